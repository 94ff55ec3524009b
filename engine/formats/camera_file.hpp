#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "engine/formats/camera_text.hpp"

namespace touchable {

/// What a camera's own file, of up to 16 MiB, says, as `cameras_in_text` understands it. No camera in it is
/// no error; an error says that it cannot be read, or what of the cameras in it cannot be.
Result<CameraText> read_camera_text(const std::filesystem::path& file);

/// The first camera in such a file. An error says what a file without one should have.
Result<CameraFile> read_camera_file(const std::filesystem::path& file);

/// What an object of JSON, such as those files are, says of a camera.
std::optional<Intrinsics> intrinsics_in_json(const std::string& text);

}  // namespace touchable
