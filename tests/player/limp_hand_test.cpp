// What the hand is left with while the program is stopped, when it is ended with all that was started with
// it, when only the process beside it is ended, and when the program waits for somebody. By order, not by
// time.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <optional>
#include <utility>

#include "device/network/network_packet.hpp"
#include "device/network/udp_socket.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

/// A network hand that goes into the globe, and hears packet by packet.
class GlobeHand {
public:
    explicit GlobeHand(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(port);
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    }
    ~GlobeHand() { ::close(socket_); }
    GlobeHand(const GlobeHand&) = delete;
    GlobeHand& operator=(const GlobeHand&) = delete;

    /// One packet out, and what has come by a millisecond later: the newest; nothing.
    std::optional<NetworkPacket> step() {
        NetworkPacket packet;
        packet.sequence = ++sequence_;
        packet.vectors[0] = {0, 0, place_};
        const auto bytes = encode(packet);
        [[maybe_unused]] const auto sent = ::send(socket_, bytes.data(), bytes.size(), 0);
        usleep(1000);
        std::optional<NetworkPacket> newest;
        for (std::optional<NetworkPacket> one; (one = hear(MSG_DONTWAIT));) newest = one;
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
        const timeval patience{10, 0};
        setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
        std::optional<NetworkPacket> packet;
        while ((packet = hear(0)) && !((*packet).*flag)) {
        }
        return packet;
    }

private:
    std::optional<NetworkPacket> hear(int flags) const {
        std::byte room[1024];
        const auto came = recv(socket_, room, sizeof room, flags);
        if (came < 0) return std::nullopt;
        const auto packet = decode_network_packet(std::span(room).first(static_cast<std::size_t>(came)));
        return packet.ok() ? std::optional(*packet) : std::nullopt;
    }
    int socket_;
    std::uint32_t sequence_ = 0;
    double place_ = 0.08;
};

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

class LimpHand : public ::testing::Test {
protected:
    void SetUp() override {
        const Outcome made = run_touchable({"make", "globe", clip_, "--size", "64x48", "--frames", "4"});
        ASSERT_EQ(made.code, 0) << made.err;
        UdpSocket socket;
        ASSERT_TRUE(socket.bind("127.0.0.1", 0).ok());
        port_ = socket.port();
    }
    void TearDown() override {
        if (program_ <= 0) return;
        kill(program_, SIGKILL);
        waitpid(program_, nullptr, 0);
    }
    /// In a group of its own, as a shell starts it, and with forces on.
    void start(std::vector<std::string> more = {}, int output = -1) {
        std::vector<std::string> words{TOUCHABLE_PROGRAM,
                                       "touch",
                                       clip_,
                                       "--live",
                                       "--force-on",
                                       "--device",
                                       "network:port=" + std::to_string(port_)};
        words.insert(words.end(), more.begin(), more.end());
        program_ = fork();
        if (program_ != 0) return;
        setpgid(0, 0);
        const int nowhere = open("/dev/null", O_RDWR);
        const int errors = open(said_.c_str(), O_WRONLY | O_CREAT, 0600);
        dup2(nowhere, 0);
        dup2(output < 0 ? nowhere : output, 1);
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
    std::uint16_t port_ = 0;
    pid_t program_ = 0;
};

TEST_F(LimpHand, WhileTheProgramIsStoppedAndIsAnsweredAfterwards) {
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

TEST_F(LimpHand, WhenAllOfTheProgramsGroupIsKilled) {
    start();
    GlobeHand hand(port_);
    ASSERT_TRUE(hand.feels_something()) << said();
    kill(-program_, SIGKILL);
    const auto last = hand.hears(&NetworkPacket::last);
    ASSERT_TRUE(last);
    EXPECT_EQ(last->vectors[0], glm::dvec3(0));
}

/// `pkill -9 touchable` and `pkill -9 -f touchable` end the program alone.
TEST_F(LimpHand, TheProcessBesideTheProgramHasAnotherName) {
    start();
    GlobeHand hand(port_);
    ASSERT_TRUE(hand.feels_something()) << said();
    ASSERT_GT(guardian(), 0);
    const std::filesystem::path process = "/proc/" + std::to_string(guardian());
    EXPECT_EQ(text_of(process / "comm"), "limp-keeper\n");
    EXPECT_EQ(text_of(process / "cmdline").find("touch"), std::string::npos);
}

TEST_F(LimpHand, WhenTheProcessBesideTheProgramIsEnded) {
    start();
    GlobeHand hand(port_);
    ASSERT_TRUE(hand.feels_something()) << said();
    const pid_t ended = guardian();
    ASSERT_GT(ended, 0);
    kill(ended, SIGKILL);
    const auto last = hand.hears(&NetworkPacket::last);
    ASSERT_TRUE(last);
    EXPECT_EQ(last->vectors[0], glm::dvec3(0));
    EXPECT_EQ(exit_code(), 5);
    EXPECT_NE(said().find("touchable: network hand: the process that leaves devices limp when this program "
                          "cannot (limp-keeper, " +
                          std::to_string(ended) + ") is gone; there is no force without it"),
              std::string::npos)
        << said();
}

/// Whoever asks it to stop by Ctrl-C has a limp hand, whatever the program waits for: a reader who reads
/// nothing.
TEST_F(LimpHand, AtCtrlCBeforeAnythingIsWaitedFor) {
    int ends[2];
    ASSERT_EQ(pipe2(ends, O_CLOEXEC), 0);
    start({"--forces", "-"}, ends[1]);
    ::close(ends[1]);
    GlobeHand hand(port_);
    ASSERT_TRUE(hand.feels_something()) << said();
    // Until the pipe is full, and a while longer: the hand is still answered then.
    int before = -1, in_pipe = 0;
    for (int steps = 0; steps < 20'000 && (in_pipe != before || in_pipe == 0); ++steps) {
        if (steps % 200 == 0) before = in_pipe;
        hand.step();
        if (steps % 200 == 199) {
            ASSERT_EQ(ioctl(ends[0], FIONREAD, &in_pipe), 0);
        }
    }
    kill(program_, SIGINT);
    EXPECT_TRUE(hand.hears(&NetworkPacket::last));
    ::close(ends[0]);
}

}  // namespace
}  // namespace touchable::test
