#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/formats/source_description.hpp"

namespace touchable {

/// A camera as a file says it.
struct CameraFile {
    Intrinsics intrinsics;
    double baseline = 0;          ///< metres; of a stereo pair, otherwise 0
    double offset = 0;            ///< of its disparities, pixels
    double codes_per_metre = 0;   ///< of its depth; 0: not said
    bool has_distortion = false;  ///< by its lens, which nothing here undoes
    std::string name{};           ///< its members, its own name, its topic
    bool operator==(const CameraFile&) const = default;
};

/// What a text says of cameras.
struct CameraText {
    std::vector<CameraFile> cameras;  ///< in the order of the text, at most 64
    double frames_per_second = 0;     ///< 0: not said
};

/// Of any text that `read_camera_file` takes. No camera: it is none of these.
CameraText cameras_in_text(std::string_view text);

}  // namespace touchable
