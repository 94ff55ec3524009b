#include "device/simulated_device.hpp"

#include <gtest/gtest.h>

#include <array>
#include <glm/geometric.hpp>
#include <limits>

namespace touchable {
namespace {

using Forces = std::array<glm::dvec3, 2>;

class SafetyContract : public ::testing::Test {
protected:
    bool push() {
        const Forces forces{glm::dvec3(1, 2, 0), glm::dvec3(0, 0, 3)};
        return device.write_forces(forces);
    }
    bool limp() const { return device.exerted()[0] == glm::dvec3(0) && device.exerted()[1] == glm::dvec3(0); }

    SimulatedDevice device{2, {.max_force = 8, .max_stiffness = 2000}};
};

TEST_F(SafetyContract, ExertsWhatIsWrittenAndReportsWhereItsFingersAre) {
    ASSERT_TRUE(device.open().ok());
    EXPECT_TRUE(limp());
    ASSERT_TRUE(push());
    EXPECT_EQ(device.exerted()[0], glm::dvec3(1, 2, 0));
    EXPECT_EQ(device.exerted()[1], glm::dvec3(0, 0, 3));
    device.move(1, {0.01, 0.02, 0.03});
    std::array<glm::dvec3, 2> positions{};
    ASSERT_TRUE(device.read_positions(positions));
    EXPECT_EQ(positions[0], glm::dvec3(0));
    EXPECT_EQ(positions[1], glm::dvec3(0.01, 0.02, 0.03));
    EXPECT_TRUE(device.health().ok());
}

TEST_F(SafetyContract, ClosingLeavesZeroForce) {
    ASSERT_TRUE(device.open().ok());
    ASSERT_TRUE(push());
    device.close();
    EXPECT_TRUE(limp());
    EXPECT_FALSE(push());
    EXPECT_TRUE(limp());
}

TEST_F(SafetyContract, NothingIsExertedBeforeOpening) {
    EXPECT_FALSE(push());
    EXPECT_TRUE(limp());
}

TEST_F(SafetyContract, FailingLeavesZeroForceAndAReasonUntilOpenedAgain) {
    ASSERT_TRUE(device.open().ok());
    ASSERT_TRUE(push());
    device.fail("was unplugged");
    EXPECT_TRUE(limp());
    std::array<glm::dvec3, 2> positions{};
    EXPECT_FALSE(push());
    EXPECT_FALSE(device.read_positions(positions));
    EXPECT_TRUE(limp());
    ASSERT_FALSE(device.health().ok());
    EXPECT_EQ(device.health().error().kind, ErrorKind::device);
    EXPECT_EQ(device.health().error().message, "simulated device was unplugged; open it again");
    ASSERT_TRUE(device.open().ok());
    EXPECT_TRUE(limp());
    EXPECT_TRUE(push());
}

TEST_F(SafetyContract, SilenceLeavesZeroForce) {
    ASSERT_TRUE(device.open().ok());
    for (int tick = 0; tick < 200; ++tick) {
        ASSERT_TRUE(push());
        device.pass_time(0.001);
        EXPECT_FALSE(limp());
    }
    device.pass_time(0.049);
    EXPECT_FALSE(limp());
    device.pass_time(0.002);
    EXPECT_TRUE(limp());
    EXPECT_TRUE(push()) << "a caller that speaks again is heard";
    EXPECT_FALSE(limp());
}

TEST_F(SafetyContract, TooLargeAForceIsShortenedAlongItsDirection) {
    ASSERT_TRUE(device.open().ok());
    const Forces forces{glm::dvec3(0, 30, -40), glm::dvec3(0, 0, 8)};
    ASSERT_TRUE(device.write_forces(forces));
    EXPECT_NEAR(glm::length(device.exerted()[0] - glm::dvec3(0, 4.8, -6.4)), 0, 1e-12);
    EXPECT_EQ(device.exerted()[1], glm::dvec3(0, 0, 8));
}

TEST_F(SafetyContract, AForceThatIsNotFiniteLeavesZeroForceOnEveryFinger) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
        ASSERT_TRUE(device.open().ok());
        ASSERT_TRUE(push());
        const Forces forces{glm::dvec3(1, 0, 0), glm::dvec3(0, bad, 0)};
        EXPECT_FALSE(device.write_forces(forces));
        EXPECT_TRUE(limp());
        EXPECT_FALSE(device.health().ok());
    }
}

}  // namespace
}  // namespace touchable
