#include "engine/camera/plugged_camera.hpp"

namespace touchable {

std::string name_of(const PluggedChoice& choice) {
    if (const auto* sender = std::get_if<FramesetChoice>(&choice)) return sender->name();
    return std::get<V4l2Choice>(choice).node;
}

Result<std::unique_ptr<ClipReader>> open_plugged_camera(
    const PluggedChoice& choice, const std::optional<SourceDescription>& known,
    const std::optional<std::filesystem::path>& scene_file) {
    if (const auto* sender = std::get_if<FramesetChoice>(&choice))
        return open_frameset_camera(*sender, known, scene_file);
    return open_v4l2_camera(std::get<V4l2Choice>(choice), known, scene_file);
}

}  // namespace touchable
