#pragma once

#include <filesystem>
#include <optional>

#include "engine/import/guess/source_description.hpp"
#include "engine/result.hpp"

namespace touchable {

/// What a camera's own file says.
struct CameraFile {
    Intrinsics intrinsics;
    double baseline = 0;         ///< metres; of a stereo pair, otherwise 0
    double offset = 0;           ///< of its disparities, pixels
    double codes_per_metre = 0;  ///< of its depth; 0: not said
};

/// Intrinsics as programs write them: JSON of RealSense (fx, ppx), Open3D (intrinsic_matrix), Record3D and
/// ROS (K); YAML of ROS (camera_matrix); COLMAP's cameras.txt; Middlebury's calib.txt; ARKitScenes' .pincam;
/// a matrix of 3x3 or 4x4 numbers. An error says what a file that is none of these should have.
Result<CameraFile> read_camera_file(const std::filesystem::path& file);

/// What an object of JSON, such as those files are, says of a camera.
std::optional<Intrinsics> intrinsics_in_json(const std::string& text);

/// The camera file that lies in a folder, by the names those programs give it; nothing where none does, or
/// none can be read.
std::optional<std::filesystem::path> camera_file_in(const std::filesystem::path& folder);

}  // namespace touchable
