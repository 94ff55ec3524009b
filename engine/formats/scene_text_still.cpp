#include "engine/formats/scene_text_still.hpp"

#include "engine/formats/image_folder_writer.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/mpeg4/scene_text.hpp"

namespace touchable {
namespace {

std::string text_of(const SceneDescription& described) {
    const Scene& scene = described.scene;
    const mpeg4::SceneTree tree =
        mpeg4::scene_of(mpeg4::nodes_of_pictures(described), scene.width, scene.height);
    return "# The text of an MPEG-4 scene; touchable play opens it\n" + mpeg4::scene_text(tree);
}

}  // namespace

Result<std::unique_ptr<ClipWriter>> create_scene_text(const std::filesystem::path& text,
                                                      const SceneDescription& described, Existing existing) {
    if (text.filename().string().starts_with("od:"))  // as texts name objects of an MP4 file
        return usage_error(text.string() + ": must not begin with od:, which names tracks in a scene's text");
    return create_described_still(text, described, existing, text_of);
}

}  // namespace touchable
