#include "device/drivers/woodenhaptics_device.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/device/wooden_bench.hpp"

namespace touchable {
namespace {

using std::chrono::microseconds;

WoodenParameters with_button() {
    auto build = published_build();
    build.homing = WoodenParameters::Homing::button;
    return build;
}

TEST(WoodenDriver, StartsInItsHomePoseWithoutForce) {
    Bench bench;
    ASSERT_TRUE(bench.connect());
    EXPECT_EQ(bench.board->counters[2], 6000);
    EXPECT_EQ(bench.board->milliamperes, (std::array<int, 3>{}));
    for (const Bytes& report : bench.wire->sent())
        EXPECT_TRUE(std::all_of(report.begin() + 1, report.begin() + 7,
                                [](std::byte byte) { return byte == std::byte{0}; }));
    const auto came = bench.turn(glm::dvec3(0));
    ASSERT_TRUE(came && *came);
    EXPECT_NEAR(bench.sample.metres[0].y, 0.205, 1e-9);
    EXPECT_NEAR(bench.sample.metres[0].z, 0.025, 1e-9);
    EXPECT_TRUE(bench.driver->prompt().empty());
}

TEST(WoodenDriver, ForcesAreCurrentsAndPartingIsLimp) {
    Bench bench;
    ASSERT_TRUE(bench.connect());
    ASSERT_TRUE(bench.turn({0, 1, 0}));
    EXPECT_EQ(bench.board->milliamperes, (std::array<int, 3>{0, 0, 788}));
    const std::size_t before = bench.wire->sent().size();
    bench.driver->disconnect();
    EXPECT_EQ(bench.wire->last_sent(), unpowered);
    EXPECT_EQ(bench.board->milliamperes, (std::array<int, 3>{}));
    const auto sent = bench.wire->sent();
    EXPECT_EQ(std::vector(sent.begin() + static_cast<std::ptrdiff_t>(before), sent.end()),
              std::vector(2, unpowered))
        << "one may be lost";
}

TEST(WoodenDriver, OneThatMustNotBeDrivenGetsNoCurrent) {
    auto build = published_build();
    build.drive = false;
    Bench bench(build);
    ASSERT_TRUE(bench.connect());
    ASSERT_TRUE(bench.turn({5, 5, 5}));
    EXPECT_EQ(bench.wire->last_sent(), unpowered);
    EXPECT_TRUE(bench.has_place());
    EXPECT_EQ(bench.driver->capabilities().axes_driven, 0);
    EXPECT_NE(bench.driver->name().find("no force"), std::string::npos);
}

TEST(WoodenDriver, WithAButtonItHasNoPlaceUntilItWasPressed) {
    Bench bench(with_button());
    bench.board->counters = {111, 222, 333, 0, 0, 0};
    ASSERT_TRUE(bench.connect());
    for (int turn = 0; turn < 100; ++turn) {
        ASSERT_TRUE(bench.turn({0, 1, 0}));
        ASSERT_FALSE(bench.has_place());
        ASSERT_EQ(bench.wire->last_sent(), unpowered);
    }
    EXPECT_NE(bench.driver->prompt().find("button"), std::string::npos);
    bench.board->pressed = true;
    for (int turn = 0; turn < 6; ++turn) ASSERT_TRUE(bench.turn({0, 0, 0}));
    EXPECT_TRUE(bench.has_place());
    EXPECT_FALSE(bench.board->pressed);
    EXPECT_EQ(bench.board->counters[2], 6000);
    EXPECT_NEAR(bench.sample.metres[0].y, 0.205, 1e-9);
    EXPECT_TRUE(bench.driver->prompt().empty());
}

TEST(WoodenDriver, TwoDamagedReadingsOfItsButtonHomeNothing) {
    Bench bench(with_button());
    bench.board->counters = {111, 222, 333, 0, 0, 0};
    ASSERT_TRUE(bench.connect());
    for (const int damaged : {1, 2}) {
        for (int reading = 0; reading < damaged; ++reading)
            bench.wire->lay(bytes_of({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 0x01, 0x00}));
        ASSERT_TRUE(bench.driver->receive(bench.sample, microseconds(0)));
        for (int turn = 0; turn < 10; ++turn) {
            ASSERT_TRUE(bench.turn({0, 1, 0}));
            EXPECT_FALSE(bench.has_place()) << damaged;
            EXPECT_EQ(bench.wire->last_sent(), unpowered);
        }
        EXPECT_EQ(bench.board->counters[2], 333) << "nobody knows that it is at home";
    }
}

/// Its counters were lost on the way, and one of its readings is damaged: its button seems to be released.
TEST(WoodenDriver, ABoardThatDidNotTakeItsCountersIsNotAtHome) {
    Bench bench(with_button());
    bench.board->counters = {111, 222, 333, 0, 0, 0};
    ASSERT_TRUE(bench.connect());
    bench.wire->answer = {};
    bench.board->pressed = true;
    for (int reading = 0; reading < 3; ++reading) bench.wire->lay(bench.board->reading());
    ASSERT_TRUE(bench.driver->receive(bench.sample, microseconds(0)));
    const std::array<glm::dvec3, 1> push{glm::dvec3(0, 1, 0)};
    ASSERT_TRUE(bench.driver->send(push));
    EXPECT_EQ(word_at(bench.wire->last_sent(), 7), 1) << "its counters";
    bench.board->pressed = false;
    bench.wire->lay(bench.board->reading());
    ASSERT_TRUE(bench.driver->receive(bench.sample, microseconds(0)));
    EXPECT_FALSE(bench.has_place());
    ASSERT_TRUE(bench.driver->send(push));
    EXPECT_EQ(bench.wire->last_sent(), unpowered);
}

TEST(WoodenDriver, ABoardThatWasHomedMaySoBeTakenOnce) {
    Bench bench(with_button(), true);
    bench.board->counters[2] = 6000;
    ASSERT_TRUE(bench.connect());
    ASSERT_TRUE(bench.turn({0, 1, 0}));
    EXPECT_TRUE(bench.has_place());
    bench.driver->disconnect();
    ASSERT_TRUE(bench.connect());
    ASSERT_TRUE(bench.turn({0, 1, 0}));
    EXPECT_FALSE(bench.has_place());
}

TEST(WoodenDriver, OneThatWasAwayIsNotTakenToBeAtHome) {
    Bench bench;
    ASSERT_TRUE(bench.connect());
    bench.wire->unplug();
    EXPECT_FALSE(bench.turn({0, 1, 0}));
    bench.driver->disconnect();
    bench.wire->plug_in();
    bench.board->counters = {};
    ASSERT_TRUE(bench.connect());
    for (int turn = 0; turn < 10; ++turn) ASSERT_TRUE(bench.turn({0, 1, 0}));
    EXPECT_FALSE(bench.has_place());
    EXPECT_EQ(bench.wire->last_sent(), unpowered);
    EXPECT_NE(bench.driver->prompt().find("away"), std::string::npos);
    bench.board->pressed = true;
    for (int turn = 0; turn < 6; ++turn) ASSERT_TRUE(bench.turn({0, 0, 0}));
    EXPECT_TRUE(bench.has_place());
}

TEST(WoodenDriver, OneDamagedReadingDoesNotSetTheCounters) {
    Bench bench;
    ASSERT_TRUE(bench.connect());
    bench.board->counters = {100, 200, 6100, 0, 0, 0};
    ASSERT_TRUE(bench.turn({0, 0, 0}));
    bench.wire->lay(bytes_of({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 0x01, 0x00}));
    ASSERT_TRUE(bench.driver->receive(bench.sample, microseconds(0)));
    EXPECT_FALSE(bench.has_place());
    ASSERT_TRUE(bench.turn({0, 1, 0}));
    EXPECT_TRUE(bench.has_place());
    EXPECT_EQ(bench.board->counters[2], 6100);
}

TEST(WoodenDriver, WhatCannotBeIsLeftOut) {
    Bench bench;
    ASSERT_TRUE(bench.connect());
    ASSERT_TRUE(bench.turn({0, 0, 0}));
    const glm::dvec3 before = bench.sample.metres[0];
    bench.wire->lay(bytes_of({1, 2, 3}));
    bench.wire->lay(Bytes(64, std::byte{0x55}));
    bench.wire->lay(bytes_of({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 0x77, 0x12}));
    const auto came = bench.driver->receive(bench.sample, microseconds(0));
    ASSERT_TRUE(came);
    EXPECT_FALSE(*came);
    EXPECT_EQ(bench.sample.metres[0], before);
    EXPECT_EQ(bench.driver->left_out(), 3);
}

TEST(WoodenDriver, TheNewestOfManyReadingsCounts) {
    Bench bench;
    ASSERT_TRUE(bench.connect());
    for (int late = 0; late < 20; ++late) {
        bench.board->counters = {0, 0, 6000 + 10 * late, 0, 0, 0};
        bench.wire->lay(bench.board->reading());
    }
    ASSERT_TRUE(bench.driver->receive(bench.sample, microseconds(0)));
    EXPECT_NEAR(bench.sample.metres[0].y, 0.205 - 0.245 * std::cos(2 * std::acos(-1.0) * 6190 / 2000 / 12),
                1e-9);
}

TEST(WoodenDriver, ABoardThatFallsSilentIsGone) {
    Bench bench;
    ASSERT_TRUE(bench.connect());
    bench.board->silent = true;
    int turns = 0;
    while (bench.turn({0, 0, 0})) ASSERT_LT(++turns, 1000);
    EXPECT_NEAR(5 * turns, 1000, 5) << "milliseconds: it is gone after a second";
    bench.driver->disconnect();
    const auto again = bench.connect();
    ASSERT_FALSE(again);
    EXPECT_EQ(again.error().kind, ErrorKind::device);
    EXPECT_NE(again.error().message.find("14 bytes"), std::string::npos);
}

/// Answers to another process, which spoke to it while this one stood still.
TEST(WoodenDriver, WhatCameWhileNobodyAskedIsForgotten) {
    Bench bench;
    ASSERT_TRUE(bench.connect());
    ASSERT_TRUE(bench.turn({0, 0, 0}));
    bench.board->silent = true;
    for (int answers = 0; answers < 40; ++answers) bench.wire->lay(bench.board->reading());
    bench.wire->pass(2 * WoodenHapticsDriver::silent_ns);
    ASSERT_TRUE(bench.driver->forget_what_came());
    const auto came = bench.turn({0, 0, 0});
    ASSERT_TRUE(came) << came.error().message;
    EXPECT_FALSE(*came);
}

TEST(WoodenDriver, ABoardWithoutCommandsIsRefused) {
    Bench bench;
    bench.wire->answer = [](FakeWire& wire, const Bytes&) {
        wire.pass(1'000'000);
        wire.lay(Bytes(14, std::byte{0}));
    };
    const auto connected = bench.connect();
    ASSERT_FALSE(connected);
    EXPECT_NE(connected.error().message.find("home pose"), std::string::npos);
    bench.driver->disconnect();
    EXPECT_FALSE(bench.connect()) << "it was never held, so it was never away";
}

TEST(WoodenDriver, WaitingForItCanBeGivenUp) {
    Bench bench;
    bench.board->silent = true;
    std::stop_source given_up;
    given_up.request_stop();
    const auto connected = work_until(given_up.get_token(), [&] { return bench.connect(); });
    ASSERT_FALSE(connected);
    EXPECT_EQ(connected.error().kind, ErrorKind::interrupted);
}

TEST(WoodenDriver, ItTellsAPlaceForEachReportAndNotByItself) {
    Bench bench;
    ASSERT_TRUE(bench.connect());
    EXPECT_TRUE(bench.driver->capabilities().answers);
    EXPECT_FALSE(*bench.driver->receive(bench.sample, microseconds(5000)));
    EXPECT_TRUE(*bench.turn({0, 0, 0}));
}

TEST(WoodenDriver, ItsZeroForcePacketIsAReportWithoutCurrents) {
    Bench bench;
    EXPECT_FALSE(bench.driver->zero_force_packet());
    ASSERT_TRUE(bench.connect());
    const auto word = bench.driver->zero_force_packet();
    ASSERT_TRUE(word);
    EXPECT_EQ(word->descriptor, 77);
    EXPECT_EQ(word->bytes, unpowered);
    EXPECT_FALSE(word->usb_endpoint);
}

}  // namespace
}  // namespace touchable
