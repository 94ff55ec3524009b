#include "engine/formats/bare_picture.hpp"

#include <utility>

#include "engine/formats/image_folder.hpp"

namespace touchable {

Result<std::unique_ptr<ClipReader>> open_bare_picture(const std::filesystem::path& file,
                                                      SceneDescription described,
                                                      std::vector<std::string> notes, Colour colour,
                                                      std::shared_ptr<ReadPictures> pictures,
                                                      DepthAlignment alignment) {
    const std::string name = file.filename().string();
    if (!is_still(name))
        return input_error(file.string() + ": has a % or * in its name, which stand for numbers: rename it");
    Scene& scene = described.scene;
    if (!scene.folder || scene.folder->depth != name) {
        // Planes in the same files as depth are in this one.
        const FolderSource described_one = scene.folder.value_or(FolderSource());
        const auto here = [&](const std::string& pattern) {
            return !pattern.empty() && pattern == described_one.depth ? name : std::string();
        };
        scene.folder.emplace();
        scene.folder->depth = name;
        scene.folder->colour = here(described_one.colour);
        scene.folder->haptic = here(described_one.haptic);
    }
    return open_image_folder(file.parent_path(), described, std::move(notes), colour, std::move(pictures),
                             alignment);
}

}  // namespace touchable
