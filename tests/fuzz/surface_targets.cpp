// Maps of touch in the files of other programs.
#include "engine/import/touch_maps/still_maps.hpp"
#include "engine/scene/scene_file.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

bool is_haptic_map(const std::filesystem::path& file) {
    Scene scene = parse_scene(R"({"touchable_scene": 1, "width": 8, "height": 6,
        "camera": {"fx": 9, "fy": 9, "cx": 3, "cy": 2}, "depth": {"coding": "linear", "near": 1, "far": 2}})",
                              "scene.json")
                      ->scene;
    const auto map = read_haptic_map(file, scene);
    if (!is_taken(map)) return false;
    const PlaneView& view = map->plane.view;
    require(view.width > 0 && view.height > 0 && view.bytes_per_sample == 1, "a map is no picture");
    (void)view.sample(view.width - 1, view.height - 1, view.channels - 1);
    for (const std::string& note : map->notes) require(!note.empty(), "a note says nothing");
    return true;
}

bool parse_x3d(std::string_view bytes) {
    return is_haptic_map(file_of(bytes, "surface.x3d"));
}
bool parse_gltf(std::string_view bytes) {
    return is_haptic_map(file_of(bytes, "material.gltf"));
}

const Registered x3d_target{{.name = "x3d", .parse = parse_x3d}};
const Registered gltf_target{{.name = "gltf", .parse = parse_gltf}};

}  // namespace
}  // namespace touchable::fuzz
