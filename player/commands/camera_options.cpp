#include "player/commands/camera_options.hpp"

#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/formats/camera_file.hpp"
#include "engine/formats/presets.hpp"
#include "player/commands/number_option.hpp"

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

/// Pixels are nearly as high as wide: other focal lengths come of a comma in place of a point.
Result<std::optional<SourceDescription>> with_likely_pixels(SourceDescription known,
                                                            const std::string& typed) {
    constexpr double most = 2;
    const double fx = known.intrinsics->fx, fy = std::abs(known.intrinsics->fy);
    if (fx <= most * fy && fy <= most * fx) return std::optional(std::move(known));
    std::string message = "--intrinsics '" + printable(typed);
    message += "': fx is ";
    message += short_number(fx);
    message += " and fy " + short_number(fy);
    return usage_error(
        message +
        ", one more than twice the other, as of no camera; right would be FX,FY or FX,FY,CX,CY "
        "in pixels, with a decimal point, such as 525.5,525.5");
}

}  // namespace

std::vector<CLI::Option*> add_camera_options(CLI::App& sub, CameraTyped& typed) {
    std::string names;
    for (const Preset& preset : all_presets())
        names += (names.empty() ? "" : ", ") + std::string(preset.name);
    auto* intrinsics = sub.add_option("--intrinsics", typed.intrinsics,
                                      "of pictures without a scene file: focal lengths and principal point, "
                                      "pixels, or a file of the camera that has them (JSON, YAML, calib.txt)")
                           ->type_name("FX,FY[,CX,CY]|FILE");
    auto* fov = add_number_option(sub, "--fov", typed.fov,
                                  "likewise: degrees that are seen from left to right", 1, 179)
                    ->type_name("DEGREES")
                    ->excludes(intrinsics);
    auto* unit = add_number_option(sub, "--depth-unit", typed.depth_unit,
                                   "likewise: metres that a stored 1 stands for", 1e-9, 1e6)
                     ->type_name("METRES");
    auto* preset = sub.add_option("--preset", typed.preset,
                                  "likewise, what is known of " + names +
                                      "; of videos also that depth is hue, or the mean of colours")
                       ->type_name("NAME");
    std::vector<CLI::Option*> options{intrinsics, fov, unit, preset};
    if (CLI::Option* const scene = sub.get_option_no_throw("--scene"))
        for (CLI::Option* option : options) option->excludes(scene);
    return options;
}

Result<std::optional<SourceDescription>> read_camera(const CameraTyped& typed) {
    if (!typed.intrinsics && !typed.fov && !typed.depth_unit && !typed.preset && !typed.least_confidence)
        return std::optional<SourceDescription>();
    SourceDescription known;
    known.fov = typed.fov;
    known.metres_per_code = typed.depth_unit;
    known.preset = typed.preset.value_or("");
    known.least_confidence = typed.least_confidence;
    if (!typed.intrinsics) return std::optional(known);
    const std::vector<double> numbers = numbers_in(*typed.intrinsics);
    if (numbers.size() == 2 || numbers.size() == 4) {
        known.intrinsics = Intrinsics{.fx = numbers[0], .fy = numbers[1]};
        if (numbers.size() == 4) known.intrinsics->cx = numbers[2];
        if (numbers.size() == 4) known.intrinsics->cy = numbers[3];
        return with_likely_pixels(std::move(known), *typed.intrinsics);
    }
    std::error_code ignored;
    if (numbers.empty() && typed.intrinsics->find_first_of("./") != std::string::npos &&
        !std::filesystem::exists(*typed.intrinsics, ignored))
        return input_error(printable(*typed.intrinsics) + ": does not exist: must be a file of the camera");
    if (!std::filesystem::exists(*typed.intrinsics, ignored))
        return usage_error(
            "--intrinsics '" + printable(*typed.intrinsics) +
            "' will not do; right would be FX,FY or FX,FY,CX,CY in pixels, such as 525,525, or a file "
            "of the camera");
    TRY_ASSIGN(const auto file, read_camera_file(*typed.intrinsics));
    known.intrinsics = file.intrinsics;
    known.file = *typed.intrinsics;
    return with_likely_pixels(std::move(known), *typed.intrinsics);
}

}  // namespace touchable
