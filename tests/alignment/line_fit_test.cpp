// The line on which most points lie.
#include "engine/clip/shot_alignment.hpp"

#include <gtest/gtest.h>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

double random_share(Numbers& numbers) {
    return static_cast<double>(numbers.next() % 10000) / 10000;
}

std::vector<LinePoint> points_on(const Line& line, int count, double noise, Numbers& numbers) {
    std::vector<LinePoint> points;
    for (int k = 0; k < count; ++k) {
        const double from = 4000 * random_share(numbers);
        points.push_back({from, line.at(from) + noise * (random_share(numbers) - 0.5)});
    }
    return points;
}

TEST(LineFit, FindsTheLineThoughNearlyHalfOfThePointsLieOnAnother) {
    Numbers numbers(1);
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

TEST(LineFit, OfAFlatWallOnlyTheShiftIsTold) {
    Numbers numbers(2);
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

TEST(LineFit, OfFewPointsThereIsNone) {
    Numbers numbers(3);
    EXPECT_FALSE(fit_line(points_on({}, 7, 0, numbers), 1));
    EXPECT_TRUE(fit_line(points_on({}, 8, 0, numbers), 1));
}

TEST(LineFit, LinesCompose) {
    const Line a{2, 10}, b{0.5, -3};
    EXPECT_EQ(a.then(b).at(7), b.at(a.at(7)));
    EXPECT_EQ(a.then(a.inverse()).at(7), 7);
}

}  // namespace
}  // namespace touchable::test
