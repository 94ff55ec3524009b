#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/formats/camera_text.hpp"

namespace touchable {

/// Where pictures of depth are whose camera is sought.
struct PicturesOfCamera {
    std::filesystem::path folder{};  ///< of the clip
    std::filesystem::path within{};  ///< that of depth's pictures, from there; empty: the same
    int width = 0, height = 0;
    /// Whose camera a file may be whatever its name is: those of the whole folder, or one with this stem.
    bool is_whole_folder = false;
    std::string stem{};
};

/// What files beside pictures say of their camera.
struct CameraBeside {
    std::optional<CameraFile> camera;  ///< of pictures of this size, or of any
    std::filesystem::path file{};      ///< that has it
    std::string doubt{};               ///< how it was taken otherwise than the file says; empty: as it says
    double frames_per_second = 0;      ///< 0: none of them says it
    std::filesystem::path rate_file{};
    std::vector<std::string> not_understood{};  ///< names of files that call themselves a camera's
};

/// Of files in the folder, in depth's, in sparse/0 (COLMAP), and, where none of these has one, in the folder
/// above. Of several cameras that of a file which calls itself a camera's, of depth, of pictures of this
/// size, without a lens's distortion, the first by its name.
CameraBeside camera_beside(const PicturesOfCamera& pictures);

/// The same camera for pictures of this size, where what its file says of sizes cannot be: the principal
/// point is near the middle of a picture, and tells of which. `doubt`: what was changed.
Intrinsics trusted_intrinsics(Intrinsics camera, int width, int height, std::string& doubt);

}  // namespace touchable
