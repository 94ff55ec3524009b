#include "device/haptic_device.hpp"
#include "device/point_motion.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "tests/frame/allocations.hpp"

namespace touchable::test {
namespace {

const glm::dvec3 camera(0.01, 0, 0.14);
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

class Pointer : public ::testing::Test {
protected:
    using Places = std::array<glm::dvec3, 3>;

    void SetUp() override { ASSERT_TRUE(device.open()); }
    Places read() {
        Places places;
        EXPECT_TRUE(device.read_positions(places));
        return places;
    }
    Places read_for(int ticks) {
        for (int k = 1; k < ticks; ++k) read();
        return read();
    }
    bool push(double newtons = 2) {
        const Places forces{glm::dvec3(0, 0, newtons), glm::dvec3(1, 2, 0), glm::dvec3(0)};
        return device.write_forces(forces);
    }
    void intend(const std::vector<glm::dvec3>& places) { device.intend(places, camera); }

    PointerSettings settings{.limits = {.max_force = 8, .max_stiffness = 2000}};
    PointerDevice device{3, camera, settings};
};

TEST_F(Pointer, TakesNoForceAndHasNoPlaceWhileItIsClosed) {
    ASSERT_TRUE(push());
    device.close();
    EXPECT_FALSE(push());
    Places places;
    EXPECT_FALSE(device.read_positions(places));
    ASSERT_TRUE(device.open());
    EXPECT_TRUE(push());
}

TEST_F(Pointer, TakesNoForceAndHasNoPlaceBeforeItIsOpened) {
    PointerDevice closed(1, camera);
    const std::array force{glm::dvec3(1)};
    std::array<glm::dvec3, 1> place;
    EXPECT_FALSE(closed.write_forces(force));
    EXPECT_FALSE(closed.read_positions(place));
}

TEST_F(Pointer, AForceThatIsNotFiniteEndsItWithAReasonUntilOpenedAgain) {
    for (const double bad : {nan, std::numeric_limits<double>::infinity(), 1e300}) {
        ASSERT_TRUE(push());
        EXPECT_FALSE(push(bad));
        EXPECT_FALSE(push());
        Places places;
        EXPECT_FALSE(device.read_positions(places));
        ASSERT_FALSE(device.health());
        EXPECT_EQ(device.health().error().kind, ErrorKind::device);
        EXPECT_EQ(device.health().error().message,
                  "pointer was given a force that is not finite; open it again");
        ASSERT_TRUE(device.open());
        EXPECT_TRUE(device.health());
    }
}

TEST_F(Pointer, FingersAreAwayUntilTheyAreMeantSomewhere) {
    EXPECT_EQ(read_for(3), (Places{camera, camera, camera}));
    const glm::dvec3 first(0.02, 0.01, -0.002), second(-0.03, 0, 0.01);
    intend({first, second});
    const Places there = read_for(2000);
    EXPECT_LT(glm::length(there[0] - first), 1e-6);
    EXPECT_LT(glm::length(there[1] - second), 1e-6);
    EXPECT_EQ(there[2], camera);
    intend({first});
    EXPECT_LT(glm::length(read_for(2000)[1] - camera), 1e-9);
    intend({});
    EXPECT_LT(glm::length(read_for(2000)[0] - camera), 1e-9);
}

TEST_F(Pointer, FingerThatIsLedForItselfBeginsWhereItIsTold) {
    const glm::dvec3 first(0.02, 0.01, -0.002), second(-0.03, 0, 0.01), near(0.02, 0.01, 0.006);
    intend({second, second});
    read_for(2000);
    device.withdraw(0);
    const Places gone = read_for(2000);
    EXPECT_LT(glm::length(gone[0] - camera), 1e-9);
    EXPECT_LT(glm::length(gone[1] - second), 1e-6) << "the other stays";
    device.intend(0, first, near, camera);
    glm::dvec3 before = read()[0];
    EXPECT_LT(glm::length(before - near), 0.001);
    for (int k = 0; k < 500; ++k) {
        device.intend(0, first, near, camera);  // with each picture
        const glm::dvec3 now = read()[0];
        EXPECT_LE(glm::length(now - before), settings.approach_speed * 1e-3 * (1 + 1e-12));
        before = now;
    }
    EXPECT_LT(glm::length(before - first), 1e-4);
    device.intend(0, {nan, 0, 0}, near, camera);
    device.intend(0, {1e9, 0, 0}, near, camera);
    EXPECT_LT(glm::length(read_for(100)[0] - first), 1e-4) << "what is no place changes nothing";
    device.intend(2, first, glm::dvec3(nan), camera);
    EXPECT_LT(glm::length(read()[2] - camera), 0.001) << "it comes from where it is away";
    EXPECT_LT(glm::length(read_for(2000)[2] - first), 1e-6);
    device.set_force(false);
    EXPECT_EQ(read_for(100), (Places{camera, camera, camera}));
}

TEST_F(Pointer, ComesSlowlyAndLeavesAtOnceOnItsWayToTheEye) {
    const glm::dvec3 deep(0.04, -0.02, -0.01);
    intend({deep});
    glm::dvec3 before = read()[0];
    for (int k = 0; k < 2000; ++k) {
        const glm::dvec3 now = read()[0];
        EXPECT_LE(glm::length(now - before), settings.approach_speed * 1e-3 * (1 + 1e-12));
        before = now;
    }
    intend({});
    for (int k = 0; k < 60; ++k) {
        const glm::dvec3 now = read()[0];
        EXPECT_LT(glm::length(glm::cross(now - camera, glm::normalize(deep - camera))), 1e-7) << "its ray";
        EXPECT_LE(glm::length(now - before), settings.max_speed * 1e-3 * (1 + 1e-12));
        before = now;
    }
    EXPECT_GT(glm::length(before - deep), 0.02);
}

TEST_F(Pointer, GoesThroughAJumpAtALimitedSpeed) {
    intend({{-0.08, 0, 0}});
    glm::dvec3 before = read_for(3000)[0];
    intend({{0.08, 0, -0.01}});
    double fastest = 0;
    for (int k = 0; k < 1000; ++k) {
        const glm::dvec3 now = read()[0];
        fastest = std::max(fastest, glm::length(now - before));
        before = now;
    }
    EXPECT_NEAR(fastest, settings.max_speed * 1e-3, 1e-12);
    EXPECT_LT(glm::length(before - glm::dvec3(0.08, 0, -0.01)), 1e-4);
}

TEST_F(Pointer, IsSlowerAlongTheViewThanAcross) {
    const glm::dvec3 eye(0.3, 0, 0);  // it looks along -X
    device.intend(std::array{glm::dvec3(0)}, eye);
    read_for(3000);
    device.intend(std::array{glm::dvec3(0, 0.001, 0)}, eye);
    const double across = read_for(50)[0].y / 0.001;
    device.intend(std::array{glm::dvec3(0)}, eye);
    read_for(3000);
    device.intend(std::array{glm::dvec3(-0.001, 0, 0)}, eye);
    const double along = read_for(50)[0].x / -0.001;
    EXPECT_NEAR(across, 1 - (1 + 2.0) * std::exp(-2.0), 1e-5);
    EXPECT_NEAR(along, 1 - (1 + 50.0 / 90) * std::exp(-50.0 / 90), 1e-5);
}

/// What is higher than relief, a slope or a step, is followed as quickly along the view as across.
TEST_F(Pointer, AlongTheViewItIsOnALeash) {
    const glm::dvec3 eye(0, 0, 0.3);
    for (const double way : {-0.02, 0.02}) {
        device.intend(std::array{glm::dvec3(0)}, eye);
        read_for(3000);
        device.intend(std::array{glm::dvec3(0, 0, way)}, eye);
        LedPoint quick({settings.across_s, settings.across_s}, 0.001);
        bool led = false;
        for (int k = 0; k < 400; ++k) {
            quick.follow({0, 0, way}, {0, 0, -1}, settings.max_speed);
            const double behind = std::abs(quick.place().z - read()[0].z);
            EXPECT_LE(behind, settings.leash + 1e-12) << k;
            led = led || behind > 0.99 * settings.leash;
        }
        EXPECT_TRUE(led) << "it is as quick itself";
    }
}

/// A goal that goes on is never reached: nor is a finger for that one that still comes from far away.
TEST_F(Pointer, IsThereOnceItIsAsDeepAsItIsMeant) {
    const glm::dvec3 eye(0, 0, 0.3);
    double x = -0.1;
    for (int k = 0; k < 1000; ++k, x += 1e-4) {  // 0.1 m/s
        if (k % 16 == 0) device.intend(std::array{glm::dvec3(x, 0, 0)}, eye);
        read();
    }
    device.intend(std::array{glm::dvec3(x, 0.1, 0)}, eye);
    glm::dvec3 before = read()[0];
    double fastest = 0;
    for (int k = 0; k < 200; ++k) {
        const glm::dvec3 now = read()[0];
        fastest = std::max(fastest, glm::length(now - before) / 1e-3);
        before = now;
    }
    EXPECT_GT(fastest, 2 * settings.approach_speed);
}

TEST_F(Pointer, StoppingIsAtOnceAndComingBackIsSlow) {
    const glm::dvec3 deep(0.02, 0, -0.005);
    intend({deep, deep, deep});
    read_for(2000);
    ASSERT_TRUE(push());
    device.set_force(false);
    EXPECT_FALSE(device.force_is_on());
    EXPECT_TRUE(push());
    for (int k = 0; k < 5; ++k) EXPECT_EQ(read(), (Places{camera, camera, camera}));
    intend({deep});
    EXPECT_EQ(read()[0], camera);
    device.set_force(true);
    glm::dvec3 before = camera;
    for (int k = 0; k < 3000; ++k) {
        const glm::dvec3 now = read()[0];
        EXPECT_LE(glm::length(now - before), settings.approach_speed * 1e-3 * (1 + 1e-12));
        before = now;
    }
    EXPECT_LT(glm::length(before - deep), 1e-6);
    EXPECT_TRUE(push());
}

TEST_F(Pointer, AStopBetweenTwoReadingsIsNotLost) {
    intend({{0.02, 0, -0.005}});
    read_for(2000);
    ASSERT_TRUE(push());
    device.set_force(false);
    device.set_force(true);
    EXPECT_TRUE(push()) << "an answer to where the finger was";
    EXPECT_LT(glm::length(read()[0] - camera), 1e-3);
    device.set_force(true);
    EXPECT_TRUE(push());
}

TEST_F(Pointer, OpeningAgainBeginsAway) {
    intend({{0.02, 0, -0.005}});
    read_for(2000);
    device.close();
    ASSERT_TRUE(device.open());
    EXPECT_LT(glm::length(read()[0] - camera), 1e-3);
}

TEST_F(Pointer, APlaceThatIsNoneChangesNothing) {
    const glm::dvec3 place(0.02, 0, 0);
    intend({place, place});
    for (const double bad : {nan, std::numeric_limits<double>::infinity(), 1e200, 1001.0})
        intend({{0, bad, 0}, place, {bad, 0, 0}});
    device.intend(std::array{glm::dvec3(nan), place, glm::dvec3(nan)}, glm::dvec3(nan));
    const Places there = read_for(3000);
    EXPECT_LT(glm::length(there[0] - place), 1e-9);
    EXPECT_LT(glm::length(there[1] - place), 1e-9);
    EXPECT_EQ(there[2], camera);
    device.intend(std::array{camera}, camera);  // looked at from where it is
    EXPECT_LT(glm::length(read_for(3000)[0] - camera), 1e-9);
}

TEST_F(Pointer, NeverAllocatesInATick) {
    intend({{0.02, 0, 0}});
    const Places forces{};
    Places places;
    const std::size_t before = allocations();
    for (int k = 0; k < 100; ++k) {
        device.read_positions(places);
        device.write_forces(forces);
        device.intend(places, camera);
    }
    EXPECT_EQ(allocations(), before);
}

}  // namespace
}  // namespace touchable::test
