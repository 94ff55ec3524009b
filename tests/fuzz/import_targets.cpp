// What lies beside pictures: descriptions of cameras, lists, and names.
#include <array>
#include <cmath>
#include <fstream>

#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/scene/scene.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

void require_lens(const Intrinsics& lens) {
    require(std::isfinite(lens.fx) && std::isfinite(lens.fy), "a focal length is not finite");
    require(std::isfinite(lens.cx.value_or(0)) && std::isfinite(lens.cy.value_or(0)),
            "a principal point is not finite");
    require(lens.width >= 0 && lens.height >= 0, "a picture has a size below 0");
}

bool parse_camera_file(std::string_view bytes) {
    if (const auto found = intrinsics_in_json(std::string(bytes))) require_lens(*found);
    const auto camera = read_camera_file(file_of(bytes, "camera.txt"));
    if (!is_taken(camera)) return false;
    require_lens(camera->intrinsics);
    const Camera scaled = scaled_camera(camera->intrinsics, 64, 48);
    require(scaled.fx > 0 && scaled.fy > 0, "a focal length is not above 0");
    require(std::isfinite(camera->baseline) && std::isfinite(camera->offset) &&
                std::isfinite(camera->codes_per_metre) && camera->codes_per_metre >= 0,
            "a camera's number is not finite");
    return true;
}

bool parse_depthkit(std::string_view bytes) {
    const auto scene = read_depthkit_metadata(file_of(bytes, "clip.Metadata.asset"));
    if (!is_taken(scene)) return false;
    require(bool(validate(*scene)), "a scene cannot be");
    return true;
}

/// The video beside a description that is right.
bool parse_depthkit_video(std::string_view bytes) {
    static const std::filesystem::path description = [] {
        Target seeds{.name = "depthkit", .parse = nullptr};
        return file_of(seeds_of(seeds).front().bytes, "depthkit.Metadata.asset");
    }();
    const auto video = file_of(bytes, "depthkit.mov");
    require(depthkit_metadata_of(video) == description, "the description is not beside the video");
    return is_clip(open_depthkit_clip({video}));
}

/// A folder with a few pictures to be found.
const std::filesystem::path& folder_of_pictures() {
    static const std::filesystem::path folder = [] {
        const auto made = file_of("", "here").parent_path() / "pictures";
        std::filesystem::create_directories(made / "depth");
        for (const char* name : {"a1.png", "a2.png", "a10.png", "depth/1.500.png", "depth/2.png"})
            std::ofstream(made / name) << 'x';
        return made;
    }();
    return folder;
}

void require_places(const PictureFiles& pictures) {
    require(pictures.keys.empty() || pictures.keys.size() == pictures.files.size(),
            "keys are not the files'");
    for (const double key : pictures.keys) require(std::isfinite(key), "a time is not finite");
    const auto rate = rate_of(pictures);
    require(!rate || (rate->num > 0 && rate->den > 0), "a rate is not above 0");
}

bool parse_list(std::string_view bytes) {
    std::ofstream(folder_of_pictures() / "depth.txt", std::ios::binary) << bytes;
    FolderSource source;
    source.depth = "depth.txt";
    source.colour = "a*.png";
    const auto pictures = depth_files(folder_of_pictures(), source);
    if (!is_taken(pictures)) return false;
    require_places(*pictures);
    const auto beside = files_beside(folder_of_pictures(), PlaneRole::colour, source, *pictures);
    if (is_taken(beside)) require(beside->count() == pictures->count(), "not a file for each");
    return true;
}

/// The pattern of depth, that of colour, and the first number.
bool parse_pattern(std::string_view bytes) {
    Taken taken(bytes);
    FolderSource source;
    source.first = static_cast<int>(taken.byte());
    source.count = static_cast<int>(taken.byte());
    source.depth = taken.line();
    source.colour = taken.line();
    Scene scene = parse_scene(R"({"touchable_scene": 1, "width": 8, "height": 6,
        "camera": {"fx": 9, "fy": 9, "cx": 3, "cy": 2}, "depth": {"coding": "linear", "near": 1, "far": 2}})",
                              "scene.json")
                      ->scene;
    scene.folder = source;
    if (!is_taken(validate(scene))) return false;
    // Folders of others may be large, or their names devices.
    if (source.depth.find('/') != std::string::npos || source.colour.find('/') != std::string::npos)
        return false;
    const auto pictures = depth_files(folder_of_pictures(), source);
    if (!is_taken(pictures)) return false;
    require_places(*pictures);
    if (!source.colour.empty())
        (void)is_taken(files_beside(folder_of_pictures(), PlaneRole::colour, source, *pictures));
    return true;
}

const Registered camera_file_target{{.name = "camera_file", .parse = parse_camera_file}};
const Registered depthkit_target{{.name = "depthkit", .parse = parse_depthkit}};
const Registered depthkit_video_target{{.name = "depthkit_video",
                                        .parse = parse_depthkit_video,
                                        .cuts_are_refused = true,
                                        .changes = 60,
                                        .most_mebibytes = 2048,
                                        .most_live_mebibytes = 2048}};
const Registered list_target{{.name = "picture_list", .parse = parse_list, .most_bytes = 1024}};
const Registered pattern_target{{.name = "picture_pattern", .parse = parse_pattern, .most_bytes = 128}};

}  // namespace
}  // namespace touchable::fuzz
