// SPDX-License-Identifier: Apache-2.0
// All threads of a window at once, as a person has them: what ThreadSanitizer has to see. The program ends
// with its own code then, and with a report on stderr. Nothing is drawn by a GPU, into which it does not see.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "device/drivers/network_device.hpp"
#include "tests/unused_port.hpp"
#include "tests/window/scripted_window.hpp"

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

    /// To its end, or until that is enough.
    Outcome play(const std::string& script, const std::vector<std::string>& more,
                 const std::function<bool()>& is_enough = {}) {
        std::ofstream(folder / "script") << script;
        std::vector<std::string> words{"play",      "globe.mkv", "--headless", "--painter", "cpu",
                                       "--builder", "cpu",       "--size",     "320x200",   "--script",
                                       "script",    "--sound",   "heard.wav"};
        words.insert(words.end(), more.begin(), more.end());
        return is_enough ? run_in_folder_until(words, folder.path(), is_enough)
                         : run_in_folder(words, folder.path());
    }

    const TemporaryFolder folder;
};

TEST_F(WholeWindow, RecordsTouchDuringSeeks) {
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
    replayed(folder.path(), "hand.touch");
}

/// A hand at the other end of a UDP socket, for as long as it lives. It goes by the forces it receives, not
/// by a clock: before the globe it asks for forces with its first button, goes in until it feels something,
/// comes out, and begins again.
class PeerHand {
public:
    PeerHand() : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
        thread_ = std::thread([this] { speak(); });
    }
    ~PeerHand() {
        over_ = true;
        thread_.join();
        close(socket_);
    }
    std::string port() const { return std::to_string(ntohs(to_.sin_port)); }
    int touches() const { return touches_; }    ///< in which it felt something
    double newtons() const { return newest_; }  ///< that it was told last
    double answered_s() const { return 1e-3 * answered_ms_; }

private:
    enum class Way { asks, goes_in, comes_out };

    /// With each answer. Where it felt nothing it goes deeper the next time: the script holds the clutch
    /// while it moves, for as long as the machine likes, and the surface is as much farther away afterwards.
    void go_on() {
        constexpr double out = 0.15, step = 0.001;
        constexpr int pressed_for = 30, let_go_for = 30;  // answers
        switch (way_) {
            case Way::asks:
                buttons_ = ++asked_ <= pressed_for ? 1 : 0;
                if (asked_ < pressed_for + let_go_for) return;
                asked_ = 0;
                way_ = Way::goes_in;
                return;
            case Way::goes_in:
                place_ -= step;
                if (newest_ > 0.1) ++touches_;
                if (newest_ > 0.1 || place_ <= deepest_) way_ = Way::comes_out;
                if (place_ <= deepest_) deepest_ -= 0.15;
                return;
            case Way::comes_out:
                place_ += step;
                if (place_ >= out) way_ = Way::asks;
        }
    }
    void speak() {
        NetworkPacket packet;
        for (; !over_; ++packet.sequence) {
            packet.time_ns = 1'000'000ULL * packet.sequence;
            packet.buttons = buttons_;
            packet.vectors[0] = {0, 0, place_};
            const auto bytes = encode(packet);
            sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to_),
                   sizeof to_);
            std::array<std::byte, NetworkPacket::most_bytes> heard;
            bool is_answered = false;
            for (ssize_t got; (got = recv(socket_, heard.data(), heard.size(), 0)) > 0;)
                if (const auto told = decode_network_packet(std::span(heard).first(std::size_t(got))); told) {
                    newest_ = glm::length(told->vectors[0]);
                    is_answered = true;
                }
            if (is_answered) go_on();
            if (is_answered) answered_ms_ = answered_ms_ + 1;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));  // its own clock
        }
    }

    const int socket_;
    const sockaddr_in to_ = loopback(unused_port());
    Way way_ = Way::asks;
    int asked_ = 0;
    std::uint32_t buttons_ = 0;
    double place_ = 0.15, deepest_ = -0.15;
    std::atomic<bool> over_{false};
    std::atomic<int> touches_{0}, answered_ms_{0};
    std::atomic<double> newest_{0};
    std::thread thread_;
};

TEST_F(WholeWindow, RecordsNetworkDevice) {
    PeerHand peer;
    const Outcome played =
        play(R"(
0.3 clutch on
0.35 clutch off
0.5 hand-scale 0.8
0.7 key j
0.8 seek 0.1
0.9 force
0.95 force
1.1 overlay depth
)",
             {"--device", "network:port=" + peer.port(), "--record", "hand.touch", "--seconds", "120"},
             [&] { return peer.touches() > 1 && peer.answered_s() > 1.6; });
    ASSERT_EQ(played.code, 130) << "it felt something " << peer.touches() << " times: " << played.err;
    EXPECT_EQ(played.err, "touchable: interrupted; written up to there: --record, --sound\n");
    EXPECT_EQ(peer.newtons(), 0) << "the last that it was told";
    replayed(folder.path(), "hand.touch");
}

TEST_F(WholeWindow, RecordsCameraAcrossSettings) {
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
    replayed(folder.path(), "hand.touch");
}

TEST_F(WholeWindow, ChangesSettingsAndClip) {
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
    EXPECT_FALSE(contains(played.err, "ThreadSanitizer"));
    EXPECT_TRUE(contains(file_contents(folder / "play.json"), "\"panel\": true"));
}

}  // namespace
}  // namespace touchable::test
