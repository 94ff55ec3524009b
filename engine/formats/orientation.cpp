#include "engine/formats/orientation.hpp"

#include <cstring>
#include <utility>

namespace touchable {

Orientation Orientation::then(const Orientation& next) const {
    Orientation both = *this;
    if (next.transposed) {
        both.transposed = !both.transposed;
        std::swap(both.flipped_x, both.flipped_y);
    }
    both.flipped_x = both.flipped_x != next.flipped_x;
    both.flipped_y = both.flipped_y != next.flipped_y;
    return both;
}

Orientation exif_orientation(int number) {
    constexpr Orientation numbered[] = {{false, false, false}, {false, true, false}, {false, true, true},
                                        {false, false, true},  {true, false, false}, {true, true, false},
                                        {true, true, true},    {true, false, true}};
    return number >= 1 && number <= 8 ? numbered[number - 1] : Orientation{};
}

Image upright(const Image& stored, const Orientation& orientation) {
    Image image = stored;
    if (orientation == Orientation{}) return image;
    if (orientation.transposed) std::swap(image.width, image.height);
    const PlaneView from = stored.view();
    const std::ptrdiff_t pixel = static_cast<std::ptrdiff_t>(stored.channels) * stored.bytes_per_sample;
    std::uint8_t* to = image.samples.data();
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x, to += pixel) {
            int column = orientation.flipped_x ? image.width - 1 - x : x;
            int row = orientation.flipped_y ? image.height - 1 - y : y;
            if (orientation.transposed) std::swap(column, row);
            std::memcpy(to, from.row(row) + pixel * column, static_cast<std::size_t>(pixel));
        }
    }
    return image;
}

Intrinsics upright(const Intrinsics& stored, const Orientation& orientation) {
    Intrinsics turned = stored;
    if (orientation.transposed) {
        std::swap(turned.fx, turned.fy);
        std::swap(turned.cx, turned.cy);
        std::swap(turned.width, turned.height);
    }
    if (orientation.flipped_x && turned.cx) turned.cx = turned.width - 1 - *turned.cx;
    if (orientation.flipped_y && turned.cy) turned.cy = turned.height - 1 - *turned.cy;
    return turned;
}

}  // namespace touchable
