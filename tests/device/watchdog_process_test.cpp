// The process that leaves devices unpowered: a program that stands still, that is dumped, that is ended with
// all of its group, and who ends that process.
#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "device/drivers/safety_watchdog.hpp"
#include "tests/sanitizers.hpp"

namespace touchable::test {
namespace {

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
    /// What the device hears next; empty: nobody holds it any more.
    std::string hears() const {
        char room[64];
        const ssize_t came = recv(device_, room, sizeof room, 0);
        return {room, static_cast<std::size_t>(came > 0 ? came : 0)};
    }
    /// Whether it comes to hear that, after other things.
    bool hears_of(const std::string& what) const {
        for (int words = 0; words < 10'000; ++words) {
            const std::string heard = hears();
            if (heard == what || heard.empty()) return heard == what;
        }
        return false;
    }
    /// Once it beats.
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
        std::optional<SafetyWatchdog::Kept> other;  // which is spoken to first
        if (beside >= 0) {
            auto also_kept = SafetyWatchdog::keep(*watchdog);
            if (!also_kept || !also_kept->set_packet({beside, word("last"), {}, {}})) _exit(1);
            other.emplace(std::move(*also_kept));
        }
        auto kept = SafetyWatchdog::keep(*watchdog);
        if (!kept || !kept->set_packet({device, word("last"), {}, word("meanwhile")})) _exit(1);
        const pid_t guardian = (*watchdog)->process();
        if (write(told, &guardian, sizeof guardian) != sizeof guardian) _exit(1);
        for (int force = 0;; ++force) {
            const auto beat = kept->beat();
            if (!beat || (other && !other->beat())) _exit(2);
            ::send(device, *beat ? "force" : "anew", *beat ? 5 : 4, 0);
            if (way == Way::aborts && force == 100) std::abort();
            usleep(1000);
        }
    }

    pid_t process_ = 0, guardian_ = 0;
    int device_ = -1;
};

/// From `begins` to what it waits for.
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

TEST(WatchdogProcess, AStoppedProgramIsMadeLimpWithoutDying) {
    double ms = 0;
    // Where this test stands still, a go takes longer, or is measured from too late. A watchdog that speaks
    // too early does so in every go.
    for (int go = 0; go < most_goes && (ms < 10 || ms > 50); ++go)
        ms = milliseconds_of([](BeatingProgram& program) { program.stop(); }, "meanwhile");
    EXPECT_LE(ms, 50);
    EXPECT_GE(ms, 10) << "not before it stands still";
}

TEST(WatchdogProcess, AProgramThatGoesOnIsLeftAloneAndWatchedAgain) {
    const BeatingProgram program;
    for (int again = 0; again < 3; ++again) {
        program.stop();
        ASSERT_TRUE(program.hears_of("meanwhile"));
        EXPECT_FALSE(program.has_ended());
        kill(program.process(), SIGCONT);
        ASSERT_TRUE(program.hears_of("anew")) << "it is told that its force begins anew";
        ASSERT_TRUE(program.hears_of("force"));
    }
}

TEST(WatchdogProcess, SaysAWordAgainWhileAProgramIsStopped) {
    const BeatingProgram program;
    program.stop();
    ASSERT_TRUE(program.hears_of("meanwhile"));
    for (int words = 1; words < 8; ++words) ASSERT_EQ(program.hears(), "meanwhile");
    kill(program.process(), SIGKILL);
    EXPECT_TRUE(program.hears_of("last")) << "once it is gone";
}

TEST(WatchdogProcess, DoesNotWaitForACoreToBeWritten) {
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

TEST(WatchdogProcess, IsNotMistakenWhenItWasLateItself) {
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

/// As a terminal does by Ctrl-C, and a person by kill -9 -GROUP.
TEST(WatchdogProcess, OutlivesWhatIsSentToTheWholeGroup) {
    for (const int signal : {SIGINT, SIGQUIT, SIGHUP, SIGTERM, SIGKILL}) {
        const BeatingProgram program;
        program.hears();
        kill(-program.process(), signal);
        std::string heard, last;
        while (!(heard = program.hears()).empty()) last = heard;
        EXPECT_EQ(last, "last") << signal;
    }
}

TEST(WatchdogProcess, IsNotEndedByWhatEndsPrograms) {
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    auto kept = SafetyWatchdog::keep(*watchdog);
    ASSERT_TRUE(kept);
    ASSERT_TRUE(kept->set_packet({0, word("zero"), {}, {}})) << "it has begun";
    for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGPIPE}) {
        kill((*watchdog)->process(), signal);
        EXPECT_TRUE(kept->set_packet({0, word("zero"), {}, {}})) << signal;
    }
    EXPECT_TRUE((*watchdog)->health());
}

std::string contents(pid_t process, const char* what) {
    std::ifstream file("/proc/" + std::to_string(process) + "/" + what);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The device is in nobody's care then, and must have no force.
TEST(WatchdogProcess, WhatItSaysOfAnEarlierOrderIsNoAnswerToTheNext) {
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    auto kept = SafetyWatchdog::keep(*watchdog);
    ASSERT_TRUE(kept);
    const pid_t process = (*watchdog)->process();
    int ends[2];
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends), 0);
    ASSERT_TRUE(kept->set_packet({ends[1], word("zero"), {}, {}}));
    ::close(ends[1]);
    kill(process, SIGSTOP);
    EXPECT_FALSE(kept->set_packet({0, word("zero"), {}, {}}));
    kill(process, SIGCONT);
    char byte = 0;
    EXPECT_EQ(recv(ends[0], &byte, 1, 0), 0) << "it obeys, and lets go of what it held";
    const auto sleeps = [&] {
        const std::string stat = contents(process, "stat");
        return stat.compare(stat.rfind(')'), 3, ") S") == 0;
    };
    while (!sleeps()) usleep(1000);  // it has answered
    kill(process, SIGSTOP);
    EXPECT_FALSE(kept->set_packet({0, word("zero"), {}, {}}));
    kill(process, SIGCONT);
    EXPECT_TRUE(kept->set_packet({0, word("zero"), {}, {}})) << "it is relied on again";
    ::close(ends[0]);
}

/// `pkill -9 touchable` goes by the one, `pkill -f` by the other.
TEST(WatchdogProcess, HasANameAndACommandLineOfItsOwn) {
    const BeatingProgram program;
    EXPECT_EQ(contents(program.guardian(), "comm"), "safety-watchdog\n");
    const std::string line = contents(program.guardian(), "cmdline");
    EXPECT_EQ(line.substr(0, line.find('\0')), "safety-watchdog");
    EXPECT_EQ(line.find_first_not_of('\0', line.find('\0')), std::string::npos) << "nothing behind it";
    EXPECT_NE(contents(program.process(), "cmdline").find("test_device"), std::string::npos)
        << "the program keeps its own";
}

TEST(WatchdogProcess, IsAsUrgentAsItMayBe) {
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

/// Whoever reads a pipe that the program writes waits for its end.
TEST(WatchdogProcess, HoldsNothingOpenThatItDoesNotNeed) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    auto kept = SafetyWatchdog::keep(*watchdog);
    ASSERT_TRUE(kept);
    ASSERT_TRUE(kept->set_packet({0, word("zero"), {}, {}})) << "it has begun";
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

/// As one whose bus hangs: whoever writes to it waits.
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

TEST(WatchdogProcess, ADeviceThatTakesNothingKeepsNoOtherWaiting) {
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
}

TEST(WatchdogProcess, LeavesEachOfTwoDevicesLimp) {
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

TEST(WatchdogProcess, SpeaksTwice) {
    const BeatingProgram program;
    kill(program.process(), SIGKILL);
    ASSERT_TRUE(program.hears_of("last"));
    EXPECT_EQ(program.hears(), "last");
    EXPECT_EQ(program.hears(), "");
}

TEST(WatchdogProcess, ThatItIsGoneIsKnown) {
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    auto kept = SafetyWatchdog::keep(*watchdog);
    ASSERT_TRUE(kept);
    EXPECT_TRUE(kept->beat());
    kill((*watchdog)->process(), SIGKILL);
    siginfo_t ended{};
    ASSERT_EQ(waitid(P_PID, static_cast<id_t>((*watchdog)->process()), &ended, WEXITED | WNOWAIT), 0);
    const auto beat = kept->beat();
    ASSERT_FALSE(beat);
    EXPECT_EQ(beat.error().kind, ErrorKind::device);
    EXPECT_NE(beat.error().message.find("(safety-watchdog, " + std::to_string((*watchdog)->process()) +
                                        ") is gone"),
              std::string::npos)
        << beat.error().message;
    EXPECT_FALSE(kept->set_packet({0, word("zero"), {}, {}}));
}

TEST(WatchdogProcess, ThatItStandsStillIsKnown) {
    auto watchdog = SafetyWatchdog::start();
    ASSERT_TRUE(watchdog);
    auto kept = SafetyWatchdog::keep(*watchdog);
    ASSERT_TRUE(kept);
    ASSERT_TRUE(kept->set_packet({0, word("zero"), {}, {}}));
    kill((*watchdog)->process(), SIGSTOP);
    int beats = 0;
    Result<bool> beat = true;
    for (; beat && beats < 10'000; ++beats) {
        usleep(1000);
        beat = kept->beat();
    }
    ASSERT_FALSE(beat);
    EXPECT_EQ(beat.error().kind, ErrorKind::device);
    EXPECT_NE(beat.error().message.find("(safety-watchdog, " + std::to_string((*watchdog)->process()) +
                                        ") stands still; there is no force without it"),
              std::string::npos)
        << beat.error().message;
    EXPECT_GE(beats, 50) << "a busy machine may keep it waiting for a while";
    kill((*watchdog)->process(), SIGCONT);
    EXPECT_FALSE(kept->beat()) << "nobody relies on it again";
    EXPECT_FALSE(kept->set_packet({0, word("zero"), {}, {}}));
}

/// Whether it was known to be stopped or not. (In a process of its own, which would hang.)
TEST(WatchdogProcess, AStoppedOneDoesNotKeepTheProgramFromItsEnd) {
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
