// However a process ends, what it held is left unpowered: the last bytes that reach the other end of a
// socket.
#include "device/drivers/safety_watchdog.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>

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

}  // namespace
}  // namespace touchable::test
