// SPDX-License-Identifier: Apache-2.0
// Devices are left unpowered at every end of their process: the last bytes that reach the other end of a
// socket.

#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>
#include <glm/geometric.hpp>

#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "device/drivers/safety_watchdog.hpp"
#include "device/point_motion.hpp"
#include "tests/limits.hpp"

namespace touchable::test {
namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return {first, first + text.size()};
}

/// The last message out of a socket before all holders of its other end have closed it.
std::string last_of(int socket) {
    std::string last;
    char room[64];
    for (ssize_t came = 0; (came = recv(socket, room, sizeof room, 0)) > 0;)
        last.assign(room, static_cast<std::size_t>(came));
    return last;
}

/// The last message to a device from a process that ends like this while its forces go out.
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
        if (!kept || !(*kept)->set_packet({device[1], bytes_of("zero"), {}})) _exit(1);
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

TEST(SafetyWatchdog, SendsZeroAfterKill) {
    EXPECT_EQ(zero_force_packet_of_one_that([](auto&) { raise(SIGKILL); }), "zero");
}

TEST(SafetyWatchdog, SendsZeroAfterEverySignal) {
    for (const int signal :
         {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGPIPE, SIGXCPU})
        EXPECT_EQ(zero_force_packet_of_one_that([signal](auto&) {
                      std::signal(signal, SIG_DFL);
                      raise(signal);
                  }),
                  "zero")
            << signal;
}

TEST(SafetyWatchdog, SendsZeroAfterThreadAborts) {
    EXPECT_EQ(zero_force_packet_of_one_that([](auto&) { std::thread([] { std::abort(); }).join(); }), "zero");
}

TEST(SafetyWatchdog, SendsZeroAfterUncaughtException) {
    EXPECT_EQ(zero_force_packet_of_one_that([](auto&) { std::thread([] { throw 1; }).join(); }), "zero");
}

TEST(SafetyWatchdog, SendsZeroAfterImmediateExit) {
    EXPECT_EQ(zero_force_packet_of_one_that([](auto&) { _exit(0); }), "zero");
}

TEST(SafetyWatchdog, IgnoresReleasedDevice) {
    EXPECT_EQ(zero_force_packet_of_one_that([](auto& kept) {
                  kept.reset();
                  raise(SIGKILL);
              }),
              "force");
}

TEST(SafetyWatchdog, KeepsNewestPacket) {
    EXPECT_EQ(zero_force_packet_of_one_that([](auto& kept) {
                  int other[2];
                  if (socketpair(AF_UNIX, SOCK_SEQPACKET, 0, other) != 0) _exit(1);
                  if (!kept->set_packet({other[1], bytes_of("other"), {}})) _exit(1);
                  ::close(other[1]);
                  raise(SIGKILL);
              }),
              "force")
        << "the first descriptor is not its any more";
}

TEST(SafetyWatchdog, RejectsLongPacket) {
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    auto kept = SafetyWatchdog::keep(*watchdog);
    ASSERT_TRUE(kept);
    EXPECT_FALSE((*kept)->set_packet({0, std::vector<std::byte>(SafetyWatchdog::most_bytes + 1), {}}));
}

TEST(SafetyWatchdog, LimitsDevicesAndReusesSlots) {
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    for (int again = 0; again < 3; ++again) {
        std::vector<std::unique_ptr<SafetyWatchdog::Kept>> kept;
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

TEST(HeartWatch, PacketIsDueAfterSilence) {
    HeartWatch watch;
    EXPECT_EQ(watch.due_ns(1000 * beat_ms), 1020 * beat_ms);
    EXPECT_EQ(watch.due_ns(1001 * beat_ms), 1021 * beat_ms) << "it beats";
}

TEST(HeartWatch, WaitsForFirstBeat) {
    HeartWatch watch;
    EXPECT_EQ(watch.due_ns(0), HeartWatch::never);
}

TEST(HeartWatch, RepeatsPacketThenStops) {
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

TEST(HeartWatch, ResumesAfterNextBeat) {
    HeartWatch watch;
    while (watch.due_ns(1000 * beat_ms) != HeartWatch::never) watch.sent(5000 * beat_ms);
    EXPECT_EQ(watch.due_ns(9000 * beat_ms), 9020 * beat_ms);
    watch.sent(9020 * beat_ms);
    EXPECT_EQ(watch.due_ns(9000 * beat_ms), 9040 * beat_ms);
    EXPECT_EQ(watch.due_ns(0), HeartWatch::never) << "another device in its place";
}

TEST(WatchdogMonitor, DetectsSilenceAfterOneSecond) {
    WatchdogMonitor watch;
    std::int64_t now = 5'000'000 * beat_ms;
    EXPECT_TRUE(watch.is_alive(7, now));
    int looks = 0;
    while (watch.is_alive(7, now += beat_ms)) ASSERT_LT(++looks, 2000);
    EXPECT_EQ(looks, 1000);
    EXPECT_TRUE(watch.is_alive(8, now)) << "it beats again";
}

TEST(WatchdogMonitor, AcceptsSlowBeats) {
    WatchdogMonitor watch;
    std::int64_t now = 0;
    for (std::uint32_t beats = 0xfffffff0; beats != 0x10; ++beats)
        for (int looks = 0; looks < 900; ++looks) ASSERT_TRUE(watch.is_alive(beats, now += beat_ms));
}

/// No process beats on a machine that sleeps.
TEST(WatchdogMonitor, IgnoresUnobservedTime) {
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

TEST(HeldHandle, FreeMassAcceleratesUniformly) {
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

TEST(HeldHandle, HandSpringIsDampedOscillator) {
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

TEST(HeldHandle, CoulombFrictionStopsSlidingMass) {
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

TEST(HeldHandle, StaticFrictionHoldsBelowThreshold) {
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

TEST(HeldHandle, QuantizesReadPosition) {
    HandleDynamics d = free_body();
    d.quantum = 6e-5;
    HeldHandle handle(d, period);
    handle.put({8.9e-5, -8.9e-5, 9.1e-5}, glm::dvec3(0));
    EXPECT_EQ(handle.reading(), glm::dvec3(6e-5, -6e-5, 2 * 6e-5));
    EXPECT_EQ(handle.place(), glm::dvec3(8.9e-5, -8.9e-5, 9.1e-5));
}

TEST(HeldHandle, NeverGainsEnergy) {
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

TEST(HeldHandle, IsBitIdenticalEverywhere) {
    HandleDynamics d;
    d.friction = 0.2;
    HeldHandle handle(d, period);
    handle.put({0.01, 0.02, -0.03}, {0.1, -0.2, 0.3});
    for (int k = 0; k < 150; ++k) handle.advance(-400.0 * handle.place());
    // The bits of GCC and Clang, with and without optimisation.
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

TEST(ReplugWatchdog, SendsToLastOpenedDevice) {
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
        if (!(*kept)->set_packet(word)) _exit(1);
        dup2(new_device[1], old_device[1]);
        _exit((*kept)->set_packet(word) ? 0 : 1);
    }
    for (const int theirs : {old_device[1], new_device[1]}) close(theirs);
    EXPECT_EQ(heard_at(new_device[0]), "0");
    EXPECT_EQ(heard_at(old_device[0]), "");
    int ended = -1;
    waitpid(process, &ended, 0);
    EXPECT_EQ(ended, 0);
    for (const int ours : {old_device[0], new_device[0]}) close(ours);
}

// The process that leaves devices unpowered: a program that stands still, that is dumped, that is ended with
// all of its group, and signals to that process itself.

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// The machine may be late, the mechanism not: it has been quick enough in one of so many goes.
constexpr int most_goes = 8;

std::vector<std::byte> word(const std::string& text) {
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return {first, first + text.size()};
}

/// A program that sends "force" to a device and beats, until it does something else.
class BeatingProgram {
public:
    enum class Way { beats, aborts };
    /// `beside`: the descriptor of another device that it holds too; -1: none.
    explicit BeatingProgram(Way way = Way::beats, const std::function<void()>& before = {}, int beside = -1) {
        int ends[2], told[2];
        EXPECT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends), 0);
        EXPECT_EQ(pipe(told), 0);
        process_ = fork();
        if (process_ == 0) {
            setpgid(0, 0);
            for (const int signal : {SIGINT, SIGQUIT, SIGHUP})
                std::signal(signal, SIG_DFL);  // nohup ignores them
            for (const int theirs : {ends[0], told[0], 2}) ::close(theirs);
            if (before) before();
            live(ends[1], told[1], way, beside);
        }
        for (const int its : {ends[1], told[1]}) ::close(its);
        device_ = ends[0];
        const timeval patience{10, 0};  // then it hears nothing, and the test fails
        setsockopt(device_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
        EXPECT_EQ(read(told[0], &guardian_, sizeof guardian_), static_cast<ssize_t>(sizeof guardian_));
        ::close(told[0]);
    }
    ~BeatingProgram() {
        kill(process_, SIGKILL);
        waitpid(process_, nullptr, 0);
        ::close(device_);
    }
    BeatingProgram(const BeatingProgram&) = delete;
    BeatingProgram& operator=(const BeatingProgram&) = delete;

    pid_t process() const { return process_; }
    pid_t guardian() const { return guardian_; }
    /// The next message to the device; empty: no process holds it any more.
    std::string hears() const {
        char room[64];
        const ssize_t came = recv(device_, room, sizeof room, 0);
        return {room, static_cast<std::size_t>(came > 0 ? came : 0)};
    }
    /// True if no process holds the device any more, and there is nothing left to hear.
    bool is_let_go_of() const {
        char room[64];
        return recv(device_, room, sizeof room, 0) == 0;
    }
    /// True if the device comes to hear that, after other messages.
    bool hears_of(const std::string& what) const {
        for (int words = 0; words < 10'000; ++words) {
            const std::string heard = hears();
            if (heard == what || heard.empty()) return heard == what;
        }
        return false;
    }
    /// Stops the program once it beats.
    void stop() const {
        ASSERT_TRUE(hears_of("force"));
        kill(process_, SIGSTOP);
        int status = 0;
        ASSERT_EQ(waitpid(process_, &status, WUNTRACED), process_);
        ASSERT_TRUE(WIFSTOPPED(status));
    }
    bool has_ended() const {
        siginfo_t state{};
        return waitid(P_PID, static_cast<id_t>(process_), &state, WEXITED | WNOHANG | WNOWAIT) == 0 &&
               state.si_pid == process_;
    }

private:
    [[noreturn]] static void live(int device, int told, Way way, int beside) {
        auto watchdog = SafetyWatchdog::start();
        if (!watchdog) _exit(1);
        std::unique_ptr<SafetyWatchdog::Kept> other;  // which is spoken to first
        if (beside >= 0) {
            auto also_kept = SafetyWatchdog::keep(*watchdog);
            if (!also_kept || !(*also_kept)->set_packet({beside, word("last"), {}, {}})) _exit(1);
            other = std::move(*also_kept);
        }
        auto kept = SafetyWatchdog::keep(*watchdog);
        if (!kept || !(*kept)->set_packet({device, word("last"), {}, word("meanwhile")})) _exit(1);
        // Opened again, the other has the higher descriptor.
        if (other && !other->set_packet({beside, word("last"), {}, {}})) _exit(1);
        const pid_t guardian = (*watchdog)->process();
        if (write(told, &guardian, sizeof guardian) != sizeof guardian) _exit(1);
        for (int force = 0;; ++force) {
            const auto beat = (*kept)->beat();
            if (!beat || (other && !other->beat())) _exit(2);
            ::send(device, *beat ? "force" : "anew", *beat ? 5 : 4, 0);
            if (way == Way::aborts && force == 100) std::abort();
            usleep(1000);
        }
    }

    pid_t process_ = 0, guardian_ = 0;
    int device_ = -1;
};

/// The time from `begins` to the message `heard`.
double milliseconds_of(const std::function<void(BeatingProgram&)>& begins, const std::string& heard,
                       BeatingProgram::Way way = BeatingProgram::Way::beats,
                       const std::function<void()>& before = {}) {
    BeatingProgram program(way, before);
    begins(program);
    const auto begun = Clock::now();
    for (std::string now = program.hears(); now != heard && !now.empty();) now = program.hears();
    return std::chrono::duration<double, std::milli>(Clock::now() - begun).count();
}

/// The shortest of several goes.
double quickest_ms(const std::function<void(BeatingProgram&)>& begins, const std::string& heard,
                   BeatingProgram::Way way = BeatingProgram::Way::beats,
                   const std::function<void()>& before = {}) {
    double quickest = 1e9;
    for (int go = 0; go < most_goes && quickest > 50; ++go)
        quickest = std::min(quickest, milliseconds_of(begins, heard, way, before));
    return quickest;
}

TEST(WatchdogProcess, UnpowersDeviceOfStoppedProgram) {
    double ms = 0;
    // If this test stands still, a go takes longer, or is measured from too late. A watchdog that speaks
    // too early does so in every go.
    for (int go = 0; go < most_goes && (ms < 10 || ms > 50); ++go)
        ms = milliseconds_of([](BeatingProgram& program) { program.stop(); }, "meanwhile");
    EXPECT_LE(ms, 50);
    EXPECT_GE(ms, 10) << "not before it stands still";
}

TEST(WatchdogProcess, KeepsWatchingResumedProgram) {
    const BeatingProgram program;
    for (int again = 0; again < 3; ++again) {
        program.stop();
        ASSERT_TRUE(program.hears_of("meanwhile"));
        EXPECT_FALSE(program.has_ended());
        kill(program.process(), SIGCONT);
        ASSERT_TRUE(program.hears_of("anew")) << "it hears that its force begins anew";
        ASSERT_TRUE(program.hears_of("force"));
    }
}

TEST(WatchdogProcess, RepeatsPacketDuringStop) {
    const BeatingProgram program;
    program.stop();
    ASSERT_TRUE(program.hears_of("meanwhile"));
    for (int words = 1; words < 8; ++words) ASSERT_EQ(program.hears(), "meanwhile");
    kill(program.process(), SIGKILL);
    EXPECT_TRUE(program.hears_of("last")) << "once it is gone";
}

TEST(WatchdogProcess, ActsBeforeCoreDumpEnds) {
#ifdef TOUCHABLE_SANITIZED
    GTEST_SKIP() << "a sanitizer's memory is too large to be dumped";
#endif
    const std::string folder = std::filesystem::temp_directory_path() / ("core-" + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    const double ms = quickest_ms(
        [](BeatingProgram& program) {
            std::string heard;
            for (int forces = 0; forces < 100 && !(heard = program.hears()).empty(); ++forces) {
            }
        },
        "meanwhile", BeatingProgram::Way::aborts,
        [&folder] {
            rlimit core{};
            getrlimit(RLIMIT_CORE, &core);
            core.rlim_cur = core.rlim_max;
            setrlimit(RLIMIT_CORE, &core);
            if (chdir(folder.c_str()) != 0) _exit(1);
            static std::vector<char> large(std::size_t{400} << 20, 'a');  // as decoded frames
            large[1] = 'b';
        });
    EXPECT_LE(ms, 50);
    std::filesystem::remove_all(folder);
}

TEST(WatchdogProcess, OwnDelayCausesNoPacket) {
    int fewest = 1;
    for (int go = 0; go < most_goes && fewest > 0; ++go) {
        const BeatingProgram program;
        for (int forces = 0; forces < 20; ++forces) program.hears();
        kill(program.guardian(), SIGSTOP);
        for (int forces = 0; forces < 60; ++forces) program.hears();
        kill(program.guardian(), SIGCONT);
        int words = 0;
        for (int forces = 0; forces < 60; ++forces) words += program.hears() == "meanwhile" ? 1 : 0;
        fewest = std::min(fewest, words);
    }
    EXPECT_EQ(fewest, 0);
}

/// Signals as of a terminal's Ctrl-C and of kill -9 -GROUP.
TEST(WatchdogProcess, SurvivesGroupSignals) {
    for (const int signal : {SIGINT, SIGQUIT, SIGHUP, SIGTERM, SIGKILL}) {
        const BeatingProgram program;
        program.hears();
        kill(-program.process(), signal);
        std::string heard, last;
        while (!(heard = program.hears()).empty()) last = heard;
        EXPECT_EQ(last, "last") << signal;
    }
}

TEST(WatchdogProcess, SurvivesTerminationSignals) {
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    auto kept = SafetyWatchdog::keep(*watchdog);
    ASSERT_TRUE(kept);
    ASSERT_TRUE((*kept)->set_packet({0, word("zero"), {}, {}})) << "it has begun";
    for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGPIPE}) {
        kill((*watchdog)->process(), signal);
        EXPECT_TRUE((*kept)->set_packet({0, word("zero"), {}, {}})) << signal;
    }
    EXPECT_TRUE((*watchdog)->health());
}

std::string contents(pid_t process, const char* what) {
    std::ifstream file("/proc/" + std::to_string(process) + "/" + what);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The device is unguarded then, and must have no force.
TEST(WatchdogProcess, IgnoresReplyToEarlierOrder) {
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    auto kept = SafetyWatchdog::keep(*watchdog);
    ASSERT_TRUE(kept);
    const pid_t process = (*watchdog)->process();
    int ends[2];
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends), 0);
    ASSERT_TRUE((*kept)->set_packet({ends[1], word("zero"), {}, {}}));
    ::close(ends[1]);
    kill(process, SIGSTOP);
    EXPECT_FALSE((*kept)->set_packet({0, word("zero"), {}, {}}));
    kill(process, SIGCONT);
    char byte = 0;
    EXPECT_EQ(recv(ends[0], &byte, 1, 0), 0) << "it obeys, and lets go of what it held";
    const auto sleeps = [&] {
        const std::string stat = contents(process, "stat");
        return stat.compare(stat.rfind(')'), 3, ") S") == 0;
    };
    while (!sleeps()) usleep(1000);  // it has answered
    kill(process, SIGSTOP);
    EXPECT_FALSE((*kept)->set_packet({0, word("zero"), {}, {}}));
    kill(process, SIGCONT);
    EXPECT_TRUE((*kept)->set_packet({0, word("zero"), {}, {}})) << "it is relied on again";
    ::close(ends[0]);
}

/// `pkill -9 touchable` goes by the one, `pkill -f` by the other.
TEST(WatchdogProcess, HasOwnProcessName) {
    const BeatingProgram program;
    EXPECT_EQ(contents(program.guardian(), "comm"), "safety-watchdog\n");
    const std::string line = contents(program.guardian(), "cmdline");
    EXPECT_EQ(line.substr(0, line.find('\0')), "safety-watchdog");
    EXPECT_EQ(line.find_first_not_of('\0', line.find('\0')), std::string::npos) << "nothing behind it";
    EXPECT_NE(contents(program.process(), "cmdline").find("test_device"), std::string::npos)
        << "the program keeps its own";
}

TEST(WatchdogProcess, RunsAtHighestAllowedPriority) {
    const BeatingProgram program;
    const pid_t tries = fork();
    if (tries == 0) {
        const sched_param least{.sched_priority = 1};
        _exit(sched_setscheduler(0, SCHED_FIFO, &least) == 0 ? SCHED_FIFO : SCHED_OTHER);
    }
    int status = 0;
    waitpid(tries, &status, 0);
    EXPECT_EQ(sched_getscheduler(program.guardian()), WEXITSTATUS(status));
}

/// A reader of a pipe that the program writes waits for its end.
TEST(WatchdogProcess, ClosesUnneededDescriptors) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    auto kept = SafetyWatchdog::keep(*watchdog);
    ASSERT_TRUE(kept);
    ASSERT_TRUE((*kept)->set_packet({0, word("zero"), {}, {}})) << "it has begun";
    ::close(ends[1]);
    pollfd end{ends[0], POLLIN, 0};
    EXPECT_EQ(poll(&end, 1, 0), 1);
    EXPECT_NE(end.revents & POLLHUP, 0);
    ::close(ends[0]);
    const std::filesystem::path open = "/proc/" + std::to_string((*watchdog)->process()) + "/fd";
    std::vector<std::string> held;
    for (const auto& one : std::filesystem::directory_iterator(open)) held.push_back(one.path().filename());
    EXPECT_EQ(held.size(), 2U) << "its socket, and what it keeps";
}

/// A device whose bus hangs: a writer waits.
class DeviceThatTakesNothing {
public:
    DeviceThatTakesNothing() {
        EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends_), 0);
        const std::vector<char> much(1 << 16);
        while (send(ends_[1], much.data(), much.size(), MSG_DONTWAIT) > 0) {
        }
    }
    ~DeviceThatTakesNothing() {
        for (const int end : ends_) ::close(end);
    }
    DeviceThatTakesNothing(const DeviceThatTakesNothing&) = delete;
    DeviceThatTakesNothing& operator=(const DeviceThatTakesNothing&) = delete;
    int end() const { return ends_[1]; }
    void let_go_of_its_end() const { ::close(ends_[0]); }

private:
    int ends_[2] = {-1, -1};
};

TEST(WatchdogProcess, BlockedDeviceDelaysNoOther) {
    const DeviceThatTakesNothing stuck;
    const BeatingProgram program(
        BeatingProgram::Way::beats, [&] { stuck.let_go_of_its_end(); }, stuck.end());
    program.stop();
    ASSERT_TRUE(program.hears_of("meanwhile"));
    for (int words = 1; words < 8; ++words) ASSERT_EQ(program.hears(), "meanwhile");
    kill(program.process(), SIGCONT);
    ASSERT_TRUE(program.hears_of("anew")) << "it answers to its program";
    kill(program.process(), SIGKILL);
    ASSERT_TRUE(program.hears_of("last"));
    EXPECT_EQ(program.hears(), "last");
    EXPECT_TRUE(program.is_let_go_of()) << "its port is free, though a sender still waits for the other";
}

TEST(WatchdogProcess, UnpowersBothDevices) {
    int ends[2];
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends), 0);
    const timeval patience{10, 0};
    setsockopt(ends[0], SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    const BeatingProgram program(
        BeatingProgram::Way::beats, [&] { ::close(ends[0]); }, ends[1]);
    ::close(ends[1]);
    kill(program.process(), SIGKILL);
    EXPECT_TRUE(program.hears_of("last"));
    char room[64];
    const ssize_t came = recv(ends[0], room, sizeof room, 0);
    EXPECT_EQ(std::string(room, static_cast<std::size_t>(std::max<ssize_t>(came, 0))), "last");
    ::close(ends[0]);
}

TEST(WatchdogProcess, SendsPacketTwice) {
    const BeatingProgram program;
    kill(program.process(), SIGKILL);
    ASSERT_TRUE(program.hears_of("last"));
    EXPECT_EQ(program.hears(), "last");
    EXPECT_EQ(program.hears(), "");
}

TEST(WatchdogProcess, DeathIsDetected) {
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    auto kept = SafetyWatchdog::keep(*watchdog);
    ASSERT_TRUE(kept);
    EXPECT_TRUE((*kept)->beat());
    kill((*watchdog)->process(), SIGKILL);
    siginfo_t ended{};
    ASSERT_EQ(waitid(P_PID, static_cast<id_t>((*watchdog)->process()), &ended, WEXITED | WNOWAIT), 0);
    const auto beat = (*kept)->beat();
    ASSERT_FALSE(beat);
    EXPECT_EQ(beat.error().kind, ErrorKind::device);
    EXPECT_NE(beat.error().message.find("(safety-watchdog, " + std::to_string((*watchdog)->process()) +
                                        ") is gone"),
              std::string::npos)
        << beat.error().message;
    EXPECT_FALSE((*kept)->set_packet({0, word("zero"), {}, {}}));
}

TEST(WatchdogProcess, StallIsDetected) {
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    auto kept = SafetyWatchdog::keep(*watchdog);
    ASSERT_TRUE(kept);
    ASSERT_TRUE((*kept)->set_packet({0, word("zero"), {}, {}}));
    kill((*watchdog)->process(), SIGSTOP);
    int beats = 0;
    Result<bool> beat = true;
    for (; beat && beats < 10'000; ++beats) {
        usleep(1000);
        beat = (*kept)->beat();
    }
    ASSERT_FALSE(beat);
    EXPECT_EQ(beat.error().kind, ErrorKind::device);
    EXPECT_NE(beat.error().message.find("(safety-watchdog, " + std::to_string((*watchdog)->process()) +
                                        ") stands still; there is no force without it"),
              std::string::npos)
        << beat.error().message;
    EXPECT_GE(beats, 50) << "a busy machine may keep it waiting for a while";
    kill((*watchdog)->process(), SIGCONT);
    EXPECT_FALSE((*kept)->beat()) << "it is not relied on again";
    EXPECT_FALSE((*kept)->set_packet({0, word("zero"), {}, {}}));
}

/// The program may or may not know that it is stopped. (In a process of its own, which would hang.)
TEST(WatchdogProcess, StoppedWatchdogDelaysNoExit) {
    const pid_t program = fork();
    if (program == 0) {
        alarm(30);
        auto watchdog = SafetyWatchdog::start();
        if (!watchdog) _exit(1);
        const pid_t process = (*watchdog)->process();
        kill(process, SIGSTOP);
        watchdog->reset();
        _exit(kill(process, 0) < 0 ? 0 : 2);
    }
    int status = -1;
    ASSERT_EQ(waitpid(program, &status, 0), program);
    EXPECT_EQ(status, 0);
}

}  // namespace
}  // namespace touchable::test
