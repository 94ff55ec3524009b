#pragma once

#include <sys/socket.h>

#include <optional>
#include <string>

#include "engine/stream/stream_url.hpp"

namespace touchable {

/// A host and a port as sockets take them.
struct SocketAddress {
    sockaddr_storage storage{};
    socklen_t length = 0;

    const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
    bool is_ipv6() const { return storage.ss_family == AF_INET6; }
    /// "192.168.0.5:7000", "[::1]:7000".
    std::string text() const;
};

/// The address of this machine at which a URL asks to listen. Nothing where its host is a name: only numbers,
/// `localhost` and an empty host (all addresses) say which address is meant. Never waits.
std::optional<SocketAddress> own_address(const StreamUrl& url);

/// The address of the URL's host. Nothing where no such host is known. A name server may take its time.
std::optional<SocketAddress> look_up(const StreamUrl& url);

}  // namespace touchable
