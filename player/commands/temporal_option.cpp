#include "player/commands/temporal_option.hpp"

#include <charconv>
#include <cmath>
#include <string_view>

namespace touchable {

std::optional<double> as_number(std::string_view text) {
    double value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::optional<DepthLength> as_depth_length(std::string_view text, char separator) {
    const std::size_t at = text.find(separator);
    const auto constant = as_number(text.substr(0, at));
    const auto quadratic = at == std::string_view::npos ? 0.0 : as_number(text.substr(at + 1));
    if (!constant || !quadratic || *constant < 0 || *quadratic < 0) return std::nullopt;
    return DepthLength{*constant, *quadratic};
}

CLI::Option* add_temporal_option(CLI::App& sub, std::optional<std::string>& typed) {
    return sub
        .add_option("--temporal", typed,
                    "average noise from frame to frame, instead of the scene's: off, on (noise as the scene "
                    "says, or as measured), or the noise of depth in scene units, C or C,Q for C + Q depth^2")
        ->type_name("WORD|C[,Q]");
}

Result<TemporalChoice> read_temporal(const std::string& typed) {
    if (typed == "off" || typed == "on") return TemporalChoice{typed == "on", std::nullopt};
    const auto noise = as_depth_length(typed, ',');
    if (!noise || *noise == DepthLength{})
        return usage_error(
            "--temporal '" + typed +
            "' will not do; right would be off, on, or the noise of depth in scene units, such as 1.5 "
            "or 1.5,0.002");
    return TemporalChoice{true, noise};
}

}  // namespace touchable
