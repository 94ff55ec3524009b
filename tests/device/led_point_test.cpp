#include "device/point_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/same_bits.hpp"

namespace touchable {
namespace {

constexpr double tick = 0.001;  // s
constexpr double any_speed = 1e9;
const LeadTimes times{0.02, 0.08};
const glm::dvec3 slow_way = glm::normalize(glm::dvec3(0.3, -0.2, -1));

/// Share of a way that a critically damped spring has left after t seconds, from rest.
double left_after(double t, double time_constant) {
    return (1 + t / time_constant) * std::exp(-t / time_constant);
}

TEST(LedPoint, GoesAsACriticallyDampedSpringDoes) {
    LedPoint point(times, tick);
    const glm::dvec3 start(0.01, 0.02, -0.03), way(0.02, -0.01, 0.04), goal = start + way;
    const glm::dvec3 along = glm::dot(way, slow_way) * slow_way, across = way - along;
    point.put(start);
    for (int k = 1; k <= 300; ++k) {
        point.follow(goal, slow_way, any_speed);
        const double t = k * tick;
        const glm::dvec3 left = left_after(t, times.across_s) * across + left_after(t, times.along_s) * along;
        EXPECT_LT(glm::length(goal - left - point.place()), 1e-15) << k;
        const glm::dvec3 velocity =
            t / times.across_s / times.across_s * std::exp(-t / times.across_s) * across +
            t / times.along_s / times.along_s * std::exp(-t / times.along_s) * along;
        EXPECT_LT(glm::length(velocity - point.velocity()), 1e-13) << k;
    }
}

/// Half the way from the lowest to the highest place while the goal swings along `slow_way` by 1 mm.
double swing(double frequency) {
    LedPoint point(times, tick);
    double least = 1, greatest = -1;
    for (int k = 0; k < 8000; ++k) {
        point.follow(0.001 * std::sin(2 * pi * frequency * k * tick) * slow_way, slow_way, any_speed);
        if (k < 3000) continue;
        const double place = glm::dot(point.place(), slow_way);
        least = std::min(least, place);
        greatest = std::max(greatest, place);
    }
    return (greatest - least) / 2;
}

TEST(LedPoint, GoesWithTheLargeShapeAndNotWithSmallBumps) {
    for (const double frequency : {0.25, 2.0, 10.0}) {
        const double x = 2 * pi * frequency * times.along_s;
        EXPECT_NEAR(swing(frequency), 0.001 / (1 + x * x), 3e-6) << frequency;  // held goals: nearly this
    }
}

TEST(LedPoint, IsNeverFasterThanItMayBeAndNeverGoesTooFar) {
    for (const double max_speed : {0.1, 1.0, 5.0}) {
        LedPoint point(times, tick);
        const glm::dvec3 goal(0.3, 0.2, -0.5);
        glm::dvec3 before = point.place();
        bool limited = false;
        for (int k = 0; k < 9000; ++k) {
            point.follow(goal, slow_way, max_speed);
            const double step = glm::length(point.place() - before);
            EXPECT_LE(step, max_speed * tick * (1 + 1e-12));
            limited = limited || step > 0.99 * max_speed * tick;
            const glm::dvec3 left = goal - point.place();
            EXPECT_GE(glm::dot(left, slow_way), -1e-12);
            EXPECT_GE(glm::dot(left, goal - glm::dot(goal, slow_way) * slow_way), -1e-12);
            before = point.place();
        }
        EXPECT_TRUE(limited) << max_speed;
        EXPECT_LT(glm::length(goal - point.place()), 1e-8);
    }
}

TEST(LedPoint, ATurnOfTheViewDoesNotMoveIt) {
    LedPoint still(times, tick), moving(times, tick);
    for (int k = 0; k < 100; ++k) {
        const glm::dvec3 along(sine(0.1 * k), 0, -cosine(0.1 * k));
        still.follow(glm::dvec3(0), along, 1);
        EXPECT_EQ(still.place(), glm::dvec3(0));
        const glm::dvec3 before = moving.place();
        moving.follow({0.02, 0.01, -0.03}, along, 1);
        EXPECT_LE(glm::length(moving.place() - before), 1e-3);
    }
}

TEST(LedPoint, IsTheSameBitsEverywhere) {
    LedPoint point({0.025, 0.09}, tick);
    const glm::dvec3 along(0.6, 0, -0.8);
    for (int k = 0; k < 150; ++k) point.follow({0.01 + 1e-5 * k, 0.02, -0.03}, along, 0.3);
    // Of GCC and Clang, with and without optimisation.
    EXPECT_EQ(point.place(), glm::dvec3(0x1.a67e41bc62aa8p-10, 0x1.413ff5415eb9cp-6, -0x1.1913c64c6fed4p-6));
    EXPECT_EQ(point.velocity(),
              glm::dvec3(0x1.103cd07e1cc86p-4, 0x1.b5d01460bc636p-7, -0x1.62e2c610b3f8fp-4));
}

}  // namespace
}  // namespace touchable
