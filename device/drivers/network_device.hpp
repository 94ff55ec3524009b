// SPDX-License-Identifier: Apache-2.0
#pragma once

// A network hand (docs/devices.md): any program as a device, from its datagrams up to `--device
// network`.

#include <netinet/in.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "device/drivers/device_driver.hpp"
#include "engine/base/files.hpp"
#include "engine/base/result.hpp"

namespace touchable {

// ---- Packets

/// One datagram of a network hand (docs/devices.md): positions or forces of fingers.
struct NetworkPacket {
    enum class Kind : std::uint8_t {
        places = 1,  ///< to touchable: metres
        forces = 2   ///< from touchable: newtons
    };
    static constexpr std::uint8_t version = 1;
    static constexpr std::size_t most_fingers = 10;
    static constexpr std::size_t most_bytes = 24 + most_fingers * 24 + 4;

    Kind kind = Kind::places;
    std::uint32_t sequence = 0;  ///< places: counted up by the sender; forces: that of the places answered
    std::uint32_t buttons = 0;   ///< places: one bit each
    std::uint64_t time_ns = 0;   ///< places: the sender's own clock; forces: that of the places answered
    bool last = false;           ///< no more packets will come: forces must be zero
    bool stands_still = false;   ///< forces: zero, because this process stands still; answers nothing
    int fingers = 1;             ///< 1 to `most_fingers`
    std::array<glm::dvec3, most_fingers> vectors{};
};

/// 28 + 24 x fingers bytes, little-endian, with a CRC-32.
std::vector<std::byte> encode(const NetworkPacket& packet);
/// Error (ErrorKind::input): what is wrong with the bytes, and what would be right.
Result<NetworkPacket> decode_network_packet(std::span<const std::byte> bytes);

// ---- Sockets

/// Source or destination of a datagram.
struct UdpAddress {
    sockaddr_in6 words{};  ///< IPv4 as IPv6 maps it
    bool operator==(const UdpAddress& other) const {
        return words.sin6_port == other.words.sin6_port && is_of_host(other);
    }
    /// Whether the hosts are the same; ports may differ.
    bool is_of_host(const UdpAddress& other) const {
        return std::memcmp(&words.sin6_addr, &other.words.sin6_addr, sizeof words.sin6_addr) == 0;
    }
    /// Whether it is a loopback address, 127.x.x.x or ::1.
    bool is_own_machine() const {
        if (IN6_IS_ADDR_V4MAPPED(&words.sin6_addr)) return words.sin6_addr.s6_addr[12] == 127;
        return IN6_IS_ADDR_LOOPBACK(&words.sin6_addr);
    }
    std::string in_words() const;  ///< "127.0.0.1:51234"
};

/// Parses an address in figures ("192.0.2.7", "::1"), with port 0; nothing: it is none.
std::optional<UdpAddress> read_udp_address(const std::string& figures);

/// Carries datagrams, and never blocks.
class DatagramSocket : NonCopyable {
public:
    virtual ~DatagramSocket() = default;

    /// Binds to an address of this machine, in figures ("127.0.0.1", "::1", "0.0.0.0": any), and a port, 0: a
    /// free one; not settled. Error (ErrorKind::device): what is wrong with them.
    virtual Result<void> bind(const std::string& address, std::uint16_t port) = 0;
    virtual void close() = 0;
    virtual int descriptor() const = 0;  ///< -1 while it is closed
    virtual std::uint16_t port() const = 0;

    /// Receives a datagram and returns its size; bytes beyond `room` are lost; nothing: none waits. A settled
    /// socket receives only from its peer.
    virtual std::optional<std::size_t> receive(std::span<std::byte> room, UdpAddress& from) = 0;
    /// Sends to the peer. Without room in the network the datagram is lost, as any may be. False: there is no
    /// receiver.
    virtual bool send(std::span<const std::byte> datagram) = 0;
    /// Restricts sending and receiving to one peer. Nothing: it receives from all and cannot send.
    virtual Result<void> settle(const std::optional<UdpAddress>& peer) = 0;
};

/// UDP over IPv4 or IPv6.
class UdpSocket final : public DatagramSocket {
public:
    Result<void> bind(const std::string& address, std::uint16_t port) override;
    void close() override { descriptor_.reset(); }
    int descriptor() const override { return descriptor_.get(); }
    std::uint16_t port() const override;
    std::optional<std::size_t> receive(std::span<std::byte> room, UdpAddress& from) override;
    bool send(std::span<const std::byte> datagram) override;
    Result<void> settle(const std::optional<UdpAddress>& peer) override;

private:
    Descriptor descriptor_;
};

// ---- The driver and its keys

/// Where a network hand's packets are received, and the forces that may be sent to it.
struct NetworkSettings {
    std::string listen = "127.0.0.1";  ///< in figures; any but a loopback one lets other machines touch
    std::uint16_t port = 5710;
    int fingers = 1;
    DeviceLimits limits{10, 3000};  ///< N, N/m: what the hand behind it bears
    std::string from{};             ///< address in figures whose packets alone count; empty: all count
};

/// Any program as a device: it sends datagrams with positions, and each is answered by one with forces
/// (docs/devices.md). One peer at a time: the first that sends valid packets, until it says that it ends or
/// has been silent for `peer_gone_s`. Packets that are damaged, from others, or not newer than the last are
/// left out and counted.
class NetworkDriver final : public DeviceDriver {
public:
    static constexpr double peer_gone_s = 1;
    static constexpr double between_peers_s =
        1.2;  ///< longer than HandControl keeps forces on without a hand

    explicit NetworkDriver(const NetworkSettings& settings,
                           std::unique_ptr<DatagramSocket> socket = std::make_unique<UdpSocket>(),
                           DriverClock clock = boot_ns)
        : settings_(settings),
          socket_(std::move(socket)),
          clock_(std::move(clock)),
          from_(read_udp_address(settings.from)) {}
    ~NetworkDriver() override { disconnect(); }

    std::string name() const override { return "network hand"; }
    int fingers() const override { return settings_.fingers; }
    DeviceLimits limits() const override { return settings_.limits; }
    DeviceCapabilities capabilities() const override {
        return {.buttons = 32, .first_button = "the device's first button (bit 0 of its buttons)"};
    }
    Result<void> connect() override;
    void disconnect() noexcept override {
        if (socket_->descriptor() < 0) return;
        try {
            part();
        } catch (...) {
        }
        socket_->close();
    }
    Result<void> send(std::span<const glm::dvec3> newtons) override;
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) override;
    Result<void> forget_what_came() override;
    int descriptor() const override { return socket_->descriptor(); }
    std::optional<ZeroForcePacket> zero_force_packet() const override {
        NetworkPacket last, meanwhile;
        last.kind = meanwhile.kind = NetworkPacket::Kind::forces;
        last.fingers = meanwhile.fingers = settings_.fingers;
        last.last = meanwhile.stands_still = true;
        return ZeroForcePacket{socket_->descriptor(), encode(last), {}, encode(meanwhile)};
    }
    std::string prompt() const override {
        if (peer_) return {};
        const std::string waits = "waiting for a hand at " + listens_at_ + who_may_touch();
        return trouble_.empty() ? waits : waits + "; " + trouble_;
    }
    std::string why_no_position() const override;

    std::uint16_t port() const { return socket_->port(); }        ///< while connected
    std::int64_t left_out() const override { return left_out_; }  ///< packets so far

private:
    struct Peer {
        UdpAddress address;
        std::uint32_t sequence = 0;
        std::uint64_t time_ns = 0;  // the peer's clock
        std::int64_t received_ns = 0;
    };
    /// Packets that were left out for the same reason.
    struct LeftOut {
        std::string why;
        std::int64_t packets = 0;
    };
    bool take(const NetworkPacket& packet, const UdpAddress& from);
    void leave_out(const std::string& why, const UdpAddress& from);
    /// Whose packets move the fingers, in words; empty if only this machine's programs reach the device.
    std::string who_may_touch() const {
        if (from_) return ", from " + settings_.from + " alone";
        const auto own = read_udp_address(settings_.listen);
        if (own && own->is_own_machine()) return {};
        return ", from ANY machine that reaches it: the first sender moves the fingers and gets "
               "the forces (the device network:from=ADDRESS lets one)";
    }
    std::string why_not(const NetworkPacket& packet, const UdpAddress& from) const;
    void part();
    NetworkPacket answer(std::span<const glm::dvec3> newtons, bool last) const;

    const NetworkSettings settings_;
    const std::unique_ptr<DatagramSocket> socket_;
    const DriverClock clock_;
    const std::optional<UdpAddress> from_;
    std::optional<Peer> peer_;
    std::int64_t left_out_ = 0;
    std::int64_t parted_ns_ = 0;  // end of the last peer; 0: there was none
    bool is_answer_due_ = false;
    int zeros_ = 0;        // sent since the last answer
    std::string trouble_;  // why the newest packet was left out, while there is no peer
    // For `why_no_position`, which any thread may call.
    mutable std::mutex words_mutex_;
    std::string listens_at_;
    std::vector<LeftOut> left_out_why_;
    bool any_peer_ = false;  // whether there ever was one
};

/// Settings of "network[:key=value,...]" (docs/devices.md). Refuses (ErrorKind::usage) invalid keys.
Result<NetworkSettings> read_network_settings(std::string_view keys);
Result<std::unique_ptr<DeviceDriver>> make_network_driver(std::string_view keys);

}  // namespace touchable
