#pragma once

#include <algorithm>
#include <cstdint>

#include "engine/gpu/gpu_commands.hpp"

namespace touchable {

/// At least `count` workgroups, in rows short enough for every device; a kernel numbers them row by row.
inline GpuGroups groups_in_rows(std::uint32_t count) {
    constexpr std::uint32_t row = 32768;
    return {std::min(count, row), groups_for(count, row), 1};
}

}  // namespace touchable
