#pragma once

#include <netinet/in.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "engine/result.hpp"

namespace touchable {

/// Where a datagram came from or goes.
struct UdpAddress {
    sockaddr_in6 words{};  ///< IPv4 as IPv6 maps it
    bool operator==(const UdpAddress& other) const;
    std::string in_words() const;  ///< "127.0.0.1:51234"
};

/// A bound UDP socket, of IPv4 or IPv6, that never blocks.
class UdpSocket {
public:
    UdpSocket() = default;
    ~UdpSocket() { close(); }
    UdpSocket(const UdpSocket&) = delete;
    UdpSocket& operator=(const UdpSocket&) = delete;

    /// Of an address of this machine, in figures ("127.0.0.1", "::1", "0.0.0.0": any), and a port, 0: a free
    /// one, until it is settled. Error (ErrorKind::device): what is wrong with them.
    Result<void> bind(const std::string& address, std::uint16_t port);
    void close();
    bool is_open() const { return descriptor_ >= 0; }
    int descriptor() const { return descriptor_; }
    std::uint16_t port() const;

    /// Bytes of the next datagram, what does not fit is lost; nothing: there is none. Of a settled socket
    /// only those of its peer.
    std::optional<std::size_t> receive(std::span<std::byte> room, UdpAddress& from) const;
    /// One that the network has no room for is lost, as any datagram may be. False where nobody is there.
    bool send(std::span<const std::byte> datagram) const;
    /// From now on it speaks with that peer alone; nothing: with anybody, and sends nothing.
    Result<void> settle(const std::optional<UdpAddress>& peer) const;

private:
    int descriptor_ = -1;
};

}  // namespace touchable
