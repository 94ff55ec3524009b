#pragma once

#include <optional>

#include "engine/formats/source_description.hpp"
#include "engine/picture/image_file.hpp"

namespace touchable {

/// How a stored picture becomes upright: its columns become rows first, then left and right, and top and
/// bottom, change places.
struct Orientation {
    bool transposed = false, flipped_x = false, flipped_y = false;
    /// This one first, then `next`.
    Orientation then(const Orientation& next) const;
    bool operator==(const Orientation&) const = default;
};

/// Of EXIF's number, 1 to 8; others are as 1.
Orientation exif_orientation(int number);

Image upright(const Image& stored, const Orientation& orientation);
/// Of a camera's pictures of `width` x `height`.
Intrinsics upright(const Intrinsics& stored, const Orientation& orientation);

}  // namespace touchable
