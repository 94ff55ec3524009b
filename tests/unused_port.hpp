// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <random>

namespace touchable::test {

/// A port of this machine's loopback; 0: any that is free.
inline sockaddr_in loopback(int port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
}

/// A port of this machine that is not listened at now, of TCP and UDP; 0: none is free. It is below those that
/// Linux gives to a socket that asks for any port: one of a test beside this one would have it before it is
/// listened at.
inline std::uint16_t unused_port() {
    constexpr unsigned least = 20'000, count = 12'000;
    std::random_device random;
    for (int attempt = 0; attempt < 100; ++attempt) {
        const auto port = static_cast<std::uint16_t>(least + random() % count);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_ANY);
        address.sin_port = htons(port);
        bool is_free = true;
        for (const int kind : {SOCK_STREAM, SOCK_DGRAM}) {
            const int socket = ::socket(AF_INET, kind | SOCK_CLOEXEC, 0);
            is_free =
                is_free && ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
            ::close(socket);
        }
        if (is_free) return port;
    }
    return 0;
}

}  // namespace touchable::test
