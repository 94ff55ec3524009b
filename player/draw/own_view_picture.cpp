#include "player/draw/own_view_picture.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "engine/base/vectors.hpp"
#include "player/draw/view_rows.hpp"
#include "shaders/raster.h"

// Compiled without errno and traps: the loop over a row's pixels becomes vectors by itself.

namespace touchable {
namespace {

/// What a row of pixels is made of.
struct PixelRow {
    const PackedColour *upper_left, *upper_right, *lower_left, *lower_right;
    const float *upper_left_q, *upper_right_q, *lower_left_q, *lower_right_q;
    const float* into;  ///< the cell, from the left
    float down;         ///< likewise from above
    float z_per_q;
    PackedColour background;
};

// Selects by masks, all bits or none: a `?:` between what is read here would become a branch, and no vectors.
[[gnu::always_inline]] inline std::int32_t mask_of(bool is_so) {
    return -static_cast<std::int32_t>(is_so);
}
[[gnu::always_inline]] inline std::uint32_t chosen(std::int32_t mask, std::uint32_t value,
                                                   std::uint32_t other) {
    return other ^ (static_cast<std::uint32_t>(mask) & (value ^ other));
}
[[gnu::always_inline]] inline float chosen(std::int32_t mask, float value, float other) {
    return std::bit_cast<float>(
        chosen(mask, std::bit_cast<std::uint32_t>(value), std::bit_cast<std::uint32_t>(other)));
}

/// A channel of a mixed colour, rounded.
[[gnu::always_inline]] inline std::uint32_t channel_of(PackedColour a, PackedColour other, PackedColour c,
                                                       float of_other, float of_c, int shift) {
    const auto at = static_cast<float>(static_cast<int>(a >> shift & 255U));
    const auto to_other = static_cast<float>(static_cast<int>(other >> shift & 255U)) - at;
    const auto to_c = static_cast<float>(static_cast<int>(c >> shift & 255U)) - at;
    const float mixed = at + of_other * to_other + of_c * to_c;
    return static_cast<std::uint32_t>(static_cast<int>(mixed + 0.5F)) << shift;
}

/// With the arithmetic of raster.comp. A cell's diagonal is from its upper left corner to its lower right.
[[gnu::always_inline]] inline void draw_row(const PixelRow& row, int pixels, PackedColour* __restrict colours,
                                            float* __restrict z) {
    const PixelRow from = row;
    const float down = from.down;
    for (int x = 0; x < pixels; ++x) {
        const float into = from.into[x];
        const std::int32_t is_right = mask_of(into >= down);
        const float right_of = into - down;
        const float of_other = chosen(is_right, right_of, -right_of), of_c = chosen(is_right, down, into);
        const float a_q = from.upper_left_q[x], c_q = from.lower_right_q[x];
        const float other_q = chosen(is_right, from.upper_right_q[x], from.lower_left_q[x]);
        const PackedColour a = from.upper_left[x], c = from.lower_right[x];
        const PackedColour other = chosen(is_right, from.upper_right[x], from.lower_left[x]);
        const PackedColour colour = channel_of(a, other, c, of_other, of_c, 0) |
                                    channel_of(a, other, c, of_other, of_c, 8) |
                                    channel_of(a, other, c, of_other, of_c, 16) | 0xff000000U;
        const float nearness = (a_q + of_other * (other_q - a_q) + of_c * (c_q - a_q)) * from.z_per_q;
        // Without a branch: not `triangle_has_hole`, nor before the near plane.
        const std::int32_t is_drawn =
            mask_of(a_q > 0.0F) & mask_of(other_q > 0.0F) & mask_of(c_q > 0.0F) & mask_of(nearness <= 1.0F);
        colours[x] = chosen(is_drawn, colour, from.background);
        z[x] = chosen(is_drawn, nearness, 0.0F);
    }
}

}  // namespace

/// Of vertices that lie where `subpixels_of(n)` says, ascending.
template <class SubpixelsOf>
void OwnViewPicture::find_places(int vertices, int pixels, SubpixelsOf subpixels_of, Places& places) {
    constexpr int half_pixel = VIEW_SUBPIXELS / 2;
    places.cells.resize(static_cast<std::size_t>(pixels));
    places.into.resize(static_cast<std::size_t>(pixels));
    // A pixel whose centre is on the cell's first side is the cell's.
    const auto pixel_from = [pixels](int subpixels) {
        return std::clamp((subpixels + half_pixel - 1) >> 8, 0, pixels);
    };
    int from = subpixels_of(0);
    places.first = places.end = pixel_from(from);
    for (int n = 0; n + 1 < vertices; ++n) {
        const int to = subpixels_of(n + 1);
        for (const int end = pixel_from(to); places.end < end; ++places.end) {
            const auto p = static_cast<std::size_t>(places.end);
            places.cells[p] = n;
            places.into[p] = static_cast<float>(places.end * VIEW_SUBPIXELS + half_pixel - from) /
                             static_cast<float>(to - from);
        }
        from = to;
    }
}

bool OwnViewPicture::draws(const ViewCamera& camera) {
    const auto [x, y, z, w] = rows_of(camera);
    // Clip space is two units wide and high.
    constexpr float largest = 2.0F * RASTER_LARGE_CELL / VIEW_SUBPIXELS;
    return is_own_view(camera) && x.x * static_cast<float>(camera.width) < largest &&
           y.y * static_cast<float>(camera.height) < largest;
}

void OwnViewPicture::read_corners(const MappedLattice& lattice, int row, Corners& corners) const {
    const std::size_t start = static_cast<std::size_t>(row) * static_cast<std::size_t>(lattice.pitch);
    const PackedColour* colours = lattice.colours + start;
    const float* q = lattice.q + start;
    for (auto* each : {&corners.left, &corners.right}) each->resize(columns_.cells.size());
    for (auto* each : {&corners.left_q, &corners.right_q}) each->resize(columns_.cells.size());
    for (auto x = static_cast<std::size_t>(columns_.first); x < static_cast<std::size_t>(columns_.end); ++x) {
        const int cell = columns_.cells[x];
        corners.left[x] = colours[cell];
        corners.right[x] = colours[cell + 1];
        corners.left_q[x] = q[cell];
        corners.right_q[x] = q[cell + 1];
    }
}

void OwnViewPicture::draw(const MappedLattice& lattice, const ViewCamera& camera,
                          std::span<const PackedColour> background, int pitch,
                          std::span<PackedColour> colours, std::span<float> z) {
    const ViewRows view = rows_of(camera);
    const auto width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
    find_places(
        lattice.width, camera.width,
        [&](int i) { return view_subpixels(view_row(view.x, static_cast<float>(i), 0, 0), width); },
        columns_);
    find_places(
        lattice.height, camera.height,
        [&](int j) { return view_subpixels(view_row(view.y, 0, static_cast<float>(j), 0), height); }, rows_);
    const int first = columns_.first, end = columns_.end;
    int read = -1;  // the upper row of the cells whose corners are there
    for (int y = 0; y < camera.height; ++y) {
        PackedColour* const to = colours.data() + static_cast<std::ptrdiff_t>(y) * pitch;
        float* const to_z = z.data() + static_cast<std::ptrdiff_t>(y) * pitch;
        const PackedColour empty = background[static_cast<std::size_t>(y)];
        const bool is_there = y >= rows_.first && y < rows_.end;
        const int left = is_there ? first : camera.width, right = is_there ? end : camera.width;
        std::fill(to, to + left, empty);
        std::fill(to_z, to_z + left, 0.0F);
        std::fill(to + right, to + camera.width, empty);
        std::fill(to_z + right, to_z + camera.width, 0.0F);
        if (!is_there) continue;
        const int row = rows_.cells[static_cast<std::size_t>(y)];
        if (row != read) {
            std::swap(upper_, lower_);
            if (read < 0 || row != read + 1) read_corners(lattice, row, upper_);
            read_corners(lattice, row + 1, lower_);
            read = row;
        }
        const PixelRow pixels{upper_.left.data() + first,
                              upper_.right.data() + first,
                              lower_.left.data() + first,
                              lower_.right.data() + first,
                              upper_.left_q.data() + first,
                              upper_.right_q.data() + first,
                              lower_.left_q.data() + first,
                              lower_.right_q.data() + first,
                              columns_.into.data() + first,
                              rows_.into[static_cast<std::size_t>(y)],
                              view.z.w,
                              empty};
        const auto draw_pixels = [&](auto) __attribute__((always_inline)) {
            draw_row(pixels, end - first, to + first, to_z + first);
        };
        run_vectors(unit_, draw_pixels);
    }
}

}  // namespace touchable
