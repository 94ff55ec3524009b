// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <srt/access_control.h>
#include <srt/srt.h>

#include <array>
#include <atomic>
#include <chrono>
#include <mutex>
#include <span>
#include <thread>

#include "engine/stream/sending.hpp"
#include "engine/stream/srt.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/stream/peers.hpp"
#include "tests/stream/relay.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

/// A stream of bytes that goes out by an SrtOutput.
struct SentOut {
    static std::span<const std::uint8_t> header() {
        static constexpr std::array<std::uint8_t, 6> letters{'H', 'E', 'A', 'D', 'E', 'R'};
        return letters;
    }
    /// Twenty framesets, a key every five: larger than a datagram, and of different sizes.
    void add_all(std::int64_t larger_by = 700) {
        ring.begin(header(), padding);
        all = "HEADER";
        for (std::int64_t n = 0; n < 20; ++n) {
            std::vector<std::uint8_t> bytes(static_cast<std::size_t>(larger_by * n + 1),
                                            static_cast<std::uint8_t>('a' + n));
            all.append(bytes.begin(), bytes.end());
            ring.add({n, n % 5 == 0, std::move(bytes)});
        }
    }
    void wait_for_callers(int count = 1) const {
        while (audience.there() < count) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    void wait_until_all_left() const {
        while (audience.there() > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    bool has_said(const std::string& what) {
        const std::lock_guard lock(mutex);
        for (const std::string& line : lines)
            if (line.find(what) != std::string::npos) return true;
        return false;
    }
    std::string newest_line() {
        const std::lock_guard lock(mutex);
        return lines.empty() ? "" : lines.back();
    }
    void wait_until_said(const std::string& what) {
        while (!has_said(what)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::unique_ptr<SrtOutput> open(const std::string& url) {
        auto output = std::move(*SrtOutput::create(*read_stream_url(url), ring, audience));
        EXPECT_TRUE(output->start());
        return output;
    }

    /// On a busy machine all of it may be sent before a caller's handshake ends, and be lost: without padding
    /// behind it, the caller would never know.
    static constexpr std::array<std::uint8_t, 1> padding{'.'};
    std::mutex mutex;
    std::vector<std::string> lines;  // guarded by mutex while an output runs
    StreamAudience audience{[this](const std::string& line) {
        const std::lock_guard lock(mutex);
        lines.push_back(line);
    }};
    StreamRing ring;
    std::string all;
};

// A stream by SRT. The other end is libsrt's plain calls, or our own receiver.

using Kind = SrtPeer::Kind;
constexpr std::chrono::milliseconds a_moment{1};

std::string place_of(int port) {
    return "srt://127.0.0.1:" + std::to_string(port);
}

/// Our receiver at that place, or why it has no connection.
Result<std::shared_ptr<StreamBytes>> connected(const std::string& url) {
    const auto wait = std::make_shared<StreamWait>();
    wait->at_most(std::chrono::minutes(1));
    return wait->in_time([&] { return connect_by_srt(*read_stream_url(url), wait); });
}

struct SrtSender : ::testing::Test {
    const int port = unused_port();
    const std::string place = place_of(port);
    SentOut sent;
};

TEST_F(SrtSender, GivesAllToSeveralCallers) {
    const auto output = sent.open(place + "?latency=60");
    EXPECT_FALSE(output->calls());
    std::vector<std::string> heard(3);
    std::vector<std::thread> callers;
    for (std::string& each : heard)
        callers.emplace_back([&each, this] { each = SrtPeer(Kind::calls, port).hear_all(); });
    sent.wait_for_callers(3);
    sent.add_all();
    sent.ring.end();
    for (std::thread& caller : callers) caller.join();
    for (std::string& each : heard) {
        std::erase(each, '.');
        EXPECT_TRUE(each == sent.all) << each.size();
    }
    sent.wait_until_all_left();
    for (const StreamAudience::Listener& figures : sent.audience.gone()) {
        EXPECT_EQ(figures.sent, 20);
        EXPECT_EQ(figures.dropped, 0);
        EXPECT_EQ(figures.end, "");
        ASSERT_TRUE(figures.link);
        EXPECT_GT(figures.link->datagrams, 100);
    }
}

TEST_F(SrtSender, LateCallerBeginsAtKey) {
    const auto output = sent.open(place);
    std::thread early([&] { EXPECT_EQ(SrtPeer(Kind::calls, port).hear_all(6), "HEADER"); });
    sent.wait_for_callers();
    sent.add_all();
    early.join();
    sent.wait_until_all_left();
    sent.ring.add({20, true, {'X'}});
    std::string heard;
    std::thread late([&] { heard = SrtPeer(Kind::calls, port).hear_all(); });
    sent.wait_for_callers();
    sent.ring.add({21, false, {'Y'}});
    sent.ring.end();
    late.join();
    std::erase(heard, '.');
    EXPECT_EQ(heard, "HEADERXY");
    sent.wait_until_all_left();
    EXPECT_TRUE(sent.has_said("has gone"));
    EXPECT_TRUE(sent.has_said("has all of it: 2 framesets sent"));
}

/// A narrow caller costs another one nothing.
TEST_F(SrtSender, DropsFramesetsForNarrowCaller) {
    constexpr std::size_t frameset_bytes = 20'000;
    constexpr std::int64_t most_framesets = 3000, far_behind = 100;
    const auto relay = must(Relay::open(Relay::Kind::udp, port, {.bytes_per_second = 100'000}));
    const auto output = sent.open(place);
    std::string narrow_heard;
    std::atomic<std::size_t> narrow_heard_bytes{0}, wide_heard{0};
    std::thread narrow([&] {
        const SrtPeer caller(Kind::calls, relay->port());
        while (auto some = caller.hear()) {
            std::erase(*some, '.');
            narrow_heard_bytes = (narrow_heard += *some).size();
        }
    });
    std::thread wide([&] {
        const SrtPeer caller(Kind::calls, port);
        while (const auto some = caller.hear()) wide_heard += some->size();
    });
    sent.wait_for_callers(2);
    sent.ring.begin(sent.header(), sent.padding);
    // At the pace of the wide caller, however slow this machine is, until the narrow one is far behind: what
    // is on its way to it and what waits for it are then less than that.
    std::int64_t framesets = 0;
    const auto bytes = [&] { return static_cast<std::size_t>(framesets) * frameset_bytes; };
    while (framesets < most_framesets && bytes() < narrow_heard_bytes + far_behind * frameset_bytes) {
        const auto letter = static_cast<std::uint8_t>('a' + framesets % 26);
        sent.ring.add({framesets, framesets % 5 == 0, std::vector<std::uint8_t>(frameset_bytes, letter)});
        ++framesets;
        while (wide_heard < bytes()) std::this_thread::sleep_for(a_moment);
    }
    sent.ring.end();
    narrow.join();
    wide.join();
    sent.wait_until_all_left();
    const auto gone = sent.audience.gone();
    ASSERT_EQ(gone.size(), 2U);
    const bool is_first_narrow = gone[0].dropped > gone[1].dropped;
    const StreamAudience::Listener &few = gone[is_first_narrow ? 0 : 1], &all = gone[is_first_narrow ? 1 : 0];
    EXPECT_EQ(all.dropped, 0);
    EXPECT_EQ(all.sent, framesets);
    EXPECT_GT(few.dropped, 0);
    EXPECT_EQ(few.sent + few.dropped, framesets);
    EXPECT_EQ(few.end, "") << "what it was given has arrived";
    // Each frameset is of one letter, and none is there by half.
    std::int64_t whole = 0;
    for (std::size_t at = 6; at < narrow_heard.size(); ++whole, at += frameset_bytes)
        ASSERT_TRUE(narrow_heard.compare(at, frameset_bytes, std::string(frameset_bytes, narrow_heard[at])) ==
                    0);
    EXPECT_EQ(whole, few.sent);
}

TEST_F(SrtSender, CallsUntilAnswered) {
    const std::string secret = "a-secret-of-two";
    const auto output = sent.open(place + "?mode=caller&passphrase=" + secret);
    EXPECT_TRUE(output->calls());
    EXPECT_EQ(output->address(), place + "?mode=caller&passphrase=...");
    std::string heard;
    std::thread listener([&] { heard = SrtPeer(Kind::listens, port, secret).hear_all(); });
    sent.wait_for_callers();
    sent.add_all();
    sent.ring.end();
    listener.join();
    std::erase(heard, '.');
    EXPECT_TRUE(heard == sent.all) << heard.size() << " of " << sent.all.size();
    sent.wait_until_all_left();
    EXPECT_EQ(sent.audience.gone().front().sent, 20);
    EXPECT_EQ(sent.audience.gone().front().dropped, 0);
    for (const std::string& line : sent.lines) EXPECT_EQ(line.find(secret), std::string::npos) << line;
}

/// The listener there closes each connection at once.
TEST_F(SrtSender, CallsLessOftenWhenRefused) {
    using Clock = std::chrono::steady_clock;
    std::atomic<bool> is_said{false}, stop{false};
    std::vector<std::pair<std::string, Clock::time_point>> lines;
    StreamRing ring;
    StreamAudience audience{[&](const std::string& line) {
        lines.emplace_back(line, Clock::now());
        if (line.find("goes again within a second") != std::string::npos) is_said = true;
    }};
    std::thread peer([&] {
        auto door = std::move(*SrtSocket::create({}, SrtSocket::Direction::receives));
        std::function<bool()> always = [] { return true; };
        EXPECT_TRUE(door.listen(*own_address(*read_stream_url(place)), always));
        while (!stop)
            if (!door.accept()) std::this_thread::sleep_for(a_moment);
    });
    ring.begin(SentOut::header());
    auto output = std::move(*SrtOutput::create(*read_stream_url(place + "?mode=caller"), ring, audience));
    ASSERT_TRUE(output->start());
    constexpr int most_connections = 20;
    for (std::int64_t n = 0; audience.all() < (is_said ? 2 : most_connections); ++n) {
        ring.add({n, true, {'X'}});
        std::this_thread::sleep_for(a_moment);
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

TEST_F(SrtSender, RejectsWrongPassphrase) {
    const auto output = sent.open(place + "?passphrase=0123456789abc");
    EXPECT_TRUE(output->is_encrypted());
    EXPECT_EQ(SrtPeer(Kind::calls, port, "another-passphrase").refusal(), SRT_REJ_BADSECRET);
    EXPECT_EQ(SrtPeer(Kind::calls, port).refusal(), SRT_REJ_UNSECURE);
    EXPECT_TRUE(SrtPeer(Kind::calls, port, "0123456789abc").is_connected());
    EXPECT_TRUE(is_refused(connected(place + "?passphrase=another-passphrase"), "passphrase"));
}

TEST_F(SrtSender, RejectsCallersBeyondTheLimit) {
    const auto output = sent.open(place);
    for (int n = 0; n < StreamAudience::most_listeners; ++n) sent.audience.came("another");
    EXPECT_EQ(SrtPeer(Kind::calls, port).refusal(), SRT_REJX_OVERLOAD);
    sent.wait_until_said("1 caller is refused");
    EXPECT_TRUE(is_refused(connected(place), "as many listeners"));
}

TEST_F(SrtSender, DropsCallerThatSends) {
    const auto output = sent.open(place);
    const SrtPeer caller(Kind::calls, port);
    const std::string much(std::size_t{1} << 16U, 'x');
    while (caller.say(much)) continue;
    sent.wait_until_said("sends, but a listener has nothing to send");
}

/// The last datagrams of a stream are lost, and none behind them tells the receiver.
TEST_F(SrtSender, ResendsLastDatagrams) {
    const auto relay = must(Relay::open(Relay::Kind::udp, port));
    const auto output = sent.open(place);
    std::string heard;
    std::thread caller([&] { heard = SrtPeer(Kind::calls, relay->port()).hear_all(); });
    const SrtPeer beside(Kind::calls, port);
    sent.wait_for_callers(2);
    relay->stall(true);
    sent.add_all();
    sent.ring.end();
    (void)beside.hear_all();  // for longer than several turns of its sender
    while (relay->lost() < 40) std::this_thread::sleep_for(a_moment);
    relay->stall(false);
    caller.join();
    // Padding says nothing, and follows ever less often while nothing arrives.
    EXPECT_LE(std::erase(heard, '.'), 20U);
    EXPECT_TRUE(heard == sent.all) << heard.size() << " of " << sent.all.size();
}

/// However many datagrams come that are no SRT, a person reads little of it.
TEST_F(SrtSender, LogsLittleOfFlood) {
    const auto output = sent.open(place);
    const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const sockaddr_in at = loopback(port);
    std::string datagram(64, '\0');
    for (unsigned n = 0; n < 20'000; ++n) {
        for (std::size_t k = 0; k < datagram.size(); ++k)
            datagram[k] = static_cast<char>((n * 2654435761U) >> (k % 25));
        (void)::sendto(socket, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&at),
                       sizeof at);
    }
    ::close(socket);
    // The output is still there for callers.
    const SrtPeer caller(Kind::calls, port);
    EXPECT_TRUE(caller.is_connected());
    sent.wait_for_callers();
    const std::lock_guard lock(sent.mutex);
    EXPECT_LE(sent.lines.size(), 4U);
}

/// The log's own clock: this test's moments are later than all others.
TEST_F(SrtSender, LogsNothingWithoutCallers) {
    constexpr std::int64_t late_ns = std::int64_t{1} << 60U;
    auto door = std::move(*SrtSocket::create({}, SrtSocket::Direction::sends));
    std::function<bool()> always = [] { return true; };
    const StreamUrl url = *read_stream_url(place_of(unused_port()));
    ASSERT_TRUE(door.listen(*own_address(url), always));
    (void)srt_log_line(late_ns);
    for (int n = 0; n < 10; ++n) EXPECT_FALSE(door.accept());
    EXPECT_EQ(srt_log_line(2 * late_ns), std::nullopt);
}

/// On a busy machine the first accept comes after the first caller.
TEST_F(SrtSender, AcceptsCallerThatCameEarlier) {
    auto door = std::move(*SrtSocket::create({}, SrtSocket::Direction::sends));
    std::function<bool()> always = [] { return true; };
    ASSERT_TRUE(door.listen(*own_address(*read_stream_url(place)), always));
    const SrtPeer caller(Kind::calls, port);
    ASSERT_TRUE(caller.is_connected());
    // libsrt answers the caller a moment before it reports it.
    auto accepted = door.accept();
    for (int n = 0; n < 5000 && !accepted; ++n) {
        std::this_thread::sleep_for(a_moment);
        accepted = door.accept();
    }
    EXPECT_TRUE(accepted);
}

TEST_F(SrtSender, RetriesFirstCall) {
    const auto relay = must(Relay::open(Relay::Kind::udp, port));
    relay->stall(true);
    const auto output = sent.open(place);
    std::thread later([&] {
        while (relay->lost() < 10) std::this_thread::sleep_for(a_moment);
        relay->stall(false);
    });
    const auto bytes = connected(place_of(relay->port()));
    later.join();
    EXPECT_TRUE(bytes);
}

TEST_F(SrtSender, ConnectsThroughLoss) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SentOut stream;
        const int target = unused_port();
        const auto relay = must(Relay::open(Relay::Kind::udp, target, {.loss = 0.2, .seed = seed}));
        const auto output = stream.open(place_of(target));
        stream.add_all();
        const auto bytes = must(connected(place_of(relay->port())));
        bytes->allow(6);
        std::string header(6, '\0');
        for (std::size_t at = 0; at < header.size();) {
            const std::size_t got =
                must(bytes->read(reinterpret_cast<std::uint8_t*>(header.data()) + at, header.size() - at));
            ASSERT_GT(got, 0U) << "seed " << seed << ": " << bytes->how_it_ended() << "; "
                               << stream.newest_line() << "; passed " << relay->passed() << ", lost "
                               << relay->lost();
            at += got;
        }
        EXPECT_EQ(header, "HEADER");
    }
}

TEST_F(SrtSender, EndsWithoutCallers) {
    const auto over = sent.open(place_of(unused_port()));
    sent.add_all();
    sent.ring.end();
    while (!over->is_over()) std::this_thread::sleep_for(a_moment);
    SentOut asked;
    auto output = asked.open(place_of(unused_port()));
    output.reset();
    EXPECT_TRUE(asked.lines.empty());
}

TEST_F(SrtSender, DoublesItsBackOff) {
    constexpr std::chrono::milliseconds half_a_second{500};
    EXPECT_EQ(back_off(half_a_second, 0), half_a_second);
    EXPECT_EQ(back_off(half_a_second, 1), 2 * half_a_second);
    EXPECT_EQ(back_off(half_a_second, 4), 16 * half_a_second);
    EXPECT_EQ(back_off(half_a_second, 999), 16 * half_a_second);
}

TEST_F(SrtSender, RejectsTakenPort) {
    const auto output = sent.open(place);
    const int taken = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in at = loopback(0);
    socklen_t length = sizeof at;
    ASSERT_EQ(::bind(taken, reinterpret_cast<const sockaddr*>(&at), length), 0);
    ASSERT_EQ(::getsockname(taken, reinterpret_cast<sockaddr*>(&at), &length), 0);
    const auto refused =
        SrtOutput::create(*read_stream_url(place_of(ntohs(at.sin_port))), sent.ring, sent.audience);
    ::close(taken);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::input);
}

TEST_F(SrtSender, RejectsInvalidSettings) {
    for (const char* const query :
         {"?latency=-1", "?latency=60001", "?latency=1s", "?mode=both", "?pbkeylen=17"}) {
        const auto refused = SrtOutput::create(*read_stream_url("srt://127.0.0.1:7000" + std::string(query)),
                                               sent.ring, sent.audience);
        ASSERT_FALSE(refused) << query;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage) << query;
    }
}

}  // namespace
}  // namespace touchable::test
