// SPDX-License-Identifier: Apache-2.0
// A scene as a list of named numbers: what forces and pictures depend on, for a page in a browser, which has no
// reader of scene files.
#include <limits>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {
namespace {

/// Calls `visit(name, member, least, most)` for each member that counts; whole numbers and enumerations must
/// be within the limits, `validate` checks the others.
void each_member(auto& scene, auto&& visit) {
    constexpr double any = std::numeric_limits<double>::infinity(), codes = 65535;
    const auto real = [&](const std::string& name, auto& value) { visit(name, value, -any, any); };
    const auto whole = [&](const std::string& name, auto& value, double most) {
        visit(name, value, 0.0, most);
    };
    const auto range = [&](const std::string& name, auto& of) {
        real(name + ".min", of.min);
        real(name + ".max", of.max);
    };
    whole("width", scene.width, 16384);
    whole("height", scene.height, 16384);
    whole("rate.num", scene.rate.num, 1e15);
    whole("rate.den", scene.rate.den, 1e15);
    real("metres_per_unit", scene.metres_per_unit);
    real("camera.fx", scene.camera.fx);
    real("camera.fy", scene.camera.fy);
    real("camera.cx", scene.camera.cx);
    real("camera.cy", scene.camera.cy);
    auto& depth = scene.depth;
    whole("depth.kind", depth.kind, static_cast<double>(DepthCodingKind::log));
    whole("depth.semantics", depth.semantics, static_cast<double>(DepthSemantics::planar));
    whole("depth.near_is_high", depth.near_is_high, 1);
    real("depth.near", depth.near);
    real("depth.far", depth.far);
    real("depth.scale", depth.scale);
    real("depth.shift", depth.shift);
    whole("depth.code_max", depth.code_max, codes);
    whole("depth.least_sum", depth.least_sum, 765);
    whole("depth.invalid_codes", depth.invalid_code_count, DepthCoding::max_invalid_codes);
    for (std::size_t k = 0; k < depth.invalid_codes.size(); ++k)
        whole("depth.invalid_" + std::to_string(k), depth.invalid_codes[k], codes);
    whole("depth.bits", scene.depth_bits, 16);
    auto& height = scene.height_coding;
    real("height.max", height.max_height);
    whole("height.units", height.units, static_cast<double>(HeightUnits::world));
    whole("height.code_max", height.code_max, codes);
    range("haptic.stiffness", scene.haptic.stiffness);
    range("haptic.static_friction", scene.haptic.static_friction);
    range("haptic.dynamic_friction", scene.haptic.dynamic_friction);
    real("default.stiffness", scene.default_properties.stiffness);
    real("default.static_friction", scene.default_properties.static_friction);
    real("default.dynamic_friction", scene.default_properties.dynamic_friction);
    real("hole_stiffness", scene.hole_stiffness);
    whole("interpolation", scene.interpolation, static_cast<double>(FrameInterpolation::linear));
    real("device_metres_per_unit", scene.device_metres_per_unit);
}

/// NaN: an optional one that is not there.
constexpr double absent = std::numeric_limits<double>::quiet_NaN();

}  // namespace

std::vector<SceneNumber> numbers_of(const Scene& scene) {
    std::vector<SceneNumber> numbers;
    each_member(scene, [&numbers]<class T>(const std::string& name, const T& value, double, double) {
        if constexpr (std::is_same_v<T, std::optional<double>>)
            numbers.push_back({name, value.value_or(absent)});
        else
            numbers.push_back({name, static_cast<double>(value)});
    });
    for (const FilterSetting& setting : filter_settings()) {
        const DepthLength value = setting.value.of(scene.filter);
        const std::string name = std::string("filter.") + setting.name;
        numbers.push_back({name, value.constant});
        if (setting.range.is_length) numbers.push_back({name + ".quadratic", value.quadratic});
    }
    return numbers;
}

Result<Scene> scene_of_numbers(std::span<const double> numbers) {
    Scene scene;
    const std::vector<SceneNumber> expected = numbers_of(scene);
    if (numbers.size() != expected.size())
        return input_error("the scene has " + std::to_string(numbers.size()) + " numbers: must be " +
                           std::to_string(expected.size()));
    std::size_t next = 0;
    std::optional<std::string> fault;
    each_member(scene, [&]<class T>(const std::string&, T& value, double least, double most) {
        const double number = numbers[next];
        const std::string& name = expected[next++].name;
        if constexpr (std::is_same_v<T, std::optional<double>>)
            value = std::isnan(number) ? std::nullopt : std::optional(number);
        else if (number >= least && number <= most)
            value = static_cast<T>(number);
        else
            fault = fault.value_or(name + " is " + formatted("%g", number));
    });
    if (fault) return input_error("the scene's " + *fault + ", which no scene has");
    for (const FilterSetting& setting : filter_settings()) {
        DepthLength value{numbers[next++]};
        if (setting.range.is_length)
            value.quadratic = numbers[next++];
        else if (!setting.range.has(value.constant))
            return input_error("the scene's filter " + std::string(setting.name) + " is " +
                               formatted("%g", value.constant) + ": must be " + setting.range.in_words());
        setting.value.set(scene.filter, value);
    }
    derive_valid_range(scene.depth);
    TRY(validate(scene));
    return scene;
}

}  // namespace touchable
