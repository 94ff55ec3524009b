// SPDX-License-Identifier: Apache-2.0
// A server's listeners, and what links to them carry: rates that are felt out, levels of HLS, colour that is
// left out.

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

#include "engine/stream/hls.hpp"
#include "engine/stream/listeners.hpp"
#include "engine/stream/receiving.hpp"
#include "tests/must.hpp"
#include "tests/stream/labelled_stream.hpp"
#include "tests/stream/peers.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

constexpr std::chrono::milliseconds at_once{0};

/// A server that takes its turns when the test calls for one, by a clock that the test sets.
struct Served {
    explicit Served(const char* address = "http://127.0.0.1:0/live.mkv",
                    const StreamRing::Bounds& bounds = {}, const StreamServer::Page& page = {})
        : ring(bounds) {
        auto opened = StreamServer::open(
            {*read_stream_url(address)}, ring, audience, [this] { return now; }, page);
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
    for (const char letter : wanted) peer.say(std::string(1, letter));
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
    head.say("HEAD /live.mkv HTTP/1.1\r\n\r\n" + wanted);
    EXPECT_TRUE(served.all_heard(head).ends_with("\r\n\r\nclosed"));
    EXPECT_EQ(served.audience.all(), 1);
}

TEST(StreamServer, AnswersAnyRequest) {
    Served served;
    served.begin();
    const std::string of_stream = "GET /live.mkv HTTP/1.1\r\nA: ";
    const std::pair<std::string, const char*> requests[]{
        {"HEAD /live.mkv?x=1 HTTP/1.0\n\n", " 200 "},
        {"HEAD /live.mkv HTTP/1.1\r\nA: " + std::string(8000, 'a') + "\r\n\r\n", " 200 "},
        {"GET / HTTP/1.1\r\n\r\n", " 404 "},
        {"GET /etc/passwd HTTP/1.1\r\n\r\n", " 404 "},
        {"GET /live.mkv/../a HTTP/1.1\r\n\r\n", " 404 "},
        {"DELETE /live.mkv HTTP/1.1\r\n\r\n", " 405 "},
        {"GET live.mkv HTTP/1.1\r\n\r\n", " 400 "},
        {"GET /live.mkv HTTP/9\r\n\r\n", " 400 "},
        {"GET /live.mkv HTTP/1.1 x\r\n\r\n", " 400 "},
        {"GET /live.mkv\r\n\r\n", " 400 "},
        {"\r\n\r\n", " 400 "},
        {std::string(10, '\0') + "\n\n", " 400 "},
        {"\x16\x03\x01 hello\r\n\r\n", " 400 "},
        {of_stream + std::string(9'000, 'a') + "\r\n\r\n", " 400 "},
        {of_stream + std::string(20'000, 'a'), " 400 "}};
    for (const auto& [request, status] : requests) {
        const StreamPeer peer(served.place);
        peer.say(request);
        EXPECT_TRUE(has_words(served.all_heard(peer), status)) << request.substr(0, 100);
    }
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
    EXPECT_EQ(served.heard(well, 6), "HEADER");
    for (std::int64_t n = 0; n < 9; ++n) {
        // The first is more than any kernel keeps for a listener. The others are small, as the kernel itself
        // closes a connection that takes nothing for ten seconds of its own clock.
        const std::size_t bytes = n == 0 ? 20'000'000 : 1;
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

// Files beside a stream: a page in browsers.

/// `clip` is looked through before `web`.
class PageServer : public ::testing::Test {
protected:
    PageServer() {
        for (const char* name : {"clip/folder.js", "web/below", "elsewhere"})
            std::filesystem::create_directories(folder / name);
        for (const char* name :
             {"clip/clip.json", "clip/depth.bin", "web/index.html", "web/page.js", "web/style.css",
              "web/engine.wasm", "web/clip.json", "web/notes.txt", "web/below/page.js", "elsewhere/page.js"})
            write_bytes(folder / name, name);
        write_bytes(folder / "clip/large.bin", std::string(large, 'x'));
    }
    /// The whole answer to a request, until the connection is closed.
    std::string answer(const std::string& line, const std::string& fields = "") const {
        const StreamPeer peer(served.place);
        peer.say(line + " HTTP/1.1\r\nHost: here\r\n" + fields + "\r\n");
        const std::string heard = served.all_heard(peer);
        EXPECT_TRUE(heard.ends_with("closed")) << heard;
        return heard.substr(0, heard.size() - std::string("closed").size());
    }
    std::string asked_part(const std::string& range, const std::string& fields = "") const {
        return answer("GET /depth.bin", "rAnge:  " + range + " \r\n" + fields);
    }

    static constexpr std::size_t large = 20'000'000;
    const TemporaryFolder folder;
    Served served{"http://127.0.0.1:0/live", {}, {folder / "clip", folder / "web"}};
};

TEST_F(PageServer, ServesWholeFiles) {
    const std::pair<const char*, std::pair<const char*, const char*>> files[]{
        {"/", {"web/index.html", "text/html; charset=utf-8"}},
        {"/index.html?clip=clip.json", {"web/index.html", "text/html; charset=utf-8"}},
        {"/page.js", {"web/page.js", "text/javascript; charset=utf-8"}},
        {"/style.css", {"web/style.css", "text/css; charset=utf-8"}},
        {"/engine.wasm", {"web/engine.wasm", "application/wasm"}},
        {"/clip.json", {"clip/clip.json", "application/json"}},
        {"/depth.bin", {"clip/depth.bin", "application/octet-stream"}}};
    for (const auto& [path, file] : files) {
        const std::string heard = answer(std::string("GET ") + path);
        EXPECT_TRUE(heard.starts_with("HTTP/1.1 200 OK\r\n")) << heard;
        EXPECT_EQ(body_of(heard), file.first);
        EXPECT_TRUE(has_words(heard, std::string("\r\nContent-Type: ") + file.second + "\r\n")) << heard;
        for (const char* field :
             {"X-Content-Type-Options: nosniff\r\n", "Cache-Control: no-cache\r\n",
              "Accept-Ranges: bytes\r\n", "script-src 'self' 'wasm-unsafe-eval'; ", "Connection: close\r\n"})
            EXPECT_TRUE(has_words(heard, field)) << field << " is not in " << heard;
    }
    EXPECT_EQ(body_of(answer("GET /large.bin")), std::string(large, 'x'));
    EXPECT_EQ(served.audience.all(), 0);
}

TEST_F(PageServer, ServesParts) {
    const std::string whole = "clip/depth.bin";
    const std::pair<const char*, std::pair<std::size_t, std::size_t>> parts[]{
        {"bytes=0-3", {0, 4}},  {"bytes=5-9", {5, 10}}, {"bytes=10-", {10, 14}},
        {"bytes=-4", {10, 14}}, {"bytes=-99", {0, 14}}, {"bytes=13-99999999999999", {13, 14}}};
    for (const auto& [range, part] : parts) {
        const auto [at, end] = part;
        const std::string heard = asked_part(range);
        EXPECT_TRUE(heard.starts_with("HTTP/1.1 206 Partial Content\r\n")) << heard;
        EXPECT_EQ(body_of(heard), whole.substr(at, end - at));
        EXPECT_TRUE(has_words(heard, "\r\nContent-Range: bytes " + std::to_string(at) + "-" +
                                         std::to_string(end - 1) + "/14\r\n"))
            << heard;
        EXPECT_TRUE(has_words(heard, "\r\nContent-Length: " + std::to_string(end - at) + "\r\n")) << heard;
    }
    // Other forms are left unread (RFC 9110, 14.2).
    for (const char* range : {"bytes=0-1,4-5", "bytes=9-5", "bytes=", "bytes=5", "bytes=-", "bytes=a-b",
                              "bytes=--3", "lines=0-3", "bytes=99999999999999999999-"}) {
        const std::string heard = asked_part(range);
        EXPECT_TRUE(heard.starts_with("HTTP/1.1 200 OK\r\n")) << range << ": " << heard;
        EXPECT_EQ(body_of(heard), whole);
    }
    for (const char* range : {"bytes=14-", "bytes=20-30", "bytes=-0"}) {
        const std::string heard = asked_part(range);
        EXPECT_TRUE(heard.starts_with("HTTP/1.1 416 Range Not Satisfiable\r\n")) << range << ": " << heard;
        EXPECT_TRUE(has_words(heard, "\r\nContent-Range: bytes */14\r\n")) << heard;
        EXPECT_EQ(body_of(heard), "");
    }
}

TEST_F(PageServer, SendsNothingKnownAgain) {
    const std::string first = answer("GET /depth.bin"), name = "\r\nETag: ";
    const std::size_t at = first.find(name) + name.size();
    const std::string tag = first.substr(at, first.find('\r', at) - at);
    const std::string known = answer("GET /depth.bin", "If-None-Match: " + tag + "\r\n");
    EXPECT_TRUE(known.starts_with("HTTP/1.1 304 Not Modified\r\n")) << known;
    EXPECT_EQ(body_of(known), "");
    EXPECT_EQ(body_of(asked_part("bytes=0-3", "If-Range: " + tag + "\r\n")), "clip");
    EXPECT_EQ(body_of(asked_part("bytes=0-3", "If-Range: \"of-another.run\"\r\n")), "clip/depth.bin");
    write_bytes(folder / "clip/depth.bin", "another clip");
    EXPECT_EQ(body_of(answer("GET /depth.bin", "If-None-Match: " + tag + "\r\n")), "another clip");
}

TEST_F(PageServer, HeadHasNoBody) {
    const std::string head = answer("HEAD /depth.bin"),
                      part = answer("HEAD /depth.bin", "Range: bytes=2-4\r\n");
    EXPECT_TRUE(has_words(head, "Content-Length: 14\r\n")) << head;
    EXPECT_TRUE(has_words(part, "Content-Length: 3\r\n")) << part;
    for (const std::string& heard : {head, part, answer("HEAD /none.js"), answer("HEAD /live")})
        EXPECT_TRUE(heard.ends_with("\r\n\r\n")) << heard;
}

TEST_F(PageServer, ServesNothingElse) {
    using namespace std::string_literals;
    const std::vector<std::string> paths{"/none.js",
                                         "/notes.txt",
                                         "/below/page.js",
                                         "/../elsewhere/page.js",
                                         "/..%2felsewhere%2fpage.js",
                                         "//page.js",
                                         "/./page.js",
                                         "/..",
                                         "/.",
                                         "/.js",
                                         "/folder.js",
                                         "/notes.txt\0.js"s,
                                         "/%70age.js",
                                         (folder / "elsewhere/page.js").string()};
    for (const std::string& path : paths) {
        const std::string heard = answer("GET " + path);
        EXPECT_TRUE(heard.starts_with("HTTP/1.1 404 Not Found\r\n")) << path << ": " << heard;
    }
    EXPECT_TRUE(answer("POST /page.js").starts_with("HTTP/1.1 405 "));
}

TEST_F(PageServer, StuckClientHarmsNoOther) {
    const StreamPeer stuck(served.place, 4096);
    stuck.say("GET /large.bin HTTP/1.1\r\n\r\n");
    EXPECT_TRUE(served.go_on_until([&] { return served.server->connections() == 1; }));
    // Two at once, each at its own pace.
    const StreamPeer one(served.place), other(served.place);
    for (const StreamPeer* peer : {&one, &other}) peer->say("GET /large.bin HTTP/1.1\r\n\r\n");
    EXPECT_EQ(served.heard(one, 1000).size(), 1000U);
    EXPECT_EQ(body_of(served.all_heard(other)), std::string(large, 'x') + "closed");
    EXPECT_TRUE(served.all_heard(one).ends_with("xxxclosed"));
    served.now += 11 * a_second_ns;
    EXPECT_TRUE(served.go_on_until([&] { return served.server->connections() == 0; }));
}

// Browsers open many connections, each for one file.
TEST_F(PageServer, ConnectionsWaitForRoom) {
    std::vector<std::unique_ptr<StreamPeer>> silent;
    for (int k = 0; k < StreamServer::most_connections; ++k) {
        silent.push_back(std::make_unique<StreamPeer>(served.place));
        served.server->turn(at_once);
    }
    const auto is_full = [&] { return served.server->connections() == StreamServer::most_connections; };
    ASSERT_TRUE(served.go_on_until(is_full));
    const StreamPeer late(served.place);
    late.say("GET /page.js HTTP/1.1\r\n\r\n");
    for (int k = 0; k < 100; ++k) served.server->turn(at_once);
    EXPECT_EQ(late.hear(), "");
    silent.pop_back();
    EXPECT_EQ(body_of(served.all_heard(late)), "web/page.jsclosed");
}

// A live source's frames.
TEST_F(PageServer, StreamIsBesideFiles) {
    served.ring.begin({});
    for (std::int64_t n = 0; n < 17; ++n) served.add(n, 3);
    const StreamPeer peer(served.place);
    peer.say("GET /live HTTP/1.1\r\n\r\n");
    const std::string head = http_answer(200, "application/octet-stream");
    EXPECT_EQ(served.heard(peer, head.size() + 6), head + "pppqqq");
    EXPECT_EQ(body_of(answer("GET /page.js")), "web/page.js");
    served.add(17, 2);
    served.ring.end();
    EXPECT_EQ(served.all_heard(peer), "rrclosed");
}

TEST(StreamServer, RunsInItsThread) {
    StreamRing ring;
    StreamAudience audience([](const std::string&) {});
    auto server = must(StreamServer::open({*read_stream_url("tcp://127.0.0.1:0")}, ring, audience));
    ASSERT_TRUE(server->start());
    const StreamPeer peer(server->addresses().front());
    ring.begin({});
    ring.add({0, true, {'x'}});
    while (peer.hear() != "x") std::this_thread::yield();
    server.reset();
    EXPECT_EQ(peer.hear(), std::nullopt);
    EXPECT_EQ(audience.there(), 0);
}

TEST(StreamServer, ClientSaysWhyItFailed) {
    for (const std::string address : {"tcp://127.0.0.1:0", "http://127.0.0.1:0/live.mkv"}) {
        StreamRing ring;
        StreamAudience audience([](const std::string&) {});
        auto server = must(StreamServer::open({*read_stream_url(address)}, ring, audience));
        ASSERT_TRUE(server->start());
        const std::string place = server->addresses().front();
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
    const auto first = must(open("tcp://127.0.0.1:0"));
    EXPECT_TRUE(is_refused(open(first->addresses().front()), "in use", ErrorKind::input));
}

constexpr std::int64_t link_ms = 1'000'000;

/// A link on which so many bytes a second arrive, looked at every 5 ms.
struct Link {
    LinkRate rate;
    LinkRate::Look now{};
    bool is_full = false;
    void go_on(std::int64_t for_ns, std::int64_t bytes_per_second, std::int64_t rtt_ns,
               std::int64_t loses_one_in = 0) {
        for (const std::int64_t end = now.now_ns + for_ns; now.now_ns < end; now.now_ns += 5 * link_ms) {
            now.arrived_bytes += bytes_per_second / 200;
            now.datagrams += 10;
            if (loses_one_in > 0 && now.datagrams % loses_one_in == 0) ++now.lost;
            now.rtt_ns = rtt_ns;
            now.is_full = is_full;
            rate.look(now);
        }
    }
    /// Until no more arrives, however much may be on its way.
    void fill(std::int64_t bytes_per_second, std::int64_t rtt_ns) {
        is_full = true;
        go_on(5 * a_second_ns, bytes_per_second, rtt_ns);
        is_full = false;
        EXPECT_FALSE(rate.is_growing());
    }
};

/// A link of so many bytes a second and so long a way, to which a sender that always has more gives what the
/// window allows.
struct FullLink {
    FullLink(std::int64_t rate_of_link, std::int64_t way) : bytes_per_second(rate_of_link), way_ns(way) {}
    std::int64_t bytes_per_second, way_ns;
    LinkRate rate;
    LinkRate::Look now{.is_full = true};
    std::int64_t handed_over = 0, served = 0, most_on_its_way = 0;
    std::deque<std::pair<std::int64_t, std::int64_t>> acknowledged;  // from when on, and how much
    std::int64_t timed = 0, timed_since_ns = 0;
    void go_on(std::int64_t for_ns) {
        for (const std::int64_t end = now.now_ns + for_ns; now.now_ns < end; now.now_ns += 5 * link_ms) {
            for (; !acknowledged.empty() && acknowledged.front().first <= now.now_ns;
                 acknowledged.pop_front())
                now.arrived_bytes = acknowledged.front().second;
            if (timed > 0 && now.arrived_bytes >= timed) {
                now.rtt_ns = now.now_ns - timed_since_ns;
                timed = 0;
            }
            rate.look(now);
            now.rtt_ns = 0;
            const std::int64_t before =
                std::exchange(handed_over, std::max(handed_over, now.arrived_bytes + rate.window_bytes()));
            if (timed == 0 && handed_over > before) {
                timed = before + 1;
                timed_since_ns = now.now_ns;
            }
            most_on_its_way = std::max(most_on_its_way, handed_over - now.arrived_bytes);
            served = std::min(handed_over, served + bytes_per_second / 200);
            acknowledged.emplace_back(now.now_ns + way_ns, served);
        }
    }
};

void expect_window(const LinkRate& rate, double bytes, double within) {
    EXPECT_NEAR(static_cast<double>(rate.window_bytes()), bytes, within);
}

TEST(LinkRate, FillsLongLink) {
    FullLink link(4'000'000, 400 * link_ms);
    link.go_on(4 * a_second_ns);
    const std::int64_t before = link.now.arrived_bytes;
    link.go_on(4 * a_second_ns);
    EXPECT_GT(link.now.arrived_bytes - before, 4 * 3'900'000);
    EXPECT_FALSE(link.rate.is_growing());
    EXPECT_LT(link.most_on_its_way, 3 * 1'600'000) << "three times what fits on the way";
    expect_window(link.rate, 4e6 * 0.5, 1e5);
}

TEST(LinkRate, SparesNarrowLink) {
    FullLink link(200'000, 20 * link_ms);
    link.go_on(8 * a_second_ns);
    EXPECT_FALSE(link.rate.is_growing());
    EXPECT_LE(link.most_on_its_way, LinkRate::first_window_bytes);
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::least_window_bytes);
}

TEST(LinkRate, BeginsWithFirstWindow) {
    Link link;
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::first_window_bytes);
    link.go_on(a_second_ns / 2, 0, 100 * link_ms);
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::first_window_bytes);
    link.go_on(a_second_ns, 0, 100 * link_ms);
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::least_window_bytes);
}

TEST(LinkRate, SizesWindowByRoundTrip) {
    Link link;
    link.go_on(a_second_ns, 4'000'000, 100 * link_ms);
    expect_window(link.rate, 4e6 * 0.28, 2e4);  // twice the way while it grows
    link.fill(4'000'000, 100 * link_ms);
    EXPECT_NEAR(static_cast<double>(link.rate.bytes_per_second()), 4e6, 1e5);
    expect_window(link.rate, 4e6 * 0.18, 2e4);
}

/// The queue in front of a full link counts in the measured round trip.
TEST(LinkRate, QueueWidensNoWindow) {
    Link link;
    link.fill(4'000'000, 20 * link_ms);
    const auto before = static_cast<double>(link.rate.window_bytes());
    link.is_full = true;
    for (std::int64_t rtt = 100 * link_ms; rtt < 2 * a_second_ns; rtt += 100 * link_ms)
        link.go_on(10 * a_second_ns, 4'000'000, rtt);
    expect_window(link.rate, before, 1e4);
}

TEST(LinkRate, FollowsLongerRoundTrip) {
    Link link;
    link.fill(4'000'000, 20 * link_ms);
    link.go_on(3 * a_second_ns, 4'000'000, 800 * link_ms);
    expect_window(link.rate, 4e6 * 1.0, 5e4);  // a quarter of the way more
}

TEST(LinkRate, LossWidensTheWindow) {
    Link link;
    link.fill(4'000'000, 100 * link_ms);
    link.go_on(3 * a_second_ns, 4'000'000, 100 * link_ms, 20);
    expect_window(link.rate, 4e6 * 0.68, 5e4);
    link.go_on(3 * a_second_ns, 4'000'000, 100 * link_ms);
    expect_window(link.rate, 4e6 * 0.18, 2e4);
}

TEST(LinkRate, FollowsNarrowingLink) {
    Link link;
    link.go_on(3 * a_second_ns, 4'000'000, 20 * link_ms);
    link.go_on(3 * a_second_ns, 1'000'000, 20 * link_ms);
    EXPECT_NEAR(static_cast<double>(link.rate.bytes_per_second()), 1e6, 1e5);
    link.go_on(3 * a_second_ns, 0, 20 * link_ms);
    EXPECT_EQ(link.rate.window_bytes(), LinkRate::least_window_bytes);
}

TEST(LinkRate, IgnoresFallingCounts) {
    LinkRate rate;
    for (int k = 0; k < 100; ++k)
        rate.look({.now_ns = k * 50 * link_ms, .arrived_bytes = 1'000'000 - k, .rtt_ns = 10 * link_ms});
    EXPECT_EQ(rate.bytes_per_second(), 0) << "no rate is below 0";
    EXPECT_EQ(rate.window_bytes(), LinkRate::least_window_bytes);
}

/// A stream of segments of a second, of 800 + 200 KB or half of that, over a link of `rate` KB/s.
struct SlowSegments {
    LevelChoice choice;
    /// Fetches `segments` of both renditions; the levels that were read: "full full low".
    std::vector<bool> read(int segments, double rate) {
        std::vector<bool> low;
        for (; segments > 0; --segments) {
            const bool is_low = choice.is_low();
            low.push_back(is_low);
            for (const bool touch : {false, true}) {
                const std::int64_t bytes = (touch ? 800'000 : 200'000) / (is_low ? 2 : 1);
                const double took_s = static_cast<double>(bytes) / (1000 * rate);
                choice.add({touch, is_low, bytes, static_cast<std::int64_t>(took_s * 1e9), a_second_ns});
            }
        }
        return low;
    }
};

using LevelsRead = std::vector<bool>;

TEST(LevelChoice, StaysFullOnGoodLink) {
    SlowSegments link;
    EXPECT_EQ(link.read(20, 1100), LevelsRead(20, false));
    EXPECT_NEAR(link.choice.need(false), 1e6, 1);
    EXPECT_NEAR(link.choice.rate(), 1.1e6, 1);
}

/// The first segment takes longer than it lasts.
TEST(LevelChoice, GoesDownAtOnce) {
    SlowSegments link;
    link.read(5, 5000);
    EXPECT_EQ(link.read(3, 900), LevelsRead({false, true, true}));
}

TEST(LevelChoice, GoesUpAtTwiceRate) {
    SlowSegments link;
    link.read(2, 600);
    EXPECT_EQ(link.read(50, 1900), LevelsRead(50, true));
    EXPECT_EQ(link.read(20, 0.5), LevelsRead(20, true));
    // The slow mean has to reach 2000 KB/s, then four segments in a row.
    const LevelsRead up = link.read(30, 4000);
    int low = 0;
    while (up[static_cast<std::size_t>(low)]) ++low;
    EXPECT_GE(low, 4 + 3);
    EXPECT_LE(low, 4 + 5);
    EXPECT_EQ(LevelsRead(up.begin() + low, up.end()),
              LevelsRead(up.size() - static_cast<std::size_t>(low), false));
}

/// A link that falters between 40 and 150 % of the rate never makes it go up and down.
TEST(LevelChoice, DoesNotFlap) {
    SlowSegments link;
    int changes = 0;
    for (int n = 0; n < 200; ++n) {
        const bool was_low = link.choice.is_low();
        link.read(1, n % 3 == 0 ? 400 : 1500);
        changes += was_low != link.choice.is_low() ? 1 : 0;
    }
    EXPECT_EQ(changes, 1);
}

TEST(LevelChoice, IgnoresMissingFiles) {
    LevelChoice choice;
    choice.add({.bytes = 0, .fetch_ns = a_second_ns / 10, .duration_ns = a_second_ns});
    choice.add({.bytes = 1000, .fetch_ns = a_second_ns, .duration_ns = 0});
    EXPECT_FALSE(choice.is_low());
    EXPECT_EQ(choice.rate(), 0);
    choice.add({.bytes = 0, .fetch_ns = 10 * a_second_ns, .duration_ns = a_second_ns});
    EXPECT_TRUE(choice.is_low());
}

TEST(LevelChoice, ColourLeftOutNeedsNothing) {
    SlowSegments link;
    link.read(3, 1100);
    link.choice.leave_out_colour();
    EXPECT_NEAR(link.choice.need(false), 8e5, 1);
    link.choice.add({true, false, 800'000, 9 * a_second_ns / 10, a_second_ns});
    EXPECT_FALSE(link.choice.is_low());
}

/// Behind from one moment to another, asked every 5 ms: how often colour is left out from then on.
int stays_behind(NarrowLink& link, std::int64_t from_ns, std::int64_t to_ns) {
    int losses = 0;
    for (std::int64_t now = from_ns; now < to_ns; now += 5 * link_ms) losses += link.is_behind(now) ? 1 : 0;
    return losses;
}

TEST(NarrowLink, DropsColourBeforeFramesets) {
    NarrowLink link;
    EXPECT_TRUE(link.gives_colour(false, 0));
    EXPECT_EQ(stays_behind(link, 0, a_second_ns), 0) << "it joins";
    link.has_caught_up();
    EXPECT_EQ(stays_behind(link, 2 * a_second_ns, 2 * a_second_ns + 150 * link_ms), 0);
    EXPECT_FALSE(link.is_far_behind(2 * a_second_ns + 150 * link_ms));
    EXPECT_EQ(stays_behind(link, 2 * a_second_ns + 150 * link_ms, 2 * a_second_ns + 300 * link_ms), 1)
        << "told once";
    EXPECT_FALSE(link.gives_colour(true, 2 * a_second_ns + 200 * link_ms));
    EXPECT_FALSE(link.is_far_behind(2 * a_second_ns + 300 * link_ms));
    EXPECT_TRUE(link.is_far_behind(2 * a_second_ns + 301 * link_ms));
    link.has_caught_up();
    EXPECT_FALSE(link.is_far_behind(4 * a_second_ns));
}

TEST(NarrowLink, KeepsColourWhileProbing) {
    NarrowLink link;
    for (std::int64_t now = 0; now < 5 * a_second_ns; now += 5 * link_ms)
        EXPECT_FALSE(link.is_behind(now, true));
    EXPECT_TRUE(link.is_far_behind(5 * a_second_ns)) << "framesets are left out all the same";
    EXPECT_TRUE(link.gives_colour(false, 5 * a_second_ns));
    EXPECT_TRUE(link.is_behind(5 * a_second_ns));
}

TEST(NarrowLink, ToleratesShortStops) {
    NarrowLink link;
    for (std::int64_t n = 0; n < 100; ++n) {
        EXPECT_EQ(stays_behind(link, n * a_second_ns, n * a_second_ns + 140 * link_ms), 0);
        link.has_caught_up();
        EXPECT_TRUE(link.gives_colour(false, n * a_second_ns + 500 * link_ms));
    }
}

/// Each time in vain: after 5 s, 10 s, 20 s.
TEST(NarrowLink, RetriesColourEverLessOften) {
    NarrowLink link;
    EXPECT_EQ(stays_behind(link, 0, a_second_ns + 200 * link_ms), 1);
    std::int64_t now = a_second_ns + 195 * link_ms;  // when it was behind last
    for (const std::int64_t trial : {5 * a_second_ns, 10 * a_second_ns, 20 * a_second_ns}) {
        link.has_caught_up();
        EXPECT_FALSE(link.gives_colour(true, now + trial - link_ms));
        EXPECT_FALSE(link.gives_colour(false, now + trial)) << "colour begins with a key";
        EXPECT_TRUE(link.gives_colour(true, now + trial));
        now += trial;
        EXPECT_EQ(stays_behind(link, now, now + 155 * link_ms), 1);
        now += 150 * link_ms;
    }
}

}  // namespace
}  // namespace touchable::test
