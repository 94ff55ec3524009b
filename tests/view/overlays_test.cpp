// SPDX-License-Identifier: Apache-2.0
// The colours of overlays, against plain code that asks the field for every pixel.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "player/draw/finger_marks.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/overlay_rows.hpp"
#include "player/draw/overlays.hpp"
#include "player/view/view.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

/// Lightness and colour of a colour on screens as eyes see them: OKLab, from sRGB.
glm::dvec3 oklab(PackedColour colour) {
    glm::dvec3 rgb;
    for (int k = 0; k < 3; ++k) {
        const double s = (colour >> (8 * k) & 255U) / 255.0;
        rgb[k] = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    }
    const double l = std::cbrt(0.4122214708 * rgb.r + 0.5363325363 * rgb.g + 0.0514459929 * rgb.b),
                 m = std::cbrt(0.2119034982 * rgb.r + 0.6806995451 * rgb.g + 0.1073969566 * rgb.b),
                 s = std::cbrt(0.0883024619 * rgb.r + 0.2817188376 * rgb.g + 0.6299787005 * rgb.b);
    return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
            1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
            0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

TEST(ColourRamp, LightensEvenlyWithoutGrey) {
    const auto& ramp = colour_ramp();
    const double first = oklab(ramp[0]).x, last = oklab(ramp[255]).x;
    EXPECT_LT(first, 0.3);
    EXPECT_GT(last, 0.92);
    for (std::size_t k = 0; k < ramp.size(); ++k) {
        const glm::dvec3 here = oklab(ramp[k]);
        EXPECT_NEAR(here.x, first + (last - first) * static_cast<double>(k) / 255, 0.002) << k;
        EXPECT_GT(std::hypot(here.y, here.z), 0.055) << k;
        if (k >= 16) {  // a single byte's step is coarse
            EXPECT_NEAR(glm::length(here - oklab(ramp[k - 16])), 16 * 0.0029, 0.004) << k;
        }
    }
    EXPECT_LT(oklab(ramp[0]).z, -0.1) << "blue";
    EXPECT_GT(oklab(ramp[255]).z, 0.1) << "yellow";
    EXPECT_EQ(ramp_colour(-1), ramp[0]);
    EXPECT_EQ(ramp_colour(0.5), ramp[128]);
    EXPECT_EQ(ramp_colour(2), ramp[255]);
}

/// Two frames with holes, heights, properties, and holes that are soft.
struct Painted : Codes {
    explicit Painted(DepthCodingKind kind)
        : Codes(coding_of(kind, DepthSemantics::range, kind != DepthCodingKind::metric), 77, 41, true) {
        SplitMix64 random(11);
        for (SurfaceFrame* frame : {&prev, &next}) {
            frame->haptic.resize(3 * frame->codes.size());
            for (auto& byte : frame->haptic) byte = static_cast<std::uint8_t>(random.next());
        }
        scene.haptic = {{0.2, 3}, {0.1, 0.9}, {0.3, 1.2}};
        scene.hole_stiffness = 0.05;
    }
    /// A field of the first frame alone.
    HeightField field_at(double seconds, std::uint64_t epoch) const {
        const auto time = static_cast<std::int64_t>(1e9 * seconds);
        return {scene, {{0, time, &prev}, {0, time, &prev}, 0, epoch}};
    }
    /// It has these depths in place of its codes and heights.
    void set_prev(const std::vector<double>& depths) {
        prev.heights.clear();
        prev.vertices = std::make_unique<ExactVertices>(77, 41, depths);
    }
};

double value_of(Scalar scalar, const PixelValues& values) {
    switch (scalar) {
        case Scalar::depth:
            return values.depth;
        case Scalar::stiffness:
            return values.properties.stiffness;
        case Scalar::static_friction:
            return values.properties.static_friction;
        case Scalar::dynamic_friction:
            return values.properties.dynamic_friction;
        default:
            return values.height;
    }
}

void expect_values(Scalar scalar, const HeightField& field, const FramePair& pair) {
    ScalarRows rows;
    rows.begin(scalar, field, pair);
    std::vector<float> row(static_cast<std::size_t>(field.width()));
    int holes = 0;
    for (int y = 0; y < field.height(); ++y) {
        rows.read(y, row.data());
        for (int x = 0; x < field.width(); ++x) {
            const float value = row[static_cast<std::size_t>(x)];
            const PixelValues plain = values_at(field, pair, x, y);
            ASSERT_EQ(!std::isnan(value), plain.valid) << x << ", " << y;
            holes += !plain.valid;
            const double right = value_of(scalar, plain);
            if (plain.valid) {
                ASSERT_NEAR(value, right, 2e-6 * std::max(1.0, right)) << x << ", " << y;
            }
        }
    }
    EXPECT_GT(holes, 20);
}

constexpr Scalar scalars[] = {Scalar::depth, Scalar::stiffness, Scalar::static_friction,
                              Scalar::dynamic_friction, Scalar::height};

void expect_values(const Painted& painted) {
    for (const double blend : {0.0, 0.3, 0.7})
        for (const Scalar scalar : scalars) {
            SCOPED_TRACE(static_cast<int>(scalar));
            const FramePair pair = painted.pair(blend);
            expect_values(scalar, HeightField(painted.scene, pair), pair);
        }
}

TEST(ScalarRows, MatchFieldPixelByPixel) {
    for (const auto kind : {DepthCodingKind::linear, DepthCodingKind::inverse, DepthCodingKind::metric}) {
        Painted painted(kind);
        expect_values(painted);
    }
}

TEST(ScalarRows, NeedNoPlanesOrCodes) {
    Painted painted(DepthCodingKind::linear);
    painted.prev.haptic.clear();
    painted.next.heights.clear();
    std::vector<double> depths(painted.prev.codes.size(), 1.5);
    for (std::size_t k = 0; k < depths.size(); k += 7) depths[k] = NAN;
    painted.next.vertices = std::make_unique<ExactVertices>(77, 41, depths);
    expect_values(painted);
}

glm::ivec3 colour_at(const Overlays::Picture& picture, int x, int y) {
    const PlaneView view = picture.view();
    return {view.sample(x, y, 0), view.sample(x, y, 1), view.sample(x, y, 2)};
}
glm::ivec3 channels(PackedColour colour) {
    return {colour & 255U, colour >> 8 & 255U, colour >> 16 & 255U};
}

TEST(Overlays, ColourIsPlaceOnScale) {
    const Painted painted(DepthCodingKind::linear);
    const FramePair pair = painted.pair(0.3);
    const HeightField field(painted.scene, pair);
    const double per_mm = 1 / (painted.scene.metres_per_unit * 1000);
    const struct {
        Overlay kind;
        Scalar scalar;
        double per_unit;
    } kinds[] = {{Overlay::depth_linear, Scalar::depth, per_mm},
                 {Overlay::height, Scalar::height, per_mm},
                 {Overlay::stiffness, Scalar::stiffness, 1000},
                 {Overlay::static_friction, Scalar::static_friction, 1},
                 {Overlay::dynamic_friction, Scalar::dynamic_friction, 1}};
    Overlays overlays;
    for (const auto& [kind, scalar, per_unit] : kinds) {
        const Overlays::Picture& picture = overlays.paint(kind, field, pair);
        EXPECT_GT(picture.scale.range.greatest, picture.scale.range.least);
        if (kind == Overlay::height) {
            EXPECT_EQ(picture.scale.unit, "mm of the scene");
        }
        for (int y = 0; y < field.height(); ++y)
            for (int x = 0; x < field.width(); ++x) {
                const PixelValues plain = values_at(field, pair, x, y);
                const glm::ivec3 seen = colour_at(picture, x, y);
                if (!plain.valid) {
                    ASSERT_EQ(seen, channels(hole_colour(x, y)));
                    continue;
                }
                const double share = picture.scale.share_of(value_of(scalar, plain) / per_unit);
                const glm::ivec3 off = glm::abs(seen - channels(ramp_colour(share)));
                ASSERT_LE(std::max({off.r, off.g, off.b}), 2) << picture.scale.name << x << ", " << y;
            }
    }
}

TEST(Overlays, ErrorsAreThoseOfTheNearerFrame) {
    Painted painted(DepthCodingKind::linear);
    for (SurfaceFrame* frame : {&painted.prev, &painted.next}) {
        frame->signs.columns = (frame->width - 1) / ErrorSigns::side;
        frame->signs.bend = 0.05;
        for (int k = 0; k < frame->signs.columns * ((frame->height - 1) / ErrorSigns::side); ++k)
            frame->signs.blocks.push_back({k % 9 == 0 ? 0.0F : 1.0F, 0,
                                           frame == &painted.prev ? 1e-4F * static_cast<float>(k) : 0.3F, 1});
    }
    for (const double blend : {0.3, 0.7}) {
        const FramePair pair = painted.pair(blend);
        const HeightField field(painted.scene, pair);
        Overlays overlays;
        const Overlays::Picture& picture = overlays.paint(Overlay::errors, field, pair);
        EXPECT_EQ(picture.scale.unit, "degrees");
        EXPECT_EQ(picture.scale.range.greatest > picture.scale.range.least, blend < 0.5);
        for (int y = 0; y < field.height(); ++y)
            for (int x = 0; x < field.width(); ++x) {
                const double degrees = field.error_bar(x, y).degrees;
                const glm::ivec3 seen = colour_at(picture, x, y);
                if (!values_at(field, pair, x, y).valid || std::isnan(degrees)) {
                    ASSERT_EQ(seen, channels(hole_colour(x, y)));
                    continue;
                }
                const glm::ivec3 off =
                    glm::abs(seen - channels(ramp_colour(picture.scale.share_of(degrees))));
                ASSERT_LE(std::max({off.r, off.g, off.b}), 2) << x << ", " << y;
            }
    }
}

TEST(Overlays, ErrorsAreNotKnownWithoutBars) {
    Painted painted(DepthCodingKind::linear);
    const FramePair pair = painted.pair(0);
    Overlays overlays;
    const Overlays::Scale scale =
        overlays.paint(Overlay::errors, HeightField(painted.scene, pair), pair).scale;
    ASSERT_EQ(scale.classes.size(), 1U);
    EXPECT_EQ(scale.classes[0].words, "not known");
    EXPECT_EQ(scale.everywhere(), "");
}

TEST(Overlays, DepthScaleOmitsOutliers) {
    Painted painted(DepthCodingKind::linear);
    const DepthCoding& coding = painted.scene.depth;
    std::vector<double> depths(painted.prev.codes.size());
    for (std::size_t k = 0; k < depths.size(); ++k)
        depths[k] = k % 2 == 0 ? coding.far : coding.near * (2 + static_cast<double>(k % 400) / 400);
    depths[0] = coding.near;
    painted.set_prev(depths);
    const FramePair pair = painted.pair(0);
    Overlays overlays;
    const Overlays::Scale& scale =
        overlays.paint(Overlay::depth_linear, HeightField(painted.scene, pair), pair).scale;
    const double unit = painted.scene.metres_per_unit * (scale.unit == "m" ? 1 : 1000);
    EXPECT_NEAR(scale.range.least, 2 * coding.near * unit, 0.02 * coding.near * unit);
    EXPECT_NEAR(scale.range.greatest, 3 * coding.near * unit, 0.02 * coding.near * unit);
    EXPECT_TRUE(scale.is_less && scale.is_more) << "there are some that its ends do not tell";
}

TEST(Overlays, ConstantValueIsOneColour) {
    for (const bool has_soft_holes : {false, true}) {
        Painted painted(DepthCodingKind::linear);
        painted.prev.haptic.clear();
        if (!has_soft_holes) painted.scene.hole_stiffness.reset();
        const FramePair pair = painted.pair(0);
        Overlays overlays;
        const Overlays::Picture& picture =
            overlays.paint(Overlay::stiffness, HeightField(painted.scene, pair), pair);
        if (!has_soft_holes) {
            EXPECT_EQ(picture.scale.range, (Overlays::Range{0.6, 0.6}));
        }
        EXPECT_EQ(picture.scale.everywhere(), std::string("0.6 N/mm everywhere: this clip has no map") +
                                                  (has_soft_holes ? "; 0.05 N/mm at holes" : ""));
        for (int x = 0; x < 77; ++x)
            if (painted.prev.is_valid(x, 20)) {
                EXPECT_EQ(colour_at(picture, x, 20), channels(ramp_colour(0.5)));
            }
    }
}

TEST(Overlays, TellsMapFromDefault) {
    Painted painted(DepthCodingKind::linear);
    painted.scene.hole_stiffness.reset();
    std::fill(painted.prev.haptic.begin(), painted.prev.haptic.end(), std::uint8_t{255});
    painted.prev.heights.clear();
    const FramePair pair{{0, 0, &painted.prev}, {0, 0, &painted.prev}, 0, 0};
    const HeightField field(painted.scene, pair);
    Overlays overlays;
    EXPECT_EQ(overlays.paint(Overlay::stiffness, field, pair).scale.everywhere(), "3 N/mm everywhere");
    EXPECT_EQ(overlays.paint(Overlay::static_friction, field, pair).scale.everywhere(), "0.9 everywhere");
    EXPECT_EQ(overlays.paint(Overlay::height, field, pair).scale.everywhere(),
              "0 mm of the scene everywhere: this clip has no map");
    EXPECT_EQ(overlays.paint(Overlay::depth, field, pair).scale.everywhere(), "");
    EXPECT_EQ(overlays.paint(Overlay::tiles, field, pair).scale.everywhere(), "");
}

/// Where every twelfth pixel is forty times as far away as the others.
struct WithOutliers : Painted {
    WithOutliers() : Painted(DepthCodingKind::linear) {
        std::vector<double> depths(prev.codes.size());
        for (std::size_t k = 0; k < depths.size(); ++k)
            depths[k] = k % 12 == 0 ? 60 : 0.5 + 0.001 * static_cast<double>(k % 1000);
        set_prev(depths);
    }
    /// Places on the ramp of each pixel, 0 (dark) to 255.
    std::vector<int> places(Overlay kind, Overlays::Scale& scale) const {
        const FramePair once{{0, 0, &prev}, {0, 0, &prev}, 0, 0};
        Overlays overlays;
        const Overlays::Picture& picture = overlays.paint(kind, HeightField(this->scene, once), once);
        scale = picture.scale;
        std::vector<int> places;
        for (int y = 0; y < 41; ++y)
            for (int x = 0; x < 77; ++x) {
                const glm::ivec3 seen = colour_at(picture, x, y);
                const auto& ramp = colour_ramp();
                const auto at = std::find(
                    ramp.begin(), ramp.end(),
                    pack_colour(static_cast<std::uint32_t>(seen.r), static_cast<std::uint32_t>(seen.g),
                                static_cast<std::uint32_t>(seen.b)));
                places.push_back(static_cast<int>(at - ramp.begin()));
            }
        return places;
    }
};

TEST(Overlays, EqualisedDepthKeepsContrast) {
    const WithOutliers painted;
    Overlays::Scale equalised, linear;
    const std::vector<int> places = painted.places(Overlay::depth, equalised),
                           even = painted.places(Overlay::depth_linear, linear);
    int least = 255, greatest = 0, least_even = 255, greatest_even = 0;
    std::array<int, 8> counts{};
    for (std::size_t k = 0; k < places.size(); ++k) {
        ASSERT_LT(places[k], 256) << "no colour of the ramp";
        ++counts[static_cast<std::size_t>(places[k] / 32)];
        if (k % 12 == 0) continue;
        least = std::min(least, places[k]);
        greatest = std::max(greatest, places[k]);
        least_even = std::min(least_even, even[k]);
        greatest_even = std::max(greatest_even, even[k]);
        if (k > 12 && (k - 1) % 12 != 0 && k % 1000 != 0) {
            ASSERT_LE(places[k], places[k - 1]) << "what is farther is not lighter";
        }
    }
    EXPECT_GT(greatest - least, 220);
    EXPECT_LT(greatest_even - least_even, 8);
    for (const int count : counts)
        EXPECT_NEAR(count, static_cast<double>(places.size()) / 8, 0.05 * static_cast<double>(places.size()));
    EXPECT_EQ(equalised.spread, "equalised");
    EXPECT_EQ(linear.spread, "linear, 1 to 99 %");
    EXPECT_EQ(equalised.range, linear.range) << "the ends are the same";
    ASSERT_EQ(equalised.levels.size(), 5U);
    EXPECT_EQ(equalised.levels.front(), equalised.range.least);
    EXPECT_EQ(equalised.levels.back(), equalised.range.greatest);
    // The middle is half-way between the ranks of the ends: 1 %, and the middle of the farthest twelfth.
    std::vector<double> depths;
    for (std::size_t k = 0; k < places.size(); ++k)
        depths.push_back(painted.prev.vertices->at(static_cast<int>(k % 77), static_cast<int>(k / 77)).depth);
    std::sort(depths.begin(), depths.end());
    const double rank = (0.01 + 1 - 1.0 / 24) / 2, unit = equalised.range.greatest / 60;
    EXPECT_NEAR(equalised.levels[2] / unit,
                depths[static_cast<std::size_t>(rank * static_cast<double>(depths.size()))], 0.003);
}

TEST(EqualisedDepth, AdaptsWithinASecond) {
    const Painted painted(DepthCodingKind::linear);
    const std::vector<float> near(100, 1.0F), far(100, 2.0F);
    const auto near_share = [](const EqualisedDepth& depth) {
        const float one = 1.0F;
        std::uint32_t bin = 0;
        depth.find_bins(&one, 1, &bin);
        return 2 * depth.share_of_bin(bin);  // half of them are told as nearer
    };
    EqualisedDepth depth;
    depth.update(near, painted.field_at(0, 0));
    EXPECT_NEAR(near_share(depth), 1, 1e-5);
    depth.update(far, painted.field_at(0, 0));
    EXPECT_NEAR(near_share(depth), 1, 1e-5) << "paused";
    depth.update(far, painted.field_at(0.1, 0));
    EXPECT_NEAR(near_share(depth), 1 - 0.1 / EqualisedDepth::adapting_s, 1e-5);
    depth.update(far, painted.field_at(9, 0));
    EXPECT_NEAR(near_share(depth), 0, 1e-5);
    depth.update(near, painted.field_at(9, 1));
    EXPECT_NEAR(near_share(depth), 1, 1e-5) << "another epoch";
    EXPECT_NEAR(depth.depth_at(0.4), 1, 1.0 / 4096);
    const float none = std::numeric_limits<float>::quiet_NaN();
    std::uint32_t bin = 0;
    depth.find_bins(&none, 1, &bin);
    EXPECT_EQ(bin, depth.bins());
}

TEST(Overlays, PlaneNormalsAreExact) {
    Painted painted(DepthCodingKind::linear);
    painted.prev.codes.clear();
    painted.scene.depth.semantics = DepthSemantics::planar;
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));
    const Camera& camera = painted.scene.camera;
    std::vector<double> depths;
    for (int y = 0; y < 41; ++y)
        for (int x = 0; x < 77; ++x) {
            const double depth = -1 / glm::dot(normal, glm::dvec3(camera.u(x), camera.v(y), -1));
            depths.push_back(x < 40 ? depth : 1.5 * depth);  // a step, which is no slope
        }
    painted.set_prev(depths);
    const FramePair pair = painted.pair(0);
    Overlays overlays;
    const Overlays::Picture& picture =
        overlays.paint(Overlay::normals, HeightField(painted.scene, pair), pair);
    for (int y = 0; y < 41; ++y)
        for (int x = 0; x < 77; ++x) {
            const glm::dvec3 seen = (glm::dvec3(colour_at(picture, x, y)) - 127.5) / 127.5;
            ASSERT_LT(glm::length(seen - normal), 0.01) << x << ", " << y;
        }
}

TEST(Overlays, TilesMatchDrawing) {
    const Painted painted(DepthCodingKind::linear);
    std::vector<double> depths(77 * 41, 2.0);
    for (int y = 0; y < 41; ++y)
        for (int x = 20; x < 77; ++x) depths[static_cast<std::size_t>(y * 77 + x)] = x < 50 ? 3.0 : NAN;
    SurfaceFrame frame;
    frame.width = 77;
    frame.height = 41;
    frame.vertices = std::make_unique<ExactVertices>(77, 41, depths);
    const FramePair pair{{0, 0, &frame}, {0, 0, &frame}, 0, 0};
    const HeightField field(painted.scene, pair);
    Overlays overlays;
    const Overlays::Picture& picture = overlays.paint(Overlay::tiles, field, pair);
    const ViewSurface::Tiles tiles = classify_tiles(77, 41, q_of(field));
    ASSERT_FALSE(tiles.whole.empty() || tiles.mixed.empty());
    const auto holds = [](const std::vector<std::uint32_t>& some, std::uint32_t tile) {
        return std::count(some.begin(), some.end(), tile) > 0;
    };
    for (std::uint32_t tile = 0; tile < 15; ++tile) {
        const int x = static_cast<int>(tile % 5) * 16 + 5, y = static_cast<int>(tile / 5) * 16 + 5;
        const glm::ivec3 seen = colour_at(picture, x, y);
        EXPECT_EQ(seen == channels(picture.scale.classes[0].colour), holds(tiles.whole, tile)) << tile;
        EXPECT_EQ(seen == channels(picture.scale.classes[1].colour), holds(tiles.mixed, tile)) << tile;
    }
}

TEST(Overlays, ValidityTellsHolesAndRims) {
    const Painted painted(DepthCodingKind::linear);
    for (const double blend : {0.0, 0.3, 0.7}) {
        const FramePair pair = painted.pair(blend);
        const HeightField field(painted.scene, pair);
        Overlays overlays;
        const Overlays::Picture& picture = overlays.paint(Overlay::validity, field, pair);
        const auto& classes = picture.scale.classes;
        ASSERT_EQ(classes.size(), blend > 0 ? 3U : 2U);
        for (int y = 0; y < 41; ++y)
            for (int x = 0; x < 77; ++x) {
                bool rim = false;
                for (int j = std::max(0, y - 1); j <= std::min(40, y + 1); ++j)
                    for (int i = std::max(0, x - 1); i <= std::min(76, x + 1); ++i)
                        rim = rim || !field.vertex(i, j).valid;
                const bool once = blend > 0 && painted.prev.is_valid(x, y) != painted.next.is_valid(x, y);
                const PackedColour right = !field.vertex(x, y).valid ? hole_colour(x, y)
                                           : once                    ? classes[2].colour
                                                                     : classes[rim ? 1 : 0].colour;
                ASSERT_EQ(colour_at(picture, x, y), channels(right)) << x << ", " << y;
            }
    }
}

/// At the moment of a frame, and between it and one that was given none.
TEST(Overlays, ValidityMarksFilledDepth) {
    Painted painted(DepthCodingKind::linear);
    auto bits = std::make_shared<std::vector<std::uint32_t>>(std::size_t{3} * 41);
    const auto is_given = [](int x, int y) { return (x + 3 * y) % 7 == 0; };
    for (int y = 0; y < 41; ++y)
        for (int x = 0; x < 77; ++x)
            if (is_given(x, y)) (*bits)[static_cast<std::size_t>(3 * y + x / 32)] |= 1U << (x % 32);
    painted.prev.filled = bits;
    for (const double blend : {0.0, 0.3, 0.7}) {
        const FramePair pair = painted.pair(blend);
        const HeightField field(painted.scene, pair);
        Overlays overlays;
        const Overlays::Picture& picture = overlays.paint(Overlay::validity, field, pair);
        const auto& last = picture.scale.classes.back();
        EXPECT_EQ(last.words, "depth of another frame");
        int given = 0;
        for (int y = 0; y < 41; ++y)
            for (int x = 0; x < 77; ++x) {
                const bool right = field.vertex(x, y).valid && is_given(x, y) && painted.prev.is_valid(x, y);
                ASSERT_EQ(colour_at(picture, x, y) == channels(last.colour), right) << x << ", " << y;
                given += right;
            }
        EXPECT_GT(given, 100);
    }
}

TEST(SteadyRange, NarrowsSlowly) {
    const Painted painted(DepthCodingKind::linear);
    SteadyRange range;
    EXPECT_EQ(range.update({2, 5}, painted.field_at(0, 0)), (Overlays::Range{2, 5}));
    EXPECT_EQ(range.update({1, 9}, painted.field_at(0.033, 0)), (Overlays::Range{1, 9}));
    EXPECT_EQ(range.update({2, 5}, painted.field_at(0.033, 0)), (Overlays::Range{1, 9})) << "paused";
    const Overlays::Range soon = range.update({2, 5}, painted.field_at(0.233, 0));
    EXPECT_NEAR(soon.least, 1.1, 1e-9);
    EXPECT_NEAR(soon.greatest, 8.6, 1e-9);
    for (int k = 1; k < 300; ++k) range.update({2, 5}, painted.field_at(0.233 + 0.033 * k, 0));
    EXPECT_NEAR(range.update({2, 5}, painted.field_at(11, 0)).greatest, 5, 0.05);
    EXPECT_EQ(range.update({3, 4}, painted.field_at(0, 1)), (Overlays::Range{3, 4})) << "another epoch";
}

TEST(Overlays, LightDependsOnKind) {
    const Painted painted(DepthCodingKind::linear);
    const FramePair pair = painted.pair(0);
    const HeightField field(painted.scene, pair);
    Overlays overlays;
    for (const auto kind : {Overlay::depth, Overlay::depth_linear, Overlay::stiffness}) {
        const Overlays::Picture& picture = overlays.paint(kind, field, pair);
        const std::vector<PackedColour> lit = make_view_surface(field, picture.view()).colours;
        const ViewSurface surface = make_view_surface(field, picture.view(), light_of(kind));
        for (std::size_t k = 0; k < lit.size(); ++k) {
            const glm::ivec3 flat(picture.rgb[3 * k], picture.rgb[3 * k + 1], picture.rgb[3 * k + 2]);
            const glm::ivec3 drawn = channels(surface.colours[k]), in_light = channels(lit[k]);
            if (kind != Overlay::stiffness) {
                ASSERT_EQ(drawn, flat);
                continue;
            }
            for (int c = 0; c < 3; ++c)
                if (in_light[c] < 255) {
                    ASSERT_NEAR(drawn[c], 0.5 * (flat[c] + in_light[c]), 1);
                }
        }
    }
}

// The panel that explains fingers in a picture.

constexpr std::pair<int, int> sizes[] = {{480, 270}, {1280, 720}, {3840, 2160}, {600, 1800}};

Image grey(int width, int height) {
    Image image{width, height, 1, 3, {}};
    image.samples.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, 100);
    return image;
}

bool has_colour(const Image& image, PackedColour colour) {
    for (std::size_t k = 0; k < image.samples.size(); k += 3)
        if (pack_colour(image.samples[k], image.samples[k + 1], image.samples[k + 2]) == colour) return true;
    return false;
}

TEST(Legend, ScaleIsRoundAndFits) {
    EXPECT_DOUBLE_EQ(scale_newtons(50, 76), 1);
    EXPECT_DOUBLE_EQ(scale_newtons(30, 76), 2);
    EXPECT_DOUBLE_EQ(scale_newtons(15.2, 76), 5);
    EXPECT_DOUBLE_EQ(scale_newtons(800, 76), 0.05);
    EXPECT_DOUBLE_EQ(scale_newtons(0.3, 76), 200);
    for (double pixels = 0.01; pixels < 1e4; pixels *= 1.07) {
        const double length = scale_newtons(pixels, 76) * pixels;
        EXPECT_LE(length, 76 * (1 + 1e-12));
        EXPECT_GT(length, 76 / 2.6);
    }
}

TEST(Legend, NamesPresentFingers) {
    for (const std::size_t fingers : {1U, 5U, 10U, 200U}) {
        Image image = grey(1280, 720);
        ASSERT_TRUE(draw_legend({fingers, 60}, image));
        for (std::size_t k = 0; k < 10; ++k) EXPECT_EQ(has_colour(image, finger_colour(k)), k < fingers) << k;
    }
}

/// The tenth finger's number has two digits, of which each is 9 pixels wide.
TEST(Legend, CountsFingersFromOne) {
    Image nine = grey(900, 720), ten = nine;
    ASSERT_TRUE(draw_legend({9, 60}, nine) && draw_legend({10, 60}, ten));
    int first = 900, last = 0;
    for (int y = 0; y < 720; ++y)
        for (int x = 0; x < 900; ++x)
            if (nine.view().sample(x, y, 1) != ten.view().sample(x, y, 1))
                first = std::min(first, x), last = std::max(last, x);
    EXPECT_GT(last - first, 30) << "dot, and 10";
    EXPECT_LT(last - first, 40);
}

TEST(Legend, StaysInItsCorner) {
    for (const auto& [width, height] : sizes) {
        Image image = grey(width, height);
        ASSERT_TRUE(draw_legend({10, 60}, image));
        EXPECT_FALSE(std::all_of(image.samples.begin(), image.samples.end(), [](int s) { return s == 100; }));
        for (int y = 0; y < height / 3; ++y) EXPECT_EQ(image.view().sample(5, y, 0), 100);
        for (int y = 0; y < height; ++y)
            for (const int x : {0, width - 1}) ASSERT_EQ(image.view().sample(x, y, 0), 100) << x << ", " << y;
    }
}

TEST(Legend, IsOmittedInSmallPictures) {
    Image image = grey(479, 300);
    ASSERT_TRUE(draw_legend({3, 60}, image));
    EXPECT_EQ(image.samples, grey(479, 300).samples);
}

std::string joined(const std::vector<ScaleMark>& marks) {
    std::string words;
    for (const ScaleMark& mark : marks) words += mark.text + " ";
    return words;
}

TEST(ScaleBar, NamesRoundValues) {
    const auto five = [](const auto& marks) { return marks.size() <= 5; };
    EXPECT_EQ(joined(scale_marks({64, 96}, five)), "70 80 90 ");
    EXPECT_EQ(joined(scale_marks({0, 0.55}, five)), "0.0 0.2 0.4 ");
    EXPECT_EQ(joined(scale_marks({-1, 1}, five)), "-1.0 -0.5 0.0 0.5 1.0 ");
    EXPECT_EQ(joined(scale_marks({1234.21, 1234.24}, five)), "1234.21 1234.22 1234.23 1234.24 ");
    EXPECT_EQ(scale_marks({3, 8}, [](const auto&) { return false; }).size(), 1U);
    for (double size = 1e-3; size < 1e6; size *= 1.37) {
        const Overlays::Range range{0.7 * size, 1.7 * size};
        const auto marks = scale_marks(range, five);
        EXPECT_GE(marks.size(), 2U) << size;
        for (const ScaleMark& mark : marks) {
            EXPECT_GE(mark.value, range.least * (1 - 1e-6));
            EXPECT_LE(mark.value, range.greatest * (1 + 1e-6));
            EXPECT_NEAR(std::stod(mark.text), mark.value, 1e-6 * size);
        }
    }
}

TEST(ScaleBar, ShowsItsColours) {
    Overlays::Scale scale{.name = "depth", .unit = "mm", .range = {64, 96}, .least_is_light = true};
    Image image = grey(1280, 720);
    ASSERT_TRUE(draw_scale_bar(scale, image));
    for (std::size_t k = 0; k < 256; k += 5) EXPECT_TRUE(has_colour(image, colour_ramp()[k])) << k;
    image = grey(1280, 720);
    scale.range = {3, 3};
    ASSERT_TRUE(draw_scale_bar(scale, image));
    EXPECT_TRUE(has_colour(image, ramp_colour(0.5)));
    EXPECT_FALSE(has_colour(image, ramp_colour(0)));
    image = grey(1280, 720);
    scale.classes = {{pack_colour(1, 2, 3), "this"}, {pack_colour(250, 3, 4), "that"}};
    ASSERT_TRUE(draw_scale_bar(scale, image));
    for (const auto& one : scale.classes) EXPECT_TRUE(has_colour(image, one.colour));
}

TEST(ScaleBar, StaysInItsCorner) {
    const Overlays::Scale scale{.name = "dynamic friction", .range = {-1234.5, 98765.4}};
    for (const auto& [width, height] : sizes) {
        Image image = grey(width, height);
        ASSERT_TRUE(draw_scale_bar(scale, image));
        EXPECT_FALSE(std::all_of(image.samples.begin(), image.samples.end(), [](int s) { return s == 100; }));
        for (int y = 0; y < height; ++y)
            for (const int x : {0, width / 5, width - 1})
                ASSERT_EQ(image.view().sample(x, y, 0), 100) << x << ", " << y;
        for (int x = 0; x < width; ++x)
            for (const int y : {0, height / 2, height - 1})
                ASSERT_EQ(image.view().sample(x, y, 0), 100) << x << ", " << y;
    }
    Image small = grey(479, 300);
    ASSERT_TRUE(draw_scale_bar(scale, small));
    EXPECT_EQ(small.samples, grey(479, 300).samples);
}

}  // namespace
}  // namespace touchable::test
