#include "engine/import/guess/unregistered_colour.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "engine/given_file.hpp"
#include "engine/import/guess/camera_file.hpp"
#include "engine/import/guess/known_camera.hpp"
#include "engine/import/guess/picture_groups.hpp"

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

/// Of three or four rows.
bool is_movement(const fs::path& file) {
    constexpr std::size_t longest = 1 << 12;
    auto text = read_given_file(file, file.string(), "a matrix", longest);
    if (!text) return false;
    std::istringstream words(std::move(*text));
    std::vector<double> numbers;
    for (double number = 0; words >> number;) numbers.push_back(number);
    if (!words.eof() || (numbers.size() != 12 && numbers.size() != 16)) return false;
    for (std::size_t k = 0; k < 12; ++k)
        if (std::abs(numbers[k] - (k % 5 == 0 ? 1 : 0)) > 1e-6) return true;
    return false;
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
        if (has_word(file.stem().string(), {"depth", "extrinsic"}) && is_movement(file)) return file;
    return {};
}

std::optional<fs::path> camera_of_colour_in(const fs::path& folder, const Scene& scene, int width,
                                            int height) {
    for (const fs::path& file : texts_of_colour(folder)) {
        if (has_word(file.stem().string(), {"depth"})) continue;
        auto read = read_camera_file(file);
        if (!read) continue;
        Intrinsics& of_colour = read->intrinsics;
        if (of_colour.width <= 0 || of_colour.height <= 0) of_colour.width = width, of_colour.height = height;
        if (differs(scaled_camera(of_colour, scene.width, scene.height), scene.camera, scene)) return file;
    }
    return {};
}

}  // namespace touchable
