#include "device/point_motion.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace touchable {
namespace {

constexpr double period = 0.001;

HandleDynamics free_body() {
    HandleDynamics d;
    d.mass = 0.4;
    d.damping = d.friction = d.quantum = d.hand_stiffness = 0;
    return d;
}

TEST(HeldHandle, FreeMassFallsAsGalileoSaid) {
    HeldHandle handle(free_body(), period);
    const glm::dvec3 start{0.01, -0.02, 0.03}, speed{0.1, 0, -0.2}, force{0.3, -1, 2};
    handle.put(start, speed);
    for (int k = 0; k < 500; ++k) handle.advance(force);
    const glm::dvec3 fallen = start + 0.5 * speed + (0.5 * 0.5 * 0.5 / 0.4) * force;
    EXPECT_LT(glm::length(handle.place() - fallen), 1e-13);
    EXPECT_LT(glm::length(handle.velocity() - (speed + (0.5 / 0.4) * force)), 1e-13);
}

TEST(HeldHandle, ViscousLossIsExponential) {
    HandleDynamics d = free_body();
    d.damping = 7;
    HeldHandle handle(d, period);
    handle.put(glm::dvec3(0), {0.3, 0, 0});
    for (int k = 0; k < 100; ++k) handle.advance(glm::dvec3(0));
    const double left = std::exp(-7 / 0.4 * 0.1);
    EXPECT_NEAR(handle.velocity().x, 0.3 * left, 1e-14);
    EXPECT_NEAR(handle.place().x, 0.3 * (0.4 / 7) * (1 - left), 1e-14);
}

TEST(HeldHandle, HandsSpringSwingsAsADampedOscillator) {
    HandleDynamics d = free_body();
    d.hand_stiffness = 300;
    d.damping = 4;
    HeldHandle handle(d, period);
    handle.intend({0.02, 0, 0});
    for (int k = 0; k < 437; ++k) handle.advance(glm::dvec3(0));
    const double t = 0.437, sigma = 4 / (2 * 0.4), omega = std::sqrt(300 / 0.4 - sigma * sigma);
    const double x =
        0.02 * (1 - std::exp(-sigma * t) * (std::cos(omega * t) + sigma / omega * std::sin(omega * t)));
    EXPECT_NEAR(handle.place().x, x, 1e-14);
}

TEST(HeldHandle, CoulombFrictionStopsASlidingMassWhereItMust) {
    HandleDynamics d = free_body();
    d.friction = 0.5;
    HeldHandle handle(d, period);
    const glm::dvec3 way = glm::normalize(glm::dvec3(1, 2, -2));
    handle.put(glm::dvec3(0), 0.2 * way);
    for (int k = 0; k < 400; ++k) handle.advance(glm::dvec3(0));
    // m v^2 / (2 f), but for the last step of 50 us.
    EXPECT_NEAR(glm::dot(handle.place(), way), 0.4 * 0.2 * 0.2 / (2 * 0.5), 1e-7);
    EXPECT_EQ(handle.velocity(), glm::dvec3(0));
}

TEST(HeldHandle, CoulombFrictionHoldsAgainstLessAndLetsGoOfMore) {
    HandleDynamics d = free_body();
    d.friction = 0.5;
    d.hand_stiffness = 100;
    HeldHandle handle(d, period);
    handle.put({0.01, 0, 0}, glm::dvec3(0));
    handle.intend({0.0145, 0, 0});
    for (int k = 0; k < 1000; ++k) handle.advance(glm::dvec3(0));
    EXPECT_EQ(handle.place(), glm::dvec3(0.01, 0, 0)) << "0.45 N do not move it at all";
    for (int k = 0; k < 5; ++k) handle.advance({0.1, 0, 0});
    EXPECT_GT(handle.place().x, 0.01);
}

TEST(HeldHandle, ReadsItsPlaceInWholeQuanta) {
    HandleDynamics d = free_body();
    d.quantum = 6e-5;
    HeldHandle handle(d, period);
    handle.put({8.9e-5, -8.9e-5, 9.1e-5}, glm::dvec3(0));
    EXPECT_EQ(handle.reading(), glm::dvec3(6e-5, -6e-5, 2 * 6e-5));
    EXPECT_EQ(handle.place(), glm::dvec3(8.9e-5, -8.9e-5, 9.1e-5));
}

TEST(HeldHandle, NeverGainsEnergyOnItsOwn) {
    HandleDynamics d;
    d.friction = 0.3;
    HeldHandle handle(d, period);
    handle.put({0.03, -0.01, 0.02}, {0.4, 0.5, -0.6});
    const auto energy = [&] {
        return 0.5 * d.mass * glm::dot(handle.velocity(), handle.velocity()) +
               0.5 * d.hand_stiffness * glm::dot(handle.place(), handle.place());
    };
    double last = energy();
    for (int k = 0; k < 2000; ++k) {
        handle.advance(glm::dvec3(0));
        EXPECT_LE(energy(), last * (1 + 1e-12));
        last = energy();
    }
    EXPECT_LT(last, 5e-4);
}

TEST(HeldHandle, IsTheSameBitsEverywhere) {
    HandleDynamics d;
    d.friction = 0.2;
    HeldHandle handle(d, period);
    handle.put({0.01, 0.02, -0.03}, {0.1, -0.2, 0.3});
    for (int k = 0; k < 150; ++k) handle.advance(-400.0 * handle.place());
    // Of GCC and Clang, with and without optimisation.
    EXPECT_EQ(handle.place(), glm::dvec3(0x1.2c6d5b7c5a063p-9, 0x1.010ad916a5e66p-7, -0x1.819045a1f8dd5p-7));
    EXPECT_EQ(handle.velocity(),
              glm::dvec3(0x1.393259bcae072p-3, 0x1.3d9d9ff7651c2p-3, -0x1.dc6c6ff317a99p-3));
}

}  // namespace
}  // namespace touchable
