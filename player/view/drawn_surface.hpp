// SPDX-License-Identifier: Apache-2.0
#pragma once

// The surface as every painter draws it: its vertices between two frames, its light, the pixels that a
// triangle covers, and colours. Plain code, vertex by vertex; cpu_painting.hpp of `draw` does the same with
// vectors, gpu_painting.hpp with kernels. A page takes the drawn depths of a frame:
//
//     const std::vector<float> q = q_of(field);  // 1 / planar depth of each pixel
//
// Threads: any may call all functions, several at once, while the field's frames live.

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <vector>

#include "engine/scene/frames.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/view/view.hpp"
#include "shaders/cut_rule.h"
#include "shaders/edge_rule.h"
#include "shaders/view_project.h"

namespace touchable {

/// How a vertex's colour is lit, to show relief. Clay is always in full light.
enum class Lighting {
    off,     ///< unchanged: photographs have the light of their place
    soft,    ///< half of the full light's effect
    full,    ///< a gentle light
    values,  ///< unchanged, for maps, whose colours carry values: nothing may darken them
};

/// How much of the full light's effect a colour gets, 0 to 1.
constexpr float light_strength(Lighting lighting) {
    return lighting == Lighting::full ? 1.0F : lighting == Lighting::soft ? 0.5F : 0.0F;
}

/// What a painter draws: the lattice at one moment, with a colour at every vertex.
struct ViewSurface {
    /// Tiles of TileGrid with something to draw, as row * tiles_x + column, ascending.
    struct Tiles {
        std::vector<std::uint32_t> whole;  ///< no triangle is cut (shaders/cut_rule.h)
        /// Some triangles are cut; at least one has no hole, so the clip's own view shows it.
        std::vector<std::uint32_t> mixed;
        bool operator==(const Tiles&) const = default;
    };

    int width = 0, height = 0;
    float focal_length = 0;             ///< of the clip's camera, pixels
    bool fills_gaps = false;            ///< with these colours, and holes (shaders/gap_fill.h)
    std::vector<float> q;               ///< 1 / planar depth, height subtracted; 0: invalid. Row-major
    std::vector<PackedColour> colours;  ///< row-major

    std::size_t index(int x, int y) const { return pixel_place(x, y, width); }
};

/// A painter's output, row-major: z (see ViewCamera; 0: empty) and colour of every pixel.
struct PicturePlanes {
    int width = 0, height = 0;
    std::vector<float> z;
    std::vector<PackedColour> colours;  ///< of no opacity where nothing is drawn

    std::size_t index(int x, int y) const { return pixel_place(x, y, width); }
};

/// clip_from_lattice in the shared header's layout.
inline ViewRows rows_of(const ViewCamera& camera) {
    const glm::dmat4 rows = glm::transpose(camera.clip_from_lattice);
    return {glm::vec4(rows[0]), glm::vec4(rows[1]), glm::vec4(rows[2]), glm::vec4(rows[3])};
}

/// Whether a view has the clip camera's position and direction: a vertex's screen position then does not
/// depend on its depth.
inline bool is_own_view(const ViewCamera& camera) {
    const auto [x, y, z, w] = rows_of(camera);
    const bool upright = x.y == 0 && x.w == 0 && y.x == 0 && y.w == 0 && x.x > 0 && y.y > 0;
    return upright && z.x == 0 && z.y == 0 && z.z == 0 && w.x == 0 && w.y == 0 && w.z == 1 && w.w == 0;
}

/// Replaces CUT_RULE_RATIO in a decimated lattice: vertices farther apart may differ more in depth.
float cut_ratio(int step);
/// A lattice as edges are found in it. `focal_length`: of its own camera, vertices.
EdgeLattice edge_lattice(const float* q, int width, int height, int pitch, int step, float focal_length);

/// ViewSurface::fills_gaps of a surface with this colour.
inline bool fills_gaps(const PlaneView& colour, Lighting lighting) {
    return lighting != Lighting::values && !colour.empty();
}

/// The same view of a lattice that keeps every `step`th vertex.
ViewCamera decimated(ViewCamera camera, int step);

/// The greatest depth change between a pair's frames that is still interpolated, scene units: `reach` of
/// shaders/blend_rule.h.
float blend_reach(const HeightField& field);

/// Depth subtracted per height code, scene units.
double height_per_code(const Scene& scene);

/// Whether a pixel's vertices in the pair's two frames are interpolated: both have depth, and their distance
/// does not mean that an edge passed over the pixel (shaders/blend_rule.h).
bool are_mixed(const HeightField& field, const FieldVertex& prev, const FieldVertex& next);

/// The drawn vertex of a pixel: interpolated, as it is felt, or that of the frame nearer in time.
FieldVertex drawn_vertex(const HeightField& field, std::int64_t i, std::int64_t j);

/// q of a drawn pixel, rounded to float, 0 without a surface; `q_of`: of every pixel.
float drawn_q(const HeightField& field, int x, int y);
std::vector<float> q_of(const HeightField& field);

/// The surface of a field with the given q. `colour` has 3 channels of the field's size; if it is
/// empty, clay shows light and depth alone.
ViewSurface make_view_surface(const HeightField& field, std::vector<float> q, const PlaneView& colour,
                              Lighting lighting);

/// The 4 % and 96 % quantiles of valid vertices' q, from a sample.
struct UsualQ {
    float farthest, nearest;
};
UsualQ usual_q(int width, int height, const std::function<float(int x, int y)>& q_at);

/// A colour for every vertex of `surface` (reads its q, not its colours): that of `colour`, lit; if it is
/// empty, clay in full light, warmer when nearer, cooler when farther. The light comes from the upper left
/// behind the clip's camera.
std::vector<PackedColour> lit_colours(const Camera& camera, const ViewSurface& surface,
                                      const PlaneView& colour, Lighting lighting);

/// Colours from dark blue through green to light yellow, lightness growing evenly as perceived (OKLab), none
/// of them grey: legible without telling red from green, by lightness and by blue and yellow.
const std::array<PackedColour, 256>& colour_ramp();

/// The ramp's colour at 0 to 1; beyond, the end's.
PackedColour ramp_colour(double share);

/// The colour of a finger, by its number.
PackedColour finger_colour(std::size_t finger);

/// A corner in clip space (ViewCamera) with a value to interpolate: a colour, a normal or similar.
struct FillCorner {
    glm::vec4 clip;
    glm::vec3 value;
};

namespace fill {

struct Point {
    std::int64_t x, y;  // subpixels
    float z;
    float share;      // 1 / w
    glm::vec3 value;  // the value / w
};

/// Twice the signed area of a, b, (x, y); positive if clockwise on the screen.
inline std::int64_t edge(const Point& a, const Point& b, std::int64_t x, std::int64_t y) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}
/// The least edge value inside: a centre on an upper or left edge belongs to the triangle.
inline std::int64_t least_inside(const Point& a, const Point& b) {
    return b.y < a.y || (b.y == a.y && b.x > a.x) ? 0 : 1;
}
inline Point to_screen(const FillCorner& corner, int width, int height) {
    const glm::vec4& c = corner.clip;
    return {view_subpixels(c.x / c.w, static_cast<float>(width)),
            view_subpixels(c.y / c.w, static_cast<float>(height)), c.z / c.w, 1.0F / c.w,
            corner.value * (1.0F / c.w)};
}
/// The pixels whose centres lie within [least, greatest] subpixels, as [first, last] on a side of `size`.
inline std::array<int, 2> pixels_between(std::int64_t least, std::int64_t greatest, int size) {
    constexpr std::int64_t half = VIEW_SUBPIXELS / 2;
    const std::int64_t first = (least - half + VIEW_SUBPIXELS - 1) >> 8, last = (greatest - half) >> 8;
    return {static_cast<int>(std::clamp<std::int64_t>(first, 0, size)),
            static_cast<int>(std::clamp<std::int64_t>(last, -1, size - 1))};
}

/// Limits a row's pixels, counted from one where the edge from a to b has the value `at`, to those inside it.
inline void limit_span(const Point& a, const Point& b, std::int64_t at, std::int64_t& first,
                       std::int64_t& last) {
    const std::int64_t step = (a.y - b.y) * VIEW_SUBPIXELS, lacks = least_inside(a, b) - at;
    if (step > 0 && lacks > 0) first = std::max(first, (lacks + step - 1) / step);
    if (step < 0) last = std::min(last, lacks > 0 ? -1 : lacks / step);
    if (step == 0 && lacks > 0) last = -1;
}

template <class Plot>
void triangle(const Point& a, Point b, Point c, int width, int height, int first_row, int last_row,
              Plot& plot) {
    std::int64_t area = edge(a, b, c.x, c.y);
    if (area == 0) return;
    if (area < 0) {
        std::swap(b, c);
        area = -area;
    }
    const auto [x0, x1] = pixels_between(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), width);
    const auto [y0, y1] = pixels_between(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), height);
    const float scale = 1.0F / static_cast<float>(area);
    for (int y = std::max(y0, first_row); y <= std::min(y1, last_row); ++y) {
        const std::int64_t px = x0 * VIEW_SUBPIXELS + VIEW_SUBPIXELS / 2,
                           py = y * VIEW_SUBPIXELS + VIEW_SUBPIXELS / 2;
        std::int64_t first = 0, last = x1 - x0;
        std::array<std::int64_t, 3> at{edge(a, b, px, py), edge(b, c, px, py), edge(c, a, px, py)};
        limit_span(a, b, at[0], first, last);
        limit_span(b, c, at[1], first, last);
        limit_span(c, a, at[2], first, last);
        for (std::int64_t x = first; x <= last; ++x) {
            const std::int64_t ab = at[0] - (b.y - a.y) * VIEW_SUBPIXELS * x,
                               ca = at[2] - (a.y - c.y) * VIEW_SUBPIXELS * x;
            const float of_b = static_cast<float>(ca) * scale, of_c = static_cast<float>(ab) * scale;
            const float share = a.share + of_b * (b.share - a.share) + of_c * (c.share - a.share);
            plot(x0 + static_cast<int>(x), y, a.z + of_b * (b.z - a.z) + of_c * (c.z - a.z),
                 (a.value + of_b * (b.value - a.value) + of_c * (c.value - a.value)) / share);
        }
    }
}

}  // namespace fill

/// Calls plot(x, y, z, value) for every pixel whose centre the triangle covers, from either side: exact in
/// subpixels of 1/256, so that triangles that share an edge neither overlap nor leave a gap. Clips at the
/// near plane. z is interpolated linearly on the screen, value linearly in space.
/// Of the rows from `first_row` to `last_row` alone.
template <class Plot>
void fill_triangle(const std::array<FillCorner, 3>& corners, int width, int height, Plot&& plot,
                   int first_row = 0, int last_row = std::numeric_limits<int>::max()) {
    std::array<fill::Point, 4> points;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const FillCorner &from = corners[k], &to = corners[(k + 1) % 3];
        const float inside_from = from.clip.w - from.clip.z, inside_to = to.clip.w - to.clip.z;
        if (inside_from >= 0) points[count++] = fill::to_screen(from, width, height);
        if ((inside_from >= 0) == (inside_to >= 0)) continue;
        const float share = inside_from / (inside_from - inside_to);
        FillCorner crossing{from.clip + share * (to.clip - from.clip),
                            from.value + share * (to.value - from.value)};
        crossing.clip.z = crossing.clip.w;
        points[count++] = fill::to_screen(crossing, width, height);
    }
    if (count >= 3) fill::triangle(points[0], points[1], points[2], width, height, first_row, last_row, plot);
    if (count == 4) fill::triangle(points[0], points[2], points[3], width, height, first_row, last_row, plot);
}

}  // namespace touchable
