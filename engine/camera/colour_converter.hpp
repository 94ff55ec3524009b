#pragma once

#include <string>

#include "engine/base/result.hpp"
#include "engine/camera/v4l2_stream.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/picture/rgb_converter.hpp"

namespace touchable {

/// Makes RGB of a camera's pictures of colour. Keeps what it has set up.
class ColourConverter {
public:
    /// Of 8 bits, in the picture's own size. An error, without the camera's name, where a coded picture is
    /// damaged.
    Result<Plane> rgb(const TakenPicture& picture, const StreamFormat& format);

private:
    RgbConverter converter_;
};

}  // namespace touchable
