#include "device/udp_socket.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace touchable {
namespace {

Error socket_error(const std::string& where) {
    return {ErrorKind::device, where + ": " + std::strerror(errno)};
}

}  // namespace

std::optional<UdpAddress> read_udp_address(const std::string& figures) {
    UdpAddress address;
    address.words.sin6_family = AF_INET6;
    for (const std::string& as_ipv6 : {figures, "::ffff:" + figures})
        if (inet_pton(AF_INET6, as_ipv6.c_str(), &address.words.sin6_addr) == 1) return address;
    return std::nullopt;
}

bool UdpAddress::operator==(const UdpAddress& other) const {
    return words.sin6_port == other.words.sin6_port && is_of_host(other);
}

bool UdpAddress::is_of_host(const UdpAddress& other) const {
    return std::memcmp(&words.sin6_addr, &other.words.sin6_addr, sizeof words.sin6_addr) == 0;
}

bool UdpAddress::is_own_machine() const {
    if (IN6_IS_ADDR_V4MAPPED(&words.sin6_addr)) return words.sin6_addr.s6_addr[12] == 127;
    return IN6_IS_ADDR_LOOPBACK(&words.sin6_addr);
}

std::string UdpAddress::in_words() const {
    char figures[INET6_ADDRSTRLEN] = "";
    inet_ntop(AF_INET6, &words.sin6_addr, figures, sizeof figures);
    const std::string text = figures, mapped = "::ffff:";
    std::string said = text.starts_with(mapped) ? text.substr(mapped.size()) : std::string("[").append(text);
    if (!text.starts_with(mapped)) said += ']';
    return said.append(":").append(std::to_string(ntohs(words.sin6_port)));
}

Result<void> UdpSocket::bind(const std::string& address, std::uint16_t port) {
    close();
    const std::string where = "UDP " + address + ":" + std::to_string(port);
    auto own = read_udp_address(address);
    if (!own)
        return Error{ErrorKind::device,
                     where + ": is no address in figures; right would be 127.0.0.1, 0.0.0.0 or ::1"};
    descriptor_ = socket(AF_INET6, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (descriptor_ < 0) return socket_error(where);
    const int off = 0;
    setsockopt(descriptor_, IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);
    own->words.sin6_port = htons(port);
    if (::bind(descriptor_, reinterpret_cast<const sockaddr*>(&own->words), sizeof own->words) == 0)
        return {};
    Error error = socket_error(where);
    if (errno == EADDRINUSE) {
        error.message += ": another program listens there; take another port";
        error.hints = {{Setting::device, "network:port=N"}};
    }
    if (errno == EADDRNOTAVAIL) error.message += ": right would be an address that this machine has";
    close();
    return error;
}

void UdpSocket::close() {
    if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
}

std::uint16_t UdpSocket::port() const {
    sockaddr_in6 own{};
    socklen_t size = sizeof own;
    getsockname(descriptor_, reinterpret_cast<sockaddr*>(&own), &size);
    return ntohs(own.sin6_port);
}

std::optional<std::size_t> UdpSocket::receive(std::span<std::byte> room, UdpAddress& from) {
    // A peer that has gone is told once, by an error in place of a datagram.
    for (int again = 0; again < 2; ++again) {
        socklen_t size = sizeof from.words;
        const auto came = recvfrom(descriptor_, room.data(), room.size(), 0,
                                   reinterpret_cast<sockaddr*>(&from.words), &size);
        if (came >= 0) return static_cast<std::size_t>(came);
        if (errno != ECONNREFUSED && errno != EINTR) break;
    }
    return std::nullopt;
}

bool UdpSocket::send(std::span<const std::byte> datagram) {
    const auto sent = ::send(descriptor_, datagram.data(), datagram.size(), MSG_NOSIGNAL);
    return sent >= 0 || errno == EAGAIN || errno == ENOBUFS;
}

Result<void> UdpSocket::settle(const std::optional<UdpAddress>& peer) {
    sockaddr nobody{};
    nobody.sa_family = AF_UNSPEC;
    const int settled =
        peer ? connect(descriptor_, reinterpret_cast<const sockaddr*>(&peer->words), sizeof peer->words)
             : connect(descriptor_, &nobody, sizeof nobody);
    if (settled == 0) return {};
    return socket_error("UDP " + (peer ? peer->in_words() : std::string("without a peer")));
}

}  // namespace touchable
