#include "engine/formats/camera_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "engine/base/given_file.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

/// Record3D's metadata has a pose for each frame.
constexpr std::size_t longest_camera_file = std::size_t{16} << 20;

/// Whether the principal point is in the picture, or no farther beside it than half of it.
bool is_near_picture(const Intrinsics& camera) {
    const auto fits = [](const std::optional<double>& at, int side) {
        return !at || side <= 0 || (*at > -0.5 * side && *at < 1.5 * side);
    };
    return fits(camera.cx, camera.width) && fits(camera.cy, camera.height);
}

bool has_focal_lengths(const Intrinsics& camera) {
    const auto is_length = [](double value) { return std::isfinite(value) && value > 0 && value < 1e6; };
    return is_length(camera.fx) && is_length(camera.fy);
}

}  // namespace

Result<CameraText> read_camera_text(const std::filesystem::path& file) {
    TRY_ASSIGN(auto given, read_given_file(file, file.string(), "a camera's file", longest_camera_file));
    std::string& text = given;
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);  // a mark that says UTF-8
    CameraText said = cameras_in_text(text);
    bool is_any_far = false;
    std::erase_if(said.cameras, [&](CameraFile& camera) {
        camera.intrinsics.fy = std::abs(camera.intrinsics.fy);
        const bool is_far = !is_near_picture(camera.intrinsics);
        is_any_far |= is_far;
        return is_far || !has_focal_lengths(camera.intrinsics);
    });
    if (said.cameras.empty() && is_any_far)
        return input_error(file.string() +
                           ": its principal point is far beside its picture: must be cx, cy in "
                           "pixels, in the picture or near it");
    return said;
}

Result<CameraFile> read_camera_file(const std::filesystem::path& file) {
    TRY_ASSIGN(auto said, read_camera_text(file));
    if (!said.cameras.empty()) return std::move(said.cameras.front());
    return input_error(
        file.string() +
        ": has no camera that could be read: must have fx, fy, cx, cy or px, py, u0, v0 (JSON, YAML, XML), a "
        "matrix K, intrinsic_matrix or camera_matrix (likewise), 3x3 numbers, or be COLMAP's cameras.txt, "
        "Kalibr's camchain.yaml, Middlebury's calib.txt or ARKitScenes' .pincam (width height fx fy cx cy)");
}

std::optional<Intrinsics> intrinsics_in_json(const std::string& text) {
    const CameraText said = cameras_in_text(text);
    return said.cameras.empty() ? std::nullopt : std::optional(said.cameras.front().intrinsics);
}

}  // namespace touchable
