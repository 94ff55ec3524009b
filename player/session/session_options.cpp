#include "player/session/session_options.hpp"

#include <cmath>

#include "player/session/playback_script.hpp"

namespace touchable {

namespace {

// N s/m. Beyond this a hand on a light device no longer slows down within a tick, it is thrown back.
constexpr double most_damping = 100;

/// A camera takes its frames in real time, one after another.
Result<void> check_camera(const SessionOptions& options) {
    if (!options.camera) return {};
    if (!options.live)
        return usage_error("camera needs a live run: its frames come in real time",
                           {{Setting::camera}, {Setting::live}});
    if (!options.playback.empty())
        return usage_error(
            "a camera's time only goes on: another start or rate, a loop or other commands are for a clip",
            settings_of(options.playback));
    if (options.clip.interpolation == FrameInterpolation::linear)
        return usage_error(
            "interpolation linear needs the frame after, which a camera has not taken yet; leave it out",
            {{Setting::interpolation}});
    return {};
}

}  // namespace

Result<void> check_guard(const GuardSettings& guard) {
    if (auto valid = validate(guard); !valid.ok()) return valid;
    if (guard.damping > most_damping)
        return usage_error("damping must be 0 to 100 N s/m", {{Setting::damping}});
    if (guard.passivity > most_damping)
        return usage_error("the passivity controller's damping must be 0 to 100 N s/m",
                           {{Setting::passivity}});
    return {};
}

Result<void> validate(const SessionOptions& options) {
    if (options.stale_after_ns && !options.camera)
        return usage_error("the age of a stale surface needs a live source: a clip's frames are never late",
                           {{Setting::stale_after}, {Setting::camera}});
    if (auto checked = check_guard(options.guard); !checked.ok()) return checked;
    if (!(options.stribeck_speed >= 0 && std::isfinite(options.stribeck_speed)))
        return usage_error("stribeck must be a number of m/s, 0 or above", {{Setting::stribeck}});
    if (options.recorded && options.clip.relief)
        return usage_error(
            "relief that is tried is not recorded: touchable relief CLIP OUT.mkv writes a clip that has it, "
            "and a run over that can be");
    if (options.recorded && options.clip.painted)
        return usage_error(
            "materials that are tried are not recorded: touchable materials writes a clip that has them, and "
            "a run over that can be");
    if (options.start_buried && !options.live)
        return usage_error(
            "a hand that starts buried needs a live run: in another no finger waits to be free",
            {{Setting::start_buried}, {Setting::live}});
    if (options.device && !options.live)
        return usage_error("device needs a live run: it is held in real time",
                           {{Setting::device}, {Setting::live}});
    if (options.held_device && (!options.live || options.device))
        return usage_error(
            "a device that a person holds is touched with in real time, and without another that a hand "
            "holds: leave the other out",
            {{Setting::device}});
    if (options.control && options.hand != SessionOptions{}.hand)
        return usage_error(
            "hand " + options.hand + ": the hand that holds the device is yours; leave one of them out",
            {{Setting::hand}});
    return check_camera(options);
}

}  // namespace touchable
