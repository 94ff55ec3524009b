#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec4.hpp>

#include "engine/base/vectors.hpp"
#include "shaders/view_project.h"

// Triangles side by side, one in each lane of a vector, with the arithmetic of triangle_fill.hpp. Vectors
// never cross a function call that is not inlined (see vectors.hpp).

namespace touchable {

inline constexpr int half_pixel = VIEW_SUBPIXELS / 2;
template <class T, int n>
struct Lanes {
    typedef T Type __attribute__((vector_size(n * sizeof(T))));
};
template <int n>
using Ints = typename Lanes<std::int32_t, n>::Type;
template <int n>
using Floats = typename Lanes<float, n>::Type;

template <class V, class T>
[[gnu::always_inline]] inline V load(const T* from) {
    V values;
    std::memcpy(&values, from, sizeof(values));
    return values;
}

template <class V, class T>
[[gnu::always_inline]] inline void store(const V& values, T* to) {
    std::memcpy(to, &values, sizeof(values));
}

/// 0, 1, 2, ...
template <int n>
[[gnu::always_inline]] inline Floats<n> lane_numbers() {
    Floats<n> numbers{};
    for (int k = 0; k < n; ++k) numbers[k] = static_cast<float>(k);
    return numbers;
}

/// All lanes' bits together.
template <class V>
[[gnu::always_inline]] inline std::uint32_t or_of(const V& values) {
    std::array<std::uint64_t, sizeof(V) / 8> words;
    std::memcpy(words.data(), &values, sizeof(V));
    std::uint64_t all = 0;
    for (const std::uint64_t word : words) all |= word;
    return static_cast<std::uint32_t>(all | all >> 32);
}

/// The pixel of the first centre at or after a place in subpixels, and of the last one at or before it.
template <class T>
[[gnu::always_inline]] inline T first_pixel(T subpixels) {
    return (subpixels + (half_pixel - 1)) >> 8;
}
template <class T>
[[gnu::always_inline]] inline T last_pixel(T subpixels) {
    return (subpixels - half_pixel) >> 8;
}

/// `triangle_is_cut` of many, by this ratio.
template <class F>
[[gnu::always_inline]] inline auto cut(const F& q0, const F& q1, const F& q2, float ratio) {
    F least = lesser(q0, q1), most = greater(q0, q1);
    least = lesser(q2, least);
    most = greater(q2, most);
    return ~(least > 0.0F) | (most > ratio * least);
}

/// `view_row` of many.
template <class F>
[[gnu::always_inline]] inline F clip(const glm::vec4& row, const F& x, const F& y, const F& q) {
    F sum = row.x * x;
    sum = sum + row.y * y;
    sum = sum + row.z;
    return sum + row.w * q;
}

/// `view_subpixels` of many. NaN, of a vertex that is not drawn, becomes the guard.
template <int n>
[[gnu::always_inline]] inline Ints<n> subpixels(const Floats<n>& ndc, float size) {
    Floats<n> at = (ndc * 0.5F + 0.5F) * (size * static_cast<float>(VIEW_SUBPIXELS)) + 0.5F;
    // The same: what is not small has no half, and the guard is even.
    at = at > -VIEW_GUARD ? at : Floats<n>{} - VIEW_GUARD;
    at = at < VIEW_GUARD ? at : Floats<n>{} + VIEW_GUARD;
    const Ints<n> whole = __builtin_convertvector(at, Ints<n>);  // towards 0
    return whole + (__builtin_convertvector(whole, Floats<n>) > at);
}

/// Corners of cells side by side. x, y: subpixels from the centre of each cell's first pixel. Colours are
/// times share, 1 / w.
template <int n>
struct Corners {
    Ints<n> x, y;
    Floats<n> z, share, red, green, blue;
};

/// Twice the signed area of each a, b, (0, 0), less what is least inside (fill::least_inside), and what it
/// grows by from pixel to pixel.
template <int n>
struct EdgeLanes {
    [[gnu::always_inline]] EdgeLanes(const Corners<n>& a, const Corners<n>& b) {
        const Ints<n> dx = b.x - a.x, dy = b.y - a.y;
        least = ((dy < 0) | ((dy == 0) & (dx > 0))) + 1;
        here = dy * a.x - dx * a.y - least;
        right = -dy * VIEW_SUBPIXELS;
        down = dx * VIEW_SUBPIXELS;
    }
    Ints<n> least, here, right, down;
};

/// Triangles side by side, each turned so that its edges are positive inside.
template <int n>
struct TriangleLanes {
    [[gnu::always_inline]] TriangleLanes(const Corners<n>& first, const Corners<n>& second,
                                         const Corners<n>& third, const Ints<n>& turns)
        : b(chosen(turns, third, second)),
          c(chosen(turns, second, third)),
          ab(first, b),
          bc(b, c),
          ca(c, first),
          scale(1.0F / __builtin_convertvector(ab.here + ab.least + bc.here + bc.least + ca.here + ca.least,
                                               Floats<n>)) {
        for (auto* const each : {&b, &c}) {
            each->z -= first.z;
            each->share -= first.share;
            each->red -= first.red;
            each->green -= first.green;
            each->blue -= first.blue;
        }
    }
    [[gnu::always_inline]] static Corners<n> chosen(const Ints<n>& mask, const Corners<n>& one,
                                                    const Corners<n>& other) {
        return {mask ? one.x : other.x,         mask ? one.y : other.y,     mask ? one.z : other.z,
                mask ? one.share : other.share, mask ? one.red : other.red, mask ? one.green : other.green,
                mask ? one.blue : other.blue};
    }

    Corners<n> b, c;  ///< z, share and colours: less the first corner's
    EdgeLanes<n> ab, bc, ca;
    Floats<n> scale;  ///< 1 / twice the area
};

/// Where a pixel lies in each of a row's triangles.
template <int n>
struct Place {
    [[gnu::always_inline]] explicit Place(const TriangleLanes<n>& t)
        : ab(t.ab.here), bc(t.bc.here), ca(t.ca.here) {}
    [[gnu::always_inline]] void go_right(const TriangleLanes<n>& t, int step) {
        ab += t.ab.right * step;
        bc += t.bc.right * step;
        ca += t.ca.right * step;
    }
    [[gnu::always_inline]] void go_down(const TriangleLanes<n>& t) {
        ab += t.ab.down;
        bc += t.bc.down;
        ca += t.ca.down;
    }
    [[gnu::always_inline]] Ints<n> is_inside() const { return (ab | bc | ca) >= 0; }
    Ints<n> ab, bc, ca;
};

}  // namespace touchable
