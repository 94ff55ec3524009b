#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "device/drivers/network_device.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {

/// The peer of `--device network:port=PORT`: one finger, packet by packet, by a socket that is made
/// by other means than the driver's.
class NetworkPeer {
public:
    explicit NetworkPeer(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(port);
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
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

}  // namespace touchable::test
