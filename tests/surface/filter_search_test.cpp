// Filters are tried on smooth places of a recording, put side by side.
#include "engine/surface/estimators.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/surface/surface_builder.hpp"
#include "tests/frame/random.hpp"

namespace touchable::test {
namespace {

constexpr int picture_width = 320, picture_height = 240;

Scene scene_of_millimetres() {
    Scene scene;
    scene.width = picture_width;
    scene.height = picture_height;
    scene.camera = {300, 300, 159.5, 119.5};
    scene.depth_bits = 16;
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = 1;
    scene.depth.far = 20700;
    scene.depth.code_max = 65535;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    return scene;
}

/// Whole millimetres of a wall that leans.
struct Wall {
    double noise = 0;  ///< standard deviation, mm
    double level = 0;  ///< mm at a metre, of disparity; 0: none
    bool holes = false, strays = false;
    double pens = 0;  ///< mm that pens stand out: columns 5 wide, 80 apart

    static bool is_pen(int x) { return x % 80 >= 40 && x % 80 < 45; }

    CodePicture picture(std::uint64_t seed) const {
        Random random(seed);
        CodePicture picture{picture_width, picture_height, {}};
        for (int y = 0; y < picture_height; ++y)
            for (int x = 0; x < picture_width; ++x) {
                double depth = 1000 / (1 - 0.3 * (x - 159.5) / 300 + 0.2 * (y - 119.5) / 300);
                double sum = -6;
                for (int k = 0; k < 12; ++k) sum += random.below(1 << 16) / 65536.0;
                depth += noise * sum - (is_pen(x) ? pens : 0);
                if (level > 0) {
                    const double step = level * 1e-6;
                    depth = 1 / (step * std::floor(1 / depth / step + 0.5));
                }
                int code = static_cast<int>(depth + 0.5);
                if (strays && random.below(2000) == 0) code = 19700;
                if (holes && random.below(50) == 0) code = CodePicture::invalid;
                picture.codes.push_back(code);
            }
        return picture;
    }
};

std::deque<CodePicture> still_of(const Wall& wall) {
    return {wall.picture(1)};
}

const TriedFilters& unfiltered(const std::vector<TriedFilters>& tried) {
    return *found_among(tried, {});
}

TEST(SmoothPatches, AFittedWallOfWholeMillimetresIsAboutAsRoughAsRounding) {
    const SmoothPatches patches(scene_of_millimetres(), still_of({}));
    ASSERT_TRUE(patches.enough());
    EXPECT_NEAR(patches.roughness().at(patches.median_depth()), 1 / std::sqrt(12.0), 0.06);
    EXPECT_NEAR(patches.median_depth(), 1000, 60);
}

TEST(SmoothPatches, RoughnessIsTheNoiseWhateverIsMissingOrFarBehind) {
    for (const bool spoilt : {false, true}) {
        const SmoothPatches patches(scene_of_millimetres(),
                                    still_of({.noise = 4, .holes = spoilt, .strays = spoilt}));
        ASSERT_TRUE(patches.enough());
        EXPECT_NEAR(patches.roughness().at(patches.median_depth()), 4, 0.4);
    }
}

TEST(SmoothPatches, FacesOfNoiseLeanAsFarAsItSays) {
    for (const double noise : {0.1, 0.3, 1.0}) {
        Scene scene = scene_of_millimetres();
        scene.depth.scale = 0.05;  // finer than all noise
        scene.depth.far = 3000;
        derive_valid_range(scene.depth);
        std::deque<CodePicture> pictures = still_of({});
        Random random(7);
        for (int y = 0; y < picture_height; ++y)
            for (int x = 0; x < picture_width; ++x) {
                double sum = -6;
                for (int k = 0; k < 12; ++k) sum += random.below(1 << 16) / 65536.0;
                pictures[0].codes[static_cast<std::size_t>(y * picture_width + x)] =
                    static_cast<int>(20 * (1000 + noise * sum) + 0.5);
            }
        const SmoothPatches patches(scene, pictures);
        ASSERT_TRUE(patches.enough());
        SurfaceFrame built;
        ASSERT_TRUE(make_reference_builder(patches.mosaic_scene())->build(patches.mosaics().back(), built));
        // Two slopes across each other, each sqrt(2) noise over 10/3 mm.
        const double expected =
            std::atan(std::sqrt(2.0) * std::sqrt(2.0) * noise / (1000.0 / 300)) * 180 / 3.14159265;
        EXPECT_NEAR(patches.faces_off_deg(built), expected, 0.08 * expected) << noise;
    }
}

// Filters of a mosaic do to the middle of a patch's core, of which faces are looked at, what they do to the
// picture.
TEST(SmoothPatches, AreFilteredAsThePictureIs) {
    Scene scene = scene_of_millimetres();
    const std::deque<CodePicture> pictures = still_of({.noise = 2, .level = 3, .holes = true});
    const SmoothPatches patches(scene, pictures);
    ASSERT_TRUE(patches.enough());
    const FilterSettings filter{.median = 5, .terraces = TerraceRemoval::on, .levels = {0, 4e-6}};
    std::vector<std::uint16_t> codes;
    for (const int code : pictures[0].codes)
        codes.push_back(static_cast<std::uint16_t>(code == CodePicture::invalid ? 0 : code));
    RawFrame raw;
    raw.depth = {reinterpret_cast<const std::uint8_t*>(codes.data()),
                 2 * picture_width,
                 picture_width,
                 picture_height,
                 2,
                 1};
    scene.filter = filter;
    Scene mosaic = patches.mosaic_scene();
    mosaic.filter = filter;
    SurfaceFrame whole, built;
    ASSERT_TRUE(make_reference_builder(scene)->build(raw, whole));
    ASSERT_TRUE(make_reference_builder(mosaic)->build(patches.mosaics().back(), built));
    ASSERT_GE(patches.places().size(), 30U);
    for (const auto& [from, to] : patches.places())
        for (int y = SmoothPatches::margin; y <= SmoothPatches::core - SmoothPatches::margin; ++y)
            for (int x = SmoothPatches::margin; x <= SmoothPatches::core - SmoothPatches::margin; ++x) {
                const auto in_mosaic = built.index(to.x + x, to.y + y),
                           in_whole = whole.index(from.x + x, from.y + y);
                ASSERT_EQ(built.codes[in_mosaic], whole.codes[in_whole]) << x << ", " << y;
            }
}

// Of a large picture no more is kept than where a place can lie, which is told by the picture's own pixels.
TEST(SmoothPatches, OfALargePictureAreTheSamePixels) {
    for (const auto& [width, height] : {std::pair{3000, 100}, {100, 3000}, {1600, 1545}}) {
        Scene scene = scene_of_millimetres();
        scene.width = width;
        scene.height = height;
        CodePicture picture{width, height, {}};
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) picture.codes.push_back((10000 + 3 * x + 2 * y) / 10);
        const CodePicture cropped = SmoothPatches::cropped(picture);
        EXPECT_EQ(cropped.width, std::min(width, 1536));
        EXPECT_EQ(cropped.height, std::min(height, 1536));
        const SmoothPatches patches(scene, {cropped});
        ASSERT_TRUE(patches.enough());
        EXPECT_NEAR(patches.roughness().at(patches.median_depth()), 1 / std::sqrt(12.0), 0.06);
        const PlaneView mosaic = patches.mosaics().back().depth;
        constexpr int around = (SmoothPatches::side - SmoothPatches::core) / 2;
        for (const auto& [from, to] : patches.places())
            for (int y = -around; y < SmoothPatches::side - around; ++y)
                for (int x = -around; x < SmoothPatches::side - around; ++x)
                    ASSERT_EQ(mosaic.sample(to.x + x, to.y + y), picture.row(from.y + y)[from.x + x]);
    }
}

// Pens of five times the noise fit into a patch that is about as smooth as the others.
TEST(SmoothPatches, LeaveOutLowRelief) {
    for (const double level : {0.0, 4.0}) {
        const Wall wall{.noise = 2, .level = level, .pens = 10};
        std::deque<CodePicture> pictures;
        for (std::uint64_t n = 1; n <= SmoothPatches::frames; ++n) pictures.push_back(wall.picture(n));
        const SmoothPatches patches(scene_of_millimetres(), pictures);
        ASSERT_TRUE(patches.enough());
        for (const auto& [from, to] : patches.places())
            for (int x = 2; x < SmoothPatches::core - 2; ++x)
                EXPECT_FALSE(Wall::is_pen(from.x + x)) << from.x << " + " << x;
        // Without pens no patch is left out.
        pictures.clear();
        for (std::uint64_t n = 1; n <= SmoothPatches::frames; ++n)
            pictures.push_back(Wall{.noise = 2, .level = level}.picture(n));
        EXPECT_GE(SmoothPatches(scene_of_millimetres(), pictures).places().size(), 60U);
    }
}

// Where relief is everywhere, it is better to judge filters by it than by nothing.
TEST(SmoothPatches, KeepLowReliefWhereNothingElseIs) {
    CodePicture picture = Wall{.noise = 2}.picture(1);
    for (int y = 0; y < picture_height; ++y)
        for (int x = 0; x < picture_width; ++x)
            if (x % 16 < 5) picture.codes[static_cast<std::size_t>(y * picture_width + x)] -= 10;
    EXPECT_TRUE(SmoothPatches(scene_of_millimetres(), {picture}).enough());
}

// A background of one code is the smoothest place of all, and says nothing.
TEST(SmoothPatches, AreNotOfABackgroundOfOneCode) {
    std::deque<CodePicture> pictures = still_of({.level = 12});
    for (int y = 0; y < picture_height; ++y)
        for (int x = 0; x < picture_width / 2; ++x)
            pictures[0].codes[static_cast<std::size_t>(y * picture_width + x)] = 3000;
    const SmoothPatches patches(scene_of_millimetres(), pictures);
    ASSERT_TRUE(patches.enough());
    for (const auto& [from, to] : patches.places())
        EXPECT_GT(from.x + SmoothPatches::core, picture_width / 2);
}

TEST(SmoothPatches, AreTooFewInASmallPictureAndWithoutDepth) {
    Scene scene = scene_of_millimetres();
    EXPECT_FALSE(SmoothPatches(scene, {}).enough());
    CodePicture none{picture_width, picture_height,
                     std::vector<int>(std::size_t{picture_width} * picture_height, CodePicture::invalid)};
    EXPECT_FALSE(SmoothPatches(scene, {none}).enough());
    scene.width = 63;
    CodePicture small{63, 64, std::vector<int>(std::size_t{63} * 64, 1000)};
    EXPECT_FALSE(SmoothPatches(scene, {small}).enough());
}

TEST(FilterSearch, FindsWhatMakesANoisyWallSmooth) {
    const SmoothPatches patches(scene_of_millimetres(), still_of({.noise = 4, .strays = true}));
    const auto tried = tried_filters(patches, {}, {});
    ASSERT_GT(tried.size(), 10U);
    const TriedFilters& best = *mildest_of_the_best(tried, false);
    EXPECT_GT(unfiltered(tried).left_deg, 30);
    EXPECT_LT(best.left_deg, 6);
    EXPECT_TRUE(best.terraces);
    for (std::size_t n = 1; n < tried.size(); ++n) EXPECT_GE(tried[n].harshness, tried[n - 1].harshness);
}

// Filters that smooth pens away leave no less than others, so the mildest is taken.
TEST(FilterSearch, KeepsLowRelief) {
    const auto chosen = [](double pens) {
        std::deque<CodePicture> pictures;
        for (std::uint64_t n = 1; n <= SmoothPatches::frames; ++n)
            pictures.push_back(Wall{.noise = 2, .pens = pens}.picture(n));
        const auto tried = tried_filters(SmoothPatches(scene_of_millimetres(), pictures), {}, {2, 0});
        return *mildest_of_the_best(tried, true);
    };
    const TriedFilters with = chosen(12), without = chosen(0);
    EXPECT_LE(with.harshness, without.harshness);
    EXPECT_LT(with.left_deg, 1.3 * without.left_deg);
}

TEST(FilterSearch, TriesAllWithAndWithoutAveragingWhatIsNoisyFromFrameToFrame) {
    std::deque<CodePicture> pictures;
    for (std::uint64_t n = 1; n <= SmoothPatches::frames; ++n)
        pictures.push_back(Wall{.noise = 4}.picture(n));
    const auto tried = tried_filters(SmoothPatches(scene_of_millimetres(), pictures), {}, {4, 0});
    for (const TriedFilters& one : tried) {
        FilterSettings filter{.median = one.median, .levels = one.levels, .temporal = !one.temporal};
        filter.terraces = one.terraces ? TerraceRemoval::on : TerraceRemoval::off;
        const TriedFilters* const other = found_among(tried, filter);
        ASSERT_NE(other, nullptr);
        if (one.temporal) {
            EXPECT_LT(one.left_deg, other->left_deg) << one.harshness;
        }
    }
    EXPECT_LT(mildest_of_the_best(tried, true)->left_deg, mildest_of_the_best(tried, false)->left_deg);
}

TEST(FilterSearch, TakesLevelsThatWereSeenForWhatTheyAre) {
    const SmoothPatches patches(scene_of_millimetres(), still_of({.level = 12}));
    const auto tried = tried_filters(patches, {0, 12e-6}, {});
    const TriedFilters& best = *mildest_of_the_best(tried, false);
    EXPECT_EQ(best.median, 0);
    EXPECT_TRUE(best.terraces);
    EXPECT_GE(best.levels.quadratic, 12e-6);
    EXPECT_LE(best.levels.quadratic, 1.4001 * 12e-6);
    EXPECT_LT(best.left_deg, 0.1 * unfiltered(tried).left_deg);
}

TEST(FilterSearch, LeavesASmoothWallAlone) {
    Scene scene = scene_of_millimetres();
    scene.depth.scale = 0.05;
    scene.depth.far = 3000;
    derive_valid_range(scene.depth);
    std::deque<CodePicture> pictures = still_of({});
    for (int& code : pictures[0].codes) code *= 20;
    for (int y = 0; y < picture_height; ++y)
        for (int x = 0; x < picture_width; ++x)
            pictures[0].codes[static_cast<std::size_t>(y * picture_width + x)] =
                static_cast<int>(20 * 1000 / (1 - 0.3 * (x - 159.5) / 300) + 0.5);
    const auto tried = tried_filters(SmoothPatches(scene, pictures), {}, {});
    ASSERT_FALSE(tried.empty());
    const TriedFilters& best = *mildest_of_the_best(tried, false);
    EXPECT_EQ(best.median, 0);
    EXPECT_FALSE(best.terraces);
}

TEST(FilterSearch, TellsWhatRemovalAloneDoes) {
    const SmoothPatches patches(scene_of_millimetres(), still_of({.level = 12}));
    const auto tried = tried_removal(patches, {0, 12e-6});
    ASSERT_EQ(tried.size(), 2U);
    EXPECT_LT(tried[1].left_deg, 0.1 * tried[0].left_deg);
    EXPECT_EQ(found_among(tried, {.terraces = TerraceRemoval::on, .levels = {0, 12e-6}}), &tried[1]);
    EXPECT_EQ(found_among(tried, {.median = 5}), nullptr);
}

}  // namespace
}  // namespace touchable::test
