#include "player/commands/frame_files.hpp"

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "engine/picture/image_file.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/surface/mesh.hpp"
#include "engine/surface/mesh_file.hpp"

namespace touchable {
namespace {

/// Codes as they lie in memory: two bytes each, host order.
PlaneView codes_view(const SurfaceFrame& surface) {
    return {reinterpret_cast<const std::uint8_t*>(surface.codes.data()),
            static_cast<std::ptrdiff_t>(surface.width) * 2,
            surface.width,
            surface.height,
            2,
            1};
}

Image validity_image(const SurfaceFrame& surface) {
    Image image{surface.width, surface.height, 1, 1, {}};
    image.samples.reserve(surface.codes.size());
    for (int y = 0; y < surface.height; ++y)
        for (int x = 0; x < surface.width; ++x)
            image.samples.push_back(surface.is_valid(x, y) ? std::uint8_t{255} : std::uint8_t{0});
    return image;
}

/// The scene of the pictures that are written of one frame, so that their folder is a clip again.
Scene as_still(Scene scene, const RawFrame& raw) {
    const auto name_of = [](const PlaneView& plane, const char* name) {
        return plane.empty() ? std::string() : std::string(name);
    };
    scene.video.reset();
    scene.folder = FolderSource{"depth.png",
                                name_of(raw.colour, "colour.png"),
                                name_of(raw.haptic, "haptic.png"),
                                name_of(raw.height, "height.png"),
                                0,
                                0};
    scene.stored = {};  // codes
    return scene;
}

/// What codes mean, as a scene file says it of its own depth: filters may have made them finer.
std::string codes_to_json(const SurfaceFrame& surface, Scene scene) {
    scene.depth = surface.coding;
    scene.depth_bits = 16;
    scene.folder.reset();
    scene.video.reset();
    scene.stored = {};  // codes
    const auto whole = nlohmann::ordered_json::parse(scene_to_json(scene));
    return nlohmann::ordered_json{{"depth", whole.at("depth")}}.dump(2);
}

Result<void> write_text(NewFile& file, const std::string& text) {
    if (auto usable = file.check(); !usable.ok()) return usable;
    std::ofstream out(file.path(), std::ios::binary);
    out << text;
    out.close();
    if (!out) return input_error(file.target().string() + " cannot be written; is there room on the disk?");
    return {};
}

}  // namespace

Result<void> write_frame_files(StagedFolder& folder, const RawFrame& raw, const SurfaceFrame& surface,
                               const Scene& scene, bool with_mesh) {
    const Image validity = validity_image(surface);
    const struct {
        const char* name;
        PlaneView plane;
    } pictures[] = {{"colour.png", raw.colour},         {"depth.png", raw.depth},
                    {"codes.png", codes_view(surface)}, {"valid.png", validity.view()},
                    {"haptic.png", raw.haptic},         {"height.png", raw.height}};
    for (const auto& [name, plane] : pictures) {
        if (plane.empty()) continue;
        if (auto written = write_png(folder.add(name), plane); !written.ok()) return written;
    }
    if (with_mesh) {
        if (auto written = write_ply(folder.add("mesh.ply"), make_mesh(surface, scene), raw.colour);
            !written.ok())
            return written;
    }
    if (auto written = write_text(folder.add("codes.json"), codes_to_json(surface, scene) + "\n");
        !written.ok())
        return written;
    return write_text(folder.add("scene.json"), scene_to_json(as_still(scene, raw)) + "\n");
}

}  // namespace touchable
