#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <iterator>
#include <numbers>
#include <random>
#include <string>

#include "device/drivers/woodenhaptics_device.hpp"
#include "tests/device/fake_reports.hpp"
#include "tests/device/temporary_file.hpp"
#include "tests/device/wooden_build.hpp"

namespace touchable {
namespace {

constexpr double quarter = std::numbers::pi / 2;

template <std::size_t n>
Bytes sent_as(const std::array<std::byte, n>& report) {
    return {report.begin(), report.end()};
}

TEST(WoodenProtocol, CurrentsAreIntegersBehindAZero) {
    EXPECT_EQ(sent_as(encode_wooden_currents({1, -2, 0x0102})),
              bytes_of({0x00, 0x01, 0x00, 0xfe, 0xff, 0x02, 0x01, 0, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(sent_as(encode_wooden_currents({-32768, 32767, 0})),
              bytes_of({0x00, 0x00, 0x80, 0xff, 0x7f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(WoodenProtocol, CountersAreCommandOneAndNoCurrents) {
    // Its first three stand behind the command, the last three where currents would.
    EXPECT_EQ(sent_as(encode_wooden_counters({0x0a, 0x0b, -1, 0x0d, 0x0e, 0x0f})),
              bytes_of({0x00, 0x0d, 0, 0x0e, 0, 0x0f, 0, 0x01, 0, 0x0a, 0, 0x0b, 0, 0xff, 0xff}));
}

TEST(WoodenProtocol, AReadingIsSixCountersAndItsInfo) {
    const auto reading = decode_wooden_reading(
        bytes_of({0x70, 0x17, 0xff, 0xff, 0x00, 0x80, 0x01, 0x00, 0x02, 0x00, 0x03, 0x00, 0x01, 0x00}));
    ASSERT_TRUE(reading);
    EXPECT_EQ(reading->encoders, (std::array<std::int16_t, 6>{6000, -1, -32768, 1, 2, 3}));
    EXPECT_EQ(reading->info, 1);
}

TEST(WoodenProtocol, AnyOtherLengthIsRefused) {
    for (std::size_t bytes = 0; bytes <= 65; ++bytes)
        EXPECT_EQ(bool(decode_wooden_reading(Bytes(bytes))), bytes == 14) << bytes;
}

TEST(WoodenKinematics, CountsTurnJointsByTheCable) {
    auto build = published_build();
    // A quarter turn of the third joint is three turns of its motor: 12 to 1.
    glm::dvec3 angles = wooden_angles(build, {2000, -4000, 6000});
    EXPECT_NEAR(angles[0], 2 * std::numbers::pi / 16, 1e-15);
    EXPECT_NEAR(angles[1], -2 * std::numbers::pi / 6, 1e-15);
    EXPECT_NEAR(angles[2], quarter, 1e-15);
    build.joints[2].counts_per_turn = -2000;
    EXPECT_NEAR(wooden_angles(build, {0, 0, 6000})[2], -quarter, 1e-15);
}

TEST(WoodenKinematics, PosesWorkedOutByHand) {
    const auto build = published_build();
    const std::pair<glm::dvec3, glm::dvec3> poses[] = {
        // One link up, the other to the person: 245 mm out of 220, 80 + 205 up of 80.
        {{0, 0, quarter}, {0, 0.205, 0.025}},
        // Both to the person.
        {{0, quarter, quarter}, {0, 0, 0.23}},
        // The same turned a quarter to the right: 450 mm right, 220 behind the centre.
        {{quarter, quarter, quarter}, {0.45, 0, -0.22}},
        // One up, one down: at the axle, 205 - 245 mm from the base's 80.
        {{0, 0, 0}, {0, -0.04, -0.22}}};
    for (const auto& [angles, place] : poses)
        EXPECT_LT(glm::distance(wooden_place(build, angles), place), 1e-15);
}

TEST(WoodenKinematics, TheJacobianIsWhatSmallTurnsDo) {
    const auto build = published_build();
    std::mt19937 random(17);
    std::uniform_real_distribution<double> angle(-1.5, 1.5);
    for (int pose = 0; pose < 1000; ++pose) {
        const glm::dvec3 angles(angle(random), angle(random), angle(random));
        const glm::dmat3 jacobian = wooden_jacobian(build, angles);
        for (int joint = 0; joint < 3; ++joint) {
            glm::dvec3 turn(0);
            turn[joint] = 1e-5;
            const glm::dvec3 slope =
                (wooden_place(build, angles + turn) - wooden_place(build, angles - turn)) / 2e-5;
            EXPECT_LT(glm::distance(jacobian[joint], slope), 1e-9);
        }
    }
}

TEST(WoodenKinematics, AForceUpIsOneMotorsAtTheHomePose) {
    // 1 N at the end of a level link of 245 mm, by a cable of 12 to 1, at 25.9 mN m/A: 788.3 mA.
    EXPECT_EQ(wooden_currents(published_build(), {0, 0, quarter}, {0, 1, 0}),
              (std::array<std::int16_t, 3>{0, 0, 788}));
    // 0.5 N to the right: 245 mm from the vertical axle, 16 to 1: 295.6 mA.
    EXPECT_EQ(wooden_currents(published_build(), {0, 0, quarter}, {0.5, 0, 0}),
              (std::array<std::int16_t, 3>{295, 0, 0}));
    // 1 N away from the person, against the link of 205 mm that stands: -659.6 mA.
    EXPECT_EQ(wooden_currents(published_build(), {0, 0, quarter}, {0, 0, -1}),
              (std::array<std::int16_t, 3>{0, -659, 0}));
}

TEST(WoodenKinematics, AMotorThatTurnsTheOtherWayGetsTheOtherSign) {
    auto build = published_build();
    build.joints[2].torque_constant = -0.0259;
    EXPECT_EQ(wooden_currents(build, {0, 0, quarter}, {0, 1, 0}), (std::array<std::int16_t, 3>{0, 0, -788}));
}

/// The force that currents exert: the torques that they make, seen from the handle.
glm::dvec3 force_of(const WoodenParameters& build, const glm::dvec3& angles,
                    const std::array<std::int16_t, 3>& currents) {
    glm::dvec3 torques;
    for (int joint = 0; joint < 3; ++joint) {
        const auto& motor = build.joints[static_cast<std::size_t>(joint)];
        torques[joint] =
            currents[static_cast<std::size_t>(joint)] / 1000.0 * motor.torque_constant / motor.cable_ratio;
    }
    return glm::inverse(glm::transpose(wooden_jacobian(build, angles))) * torques;
}

TEST(WoodenKinematics, ASaturatedForceKeepsItsDirection) {
    const auto build = published_build();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> part(-1, 1), far(0.5, 1.2);
    for (int push = 0; push < 10'000; ++push) {
        const glm::dvec3 angles(part(random), far(random), far(random));
        const glm::dvec3 force = glm::normalize(glm::dvec3(part(random), part(random), part(random))) *
                                 (push % 2 == 0 ? 50.0 : 1e6);
        const auto currents = wooden_currents(build, angles, force);
        EXPECT_LE(std::abs(currents[0]), 1000);
        EXPECT_LE(std::abs(currents[1]), 2000);
        EXPECT_LE(std::abs(currents[2]), 2000);
        const glm::dvec3 felt = force_of(build, angles, currents);
        EXPECT_GT(glm::dot(felt, force) / glm::length(felt) / glm::length(force), 0.999);
        EXPECT_LT(glm::length(felt), glm::length(force));
    }
}

TEST(WoodenKinematics, AWeakForceIsExertedAsItIs) {
    const auto build = published_build();
    const glm::dvec3 angles(0.3, 0.7, 0.9), force(0.4, -0.3, 0.5);
    EXPECT_LT(glm::distance(force_of(build, angles, wooden_currents(build, angles, force)), force), 0.004);
}

std::string example_text() {
    std::ifstream in(std::string(TOUCHABLE_SOURCE_DIR) + "/examples/woodenhaptics.json");
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(WoodenParameters, TheExampleIsThePublishedBuildAndIsNotDriven) {
    const auto read =
        read_wooden_parameters(std::string(TOUCHABLE_SOURCE_DIR) + "/examples/woodenhaptics.json");
    ASSERT_TRUE(read) << read.error().message;
    const auto right = published_build();
    EXPECT_FALSE(read->drive);
    EXPECT_EQ(read->links, right.links);
    EXPECT_EQ(read->origin, right.origin);
    EXPECT_EQ(read->limits.max_force, 5);
    EXPECT_EQ(read->limits.max_stiffness, 1000);
    for (std::size_t joint = 0; joint < 3; ++joint) {
        EXPECT_EQ(read->joints[joint].counts_per_turn, right.joints[joint].counts_per_turn);
        EXPECT_DOUBLE_EQ(read->joints[joint].cable_ratio, right.joints[joint].cable_ratio);
        EXPECT_EQ(read->joints[joint].torque_constant, right.joints[joint].torque_constant);
        EXPECT_EQ(read->joints[joint].most_amperes, right.joints[joint].most_amperes);
        EXPECT_EQ(read->joints[joint].home_counts, right.joints[joint].home_counts);
    }
}

TEST(WoodenParameters, WhatIsWrongIsNamed) {
    const struct {
        const char *from, *to, *named;
    } changes[] = {
        {"\"drive\": \"no\"", "\"drive\": \"perhaps\"", "drive"},
        {"\"drive\": \"no\",", "", "drive is missing"},
        {"\"reach\": 0.1", "\"reach\": 0.1, \"reach\": 0.2", "twice"},
        {"\"reach\": 0.1", "\"reach\": -0.1", "reach"},
        {"\"reach\": 0.1", "\"reech\": 0.1", "reech"},
        {"\"homing\": \"start\"", "\"homing\": \"maybe\"", "homing"},
        {"[0.080, 0.205, 0.245]", "[0.080, 0.205]", "links"},
        {"[0.080, 0.205, 0.245]", "[0.080, 0, 0.245]", "links[1]"},
        {"\"counts_per_turn\": 2000", "\"counts_per_turn\": 0", "joints[0].counts_per_turn"},
        {"\"torque_constant\": 0.0259", "\"torque_constant\": 1e300", "joints[0].torque_constant"},
        {"\"capstan_diameter\": 0.010, \"drum_diameter\": 0.160",
         "\"capstan_diameter\": 0.09, \"drum_diameter\": 0.08", "joints[0].capstan_diameter"},
        {"\"home_counts\": 6000", "\"home_counts\": 40000", "joints[2].home_counts"},
        {"\"most_force\": 5", "\"most_force\": 5000", "most_force"},
        {"\"touchable_woodenhaptics\": 1", "\"touchable_woodenhaptics\": 2", "touchable_woodenhaptics"},
    };
    for (const auto& change : changes) {
        std::string text = example_text();
        const auto at = text.find(change.from);
        ASSERT_NE(at, std::string::npos) << change.from;
        text.replace(at, std::string(change.from).size(), change.to);
        const auto read = parse_wooden_parameters(text, "mine.json");
        ASSERT_FALSE(read) << change.to;
        EXPECT_EQ(read.error().kind, ErrorKind::input);
        EXPECT_NE(read.error().message.find("mine.json"), std::string::npos);
        EXPECT_NE(read.error().message.find(change.named), std::string::npos) << read.error().message;
        EXPECT_EQ(read.error().message.find('\n'), std::string::npos);
    }
}

TEST(WoodenParameters, AFileCutAnywhereIsRefused) {
    const std::string whole = example_text();
    ASSERT_GT(whole.size(), 1000u);
    for (std::size_t bytes = 0; bytes + 2 < whole.size(); bytes += 7)
        EXPECT_FALSE(parse_wooden_parameters(whole.substr(0, bytes), "cut.json")) << bytes;
}

TEST(WoodenParameters, AFileThatIsNoneIsRefused) {
    for (const std::string& file : {std::string("/nowhere/woodenhaptics.json"), std::string("/")}) {
        const auto read = read_wooden_parameters(file);
        ASSERT_FALSE(read);
        EXPECT_EQ(read.error().kind, ErrorKind::input);
        EXPECT_NE(read.error().message.find("examples/woodenhaptics.json"), std::string::npos);
    }
}

TEST(WoodenKeys, TheFileMustBeNamed) {
    const auto given = read_wooden_settings("file=mine.json,node=/dev/hidraw3,homed=1");
    ASSERT_TRUE(given);
    EXPECT_EQ(given->file, "mine.json");
    EXPECT_EQ(given->node, "/dev/hidraw3");
    EXPECT_TRUE(given->homed);
    for (const char* wrong : {"", "homed=1", "file=a,homed=2", "file=a,force=3"}) {
        const auto refused = read_wooden_settings(wrong);
        ASSERT_FALSE(refused) << wrong;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    }
    const TemporaryFile bad("bad.json", "{}");
    const auto made = make_woodenhaptics_driver("file=" + bad.path());
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().kind, ErrorKind::input);
}

TEST(WoodenIds, AreThoseOfItsFirmware) {
    EXPECT_TRUE(is_woodenhaptics(0x1234, 0x0006));
    EXPECT_FALSE(is_woodenhaptics(0x1234, 0x0007));
}

}  // namespace
}  // namespace touchable
