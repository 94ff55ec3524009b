// What is measured of a recording, against the numbers of docs/conventions.md (plain_estimator), over random
// pictures that come near to each of them; and from where on it tells of a camera.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "engine/content/seeded_noise.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/plain_estimator.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

/// Codes from 600 to 4000, 1 unit or about it apart, 0 being none.
DepthCoding coding_of_codes(SplitMix64& random) {
    DepthCoding coding;
    coding.semantics = DepthSemantics::planar;
    coding.near = 500;
    coding.far = 4000;
    coding.code_max = 4000;
    coding.invalid_code_count = 1;
    const auto kind = random.next() % 4;
    coding.kind = kind < 2    ? DepthCodingKind::metric
                  : kind == 2 ? DepthCodingKind::linear
                              : DepthCodingKind::inverse;
    coding.scale = kind == 0 ? 1 : 0.2;
    coding.near_is_high = random.next() % 2 == 0;
    if (coding.kind == DepthCodingKind::metric) coding.far = 4000 * coding.scale;
    if (coding.kind == DepthCodingKind::metric) coding.near = 0;
    derive_valid_range(coding);
    return coding;
}

double normal_number(SplitMix64& random) {
    double sum = -6;
    for (int n = 0; n < 12; ++n) sum += random.unit();
    return sum;
}

/// Stripes that differ in depth by about as much as an edge does; each with noise, drift, outliers, waves and
/// holes of its own.
std::vector<CodePicture> any_recording(SplitMix64& random, int width, int height) {
    struct Stripe {
        int end;
        double code, noise, drift, wave, outliers, farthest, holes, dropouts;
    };
    std::vector<Stripe> stripes;
    const bool is_wide = random.next() % 2 == 0;
    const double drift = random.next() % 3 == 0 ? 0 : random.within(0, 1.2);  // times the noise
    for (int x = 0; x < width;) {
        x += static_cast<int>(is_wide ? random.within(6, 40) : random.within(1, 14));
        const double before = stripes.empty() ? random.within(700, 3000) : stripes.back().code;
        const double code = std::clamp(before * (1 + random.within(-0.12, 0.12)), 620.0, 3900.0);
        const double noise = random.next() % 4 == 0 ? random.within(0, 0.6) : random.within(0, 0.02 * code);
        stripes.push_back({x, code, noise, random.next() % 2 == 0 ? drift * noise : 0,
                           random.next() % 2 == 0 ? 0 : random.within(0, 0.15 * code),
                           random.next() % 2 == 0 ? 0 : random.within(0, 0.5), random.within(0, 0.4),
                           random.next() % 2 == 0 ? 0 : random.within(0, 0.1),
                           random.next() % 2 == 0 ? 0 : random.within(0, 0.1)});
    }
    std::vector<CodePicture> pictures(3 + random.next() % 2);
    std::vector<bool> hole;
    for (int k = 0; k < width * height; ++k) {
        const auto of = std::find_if(stripes.begin(), stripes.end(),
                                     [&](const Stripe& stripe) { return k % width < stripe.end; });
        hole.push_back(random.unit() < of->holes);
    }
    SplitMix64 others = random;  // pictures that are no film sway
    const double sway = others.next() % 4 == 0 ? others.within(0, 0.1) : 0;
    for (std::size_t n = 0; n < pictures.size(); ++n) {
        const double sways = n % 2 == 0 ? 1 + sway : 1 - sway;
        pictures[n] = {width, height, {}};
        for (int k = 0; k < width * height; ++k) {
            const auto of = std::find_if(stripes.begin(), stripes.end(),
                                         [&](const Stripe& stripe) { return k % width < stripe.end; });
            double code = of->code + of->noise * normal_number(random) + of->drift * static_cast<double>(n);
            code += of->wave * random.unit() * (k % 3 == 0);
            if (random.unit() < of->outliers) code *= 1 + random.within(-of->farthest, of->farthest);
            code *= sways;
            const bool none = hole[static_cast<std::size_t>(k)] || random.unit() < of->dropouts;
            pictures[n].codes.push_back(none ? CodePicture::invalid
                                             : static_cast<int>(std::clamp(code + 0.5, 1.0, 4000.0)));
        }
    }
    return pictures;
}

void expect_near(const DepthLength& found, const DepthLength& plain, const char* what) {
    EXPECT_NEAR(found.constant, plain.constant, 1e-9 * plain.constant) << what;
    EXPECT_NEAR(found.quadratic, plain.quadratic, 1e-9 * plain.quadratic) << what;
}

TEST(EstimatorRules, NoiseAndHolesAreMeasuredAsThePageSays) {
    const int rounds = 400 / static_cast<int>(sweep_step());
    SplitMix64 random(29);
    std::map<std::string, int> decided;
    int noisy = 0, rough = 0;
    for (int round = 0; round < rounds && !testing::Test::HasFailure(); ++round) {
        SCOPED_TRACE(round);
        const DepthCoding coding = coding_of_codes(random);
        const auto pictures = any_recording(random, static_cast<int>(40 + random.next() % 60), 30);
        const PlainEstimator plain = plain_estimator(coding, pictures);
        NoiseEstimator estimator(coding);
        for (const CodePicture& picture : pictures) estimator.add(picture);
        expect_near(estimator.noise(NoiseEstimator::Place::flat), plain.noise_at_flat,
                    "noise at flat places");
        expect_near(estimator.noise(NoiseEstimator::Place::edge), plain.noise_at_edges, "noise at edges");
        expect_near(estimator.noise(NoiseEstimator::Place::rim), plain.noise_at_rims, "noise at rims");
        expect_near(estimator.roughness(), plain.roughness, "roughness");
        EXPECT_EQ(estimator.dropouts(), plain.dropouts);
        EXPECT_EQ(estimator.tiny_holes(), plain.tiny_holes);
        EXPECT_EQ(estimator.flying(), plain.flying);
        EXPECT_EQ(estimator.midway(), plain.midway);
        EXPECT_EQ(estimator.clean_edges(), plain.clean_edges);
        for (const std::string& rule : plain.decided) ++decided[rule];
        noisy += plain.noise_at_flat != DepthLength{};
        rough += plain.roughness != DepthLength{};
    }
    EXPECT_GT(noisy, rounds * 3 / 8);
    EXPECT_GT(rough, rounds * 3 / 4);
    for (const char* rule : {"fewer than 200 pixels", "more than half is left out", "not noisy",
                             "less than half is noisy", "noise has no constant", "noise does not grow",
                             "flying", "flying on a ramp", "midway", "clean edge", "unrelated pictures"})
        EXPECT_GT(decided[rule], rounds / 20) << rule;
}

/// 1200 pixels at 1000 mm with noise, of which `share` were 200 mm, more than a tenth, farther in the first
/// frame.
DepthLength noise_of_what_is_left(double share) {
    DepthCoding coding;
    coding.kind = DepthCodingKind::metric;
    coding.scale = 1;
    coding.far = 4000;
    coding.code_max = 4000;
    const int width = 42, height = 32;
    SplitMix64 random(43);
    NoiseEstimator estimator(coding);
    for (int n = 0; n < 3; ++n) {
        CodePicture picture{width, height, {}};
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const bool was_farther = n == 0 && (x - 1) + 40 * (y - 1) < share * 1200;
                picture.codes.push_back((was_farther ? 1200 : 1000) + static_cast<int>(random.next() % 9));
            }
        estimator.add(picture);
    }
    return estimator.noise(NoiseEstimator::Place::flat);
}

TEST(EstimatorRules, AWindowOfWhichMoreThanHalfIsLeftOutSaysNothing) {
    for (const double share : {0.4, 0.5}) {
        // Of nine even numbers the standard deviation is 2.58.
        EXPECT_NEAR(noise_of_what_is_left(share).constant, 2.58, 0.15) << share;
    }
    for (const double share : {0.51, 0.6}) EXPECT_EQ(noise_of_what_is_left(share), DepthLength{}) << share;
}

TEST(EstimatorRules, APlaneHasNeitherNoiseNorRoughness) {
    DepthCoding coding;
    coding.kind = DepthCodingKind::metric;
    coding.scale = 1;
    coding.far = 4000;
    coding.code_max = 4000;
    NoiseEstimator estimator(coding);
    for (int n = 0; n < 3; ++n) estimator.add({40, 30, std::vector<int>(40 * 30, 1000)});
    EXPECT_EQ(estimator.noise(NoiseEstimator::Place::flat), DepthLength{});
    EXPECT_EQ(estimator.roughness(), DepthLength{});
}

// Larger pictures than 640x480 are looked at in some of their rows.
TEST(EstimatorRules, OfLargePicturesSomeRowsAreLookedAt) {
    SplitMix64 random(31);
    const DepthCoding coding = coding_of_codes(random);
    // Every row, every second, every third.
    const std::vector<int> heights = sweep_step() == 1 ? std::vector{959, 960, 1441} : std::vector{960};
    for (const int height : heights) {
        std::vector<CodePicture> pictures(3);
        for (CodePicture& picture : pictures) {
            picture = {640, height, {}};
            for (int k = 0; k < 640 * height; ++k) {
                const bool none = random.next() % 50 == 0;
                picture.codes.push_back(none ? CodePicture::invalid
                                             : static_cast<int>(1500 + random.next() % 8));
            }
        }
        const PlainEstimator plain = plain_estimator(coding, pictures);
        NoiseEstimator estimator(coding);
        for (const CodePicture& picture : pictures) estimator.add(picture);
        EXPECT_EQ(estimator.tiny_holes(), plain.tiny_holes) << height;
        EXPECT_EQ(estimator.dropouts(), plain.dropouts) << height;
        expect_near(estimator.roughness(), plain.roughness, "roughness");
    }
}

/// Patches of levels; how far apart these are, how many pixels they have and how wide patches are is near to
/// what decides.
CodePicture any_levels(SplitMix64& random) {
    const int width = 60, height = 40;
    // Evenly, with depth squared, about one of these, none, as of floats.
    const auto rule = std::min<std::uint64_t>(random.next() % 7, 4);
    const double gap = random.within(3, 14), exponent = rule == 0 ? 0 : 2, wrong = rule == 2 ? 0.5 : 0.1;
    const auto digits = static_cast<double>(6 + random.next() % 3);
    std::vector<int> levels;
    const int windows = static_cast<int>(2 + random.next() % 4);
    double code = random.within(600, 1200);
    for (int n = 0; n < windows; ++n, code *= random.within(1.15, 1.4)) {
        const int count = static_cast<int>(2 + random.next() % (rule == 4 ? 19 : 7));
        double level = code;
        for (int k = 0; rule == 4 && k < count; ++k) {
            const double step = std::exp2(std::max(0.0, std::floor(std::log2(level)) - digits));
            level = step * std::floor(level / step);
            levels.push_back(static_cast<int>(level));
            level += step;
        }
        if (rule == 4) continue;
        const double off = 1 + random.within(-wrong, wrong);
        for (int k = 0; k < count; ++k) {
            levels.push_back(static_cast<int>(level));
            const double step = off * gap * std::pow(level / 1500, exponent);
            level += rule == 3 ? random.within(1, 30) : std::max(1.0, step);
        }
    }
    const bool is_near = random.next() % 2 == 0;  // to a seventh
    const double wide = random.within(is_near ? 0.05 : 0, is_near ? 0.2 : 0.5);
    const double tall = random.within(is_near ? 0.05 : 0, is_near ? 0.2 : 0.5);
    const double strays = random.next() % 2 == 0 ? 0 : random.within(0, 0.05);
    const double shown = random.within(0.02, 1);  // the rest is none
    CodePicture picture{width, height, std::vector<int>(static_cast<std::size_t>(width * height), 0)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            int& here = picture.codes[static_cast<std::size_t>(y * width + x)];
            if (x > 0 && random.unit() < wide) {
                here = *(&here - 1);
            } else if (y > 0 && random.unit() < tall) {
                here = *(&here - width);
            } else {
                here = levels[random.next() % levels.size()];
                if (random.unit() < strays) here += static_cast<int>(random.next() % 40);
                if (random.unit() > shown) here = CodePicture::invalid;
            }
        }
    return picture;
}

TEST(EstimatorRules, LevelsAreMeasuredAsThePageSays) {
    const int rounds = 1600 / static_cast<int>(sweep_step());
    SplitMix64 random(37);
    std::map<std::string, int> decided;
    for (int round = 0; round < rounds && !testing::Test::HasFailure(); ++round) {
        SCOPED_TRACE(round);
        DepthCoding coding;
        coding.semantics = DepthSemantics::planar;
        coding.kind = DepthCodingKind::metric;
        coding.scale = round % 2 == 0 ? 1 : 0.2;
        coding.code_max = 65535;
        coding.far = coding.scale * random.within(800, 4000);
        const CodePicture picture = any_levels(random);
        const PlainEstimator plain = plain_estimator(coding, {picture});
        LevelEstimator estimator(coding);
        estimator.add(picture);
        expect_near(estimator.levels(), plain.levels, "levels");
        EXPECT_EQ(estimator.median_depth().value_or(0), plain.median_depth);
        for (const std::string& rule : plain.decided) ++decided[rule];
    }
    for (const char* rule :
         {"fewer than 20 pixels a code", "stray codes", "fewer than 4 levels", "chance meets as few codes",
          "no terraces", "fewer than three windows", "levels grow with depth squared",
          "levels are evenly apart", "all codes are multiples", "levels double at powers of two",
          "levels have no rule"})
        EXPECT_GT(decided[rule], sweep_step() == 1 ? 50 : 5) << rule;
}

// A background is at the far plane from 0.999 of it on.
TEST(EstimatorRules, TheMedianLeavesOutWhatIsBeyondAThousandthBeforeTheFarPlane) {
    DepthCoding coding;
    coding.kind = DepthCodingKind::metric;
    coding.scale = 1;
    coding.far = 10'000;
    coding.code_max = 65535;
    for (const auto& [background, median] : {std::pair{9989, 9989}, {9990, 500}, {10'000, 500}}) {
        CodePicture picture{10, 10, std::vector<int>(100, background)};
        for (std::size_t k = 0; k < 20; ++k) picture.codes[k] = 500;
        LevelEstimator estimator(coding);
        estimator.add(picture);
        EXPECT_EQ(*estimator.median_depth(), median) << background;
    }
}

TEST(EstimatorRules, FromWhichSharesOnACameraMadeTheDepth) {
    const auto is_camera = [](auto change) {
        MeasuredDepth measured;
        change(measured);
        return measured.from_a_camera();
    };
    EXPECT_FALSE(is_camera([](MeasuredDepth&) {}));
    EXPECT_FALSE(is_camera([](MeasuredDepth& of) { of.dropouts = 0.000499; }));
    EXPECT_TRUE(is_camera([](MeasuredDepth& of) { of.dropouts = 0.0005; }));
    EXPECT_FALSE(is_camera([](MeasuredDepth& of) { of.tiny_holes = 0.0000999; }));
    EXPECT_TRUE(is_camera([](MeasuredDepth& of) { of.tiny_holes = 0.0001; }));
    EXPECT_TRUE(is_camera([](MeasuredDepth& of) { of.levels.quadratic = 1e-9; }));
    EXPECT_FALSE(is_camera([](MeasuredDepth& of) { of.levels.constant = 5; })) << "a converter's rounding";
    EXPECT_TRUE(is_camera([](MeasuredDepth& of) { of.noise.constant = 1e-9; }));
}

// Frames 0 to 15, or 0 to 3 where these show nothing of a camera.
TEST(EstimatorRules, SixteenFramesOfACameraAreLookedAtAndFourOfOthers) {
    for (const bool is_camera : {false, true}) {
        Scene scene = depth_scene(64, 48, 16, Marking::zero);
        DepthEstimator estimator(scene);
        SplitMix64 random(5);
        int frames = 0;
        for (; !estimator.enough(); ++frames) {
            ASSERT_LT(frames, 100);
            std::vector<std::uint16_t> codes;
            for (int k = 0; k < 64 * 48; ++k)
                codes.push_back(static_cast<std::uint16_t>(1000 + (is_camera ? random.next() % 8 : 0)));
            estimator.add(store_plane(64, 48, codes, {}).frame());
        }
        EXPECT_EQ(frames, is_camera ? 16 : 4);
        EXPECT_EQ(estimator.measured()->frames, frames);
    }
}

}  // namespace
}  // namespace touchable::test
