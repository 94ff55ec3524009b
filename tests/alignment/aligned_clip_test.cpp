// SPDX-License-Identifier: Apache-2.0
// Depth that was guessed picture by picture gets one scale, and what truly moves goes on moving.

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <iostream>

#include "engine/base/same_bits.hpp"
#include "engine/clip/readers.hpp"
#include "engine/clip/shot_alignment.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/filter_codes.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/clip/made_clip.hpp"
#include "tests/limits.hpp"

namespace touchable::test {
namespace {

constexpr int columns = 96, rows = 72;

Guessed pumped(std::int64_t frame) {
    Random numbers(static_cast<std::uint64_t>(frame) + 77);
    const double a = static_cast<double>(numbers.next() % 1000) / 1000,
                 b = static_cast<double>(numbers.next() % 1000) / 1000;
    return {0.7 + 0.5 * a, 0.1 * b};
}

std::unique_ptr<MadeClip> made(std::int64_t count, int bytes, bool colour,
                               std::function<Scenery(std::int64_t)> scenery,
                               std::function<Guessed(std::int64_t)> guessed) {
    return std::make_unique<MadeClip>(count, bytes, [=](std::int64_t n) {
        return guessed_frame(scenery(n), guessed(n), bytes, colour, n);
    });
}

/// 1/depth of every pixel of every frame, as the clip has it.
std::vector<std::vector<double>> values_of(ClipReader& clip) {
    std::vector<std::vector<double>> values;
    for (const RawFrame& frame : must(read_all(clip))) {
        values.emplace_back();
        for (int y = 0; y < frame.depth.height; ++y)
            for (int x = 0; x < frame.depth.width; ++x)
                values.back().push_back(1 / clip.scene().depth.depth(frame.depth.sample(x, y)));
    }
    return values;
}

/// Root mean square of what `moved` says of two frames at places where nothing but the scale changes.
double pumping_of(const std::vector<std::vector<double>>& values, const Scenery& without_ball) {
    double sum = 0;
    std::int64_t count = 0;
    for (std::size_t n = 1; n < values.size(); ++n)
        for (int y = 0; y < without_ball.rows; y += 5)
            for (int x = 0; x < without_ball.columns / 4; x += 5) {
                const std::size_t k = static_cast<std::size_t>(y * without_ball.columns + x);
                const double moved = values[n][k] - values[n - 1][k];
                sum += moved * moved;
                ++count;
            }
    return std::sqrt(sum / static_cast<double>(count));
}

std::unique_ptr<ClipReader> aligned(std::unique_ptr<MadeClip> clip,
                                    DepthAlignment wanted = DepthAlignment::on) {
    return must(with_aligned_depth(std::move(clip), wanted));
}

struct Case {
    const char* name;
    int bytes;
    bool colour;
};

class StillWall : public ::testing::TestWithParam<Case> {};

/// A ball rolls by meanwhile, a quarter of the picture high, nearer than all else.
TEST_P(StillWall, PumpsTwentyTimesLess) {
    const auto scenery = [](std::int64_t n) {
        return Scenery{.ball_near = 0.2, .ball_x = 0.45 + 0.01 * static_cast<double>(n)};
    };
    const auto clip = [&] { return made(24, GetParam().bytes, GetParam().colour, scenery, pumped); };
    const auto plain = clip();
    const double before = pumping_of(values_of(*plain), {});
    const auto reader = aligned(clip(), DepthAlignment::automatic);
    const double after = pumping_of(values_of(*reader), {});
    std::cout << GetParam().name << ": pumping " << before << " -> " << after << " 1/m, " << before / after
              << " times less\n";
    EXPECT_GE(before, 20 * after);
    ASSERT_EQ(reader->notes().size(), 1U);
    EXPECT_NE(reader->notes()[0].find("depth is aligned"), std::string::npos);
    std::cout << reader->notes()[0] << '\n';
}

INSTANTIATE_TEST_SUITE_P(Alignment, StillWall,
                         ::testing::Values(Case{"16 bits", 2, true}, Case{"16 bits without colour", 2, false},
                                           Case{"8 bits", 1, true}),
                         [](const auto& each) { return std::to_string(each.index); });

/// The values of the clip are a line of the true ones, the same for all frames: by two places of the wall.
struct Truth {
    double scale = 1, shift = 0;
    double value(double of_clip) const { return (of_clip - shift) / scale; }
};
Truth truth_by(const std::vector<double>& values, const Scenery& scenery) {
    const auto at = [&](int x, int y) { return values[static_cast<std::size_t>(y * scenery.columns + x)]; };
    const double low = scenery.value(4, 4), high = scenery.value(4, rows - 5);
    const double scale = (at(4, rows - 5) - at(4, 4)) / (high - low);
    return {scale, at(4, 4) - scale * low};
}

TEST(AlignedMotion, KeepsApproachOfBall) {
    const auto scenery = [](std::int64_t n) {
        return Scenery{.ball_near = 0.05 + 0.008 * static_cast<double>(n)};
    };
    const auto reader = aligned(made(40, 2, true, scenery, pumped));
    const auto values = values_of(*reader);
    const Truth truth = truth_by(values[20], scenery(20));
    double worst = 0;
    for (std::size_t n = 0; n < values.size(); ++n) {
        const int x = columns / 2, y = rows / 2;
        const double is = truth.value(values[n][static_cast<std::size_t>(y * columns + x)]),
                     was = scenery(static_cast<std::int64_t>(n)).value(x, y);
        worst = std::max(worst, std::fabs(is - was));
    }
    std::cout << "a ball comes nearer by 0.008 a frame: error " << worst << ", lag " << worst / 0.008
              << " frames\n";
    EXPECT_LT(worst / 0.008, 0.25);
}

/// The camera goes ahead: textures grow everywhere, and nothing stands still.
TEST(AlignedMotion, KeepsApproachOfCamera) {
    const auto scenery = [](std::int64_t n) { return Scenery{.forward = 0.01 * static_cast<double>(n)}; };
    for (const bool pumps : {false, true}) {
        const auto guessed = [&](std::int64_t n) {
            Guessed of = pumped(n);
            if (!pumps) of = {0.8, 0.05};
            return of;
        };
        const auto clip = [&] { return made(60, 2, true, scenery, guessed); };
        const auto reader = aligned(clip());
        const auto values = values_of(*reader);
        const auto mean_at = [&](std::size_t n) {
            double sum = 0;
            for (const double value : values[n]) sum += value;
            return sum / static_cast<double>(values[n].size());
        };
        // Depth that did not pump is unchanged.
        if (!pumps) {
            const auto plain = clip();
            const auto were = values_of(*plain);
            double worst = 0, travelled = 0;
            for (std::size_t n = 0; n < values.size(); ++n)
                for (std::size_t k = 0; k < values[n].size(); k += 31) {
                    worst = std::max(worst, std::fabs(values[n][k] - were[n][k]));
                    travelled = std::max(travelled, std::fabs(were[n][k] - were[0][k]));
                }
            std::cout << "a camera that goes ahead: the nearest comes nearer by " << travelled
                      << " 1/m, error " << worst << ", lag " << worst / travelled * 60 << " frames\n";
            EXPECT_LT(worst, 0.05 * travelled);
        } else {
            // From frame to frame nothing jumps any more, and it comes nearer as it did.
            double jump = 0;
            for (std::size_t n = 1; n < values.size(); ++n)
                jump = std::max(jump, std::fabs(mean_at(n) - mean_at(n - 1)));
            const auto plain = clip();
            const auto were = values_of(*plain);
            double jumped = 0;
            for (std::size_t n = 1; n < were.size(); ++n) {
                double sum = 0;
                for (std::size_t k = 0; k < were[n].size(); ++k) sum += were[n][k] - were[n - 1][k];
                jumped = std::max(jumped, std::fabs(sum / static_cast<double>(were[n].size())));
            }
            std::cout << "the same, pumping: largest jump of the mean " << jumped << " -> " << jump
                      << " 1/m\n";
            EXPECT_LT(jump, jumped / 5);
            EXPECT_TRUE(is_noted(*reader, "; in 1 of 1 shots too little stands still"));
            EXPECT_GT(mean_at(50), mean_at(10));
        }
    }
}

TEST(AlignedClip, LeavesSteadyClips) {
    const auto scenery = [](std::int64_t n) {
        return Scenery{.ball_near = 0.2, .ball_x = 0.3 + 0.01 * static_cast<double>(n)};
    };
    const auto steady = [](std::int64_t) { return Guessed{0.9, 0.05}; };
    for (const int bytes : {1, 2}) {
        const auto clip = [&] { return made(30, bytes, true, scenery, steady); };
        const auto plain = clip();
        const auto before = read_all(*plain);
        const auto reader = aligned(clip(), DepthAlignment::automatic);
        EXPECT_TRUE(reader->notes().empty());
        const auto after = read_all(*reader);
        for (std::size_t n = 0; n < before->size(); ++n)
            EXPECT_TRUE(same_samples((*before)[n].depth, (*after)[n].depth));
        // Alignment on request changes it by less than a code.
        const auto forced = aligned(clip());
        const auto codes = read_all(*forced);
        const DepthCoding& was = plain->scene().depth;
        const DepthCoding& is = forced->scene().depth;
        double worst = 0;
        for (std::size_t n = 0; n < codes->size(); ++n)
            for (int y = 0; y < rows; ++y)
                for (int x = 0; x < columns; ++x) {
                    const double a = 1 / was.depth((*before)[n].depth.sample(x, y)),
                                 b = 1 / is.depth((*codes)[n].depth.sample(x, y)),
                                 code = (1 / was.near - 1 / was.far) / was.code_max;
                    worst = std::max(worst, std::fabs(a - b) / code);
                }
        std::cout << 8 * bytes << " bits, steady: aligned all the same, " << worst << " codes at most\n";
        EXPECT_LT(worst, 1);
    }
}

TEST(AlignedClip, KeepsOneScaleForLong) {
#ifdef TOUCHABLE_SANITIZED
    constexpr int count = 100;
#else
    constexpr int count = 600;
#endif
    const auto scenery = [](std::int64_t n) {
        return Scenery{.columns = 64,
                       .rows = 48,
                       .ball_near = 0.2,
                       .ball_x = 0.5 + 0.3 * std::sin(0.05 * static_cast<double>(n))};
    };
    const auto reader = aligned(made(count, 1, true, scenery, pumped));
    const auto values = values_of(*reader);
    const double code = (1 / 0.5 - 1 / 1.5) / 255;
    double worst = 0;
    for (std::size_t n = 1; n < values.size(); ++n)
        for (const std::size_t k : {70U, 2600U, 3000U})
            worst = std::max(worst, std::fabs(values[n][k] - values[0][k]));
    std::cout << count << " frames of 8 bits: a place moved by " << worst / code << " codes at most\n";
    EXPECT_LT(worst, 1.5 * code);  // half a code of each frame's own rounding, of scales from 0.7 to 1.2
}

TEST(AlignedClip, RestartsAtCut) {
    const auto scenery = [](std::int64_t n) { return Scenery{.wall = n < 15 ? 0 : 1}; };
    ShotAlignment alignment;
    const auto clip = made(30, 2, true, scenery, pumped);
    for (int n = 0; n < 30; ++n) alignment.add(cell_picture(**clip->next(), clip->scene().depth));
    const auto lines = alignment.finish();
    ASSERT_EQ(lines.size(), 30U);
    EXPECT_EQ(alignment.shots(), 2);
    EXPECT_EQ(alignment.still_shots(), 2);
    const auto reader = aligned(made(30, 2, true, scenery, pumped));
    auto values = values_of(*reader);
    const std::vector<std::vector<double>> first(values.begin(), values.begin() + 15),
        second(values.begin() + 15, values.end());
    EXPECT_LT(pumping_of(first, {}), 0.002);
    EXPECT_LT(pumping_of(second, {}), 0.002);
    EXPECT_FALSE(is_noted(*reader, "too little stands still"));
}

TEST(AlignedClip, GivesSameFrameAfterSeeks) {
    const auto scenery = [](std::int64_t) { return Scenery{}; };
    const auto reader = aligned(made(20, 1, true, scenery, pumped));
    const auto frames = read_all(*reader);
    for (const std::int64_t n : {13, 4, 19, 0}) {
        must(reader->seek(n));
        const auto there = reader->next();
        EXPECT_TRUE(same_samples((**there).depth, (*frames)[static_cast<std::size_t>(n)].depth)) << n;
    }
}

/// By GCC and Clang, with and without optimisation.
TEST(AlignedClip, HasSameBitsEverywhere) {
    const auto scenery = [](std::int64_t n) {
        return Scenery{.ball_near = 0.2, .ball_x = 0.02 * static_cast<double>(n)};
    };
    ByteHash hash;
    const auto reader = aligned(made(20, 2, true, scenery, pumped));
    for (const RawFrame& frame : must(read_all(*reader)))
        for (int y = 0; y < rows; ++y) hash.add(frame.depth.row(y), 2 * columns);
    EXPECT_EQ(hash.value(), 8537635419185157816U);
}

TEST(AlignedClip, IsSameWithoutColour) {
    const auto scenery = [](std::int64_t) { return Scenery{}; };
    const auto with = aligned(made(12, 2, true, scenery, pumped));
    const auto without = aligned(made(12, 2, true, scenery, pumped));
    without->leave_out_colour();
    const auto a = read_all(*with), b = read_all(*without);
    for (std::size_t n = 0; n < a->size(); ++n) EXPECT_TRUE(same_samples((*a)[n].depth, (*b)[n].depth));
}

/// Depth that is ten times as steep in each frame: a chain of frames says no likely scale.
TEST(AlignedClip, LimitsItsScale) {
    ShotAlignment alignment;
    for (int n = 0; n < 5; ++n) {
        CellPicture picture;
        for (int k = 0; k < 400; ++k) {
            int depth = 1000 + k;
            for (int times = 0; times < n; ++times) depth = 10 * depth - 9000;
            picture.cells.push_back({.depth = depth});
        }
        picture.most = 30;
        alignment.add(picture);
    }
    for (const Line& line : alignment.finish()) {
        EXPECT_GE(line.scale, 1.0 / 64);
        EXPECT_LE(line.scale, 64);
    }
}

TEST(AlignedClip, RejectsMetricDepth) {
    auto clip = made(
        3, 2, false, [](std::int64_t) { return Scenery{}; }, pumped);
    clip->scene().depth.kind = DepthCodingKind::metric;
    const auto reader = with_aligned_depth(std::move(clip), DepthAlignment::on);
    ASSERT_FALSE(reader);
    EXPECT_EQ(reader.error().kind, ErrorKind::usage);
}

TEST(AlignedClip, IsQuick) {
    const auto clip = made(
        2, 2, true,
        [](std::int64_t n) {
            return Scenery{.columns = 640, .rows = 480, .ball_near = 0.1 * static_cast<double>(n + 1)};
        },
        pumped);
    const RawFrame frames[] = {std::move(**clip->next()), std::move(**clip->next())};
    ShotAlignment alignment;
#ifdef TOUCHABLE_SANITIZED
    constexpr int count = 4;
    constexpr double least = 0;
#else
    constexpr int count = 40;
    constexpr double least = 30;
#endif
    const std::clock_t begin = std::clock();
    for (int n = 0; n < count; ++n) alignment.add(cell_picture(frames[n % 2], clip->scene().depth));
    const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    std::cout << "640x480: " << count / seconds << " frames a second of processor time\n";
    EXPECT_GE(count / seconds, least);
}

/// Codes of 13 bits become no more than leave room for finer ones where terraces are to be removed.
TEST(AlignedCodes, LeaveRoomForTerraceRemoval) {
    for (const bool has_levels : {false, true}) {
        auto clip = std::make_unique<MadeClip>(24, 2, [](std::int64_t n) {
            RawFrame frame = guessed_frame({}, pumped(n), 2, true, n);
            Image depth{columns, rows, 2, 1, {}};
            for (int y = 0; y < rows; ++y)
                for (int x = 0; x < columns; ++x) {
                    const int code = frame.depth.sample(x, y) / 8;
                    push_16(depth, code);
                }
            frame.depth = {};
            add_plane(frame, PlaneRole::depth, plane_from(std::move(depth), 16));
            return frame;
        });
        Scene& scene = clip->scene();
        scene.depth.code_max = 8191;
        derive_valid_range(scene.depth);
        scene.filter.terraces = TerraceRemoval::on;
        if (has_levels)
            scene.filter.levels.quadratic = 20 * (1 / scene.depth.near - 1 / scene.depth.far) / 8191;
        must(validate(scene));
        const auto reader = aligned(std::move(clip), DepthAlignment::automatic);
        EXPECT_EQ(reader->notes().size(), 1U);
        EXPECT_TRUE(terrace_filter(reader->scene()));
        EXPECT_GT(reader->scene().depth.code_max, 8191);
        EXPECT_GT(reader->scene().filter.levels.quadratic, 0);
    }
}

// The line on which most points lie.

double random_share(Random& numbers) {
    return static_cast<double>(numbers.next() % 10000) / 10000;
}

std::vector<LinePoint> points_on(const Line& line, int count, double noise, Random& numbers) {
    std::vector<LinePoint> points;
    for (int k = 0; k < count; ++k) {
        const double from = 4000 * random_share(numbers);
        points.push_back({from, line.at(from) + noise * (random_share(numbers) - 0.5)});
    }
    return points;
}

TEST(LineFit, FindsLineDespiteManyOutliers) {
    Random numbers(1);
    std::vector<LinePoint> points = points_on({1.3, -200}, 600, 2, numbers);
    // Something near, which came nearer.
    for (int k = 0; k < 450; ++k) {
        const double from = 3000 + 1000 * random_share(numbers);
        points.push_back({from, 1.3 * from + 300});
    }
    const auto fit = fit_line(points, 1);
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->line.scale, 1.3, 0.0005);
    EXPECT_NEAR(fit->line.shift, -200, 1);
}

TEST(LineFit, FindsOnlyShiftOfWall) {
    Random numbers(2);
    std::vector<LinePoint> points;
    for (int k = 0; k < 100; ++k) {
        const double from = 1000 + 4 * random_share(numbers);
        points.push_back({from, from + 50 + 4 * random_share(numbers)});
    }
    const auto fit = fit_line(points, 1);
    ASSERT_TRUE(fit);
    EXPECT_EQ(fit->line.scale, 1);
    EXPECT_NEAR(fit->line.shift, 52, 1);
}

TEST(LineFit, NeedsEnoughPoints) {
    Random numbers(3);
    EXPECT_FALSE(fit_line(points_on({}, 7, 0, numbers), 1));
    EXPECT_TRUE(fit_line(points_on({}, 8, 0, numbers), 1));
}

TEST(LineFit, ComposesLines) {
    const Line a{2, 10}, b{0.5, -3};
    EXPECT_EQ(a.then(b).at(7), b.at(a.at(7)));
    EXPECT_EQ(a.then(a.inverse()).at(7), 7);
}

}  // namespace
}  // namespace touchable::test
