// SPDX-License-Identifier: Apache-2.0
// The safety contract of every backend, in virtual time: a tick is a reading, a force and a turn of the
// device's thread.

#include <gtest/gtest.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>
#include <glm/geometric.hpp>

#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "device/drivers/driven_device.hpp"
#include "device/haptic_device.hpp"
#include "device/point_motion.hpp"
#include "tests/device/fake_driver.hpp"
#include "tests/device/fault_sessions.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
using Fault = FakeHardware::Fault;

class DeviceDrive : public testing::Test {
protected:
    DeviceDrive() { EXPECT_TRUE(device.open()); }
    bool turn() {
        now += ms;
        return device.turn();
    }
    /// A haptic tick, then the device's: what the hardware exerts afterwards.
    glm::dvec3 tick(const glm::dvec3& newtons) {
        reads = device.read_positions(std::span(&place, 1));
        writes = device.write_forces(std::span(&newtons, 1));
        turn();
        return hardware.force;
    }
    void settle() {
        for (int turns = 0; turns < 105; ++turns) tick({0, 0, 1});
        ASSERT_EQ(hardware.force, glm::dvec3(0, 0, 1));
    }

    std::int64_t now = ms;
    FakeHardware hardware;
    DrivenDevice device{
        std::make_unique<FakeDriver>(hardware),
        {.away_s = 2, .look_again_s = 0.1, .clock = [this] { return now; }, .own_thread = false}};
    glm::dvec3 place{0.0};
    bool reads = false, writes = false;
};

TEST_F(DeviceDrive, ReadsPositionsAndExertsForces) {
    hardware.place = {0.01, 0.02, 0.03};
    hardware.buttons = 2;
    settle();
    EXPECT_TRUE(reads && writes);
    EXPECT_EQ(place, glm::dvec3(0.01, 0.02, 0.03));
    EXPECT_EQ(device.buttons(), 2U);
    EXPECT_LE(device.age_s(), 0.0011);
    EXPECT_TRUE(device.health());
}

TEST_F(DeviceDrive, ForceIsZeroUntilRequested) {
    for (int turns = 0; turns < 5; ++turns) turn();
    EXPECT_GT(hardware.sent, 3) << "zeros go out all the same";
    EXPECT_EQ(hardware.force, glm::dvec3(0));
}

TEST_F(DeviceDrive, ShortensForceBeyondLimit) {
    settle();
    const glm::dvec3 force = tick({30, 0, -40});
    EXPECT_NEAR(glm::length(force), 10, 1e-12);
    EXPECT_NEAR(force.x / force.z, -0.75, 1e-12);
}

TEST_F(DeviceDrive, ForceRisesWithinItsCeiling) {
    for (int turns = 0; turns < 150; ++turns) {
        const double force = glm::length(tick({300, -400, 0}));
        ASSERT_LE(force, std::min(10.0, 0.1 * turns + 0.1) + 1e-12) << turns;
        ASSERT_GE(force, std::min(10.0, 0.1 * turns - 0.2) - 1e-12) << turns;
    }
}

TEST_F(DeviceDrive, LateTurnLimitsForceRise) {
    double before = 0;
    for (int turns = 0; turns < 30; ++turns) before = tick({0, 0, 10}).z;
    ASSERT_GT(before, 2.5);
    now += 14 * ms;
    const double after = tick({0, 0, 10}).z;
    EXPECT_GT(after, before);
    EXPECT_LE(after - before, 0.7) << "five milliseconds of a tenth of a second, and a tick of headroom";
    for (int turns = 0; turns < 100; ++turns) tick({0, 0, 10});
    EXPECT_EQ(hardware.force, glm::dvec3(0, 0, 10));
}

TEST_F(DeviceDrive, UnpowersWhenCallerIsSilent) {
    settle();
    int exerted = 0;
    for (; exerted < 100 && turn() && hardware.force != glm::dvec3(0); ++exerted) {
    }
    EXPECT_GE(exerted, 48);
    EXPECT_LE(exerted, 50);
}

TEST_F(DeviceDrive, UnpowersWhenDeviceIsSilent) {
    hardware.buttons = 3;
    settle();
    EXPECT_EQ(device.buttons(), 3U);
    hardware.fault = Fault::silent;
    int exerted = 0;
    while (exerted < 100 && tick({0, 0, 1}) != glm::dvec3(0)) {
        EXPECT_TRUE(std::isfinite(place.x));
        ++exerted;
    }
    EXPECT_GE(exerted, 19);
    EXPECT_LE(exerted, 20);
    tick({0, 0, 1});
    tick({0, 0, 1});
    EXPECT_TRUE(reads) << "it has not failed, it has nothing to say";
    EXPECT_TRUE(std::isnan(place.x));
    EXPECT_EQ(device.buttons(), 0U);
    hardware.fault = Fault::none;
    tick({0, 0, 1});
    tick({0, 0, 1});
    EXPECT_TRUE(std::isfinite(place.x));
    EXPECT_EQ(device.buttons(), 3U);
}

TEST_F(DeviceDrive, DropsForceFromBeforeGap) {
    settle();
    hardware.fault = Fault::leap;
    EXPECT_EQ(hardware.force, glm::dvec3(0, 0, 1));
    for (int turns = 0; turns < 15; ++turns) tick({0, 0, 1});
    EXPECT_EQ(hardware.force, glm::dvec3(0, 0, 1)) << "its last place is not old yet";
    for (int turns = 0; turns < 10; ++turns) tick({0, 0, 1});
    EXPECT_EQ(hardware.force, glm::dvec3(0)) << "it has no place";
    hardware.fault = Fault::none;
    turn();
    turn();
    EXPECT_EQ(hardware.force, glm::dvec3(0)) << "what was asked for answers another place";
    double before = 0;
    for (int turns = 0; turns < 105; ++turns) {
        const double now_felt = tick({0, 0, 1}).z;
        EXPECT_LE(now_felt - before, 0.0101) << "it rises";
        before = now_felt;
    }
    EXPECT_EQ(before, 1);
}

TEST_F(DeviceDrive, UnpowersFingerWithoutPosition) {
    settle();
    hardware.fault = Fault::no_place;
    tick({0, 0, 1});
    EXPECT_EQ(tick({0, 0, 1}), glm::dvec3(0)) << "its last place is not old, but it is not there any more";
    EXPECT_TRUE(std::isnan(place.x));
    EXPECT_TRUE(device.health());
}

TEST_F(DeviceDrive, ReopeningForgetsPositionAndButtons) {
    hardware.buttons = 1;
    hardware.over = true;
    settle();
    device.close();
    hardware.fault = Fault::silent;
    hardware.over = false;
    ASSERT_TRUE(device.open());
    EXPECT_FALSE(device.is_over());
    for (int turns = 0; turns < 15; ++turns) {
        EXPECT_EQ(tick({0, 0, 1}), glm::dvec3(0)) << "it answers a place of before";
        EXPECT_TRUE(std::isnan(place.x));
        EXPECT_EQ(device.buttons(), 0U);
        EXPECT_EQ(device.age_s(), std::numeric_limits<double>::infinity());
    }
}

TEST_F(DeviceDrive, ReopeningForgetsRequestedForce) {
    settle();
    device.close();
    hardware.kept_ns = 3 * ms;  // what it tells first had come before that
    ASSERT_TRUE(device.open());
    for (int turns = 0; turns < 60; ++turns) {
        turn();
        EXPECT_EQ(hardware.force, glm::dvec3(0)) << turns;
    }
}

/// Hardware that speaks by itself: a force may be asked for before the first word to it.
TEST_F(DeviceDrive, ReopeningRampsForceFromZero) {
    hardware.descriptor = eventfd(1, EFD_CLOEXEC);  // readable always
    settle();
    device.close();
    ASSERT_TRUE(device.open());
    double before = 0;
    for (int turns = 0; turns < 120; ++turns) {
        const double felt = tick({0, 0, 1}).z;
        EXPECT_LE(felt - before, 0.0501) << "five milliseconds of a tenth of a second, at most";
        before = felt;
    }
    EXPECT_EQ(before, 1);
    ::close(hardware.descriptor);
}

/// The caller lives for 50 ms after its last word; the place is found in these.
TEST_F(DeviceDrive, DropsForceRequestedWithoutPosition) {
    hardware.fault = Fault::silent;
    for (int turns = 0; turns < 5; ++turns) tick({0, 0, 1});
    hardware.fault = Fault::none;
    for (int turns = 0; turns < 60; ++turns) {
        turn();
        EXPECT_EQ(hardware.force, glm::dvec3(0)) << turns << " ms after it was found first";
    }
    settle();
    hardware.fault = Fault::silent;
    for (int turns = 0; turns < 25; ++turns) tick({0, 0, 1});
    hardware.fault = Fault::none;
    for (int turns = 0; turns < 60; ++turns) {
        turn();
        EXPECT_EQ(hardware.force, glm::dvec3(0)) << turns << " ms after it was found again";
    }
}

TEST_F(DeviceDrive, InvalidForceUnpowersUntilReopened) {
    settle();
    EXPECT_EQ(tick({0, no_number, 0}), glm::dvec3(0));
    EXPECT_FALSE(writes);
    EXPECT_EQ(tick({0, 0, 1}), glm::dvec3(0));
    EXPECT_FALSE(reads || writes);
    EXPECT_EQ(device.health().error().kind, ErrorKind::device);
    EXPECT_TRUE(device.open());
    settle();
}

TEST_F(DeviceDrive, UnpluggedDeviceReturnsWithoutForce) {
    settle();
    hardware.plugged = false;
    EXPECT_EQ(tick({0, 0, 1}), glm::dvec3(0));
    EXPECT_FALSE(hardware.connected);
    tick({0, 0, 1});
    EXPECT_TRUE(reads && writes);
    EXPECT_TRUE(std::isnan(place.x));
    EXPECT_EQ(device.health().error().message, "fake: gone");
    EXPECT_EQ(device.prompt(), "looking for the fake again");
    for (int turns = 0; turns < 500; ++turns) EXPECT_EQ(tick({0, 0, 1}), glm::dvec3(0));
    hardware.plugged = true;
    for (int turns = 0; turns < 101 && !hardware.connected; ++turns) tick({0, 0, 1});
    EXPECT_TRUE(hardware.connected);
    EXPECT_EQ(hardware.force, glm::dvec3(0)) << "nothing was heard of it yet";
    settle();
    EXPECT_TRUE(device.health());
    EXPECT_EQ(device.facts().losses, 1);
}

TEST_F(DeviceDrive, AcceptsNewPositionAfterReconnect) {
    settle();
    hardware.plugged = false;
    tick({0, 0, 1});
    hardware.place = {0.3, 0, 0};
    hardware.plugged = true;
    for (int turns = 0; turns < 101 && !hardware.connected; ++turns) tick({0, 0, 1});
    ASSERT_TRUE(hardware.connected);
    tick({0, 0, 1});
    tick({0, 0, 1});
    EXPECT_EQ(place, glm::dvec3(0.3, 0, 0)) << "where it was before says nothing of where it is";
    EXPECT_EQ(device.facts().implausible, 0);
    settle();
}

TEST_F(DeviceDrive, ReportsWhyReconnectFails) {
    settle();
    hardware.plugged = false;
    tick({0, 0, 1});
    hardware.not_opened_because = "fake: may not be opened";
    while (device.prompt() == "looking for the fake again" && turn()) {
    }
    EXPECT_EQ(device.prompt(), "looking for the fake again: fake: may not be opened");
    EXPECT_EQ(device.health().error().message, "fake: gone; now fake: may not be opened");
    for (int turns = 0; turns < 300; ++turns) turn();
    EXPECT_EQ(device.health().error().message, "fake: gone; now fake: may not be opened") << "said once";
    while (turn()) {
    }
    EXPECT_EQ(device.health().error().message, "fake: gone; it did not come back: fake: may not be opened");
}

TEST_F(DeviceDrive, GivesUpLostDevice) {
    settle();
    hardware.plugged = false;
    int turns = 0;
    while (turns < 10'000 && turn()) ++turns;
    EXPECT_GE(turns, 1990);
    EXPECT_LE(turns, 2110);
    tick({0, 0, 1});
    EXPECT_FALSE(reads || writes);
    EXPECT_EQ(device.health().error().message, "fake: gone; it did not come back");
    hardware.plugged = true;
    ASSERT_TRUE(device.open());
    settle();
    EXPECT_TRUE(reads && writes);
}

TEST_F(DeviceDrive, ReportsDriverException) {
    settle();
    hardware.fault = Fault::throws;
    EXPECT_EQ(tick({0, 0, 1}), glm::dvec3(0));
    EXPECT_EQ(device.health().error().message, "fake: bytes that cannot be");
}

TEST_F(DeviceDrive, ClosingLeavesNoForce) {
    settle();
    device.close();
    EXPECT_EQ(hardware.force, glm::dvec3(0));
    EXPECT_FALSE(hardware.connected);
    EXPECT_FALSE(device.read_positions(std::span(&place, 1)));
}

TEST_F(DeviceDrive, ForwardsDriverPrompt) {
    hardware.prompt = "pull the grip out, then push it in";
    turn();
    EXPECT_EQ(device.prompt(), hardware.prompt);
}

/// Faults of every kind at random moments, each for a random time: whatever happens, no force goes out that
/// answers a place older than promised, and none that was not asked for.
TEST_F(DeviceDrive, SurvivesRandomFaults) {
    SCOPED_TRACE("seed " + std::to_string(fault_seed()));
    std::mt19937 random(fault_seed());
    const auto below = [&](unsigned n) { return static_cast<int>(random() % n); };
    settle();
    std::int64_t sound_ns = now, asked_ns = now;  // the hardware told a sound place; a force was asked for
    for (int fault = 0; fault < 10'000; ++fault) {
        hardware.fault = static_cast<Fault>(1 + below(8));
        const bool unplugged = below(4) == 0, caller_sleeps = below(5) == 0;
        hardware.plugged = !unplugged;
        const int lasts = below(40);
        for (int turns = 0; turns < lasts + 10; ++turns) {
            if (turns == lasts) {
                hardware.fault = Fault::none;
                hardware.plugged = true;
            }
            hardware.place.x = 0.02 * std::sin(static_cast<double>(now) * 5e-9);
            const glm::dvec3 newtons(0, 0, below(20));
            if (!caller_sleeps) {
                ASSERT_TRUE(device.read_positions(std::span(&place, 1)));
                ASSERT_TRUE(std::isnan(place.x) || glm::length(place) < 0.021) << "a place that never was";
                ASSERT_TRUE(device.write_forces(std::span(&newtons, 1)));
                asked_ns = now;
            }
            const bool tells = hardware.connected && hardware.plugged && hardware.fault == Fault::none;
            ASSERT_TRUE(turn());
            if (hardware.force != glm::dvec3(0)) {
                ASSERT_TRUE(hardware.connected);
                ASSERT_LE(glm::length(hardware.force), 10.0);
                ASSERT_LE(now - asked_ns, 50 * ms + ms) << "outlived its caller";
                ASSERT_LE(now - sound_ns, 20 * ms + ms) << "answers a place that is too old";
            }
            if (tells) sound_ns = now;
        }
    }
    EXPECT_GT(device.facts().losses, 500);
    EXPECT_GT(device.facts().implausible, 1000);
    hardware.fault = Fault::none;
    for (int turns = 0; turns < 300; ++turns) tick({0, 0, 1});
    EXPECT_EQ(hardware.force, glm::dvec3(0, 0, 1)) << "it works again after all that";
    device.close();
    EXPECT_EQ(hardware.force, glm::dvec3(0));
    std::printf("any driver: 10000 faults, seed %u, %.0f s of virtual time\n", fault_seed(),
                static_cast<double>(now) * 1e-9);
}

}  // namespace
}  // namespace touchable::test

namespace touchable {
namespace {

/// Says of itself what a test wants.
class ToldDevice final : public HapticDevice {
public:
    ToldDevice(std::string name, bool over, std::string prompt, const char* first_button = nullptr)
        : name_(std::move(name)), over_(over), prompt_(std::move(prompt)) {
        if (first_button) can_.first_button = first_button;
    }
    std::string name() const override { return name_; }
    DeviceLimits limits() const override { return {10, 1000}; }
    int fingers() const override { return 1; }
    DeviceCapabilities capabilities() const override { return can_; }
    Result<void> open() override { return {}; }
    void close() override {}
    bool read_positions(std::span<glm::dvec3>) override { return true; }
    bool write_forces(std::span<const glm::dvec3>) override { return true; }
    bool is_over() const override { return over_; }
    std::string prompt() const override { return prompt_; }
    Result<void> health() const override { return {}; }

private:
    std::string name_;
    bool over_;
    std::string prompt_;
    DeviceCapabilities can_;
};

template <class... Devices>
std::unique_ptr<HapticDevice> group_of(Devices... devices) {
    std::vector<std::unique_ptr<HapticDevice>> all;
    (all.push_back(std::move(devices)), ...);
    return make_device_group(std::move(all));
}

TEST(DeviceGroup, EndsWithItsLastDevice) {
    const auto told = [](bool over) { return std::make_unique<ToldDevice>("log", over, ""); };
    EXPECT_FALSE(group_of(told(true), told(false))->is_over());
    EXPECT_TRUE(group_of(told(true), told(true))->is_over());
}

TEST(DeviceGroup, ReportsEachDeviceWithoutPosition) {
    const auto group = group_of(std::make_unique<ToldDevice>("grip", false, "pull it out"),
                                std::make_unique<ToldDevice>("pen", false, ""));
    EXPECT_EQ(group->why_no_position(),
              "the grip never told a position: pull it out; the pen never told a position");
}

TEST(DeviceGroup, NamesSharedFirstButton) {
    const auto told = [](const char* button) { return std::make_unique<ToldDevice>("a", false, "", button); };
    EXPECT_STREQ(group_of(told("bit 0"), told("bit 0"))->capabilities().first_button, "bit 0");
    EXPECT_STREQ(group_of(told("bit 0"), told("the red one"))->capabilities().first_button,
                 "the device's first button");
}

/// Settings and record of a HardwareDevice; they outlive it.
struct Hardware {
    DeviceLimits limits{10, 1000};
    DeviceCapabilities can{};
    int fingers = 1;
    bool works = true, plugged = true, open = false;
    double first_x = 0;  // of finger 0; the next fingers are one to the right each
    std::uint32_t pressed = 0;
    double age_s = 0;
    std::vector<glm::dvec3> forces{};  // of the newest tick
};

class HardwareDevice final : public HapticDevice {
public:
    explicit HardwareDevice(Hardware& hardware) : hardware_(hardware) {}
    std::string name() const override { return "fake"; }
    DeviceLimits limits() const override { return hardware_.limits; }
    int fingers() const override { return hardware_.fingers; }
    DeviceCapabilities capabilities() const override { return hardware_.can; }
    Result<void> open() override {
        if (!hardware_.plugged) return gone();
        hardware_.open = true;
        return {};
    }
    void close() override { hardware_.open = false; }
    bool read_positions(std::span<glm::dvec3> metres) override {
        if (!hardware_.works) return false;
        for (std::size_t finger = 0; finger < metres.size(); ++finger)
            metres[finger] = {hardware_.first_x + static_cast<double>(finger), 0, 0};
        return true;
    }
    bool write_forces(std::span<const glm::dvec3> newtons) override {
        if (!hardware_.works) return false;
        hardware_.forces.assign(newtons.begin(), newtons.end());
        return true;
    }
    std::uint32_t buttons() override { return hardware_.pressed; }
    double age_s() const override { return hardware_.age_s; }
    Result<void> health() const override { return hardware_.works ? Result<void>{} : gone(); }

private:
    static Result<void> gone() { return Error{ErrorKind::device, "fake: gone"}; }
    Hardware& hardware_;
};

/// One finger, then two.
class GroupOfTwo : public ::testing::Test {
protected:
    Hardware first, second{.fingers = 2, .first_x = 10};
    const std::unique_ptr<HapticDevice> group =
        group_of(std::make_unique<HardwareDevice>(first), std::make_unique<HardwareDevice>(second));
    std::array<glm::dvec3, 3> places{glm::dvec3(-1), glm::dvec3(-1), glm::dvec3(-1)};
    const std::array<glm::dvec3, 3> push{glm::dvec3(1), glm::dvec3(2), glm::dvec3(3)};
};

TEST_F(GroupOfTwo, NumbersFingersInDeviceOrder) {
    EXPECT_EQ(group->fingers(), 3);
    ASSERT_TRUE(group->read_positions(places));
    EXPECT_EQ(places[0].x, 0);
    EXPECT_EQ(places[1].x, 10);
    EXPECT_EQ(places[2].x, 11);
    ASSERT_TRUE(group->write_forces(push));
    EXPECT_EQ(first.forces, std::vector{push[0]});
    EXPECT_EQ(second.forces, (std::vector{push[1], push[2]}));
}

TEST_F(GroupOfTwo, WeakestDeviceSetsLimits) {
    for (const bool is_turned : {false, true}) {
        first.limits = {10, 1000};
        second.limits = {4, 3000};
        if (is_turned) std::swap(first.limits, second.limits);
        EXPECT_EQ(group->limits().max_force, 4);
        EXPECT_EQ(group->limits().max_stiffness, 1000);
    }
}

TEST_F(GroupOfTwo, CombinesCapabilities) {
    first.can = {
        .axes_driven = 0, .reach = {0.1, 0.3, 0.1}, .rate_hz = 500, .buttons = 1, .own_watchdog = true};
    second.can = {.axes_driven = 3, .reach = {0.2, 0.2, 0.2}, .rate_hz = 1000, .buttons = 4};
    for (const bool is_turned : {false, true}) {
        if (is_turned) std::swap(first.can, second.can);
        const DeviceCapabilities can = group->capabilities();
        EXPECT_EQ(can.axes_driven, 3) << "one of them exerts forces";
        EXPECT_EQ(can.reach, glm::dvec3(0.1, 0.2, 0.1));
        EXPECT_EQ(can.rate_hz, 500);
        EXPECT_EQ(can.buttons, 4);
        EXPECT_FALSE(can.own_watchdog) << "one holds its last force";
    }
}

TEST_F(GroupOfTwo, ZeroForceReachesHealthyDevices) {
    ASSERT_TRUE(group->write_forces(push));
    for (Hardware* const broken : {&first, &second}) {
        Hardware& other = broken == &first ? second : first;
        broken->works = false;
        EXPECT_FALSE(group->read_positions(places));
        EXPECT_FALSE(group->health());
        ASSERT_TRUE(other.forces[0] != glm::dvec3(0));
        EXPECT_FALSE(group->write_forces(std::vector<glm::dvec3>(3, glm::dvec3(0))));
        for (const glm::dvec3& force : other.forces) EXPECT_EQ(force, glm::dvec3(0));
        broken->works = true;
        ASSERT_TRUE(group->write_forces(push));
    }
}

TEST_F(GroupOfTwo, ReadsHealthyDeviceBesideFailed) {
    first.works = false;
    EXPECT_FALSE(group->read_positions(places));
    EXPECT_EQ(places[1].x, 10);
    EXPECT_EQ(places[2].x, 11);
}

TEST_F(GroupOfTwo, CombinesButtonsAndAge) {
    first.pressed = 1;
    second.pressed = 2;
    EXPECT_EQ(group->buttons(), 3U);
    first.age_s = 0.5;
    second.age_s = 0.001;
    EXPECT_EQ(group->age_s(), 0.5);
    std::swap(first.age_s, second.age_s);
    EXPECT_EQ(group->age_s(), 0.5);
}

TEST_F(GroupOfTwo, OpensAllOrNone) {
    ASSERT_TRUE(group->open());
    EXPECT_TRUE(first.open && second.open);
    group->close();
    EXPECT_FALSE(first.open || second.open);
    second.plugged = false;
    const auto opened = group->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().message, "fake: gone");
    EXPECT_FALSE(first.open);
}

}  // namespace
}  // namespace touchable

namespace touchable::test {
namespace {

// A device beside the process that leaves it unpowered: what happens to its force where its thread stood
// still, and where that process is gone.

class GuardedDevice : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, line), 0);
        const timeval patience{10, 0};  // then nothing was said
        setsockopt(line[0], SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
        hardware.zero_force_packet = ZeroForcePacket{line[1], {std::byte{'L'}}, {}, {std::byte{'M'}}};
        auto started = SafetyWatchdog::start();
        ASSERT_TRUE(started);
        watchdog = *started;
        device.emplace(
            std::make_unique<FakeDriver>(hardware),
            DrivenSettings{.watchdog = watchdog, .clock = [this] { return now; }, .own_thread = false});
        ASSERT_TRUE(device->open());
    }
    void TearDown() override {
        device.reset();
        for (const int end : line) ::close(end);
    }
    /// A haptic tick, then the device's: what the hardware exerts afterwards.
    double tick() {
        glm::dvec3 place;
        const glm::dvec3 newtons(0, 0, 1);
        now += 1'000'000;
        reads = device->read_positions(std::span(&place, 1)) && device->write_forces(std::span(&newtons, 1));
        goes_on = device->turn();
        return hardware.force.z;
    }
    /// Ticks until the force has risen; starts over when the machine stalls. The watchdog's packets about
    /// earlier stalls are thrown away: the last tick shows that there was none since.
    void rise() {
        char word = 0;
        double force = 0;
        for (int ticks = 0; ticks < 100'000 && force < 1; ++ticks) {
            while (recv(line[0], &word, 1, MSG_DONTWAIT) == 1) {
            }
            force = tick();
        }
        ASSERT_EQ(hardware.force.z, 1);
    }

    int line[2] = {-1, -1};
    std::int64_t now = 1'000'000;
    FakeHardware hardware;
    std::shared_ptr<SafetyWatchdog> watchdog;
    std::optional<DrivenDevice> device;
    bool reads = false, goes_on = true;
};

TEST_F(GuardedDevice, RampsForceAfterThreadStall) {
    rise();
    char word = 0;
    ASSERT_EQ(recv(line[0], &word, 1, 0), 1) << "until it was made unpowered";
    EXPECT_EQ(word, 'M');
    EXPECT_EQ(tick(), 0);
    EXPECT_LT(tick(), 0.02) << "it rises";
    rise();
}

/// The input: answers to the process that made the device unpowered.
TEST_F(GuardedDevice, DiscardsInputFromThreadStall) {
    rise();
    const std::int64_t before = hardware.forgotten;
    char word = 0;
    ASSERT_EQ(recv(line[0], &word, 1, 0), 1);
    tick();
    EXPECT_EQ(hardware.forgotten, before + 1);
}

/// A stopped thread usually stops in a call that waits.
TEST_F(GuardedDevice, DropsSampleOfStalledCall) {
    rise();
    const std::int64_t before = device->facts().samples;
    char word = 0;
    hardware.as_it_is_waited_for = [&] { ASSERT_EQ(recv(line[0], &word, 1, 0), 1); };
    tick();
    EXPECT_EQ(word, 'M');
    EXPECT_EQ(device->facts().samples, before);
    hardware.as_it_is_waited_for = {};
    rise();
    EXPECT_GT(device->facts().samples, before);
}

TEST_F(GuardedDevice, ForceIsZeroWithoutWatchdog) {
    rise();
    kill(watchdog->process(), SIGKILL);
    siginfo_t ended{};
    ASSERT_EQ(waitid(P_PID, static_cast<id_t>(watchdog->process()), &ended, WEXITED | WNOWAIT), 0);
    EXPECT_EQ(tick(), 0);
    EXPECT_FALSE(goes_on);
    EXPECT_FALSE(hardware.connected);
    tick();
    EXPECT_FALSE(reads) << "it has failed, and is not looked for";
    const auto health = device->health();
    ASSERT_FALSE(health);
    EXPECT_EQ(health.error().message,
              "fake: the process that leaves devices unpowered when this program cannot (safety-watchdog, " +
                  std::to_string(watchdog->process()) +
                  ") is gone; there is no force without it: start the program again");
    EXPECT_FALSE(device->open());
    EXPECT_EQ(hardware.force, glm::dvec3(0));
}

TEST_F(GuardedDevice, StalledWatchdogZeroesForce) {
    rise();
    kill(watchdog->process(), SIGSTOP);
    for (int ticks = 0; ticks < 10'000 && goes_on; ++ticks) {
        usleep(1000);
        tick();
    }
    EXPECT_FALSE(goes_on);
    EXPECT_EQ(hardware.force, glm::dvec3(0));
    EXPECT_FALSE(hardware.connected);
    tick();
    EXPECT_FALSE(reads) << "it has failed, and is not looked for";
    EXPECT_NE(device->health().error().message.find(") stands still; there is no force without it"),
              std::string::npos)
        << device->health().error().message;
}

/// A driver's call may hang while no force is out, for example while it loads firmware.
TEST_F(GuardedDevice, HeartbeatStartsWithFirstTurn) {
    usleep(50'000);
    EXPECT_EQ(recv(line[0], nullptr, 0, MSG_DONTWAIT | MSG_PEEK), -1);
    rise();
}

}  // namespace
}  // namespace touchable::test

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

TEST_F(SafetyContract, ExertsForcesAndReportsPositions) {
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

TEST_F(SafetyContract, ForceIsZeroBeforeOpening) {
    EXPECT_FALSE(push());
    EXPECT_TRUE(unpowered());
}

TEST_F(SafetyContract, FailureZeroesForceUntilReopened) {
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

TEST_F(SafetyContract, ShortensLongForceKeepingDirection) {
    ASSERT_TRUE(device.open());
    const Forces forces{glm::dvec3(0, 30, -40), glm::dvec3(0, 0, 8)};
    ASSERT_TRUE(device.write_forces(forces));
    EXPECT_NEAR(glm::length(device.exerted()[0] - glm::dvec3(0, 4.8, -6.4)), 0, 1e-12);
    EXPECT_EQ(device.exerted()[1], glm::dvec3(0, 0, 8));
}

TEST_F(SafetyContract, InvalidForceUnpowersEveryFinger) {
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

TEST(SimulatedHandles, YieldAgainstHandSpring) {
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

TEST(SimulatedHandles, FollowTheirDescription) {
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

TEST(SimulatedHandles, UnpowerWhenUnplugged) {
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

TEST(SimulatedHandles, RejectInvalidDescriptions) {
    const auto refusal = [](const char* words) { return make_simulated_device(words, 1).error().message; };
    EXPECT_EQ(refusal("falcon"), "unknown device 'falcon'; the one there is is simulated");
    EXPECT_EQ(refusal("simulated:mass=0"),
              "device 'simulated': mass=0 is not allowed; mass takes 0.05 to 10 kg");
    EXPECT_NE(refusal("simulated:weight=1").find("unknown key 'weight'; keys are mass"), std::string::npos);
}

}  // namespace
}  // namespace touchable
