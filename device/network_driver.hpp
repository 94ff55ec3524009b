#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "device/device_driver.hpp"
#include "device/network_packet.hpp"
#include "device/steady_time.hpp"
#include "device/udp_socket.hpp"

namespace touchable {

/// Where a network hand's packets are received, and the forces that may be sent to it.
struct NetworkSettings {
    std::string listen = "127.0.0.1";  ///< address in figures; any but this machine's own lets others touch
    std::uint16_t port = 5710;
    int fingers = 1;
    DeviceLimits limits{10, 3000};  ///< N, N/m: what the hand behind it bears
    std::string from{};             ///< an address in figures: whose packets alone count; empty: anybody's
};

/// Any program as a device: it sends datagrams with places, and each is answered by one with forces
/// (docs/network-hand.md). One peer at a time: the first that sends sound packets, until it says that it
/// ends, or has been silent for `peer_gone_s`. Packets that are damaged, of others, or not newer than the
/// last are left out and counted.
class NetworkDriver final : public DeviceDriver {
public:
    static constexpr double peer_gone_s = 1;
    static constexpr double between_peers_s = 1.2;  ///< longer than HandControl keeps forces on for nobody

    explicit NetworkDriver(const NetworkSettings& settings,
                           std::unique_ptr<DatagramSocket> socket = std::make_unique<UdpSocket>(),
                           DriverClock clock = steady_ns)
        : settings_(settings),
          socket_(std::move(socket)),
          clock_(std::move(clock)),
          from_(read_udp_address(settings.from)) {}
    ~NetworkDriver() override { disconnect(); }

    std::string name() const override { return "network hand"; }
    int fingers() const override { return settings_.fingers; }
    DeviceLimits limits() const override { return settings_.limits; }
    DeviceCapabilities capabilities() const override;
    Result<void> connect(const GivenUp& given_up) override;
    void disconnect() noexcept override;
    Result<void> send(std::span<const glm::dvec3> newtons) override;
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) override;
    Result<void> forget_what_came() override;
    int descriptor() const override { return socket_->descriptor(); }
    std::optional<ZeroForcePacket> zero_force_packet() const override;
    std::string prompt() const override;
    std::string why_no_position() const override;

    std::uint16_t port() const { return socket_->port(); }        ///< while connected
    std::int64_t left_out() const override { return left_out_; }  ///< packets so far

private:
    struct Peer {
        UdpAddress address;
        std::uint32_t sequence = 0;
        std::uint64_t time_ns = 0;  // its own
        std::int64_t received_ns = 0;
    };
    /// Packets that were left out for the same reason.
    struct LeftOut {
        std::string why;
        std::int64_t packets = 0;
    };
    bool take(const NetworkPacket& packet, const UdpAddress& from);
    void leave_out(const std::string& why, const UdpAddress& from);
    std::string who_may_touch() const;
    std::string why_not(const NetworkPacket& packet, const UdpAddress& from) const;
    void part();
    NetworkPacket answer(std::span<const glm::dvec3> newtons, bool last) const;

    const NetworkSettings settings_;
    const std::unique_ptr<DatagramSocket> socket_;
    const DriverClock clock_;
    const std::optional<UdpAddress> from_;
    std::optional<Peer> peer_;
    std::int64_t left_out_ = 0;
    std::int64_t parted_ns_ = 0;  // from the last peer; 0: there was none
    bool is_answer_due_ = false;
    int zeros_ = 0;        // that went out since the last answer
    std::string trouble_;  // of the newest packet that was left out, while there is no peer
    // What is told of in the end, by any thread.
    mutable std::mutex words_mutex_;
    std::string listens_at_;
    std::vector<LeftOut> left_out_why_;
    bool any_peer_ = false;  // there ever was one
};

}  // namespace touchable
