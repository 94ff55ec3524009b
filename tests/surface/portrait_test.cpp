// A phone's portrait: a head and a pen before a wall, stored at a quarter of the picture's resolution and
// made larger, as 8 bits or half floats of disparity. Its edges are ramps, and flying pixels are chosen by
// that.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "engine/surface/depth_estimator.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/surface/pictures.hpp"

namespace touchable::test {
namespace {

constexpr int portrait_width = 240, portrait_height = 320;
constexpr double focal = 250, nearest = 400, farthest = 2000;
/// Before the wall, two pixels wide.
constexpr double pen_depth = 430;
constexpr int pen_left = 40, pen_right = 42;

using DepthAt = std::function<double(double x, double y)>;

double true_depth(double x, double y) {
    const double u = (x - 120) / 70, v = (y - 150) / 95, r2 = u * u + v * v;
    if (r2 < 1) return 600 - 110 * std::sqrt(1 - r2);
    return 1500 + 0.8 * x;
}

/// The pen is there at full resolution only: nobody's depth of a quarter of it has one.
double true_depth_with_pen(double x, double y) {
    return x >= pen_left && x < pen_right && y > 100 ? pen_depth : true_depth(x, y);
}

/// Disparity of every `factor`th pixel, and in between it by bilinear interpolation.
DepthAt made_larger(const DepthAt& depth, int factor) {
    return [=](double x, double y) {
        const double left = std::floor(x / factor) * factor, top = std::floor(y / factor) * factor;
        const double u = (x - left) / factor, v = (y - top) / factor;
        const auto disparity = [&](double dx, double dy) { return 1 / depth(left + dx, top + dy); };
        return 1 / ((1 - v) * ((1 - u) * disparity(0, 0) + u * disparity(factor, 0)) +
                    v * ((1 - u) * disparity(0, factor) + u * disparity(factor, factor)));
    };
}

/// Every second row mixed, as where two resolutions met.
DepthAt combed(const DepthAt& depth) {
    return [=](double x, double y) {
        return static_cast<int>(y) % 4 < 2 ? depth(x, y) : 1 / (0.5 / depth(x, y) + 0.5 / depth(x + 1, y));
    };
}

Scene portrait_scene(int bits) {
    Scene scene;
    scene.width = portrait_width;
    scene.height = portrait_height;
    scene.camera = {focal, focal, 119.5, 159.5};
    scene.depth_bits = bits;
    scene.depth.kind = DepthCodingKind::inverse;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.near = nearest;
    scene.depth.far = farthest;
    scene.depth.near_is_high = true;
    scene.depth.code_max = static_cast<std::uint16_t>((1 << bits) - 1);
    scene.depth.invalid_code_count = 0;
    derive_valid_range(scene.depth);
    return scene;
}

/// Of 11 bits, as of half floats.
double as_half(double value) {
    int exponent = 0;
    const double mantissa = std::frexp(value, &exponent);
    return std::ldexp(std::round(std::ldexp(mantissa, 11)), exponent - 11);
}

struct Portrait {
    Scene scene;
    StoredPlane plane;
};

Portrait portrait_of(const DepthAt& depth, int bits, bool half = false) {
    Portrait portrait{portrait_scene(bits), {}};
    std::vector<std::uint16_t> codes;
    for (int y = 0; y < portrait_height; ++y)
        for (int x = 0; x < portrait_width; ++x) {
            const double disparity = 1 / depth(x, y), stored = half ? as_half(disparity) : disparity;
            codes.push_back(portrait.scene.depth.code(1 / stored));
        }
    portrait.plane =
        store_plane(portrait_width, portrait_height, codes, {.bytes_per_sample = bits > 8 ? 2 : 1});
    return portrait;
}

FilterSettings chosen_of(const Portrait& portrait) {
    DepthEstimator estimator(portrait.scene);
    estimator.add(portrait.plane.frame());
    Scene scene = portrait.scene;
    choose_filters(estimator.measured(), all_unstated, scene);
    return scene.filter;
}

struct Felt {
    int hanging = 0;        ///< pixels near edges that are 100 mm or more from both sides
    double rms_deg = 0;     ///< of faces near edges against the true ones
    double pen_relief = 0;  ///< least, mm, before what is beside it
};

/// Face of a pixel and its right and lower neighbours, (x, y, z) mm.
struct Face {
    double x, y, z;
};
Face face_of(const DepthAt& depth, int x, int y) {
    const auto point = [&](int i, int j) {
        const double z = depth(i, j);
        return Face{z * (i - 119.5) / focal, z * (j - 159.5) / focal, z};
    };
    const Face o = point(x, y), r = point(x + 1, y), d = point(x, y + 1);
    const Face a{r.x - o.x, r.y - o.y, r.z - o.z}, b{d.x - o.x, d.y - o.y, d.z - o.z};
    const Face n{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    const double length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return {n.x / length, n.y / length, n.z / length};
}

Felt felt(const Portrait& portrait, const FilterSettings& filter, const DepthAt& truth) {
    Scene scene = portrait.scene;
    scene.filter = filter;
    SurfaceFrame frame;
    EXPECT_TRUE(make_cpu_builder(scene)->build(portrait.plane.frame(), frame));
    const DepthAt built = [&](double x, double y) {
        return frame.coding.depth(frame.codes[frame.index(static_cast<int>(x), static_cast<int>(y))]);
    };
    const auto spread = [&](int x, int y, int reach) {
        double least = 1e9, most = 0;
        const int step = (reach + 1) / 2;
        for (int dy = -reach; dy <= reach; dy += step)
            for (int dx = -reach; dx <= reach; dx += step) {
                least = std::min(least, truth(x + dx, y + dy));
                most = std::max(most, truth(x + dx, y + dy));
            }
        return std::pair(least, most);
    };
    Felt result;
    int faces = 0;
    for (int y = 16; y < portrait_height - 16; ++y)
        for (int x = 16; x < portrait_width - 16; ++x) {
            const auto [near, far] = spread(x, y, 6);
            if (far - near < 300) continue;  // no edge is near
            const double z = built(x, y);
            result.hanging += z > near + 100 && z < far - 100;
            const auto [here_near, here_far] = spread(x, y, 1);
            if (here_far - here_near > 30) continue;  // in truth the edge itself, or the head's rim
            const Face is = face_of(built, x, y), was = face_of(truth, x, y);
            const double cosine = is.x * was.x + is.y * was.y + is.z * was.z;
            const double degrees = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / 3.14159265358979;
            result.rms_deg += degrees * degrees;
            ++faces;
        }
    result.rms_deg = std::sqrt(result.rms_deg / faces);
    result.pen_relief = 1e9;
    for (int y = 110; y < portrait_height - 10; ++y)
        for (int x = pen_left; x < pen_right; ++x)
            result.pen_relief = std::min(
                result.pen_relief, std::min(built(pen_left - 3, y), built(pen_right + 2, y)) - built(x, y));
    return result;
}

struct Kind {
    const char* name;
    int bits, factor;
    bool half, comb;
};

TEST(Portrait, RampsOfPhonesAreChosenAndPulledIn) {
    for (const Kind& kind : {Kind{"8 bits, a quarter", 8, 4, false, false},
                             {"half floats, a quarter", 16, 4, true, false},
                             {"8 bits, an eighth", 8, 8, false, false},
                             {"half floats, a comb", 16, 1, true, true}}) {
        SCOPED_TRACE(kind.name);
        const DepthAt larger = made_larger(true_depth, kind.factor);
        const Portrait portrait = portrait_of(kind.comb ? combed(larger) : larger, kind.bits, kind.half);
        const FilterSettings chosen = chosen_of(portrait);
        EXPECT_NE(chosen.flying_pixels, DepthLength{});
        FilterSettings without = chosen;
        without.flying_pixels = {};
        const Felt before = felt(portrait, without, true_depth), after = felt(portrait, chosen, true_depth);
        EXPECT_GT(before.hanging, 100);
        EXPECT_LT(after.hanging, before.hanging / 20);
        EXPECT_LT(after.rms_deg, 1.25 * before.rms_deg) << "an edge may come to lie a pixel aside";
    }
}

// Depth that was drawn: clean edges, real slopes, and a head whose rim falls away.
TEST(Portrait, CleanEdgesAreLeftAlone) {
    for (const int bits : {8, 16})
        for (const bool pen : {false, true}) {
            const Portrait portrait = portrait_of(pen ? true_depth_with_pen : true_depth, bits);
            EXPECT_EQ(chosen_of(portrait).flying_pixels, DepthLength{}) << bits << pen;
        }
}

// What a phone's filter does to a pen and to relief that were clean.
TEST(Portrait, APenTwoPixelsWideAndReliefStay) {
    for (const int bits : {8, 16}) {
        const DepthAt relief = [](double x, double y) {
            return true_depth_with_pen(x, y) - 8 * (static_cast<int>(x / 6) % 2);
        };
        const Portrait portrait = portrait_of(relief, bits);
        FilterSettings of_a_phone;
        of_a_phone.flying_pixels = chosen_of(portrait_of(made_larger(true_depth, 4), bits)).flying_pixels;
        ASSERT_NE(of_a_phone.flying_pixels, DepthLength{});
        const Felt before = felt(portrait, {}, relief), after = felt(portrait, of_a_phone, relief);
        EXPECT_EQ(after.pen_relief, before.pen_relief) << bits;
        EXPECT_GT(after.pen_relief, 900) << bits;
        EXPECT_LE(after.rms_deg, before.rms_deg + 0.5) << bits;
    }
}

}  // namespace
}  // namespace touchable::test
