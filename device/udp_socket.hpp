#pragma once

#include <netinet/in.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "engine/base/result.hpp"

namespace touchable {

/// Where a datagram came from or goes.
struct UdpAddress {
    sockaddr_in6 words{};  ///< IPv4 as IPv6 maps it
    bool operator==(const UdpAddress& other) const;
    bool is_of_host(const UdpAddress& other) const;  ///< whatever the ports are
    bool is_own_machine() const;                     ///< 127.0.0.1 and its like, ::1
    std::string in_words() const;                    ///< "127.0.0.1:51234"
};

/// "192.0.2.7", "::1": in figures, with port 0; nothing: it is none.
std::optional<UdpAddress> read_udp_address(const std::string& figures);

/// Carries datagrams, and never blocks.
class DatagramSocket {
public:
    DatagramSocket() = default;
    DatagramSocket(const DatagramSocket&) = delete;
    DatagramSocket& operator=(const DatagramSocket&) = delete;
    virtual ~DatagramSocket() = default;

    /// Of an address of this machine, in figures ("127.0.0.1", "::1", "0.0.0.0": any), and a port, 0: a free
    /// one, until it is settled. Error (ErrorKind::device): what is wrong with them.
    virtual Result<void> bind(const std::string& address, std::uint16_t port) = 0;
    virtual void close() = 0;
    virtual int descriptor() const = 0;  ///< -1 while it is closed
    virtual std::uint16_t port() const = 0;

    /// Bytes of the next datagram, what does not fit is lost; nothing: there is none. Of a settled socket
    /// only those of its peer.
    virtual std::optional<std::size_t> receive(std::span<std::byte> room, UdpAddress& from) = 0;
    /// One that the network has no room for is lost, as any datagram may be. False where nobody is there.
    virtual bool send(std::span<const std::byte> datagram) = 0;
    /// From now on it sends to that peer and receives from it alone. Nothing: it receives from anybody, and
    /// sends nothing.
    virtual Result<void> settle(const std::optional<UdpAddress>& peer) = 0;
};

/// By UDP, of IPv4 or IPv6.
class UdpSocket final : public DatagramSocket {
public:
    ~UdpSocket() override { UdpSocket::close(); }
    Result<void> bind(const std::string& address, std::uint16_t port) override;
    void close() override;
    int descriptor() const override { return descriptor_; }
    std::uint16_t port() const override;
    std::optional<std::size_t> receive(std::span<std::byte> room, UdpAddress& from) override;
    bool send(std::span<const std::byte> datagram) override;
    Result<void> settle(const std::optional<UdpAddress>& peer) override;

private:
    int descriptor_ = -1;
};

}  // namespace touchable
