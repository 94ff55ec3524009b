#include "engine/stream/stream_output.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>

#include "tests/stream/sent_out.hpp"

namespace touchable::test {
namespace {

/// A socket of datagrams on this machine, at any port.
class DatagramSocket {
public:
    DatagramSocket() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
        sockaddr_in at = {};
        at.sin_family = AF_INET;
        at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t length = sizeof at;
        EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&at), length), 0);
        EXPECT_EQ(::getsockname(socket_, reinterpret_cast<sockaddr*>(&at), &length), 0);
        port_ = ntohs(at.sin_port);
        const timeval longest{60, 0};
        EXPECT_EQ(::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &longest, sizeof longest), 0);
    }
    ~DatagramSocket() { ::close(socket_); }
    DatagramSocket(const DatagramSocket&) = delete;
    DatagramSocket& operator=(const DatagramSocket&) = delete;
    std::string port() const { return std::to_string(port_); }
    std::string next() const {
        std::string bytes(65536, '\0');
        const auto got = ::recv(socket_, bytes.data(), bytes.size(), 0);
        return bytes.substr(0, static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    }

private:
    int socket_, port_ = 0;
};

TEST(StreamOutput, WaitsTwiceAsLongEachTime) {
    constexpr std::int64_t second = 1'000'000'000;
    EXPECT_EQ(wait_before_call_ns(1), second / 2);
    EXPECT_EQ(wait_before_call_ns(2), second);
    EXPECT_EQ(wait_before_call_ns(5), 8 * second);
    EXPECT_EQ(wait_before_call_ns(1000), 8 * second);
}

TEST(StreamOutput, GoesByUdpInDatagrams) {
    SentOut sent;
    const DatagramSocket there;
    const auto output = sent.open("udp://127.0.0.1:" + there.port());
    sent.wait_for_somebody();
    sent.add_all(150);  // all of it in what the kernel keeps
    sent.ring.end();
    std::string heard;
    while (heard.size() < sent.all.size()) {
        const std::string datagram = there.next();
        ASSERT_LE(datagram.size(), 1316U);
        ASSERT_FALSE(datagram.empty());
        heard += datagram;
    }
    EXPECT_EQ(heard, sent.all);
    sent.wait_for_nobody();
    EXPECT_NE(sent.lines.front().find("is sent to, whoever listens"), std::string::npos);
    EXPECT_NE(sent.lines.back().find("was sent all: 20 framesets"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
