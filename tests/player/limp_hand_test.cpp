// What the hand is left with while the program is stopped, when it is ended with all that was started with
// it, when only the process beside it is ended, and when the program waits for somebody. By order, not by
// time.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <optional>
#include <utility>

#include "tests/player/network_peer.hpp"
#include "tests/player/program.hpp"
#include "tests/sanitizers.hpp"

namespace touchable::test {
namespace {

using std::chrono::milliseconds;

/// A network hand that goes into the globe, and hears packet by packet.
class GlobeHand {
public:
    explicit GlobeHand(std::uint16_t port) : peer_(port) {}

    /// One packet out, and what has come by a millisecond later: the newest; nothing.
    std::optional<NetworkPacket> step() {
        peer_.say({0, 0, place_});
        usleep(1000);
        std::optional<NetworkPacket> newest;
        for (std::optional<NetworkPacket> one; (one = peer_.hear(milliseconds(0)));) newest = one;
        return newest;
    }
    /// Comes from the air until it feels something; again where the machine stood still.
    bool feels_something() {
        for (int steps = 0; steps < 40'000; ++steps) {
            place_ = 0.08 - 0.0005 * (steps % 280);
            if (const auto answer = step(); answer && glm::length(answer->vectors[0]) > 0.1) return true;
        }
        return false;
    }
    /// The next packet of that kind; nothing: there is none for a long time.
    std::optional<NetworkPacket> hears(bool NetworkPacket::*flag) {
        std::optional<NetworkPacket> packet;
        while ((packet = peer_.hear(milliseconds(10'000))) && !((*packet).*flag)) {
        }
        return packet;
    }

    /// Likewise, while it goes on: of one that falls silent the program parts by itself.
    std::optional<NetworkPacket> hears_while_it_goes_on(bool NetworkPacket::*flag) {
        for (int steps = 0; steps < 20'000; ++steps)
            if (const auto answer = step(); answer && (*answer).*flag) return answer;
        return std::nullopt;
    }

private:
    NetworkPeer peer_;
    double place_ = 0.08;
};

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

class UnpoweredHand : public ::testing::Test {
protected:
    void SetUp() override {
        const Outcome made = run_touchable({"make", "globe", clip_, "--size", "64x48", "--frames", "4"});
        ASSERT_EQ(made.code, 0) << made.err;
    }
    void TearDown() override {
        if (program_ <= 0) return;
        kill(program_, SIGKILL);
        waitpid(program_, nullptr, 0);
    }
    /// In a group of its own, as a shell starts it, and with forces on. `terminal`: for what it says; -1:
    /// that goes to a file.
    void start(int terminal = -1) {
        std::vector<std::string> words{TOUCHABLE_PROGRAM,
                                       "touch",
                                       clip_,
                                       "--live",
                                       "--force-on",
                                       "--device",
                                       "network:port=" + std::to_string(port_)};
        program_ = fork();
        if (program_ != 0) return;
        setpgid(0, 0);
        // As from a terminal, though these tests may run in a shell's background, where they are ignored.
        for (const int asked : {SIGINT, SIGTERM, SIGHUP}) std::signal(asked, SIG_DFL);
        const int nowhere = open("/dev/null", O_RDWR);
        const int errors = terminal < 0 ? open(said_.c_str(), O_WRONLY | O_CREAT, 0600) : terminal;
        for (const int stream : {0, 1}) dup2(nowhere, stream);
        dup2(errors, 2);
        std::vector<char*> arguments;
        for (std::string& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        execv(TOUCHABLE_PROGRAM, arguments.data());
        _exit(127);
    }
    /// The one process that the program has started.
    pid_t guardian() const {
        for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
            const std::string name = entry.path().filename();
            if (name.find_first_not_of("0123456789") != std::string::npos) continue;
            const std::string stat = text_of(entry.path() / "stat");
            const std::size_t at = stat.rfind(')');
            if (at == std::string::npos) continue;
            if (std::strtol(stat.c_str() + at + 4, nullptr, 10) == program_) return std::stoi(name);
        }
        return 0;
    }
    std::string said() const { return file_contents(said_); }
    int exit_code() {
        int status = 0;
        EXPECT_EQ(waitpid(std::exchange(program_, 0), &status, 0) > 0, true);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

    const TemporaryFolder folder_;
    const std::string clip_ = folder_ / "globe.mkv", said_ = folder_ / "said";
    const std::uint16_t port_ = unused_port();
    pid_t program_ = 0;
};

TEST_F(UnpoweredHand, WhileTheProgramIsStoppedAndIsAnsweredAfterwards) {
    start();
    GlobeHand hand(port_);
    ASSERT_TRUE(hand.feels_something()) << said();
    kill(program_, SIGSTOP);
    const auto still = hand.hears(&NetworkPacket::stands_still);
    ASSERT_TRUE(still);
    EXPECT_EQ(still->vectors[0], glm::dvec3(0));
    EXPECT_FALSE(still->last);
    siginfo_t state{};
    ASSERT_EQ(waitid(P_PID, static_cast<id_t>(program_), &state, WSTOPPED | WNOWAIT), 0);
    EXPECT_EQ(state.si_code, CLD_STOPPED) << "it lives";
    kill(program_, SIGCONT);
    bool is_answered = false;
    for (int steps = 0; steps < 10'000 && !is_answered; ++steps)
        if (const auto answer = hand.step(); answer)
            is_answered = !answer->stands_still && answer->sequence > 1;
    EXPECT_TRUE(is_answered);
}

TEST_F(UnpoweredHand, WhenAllOfTheProgramsGroupIsKilled) {
    start();
    GlobeHand hand(port_);
    ASSERT_TRUE(hand.feels_something()) << said();
    kill(-program_, SIGKILL);
    const auto last = hand.hears(&NetworkPacket::last);
    ASSERT_TRUE(last);
    EXPECT_EQ(last->vectors[0], glm::dvec3(0));
}

/// `pkill -9 touchable` and `pkill -9 -f touchable` end the program alone.
TEST_F(UnpoweredHand, TheProcessBesideTheProgramHasAnotherName) {
    start();
    GlobeHand hand(port_);
    ASSERT_TRUE(hand.feels_something()) << said();
    ASSERT_GT(guardian(), 0);
    const std::filesystem::path process = "/proc/" + std::to_string(guardian());
    EXPECT_EQ(text_of(process / "comm"), "safety-watchdog\n");
    EXPECT_EQ(text_of(process / "cmdline").find("touch"), std::string::npos);
}

class UnpoweredHandWithoutWatchdog : public UnpoweredHand,
                                     public ::testing::WithParamInterface<std::pair<int, const char*>> {};

TEST_P(UnpoweredHandWithoutWatchdog, IsLimpAndTheProgramEndsAndSaysWhy) {
    const auto [signal, what] = GetParam();
    start();
    GlobeHand hand(port_);
    ASSERT_TRUE(hand.feels_something()) << said();
    const pid_t ended = guardian();
    ASSERT_GT(ended, 0);
    kill(ended, signal);
    const auto last = hand.hears_while_it_goes_on(&NetworkPacket::last);
    ASSERT_TRUE(last);
    EXPECT_EQ(last->vectors[0], glm::dvec3(0));
    EXPECT_EQ(exit_code(), 5);
    EXPECT_NE(
        said().find("touchable: network hand: the process that leaves devices unpowered when this program "
                    "cannot (safety-watchdog, " +
                    std::to_string(ended) + ") " + what + "; there is no force without it"),
        std::string::npos)
        << said();
}

INSTANTIATE_TEST_SUITE_P(Signals, UnpoweredHandWithoutWatchdog,
                         ::testing::Values(std::pair{SIGKILL, "is gone"},
                                           std::pair{SIGSTOP, "stands still"}));

/// Whoever asks it to stop by Ctrl-C has an unpowered hand, whatever the program waits for: a terminal that
/// is held by Ctrl-S takes not even the line that says how it goes, and never answers.
TEST_F(UnpoweredHand, AtCtrlCBeforeAnythingIsWaitedFor) {
    TOUCHABLE_SKIP_UNDER_THREAD_SANITIZER(
        "a signal does not reach its handler while the thread hangs in write(2)");
    int keyboard = -1, terminal = -1;
    ASSERT_EQ(openpty(&keyboard, &terminal, nullptr, nullptr, nullptr), 0);
    start(terminal);
    GlobeHand hand(port_);
    EXPECT_TRUE(hand.feels_something());
    ASSERT_EQ(tcflow(terminal, TCOOFF), 0);
    for (int answers = 0, steps = 0; answers < 1000 && steps < 20'000; ++steps)
        answers += hand.step() ? 1 : 0;
    ASSERT_EQ(waitpid(program_, nullptr, WNOHANG), 0) << "it waits, and the hand does not";
    kill(program_, SIGINT);
    EXPECT_TRUE(hand.hears_while_it_goes_on(&NetworkPacket::last));
    EXPECT_EQ(waitpid(program_, nullptr, WNOHANG), 0) << "it still waits";
    ASSERT_EQ(tcflow(terminal, TCOON), 0);
    EXPECT_EQ(exit_code(), 130);
    for (const int end : {keyboard, terminal}) ::close(end);
}

}  // namespace
}  // namespace touchable::test
