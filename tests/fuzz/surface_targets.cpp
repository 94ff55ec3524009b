// Maps of touch in the files of other programs, and clips as glTF scenes.
#include "engine/formats/formats_read.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/formats/touch_maps.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
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

/// Beside a picture of depth and one of touch, and a clip in MP4.
bool parse_gltf_clip(std::string_view bytes) {
    static const bool is_ready = [] {
        constexpr int side = 16;  // as the clip's
        const std::vector<std::uint8_t> samples(std::size_t{side} * side * 3, 200);
        const auto put = [&](const char* name, int channels) {
            const PlaneView plane{samples.data(), std::ptrdiff_t{side} * channels, side, side, 1, channels};
            return bool(write_png(file_of("", name), plane));
        };
        const Target seeds{.name = "mp4_clip", .parse = nullptr};
        file_of(seeds_of(seeds).front().bytes, "planes.mp4");
        return put("depth.png", 1) && put("touch.png", 3);
    }();
    require(is_ready, "the files beside it cannot be written");
    return is_clip(open_gltf_clip({file_of(bytes, "clip.gltf")}));
}

const Registered x3d_target{{.name = "x3d", .parse = parse_x3d}};
const Registered gltf_target{{.name = "gltf", .parse = parse_gltf}};
const Registered gltf_clip_target{{.name = "gltf_clip",
                                   .parse = parse_gltf_clip,
                                   .cuts_are_refused = true,
                                   .needless_bytes = 1,
                                   .most_mebibytes = 2048,
                                   .most_live_mebibytes = 2048}};

}  // namespace
}  // namespace touchable::fuzz
