#include "engine/stream/socket_address.hpp"

#include <netdb.h>

#include <cstring>
#include <memory>

namespace touchable {
namespace {

struct AddressListDeleter {
    void operator()(addrinfo* list) const { ::freeaddrinfo(list); }
};

/// The first address that the system finds.
std::optional<SocketAddress> find(const std::string& host, int port, int flags) {
    addrinfo wanted = {};
    wanted.ai_flags = AI_NUMERICSERV | flags;
    wanted.ai_socktype = SOCK_STREAM;  // otherwise each address is listed once per type
    addrinfo* found = nullptr;
    if (::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found) != 0) return std::nullopt;
    const std::unique_ptr<addrinfo, AddressListDeleter> list(found);
    SocketAddress address;
    if (found->ai_addrlen > sizeof address.storage) return std::nullopt;
    address.length = found->ai_addrlen;
    std::memcpy(&address.storage, found->ai_addr, found->ai_addrlen);
    return address;
}

}  // namespace

std::string SocketAddress::text() const {
    char host[NI_MAXHOST], port[NI_MAXSERV];
    if (::getnameinfo(get(), length, host, sizeof host, port, sizeof port, NI_NUMERICHOST | NI_NUMERICSERV) !=
        0)
        return "?";
    const std::string name(&host[0]);
    return (is_ipv6() ? "[" + name + "]" : name) + ":" + &port[0];
}

std::optional<SocketAddress> own_address(const StreamUrl& url) {
    const std::string host = url.host == "localhost" ? "127.0.0.1" : url.host.empty() ? "0.0.0.0" : url.host;
    return find(host, url.port, AI_PASSIVE | AI_NUMERICHOST);
}

std::optional<SocketAddress> look_up(const StreamUrl& url) {
    return find(url.host.empty() ? "127.0.0.1" : url.host, url.port, 0);
}

}  // namespace touchable
