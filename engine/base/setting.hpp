#pragma once

#include <string>
#include <vector>

namespace touchable {

/// What a person can set of what is opened, touched, shown or written. Messages speak of it in plain words; a
/// program that lets people set it knows what they write for it: an option, a row of a panel, a parameter.
enum class Setting {
    builder,
    camera,
    clip,
    damping,
    depth_unit,
    device,
    device_rules,
    field_of_view,
    fingers,
    forces,
    gpu,
    hand,
    haptic_map,
    headless,
    height_map,
    interpolation,
    intrinsics,
    live,
    loop,
    max_force,
    max_stiffness,
    painter,
    passivity,
    playback,
    preset,
    rate,
    record,
    scene_file,
    script,
    seconds,
    stale_after,
    start,
    start_buried,
    stiffness_rise,
    stribeck,
    temporal,
    view
};
inline constexpr int setting_count = static_cast<int>(Setting::view) + 1;

/// A setting that a message is about, or that would help, and the value that would be right.
struct Hint {
    Setting setting;
    std::string value{};  ///< empty: any, or what the message says
};
using Hints = std::vector<Hint>;

}  // namespace touchable
