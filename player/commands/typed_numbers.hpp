#pragma once

#include <charconv>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "engine/base/result.hpp"
#include "engine/scene/frame_rate.hpp"

namespace touchable {

/// A whole number as typed after `option`; refused (ErrorKind::usage) where it is none, or out of range. What
/// is too large for its type is refused as well, not cut down to it.
template <class Whole>
Result<Whole> read_whole_number(const std::string& option, std::string_view text, Whole least, Whole most) {
    Whole value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure == std::errc() && end == text.data() + text.size() && value >= least && value <= most)
        return value;
    std::string message = (option.empty() ? "'" : option + " '").append(text);
    message += "' will not do; right would be a whole number";
    if (least != std::numeric_limits<Whole>::min() || most != std::numeric_limits<Whole>::max())
        message += ", " + std::to_string(least) + " to " + std::to_string(most);
    return usage_error(std::move(message));
}

/// A finite number as typed after `option`; refused (ErrorKind::usage) where it is none, or out of range.
Result<double> read_number(const std::string& option, std::string_view text, double least, double most);

/// Frames per second as typed after `option`, exactly: "25", "29.97" (2997/100), "30000/1001"; 0.001 to 1000.
Result<FrameRate> read_frame_rate(const std::string& option, std::string_view text);

struct PixelSize {
    int width = 0, height = 0;
};
/// "720x480" as typed after `option`, each side `least` to `most` pixels.
Result<PixelSize> read_pixel_size(const std::string& option, std::string_view text, int least, int most);

}  // namespace touchable
