#include "engine/import/bare_picture.hpp"

#include <utility>

#include "engine/import/image_folder.hpp"

namespace touchable {

Result<std::unique_ptr<ClipReader>> open_bare_picture(const std::filesystem::path& file,
                                                      SceneDescription described,
                                                      std::vector<std::string> notes, Colour colour,
                                                      std::shared_ptr<ReadPictures> pictures) {
    const std::string name = file.filename().string();
    if (!is_still(name))
        return input_error(file.string() + ": has a % or * in its name, which stand for numbers: rename it");
    Scene& scene = described.scene;
    if (!scene.folder || scene.folder->depth != name) {
        scene.folder.emplace();
        scene.folder->depth = name;
    }
    return open_image_folder(file.parent_path(), described, std::move(notes), colour, std::move(pictures));
}

}  // namespace touchable
