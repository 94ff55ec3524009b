#include "engine/stream/listeners.hpp"
#include "engine/stream/receiving.hpp"
#include "tests/stream/labelled_stream.hpp"
#include "tests/stream/stream_peer.hpp"

namespace touchable::test {
namespace {

constexpr std::chrono::milliseconds at_once{0};

/// A server that takes its turns when the test calls for one, by a clock that the test sets.
struct Served {
    explicit Served(const char* address = "http://127.0.0.1:0/live.mkv",
                    const StreamRing::Bounds& bounds = {})
        : ring(bounds) {
        auto opened = StreamServer::open({*read_stream_url(address)}, ring, audience, [this] { return now; });
        EXPECT_TRUE(opened);
        server = std::move(*opened);
        place = server->addresses().front();
    }
    /// Takes turns until that is so; what is sent on this machine comes when the kernel has time.
    template <class Condition>
    bool go_on_until(const Condition& is_so) const {
        constexpr int most_turns = 60'000;
        for (int k = 0; k < most_turns; ++k) {
            if (is_so()) return true;
            server->turn(std::chrono::milliseconds(1));
        }
        return false;
    }
    void expect_there(int count) const {
        EXPECT_TRUE(go_on_until([&] { return audience.there() == count; }))
            << audience.there() << " instead of " << count;
    }
    void add(std::int64_t frame, std::size_t bytes = 100) {
        ring.add({frame, frame % 15 == 0,
                  std::vector<std::uint8_t>(bytes, static_cast<std::uint8_t>('a' + frame % 26))});
        server->turn(at_once);
    }
    /// So many bytes, or fewer and "closed" where it is closed before.
    std::string heard(const StreamPeer& peer, std::size_t bytes) const {
        std::string all;
        bool is_closed = false;
        EXPECT_TRUE(go_on_until([&] {
            const auto more = is_closed ? std::optional(std::string())
                                        : peer.hear(std::min<std::size_t>(bytes - all.size(), 1 << 20));
            if (more)
                all += *more;
            else
                is_closed = true;
            return is_closed || all.size() == bytes;
        })) << all.size()
            << " of " << bytes;
        return is_closed ? all + "closed" : all;
    }
    /// All until it is closed, and "closed".
    std::string all_heard(const StreamPeer& peer) const { return heard(peer, std::size_t{1} << 30U); }
    void begin() {
        const std::string header = "HEADER";
        ring.begin({reinterpret_cast<const std::uint8_t*>(header.data()), header.size()});
    }
    bool has_said(const std::string& words) const {
        return std::any_of(lines.begin(), lines.end(),
                           [&](const std::string& line) { return line.find(words) != std::string::npos; });
    }

    std::int64_t now = 100 * a_second_ns;
    std::vector<std::string> lines;
    StreamAudience audience{[this](const std::string& line) { lines.push_back(line); }};
    StreamRing ring;
    std::unique_ptr<StreamServer> server;
    std::string place;
};

const std::string wanted = "GET /live.mkv HTTP/1.1\r\nHost: here\r\n\r\n";

std::string body_of(const std::string& answer) {
    return answer.substr(std::min(answer.size(), answer.find("\r\n\r\n") + 4));
}

TEST(StreamServer, ServesTcp) {
    Served served("tcp://127.0.0.1:0");
    EXPECT_TRUE(served.place.starts_with("tcp://127.0.0.1:"));
    const StreamPeer early(served.place);
    served.expect_there(1);
    EXPECT_EQ(early.hear(), "");
    served.begin();
    for (std::int64_t n = 0; n < 20; ++n) served.add(n, 1);
    EXPECT_EQ(served.heard(early, 26), "HEADERabcdefghijklmnopqrst");
    const StreamPeer late(served.place);
    EXPECT_EQ(served.heard(late, 11), "HEADERpqrst");
    served.add(20, 1);
    served.ring.end();
    EXPECT_EQ(served.all_heard(early), "uclosed");
    EXPECT_EQ(served.all_heard(late), "uclosed");
    EXPECT_EQ(served.audience.there(), 0);
    const auto gone = served.audience.gone();
    ASSERT_EQ(gone.size(), 2U);
    EXPECT_EQ(gone[0].sent + gone[1].sent, 21 + 6);
    EXPECT_EQ(gone[0].dropped + gone[1].dropped, 0);
    EXPECT_TRUE(served.has_said("has all of it: 21 framesets sent, 0 left out"));
}

TEST(StreamServer, ServesHttp) {
    Served served;
    served.begin();
    served.add(0, 3);
    const StreamPeer peer(served.place);
    peer.say(wanted);
    const std::string answer = served.heard(peer, http_answer(200).size() + 9);
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 200 OK\r\n")) << answer;
    EXPECT_TRUE(has_words(answer, "Content-Type: video/x-matroska\r\n"));
    EXPECT_TRUE(has_words(answer, "Connection: close\r\n"));
    EXPECT_EQ(answer.find("Content-Length"), std::string::npos);
    EXPECT_EQ(body_of(answer), "HEADERaaa");
    peer.hang_up_saying();  // and listens on
    served.add(1, 2);
    EXPECT_EQ(served.heard(peer, 2), "bb");
    const StreamPeer head(served.place);
    head.say("HEAD /live.mkv HTTP/1.1\r\n\r\n");
    EXPECT_TRUE(served.all_heard(head).ends_with("\r\n\r\nclosed"));
    EXPECT_EQ(served.audience.all(), 1);
}

TEST(StreamServer, RejectsOtherRequests) {
    Served served;
    served.begin();
    const std::pair<const char*, const char*> refusals[]{{"GET /etc/passwd HTTP/1.1\r\n\r\n", " 404 "},
                                                         {"DELETE /live.mkv HTTP/1.1\r\n\r\n", " 405 "},
                                                         {"\x16\x03\x01 hello\r\n\r\n", " 400 "}};
    for (const auto& [request, status] : refusals) {
        const StreamPeer peer(served.place);
        peer.say(request);
        const std::string answer = served.all_heard(peer);
        EXPECT_TRUE(has_words(answer, status));
    }
    const StreamPeer endless(served.place);
    endless.say("GET /live.mkv HTTP/1.1\r\n" + std::string(20'000, 'x'));
    EXPECT_TRUE(has_words(served.all_heard(endless), " 400 "));
    EXPECT_EQ(served.audience.all(), 0);
}

TEST(StreamServer, ClosesSlowRequests) {
    Served served;
    const StreamPeer peer(served.place);
    const auto is_one = [&] { return served.server->connections() == 1; };
    ASSERT_TRUE(served.go_on_until(is_one));
    for (const char letter : {'G', 'E', 'T', ' '}) {
        served.now += a_second_ns;
        peer.say(std::string(1, letter));
        served.server->turn(at_once);
        ASSERT_TRUE(is_one());
    }
    served.now += a_second_ns;
    EXPECT_EQ(served.all_heard(peer), "closed");
    EXPECT_EQ(served.server->connections(), 0);
}

TEST(StreamServer, SlowListenerHarmsNoOther) {
    Served served("tcp://127.0.0.1:0", {.framesets = 20, .bytes = std::size_t{64} << 20U});
    const StreamPeer quick(served.place), slow(served.place, 4096);
    served.expect_there(2);
    served.begin();
    constexpr std::size_t bytes = 400'000;
    constexpr std::int64_t framesets = 100;
    EXPECT_EQ(served.heard(quick, 6), "HEADER");
    for (std::int64_t n = 0; n < framesets; ++n) {
        served.add(n, bytes);
        EXPECT_EQ(served.heard(quick, bytes).size(), bytes);
    }
    // Once it reads again the slow one has whole framesets: those that waited, and the newest ones.
    served.ring.end();
    const std::string heard = served.all_heard(slow);
    ASSERT_TRUE(heard.starts_with("HEADER") && heard.ends_with("closed"));
    ASSERT_EQ((heard.size() - 12) % bytes, 0U);
    const std::size_t whole = (heard.size() - 12) / bytes;
    EXPECT_LT(whole, 100U);
    for (std::size_t k = 0; k < whole; ++k) {
        const std::string frameset = heard.substr(6 + k * bytes, bytes);
        EXPECT_EQ(frameset.find_first_not_of(frameset.front()), std::string::npos);
    }
    EXPECT_EQ(heard[heard.size() - 7], static_cast<char>('a' + (framesets - 1) % 26));
    const auto gone = served.audience.gone();
    ASSERT_EQ(gone.size(), 2U);
    EXPECT_EQ(gone[0].dropped, 0);
    EXPECT_EQ(gone[1].sent, static_cast<std::int64_t>(whole));
    EXPECT_EQ(gone[1].sent + gone[1].dropped, framesets);
}

TEST(StreamServer, ClosesListenerThatTakesNothing) {
    Served served("tcp://127.0.0.1:0");
    const StreamPeer stuck(served.place, 4096), well(served.place);
    served.expect_there(2);
    served.begin();
    constexpr std::size_t bytes = 20'000'000;  // more than any kernel keeps for it
    EXPECT_EQ(served.heard(well, 6), "HEADER");
    for (std::int64_t n = 0; n < 9; ++n) {
        served.add(n, bytes);
        EXPECT_EQ(served.heard(well, bytes).size(), bytes);
        served.now += a_second_ns;
        served.server->turn(at_once);
    }
    EXPECT_EQ(served.audience.there(), 2);
    served.now += 2 * a_second_ns;
    served.expect_there(1);
    EXPECT_TRUE(served.has_said("took no whole frameset for 10 s"));
}

TEST(StreamServer, RejectsListenerBeyondLimit) {
    for (const char* const address : {"tcp://127.0.0.1:0", "http://127.0.0.1:0/live.mkv"}) {
        Served served(address);
        const bool is_http = std::string(address).starts_with("http");
        served.begin();
        std::vector<std::unique_ptr<StreamPeer>> peers;
        const auto come = [&] {
            peers.push_back(std::make_unique<StreamPeer>(served.place));
            if (is_http) peers.back()->say(wanted);
        };
        for (int there = 1; there <= StreamAudience::most_listeners; ++there) {
            come();
            served.expect_there(there);
        }
        come();
        const std::string answer = served.all_heard(*peers.back());
        EXPECT_EQ(answer.find(" 503 ") != std::string::npos, is_http);
        EXPECT_EQ(answer == "touchable serve: there are 64 listeners already; try again later\nclosed",
                  !is_http)
            << answer;
        EXPECT_TRUE(is_http || served.has_said("is refused"));
        EXPECT_EQ(served.audience.there(), 64);
        peers.front().reset();  // who goes makes room
        std::int64_t frame = 0;
        EXPECT_TRUE(served.go_on_until([&] {
            served.add(frame++, 1);
            return served.audience.there() == 63;
        }));
        come();
        served.expect_there(64);
        // Connections that ask for nothing take no place of those who listen, and are few as well.
        for (int k = 0; k < 50; ++k) {
            peers.push_back(std::make_unique<StreamPeer>(served.place));
            served.server->turn(at_once);
            EXPECT_LE(served.server->connections(), StreamServer::most_connections);
        }
        served.expect_there(64);
    }
}

TEST(StreamServer, DropsListenerThatSends) {
    Served served("tcp://127.0.0.1:0");
    const StreamPeer peer(served.place);
    served.expect_there(1);
    served.begin();
    peer.say(std::string(StreamListener::most_heard_bytes + 1, 'x'));
    served.expect_there(0);
    EXPECT_TRUE(served.has_said("nothing to send"));
}

TEST(StreamServer, ForgetsListenerThatLeft) {
    Served served("tcp://127.0.0.1:0");
    {
        const StreamPeer peer(served.place);
        served.expect_there(1);
    }
    served.expect_there(0);
    EXPECT_TRUE(served.has_said("has gone"));
}

TEST(StreamServer, RunsInItsThread) {
    StreamRing ring;
    StreamAudience audience([](const std::string&) {});
    auto server = StreamServer::open({*read_stream_url("tcp://127.0.0.1:0")}, ring, audience);
    ASSERT_TRUE(server);
    ASSERT_TRUE((*server)->start());
    const StreamPeer peer((*server)->addresses().front());
    ring.begin({});
    ring.add({0, true, {'x'}});
    while (peer.hear() != "x") std::this_thread::yield();
    server->reset();
    EXPECT_EQ(peer.hear(), std::nullopt);
    EXPECT_EQ(audience.there(), 0);
}

TEST(StreamServer, ClientSaysWhyItFailed) {
    for (const std::string address : {"tcp://127.0.0.1:0", "http://127.0.0.1:0/live.mkv"}) {
        StreamRing ring;
        StreamAudience audience([](const std::string&) {});
        auto server = StreamServer::open({*read_stream_url(address)}, ring, audience);
        ASSERT_TRUE(server);
        ASSERT_TRUE((*server)->start());
        const std::string place = (*server)->addresses().front();
        std::vector<std::unique_ptr<StreamPeer>> peers;
        while (std::ssize(peers) < StreamAudience::most_listeners) {
            peers.push_back(std::make_unique<StreamPeer>(place));
            if (place.starts_with("http")) peers.back()->say(wanted);
        }
        while (audience.has_room()) std::this_thread::yield();
        const auto refused = open_stream_clip(source_of(place));
        EXPECT_TRUE(is_refused(refused, "", ErrorKind::input));
        EXPECT_EQ(refused.error().message,
                  place + (place.starts_with("http")
                               ? ": no connection: Server returned 5XX Server Error reply; its listeners may "
                                 "be too many, try again later"
                               : ": the sender refuses: there are 64 listeners already; try again later"));
    }
}

TEST(StreamServer, RejectsUnusableAddresses) {
    StreamRing ring;
    StreamAudience audience([](const std::string&) {});
    const auto open = [&](const std::string& address) {
        return StreamServer::open({*read_stream_url(address)}, ring, audience);
    };
    EXPECT_TRUE(is_refused(open("tcp://example.org:7000"), "", ErrorKind::usage));
    const auto first = open("tcp://127.0.0.1:0");
    ASSERT_TRUE(first);
    EXPECT_TRUE(is_refused(open((*first)->addresses().front()), "in use", ErrorKind::input));
}

}  // namespace
}  // namespace touchable::test
