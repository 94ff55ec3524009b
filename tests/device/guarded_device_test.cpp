// A device beside the process that leaves it unpowered: what happens to its force where its thread stood
// still, and where that process is gone.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>

#include "device/drivers/driven_device.hpp"
#include "tests/device/fake_driver.hpp"

namespace touchable::test {
namespace {

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
    /// Where the machine stands still, it begins anew. What the watchdog said of earlier standstills is
    /// thrown away: the last tick shows that there was none since.
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

TEST_F(GuardedDevice, ItsForceBeginsAnewAfterItsThreadStoodStill) {
    rise();
    char word = 0;
    ASSERT_EQ(recv(line[0], &word, 1, 0), 1) << "until it was made unpowered";
    EXPECT_EQ(word, 'M');
    EXPECT_EQ(tick(), 0);
    EXPECT_LT(tick(), 0.02) << "it rises";
    rise();
}

/// What it answered to the process that made it unpowered.
TEST_F(GuardedDevice, WhatCameWhileItsThreadStoodStillIsForgotten) {
    rise();
    const std::int64_t before = hardware.forgotten;
    char word = 0;
    ASSERT_EQ(recv(line[0], &word, 1, 0), 1);
    tick();
    EXPECT_EQ(hardware.forgotten, before + 1);
}

/// As a thread that is stopped: most of the time it waits.
TEST_F(GuardedDevice, WhatComesInACallThatStoodStillIsNoPlace) {
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

TEST_F(GuardedDevice, HasNoForceBesideNobody) {
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

TEST_F(GuardedDevice, HasNoForceBesideOneThatStandsStill) {
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

/// What hangs in a call of a driver, as one that loads firmware, may do so where no force is out.
TEST_F(GuardedDevice, NoBeatIsExpectedBeforeTheFirstTurn) {
    usleep(50'000);
    EXPECT_EQ(recv(line[0], nullptr, 0, MSG_DONTWAIT | MSG_PEEK), -1);
    rise();
}

}  // namespace
}  // namespace touchable::test
