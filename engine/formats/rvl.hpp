#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace touchable {

/// Depth as RVL packs it (Wilson, Fast lossless depth image compression, 2017), `pixels` of them; nothing
/// where the words end before, or hold more in one run than are left.
std::optional<std::vector<std::uint16_t>> unpack_rvl(std::string_view words, std::size_t pixels);

}  // namespace touchable
