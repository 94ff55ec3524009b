#include "engine/import/bare_picture.hpp"

#include <utility>

#include "engine/import/image_folder.hpp"
#include "engine/media/stored_image.hpp"
#include "engine/printable.hpp"

namespace touchable {
namespace {

/// N/mm. Where a camera saw nothing no wall pushes with all that a device can (docs/scene_file.md, Holes).
constexpr double soft_holes = 0.1;

Result<StoredImage> read_depth_picture(const std::filesystem::path& file) {
    auto stored = read_stored_image(file);
    if (stored && stored->image.channels != 1)
        return input_error(file.string() + ": is in colour: a picture of depth is grey");
    if (stored && !stored->values.empty())
        return input_error(file.string() + ": is a picture of floats: must be of integers");
    return stored;
}

}  // namespace

Result<Scene> bare_picture_scene(const std::filesystem::path& file, const PictureCamera& camera) {
    const auto stored = read_depth_picture(file);
    if (!stored) return stored.error();
    const Image& image = stored->image;
    Scene scene;
    scene.name = file.stem().string();
    scene.width = image.width;
    scene.height = image.height;
    scene.metres_per_unit = 1;
    scene.camera = {camera.fx, camera.fy, camera.cx.value_or(0.5 * (image.width - 1)),
                    camera.cy.value_or(0.5 * (image.height - 1))};
    scene.depth_bits = 8 * image.bytes_per_sample;
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = camera.metres_per_code;
    scene.depth.code_max = image.bytes_per_sample == 1 ? 255 : 65535;
    scene.depth.far = scene.depth.scale * scene.depth.code_max;
    scene.depth.invalid_code_count = 1;  // 0
    scene.far_from_frames = true;
    scene.unstated = all_unstated;
    scene.hole_stiffness = soft_holes;
    derive_valid_range(scene.depth);
    if (auto valid = validate(scene); !valid)
        return usage_error("--intrinsics, --depth-unit: " + valid.error().message);
    return scene;
}

Result<std::unique_ptr<ClipReader>> open_bare_picture(const std::filesystem::path& file, Scene scene) {
    const std::string name = file.filename().string();
    if (!is_still(name))
        return input_error(file.string() + ": has a % in its name, which stands for numbers: rename it");
    if (!scene.folder || scene.folder->depth != name) {
        scene.folder.emplace();
        scene.folder->depth = name;
    }
    return open_image_folder(file.parent_path(), scene);
}

Error no_description(const std::filesystem::path& file) {
    const auto stored = read_depth_picture(file);
    if (!stored) return stored.error();
    const Image& image = stored->image;
    const auto middle = [](int side) { return std::to_string((side - 1) / 2) + (side % 2 == 0 ? ".5" : ""); };
    const std::string width = std::to_string(image.width), height = std::to_string(image.height);
    const std::string example = R"({"touchable_scene": 1, "width": )" + width + R"(, "height": )" + height +
                                R"(, "metres_per_unit": 1, "camera": {"fx": )" + width + R"(, "fy": )" +
                                width + R"(, "cx": )" + middle(image.width) + R"(, "cy": )" +
                                middle(image.height) +
                                R"(}, "depth": {"coding": "metric", "scale": 0.001, "bits": )" +
                                std::to_string(8 * image.bytes_per_sample) +
                                R"(, "invalid": [0]}, "hole_stiffness": 0.1, "folder": {"depth": )" +
                                in_quotes(file.filename().string()) + "}}";
    return input_error(
        file.string() +
        ": is a picture without a scene file: give --intrinsics FX,FY (focal lengths, pixels) and "
        "--depth-unit METRES, or --scene FILE, such as: " +
        example);
}

}  // namespace touchable
