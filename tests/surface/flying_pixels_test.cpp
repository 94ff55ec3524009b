// SPDX-License-Identifier: Apache-2.0
// Pixels that hang between two surfaces are pulled to one of them; slopes, steps and thin things stay.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "engine/formats/open_clip.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/must.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

constexpr int side = 24;

/// Codes are millimetres; those that differ by 10 or less belong to one surface.
std::vector<std::uint16_t> landed_picture(const std::function<int(int x, int y)>& code) {
    Scene scene = depth_scene(side, side, 12, Marking::range_and_few, {.flying_pixels = {10, 0}});
    std::vector<std::uint16_t> stored;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) stored.push_back(static_cast<std::uint16_t>(code(x, y)));
    const StoredPlane plane = store_plane(side, side, stored, {});
    SurfaceFrame frame;
    EXPECT_TRUE(make_cpu_builder(scene)->build(plane.frame(), frame));
    return {frame.codes.begin(), frame.codes.end()};
}

std::string changes(const std::function<int(int x, int y)>& code) {
    const auto picture = landed_picture(code);
    std::string words;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const int is = picture[static_cast<std::size_t>(y * side + x)];
            if (is != code(x, y))
                words += std::to_string(x) + "," + std::to_string(y) + ": " + std::to_string(code(x, y)) +
                         " to " + std::to_string(is) + "; ";
        }
    return words;
}

/// For pictures that vary along one direction only: from left to right, or downwards.
void expect_landed(bool down, const std::function<int(int along)>& stored,
                   const std::function<int(int along)>& expected) {
    const auto picture = landed_picture([&](int x, int y) { return stored(down ? y : x); });
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
            ASSERT_EQ(picture[static_cast<std::size_t>(y * side + x)], expected(down ? y : x))
                << x << ", " << y;
}

TEST(FlyingPixels, MoveToNearerSurface) {
    for (const bool down : {false, true})
        for (const int wide : {1, 2})
            for (const auto& codes : {std::pair{1000, 900}, {1099, 900}, {1101, 1300}, {1270, 1300}}) {
                const auto codes_with = [&](int between) {
                    return [=](int along) { return along < 12 ? 900 : along < 12 + wide ? between : 1300; };
                };
                expect_landed(down, codes_with(codes.first), codes_with(codes.second));
            }
}

/// From 900 to 900 + 40 n in n steps, from the pixel `first` on.
int on_a_ramp(int along, int first, int steps) {
    return 900 + 40 * std::clamp(along - first, 0, steps);
}

// Edges of depth that was made larger. Half of the ramp goes to each side, and pixels within twice the gate
// of a side are its.
TEST(FlyingPixels, SplitRampsUpTo12Steps) {
    for (const bool down : {false, true})
        for (int steps = 2; steps <= 12; ++steps) {
            SCOPED_TRACE(steps);
            expect_landed(
                down, [=](int along) { return on_a_ramp(along, 6, steps); },
                [=](int along) { return 2 * (along - 6) <= steps ? 900 : 900 + 40 * steps; });
        }
}

TEST(FlyingPixels, KeepOtherSlopes) {
    EXPECT_EQ(changes([](int x, int) { return on_a_ramp(x, 5, 13); }), "") << "wider: a real slope";
    EXPECT_EQ(changes([](int x, int) { return 900 + 9 * std::clamp(x - 6, 0, 10); }), "") << "gentle";
    EXPECT_EQ(changes([](int x, int) { return x < 6 || x > 16 ? 900 : 900 + 40 * std::min(x - 5, 17 - x); }),
              "")
        << "a ridge, whose sides end at its edge";
    EXPECT_EQ(changes([](int x, int y) { return (x == 10 || x == 11) && y > 4 ? 900 : 1300; }), "")
        << "a pen two pixels wide";
}

TEST(FlyingPixels, PreferLowerCodeHalfWay) {
    const auto picture = landed_picture([](int x, int) { return x < 12 ? 900 : x == 12 ? 1000 : 1100; });
    EXPECT_EQ(picture[12], 900);
}

TEST(FlyingPixels, KeepPixelsOfSurfaces) {
    EXPECT_EQ(changes([](int x, int) { return 600 + 40 * x; }), "") << "a steep slope";
    EXPECT_EQ(changes([](int x, int y) { return 600 + 9 * x + 9 * y; }), "") << "a slope";
    EXPECT_EQ(changes([](int x, int) { return x < 12 ? 900 : 1300; }), "") << "a silhouette";
    EXPECT_EQ(changes([](int x, int) { return x < 12 ? 900 : 920; }), "") << "a small step";
    EXPECT_EQ(changes([](int x, int) { return 600 + 100 * (x / 3); }), "") << "stairs three pixels wide";
    EXPECT_EQ(changes([](int x, int y) { return x >= 10 && x < 15 && y > 4 ? 900 : 1300; }), "") << "a pen";
    EXPECT_EQ(changes([](int x, int y) { return x == 12 && y > 4 ? 900 : 1300; }), "")
        << "a wire in front of a wall";
    EXPECT_EQ(changes([](int x, int y) { return x == 12 && y == 12 ? 900 : 1300; }), "") << "a speck";
}

TEST(FlyingPixels, UseOtherLinesAroundHoles) {
    // A hole on the line across leaves the two diagonals.
    const auto code = [](int x, int y) {
        if (x == 10 && y == 12) return 0;
        return x < 12 ? 900 : x == 12 ? 1000 : 1300;
    };
    EXPECT_EQ(landed_picture(code)[12 * side + 12], 900);
    EXPECT_EQ(changes([](int x, int) {
                  return x == 11 || x == 13 ? 0 : x < 12 ? 900 : x == 12 ? 1000 : 1300;
              }),
              "");
}

Scene log_scene(double near, double far, double shift, int code_max, bool near_is_high, DepthLength length) {
    Scene scene = depth_scene(96, 64, 16, Marking::none, {.flying_pixels = length});
    DepthCoding& depth = scene.depth;
    depth.kind = DepthCodingKind::log;
    depth.near = near;
    depth.far = far;
    depth.shift = shift;
    depth.code_max = static_cast<std::uint16_t>(code_max);
    depth.near_is_high = near_is_high;
    derive_valid_range(depth);
    return scene;
}

// The gate of docs/conventions.md, step 5, for log codes.
TEST(FlyingPixels, HaveThreePointLogGate) {
    int falling = 0, rising = 0;
    struct Planes {
        double near, far, shift;
    };
    for (const Planes planes : {Planes{0.01, 10, 3.5}, {400, 2800, 0}, {0.5, 1.5, -0.2}})
        for (const int code_max : {300, 4095, 65535})
            for (const DepthLength share : {DepthLength{0.02, 0}, {0, 0.02}, {0.01, 0.01}, {0.2, 0.3}})
                for (const bool near_is_high : {false, true}) {
                    const double near = planes.near, far = planes.far, shift = planes.shift;
                    const double middle = std::sqrt((near + shift) * (far + shift)) - shift;
                    const DepthLength length{share.constant * middle, share.quadratic / middle};
                    const Scene scene = log_scene(near, far, shift, code_max, near_is_high, length);
                    const FlyingPixels filter = *flying_pixels(scene);
                    const double way = std::log((far + shift) / (near + shift));
                    const auto in_codes = [&](double z) {
                        return code_max * (length.constant + length.quadratic * z * z) / ((z + shift) * way);
                    };
                    const double a = in_codes(near), m = in_codes(middle), b = in_codes(far);
                    const double linear = 4 * m - 3 * a - b, quadratic = 2 * (a + b) - 4 * m;
                    ++(linear < 0 ? falling : rising);
                    int scale = 1;
                    while (code_max * scale * 2 <= 65535) scale *= 2;
                    const double unit = 65536.0 / (code_max * scale);
                    const auto rounded = [](double x) {
                        return static_cast<std::int64_t>(std::floor(std::min(x, 21845.0) + 0.5));
                    };
                    const std::int64_t constant = rounded(a), slope = rounded(std::fabs(linear) * unit),
                                       bend = rounded(quadratic * unit * unit);
                    for (int code = 0; code <= code_max; ++code) {
                        const std::int64_t from_near = near_is_high ? code_max - code : code;
                        const std::int64_t n = from_near * scale, part = slope * n / 65536;
                        const std::int64_t rest = constant + bend * (n * n / 65536) / 65536;
                        const std::int64_t gate =
                            linear < 0 ? std::max<std::int64_t>(rest - part, 0) : rest + part;
                        ASSERT_EQ(filter.gate_at(static_cast<std::uint16_t>(code)),
                                  std::clamp<std::int64_t>(gate, 1, 32767))
                            << near << " to " << far << ", largest code " << code_max << ", code " << code;
                    }
                }
    EXPECT_GT(falling, 10);
    EXPECT_GT(rising, 4);
}

// Each row is a ramp from one end of the codes to the other, with steps between the least gate, which is in
// the middle, and those of its ends.
TEST(FlyingPixels, LandEquallyByEveryBuilder) {
    for (const bool near_is_high : {false, true}) {
        const Scene scene = log_scene(500, 1500, -200, 4095, near_is_high, {26, 7.5e-5});
        const FlyingPixels filter = *flying_pixels(scene);
        const int low = 512, high = 3584, steps = 8;
        ASSERT_GT(std::min(filter.gate_at(low), filter.gate_at(high)), (high - low) / steps);
        ASSERT_LT(filter.gate_at(2048), (high - low) / steps);
        std::vector<std::uint16_t> stored;
        for (int y = 0; y < scene.height; ++y)
            for (int x = 0; x < scene.width; ++x)
                stored.push_back(static_cast<std::uint16_t>(
                    low + (high - low) * std::clamp(x % 48 - 12, 0, steps) / steps));
        const StoredPlane plane = store_plane(scene.width, scene.height, stored, {});
        SurfaceFrame expected, frame;
        ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), expected));
        EXPECT_FALSE(std::equal(stored.begin(), stored.end(), expected.codes.begin()));
        for (const VectorUnit unit : usable_vector_units()) {
            ASSERT_TRUE(make_cpu_builder(scene, {1, unit})->build(plane.frame(), frame));
            EXPECT_EQ(first_difference(expected, frame), "") << "vectors " << static_cast<int>(unit);
        }
    }
}

// A phone's portrait: a head and a pen before a wall, stored at a quarter of the picture's resolution and
// made larger, as 8 bits or half floats of disparity. Its edges are ramps, and flying pixels are chosen by
// that.

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

/// The pen is there at full resolution only: depth of a quarter of it has none.
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

/// Rounded to 11 bits, like half floats.
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

/// Normal of the face of a pixel and its right and lower neighbours.
glm::dvec3 face_of(const DepthAt& depth, int x, int y) {
    const auto point = [&](int i, int j) {
        return depth(i, j) * glm::dvec3((i - 119.5) / focal, (j - 159.5) / focal, 1);
    };
    const glm::dvec3 corner = point(x, y);
    return glm::normalize(glm::cross(point(x + 1, y) - corner, point(x, y + 1) - corner));
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
            const double cosine = glm::dot(face_of(built, x, y), face_of(truth, x, y));
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

TEST(Portrait, PullsInRampsOfPhones) {
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
TEST(Portrait, LeavesCleanEdgesAlone) {
    for (const int bits : {8, 16})
        for (const bool pen : {false, true}) {
            const Portrait portrait = portrait_of(pen ? true_depth_with_pen : true_depth, bits);
            EXPECT_EQ(chosen_of(portrait).flying_pixels, DepthLength{}) << bits << pen;
        }
}

// A phone's filter leaves a clean pen and clean relief alone.
TEST(Portrait, KeepsPenAndRelief) {
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

// How far the faces of a structured-light recording are off the planes around them: with and without its
// levels.

constexpr int reach = 15;  // windows of 31x31 pixels

/// The plane 1 / depth = at + right (x - x0) + down (y - y0) of the pixels around (x0, y0).
struct Plane {
    double at = 0, right = 0, down = 0;
    double residual = 0;  // RMS
};

glm::dvec3 normal_of(const Plane& plane, const Camera& camera, int x, int y) {
    return glm::normalize(
        glm::dvec3(plane.right * camera.fx, plane.down * camera.fy,
                   plane.at - plane.right * (x - camera.cx) - plane.down * (y - camera.cy)));
}

/// Nothing where a pixel of the window is invalid.
std::optional<Plane> plane_around(const RawFrame& raw, const DepthCoding& coding, int x0, int y0) {
    double sum = 0, along_x = 0, along_y = 0, square = 0, steps = 0;
    for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
            const std::uint16_t code = raw.depth.sample(x0 + dx, y0 + dy);
            if (!coding.is_valid(code)) return std::nullopt;
            const double q = 1 / coding.depth(code);
            sum += q;
            along_x += dx * q;
            along_y += dy * q;
            square += q * q;
            steps += dx * dx;
        }
    const double count = (2 * reach + 1) * (2 * reach + 1);
    Plane plane{sum / count, along_x / steps, along_y / steps, 0};
    const double rest = square - sum * plane.at - (plane.right * along_x + plane.down * along_y);
    plane.residual = std::sqrt(std::max(rest, 0.0) / count);
    return plane;
}

/// Degrees RMS between the faces of the surface and the planes around them, over what is flat to half a
/// level.
double off_the_planes(const RawFrame& raw, const Scene& scene, double level) {
    SurfaceFrame surface;
    EXPECT_TRUE(make_cpu_builder(scene)->build(raw, surface));
    double sum = 0;
    int faces = 0;
    const auto q = [&](int x, int y) { return 1 / sample_of(surface, x, y).depth; };
    for (int y = reach; y < scene.height - reach; y += 5)
        for (int x = reach; x < scene.width - reach; x += 5) {
            const auto plane = plane_around(raw, scene.depth, x, y);
            if (!plane || plane->residual > 0.45 * level) continue;
            const Plane face{q(x, y), q(x + 1, y) - q(x, y), q(x + 1, y + 1) - q(x + 1, y), 0};
            const double cosine =
                glm::dot(normal_of(face, scene.camera, x, y), normal_of(*plane, scene.camera, x, y));
            const double angle = std::acos(std::min(cosine, 1.0)) * 57.29577951308232;
            sum += angle * angle;
            ++faces;
        }
    EXPECT_GT(faces, 1000);
    return std::sqrt(sum / faces);
}

/// Degrees RMS: at least with levels in, at most without them.
struct Off {
    double stored, millimetres, measured;
};

void expect_faces_on_planes(const std::filesystem::path& folder, const std::filesystem::path& scene_file,
                            const Off& limits) {
    auto reader = must(open_clip(folder, scene_file));
    Scene scene = reader->scene();
    DepthEstimator estimator(scene);
    const auto first = reader->next();
    ASSERT_TRUE(first && *first);
    estimator.add(**first);
    const DepthLength levels = estimator.measured()->levels;
    scene.filter.fill_holes = 0;
    scene.filter.median = 0;
    const double stored = off_the_planes(**first, scene, levels.quadratic);
    scene.filter.median = 5;
    const double median = off_the_planes(**first, scene, levels.quadratic);
    scene.filter.terraces = TerraceRemoval::on;
    const double millimetres = off_the_planes(**first, scene, levels.quadratic);
    scene.filter.levels = levels;
    const double measured = off_the_planes(**first, scene, levels.quadratic);
    std::printf("degrees RMS: stored %.1f, median %.1f, terraces of millimetres %.1f, of levels %.1f\n",
                stored, median, millimetres, measured);
    EXPECT_GT(stored, limits.stored);
    EXPECT_GT(millimetres, limits.millimetres) << "which is what levels are for";
    EXPECT_LT(measured, limits.measured);
}

TEST(RealLevels, PutFacesOnPlanes) {
    TOUCHABLE_NEEDS_DATA(real_data("stills/redwood5"));
    expect_faces_on_planes(real_data("stills/redwood5"),
                           std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes/redwood5.json",
                           {40, 30, 3});
}

TEST(StandInLevels, PutFacesOnPlanes) {
    const TemporaryFolder folder;
    StandIn what = stand_in("redwood5");
    what.hole_share = 0;  // planes are sought where nothing is missing
    what.frames = 1;
    expect_faces_on_planes(folder.path(), write_stand_in(folder.path(), what), {20, 20, 1});
}

}  // namespace
}  // namespace touchable::test
