#include "engine/camera/plugged_camera.hpp"

#include "engine/base/try.hpp"
#include "engine/scene/scene_file.hpp"

namespace touchable {

std::string name_of(const PluggedChoice& choice) {
    if (const auto* sender = std::get_if<FramesetChoice>(&choice)) return sender->name();
    if (const auto* stream = std::get_if<StreamChoice>(&choice)) return stream->url.name();
    return std::get<V4l2Choice>(choice).node;
}

namespace {

Result<std::unique_ptr<ClipReader>> open_stream(const StreamChoice& choice,
                                                const std::optional<SourceDescription>& known,
                                                const std::optional<std::filesystem::path>& scene_file) {
    if (known && !(*known == SourceDescription()))
        return usage_error(
            choice.url.name() + ": is a stream, which has its scene in it: leave camera, unit and preset out",
            {{Setting::intrinsics}, {Setting::depth_unit}, {Setting::preset}});
    if (!scene_file) return open_live_stream(choice);
    TRY_ASSIGN(const auto described, read_scene_file(*scene_file));
    auto reader = open_live_stream(choice, described);
    if (reader) (*reader)->add_input(*scene_file);
    return reader;
}

}  // namespace

Result<std::unique_ptr<ClipReader>> open_plugged_camera(
    const PluggedChoice& choice, const std::optional<SourceDescription>& known,
    const std::optional<std::filesystem::path>& scene_file) {
    if (const auto* sender = std::get_if<FramesetChoice>(&choice))
        return open_frameset_camera(*sender, known, scene_file);
    if (const auto* stream = std::get_if<StreamChoice>(&choice))
        return open_stream(*stream, known, scene_file);
    return open_v4l2_camera(std::get<V4l2Choice>(choice), known, scene_file);
}

}  // namespace touchable
