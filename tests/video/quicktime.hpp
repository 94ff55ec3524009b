#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"

namespace touchable::test {

enum class QuicktimeCodec {
    png,  ///< without loss
    hap   ///< four by four pixels of two colours and what is between them, as Depthkit writes
};

/// Writes 8-bit RGB pictures as a QuickTime file. `time_of` gives each frame's time in units of 1/rate.num
/// seconds; its number times rate.den where evenly spaced.
void write_quicktime(const std::filesystem::path& file, const std::vector<Image>& pictures,
                     const FrameRate& rate, const std::function<std::int64_t(int)>& time_of = {},
                     QuicktimeCodec codec = QuicktimeCodec::png);

}  // namespace touchable::test
