// A hand in closed loop through real sockets, in virtual time: it rests up to the stiffness that theory says
// of its delay (docs/measurements.md), and shakes beyond.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <deque>

#include "device/drivers/driven_device.hpp"
#include "device/drivers/network_device.hpp"
#include "device/point_motion.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

constexpr double period_s = 0.001;

/// A handle in a hand behind a socket: tells where it is, and is pushed by the newest force that has come.
class FarHand {
public:
    FarHand(std::uint16_t port, const HandleDynamics& dynamics)
        : handle_(dynamics, period_s), socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(port);
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    }
    ~FarHand() { ::close(socket_); }
    FarHand(const FarHand&) = delete;
    FarHand& operator=(const FarHand&) = delete;

    HeldHandle& handle() { return handle_; }
    void tell() {
        NetworkPacket packet;
        packet.sequence = ++sequence_;
        packet.vectors[0] = handle_.reading();
        const auto bytes = encode(packet);
        ASSERT_EQ(::send(socket_, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    }
    /// The force that answers what was told last.
    glm::dvec3 hear() {
        std::byte room[1024];
        for (pollfd waited_for{socket_, POLLIN, 0}; poll(&waited_for, 1, 2000) == 1;) {
            const auto came = recv(socket_, room, sizeof room, 0);
            const auto packet = decode_network_packet(std::span(room).first(static_cast<std::size_t>(came)));
            if (packet && packet->sequence == sequence_) force_ = packet->vectors[0];
            if (packet && packet->sequence == sequence_ && poll(&waited_for, 1, 0) == 0) return force_;
        }
        ADD_FAILURE() << "no answer";
        return force_;
    }

private:
    HeldHandle handle_;
    int socket_;
    std::uint32_t sequence_ = 0;
    glm::dvec3 force_{0.0};
};

class NetworkLoop : public testing::Test {
protected:
    /// How far it moves, to and fro, in the last tenth of a second for that after the nudge.
    double growth(double stiffness, std::size_t delay_ticks) {
        const std::uint16_t port = unused_port();
        std::int64_t now = 1;
        DrivenDevice device(std::make_unique<NetworkDriver>(NetworkSettings{
                                .listen = "127.0.0.1", .port = port, .fingers = 1, .limits = {1e6, 1e6}}),
                            {.clock = [&] { return now; }, .own_thread = false});
        EXPECT_TRUE(device.open());
        FarHand hand(port, {.mass = 0.5, .damping = 5, .friction = 0, .quantum = 0, .hand_stiffness = 300});
        const double rest = -3 / stiffness;  // deep where the wall pushes back with 3 N
        hand.handle().put({0, 0, rest}, {0, 0, -0.0005});
        hand.handle().intend({0, 0, rest - 3.0 / 300});
        std::deque<glm::dvec3> under_way(delay_ticks, glm::dvec3(0, 0, 3));
        double early = 0, late = 0;
        // Its force rises first, and somebody holds the handle meanwhile.
        for (int tick = -120; tick < 400; ++tick) {
            now += 1'000'000;
            hand.tell();
            for (int tries = 0; tries < 1000 && device.facts().samples == tick + 120; ++tries) {
                if (tries > 0) usleep(1000);  // what was told comes a moment later where the machine is busy
                device.turn();
            }
            glm::dvec3 place;
            EXPECT_TRUE(device.read_positions(std::span(&place, 1)));
            EXPECT_TRUE(std::isfinite(place.z)) << "tick " << tick;
            const glm::dvec3 wall(0, 0, std::max(0.0, -place.z * stiffness));
            EXPECT_TRUE(device.write_forces(std::span(&wall, 1)));
            device.turn();  // it speaks
            under_way.push_back(hand.hear());
            if (tick >= 0) hand.handle().advance(under_way.front());
            under_way.pop_front();
            if (tick < 0) continue;
            const double away = std::abs(hand.handle().place().z - rest);
            (tick < 100 ? early : late) =
                std::max(tick < 100 || tick >= 300 ? away : 0.0, tick < 100 ? early : late);
            if (HasFatalFailure()) return 0;
        }
        device.close();
        return late / early;
    }
};

TEST_F(NetworkLoop, RestsUpToTheBoundaryOfItsDelayAndShakesBeyond) {
    for (const std::size_t delay : {0U, 1U, 2U}) {
        const double boundary =
            5 / (period_s / 2 + static_cast<double>(delay) * period_s);  // Gil et al. 2009
        EXPECT_LT(growth(0.8 * boundary, delay), 0.9) << delay << " ticks late, " << 0.8 * boundary << " N/m";
        EXPECT_GT(growth(1.2 * boundary, delay), 1.2) << delay << " ticks late, " << 1.2 * boundary << " N/m";
    }
}

}  // namespace
}  // namespace touchable::test
