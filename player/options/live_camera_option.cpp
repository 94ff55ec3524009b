#include "player/options/live_camera_option.hpp"

#include <cmath>

#include "player/options/number_option.hpp"
#include "player/session/camera_words.hpp"

namespace touchable {

CLI::Option* add_live_camera_option(CLI::App& sub, SessionOptions& session) {
    return sub.add_option(
        "--camera", session.camera,
        "live, in place of CLIP: v4l2:/dev/videoN[,key=value,...], a camera that is plugged in; pipe:CMD or "
        "tcp://HOST:PORT, a program that sends framesets; or replay:PATH[,key=value,...], a recording that "
        "behaves like one (docs/camera.md)");
}

CLI::Option* add_stale_after_option(CLI::App& sub, std::optional<double>& milliseconds) {
    return add_number_option(
        sub, "--stale-after", milliseconds,
        "ms: a live surface whose newest frame is older is not felt any more, until a "
        "newer one comes; 0: it stays as it is (otherwise 250 of a stream, 0 of a camera)",
        0, 3'600'000);
}

Result<void> read_live_camera(bool has_clip, const std::optional<double>& stale_after_ms,
                              SessionOptions& session) {
    if (stale_after_ms) session.stale_after_ns = std::llround(*stale_after_ms * 1e6);
    if (!session.camera) return {};
    if (has_clip) return usage_error("CLIP and --camera are two things to touch; leave one of them out");
    const auto camera = read_live_camera(*session.camera);
    if (!camera.ok()) return camera.error();
    session.clip.take(*camera);
    return {};
}

}  // namespace touchable
