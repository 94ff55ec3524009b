#include "device/haptic_device.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "device/point_motion.hpp"

namespace touchable {
namespace {

using Forces = std::array<glm::dvec3, 2>;

class SafetyContract : public ::testing::Test {
protected:
    bool push() {
        const Forces forces{glm::dvec3(1, 2, 0), glm::dvec3(0, 0, 3)};
        return device.write_forces(forces);
    }
    bool unpowered() const {
        return device.exerted()[0] == glm::dvec3(0) && device.exerted()[1] == glm::dvec3(0);
    }

    SimulatedDevice device{2, {.max_force = 8, .max_stiffness = 2000}};
};

TEST_F(SafetyContract, ExertsWhatIsWrittenAndReportsWhereItsFingersAre) {
    ASSERT_TRUE(device.open());
    EXPECT_TRUE(unpowered());
    ASSERT_TRUE(push());
    EXPECT_EQ(device.exerted()[0], glm::dvec3(1, 2, 0));
    EXPECT_EQ(device.exerted()[1], glm::dvec3(0, 0, 3));
    device.put(1, {0.01, 0.02, 0.03});
    std::array<glm::dvec3, 2> positions{};
    ASSERT_TRUE(device.read_positions(positions));
    EXPECT_EQ(positions[0], glm::dvec3(0));
    EXPECT_EQ(positions[1], glm::dvec3(0.01, 0.02, 0.03));
    EXPECT_TRUE(device.health());
}

TEST_F(SafetyContract, ClosingLeavesZeroForce) {
    ASSERT_TRUE(device.open());
    ASSERT_TRUE(push());
    device.close();
    EXPECT_TRUE(unpowered());
    EXPECT_FALSE(push());
    EXPECT_TRUE(unpowered());
}

TEST_F(SafetyContract, NothingIsExertedBeforeOpening) {
    EXPECT_FALSE(push());
    EXPECT_TRUE(unpowered());
}

TEST_F(SafetyContract, FailingLeavesZeroForceAndAReasonUntilOpenedAgain) {
    ASSERT_TRUE(device.open());
    ASSERT_TRUE(push());
    device.fail("was unplugged");
    EXPECT_TRUE(unpowered());
    std::array<glm::dvec3, 2> positions{};
    EXPECT_FALSE(push());
    EXPECT_FALSE(device.read_positions(positions));
    EXPECT_TRUE(unpowered());
    ASSERT_FALSE(device.health());
    EXPECT_EQ(device.health().error().kind, ErrorKind::device);
    EXPECT_EQ(device.health().error().message, "simulated device was unplugged; open it again");
    ASSERT_TRUE(device.open());
    EXPECT_TRUE(unpowered());
    EXPECT_TRUE(push());
}

TEST_F(SafetyContract, SilenceLeavesZeroForce) {
    ASSERT_TRUE(device.open());
    for (int tick = 0; tick < 200; ++tick) {
        ASSERT_TRUE(push());
        device.pass_tick();
        EXPECT_FALSE(unpowered());
    }
    for (int tick = 0; tick < 48; ++tick) device.pass_tick();
    EXPECT_FALSE(unpowered());
    for (int tick = 0; tick < 2; ++tick) device.pass_tick();
    EXPECT_TRUE(unpowered());
    EXPECT_TRUE(push()) << "a caller that speaks again is heard";
    EXPECT_FALSE(unpowered());
}

TEST_F(SafetyContract, TooLargeAForceIsShortenedAlongItsDirection) {
    ASSERT_TRUE(device.open());
    const Forces forces{glm::dvec3(0, 30, -40), glm::dvec3(0, 0, 8)};
    ASSERT_TRUE(device.write_forces(forces));
    EXPECT_NEAR(glm::length(device.exerted()[0] - glm::dvec3(0, 4.8, -6.4)), 0, 1e-12);
    EXPECT_EQ(device.exerted()[1], glm::dvec3(0, 0, 8));
}

TEST_F(SafetyContract, AForceThatIsNotFiniteLeavesZeroForceOnEveryFinger) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
        ASSERT_TRUE(device.open());
        ASSERT_TRUE(push());
        const Forces forces{glm::dvec3(1, 0, 0), glm::dvec3(0, bad, 0)};
        EXPECT_FALSE(device.write_forces(forces));
        EXPECT_TRUE(unpowered());
        EXPECT_FALSE(device.health());
    }
}

TEST(SimulatedHandles, YieldToTheForceAsFarAsTheHandsSpringLets) {
    HandleDynamics handle;
    handle.hand_stiffness = 250;
    SimulatedDevice device(2, {.max_force = 8, .max_stiffness = 2000}, handle);
    ASSERT_TRUE(device.open());
    device.put(0, {0.01, 0, 0});
    device.put(1, {0, 0.02, 0});
    device.intend(1, {0, 0.03, 0});
    device.intend(1, {0, std::numeric_limits<double>::infinity(), 0});
    const Forces forces{glm::dvec3(0, 0, 1), glm::dvec3(0)};
    for (int tick = 0; tick < 3000; ++tick) {
        ASSERT_TRUE(device.write_forces(forces));
        device.pass_tick();
    }
    std::array<glm::dvec3, 2> positions{};
    ASSERT_TRUE(device.read_positions(positions));
    EXPECT_LT(glm::length(positions[0] - glm::dvec3(0.01, 0, 1.0 / 250)), 1e-6);
    EXPECT_LT(glm::length(positions[1] - glm::dvec3(0, 0.03, 0)), 1e-6);
}

TEST(SimulatedHandles, AreWhatTheDescriptionSays) {
    const auto device =
        make_simulated_device("simulated:mass=0.2,damping=0,hand=0.1,quantum=50,force=8,stiffness=2", 1);
    ASSERT_TRUE(device);
    EXPECT_EQ((*device)->limits().max_force, 8);
    EXPECT_EQ((*device)->limits().max_stiffness, 2000);
    ASSERT_TRUE((*device)->open());
    (*device)->put(0, {0.01, 0, 0});
    const std::array force{glm::dvec3(0.4, 0, 0)};
    const int ticks = 20;
    for (int tick = 0; tick < ticks; ++tick) {
        ASSERT_TRUE((*device)->write_forces(force));
        (*device)->pass_tick();
    }
    // A swing about 4 mm farther on.
    const double swung = 0.004 * (1 - std::cos(std::sqrt(100 / 0.2) * 0.001 * ticks));
    std::array<glm::dvec3, 1> place{};
    ASSERT_TRUE((*device)->read_positions(place));
    EXPECT_NEAR(place[0].x, 0.01 + swung, 25.1e-6);
    EXPECT_NEAR(std::remainder(place[0].x, 50e-6), 0, 1e-12);
}

TEST(SimulatedHandles, AreLimpOnceTheDeviceIsUnplugged) {
    const auto device = make_simulated_device("simulated:unplug=0.03", 1);
    ASSERT_TRUE(device);
    ASSERT_TRUE((*device)->open());
    const std::array force{glm::dvec3(0.4, 0, 0)};
    for (int tick = 0; tick < 30; ++tick) {
        ASSERT_TRUE((*device)->write_forces(force)) << tick;
        (*device)->pass_tick();
    }
    EXPECT_FALSE((*device)->write_forces(force));
    EXPECT_EQ((*device)->exerted()[0], glm::dvec3(0));
    EXPECT_EQ((*device)->health().error().message, "simulated device was unplugged; open it again");
}

TEST(SimulatedHandles, DescriptionsThatMeanNothingAreRefused) {
    const auto refusal = [](const char* words) { return make_simulated_device(words, 1).error().message; };
    EXPECT_EQ(refusal("falcon"), "unknown device 'falcon'; the one there is is simulated");
    EXPECT_EQ(refusal("simulated:mass=0"),
              "device 'simulated': mass=0 is not allowed; mass takes 0.05 to 10 kg");
    EXPECT_NE(refusal("simulated:weight=1").find("unknown key 'weight'; keys are mass"), std::string::npos);
}

}  // namespace
}  // namespace touchable
