#include <gtest/gtest.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "device/drivers/network_device.hpp"
#include "tests/device/fault_sessions.hpp"

namespace touchable::test {
namespace {

UdpAddress hand_at(std::uint16_t port) {
    UdpAddress address;
    address.words.sin6_family = AF_INET6;
    address.words.sin6_port = port;
    return address;
}

/// A program that sends places a thousand times a second, over a network that does everything that networks
/// do. Now and then another program comes between, or it ends and begins anew.
class FaultyNetwork final : public FaultyDevice {
public:
    FaultyNetwork()
        : FaultyDevice("network hand", {.answers_after_ns = 200'000,
                                        .has_checksum = true,
                                        .reorders = true,
                                        .longest_force = 10.0 + 1e-9}) {
        // What UDP cannot do.
        std::erase(faults, Fault::refuses);
    }

    std::unique_ptr<DeviceDriver> driver() override {
        return std::make_unique<NetworkDriver>(NetworkSettings{}, std::make_unique<Socket>(*this),
                                               [this] { return time.now_ns(); });
    }
    void live(double angle) override {
        NetworkPacket packet;
        packet.sequence = ++sequence_;
        packet.time_ns = static_cast<std::uint64_t>(time.now_ns());
        packet.last = std::exchange(ends_, false);
        packet.vectors[0] = 0.02 * glm::dvec3(std::cos(angle), std::sin(angle), 0);
        const glm::dvec3 none(std::nan(""));
        line.tell(encode(packet), packet.last ? none : packet.vectors[0]);
        if (!std::exchange(intrudes_, false)) return;
        packet.sequence += 1000;
        packet.vectors[0] = glm::dvec3(0.1);
        intruders_ = encode(packet);
    }
    void suffer_its_own() override {
        (chance() % 2 == 0 ? ends_ : intrudes_) = true;
        if (chance() % 4 == 0) line.begin(Fault::refuses, VirtualTime::ms);
    }

private:
    class Socket final : public DatagramSocket {
    public:
        explicit Socket(FaultyNetwork& network) : network_(network), descriptor_(eventfd(1, EFD_CLOEXEC)) {}
        ~Socket() override { ::close(descriptor_); }
        Result<void> bind(const std::string&, std::uint16_t) override {
            open_ = true;
            return {};
        }
        void close() override { open_ = false; }
        int descriptor() const override { return open_ ? descriptor_ : -1; }
        std::uint16_t port() const override { return 5710; }
        std::optional<std::size_t> receive(std::span<std::byte> room, UdpAddress& from) override {
            std::optional<FaultyLine::Message> came = std::exchange(network_.intruders_, std::nullopt);
            from = hand_at(came ? 2 : 1);
            if (came && settled_) came.reset();  // the system keeps it away
            if (!came) {
                came = network_.line.next(std::chrono::microseconds(0));
                from = hand_at(1);
            }
            if (!came) return std::nullopt;
            const std::size_t bytes = std::min(room.size(), came->size());
            std::copy_n(came->begin(), bytes, room.begin());
            return bytes;
        }
        /// A network that is cut says nothing of it.
        bool send(std::span<const std::byte> datagram) override {
            const auto packet = decode_network_packet(datagram);
            EXPECT_TRUE(packet);
            if (!network_.line.passes()) return network_.line.fault() == Fault::unplugged;
            network_.line.went_out(packet ? glm::length(packet->vectors[0]) : 1e9);
            return true;
        }
        Result<void> settle(const std::optional<UdpAddress>& peer) override {
            settled_ = peer.has_value();
            return {};
        }

    private:
        FaultyNetwork& network_;
        const int descriptor_;  // readable always
        bool open_ = false, settled_ = false;
    };

    std::uint32_t sequence_ = 0xffffff00;  // comes round soon
    bool ends_ = false, intrudes_ = false;
    std::optional<FaultyLine::Message> intruders_;
};

TEST(NetworkFaults, AtRandomMoments) {
    FaultyNetwork network;
    run_fault_sessions(network);
}

TEST(NetworkFaults, ForceAfterSilence) {
    FaultyNetwork network;
    expect_force_after_silence(network);
}

}  // namespace
}  // namespace touchable::test
