#include "player/commands/camera_options.hpp"

#include <charconv>
#include <cmath>
#include <string_view>

#include "engine/printable.hpp"

namespace touchable {
namespace {

/// Numbers between commas; fewer where one of them is none.
std::vector<double> numbers_in(std::string_view text) {
    std::vector<double> numbers;
    while (true) {
        const std::string_view part = text.substr(0, text.find(','));
        double number = 0;
        const auto [end, failure] = std::from_chars(part.data(), part.data() + part.size(), number);
        if (failure != std::errc() || end != part.data() + part.size() || !std::isfinite(number)) return {};
        numbers.push_back(number);
        if (part.size() == text.size()) return numbers;
        text.remove_prefix(part.size() + 1);
    }
}

}  // namespace

std::vector<CLI::Option*> add_camera_options(CLI::App& sub, CameraTyped& typed) {
    auto* intrinsics = sub.add_option("--intrinsics", typed.intrinsics,
                                      "of a single depth picture, instead of a scene file: focal lengths and "
                                      "principal point, pixels; without the latter the middle")
                           ->type_name("FX,FY[,CX,CY]")
                           ->excludes("--scene");
    auto* unit = sub.add_option("--depth-unit", typed.depth_unit,
                                "metres per code of that picture, 0 of which is no depth; otherwise 0.001")
                     ->type_name("METRES")
                     ->needs(intrinsics);
    return {intrinsics, unit};
}

Result<std::optional<PictureCamera>> read_camera(const CameraTyped& typed) {
    if (!typed.intrinsics) return std::optional<PictureCamera>();
    const std::vector<double> numbers = numbers_in(*typed.intrinsics);
    const bool four = numbers.size() == 4;
    if (!four && numbers.size() != 2)
        return usage_error("--intrinsics '" + printable(*typed.intrinsics) +
                           "' will not do; right would be FX,FY or FX,FY,CX,CY in pixels, such as 525,525");
    PictureCamera camera{.fx = numbers[0], .fy = numbers[1]};
    if (four) camera.cx = numbers[2];
    if (four) camera.cy = numbers[3];
    camera.metres_per_code = typed.depth_unit.value_or(camera.metres_per_code);
    return std::optional(camera);
}

}  // namespace touchable
