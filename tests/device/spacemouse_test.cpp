#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <thread>

#include "device/drivers/driven_device.hpp"
#include "device/drivers/spacemouse_device.hpp"
#include "tests/device/fake_reports.hpp"

namespace touchable {
namespace {

using std::chrono::microseconds;
constexpr std::int64_t ms = 1'000'000;

SpaceMouseReport decoded(std::initializer_list<int> bytes) {
    const auto report = decode_spacemouse_report(bytes_of(bytes));
    EXPECT_TRUE(report);
    return report ? *report : SpaceMouseReport{};
}

TEST(SpaceMouseProtocol, TranslationIsThreeIntegersWithTheLowByteFirst) {
    const auto report = decoded({0x01, 0x5e, 0x01, 0xa2, 0xfe, 0xff, 0xff});
    EXPECT_EQ(report.translation, glm::ivec3(350, -350, -1));
    EXPECT_FALSE(report.buttons);
}

TEST(SpaceMouseProtocol, SomeModelsSendTheRotationBehindIt) {
    const auto report =
        decoded({0x01, 0x0a, 0x00, 0x00, 0x00, 0xf6, 0xff, 0x5e, 0x01, 0x5e, 0x01, 0x5e, 0x01});
    EXPECT_EQ(report.translation, glm::ivec3(10, 0, -10));
}

TEST(SpaceMouseProtocol, RotationIsNoTranslation) {
    const auto report = decoded({0x02, 0x00, 0x00, 0xe2, 0xff, 0x00, 0x00});
    EXPECT_FALSE(report.translation || report.buttons);
}

TEST(SpaceMouseProtocol, ButtonsAreBits) {
    EXPECT_EQ(decoded({0x03, 0x01, 0x00}).buttons, 1u);
    EXPECT_EQ(decoded({0x03, 0x02, 0x00}).buttons, 2u);
    EXPECT_EQ(decoded({0x03, 0x03, 0x00}).buttons, 3u);
    EXPECT_EQ(decoded({0x03, 0x00, 0x00}).buttons, 0u);
    EXPECT_EQ(decoded({0x03, 0x00, 0x10, 0x00, 0x80, 0xff, 0xff}).buttons, 0x80001000u);
}

TEST(SpaceMouseProtocol, ABatteryTellsNothing) {
    const auto report = decoded({0x17, 0x64});
    EXPECT_FALSE(report.translation || report.buttons);
}

TEST(SpaceMouseProtocol, WhatIsTooShortIsRefused) {
    EXPECT_FALSE(decode_spacemouse_report({}));
    EXPECT_FALSE(decode_spacemouse_report(bytes_of({3})));
    for (const int number : {1, 2}) {
        Bytes bytes = bytes_of({number});
        for (; bytes.size() < 7; bytes.push_back(std::byte{0}))
            EXPECT_FALSE(decode_spacemouse_report(bytes)) << bytes.size();
        EXPECT_TRUE(decode_spacemouse_report(bytes));
    }
}

TEST(SpaceMouseProtocol, IdsAreThoseOfPucksAndNotOfMice) {
    EXPECT_TRUE(is_spacemouse(0x046d, 0xc626));   // SpaceNavigator
    EXPECT_TRUE(is_spacemouse(0x046d, 0xc62b));   // SpaceMouse Pro
    EXPECT_TRUE(is_spacemouse(0x256f, 0xc635));   // SpaceMouse Compact
    EXPECT_TRUE(is_spacemouse(0x256f, 0xc652));   // universal receiver
    EXPECT_FALSE(is_spacemouse(0x046d, 0xc52b));  // Logitech's own receiver
    EXPECT_FALSE(is_spacemouse(0x046d, 0xc077));  // an ordinary mouse
    EXPECT_FALSE(is_spacemouse(0x256f, 0xc650));  // CadMouse
    EXPECT_FALSE(is_spacemouse(0x0403, 0xcb48));
}

TEST(SpaceMouseMotion, AFullPushIsTheSpeedAlongEachAxis) {
    const std::pair<glm::ivec3, glm::dvec3> pushes[] = {
        {{350, 0, 0}, {0.02, 0, 0}}, {{0, 350, 0}, {0, 0, 0.02}}, {{0, 0, 350}, {0, -0.02, 0}}};
    for (const auto& [counts, metres] : pushes) {
        SpaceMouseMotion motion({0.1, 0.08}, 0);
        motion.deflect(counts, 0);
        EXPECT_LT(glm::distance(motion.place(200 * ms), metres), 1e-12);
    }
}

TEST(SpaceMouseMotion, ADiagonalPushIsNotFaster) {
    SpaceMouseMotion motion({0.1, 0.08}, 0);
    motion.deflect({350, 350, -350}, 0);
    EXPECT_NEAR(glm::length(motion.place(100 * ms)), 0.01, 1e-12);
}

TEST(SpaceMouseMotion, ARestingHandDoesNotMoveIt) {
    SpaceMouseMotion motion({0.1, 0.08}, 0);
    motion.deflect({10, -10, 8}, 0);  // 16.2 counts long; the dead zone is 17.5
    EXPECT_EQ(motion.place(200 * ms), glm::dvec3(0));
    // Half-way between the dead zone's 17.5 and 350, half the speed.
    motion.deflect({0, 184, 0}, 200 * ms);
    EXPECT_NEAR(motion.place(300 * ms).z, 0.1 * 0.1 * (184 - 17.5) / (350 - 17.5), 1e-12);
}

TEST(SpaceMouseMotion, SilenceIsAReleasedPuck) {
    SpaceMouseMotion motion({0.1, 0.08}, 0);
    motion.deflect({350, 0, 0}, 0);
    EXPECT_NEAR(motion.place(199 * ms).x, 0.0199, 1e-12);
    EXPECT_NEAR(motion.place(5000 * ms).x, 0.02, 1e-12);
    motion.deflect({350, 0, 0}, 6000 * ms);
    EXPECT_NEAR(motion.place(6010 * ms).x, 0.021, 1e-12);
}

TEST(SpaceMouseMotion, SkippedTurnsDoNotChangeTheWay) {
    SpaceMouseMotion often({0.1, 0.08}, 0), seldom({0.1, 0.08}, 0);
    often.deflect({200, 0, 0}, 0);
    seldom.deflect({200, 0, 0}, 0);
    for (int turn = 1; turn < 150; ++turn) often.place(turn * ms);
    EXPECT_NEAR(often.place(150 * ms).x, seldom.place(150 * ms).x, 1e-12);
}

TEST(SpaceMouseMotion, ItStaysWithinReach) {
    SpaceMouseMotion motion({1, 0.05}, 0);
    for (int turn = 0; turn < 100; ++turn) motion.deflect({350, 350, 350}, turn * 100 * ms);
    EXPECT_EQ(motion.place(10'000 * ms), glm::dvec3(0.05, -0.05, 0.05));
    motion.deflect({-350, 0, 0}, 10'000 * ms);
    EXPECT_NEAR(motion.place(10'010 * ms).x, 0.04, 1e-12);
}

TEST(SpaceMouseKeys, AreReadAndRefused) {
    const auto given = read_spacemouse_settings("speed=0.25,reach=0.05,node=/dev/hidraw7");
    ASSERT_TRUE(given);
    EXPECT_EQ(given->pace.speed, 0.25);
    EXPECT_EQ(given->pace.reach, 0.05);
    EXPECT_EQ(given->node, "/dev/hidraw7");
    for (const char* wrong : {"speed=0", "reach=2", "force=1", "speed", "node="}) {
        const auto refused = read_spacemouse_settings(wrong);
        ASSERT_FALSE(refused) << wrong;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    }
}

struct Puck {
    std::shared_ptr<FakeWire> wire = std::make_shared<FakeWire>();
    SpaceMouseDriver driver{SpaceMousePace{},
                            [wire = wire]() -> Result<std::unique_ptr<ReportTransport>> {
                                return std::unique_ptr<ReportTransport>(std::make_unique<FakeReports>(wire));
                            },
                            [wire = wire] { return wire->now_ns(); }};
    DeviceSample sample;

    bool receive() {
        const auto came = driver.receive(sample, microseconds(5000));
        return came && *came;
    }
};

TEST(SpaceMouseDriver, APuckAtRestIsSilentAndThere) {
    Puck puck;
    ASSERT_TRUE(puck.driver.connect());
    for (int turn = 0; turn < 5000; ++turn) ASSERT_TRUE(puck.receive());
    EXPECT_EQ(puck.sample.metres[0], glm::dvec3(0));
    EXPECT_GE(puck.wire->now_ns(), 5000 * ms);
    EXPECT_EQ(puck.driver.descriptor(), -1);
    EXPECT_EQ(puck.driver.capabilities().axes_driven, 0);
    EXPECT_GT(puck.driver.limits().max_force, 0);
    EXPECT_GT(puck.driver.limits().max_stiffness, 0);
}

TEST(SpaceMouseDriver, PushesMoveItAndButtonsArePressed) {
    Puck puck;
    ASSERT_TRUE(puck.driver.connect());
    puck.wire->lay(bytes_of({0x01, 0x5e, 0x01, 0, 0, 0, 0}));
    puck.wire->lay(bytes_of({0x03, 0x02, 0x00}));
    ASSERT_TRUE(puck.receive());
    EXPECT_EQ(puck.sample.buttons, 2u);
    for (int turn = 0; turn < 50; ++turn) ASSERT_TRUE(puck.receive());
    EXPECT_NEAR(puck.sample.metres[0].x, 0.005, 1e-9);  // 50 ms at 0.1 m/s
    puck.wire->lay(bytes_of({0x01, 0, 0, 0, 0, 0, 0}));
    for (int turn = 0; turn < 50; ++turn) ASSERT_TRUE(puck.receive());
    EXPECT_NEAR(puck.sample.metres[0].x, 0.005, 1e-9);
}

TEST(SpaceMouseDriver, DamagedReportsAreLeftOut) {
    Puck puck;
    ASSERT_TRUE(puck.driver.connect());
    puck.wire->lay(bytes_of({0x01, 0x5e, 0x01}));
    puck.wire->lay(bytes_of({0x03}));
    ASSERT_TRUE(puck.receive());
    EXPECT_EQ(puck.driver.left_out(), 2);
    for (int turn = 0; turn < 10; ++turn) ASSERT_TRUE(puck.receive());
    EXPECT_EQ(puck.sample.metres[0], glm::dvec3(0));
}

TEST(SpaceMouseDriver, OneThatIsPulledOutIsGoneAndComesBack) {
    Puck puck;
    ASSERT_TRUE(puck.driver.connect());
    puck.wire->unplug();
    EXPECT_FALSE(puck.driver.receive(puck.sample, microseconds(1000)));
    puck.driver.disconnect();
    puck.wire->plug_in();
    ASSERT_TRUE(puck.driver.connect());
    EXPECT_TRUE(puck.receive());
}

TEST(SpaceMouseDriver, TheHapticThreadHasAPlaceWhileThePuckRests) {
    auto wire = std::make_shared<FakeWire>();
    wire->waits = true;
    DrivenDevice device(std::make_unique<SpaceMouseDriver>(
        SpaceMousePace{}, [wire]() -> Result<std::unique_ptr<ReportTransport>> {
            return std::unique_ptr<ReportTransport>(std::make_unique<FakeReports>(wire));
        }));
    ASSERT_TRUE(device.open());
    while (device.facts().samples < 30) std::this_thread::yield();
    std::array<glm::dvec3, 1> place{glm::dvec3(std::numeric_limits<double>::quiet_NaN())};
    ASSERT_TRUE(device.read_positions(place));
    EXPECT_EQ(place[0], glm::dvec3(0));
    const std::array<glm::dvec3, 1> force{glm::dvec3(1, 0, 0)};
    EXPECT_TRUE(device.write_forces(force));
    device.close();
    EXPECT_TRUE(wire->sent().empty());
}

}  // namespace
}  // namespace touchable
