#include "capi/clip_settings.hpp"

#include <cmath>
#include <string>
#include <utility>

namespace touchable::capi {
namespace {

Error refuse_member(const char* member, const char* right) {
    return usage_error(std::string(member) + " is out of range; right would be " + right);
}

bool is_within(double value, double least, double most) {
    return value >= least && value <= most;  // of NaN it is not
}

}  // namespace

touch_clip_settings default_clip_settings() {
    touch_clip_settings settings{};
    settings.struct_size = sizeof settings;
    settings.colour = 1;
    settings.cx_px = settings.cy_px = std::nan("");
    return settings;
}

Result<std::optional<SourceDescription>> known_of(const touch_clip_settings& settings) {
    SourceDescription known;
    constexpr double longest_px = 1e9;
    if (settings.fx_px != 0 || settings.fy_px != 0) {
        if (!(settings.fx_px > 0 && settings.fx_px <= longest_px && settings.fy_px > 0 &&
              settings.fy_px <= longest_px))
            return refuse_member("fx_px or fy_px", "above 0, or both 0");
        known.intrinsics = Intrinsics{.fx = settings.fx_px, .fy = settings.fy_px};
        const auto place = [](double px) { return std::isnan(px) ? std::nullopt : std::optional(px); };
        known.intrinsics->cx = place(settings.cx_px);
        known.intrinsics->cy = place(settings.cy_px);
        if (std::isinf(settings.cx_px) || std::isinf(settings.cy_px))
            return refuse_member("cx_px or cy_px", "pixels, or NaN for the middle");
    }
    if (settings.fov_degrees != 0) {
        if (!is_within(settings.fov_degrees, 1, 179)) return refuse_member("fov_degrees", "1 to 179");
        if (known.intrinsics)
            return usage_error("fx_px and fov_degrees are both set; right would be one of them");
        known.fov = settings.fov_degrees;
    }
    if (settings.metres_per_code != 0) {
        if (!is_within(settings.metres_per_code, 1e-9, 1e6))
            return refuse_member("metres_per_code", "1e-9 to 1e6");
        known.metres_per_code = settings.metres_per_code;
    }
    if (settings.preset) known.preset = settings.preset;
    if (known == SourceDescription{}) return std::optional<SourceDescription>();
    if (settings.scene_file)
        return usage_error(
            "scene_file is set, and something of the camera beside it; right would be one of them");
    return std::optional(std::move(known));
}

}  // namespace touchable::capi
