// The network that other tests stand in: what it lets through, and what it does to it.
#include "tests/stream/relay.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <numeric>
#include <string>
#include <vector>

#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

/// A socket of this machine's loopback, closed with it.
class End {
public:
    explicit End(int of) : of_(of) {}
    explicit End(int type, int port) : End(::socket(AF_INET, type, 0)) {
        const sockaddr_in address = loopback(port);
        const auto* const plain = reinterpret_cast<const sockaddr*>(&address);
        const int status =
            port == 0 ? ::bind(of_, plain, sizeof address) : ::connect(of_, plain, sizeof address);
        EXPECT_EQ(status, 0);
        if (port == 0 && type == SOCK_STREAM) {
            EXPECT_EQ(::listen(of_, 8), 0);
        }
        const timeval patience{30, 0};
        ::setsockopt(of_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    }
    ~End() { ::close(of_); }
    End(const End&) = delete;
    End& operator=(const End&) = delete;
    int get() const { return of_; }
    int port() const {
        sockaddr_in address{};
        socklen_t size = sizeof address;
        EXPECT_EQ(::getsockname(of_, reinterpret_cast<sockaddr*>(&address), &size), 0);
        return ntohs(address.sin_port);
    }

private:
    int of_;
};

std::string received(const End& from, std::size_t count) {
    std::string all;
    std::vector<char> some(1 << 16);
    while (all.size() < count) {
        const ssize_t got = ::recv(from.get(), some.data(), some.size(), 0);
        if (got <= 0) break;
        all.append(some.data(), static_cast<std::size_t>(got));
    }
    return all;
}

TEST(Relay, AConnectionKeepsEveryByteInOrder) {
    const End listener(SOCK_STREAM, 0);
    const auto relay = Relay::open(Relay::Kind::tcp, listener.port(),
                                   {.loss = 0.05, .burst = 2, .delay_ms = 2, .jitter_ms = 3});
    ASSERT_TRUE(relay) << relay.error().message;
    const End client(SOCK_STREAM, (*relay)->port());
    const End server(::accept(listener.get(), nullptr, nullptr));
    std::string sent(300'000, ' ');
    std::iota(sent.begin(), sent.end(), '\0');
    ASSERT_EQ(::send(server.get(), sent.data(), sent.size(), 0), static_cast<ssize_t>(sent.size()));
    ::shutdown(server.get(), SHUT_WR);
    EXPECT_EQ(received(client, sent.size() + 1), sent);
    EXPECT_GT((*relay)->lost(), 0);
    (*relay)->cut();
    EXPECT_EQ(received(client, 1), "");
}

TEST(Relay, DatagramsAreLostAsOftenAsItSays) {
    const End server(SOCK_DGRAM, 0);
    const auto relay = Relay::open(Relay::Kind::udp, server.port(), {.loss = 0.1, .burst = 3});
    ASSERT_TRUE(relay) << relay.error().message;
    const End client(SOCK_DGRAM, (*relay)->port());
    constexpr int count = 2000;
    int last = -1, arrived = 0;
    const auto take_one = [&] {
        int number = -1;
        ASSERT_EQ(::recv(server.get(), &number, sizeof number, 0), static_cast<ssize_t>(sizeof number));
        ASSERT_GT(number, last);
        last = number;
        ++arrived;
    };
    for (int k = 0; k < count; ++k) {
        ASSERT_EQ(::send(client.get(), &k, sizeof k, 0), static_cast<ssize_t>(sizeof k));
        while ((*relay)->passed() + (*relay)->lost() <= k) ::poll(nullptr, 0, 1);
        while (arrived < (*relay)->passed()) take_one();
    }
    EXPECT_NEAR(static_cast<double>((*relay)->lost()) / count, 0.1, 0.04);
    (*relay)->stall(true);
    const std::int64_t before = (*relay)->passed();
    const int more = count;
    ASSERT_GT(::send(client.get(), &more, sizeof more, 0), 0);
    while ((*relay)->passed() + (*relay)->lost() <= count) ::poll(nullptr, 0, 1);
    EXPECT_EQ((*relay)->passed(), before);
}

}  // namespace
}  // namespace touchable::test
