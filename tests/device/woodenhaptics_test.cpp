// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "device/drivers/driven_device.hpp"
#include "device/drivers/woodenhaptics_device.hpp"
#include "tests/device/wooden_bench.hpp"
#include "tests/temporary_files.hpp"

namespace touchable {
namespace {

using test::TemporaryFile;

constexpr double quarter = std::numbers::pi / 2;

template <std::size_t n>
Bytes sent_as(const std::array<std::byte, n>& report) {
    return {report.begin(), report.end()};
}

TEST(WoodenProtocol, EncodesCurrents) {
    EXPECT_EQ(sent_as(encode_wooden_currents({1, -2, 0x0102})),
              bytes_of({0x00, 0x01, 0x00, 0xfe, 0xff, 0x02, 0x01, 0, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(sent_as(encode_wooden_currents({-32768, 32767, 0})),
              bytes_of({0x00, 0x00, 0x80, 0xff, 0x7f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(WoodenProtocol, EncodesCountersAsCommandOne) {
    // Its first three stand behind the command, the last three where currents would.
    EXPECT_EQ(sent_as(encode_wooden_counters({0x0a, 0x0b, -1, 0x0d, 0x0e, 0x0f})),
              bytes_of({0x00, 0x0d, 0, 0x0e, 0, 0x0f, 0, 0x01, 0, 0x0a, 0, 0x0b, 0, 0xff, 0xff}));
}

TEST(WoodenProtocol, DecodesCountersAndInfo) {
    const auto reading = decode_wooden_reading(
        bytes_of({0x70, 0x17, 0xff, 0xff, 0x00, 0x80, 0x01, 0x00, 0x02, 0x00, 0x03, 0x00, 0x01, 0x00}));
    ASSERT_TRUE(reading);
    EXPECT_EQ(reading->encoders, (std::array<std::int16_t, 6>{6000, -1, -32768, 1, 2, 3}));
    EXPECT_EQ(reading->info, 1);
}

TEST(WoodenProtocol, RejectsOtherLengths) {
    for (std::size_t bytes = 0; bytes <= 65; ++bytes)
        EXPECT_EQ(bool(decode_wooden_reading(Bytes(bytes))), bytes == 14) << bytes;
}

TEST(WoodenKinematics, ConvertsCountsToAngles) {
    auto build = published_build();
    // A quarter turn of the third joint is three turns of its motor: 12 to 1.
    glm::dvec3 angles = wooden_angles(build, {2000, -4000, 6000});
    EXPECT_NEAR(angles[0], 2 * std::numbers::pi / 16, 1e-15);
    EXPECT_NEAR(angles[1], -2 * std::numbers::pi / 6, 1e-15);
    EXPECT_NEAR(angles[2], quarter, 1e-15);
    build.joints[2].counts_per_turn = -2000;
    EXPECT_NEAR(wooden_angles(build, {0, 0, 6000})[2], -quarter, 1e-15);
}

TEST(WoodenKinematics, MatchesHandComputedPoses) {
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

TEST(WoodenKinematics, JacobianMatchesFiniteDifferences) {
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

TEST(WoodenKinematics, HomeForceUsesOneMotor) {
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

TEST(WoodenKinematics, ReversedMotorFlipsCurrentSign) {
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

TEST(WoodenKinematics, SaturationKeepsDirection) {
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

TEST(WoodenKinematics, WeakForceIsExact) {
    const auto build = published_build();
    const glm::dvec3 angles(0.3, 0.7, 0.9), force(0.4, -0.3, 0.5);
    EXPECT_LT(glm::distance(force_of(build, angles, wooden_currents(build, angles, force)), force), 0.004);
}

std::string example_text() {
    std::ifstream in(std::string(TOUCHABLE_SOURCE_DIR) + "/examples/woodenhaptics.json");
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(WoodenParameters, ExampleMatchesPublishedBuild) {
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

TEST(WoodenParameters, ErrorNamesInvalidField) {
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

TEST(WoodenParameters, RejectTruncatedFile) {
    const std::string whole = example_text();
    ASSERT_GT(whole.size(), 1000u);
    for (std::size_t bytes = 0; bytes + 2 < whole.size(); bytes += 7)
        EXPECT_FALSE(parse_wooden_parameters(whole.substr(0, bytes), "cut.json")) << bytes;
}

TEST(WoodenParameters, RejectUnreadableFile) {
    for (const std::string& file : {std::string("/nowhere/woodenhaptics.json"), std::string("/")}) {
        const auto read = read_wooden_parameters(file);
        ASSERT_FALSE(read);
        EXPECT_EQ(read.error().kind, ErrorKind::input);
        EXPECT_NE(read.error().message.find("examples/woodenhaptics.json"), std::string::npos);
    }
}

TEST(WoodenKeys, RequireFile) {
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

TEST(WoodenIds, MatchFirmware) {
    EXPECT_TRUE(is_woodenhaptics(0x1234, 0x0006));
    EXPECT_FALSE(is_woodenhaptics(0x1234, 0x0007));
}

using std::chrono::microseconds;

WoodenParameters with_button() {
    auto build = published_build();
    build.homing = WoodenParameters::Homing::button;
    return build;
}

TEST(WoodenDriver, StartsUnpoweredAtHome) {
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

TEST(WoodenDriver, SendsCurrentsAndDisconnectsUnpowered) {
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

TEST(WoodenDriver, UndrivenBuildGetsNoCurrent) {
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

TEST(WoodenDriver, ButtonHomingPrecedesPosition) {
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

TEST(WoodenDriver, DamagedButtonReadingsHomeNothing) {
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
        EXPECT_EQ(bench.board->counters[2], 333) << "it is not known to be at home";
    }
}

/// Its counters were lost on the way, and one of its readings is damaged: its button seems to be released.
TEST(WoodenDriver, LostCountersPreventHoming) {
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

TEST(WoodenDriver, TrustsHomedOptionOnce) {
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

TEST(WoodenDriver, ReplugRequiresHoming) {
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

TEST(WoodenDriver, DamagedReadingSetsNoCounters) {
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

TEST(WoodenDriver, SkipsImpossibleReadings) {
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

TEST(WoodenDriver, TakesNewestReading) {
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

TEST(WoodenDriver, DropsSilentBoard) {
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
TEST(WoodenDriver, ForgetsAnswersToOtherProcess) {
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

TEST(WoodenDriver, RejectsBoardWithoutCommands) {
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

TEST(WoodenDriver, ConnectingCanBeCancelled) {
    Bench bench;
    bench.board->silent = true;
    std::stop_source given_up;
    given_up.request_stop();
    const auto connected = work_until(given_up.get_token(), [&] { return bench.connect(); });
    ASSERT_FALSE(connected);
    EXPECT_EQ(connected.error().kind, ErrorKind::interrupted);
}

TEST(WoodenDriver, TellsPositionOnlyWhenAsked) {
    Bench bench;
    ASSERT_TRUE(bench.connect());
    EXPECT_TRUE(bench.driver->capabilities().answers);
    EXPECT_FALSE(*bench.driver->receive(bench.sample, microseconds(5000)));
    EXPECT_TRUE(*bench.turn({0, 0, 0}));
}

TEST(WoodenDriver, ZeroForcePacketLacksCurrents) {
    Bench bench;
    EXPECT_FALSE(bench.driver->zero_force_packet());
    ASSERT_TRUE(bench.connect());
    const auto word = bench.driver->zero_force_packet();
    ASSERT_TRUE(word);
    EXPECT_EQ(word->descriptor, 77);
    EXPECT_EQ(word->bytes, unpowered);
    EXPECT_FALSE(word->usb_endpoint);
}

/// Reports as a bad cable would bring them.
void damage(std::mt19937& random, FakeWire& wire, const Bytes& sound, Bytes& kept) {
    const auto any = [&](int below) { return static_cast<int>(random() % static_cast<unsigned>(below)); };
    switch (any(8)) {
        case 0:
            return;  // lost
        case 1:
            return wire.lay(Bytes(sound.begin(), sound.begin() + any(14)));  // short
        case 2: {
            Bytes broken = sound;
            broken[static_cast<std::size_t>(any(14))] ^= static_cast<std::byte>(1 << any(8));
            return wire.lay(broken);
        }
        case 3:
            wire.lay(sound);
            return wire.lay(sound);  // twice
        case 4:
            kept = sound;
            return;  // late: with the next
        case 5:
            return wire.lay(Bytes(static_cast<std::size_t>(any(65)), static_cast<std::byte>(any(256))));
        case 6:
            return wire.unplug();
        default:
            wire.lay(kept);
            return wire.lay(sound);
    }
}

TEST(WoodenDriver, FaultsNeverLeaveForce) {
    Bench bench;
    bench.wire->remembers = false;
    std::mt19937 random(20);
    std::uniform_real_distribution<double> newton(-30, 30);
    Bytes kept;
    int faults = 0, heard_partings = 0, places = 0;
    bool faulty = false;
    bench.board->silent = true;  // it is answered for
    bench.wire->answer = [&](FakeWire& wire, const Bytes& report) {
        bench.board->hear(wire, report);
        EXPECT_LE(std::abs(bench.board->milliamperes[0]), 1000);
        EXPECT_LE(std::abs(bench.board->milliamperes[1]), 2000);
        EXPECT_LE(std::abs(bench.board->milliamperes[2]), 2000);
        if (!faulty) return wire.lay(bench.board->reading());
        ++faults;
        damage(random, wire, bench.board->reading(), kept);
    };
    while (faults < 10'000) {
        faulty = false;
        bench.wire->plug_in();
        ASSERT_TRUE(bench.connect());
        ASSERT_TRUE(bench.turn(glm::dvec3(0)));
        for (bool held = true; held && faults < 10'000;) {
            faulty = random() % 2 == 0;
            bench.board->pressed = random() % 20 == 0 || bench.board->pressed;
            const bool knew = bench.has_place();
            held = bool(bench.turn({newton(random), newton(random), newton(random)}));
            if (!knew) {
                ASSERT_EQ(bench.board->milliamperes, (std::array<int, 3>{}));
            }
            places += bench.has_place() ? 1 : 0;
        }
        const bool is_in_again = random() % 2 == 0;
        if (is_in_again) bench.wire->plug_in();
        faulty = false;
        bench.driver->disconnect();
        if (is_in_again) {
            ++heard_partings;
            ASSERT_EQ(bench.wire->last_sent(), unpowered);
            ASSERT_EQ(bench.board->milliamperes, (std::array<int, 3>{}));
        }
    }
    EXPECT_GT(heard_partings, 100);
    EXPECT_GT(places, 1000);
}

TEST(WoodenDriver, UnpowersOnSilenceOrUnplugging) {
    auto wire = std::make_shared<FakeWire>();
    wire->waits = true;
    auto board = std::make_shared<Board>();
    wire->answer = [board](FakeWire& on, const Bytes& report) { board->hear(on, report); };
    DrivenDevice device(std::make_unique<WoodenHapticsDriver>(
                            published_build(), false,
                            [wire]() -> Result<std::unique_ptr<ReportTransport>> {
                                return std::unique_ptr<ReportTransport>(std::make_unique<FakeReports>(wire));
                            }),
                        {.away_s = 10, .look_again_s = 0.001});
    ASSERT_TRUE(device.open());
    const std::array<glm::dvec3, 1> push{glm::dvec3(0, 1, 0)};
    std::array<glm::dvec3, 1> place{};
    const auto pushed = [&] { return word_at(wire->last_sent(), 5) == 788; };
    while (!pushed()) {
        ASSERT_TRUE(device.read_positions(place));
        ASSERT_TRUE(device.write_forces(push));
        std::this_thread::yield();
    }
    // No caller writes any more: the device goes unpowered by itself.
    while (wire->last_sent() != unpowered) std::this_thread::yield();
    while (!pushed()) {
        ASSERT_TRUE(device.write_forces(push));
        std::this_thread::yield();
    }
    wire->unplug();
    while (device.facts().losses == 0) std::this_thread::yield();
    wire->plug_in();
    const auto before = device.facts().samples;
    while (device.facts().samples < before + 5) {
        ASSERT_TRUE(device.write_forces(push));
        std::this_thread::yield();
    }
    ASSERT_TRUE(device.read_positions(place));
    EXPECT_TRUE(std::isnan(place[0].x));
    EXPECT_EQ(wire->last_sent(), unpowered);
    device.close();
    EXPECT_EQ(wire->last_sent(), unpowered);
}

}  // namespace
}  // namespace touchable
