#include "engine/stream/stream_output.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "engine/ffmpeg/ffmpeg.hpp"
#include "tests/unused_port.hpp"

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

/// All that FFmpeg's SRT hears there until it ends. Nothing is dropped because it is late.
std::string heard_by_srt(const std::string& url, std::size_t enough = std::size_t{1} << 40U) {
    AVIOContext* io = nullptr;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "tlpktdrop", "0", 0);
    const int status = avio_open2(&io, url.c_str(), AVIO_FLAG_READ, nullptr, &options);
    av_dict_free(&options);
    if (status < 0) return ffmpeg_text(status);
    std::string all, some(1316, '\0');
    while (all.size() < enough) {
        const int got = avio_read_partial(io, reinterpret_cast<unsigned char*>(some.data()), 1316);
        if (got <= 0) break;
        all.append(some, 0, static_cast<std::size_t>(got));
    }
    avio_closep(&io);
    return all;
}

struct SentOut {
    /// Twenty framesets, a key every five: larger than a datagram, and of different sizes.
    void add_all(std::int64_t larger_by = 700) {
        const std::string header = "HEADER";
        ring.begin({reinterpret_cast<const std::uint8_t*>(header.data()), header.size()});
        all = header;
        for (std::int64_t n = 0; n < 20; ++n) {
            std::vector<std::uint8_t> bytes(static_cast<std::size_t>(larger_by * n + 1),
                                            static_cast<std::uint8_t>('a' + n));
            all.append(bytes.begin(), bytes.end());
            ring.add({n, n % 5 == 0, std::move(bytes)});
        }
    }
    void wait_for_somebody() const {
        while (audience.there() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    void wait_for_nobody() const {
        while (audience.there() > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::unique_ptr<StreamOutput> open(const std::string& url) {
        auto output = StreamOutput::create(*read_stream_url(url), ring, audience);
        EXPECT_TRUE(output.ok());
        EXPECT_TRUE((*output)->start().ok());
        return std::move(*output);
    }

    std::vector<std::string> lines;
    StreamAudience audience{[this](const std::string& line) { lines.push_back(line); }};
    StreamRing ring;
    std::string all;
};

TEST(StreamOutput, WaitsTwiceAsLongEachTime) {
    constexpr std::int64_t second = 1'000'000'000;
    EXPECT_EQ(wait_before_call_ns(1), second / 2);
    EXPECT_EQ(wait_before_call_ns(2), second);
    EXPECT_EQ(wait_before_call_ns(5), 8 * second);
    EXPECT_EQ(wait_before_call_ns(1000), 8 * second);
}

TEST(StreamOutput, OneCallerAfterTheOther) {
    SentOut sent;
    const std::string place = "srt://127.0.0.1:" + std::to_string(unused_port());
    const auto output = sent.open(place + "?latency=60");
    EXPECT_FALSE(output->calls());
    std::string first, second;
    std::thread early([&] { first = heard_by_srt(place + "?mode=caller", 6); });
    sent.wait_for_somebody();
    sent.add_all();
    early.join();
    EXPECT_EQ(first.substr(0, 6), "HEADER");
    // That it has gone is seen when it is to be given more.
    while (sent.audience.there() > 0) {
        sent.ring.add({20, true, {'X'}});
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::thread late([&] { second = heard_by_srt(place + "?mode=caller"); });
    sent.wait_for_somebody();
    sent.ring.add({21, false, {'Y'}});
    sent.ring.end();
    late.join();
    EXPECT_EQ(second, "HEADERXY") << "from the newest key on";
    sent.wait_for_nobody();
    ASSERT_EQ(sent.lines.size(), 4U);
    EXPECT_NE(sent.lines[1].find("has gone"), std::string::npos) << sent.lines[1];
    EXPECT_NE(sent.lines[3].find("has all of it: 2 framesets sent"), std::string::npos) << sent.lines[3];
}

TEST(StreamOutput, CallsUntilSomebodyAnswers) {
    SentOut sent;
    const std::string place = "srt://127.0.0.1:" + std::to_string(unused_port()), secret = "a-secret-of-two";
    const auto output = sent.open(place + "?mode=caller&passphrase=" + secret);
    EXPECT_TRUE(output->calls());
    EXPECT_EQ(output->address(), place + "?mode=caller&passphrase=...");
    std::string heard;
    std::thread listener([&] { heard = heard_by_srt(place + "?mode=listener&passphrase=" + secret); });
    sent.wait_for_somebody();
    sent.add_all();
    sent.ring.end();
    listener.join();
    EXPECT_EQ(heard, sent.all);
    sent.wait_for_nobody();
    EXPECT_EQ(sent.audience.gone().front().sent, 20);
    EXPECT_EQ(sent.audience.gone().front().dropped, 0);
    for (const std::string& line : sent.lines) EXPECT_EQ(line.find(secret), std::string::npos) << line;
}

/// Whoever listens there closes each connection at once.
TEST(StreamOutput, CallsLessOftenWhereNobodyStays) {
    using Clock = std::chrono::steady_clock;
    const std::string place = "srt://127.0.0.1:" + std::to_string(unused_port());
    std::atomic<bool> is_said{false}, stop{false};
    std::vector<std::pair<std::string, Clock::time_point>> lines;
    StreamRing ring;
    StreamAudience audience{[&](const std::string& line) {
        lines.emplace_back(line, Clock::now());
        if (line.find("goes again within a second") != std::string::npos) is_said = true;
    }};
    std::thread peer([&] {
        const AVIOInterruptCB interrupt{
            [](void* asked) { return *static_cast<std::atomic<bool>*>(asked) ? 1 : 0; }, &stop};
        while (!stop) {
            AVIOContext* io = nullptr;
            (void)avio_open2(&io, (place + "?mode=listener").c_str(), AVIO_FLAG_READ, &interrupt, nullptr);
            avio_closep(&io);
        }
    });
    const std::string header = "HEADER";
    ring.begin({reinterpret_cast<const std::uint8_t*>(header.data()), header.size()});
    auto output = std::move(*StreamOutput::create(*read_stream_url(place + "?mode=caller"), ring, audience));
    ASSERT_EQ(output->start().ok(), true);
    constexpr int most_connections = 20;
    for (std::int64_t n = 0; audience.all() < (is_said ? 2 : most_connections); ++n) {
        ring.add({n, true, {'X'}});
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    output.reset();
    stop = true;
    peer.join();
    EXPECT_TRUE(is_said);
    for (std::size_t k = 0; k + 1 < lines.size(); ++k)
        if (lines[k].first.find("goes again") != std::string::npos) {
            EXPECT_GE(lines[k + 1].second - lines[k].second, std::chrono::milliseconds(500));
        }
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

TEST(StreamOutput, EndsThoughNobodyCalled) {
    SentOut sent;
    const auto over = sent.open("srt://127.0.0.1:" + std::to_string(unused_port()));
    sent.add_all();
    sent.ring.end();
    while (!over->is_over()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    SentOut asked;
    auto output = asked.open("srt://127.0.0.1:" + std::to_string(unused_port()));
    output.reset();
    EXPECT_TRUE(asked.lines.empty());
}

}  // namespace
}  // namespace touchable::test
