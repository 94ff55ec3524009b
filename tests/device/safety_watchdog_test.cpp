// However a process ends, what it held is left unpowered: the last bytes that reach the other end of a
// socket.

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <glm/geometric.hpp>

#include <array>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>

#include "device/drivers/safety_watchdog.hpp"
#include "device/point_motion.hpp"
#include "tests/sanitizers.hpp"

namespace touchable::test {
namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return {first, first + text.size()};
}

/// All that comes out of a socket until its other end is closed by everybody; the last of it.
std::string last_of(int socket) {
    std::string last;
    char room[64];
    for (ssize_t came = 0; (came = recv(socket, room, sizeof room, 0)) > 0;)
        last.assign(room, static_cast<std::size_t>(came));
    return last;
}

/// What a device hears last of a process that holds it, and ends like this while its forces go out.
template <class End>
std::string zero_force_packet_of_one_that(End&& ends) {
    int device[2];
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, device), 0);
    const pid_t process = fork();
    if (process == 0) {
        const rlimit no_core{0, 0};
        setrlimit(RLIMIT_CORE, &no_core);
        ::close(device[0]);
        ::close(2);  // what the runtime says of such an end is not the test's
        auto watchdog = SafetyWatchdog::start();
        if (!watchdog) _exit(1);
        auto kept = SafetyWatchdog::keep(*watchdog);
        if (!kept || !kept->set_packet({device[1], bytes_of("zero"), {}})) _exit(1);
        for (int force = 0; force < 100; ++force)
            if (::send(device[1], "force", 5, 0) != 5) _exit(1);
        ends(*kept);
        _exit(1);
    }
    ::close(device[1]);
    const std::string last = last_of(device[0]);
    ::close(device[0]);
    waitpid(process, nullptr, 0);
    return last;
}

TEST(SafetyWatchdog, SpeaksForAProcessThatWasKilled) {
    EXPECT_EQ(zero_force_packet_of_one_that([](auto&) { raise(SIGKILL); }), "zero");
}

TEST(SafetyWatchdog, SpeaksAfterEverySignal) {
    for (const int signal :
         {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGPIPE, SIGXCPU})
        EXPECT_EQ(zero_force_packet_of_one_that([signal](auto&) {
                      std::signal(signal, SIG_DFL);
                      raise(signal);
                  }),
                  "zero")
            << signal;
}

TEST(SafetyWatchdog, SpeaksAfterAbortInAnotherThread) {
    EXPECT_EQ(zero_force_packet_of_one_that([](auto&) { std::thread([] { std::abort(); }).join(); }), "zero");
}

TEST(SafetyWatchdog, SpeaksAfterAnExceptionThatNobodyCaught) {
    EXPECT_EQ(zero_force_packet_of_one_that([](auto&) { std::thread([] { throw 1; }).join(); }), "zero");
}

TEST(SafetyWatchdog, SpeaksAfterAnExitThatDestroysNothing) {
    EXPECT_EQ(zero_force_packet_of_one_that([](auto&) { _exit(0); }), "zero");
}

TEST(SafetyWatchdog, SaysNothingForADeviceThatWasLetGoOf) {
    EXPECT_EQ(zero_force_packet_of_one_that([](SafetyWatchdog::Kept& kept) {
                  { const SafetyWatchdog::Kept let_go(std::move(kept)); }
                  raise(SIGKILL);
              }),
              "force");
}

TEST(SafetyWatchdog, KeepsTheNewestPacket) {
    EXPECT_EQ(zero_force_packet_of_one_that([](SafetyWatchdog::Kept& kept) {
                  int other[2];
                  if (socketpair(AF_UNIX, SOCK_SEQPACKET, 0, other) != 0) _exit(1);
                  if (!kept.set_packet({other[1], bytes_of("other"), {}})) _exit(1);
                  ::close(other[1]);
                  raise(SIGKILL);
              }),
              "force")
        << "the first descriptor is not its any more";
}

TEST(SafetyWatchdog, RefusesAWordThatIsTooLong) {
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    auto kept = SafetyWatchdog::keep(*watchdog);
    ASSERT_TRUE(kept);
    EXPECT_FALSE(kept->set_packet({0, std::vector<std::byte>(SafetyWatchdog::most_bytes + 1), {}}));
}

TEST(SafetyWatchdog, KeepsAFewDevicesAndHasRoomAgainAfterwards) {
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    for (int again = 0; again < 3; ++again) {
        std::vector<SafetyWatchdog::Kept> kept;
        for (int device = 0; device < SafetyWatchdog::most_devices; ++device) {
            auto one = SafetyWatchdog::keep(*watchdog);
            ASSERT_TRUE(one) << device;
            kept.push_back(std::move(*one));
        }
        EXPECT_EQ(SafetyWatchdog::keep(*watchdog).error().kind, ErrorKind::device);
    }
}

// When a silent thread's device is made unpowered, in virtual time.

constexpr std::int64_t beat_ms = 1'000'000;

TEST(HeartWatch, WantsAPacketTwentyMillisecondsAfterTheLastBeat) {
    HeartWatch watch;
    EXPECT_EQ(watch.due_ns(1000 * beat_ms), 1020 * beat_ms);
    EXPECT_EQ(watch.due_ns(1001 * beat_ms), 1021 * beat_ms) << "it beats";
}

TEST(HeartWatch, WaitsForAFirstBeat) {
    HeartWatch watch;
    EXPECT_EQ(watch.due_ns(0), HeartWatch::never);
}

TEST(HeartWatch, SendsAgainInTheSameSilenceAndThenStops) {
    HeartWatch watch;
    std::int64_t now = 0;
    for (int word = 0; word < 20; ++word) {
        const std::int64_t due = watch.due_ns(1000 * beat_ms);
        ASSERT_NE(due, HeartWatch::never) << word;
        if (word > 0) {
            EXPECT_EQ(due, now + 20 * beat_ms);
        }
        now = due + 3 * beat_ms;  // it is late itself
        watch.sent(now);
    }
    EXPECT_EQ(watch.due_ns(1000 * beat_ms), HeartWatch::never) << "of a program that is stopped for an hour";
}

TEST(HeartWatch, WatchesAgainOnceTheHeartBeats) {
    HeartWatch watch;
    while (watch.due_ns(1000 * beat_ms) != HeartWatch::never) watch.sent(5000 * beat_ms);
    EXPECT_EQ(watch.due_ns(9000 * beat_ms), 9020 * beat_ms);
    watch.sent(9020 * beat_ms);
    EXPECT_EQ(watch.due_ns(9000 * beat_ms), 9040 * beat_ms);
    EXPECT_EQ(watch.due_ns(0), HeartWatch::never) << "another device in its place";
}

TEST(WatchdogMonitor, KnowsAfterASecondThatNothingBeats) {
    WatchdogMonitor watch;
    std::int64_t now = 5'000'000 * beat_ms;
    EXPECT_TRUE(watch.is_alive(7, now));
    int looks = 0;
    while (watch.is_alive(7, now += beat_ms)) ASSERT_LT(++looks, 2000);
    EXPECT_EQ(looks, 1000);
    EXPECT_TRUE(watch.is_alive(8, now)) << "it beats again";
}

TEST(WatchdogMonitor, OneThatBeatsSeldomLives) {
    WatchdogMonitor watch;
    std::int64_t now = 0;
    for (std::uint32_t beats = 0xfffffff0; beats != 0x10; ++beats)
        for (int looks = 0; looks < 900; ++looks) ASSERT_TRUE(watch.is_alive(beats, now += beat_ms));
}

/// On a machine that sleeps nobody beats.
TEST(WatchdogMonitor, TimeInWhichNobodyLookedDoesNotCount) {
    WatchdogMonitor watch;
    std::int64_t now = 0;
    watch.is_alive(7, now);
    for (int sleeps = 0; sleeps < 40; ++sleeps) ASSERT_TRUE(watch.is_alive(7, now += 3'600'000 * beat_ms));
}

}  // namespace
}  // namespace touchable::test

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

namespace touchable::test {
namespace {

// A device that is plugged in again has often the number of its old descriptor, and the same last word.

std::string heard_at(int socket) {
    char room[16];
    const ssize_t came = recv(socket, room, sizeof room, 0);
    return {room, static_cast<std::size_t>(came > 0 ? came : 0)};
}

TEST(ReplugWatchdog, SpeaksToTheDeviceThatWasOpenedLast) {
    int old_device[2], new_device[2];
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, old_device), 0);
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, new_device), 0);
    const pid_t process = fork();
    if (process == 0) {
        auto watchdog = SafetyWatchdog::start();
        if (!watchdog) _exit(1);
        auto kept = SafetyWatchdog::keep(*watchdog);
        if (!kept) _exit(1);
        const ZeroForcePacket word{old_device[1], {std::byte{'0'}}, {}};
        if (!kept->set_packet(word)) _exit(1);
        dup2(new_device[1], old_device[1]);
        _exit(kept->set_packet(word) ? 0 : 1);
    }
    for (const int theirs : {old_device[1], new_device[1]}) close(theirs);
    EXPECT_EQ(heard_at(new_device[0]), "0");
    EXPECT_EQ(heard_at(old_device[0]), "");
    int ended = -1;
    waitpid(process, &ended, 0);
    EXPECT_EQ(ended, 0);
    for (const int ours : {old_device[0], new_device[0]}) close(ours);
}

}  // namespace
}  // namespace touchable::test
