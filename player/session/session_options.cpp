#include "player/session/session_options.hpp"

#include <cmath>

namespace touchable {

namespace {

// N s/m. Beyond this a hand on a light device no longer slows down within a tick, it is thrown back.
constexpr double most_damping = 100;

constexpr GuardNames option_names{.max_force = "--max-force",
                                  .max_stiffness = "--max-stiffness",
                                  .rise = "--stiffness-slew",
                                  .damping = "--damping",
                                  .passivity = "--passivity"};

/// A camera takes its frames in real time, one after another.
Result<void> check_camera(const SessionOptions& options) {
    if (!options.camera) return {};
    if (!options.live) return usage_error("--camera needs --live: a camera's frames come in real time");
    if (!options.playback.empty())
        return usage_error("--start, --rate, --loop and --play are for a clip; a camera's time only goes on");
    if (options.clip.interpolation == FrameInterpolation::linear)
        return usage_error(
            "--interpolation linear needs the frame after, which a camera has not taken yet; "
            "leave it out with --camera");
    return {};
}

}  // namespace

Result<void> check_guard(const GuardSettings& guard) {
    if (auto valid = validate(guard, option_names); !valid.ok()) return valid;
    if (guard.damping > most_damping) return usage_error("--damping must be 0 to 100 N s/m");
    if (guard.passivity > most_damping) return usage_error("--passivity must be 0 to 100 N s/m");
    return {};
}

Result<void> validate(const SessionOptions& options) {
    if (auto checked = check_guard(options.guard); !checked.ok()) return checked;
    if (!(options.stribeck_speed >= 0 && std::isfinite(options.stribeck_speed)))
        return usage_error("--stribeck must be a number of m/s, 0 or above");
    if (options.start_buried && !options.live)
        return usage_error("--start-buried needs --live: without it no finger waits to be free");
    if (options.device && !options.live)
        return usage_error("--device needs --live: a device is held in real time");
    if (options.held_device && (!options.live || options.device))
        return usage_error(
            "a device that a person holds is touched with in real time, and without another that a hand "
            "holds: "
            "leave out --device");
    if (options.control && options.hand != SessionOptions{}.hand)
        return usage_error("--hand " + options.hand +
                           ": the hand that holds the device is yours; leave one of them out");
    return check_camera(options);
}

}  // namespace touchable
