#include "tests/verify/surface.hpp"

#include <algorithm>

namespace touchable::verify {
namespace {

struct Sample {
    real depth = 0, height = 0;
    bool valid = false;
};

Sample sample(const ExportedFrame& frame, std::size_t index) {
    const Meaning& m = frame.meaning;
    Sample s;
    s.valid = frame.valid[index] != 0;
    if (!s.valid) return s;
    s.depth = m.depth(frame.codes[index]);
    if (!frame.heights.empty()) s.height = m.largest_height * frame.heights[index] / m.height_code_max;
    return s;
}

real between(real a, real b, real t) {
    return a + t * (b - a);
}

/// Stiffness and friction of a pixel of a frame.
Touch meant(const ExportedFrame& frame, std::size_t index) {
    const Meaning& m = frame.meaning;
    if (frame.haptic.empty()) return m.by_default;
    const std::uint8_t* p = &frame.haptic[3 * index];
    return {between(m.low.stiffness, m.high.stiffness, p[0] / 255.0L),
            between(m.low.mu_static, m.high.mu_static, p[1] / 255.0L),
            between(m.low.mu_dynamic, m.high.mu_dynamic, p[2] / 255.0L)};
}

}  // namespace

Surface::Surface(const ExportedFrame& earlier, const ExportedFrame& later, real blend)
    : earlier_(earlier),
      later_(later),
      nearer_(blend < 0.5L ? earlier : later),
      meaning_(earlier.meaning),
      blend_(blend) {}

Vec3 Surface::ray(real x, real y) const {
    return {(x - meaning_.cx) / meaning_.fx, -(y - meaning_.cy) / meaning_.fy, -1};
}

ImagePosition Surface::project(const Vec3& world) const {
    const real planar = -world.z;
    return {meaning_.cx + meaning_.fx * world.x / planar, meaning_.cy - meaning_.fy * world.y / planar};
}

Vertex Surface::vertex(int i, int j) const {
    Sample s;
    if (i >= 0 && j >= 0 && i < meaning_.width && j < meaning_.height) {
        const auto index = static_cast<std::size_t>(j) * static_cast<std::size_t>(meaning_.width) +
                           static_cast<std::size_t>(i);
        const Sample a = sample(earlier_, index), b = sample(later_, index);
        if (blend_ == 0) {
            s = a;
        } else if (a.valid && b.valid) {
            s = {between(a.depth, b.depth, blend_), between(a.height, b.height, blend_), true};
        } else {
            s = &nearer_ == &earlier_ ? a : b;
        }
    }
    const real depth = s.valid ? s.depth - s.height : meaning_.scene_far;
    const Vec3 r = ray(i, j);
    const real planar = meaning_.range ? depth / length(r) : depth;
    return {planar * r, 1 / planar, s.valid, s.valid ? s.height : 0};
}

FacetId Surface::facet_id(ImagePosition at) const {
    auto cell = [](real x, int size) {
        if (x < -1) return -2;
        if (x > size) return size;
        return std::min(static_cast<int>(std::floor(x)), size - 1);
    };
    FacetId id{cell(at.x, meaning_.width), cell(at.y, meaning_.height), 0};
    const bool inside =
        id.column > -2 && id.column < meaning_.width && id.row > -2 && id.row < meaning_.height;
    if (inside && at.x - id.column < at.y - id.row) id.half = 1;
    return id;
}

Facet Surface::facet_at(ImagePosition at) const {
    const FacetId id = facet_id(at);
    const bool strip_x = id.column == -2 || id.column == meaning_.width;
    const bool strip_y = id.row == -2 || id.row == meaning_.height;
    const int i = std::max(id.column, -1), j = std::max(id.row, -1);
    const Vec3 p = vertex(i, j).position;
    Vec3 along, across;
    if (strip_x) {  // q does not change with x: a line of constant planar depth
        along = {1, 0, 0};
        across = strip_y ? Vec3{0, 1, 0} : vertex(i, j + 1).position - p;
    } else if (strip_y) {
        along = vertex(i + 1, j).position - p;
        across = {0, 1, 0};
    } else {
        along = vertex(i + 1, j + 1).position - p;
        across = (id.half == 0 ? vertex(i + 1, j) : vertex(i, j + 1)).position - p;
    }
    const Vec3 n = unit(cross(along, across));
    return {id, p, dot(n, p) < 0 ? n : -1 * n};
}

real Surface::q_at(ImagePosition at) const {
    const real x = std::clamp<real>(at.x, -1, meaning_.width),
               y = std::clamp<real>(at.y, -1, meaning_.height);
    const int i = std::min(static_cast<int>(std::floor(x)), meaning_.width - 1);
    const int j = std::min(static_cast<int>(std::floor(y)), meaning_.height - 1);
    const real a = x - i, b = y - j;
    const real start = vertex(i, j).q, end = vertex(i + 1, j + 1).q;
    if (a >= b) {
        const real corner = vertex(i + 1, j).q;
        return start + a * (corner - start) + b * (end - corner);
    }
    const real corner = vertex(i, j + 1).q;
    return start + b * (corner - start) + a * (end - corner);
}

Touch Surface::touch_of_pixel(int i, int j) const {
    const int ci = std::clamp(i, 0, meaning_.width - 1), cj = std::clamp(j, 0, meaning_.height - 1);
    const auto index = static_cast<std::size_t>(cj) * static_cast<std::size_t>(meaning_.width) +
                       static_cast<std::size_t>(ci);
    const Touch before = meant(earlier_, index), after = meant(later_, index);
    Touch t{between(before.stiffness, after.stiffness, blend_),
            between(before.mu_static, after.mu_static, blend_),
            between(before.mu_dynamic, after.mu_dynamic, blend_)};
    if (ci != i || cj != j || nearer_.valid[index] == 0) t.mu_static = t.mu_dynamic = 0;
    return t;
}

/// 1 where a pixel has no depth at this moment. One that is about to lose it, half-way between the frames,
/// lacks it more and more until then.
real Surface::lacks_depth(int i, int j) const {
    if (i < 0 || j < 0 || i >= meaning_.width || j >= meaning_.height) return 1;
    const auto index =
        static_cast<std::size_t>(j) * static_cast<std::size_t>(meaning_.width) + static_cast<std::size_t>(i);
    if (nearer_.valid[index] == 0) return 1;
    const bool is_lost = earlier_.valid[index] != 0 && later_.valid[index] == 0;
    return is_lost ? 2 * blend_ : 0;
}

/// The most that a vertex or one of the eight around it lacks.
real Surface::hole_around(int i, int j) const {
    real most = 0;
    for (int n = 0; n < 9; ++n) most = std::fmax(most, lacks_depth(i + n % 3 - 1, j + n / 3 - 1));
    return most;
}

Touch Surface::touch_at(ImagePosition at) const {
    const real x = std::clamp<real>(at.x, -1, meaning_.width),
               y = std::clamp<real>(at.y, -1, meaning_.height);
    const int i = std::min(static_cast<int>(std::floor(x)), meaning_.width - 1);
    const int j = std::min(static_cast<int>(std::floor(y)), meaning_.height - 1);
    const real a = x - i, b = y - j;
    Touch sum;
    real hole = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const int di = corner & 1, dj = corner >> 1;
        const Touch t = touch_of_pixel(i + di, j + dj);
        const real weight = (di ? a : 1 - a) * (dj ? b : 1 - b);
        sum.stiffness += weight * t.stiffness;
        sum.mu_static += weight * t.mu_static;
        sum.mu_dynamic += weight * t.mu_dynamic;
        if (meaning_.hole_stiffness) hole += weight * hole_around(i + di, j + dj);
    }
    if (meaning_.hole_stiffness) sum.stiffness = between(sum.stiffness, *meaning_.hole_stiffness, hole);
    sum.mu_dynamic = std::fmin(sum.mu_dynamic, sum.mu_static);
    return sum;
}

}  // namespace touchable::verify
