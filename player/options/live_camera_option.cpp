#include "player/options/live_camera_option.hpp"

#include "player/session/camera_words.hpp"

namespace touchable {

CLI::Option* add_live_camera_option(CLI::App& sub, SessionOptions& session) {
    return sub.add_option(
        "--camera", session.camera,
        "live, in place of CLIP: v4l2:/dev/videoN[,key=value,...], a camera that is plugged in; pipe:CMD or "
        "tcp://HOST:PORT, a program that sends framesets; or replay:PATH[,key=value,...], a recording that "
        "behaves like one (docs/camera.md)");
}

Result<void> read_live_camera(bool has_clip, SessionOptions& session) {
    if (!session.camera) return {};
    if (has_clip) return usage_error("CLIP and --camera are two things to touch; leave one of them out");
    const auto camera = read_live_camera(*session.camera);
    if (!camera.ok()) return camera.error();
    session.clip.take(*camera);
    return {};
}

}  // namespace touchable
