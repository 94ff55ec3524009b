// All threads of a window at once, as a person has them: what ThreadSanitizer has to see. The program ends
// with its own code then, and with a report on stderr. Nothing is drawn by a GPU, into which it does not see.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "device/network/network_packet.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

class WholeWindow : public testing::Test {
protected:
    void SetUp() override { make("globe.mkv", {"--frames", "12"}); }

    void make(const std::string& name, const std::vector<std::string>& more) {
        std::vector<std::string> words{"make", "globe", (folder / name).string(), "--size", "64x48"};
        words.insert(words.end(), more.begin(), more.end());
        ASSERT_EQ(run_touchable(words).code, 0);
    }

    Outcome play(const std::string& script, const std::vector<std::string>& more) {
        std::ofstream(folder / "script") << script;
        std::vector<std::string> words{"play",      "globe.mkv", "--headless", "--painter", "cpu",
                                       "--builder", "cpu",       "--size",     "320x200",   "--script",
                                       "script",    "--sound",   "heard.wav"};
        words.insert(words.end(), more.begin(), more.end());
        return run_in_folder(words, folder.path());
    }

    const TemporaryFolder folder;
};

TEST_F(WholeWindow, IsTouchedWhileTheClipJumpsAndIsRecorded) {
    const Outcome played = play(R"(
0.0 move 160 100
0.05 press left
0.2 seek 0.1
0.25 speed 2
0.3 move 180 110
0.35 seek 0.3
0.4 overlay depth
0.45 loop
0.5 key 5
0.55 seek-by -0.2
0.6 step 1
0.65 play-pause
0.7 overlay normals
0.75 mute
0.8 press middle
0.85 move 200 90
0.9 release middle
0.95 speed 0.5
1.0 force
1.05 force
1.1 panel
)",
                                {"--record", "hand.touch", "--seconds", "1.3"});
    ASSERT_EQ(played.code, 0) << played.err;
    EXPECT_EQ(played.err, "");
    const Outcome again = run_in_folder({"touch", "--replay", "hand.touch", "--json", "-"}, folder.path());
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_EQ(again.out.find("\"contact_ticks\": 0,"), std::string::npos) << "nothing was touched";
}

/// A hand at the other end of a UDP socket, for as long as it lives: it presses into the globe and leaves it,
/// twice a second, and has its first button down from time to time.
class PeerHand {
public:
    PeerHand() : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
        to_.sin_family = AF_INET;
        to_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof to_;
        const int other = socket(AF_INET, SOCK_DGRAM, 0);  // finds a port that is free
        bind(other, reinterpret_cast<const sockaddr*>(&to_), size);
        getsockname(other, reinterpret_cast<sockaddr*>(&to_), &size);
        close(other);
        thread_ = std::thread([this] { speak(); });
    }
    ~PeerHand() {
        over_ = true;
        thread_.join();
        close(socket_);
    }
    std::string port() const { return std::to_string(ntohs(to_.sin_port)); }
    double most_newtons() const { return most_; }  ///< that it was told
    double newtons() const { return newest_; }

private:
    void speak() {
        NetworkPacket packet;
        for (; !over_; ++packet.sequence) {
            packet.time_ns = 1'000'000ULL * packet.sequence;
            packet.buttons = packet.sequence % 400 < 50 ? 1 : 0;
            const double share = std::sin(0.012 * packet.sequence);
            // So far that at a finer scale, too, it comes in and out, wherever it was when that changed.
            packet.vectors[0] = {0, 0, 0.15 * share};
            const auto bytes = encode(packet);
            sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to_),
                   sizeof to_);
            std::array<std::byte, NetworkPacket::most_bytes> heard;
            for (ssize_t got; (got = recv(socket_, heard.data(), heard.size(), 0)) > 0;)
                if (const auto told = decode_network_packet(std::span(heard).first(std::size_t(got)));
                    told.ok()) {
                    newest_ = glm::length(told->vectors[0]);
                    most_ = std::max(most_.load(), newest_.load());
                }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));  // its own clock
        }
    }

    const int socket_;
    sockaddr_in to_{};
    std::atomic<bool> over_{false};
    std::atomic<double> most_{0}, newest_{0};
    std::thread thread_;
};

TEST_F(WholeWindow, IsTouchedByAProgramAndIsRecorded) {
    // Where the machine stood still whenever it pressed, it felt nothing, and tries again.
    double most_newtons = 0;
    for (int go = 0; go < 8 && most_newtons == 0; ++go) {
        PeerHand peer;
        const Outcome played = play(R"(
0.3 clutch on
0.35 clutch off
0.5 hand-scale 0.8
0.7 key j
0.8 seek 0.1
0.9 force
0.95 force
1.1 overlay depth
)",
                                    {"--device", "network:port=" + peer.port(), "--record", "hand.touch",
                                     "--overwrite", "--seconds", "1.6"});
        ASSERT_EQ(played.code, 0) << played.err;
        EXPECT_EQ(played.err, "");
        EXPECT_EQ(peer.newtons(), 0) << "the last that it was told";
        most_newtons = peer.most_newtons();
    }
    EXPECT_GT(most_newtons, 0);
    const Outcome again = run_in_folder({"touch", "--replay", "hand.touch", "--json", "-"}, folder.path());
    EXPECT_EQ(again.code, 0) << again.err;
}

TEST_F(WholeWindow, OfACameraChangesItsSettingsAndIsRecorded) {
    std::ofstream(folder / "script") << R"(
0.0 move 160 100
0.05 press left
0.2 median 3
0.4 seek 0.1
0.6 overlay depth
)";
    const Outcome played =
        run_in_folder({"play", "--camera", "replay:globe.mkv,fps=50,jitter=4", "--headless", "--painter",
                       "cpu", "--builder", "cpu", "--size", "320x200", "--script", "script", "--record",
                       "hand.touch", "--seconds", "0.8"},
                      folder.path());
    ASSERT_EQ(played.code, 0) << played.err;
    EXPECT_EQ(played.err,
              "touchable: warning: playback: a camera's time only goes on; a clip would take commands\n");
    const Outcome again = run_in_folder({"touch", "--replay", "hand.touch", "--json", "-"}, folder.path());
    EXPECT_EQ(again.code, 0) << again.err;
    const std::string of_both_parts = again.out.substr(0, again.out.find("\"parts\""));
    EXPECT_EQ(of_both_parts.find("\"contact_ticks\": 0,"), std::string::npos) << "nothing was touched";
}

TEST_F(WholeWindow, ChangesItsSettingsAndItsClip) {
    make("other.mkv", {"--frames", "3"});
    const Outcome played = play(R"(
0.0 move 160 100
0.05 press left
0.2 median 3
0.3 settings b
0.35 seek 0.2
0.4 settings a
0.5 open other.mkv
0.55 move 150 90
0.6 press left
0.7 open nowhere.mkv
0.75 interpolation linear
0.8 settings b
0.85 drop globe.mkv
0.95 size 400x300
1.0 reset
1.1 panel
)",
                                {"--seconds", "1.3", "--settings", "play.json"});
    ASSERT_EQ(played.code, 0) << played.err;
    EXPECT_EQ(played.err.find("ThreadSanitizer"), std::string::npos) << played.err;
    EXPECT_NE(file_contents(folder / "play.json").find("\"panel\": true"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
