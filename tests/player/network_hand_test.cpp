// SPDX-License-Identifier: Apache-2.0
// Another program as the hand: from its datagrams to forces and back, and no force once either ends. No test
// depends on a deadline.

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <regex>
#include <span>
#include <sstream>
#include <thread>
#include <utility>

#include "device/drivers/network_device.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/limits.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/stream/servers.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

/// Output of a command, and its exit code behind it.
std::string said_by(const std::string& command) {
    std::string said;
    FILE* pipe = popen((command + " 2>&1; echo exit $?").c_str(), "r");
    std::array<char, 256> some;
    while (fgets(some.data(), some.size(), pipe)) said += some.data();
    pclose(pipe);
    return said;
}

int times_in(const std::string& text, const std::string& words) {
    int times = 0;
    for (std::size_t at = 0; (at = text.find(words, at)) != std::string::npos; at += words.size()) ++times;
    return times;
}

/// Newtons that a hand of Python says it has felt; 0: none.
double felt_force(const std::string& said) {
    const std::string words = "largest force ";
    const std::size_t at = said.find(words);
    return at == std::string::npos ? 0 : std::strtod(said.c_str() + at + words.size(), nullptr);
}

/// The peer of `--device network:port=PORT`: one finger, packet by packet, by a socket that is made
/// by other means than the driver's.
class NetworkPeer {
public:
    explicit NetworkPeer(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
        const sockaddr_in to = loopback(port);
        EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    }
    ~NetworkPeer() { ::close(socket_); }
    NetworkPeer(const NetworkPeer&) = delete;
    NetworkPeer& operator=(const NetworkPeer&) = delete;

    void say(const glm::dvec3& place) {
        NetworkPacket packet;
        packet.sequence = ++sequence_;
        packet.vectors[0] = place;
        const auto bytes = encode(packet);
        [[maybe_unused]] const auto sent = ::send(socket_, bytes.data(), bytes.size(), 0);
    }
    /// The next packet; nothing: none comes in that time.
    std::optional<NetworkPacket> hear(std::chrono::milliseconds patience) const {
        pollfd waited_for{socket_, POLLIN, 0};
        std::byte room[1024];
        while (poll(&waited_for, 1, static_cast<int>(patience.count())) == 1) {
            const auto came = recv(socket_, room, sizeof room, 0);
            // The error of a closed port comes before the last packet.
            if (came < 0 && errno == ECONNREFUSED) continue;
            if (came < 0) break;
            const auto packet = decode_network_packet(std::span(room).first(static_cast<std::size_t>(came)));
            if (packet) return *packet;
        }
        return std::nullopt;
    }

private:
    const int socket_;
    std::uint32_t sequence_ = 0;
};

/// A hand that, once it is answered, comes towards the middle of the picture, half a millimetre a packet,
/// until it feels a tenth of a newton. Where that was nothing, as of a surface that jumped meanwhile, it goes
/// back and comes again.
class PressingHand {
public:
    explicit PressingHand(std::uint16_t port) : peer_(port) {}

    /// Sends a packet; gives the newest answer that has come within a moment.
    NetworkPacket rest_at(double place) {
        place_ = place;
        way_ = 0;
        return press();
    }
    NetworkPacket press() {
        if (newest_.kind == NetworkPacket::Kind::forces && glm::length(newest_.vectors[0]) <= 0.1)
            place_ += way_;
        if (place_ < -0.06) way_ = 0.0005;
        if (place_ > 0.1) way_ = -0.0005;
        peer_.say({0, 0, place_});
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return hear(0);
    }
    bool feels_something() {
        for (int tries = 0; tries < 20'000; ++tries)
            if (glm::length(press().vectors[0]) > 0.1) return true;
        return false;
    }
    double place() const { return place_; }
    void go_out() { way_ = 0.0005; }  ///< and come again
    /// Discards all earlier answers.
    void forget() {
        hear(20);
        newest_ = {};
    }
    NetworkPacket hear(int patience_ms) {
        while (const auto packet = peer_.hear(std::chrono::milliseconds(patience_ms))) {
            newest_ = *packet;
            if (newest_.last) break;
        }
        return newest_;
    }

private:
    NetworkPeer peer_;
    double place_ = 0.1, way_ = -0.0005;
    NetworkPacket newest_;
};

/// The force in a row of a device's log, newtons.
std::array<double, 3> sent_of(const std::string& row) {
    std::array<double, 11> cells{};
    std::istringstream in(row);
    std::string cell;
    for (double& value : cells)
        if (std::getline(in, cell, ',')) value = std::strtod(cell.c_str(), nullptr);
    return {cells[7], cells[8], cells[9]};
}

/// Touches with these words, and starts `hand`, a command, once the program waits for one; ends the program
/// once the hand has ended. `said`: as said_by().
Outcome touch_with(const std::string& hand, const Words& words, std::string& said) {
    std::thread beside;
    std::atomic<bool> has_ended = false;
    const Outcome outcome = run_on_terminal(words, [&](const std::string& shown) {
        if (!beside.joinable() && shown.find("waiting for a hand at UDP") != std::string::npos)
            beside = std::thread([&] {
                said = said_by(hand);
                has_ended = true;
            });
        return has_ended.load();
    });
    if (beside.joinable()) beside.join();
    return outcome;
}

class NetworkTouch : public ::testing::Test {
protected:
    NetworkTouch() { succeed({"make", "globe", clip, "--size", "64x48", "--frames", "4"}); }
    std::string device() const { return "network:port=" + std::to_string(port); }

    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", report = folder / "r.json", log = folder / "log.csv",
                      forces = folder / "forces.csv", record = folder / "live.rec";
    const std::uint16_t port = unused_port();
};

TEST_F(NetworkTouch, PythonExampleFeelsAndReplays) {
    nlohmann::json facts;
    std::string said;
    Outcome live;
    const auto rising_ticks = [&] {
        const auto told = read_forces(forces);
        return std::count_if(told.begin(), told.end(),
                             [](const ForcesRow& row) { return row["share"] > 0 && row["share"] < 1; });
    };
    // A hand that the machine keeps from its packets feels nothing: it then takes longer.
    const auto is_felt = [&] {
        return !stood_still(facts) && facts["contact_ticks"] > 50 && felt_force(said) > 0 &&
               rising_ticks() > 0;
    };
    for (int seconds = 3; seconds == 3 || (!is_felt() && seconds < 200); seconds *= 2) {
        live = touch_with(
            "/usr/bin/python3 " TOUCHABLE_SOURCE_DIR "/device/examples/network_hand.py " +
                std::to_string(seconds) + " " + std::to_string(port),
            {"touch", clip, "--live", "--device", device(), "--force-on", "--seconds", "600", "--overwrite",
             "--verbose", "--json", report, "--device-log", log, "--record", record, "--forces", forces},
            said);
        ASSERT_EQ(live.code, 130) << live.err;
        facts = json_in(report);
    }
    EXPECT_PRED2(says, said, "ms p99, largest force ");
    EXPECT_PRED2(says, said, "exit 0");
    EXPECT_GT(felt_force(said), 0) << said;
    EXPECT_EQ(facts["device"], "network hand");
    EXPECT_GT(facts["forces_on_ticks"], 1000);
    EXPECT_GT(facts["contact_ticks"], 50);
    EXPECT_GT(facts["longest_device_call_ms"].get<double>(), 0);
    EXPECT_TRUE(std::isfinite(facts["longest_device_call_ms"].get<double>()));
    EXPECT_PRED2(says, live.out, "\n  device calls          longest ");
    EXPECT_EQ(facts["proxy_behind_mesh_ticks"], 0);
    succeed({"touch", "--replay", record, "--json", folder / "again.json"});
    EXPECT_EQ(json_in(folder / "again.json")["force_hash"], facts["force_hash"]);

    std::ifstream rows(log);
    std::string header, row;
    std::getline(rows, header);
    EXPECT_EQ(header, "time_s,finger,x,y,z,buttons,age_ms,fx,fy,fz,force_on");
    const auto told = read_forces(forces);
    std::size_t count = 0;
    double most = 0;
    for (; std::getline(rows, row); ++count) {
        ASSERT_LT(count, told.size());
        // The row of a tick has the force that was sent in it.
        const std::array<double, 3> sent = sent_of(row), of_it = told[count].vector("force");
        for (std::size_t axis = 0; axis < 3; ++axis) ASSERT_NEAR(of_it[axis], sent[axis], 1e-12) << row;
        most = std::max(most, length(sent));
    }
    EXPECT_EQ(count, facts["ticks"].get<std::size_t>());
    EXPECT_NEAR(facts["force_n"]["max"].get<double>(), most, 1e-12);
    EXPECT_GT(rising_ticks(), 0) << "it did not come on as it should";
    const std::string plotted =
        said_by("/usr/bin/python3 " TOUCHABLE_SOURCE_DIR "/device/examples/plot_live.py " +
                (folder / "plot.png").string() + " < " + log);
    EXPECT_EQ(plotted, "exit 0\n");
    EXPECT_EQ(file_contents(folder / "plot.png").substr(1, 3), "PNG");
}

/// The block of Python in docs/devices.md.
std::string documented_hand() {
    std::ifstream in(std::string(TOUCHABLE_SOURCE_DIR) + "/docs/devices.md");
    std::string line, script;
    while (std::getline(in, line) && line != "```python") {
    }
    while (std::getline(in, line) && line != "```") script += line + "\n";
    return script;
}

/// The text, whose one `word` is another one.
std::string with(std::string text, const std::string& word, const std::string& other) {
    EXPECT_EQ(times_in(text, word), 1) << word << " in:\n" << text;
    return text.replace(std::min(text.find(word), text.size()), word.size(), other);
}

TEST_F(NetworkTouch, DocumentedHandFeelsGlobe) {
    const std::string script = with(documented_hand(), "5710", std::to_string(port));
    std::string said;
    for (int ticks = 3000; ticks == 3000 || (felt_force(said) == 0 && ticks < 200'000); ticks *= 2) {
        const std::string as_long =
            with(script, "range(1, 3001)", "range(1, " + std::to_string(ticks + 1) + ")");
        std::ofstream(folder / "hand.py")
            << with(as_long, "tick == 3000", "tick == " + std::to_string(ticks));
        const Outcome live = touch_with("/usr/bin/python3 " + (folder / "hand.py").string(),
                                        {"touch", clip, "--live", "--device", device(), "--force-on",
                                         "--seconds", "600", "--overwrite", "--json", report},
                                        said);
        EXPECT_EQ(live.code, 130) << live.err;
    }
    EXPECT_PRED2(says, said, " answers, largest force ");
    EXPECT_GT(felt_force(said), 0) << said;
    EXPECT_PRED2(says, said, "exit 0");
}

TEST_F(NetworkTouch, SerialBoardFeelsGlobe) {
    std::string said;
    for (int seconds = 3; seconds == 3 || (felt_force(said) == 0 && seconds < 200); seconds *= 2) {
        const Outcome live = touch_with(
            "/usr/bin/python3 " TOUCHABLE_SOURCE_DIR "/tests/player/serial_board.py " TOUCHABLE_SOURCE_DIR
            "/examples/python/serial_hand.py " +
                std::to_string(port) + " " + std::to_string(seconds),
            {"touch", clip, "--live", "--device", device(), "--force-on", "--max-force", "1", "--seconds",
             "600", "--overwrite", "--json", report},
            said);
        EXPECT_EQ(live.code, 130) << live.err;
    }
    EXPECT_GT(felt_force(said), 0) << said;
    EXPECT_LE(felt_force(said), 1) << said;
    EXPECT_TRUE(
        std::regex_search(said, std::regex("the bridge: /dev/pts/[0-9]+: .*; [1-9][0-9]* places sent, "
                                           "[0-9]+ lines damaged\\nexit 0")))
        << said;
}

TEST_F(NetworkTouch, ExampleReportsMissingAnswer) {
    const std::string example = "/usr/bin/python3 " TOUCHABLE_SOURCE_DIR "/device/examples/network_hand.py ";
    const std::string alone = said_by(example + "0.05 " + std::to_string(port));
    EXPECT_PRED2(says, alone,
                 "no answer from UDP 127.0.0.1:" + std::to_string(port) + ": no program listens there");
    EXPECT_PRED2(says, alone, "exit 1");
    UdpSocket deaf;
    ASSERT_TRUE(deaf.bind("127.0.0.1", 0));
    const std::string unheard = said_by(example + "0.05 " + std::to_string(deaf.port()));
    EXPECT_PRED2(says, unheard, ": no answer came");
    EXPECT_EQ(unheard.find("Traceback"), std::string::npos) << unheard;
    const std::string help = said_by(example + "--help");
    EXPECT_PRED2(says, help, "A small hand");
    EXPECT_PRED2(says, help, "exit 0");
}

TEST_F(NetworkTouch, ReportsSlowLogReader) {
    const std::string command =
        std::string("set -o pipefail; ") + TOUCHABLE_PROGRAM + " touch " + clip + " --live --device " +
        device() + " --seconds 8 --device-log - | (IFS= read -r header; sleep 9; cat > " + log + ")";
    // A machine that stood still makes too few ticks to overflow the queue.
    std::string said;
    for (int go = 0; go < most_standstills && said.find("exit 3") == std::string::npos; ++go) {
        said = said_by("bash -c '" + command + "'");
        const std::string rows = file_contents(log);
        if (std::count(rows.begin(), rows.end(), '\n') > 7000) break;
    }
    EXPECT_PRED2(says, said, "--device-log -: its disk or its reader was too slow for 1000 ticks a second: ");
    EXPECT_PRED2(says, said, " ticks are missing");
    EXPECT_PRED2(says, said, "exit 3");
}

TEST_F(NetworkTouch, LivePlotEndsWithInput) {
    const std::string picture = (folder / "live.png").string();
    const std::string command = std::string("set -o pipefail; ") + TOUCHABLE_PROGRAM + " touch " + clip +
                                " --live --device " + device() +
                                " --seconds 3 --device-log - | /usr/bin/python3 " TOUCHABLE_SOURCE_DIR
                                "/device/examples/plot_live.py " +
                                picture;
    const std::string said = said_by("bash -c '" + command + "'");
    EXPECT_PRED2(says, said, "exit 0");
    EXPECT_EQ(file_contents(picture).substr(1, 3), "PNG");
}

TEST_F(NetworkTouch, ForcesAreOffUntilRequested) {
    Outcome live;
    nlohmann::json facts;
    for (int go = 0; go == 0 || (stood_still(facts) && go < most_standstills); ++go) {
        std::atomic<bool> is_over = false;
        std::thread touchable([&] {
            live = run_touchable({"touch", clip, "--live", "--device", device(), "--seconds", "3",
                                  "--overwrite", "--json", report, "--forces", forces});
            is_over = true;
        });
        PressingHand hand(port);
        while (!is_over) EXPECT_EQ(hand.press().vectors[0], glm::dvec3(0));
        touchable.join();
        ASSERT_EQ(live.code, 0) << live.err;
        facts = json_in(report);
    }
    EXPECT_PRED2(says, live.err, "forces are off");
    EXPECT_EQ(facts["forces_on_ticks"], 0);
    // Nor is one told of, though the hand was pressed in.
    EXPECT_GT(facts["contact_ticks"], 0);
    EXPECT_EQ(facts["held_back_ticks"], facts["contact_ticks"]);
    EXPECT_EQ(facts["force_n"]["max"], 0);
    EXPECT_EQ(facts["force_limited"]["finger_ticks"], 0);
    for (const char* figure : {"created", "zoh_bound", "surface", "on_hand"})
        EXPECT_NEAR(facts["energy_mj"][figure].get<double>(), 0, 1e-9) << figure;
    EXPECT_PRED2(says, live.out, "with no force or a part of it: forces were off");
    for (const ForcesRow& row : read_forces(forces)) {
        ASSERT_EQ(row["share"], 0) << row["tick"];
        ASSERT_EQ(length(row.vector("force")), 0) << row["tick"];
    }
}

TEST_F(NetworkTouch, AsksBuriedFingerToLift) {
    const std::string told = "forces on; lift the finger off the surface", felt = "; forces on\033[K";
    for (const auto& [place, is_inside] : {std::pair{0.0, false}, std::pair{-0.04, true}}) {
        Outcome live;
        std::atomic<bool> is_over = false;
        std::thread touchable([&, wanted = is_inside ? told : felt] {
            live = run_on_terminal(
                {"touch", clip, "--live", "--device", device(), "--force-on", "--seconds", "60"},
                [&](const std::string& shown) { return times_in(shown, wanted) >= 3; });
            is_over = true;
        });
        PressingHand hand(port);
        while (!is_over) EXPECT_EQ(hand.rest_at(place).vectors[0], glm::dvec3(0));
        touchable.join();
        EXPECT_EQ(live.code, 130) << "it was to end once its line had said that thrice: " << live.err;
        EXPECT_EQ(times_in(live.err, told) > 0, is_inside) << live.err;
    }
}

/// The program, with the device and forces from the start, until it is asked to end.
class RunningProgram {
public:
    RunningProgram(const std::string& clip, const std::string& device, const std::string& record)
        : program_(start_touchable(
              {"touch", clip, "--live", "--device", device, "--force-on", "--record", record})) {}
    ~RunningProgram() {
        send(SIGCONT);
        send(SIGTERM);
        waitpid(program_, nullptr, 0);
    }
    RunningProgram(const RunningProgram&) = delete;
    RunningProgram& operator=(const RunningProgram&) = delete;
    void send(int signal) const { kill(program_, signal); }
    /// It has stopped once this returns.
    void stop() const {
        send(SIGSTOP);
        int state = 0;
        ASSERT_EQ(waitpid(program_, &state, WUNTRACED), program_);
        ASSERT_TRUE(WIFSTOPPED(state));
    }

private:
    const pid_t program_;
};

/// For 600 answers under the surface; then the hand goes out.
void expect_no_force(PressingHand& hand, double inside) {
    int answers = 0;
    std::uint32_t answered = 0;
    for (int tries = 0; answers < 600 && tries < 60'000; ++tries) {
        const NetworkPacket answer = hand.rest_at(inside);
        ASSERT_EQ(answer.kind == NetworkPacket::Kind::forces ? answer.vectors[0] : glm::dvec3(0),
                  glm::dvec3(0))
            << "answer " << answers;
        if (!answer.last && answer.sequence != std::exchange(answered, answer.sequence)) ++answers;
    }
    EXPECT_EQ(answers, 600) << "the program does not answer any more";
    hand.go_out();
}

/// A program that was stopped, as by a debugger or a machine that swaps, may find any hand anywhere.
TEST_F(NetworkTouch, StandstillRequiresFreeFinger) {
    std::optional<RunningProgram> program(std::in_place, clip, device(), record);
    PressingHand hand(port);
    for (const bool goes_in_meanwhile : {false, true}) {
        ASSERT_TRUE(hand.feels_something());
        const double inside = hand.place() - 0.004;
        if (goes_in_meanwhile)
            for (int packet = 0; packet < 300; ++packet) hand.rest_at(inside + 0.04);
        program->stop();
        std::this_thread::sleep_for(std::chrono::milliseconds(400));
        hand.forget();
        program->send(SIGCONT);
        expect_no_force(hand, inside);
    }
    EXPECT_TRUE(hand.feels_something()) << "it goes out of the surface, and comes again";
    program.reset();
    const RecordingBytes raw(file_contents(record));
    int gaps = 0;
    for (std::size_t tick = 0; tick < raw.ticks(); ++tick)
        gaps += (raw.integer(raw.guard_at(tick, 0), 4) & guard_gap) != 0;
    EXPECT_GE(gaps, 2);
    succeed({"touch", "--replay", record});
}

/// docs/devices.md: after more than 50 ms, which a slow machine only makes longer.
TEST_F(NetworkTouch, SilenceRequiresFreeFinger) {
    const RunningProgram program(clip, device(), record);
    PressingHand hand(port);
    ASSERT_TRUE(hand.feels_something());
    const double inside = hand.place() - 0.004;
    std::this_thread::sleep_for(std::chrono::milliseconds(70));
    hand.forget();
    expect_no_force(hand, inside);
    EXPECT_TRUE(hand.feels_something()) << "it goes out of the surface, and comes again";
}

TEST_F(NetworkTouch, AnyExitUnpowersHand) {
    for (const int signal : {SIGKILL, SIGSEGV, SIGABRT, SIGTERM}) {
        // Another each time: the guardian of the program before may hold its own for a while.
        const std::uint16_t own_port = unused_port();
        const std::string own_device = "network:port=" + std::to_string(own_port);
        const std::string said = folder / "said.txt";
        const int said_to = creat(said.c_str(), 0600);
        const pid_t program =
            start_touchable({"touch", clip, "--live", "--device", own_device, "--force-on"}, -1, -1, said_to);
        ::close(said_to);
        PressingHand hand(own_port);
        EXPECT_TRUE(hand.feels_something()) << signal;
        ASSERT_EQ(waitpid(program, nullptr, WNOHANG), 0)
            << "it is gone before signal " << signal << ": " << file_contents(said);
        kill(program, signal);
        const NetworkPacket last = hand.hear(5000);
        EXPECT_TRUE(last.last) << "no last packet for the hand, after signal " << signal;
        EXPECT_EQ(last.vectors[0], glm::dvec3(0));
        waitpid(program, nullptr, 0);
    }
}

TEST_F(NetworkTouch, RejectsInvalidOptions) {
    const std::vector<std::pair<Words, std::string>> refused{
        {{"--device", device()}, "--live"},
        {{"--live", "--device", "network:port=0"}, "1 to 65535"},
        {{"--live", "--device", "network:listen=192.0.2.1"}, "192.0.2.1"},
        {{"--live", "--device", device(), "--world-from-camera", "1,2,3"}, "16 numbers"},
        {{"--live", "--device", device(), "--world-from-camera", "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1"},
         "rotation"},
        {{"--live", "--device", "simulated", "--device", device()}, "simulated"},
        {{"--live", "--force-on"}, "--device"},
        {{"--live", "--device", device(), "--hand", "poke"}, "--hand"},
        {{"--live", "--device", "mouse"}, "touchable play"},
        {{"--live", "--device", "falkon"}, "simulated"},
        {{"--live", "--device", "simulated:mass=no"}, "0.05 to 10 kg"},
        {{"--live", "--device", device(), "--world-from-camera", ""}, "16 numbers"},
        {{"--live", "--device-log", log}, "--device-log"},
    };
    for (const auto& [words, part] : refused) {
        const Outcome outcome = run_touchable(plus({"touch", clip, "--seconds", "0.1"}, words));
        EXPECT_TRUE(outcome.code == 2 || outcome.code == 5) << outcome.code << ' ' << outcome.err;
        EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
        EXPECT_PRED2(says, outcome.err, part);
    }
}

// Streams in the program: what is touched of one is what is touched of its file.

class StreamedClip : public TouchedCamera {
protected:
    StreamedClip() {
        succeed({"make", "moving", clip, "--size", "64x48", "--frames", "30"});
        bytes = read_bytes(clip);
    }
    /// A web server with that one file, of which it gives parts.
    std::unique_ptr<LoopbackSender> web_server() const {
        return std::make_unique<LoopbackSender>([this](const LoopbackSender::Listener& to, int) {
            const std::string asked = to.request();
            std::size_t from = 0;
            if (const auto range = asked.find("Range: bytes="); range != std::string::npos)
                from = std::stoul(asked.substr(range + 13));
            const std::string size = std::to_string(bytes.size());
            (void)to.send("HTTP/1.1 206 Partial Content\r\nAccept-Ranges: bytes\r\nContent-Range: bytes " +
                          std::to_string(from) + "-" + std::to_string(bytes.size() - 1) + "/" + size +
                          "\r\nContent-Length: " + std::to_string(bytes.size() - from) +
                          "\r\nConnection: close\r\n\r\n" + bytes.substr(from));
        });
    }
    /// Sends the clip to every connection, in pieces, over and over.
    std::unique_ptr<LoopbackSender> paced_sender() const {
        return std::make_unique<LoopbackSender>([this](const LoopbackSender::Listener& to, int) {
            constexpr std::size_t pieces = 60;
            for (std::size_t at = 0; at < bytes.size(); at += bytes.size() / pieces)
                if (!to.send(std::string_view(bytes).substr(at, bytes.size() / pieces)) ||
                    !to.wait(std::chrono::milliseconds(5)))
                    return;
        });
    }

    const std::string clip = folder / "moving.mkv";
    std::string bytes;
};

TEST_F(StreamedClip, MatchesFileForces) {
    const auto felt = touch({clip, "--fingers", "2"});
    const LoopbackSender sender(bytes);
    const auto server = web_server();
    for (const std::string& url : {sender.url(), server->url("http", "/moving.mkv")}) {
        const auto streamed = touch({url, "--fingers", "2"});
        EXPECT_EQ(streamed["force_hash"], felt["force_hash"]) << url;
        EXPECT_EQ(streamed["clip"], url);
        EXPECT_TRUE(streamed["warnings"].empty() || streamed["warnings"] == felt["warnings"]);
        const Outcome info = succeed({"info", url});
        EXPECT_EQ(info.out.find(url), 0U) << info.out;
        const std::string saved = folder / "saved.mkv";
        succeed({"convert", url, saved, "--overwrite"});
        EXPECT_EQ(touch({saved, "--fingers", "2"})["force_hash"], felt["force_hash"]) << url;
    }
}

TEST_F(StreamedClip, LiveRunReplaysWithoutStream) {
    std::string url;
    nlohmann::json lived;
    {
        const auto sender = paced_sender();
        url = sender->url();
        lived = touch({"--live", url, "--seconds", "2", "--hand", "press", "--fingers", "2", "--latency",
                       "50", "--record", record});
    }
    EXPECT_EQ(lived["camera"], "stream:" + url);
    EXPECT_GT(lived["frames_shown"], 0) << said;
    EXPECT_GT(lived["contact_ticks"], 0) << said;
    EXPECT_GT(lived["stream"]["whole"], 0);
    EXPECT_EQ(lived["stream"]["torn"], 0);
    EXPECT_LE(lived["stream"]["delay_ms"], 50);
    EXPECT_PRED2(says, said, "framesets whole");
    const auto again = touch({"--replay", record, "--builder", "reference"});
    EXPECT_EQ(again["force_hash"], lived["force_hash"]);
    EXPECT_EQ(said.find("not the recorded ones"), std::string::npos) << said;
}

TEST_F(StreamedClip, ServedFileIsNoCamera) {
    const auto server = web_server();
    const auto lived = touch({"--live", server->url("http", "/moving.mkv"), "--seconds", "0.3"});
    EXPECT_FALSE(lived.contains("camera"));
    EXPECT_TRUE(lived.contains("late_frames"));
}

TEST_F(StreamedClip, RejectsInvalidOptions) {
    const LoopbackSender sender(bytes);
    for (const auto& [words, code, fragment] : std::vector<std::tuple<Words, int, std::string>>{
             {{"touch", clip, "--latency", "5"}, 2, "--latency is for a stream"},
             {{"touch", "--live", sender.url(), "--latency", "0"}, 2, "1 to 5000"},
             {{"touch", "tcp://127.0.0.1"}, 2, "HOST:PORT"},
             {{"touch", "--live", "srt://127.0.0.1:1?key=1"}, 2, "has no setting"},
             {{"touch", sender.url(), "--fov", "60"}, 2, "has its scene in it"},
             {{"touch", "--live", sender.url(), "--fov", "60"}, 2, "has its scene in it"},
             {{"info", "pipe:77"}, 3, "no open descriptor 77"}}) {
        expect_failure(words, code, fragment);
    }
}

TEST_F(StreamedClip, SilentStreamIsInterruptible) {
    const LoopbackSender silent(
        [](const LoopbackSender::Listener& to, int) { (void)to.wait(std::chrono::hours(1)); });
    for (const Words& words : {Words{"touch", silent.url()}, Words{"touch", "--live", silent.url()}}) {
        expect_failure(run_interrupted_at_once(words), 130);
    }
}

// The hand's last force while the program is stopped, when it is ended with all that was started with it,
// when only the process beside it is ended, and when the program waits for output. By order, not by time.

using std::chrono::milliseconds;

/// A network hand that goes into the globe, and hears packet by packet.
class GlobeHand {
public:
    explicit GlobeHand(std::uint16_t port) : peer_(port) {}

    /// Sends a packet; gives the newest answer that has come a millisecond later, or nothing.
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

    /// As hears(), but keeps sending: the program drops a hand that falls silent.
    std::optional<NetworkPacket> hears_while_it_goes_on(bool NetworkPacket::*flag) {
        for (int steps = 0; steps < 20'000; ++steps)
            if (const auto answer = step(); answer && (*answer).*flag) return answer;
        return std::nullopt;
    }

private:
    NetworkPeer peer_;
    double place_ = 0.08;
};

class UnpoweredHand : public ::testing::Test {
protected:
    void SetUp() override { succeed({"make", "globe", clip_, "--size", "64x48", "--frames", "4"}); }
    void TearDown() override {
        if (program_ <= 0) return;
        kill(program_, SIGKILL);
        waitpid(program_, nullptr, 0);
    }
    /// With forces on. `terminal`: for what it says; -1: that goes to a file.
    void start(int terminal = -1) {
        const int errors = terminal < 0 ? creat(said_.c_str(), 0600) : dup(terminal);
        program_ = start_touchable(
            {"touch", clip_, "--live", "--force-on", "--device", "network:port=" + std::to_string(port_)}, -1,
            -1, errors);
        ::close(errors);
    }
    /// The one process that the program has started.
    pid_t guardian() const {
        for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
            const std::string name = entry.path().filename();
            if (name.find_first_not_of("0123456789") != std::string::npos) continue;
            const std::string stat = file_contents(entry.path() / "stat");
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

TEST_F(UnpoweredHand, RecoversAfterStoppedProgram) {
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

TEST_F(UnpoweredHand, FollowsKilledProcessGroup) {
    start();
    GlobeHand hand(port_);
    ASSERT_TRUE(hand.feels_something()) << said();
    kill(-program_, SIGKILL);
    const auto last = hand.hears(&NetworkPacket::last);
    ASSERT_TRUE(last);
    EXPECT_EQ(last->vectors[0], glm::dvec3(0));
}

/// `pkill -9 touchable` and `pkill -9 -f touchable` end the program alone.
TEST_F(UnpoweredHand, WatchdogHasAnotherName) {
    start();
    GlobeHand hand(port_);
    ASSERT_TRUE(hand.feels_something()) << said();
    ASSERT_GT(guardian(), 0);
    const std::filesystem::path process = "/proc/" + std::to_string(guardian());
    EXPECT_EQ(file_contents(process / "comm"), "safety-watchdog\n");
    EXPECT_EQ(file_contents(process / "cmdline").find("touch"), std::string::npos);
}

class UnpoweredHandWithoutWatchdog : public UnpoweredHand,
                                     public ::testing::WithParamInterface<std::pair<int, const char*>> {};

TEST_P(UnpoweredHandWithoutWatchdog, EndsProgramWithReason) {
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

/// Ctrl-C leaves the hand unpowered, whatever the program waits for: a terminal that is held by Ctrl-S takes
/// not even the line that says how it goes, and never answers.
TEST_F(UnpoweredHand, CtrlCUnpowersBeforeWaiting) {
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
