// Figures of moments and places, worked out by hand.
#include "device/drivers/device_measure.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace touchable::test {
namespace {

TEST(Percentiles, IsOfValuesThatWereThere) {
    std::vector<double> values;
    for (int k = 200; k >= 1; --k) values.push_back(k);
    const WatchFigures::Percentiles found = percentiles_of(values);
    EXPECT_EQ(found.count, 200);
    EXPECT_EQ(found.median, 100);
    EXPECT_EQ(found.p99, 198);
    EXPECT_EQ(found.greatest, 200);
    EXPECT_EQ(percentiles_of({7}).p99, 7);
    EXPECT_EQ(percentiles_of({}).count, 0);
}

TEST(Intervals, AreFromEachMomentToTheNext) {
    const std::vector<std::int64_t> times{5'000'000, 6'000'000, 9'000'000};
    const auto intervals = intervals_between(times);
    ASSERT_EQ(intervals.size(), 2u);
    EXPECT_NEAR(intervals[0], 0.001, 1e-15);
    EXPECT_NEAR(intervals[1], 0.003, 1e-15);
    EXPECT_TRUE(intervals_between(std::span(times).first(1)).empty());
}

TEST(UntilTheNext, AnswersOnlyTheLastBeforeIt) {
    const std::vector<std::int64_t> asked{1000, 2000, 3000, 9000}, answered{500, 2400, 2500, 5000};
    const auto waits = until_the_next(asked, answered);
    ASSERT_EQ(waits.size(), 2u) << "that of 1000 came after another was asked for, that of 9000 never";
    EXPECT_NEAR(waits[0], 400e-9, 1e-15);
    EXPECT_NEAR(waits[1], 2000e-9, 1e-15);
}

TEST(Rest, OfAnEncoderThatFlickersBetweenTwoCounts) {
    std::vector<glm::dvec3> places;
    for (int k = 0; k < 100; ++k) places.push_back({k % 2 == 0 ? 0.0 : 40e-6, 0.001, k < 50 ? 0.0 : 10e-6});
    const WatchFigures::Rest rest = rest_of(places);
    EXPECT_NEAR(rest.deviation_m.x, 20e-6, 1e-12);
    EXPECT_NEAR(rest.deviation_m.y, 0, 1e-12);
    EXPECT_NEAR(rest.deviation_m.z, 5e-6, 1e-12);
    EXPECT_NEAR(rest.step_m.x, 40e-6, 1e-12);
    EXPECT_EQ(rest.step_m.y, 0);
    EXPECT_NEAR(rest.step_m.z, 10e-6, 1e-12);
    EXPECT_NEAR(rest.farthest_m, std::hypot(20e-6, 5e-6), 1e-12);
    EXPECT_FALSE(rest.moved());
}

TEST(Rest, OfAHandThatWentIsCalledSo) {
    std::vector<glm::dvec3> places;
    for (int k = 0; k <= 100; ++k) places.push_back({0, k * 20e-6, 0});
    EXPECT_TRUE(rest_of(places).moved()) << "1 mm to each side of the mean";
    EXPECT_EQ(rest_of({}).places, 0);
}

TEST(DriveTimes, GiveWhatWasWithinAndKeepTheNewest) {
    DriveTimes times(4);
    for (std::int64_t moment = 1; moment <= 6; ++moment) times.received(moment * 10);
    times.sent(35);
    EXPECT_EQ(times.received_within(0, 1000), (std::vector<std::int64_t>{30, 40, 50, 60}));
    EXPECT_EQ(times.received_within(40, 60), (std::vector<std::int64_t>{40, 50}));
    EXPECT_EQ(times.sent_within(0, 1000), (std::vector<std::int64_t>{35}));
}

}  // namespace
}  // namespace touchable::test
