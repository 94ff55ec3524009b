#include "engine/formats/unregistered_colour.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "engine/base/given_file.hpp"
#include "engine/formats/camera_file.hpp"
#include "engine/formats/known_camera.hpp"
#include "engine/formats/picture_groups.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

/// By their names.
std::vector<fs::path> texts_of_colour(const fs::path& folder) {
    constexpr std::size_t most = 1000;
    std::vector<fs::path> files;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored))
        if (has_word(entry.path().extension().string(), {".txt", ".json", ".yaml", ".yml"}) &&
            has_word(entry.path().stem().string(), {"color", "colour", "rgb"}) && files.size() < most)
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

/// Of three or four rows; nothing where it is none, or moves nothing.
std::optional<CameraPose> movement_of(const fs::path& file) {
    constexpr std::size_t longest = 1 << 12;
    auto text = read_given_file(file, file.string(), "a matrix", longest);
    if (!text) return {};
    std::istringstream words(std::move(*text));
    std::vector<double> numbers;
    for (double number = 0; words >> number;) numbers.push_back(number);
    if (!words.eof() || (numbers.size() != 12 && numbers.size() != 16)) return {};
    CameraPose pose;
    bool moves = false;
    for (std::size_t k = 0; k < 12; ++k) {
        moves = moves || std::abs(numbers[k] - (k % 5 == 0 ? 1 : 0)) > 1e-6;
        (k % 4 == 3 ? pose.translation[k / 4] : pose.rotation[k / 4 * 3 + k % 4]) = numbers[k];
    }
    return moves ? std::optional(pose) : std::nullopt;
}

/// Of pictures of this size, unless it says another.
Intrinsics sized(Intrinsics camera, int width, int height) {
    if (camera.width <= 0 || camera.height <= 0) camera.width = width, camera.height = height;
    return camera;
}

/// Whether a pixel is elsewhere by more than two hundredths of the picture.
bool differs(const Camera& a, const Camera& b, const Scene& scene) {
    constexpr double share = 0.02;
    return std::abs(a.fx - b.fx) > share * b.fx || std::abs(a.fy - b.fy) > share * b.fy ||
           std::abs(a.cx - b.cx) > share * scene.width || std::abs(a.cy - b.cy) > share * scene.height;
}

}  // namespace

std::optional<fs::path> colour_movement_in(const fs::path& folder) {
    for (const fs::path& file : texts_of_colour(folder))
        if (has_word(file.stem().string(), {"depth", "extrinsic"}) && movement_of(file)) return file;
    return {};
}

std::optional<VispColourCamera> visp_colour_camera(const fs::path& movement, const fs::path& camera_of_depth,
                                                   int width, int height) {
    const std::string stem = camera_of_depth.stem().string(), of_depth = "_depth";
    const auto to_depth = movement_of(movement);
    if (movement.filename() != "depth_M_color.txt" || !stem.ends_with(of_depth) || !to_depth) return {};
    fs::path file = camera_of_depth;
    file.replace_filename(stem.substr(0, stem.size() - of_depth.size()) +
                          camera_of_depth.extension().string());
    auto read = read_camera_file(file);
    if (!read || read->has_distortion) return {};
    return VispColourCamera{{scaled_camera(sized(read->intrinsics, width, height), width, height),
                             width,
                             height,
                             {},
                             to_depth->inverse()},
                            file};
}

std::optional<fs::path> camera_of_colour_in(const fs::path& folder, const Scene& scene, int width,
                                            int height) {
    for (const fs::path& file : texts_of_colour(folder)) {
        if (has_word(file.stem().string(), {"depth"})) continue;
        auto read = read_camera_file(file);
        if (!read) continue;
        const Intrinsics of_colour = sized(read->intrinsics, width, height);
        if (differs(scaled_camera(of_colour, scene.width, scene.height), scene.camera, scene)) return file;
    }
    return {};
}

}  // namespace touchable
