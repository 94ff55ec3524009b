// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "engine/base/threads.hpp"
#include "engine/stream/hls.hpp"
#include "tests/must.hpp"
#include "tests/stream/labelled_stream.hpp"
#include "tests/stream/servers.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// A stream of `frames`, ten a second, in segments of a second.
struct WebStream {
    TemporaryFolder folder;
    Scene scene;
    std::vector<RawFrame> frames;
    std::unique_ptr<HlsWriter> writer;

    explicit WebStream(int count, std::int64_t window_s = 0, const Planes& planes = {true, true},
                       bool has_low = false) {
        scene = small_scene(32, 24, 16);
        scene.rate = {10, 1};
        writer = must(HlsWriter::open({folder / "web", a_second_ns, window_s * a_second_ns, has_low}, scene));
        add(count, planes);
        if (window_s == 0) finish();
    }
    void add(int count, const Planes& planes = {true, true}) {
        for (; count > 0; --count) {
            const auto n = static_cast<std::int64_t>(frames.size());
            frames.push_back(test_frame(scene, n, planes));
            EXPECT_EQ(message(writer->add(frames.back(), sent_label(n), scene.rate.time_ns(n), true)), "");
        }
    }
    void finish() { EXPECT_EQ(message(writer->finish()), ""); }
    WebReply reply(const std::string& path) const { return reply_with_file(folder / "web", path); }
    std::string text(const std::string& name) const { return read_bytes(folder / ("web/" + name)); }
    std::string segment(const std::string& rendition, int number) const {
        for (const auto& entry : fs::directory_iterator(folder / "web")) {
            const std::string name = entry.path().filename().string();
            if (name.starts_with(rendition) && name.ends_with("-" + std::to_string(number) + ".m4s"))
                return "/" + name;
        }
        return "";
    }
};

/// All that a receiver got.
struct HlsReceived {
    std::string error;
    Came came{};
    std::int64_t segments_lost = 0;
    std::vector<std::string> remarks{};
    std::size_t of(PlaneRole role) const {
        std::size_t count = 0;
        for (const auto& [which, often] : came) count += which.first == role ? 1 : 0;
        return count;
    }
};

HlsReceived received_from(HlsInput& input, const std::vector<RawFrame>& frames, std::size_t most = 100'000) {
    HlsReceived all;
    LabelledDecoder decoder(1 << 22);
    std::map<std::pair<bool, int>, std::size_t> tracks;
    for (std::size_t packets = 0; packets < most; ++packets) {
        auto packet = input.next();
        if (!packet) {
            all.error = packet.error().message;
            break;
        }
        if (!*packet) break;
        constexpr int of_low = 100;
        const std::pair which{(*packet)->is_touch,
                              (*packet)->stream->index + ((*packet)->is_low ? of_low : 0)};
        if (!tracks.contains(which)) {
            const auto track = decoder.add_track(*(*packet)->stream, "stream");
            if (!track) continue;  // its header is damaged
            tracks[which] = *track;
        }
        take_pictures(must(decoder.add(tracks[which], *(*packet)->packet)), frames, all.came);
    }
    all.segments_lost = input.segments_lost();
    all.remarks = input.remarks();
    return all;
}

/// A web server behind a link, by a clock of its own: files take as long as their bytes need.
struct LinkedServer {
    explicit LinkedServer(const WebStream& stream)
        : server([this, &stream](const std::string& path) {
              WebReply reply = answer ? answer(path) : stream.reply(path);
              if (path.ends_with(".m4s")) {
                  const double rate = rate_of(path);  // bytes a second
                  now_ns += static_cast<std::int64_t>(static_cast<double>(reply.body.size()) / rate * 1e9);
              }
              return reply;
          }) {}
    Result<std::unique_ptr<HlsInput>> open() {
        return HlsInput::open(server.url("/master.m3u8"), [this] { return now_ns.load(); });
    }
    std::atomic<std::int64_t> now_ns{0};
    std::function<WebReply(const std::string&)> answer{};
    std::function<double(const std::string&)> rate_of = [](const std::string&) { return 1e9; };
    WebServer server;
};

/// The number in a segment's file name.
int number_of(const std::string& path) {
    return std::stoi(path.substr(path.rfind('-') + 1));
}

/// Frames of depth that belong to segments, of ten frames each, in a level.
Came depth_of_segments(int segments, const std::function<bool(int)>& is_low) {
    Came came;
    for (int n = 0; n < 10 * segments; ++n)
        if (!is_low(n / 10) || n % 2 == 0) came[{PlaneRole::depth, n}] = 1;
    return came;
}

Came depth_in(const Came& all) {
    Came depth;
    for (const auto& [which, count] : all)
        if (which.first == PlaneRole::depth) depth[which] = count;
    return depth;
}

/// The same without an error.
HlsReceived received_whole(HlsInput& input, const std::vector<RawFrame>& frames) {
    HlsReceived all = received_from(input, frames);
    EXPECT_EQ(all.error, "");
    return all;
}

HlsReceived received_at(const std::string& place, const std::vector<RawFrame>& frames) {
    auto input = HlsInput::open(place);
    if (!input) return {.error = input.error().message};
    return received_from(**input, frames);
}

HlsReceived whole_at(const std::string& place, const std::vector<RawFrame>& frames) {
    return received_whole(*must(HlsInput::open(place)), frames);
}

TEST(HlsInput, ReceivesStreamExactly) {
    const WebStream stream(25);
    WebServer server([&](const std::string& path) { return stream.reply(path); });
    for (const std::string& place :
         {server.url("/master.m3u8"), (stream.folder / "web/master.m3u8").string()}) {
        const HlsReceived all = whole_at(place, stream.frames);
        EXPECT_EQ(all.came.size(), 75U) << place;
        for (const auto& [which, count] : all.came) EXPECT_EQ(count, 1);
        EXPECT_EQ(all.remarks.size(), 0U);
    }
    // 3 playlists (the master once), 2 headers, 6 segments
    EXPECT_EQ(server.requests().size(), 3U + 2U + 6U);
}

/// The link is narrow from segment 3 to 7: that one takes too long, and four that came well lead up again.
TEST(HlsInput, SwitchesLevels) {
    const WebStream stream(200, 0, {true, true}, true);
    LinkedServer link(stream);
    link.rate_of = [](const std::string& path) {
        const int number = number_of(path);
        return number >= 3 && number < 8 ? 1000 : 1e6;
    };
    auto input = must(link.open());
    const HlsReceived all = received_whole(*input, stream.frames);
    EXPECT_EQ(all.segments_lost, 0);
    std::vector<int> low;
    for (const std::string& path : link.server.requests())
        if (path.starts_with("/touch-low-") && path.ends_with(".m4s")) low.push_back(number_of(path));
    ASSERT_FALSE(low.empty());
    EXPECT_EQ(low.front(), 4);
    EXPECT_GE(low.back(), 7 + 4);
    EXPECT_LT(low.back(), 19);
    EXPECT_EQ(low.size(), static_cast<std::size_t>(low.back() - low.front() + 1));
    // Every frameset of each segment's level is there, once, and exact; colour has all of its frames.
    EXPECT_EQ(depth_in(all.came), depth_of_segments(20, [&](int n) { return n >= 4 && n <= low.back(); }));
    EXPECT_EQ(all.of(PlaneRole::colour), 200U);
    for (const auto& [which, count] : all.came) EXPECT_EQ(count, 1) << which.second;
    const auto levels = input->levels();
    ASSERT_TRUE(levels);
    EXPECT_EQ(levels->changes, 2);
    EXPECT_FALSE(levels->is_low);
    EXPECT_DOUBLE_EQ(levels->low_s, static_cast<double>(low.size()));
    EXPECT_DOUBLE_EQ(levels->full_s + levels->low_s, 20);
}

TEST(HlsInput, ReadsSingleLevel) {
    for (const bool has_low : {false, true}) {
        const WebStream stream(60, 0, {true, true}, has_low);
        LinkedServer link(stream);
        link.rate_of = [](const std::string&) { return 1000; };
        auto input =
            has_low ? HlsInput::open(link.server.url("/master.m3u8")) : link.open();  // which no clock has
        ASSERT_EQ(message(input), "");
        const HlsReceived all = received_from(**input, stream.frames);
        EXPECT_EQ(all.error, "");
        EXPECT_EQ(all.of(PlaneRole::depth), 60U);
        EXPECT_FALSE((*input)->levels());
    }
}

/// Its playlist is missing, or ends before the segment where it is needed.
TEST(HlsInput, StaysWithoutOtherLevel) {
    for (const bool is_short : {false, true}) {
        const WebStream stream(60, 0, {true, true}, true);
        std::string text = stream.text("touch-low.m3u8");
        text.resize(text.find("#EXTINF", text.find("-0.m4s")));
        LinkedServer link(stream);
        link.rate_of = [](const std::string&) { return 1000; };
        link.answer = [&](const std::string& path) {
            if (path != "/touch-low.m3u8") return stream.reply(path);
            return is_short ? WebReply{.body = text} : WebReply{.status = 404};
        };
        auto input = must(link.open());
        const HlsReceived all = received_whole(*input, stream.frames);
        EXPECT_EQ(depth_in(all.came), depth_of_segments(6, [](int) { return false; }));
        ASSERT_TRUE(input->levels());
        EXPECT_EQ(input->levels()->changes, 0);
    }
}

/// From the segment where it is, not from where a live stream is begun.
TEST(HlsInput, SwitchesLevelsLive) {
    WebStream stream(65, 30, {true, true}, true);
    int reloads = 0;
    LinkedServer link(stream);
    link.answer = [&](const std::string& path) {
        if (path == "/touch-low.m3u8" && ++reloads == 2) stream.finish();
        return stream.reply(path);
    };
    link.rate_of = [](const std::string&) { return 1000; };
    auto input = must(link.open());
    std::vector<RawFrame> frames = stream.frames;
    const HlsReceived all = received_whole(*input, frames);
    // The third but last one, 3, is read in full; from 4 on each second frame.
    Came right;
    for (int n = 30; n < 65; ++n)
        if (n < 40 || n % 2 == 0) right[{PlaneRole::depth, n}] = 1;
    EXPECT_EQ(depth_in(all.came), right);
}

TEST(HlsInput, ReadsMediaPlaylistAlone) {
    const WebStream stream(12);
    WebServer server([&](const std::string& path) { return stream.reply(path); });
    const HlsReceived all = whole_at(server.url("/touch.m3u8"), stream.frames);
    EXPECT_EQ(all.of(PlaneRole::depth), 12U);
    EXPECT_EQ(all.of(PlaneRole::colour), 0U);
}

TEST(HlsInput, FollowsLiveStreamToEnd) {
    WebStream stream(45, 8);
    int reloads = 0;
    WebServer server([&](const std::string& path) {
        if (path == "/touch.m3u8" && ++reloads == 2) stream.add(20);
        if (path == "/touch.m3u8" && reloads == 3) stream.finish();
        return stream.reply(path);
    });
    auto input = must(HlsInput::open(server.url("/master.m3u8")));
    EXPECT_TRUE(input->is_live());
    std::vector<RawFrame> frames;
    for (int n = 0; n < 65; ++n) frames.push_back(test_frame(stream.scene, n, {true, true}));
    const HlsReceived all = received_whole(*input, frames);
    EXPECT_EQ(all.came.begin()->first.second, 10) << "three segments before the newest";
    EXPECT_EQ(all.of(PlaneRole::depth), 55U);
    EXPECT_EQ(all.of(PlaneRole::colour), 55U);
    EXPECT_EQ(all.segments_lost, 0);
    for (const std::string& header : server.requests())
        EXPECT_TRUE(!header.ends_with("init.mp4") || std::ranges::count(server.requests(), header) == 1);
}

TEST(HlsInput, SkipsMissingAndCutSegments) {
    const WebStream stream(40);
    const std::string missing = stream.segment("touch", 1), cut = stream.segment("colour", 1),
                      torn = stream.segment("touch", 2);
    WebServer server([&](const std::string& path) {
        WebReply reply = stream.reply(path);
        if (path == missing) return WebReply{404};
        if (path == cut) reply.sent = reply.body.size() / 2;
        if (path == torn) reply.body.resize(reply.body.size() - 100);  // and the server knows no better
        return reply;
    });
    const HlsReceived all = whole_at(server.url("/master.m3u8"), stream.frames);
    EXPECT_EQ(all.segments_lost, 3);
    EXPECT_EQ(all.of(PlaneRole::depth), 20U);
    EXPECT_EQ(all.of(PlaneRole::colour), 30U);
    EXPECT_TRUE(all.came.contains({PlaneRole::depth, 39}));
}

TEST(HlsInput, SkipsMissingColour) {
    const WebStream stream(12);
    WebServer server(
        [&](const std::string& path) { return path == "/colour.m3u8" ? WebReply{500} : stream.reply(path); });
    const HlsReceived all = whole_at(server.url("/master.m3u8"), stream.frames);
    EXPECT_EQ(all.of(PlaneRole::depth), 12U);
    EXPECT_EQ(all.remarks.size(), 1U);
}

/// A cache may have an older playlist; one that stays older is of a sender that began anew.
TEST(HlsInput, ToleratesOlderPlaylistBriefly) {
    WebStream stream(45, 8);
    std::vector<std::string> texts{stream.text("touch.m3u8")};
    stream.add(10);
    texts.push_back(stream.text("touch.m3u8"));
    for (const bool stays_older : {false, true}) {
        int reloads = 0;
        WebServer server([&](const std::string& path) {
            WebReply reply = stream.reply(path);
            if (path != "/touch.m3u8") return reply;
            ++reloads;
            reply.body = texts[1];
            if (reloads >= 2 && reloads < (stays_older ? 1000 : 4)) reply.body = texts[0];
            if (reloads >= 4 && !stays_older) reply.body += "#EXT-X-ENDLIST\n";
            return reply;
        });
        const HlsReceived all = received_at(server.url("/touch.m3u8"), stream.frames);
        EXPECT_EQ(all.error.find("began anew") != std::string::npos, stays_older) << all.error;
        EXPECT_EQ(all.of(PlaneRole::depth), 30U);
    }
}

TEST(HlsInput, WaitsForReturningServer) {
    WebStream stream(45, 8);
    int reloads = 0;
    WebServer server([&](const std::string& path) {
        if (path == "/touch.m3u8" && ++reloads > 1 && reloads < 5) return WebReply{503};
        if (path == "/touch.m3u8" && reloads == 5) stream.finish();
        return stream.reply(path);
    });
    const HlsReceived all = whole_at(server.url("/touch.m3u8"), stream.frames);
    EXPECT_TRUE(all.came.contains({PlaneRole::depth, 44}));
}

TEST(HlsInput, EndsWhenStreamRestarts) {
    WebStream stream(45, 8);
    int reloads = 0;
    WebServer server([&](const std::string& path) {
        WebReply reply = stream.reply(path);
        if (path == "/touch.m3u8" && ++reloads > 1) {
            const std::size_t at = reply.body.find("-init.mp4");
            reply.body.replace(at - 1, 1, reply.body[at - 1] == '0' ? "1" : "0");
        }
        return reply;
    });
    EXPECT_TRUE(has_words(received_at(server.url("/touch.m3u8"), stream.frames).error, "began anew"));
}

TEST(HlsInput, FetchesFromItsServerOnly) {
    const WebStream stream(12);
    int asked = 0;
    WebServer other([&](const std::string& path) {
        ++asked;
        return stream.reply(path);
    });
    const auto error_with = [&](const std::string& path, const WebReply& reply) {
        WebServer server([&](const std::string& of) { return of == path ? reply : stream.reply(of); });
        return received_at(server.url("/master.m3u8"), stream.frames).error;
    };
    const std::string head = "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\n";
    EXPECT_NE(error_with("/master.m3u8", {302, "", "Location: " + other.url("/master.m3u8") + "\r\n"}), "");
    EXPECT_NE(error_with("/master.m3u8", {302, "", "Location: file:///etc/passwd\r\n"}), "");
    EXPECT_NE(error_with("/touch.m3u8", {301, "", "Location: " + other.url("/touch.m3u8") + "\r\n"}), "");
    EXPECT_NE(error_with("/touch.m3u8", {200, head + other.url("/a.m4s") + "\n"}), "");
    EXPECT_NE(error_with("/touch.m3u8", {200, head + "file:///etc/passwd\n#EXT-X-ENDLIST\n"}), "");
    EXPECT_NE(error_with("/touch.m3u8", {200, "#EXTM3U\n#EXT-X-STREAM-INF:BANDWIDTH=1\ntouch.m3u8\n"}), "");
    EXPECT_NE(error_with("/touch.m3u8", {200, head + "touch.m3u8\n#EXT-X-ENDLIST\n"}), "");
    EXPECT_NE(error_with("/master.m3u8", {200, "#EXTM3U\n#EXT-X-STREAM-INF:BANDWIDTH=1\nmaster.m3u8\n"}), "");
    EXPECT_NE(error_with("/master.m3u8", {200, "#EXTM3U\n" + std::string(2 << 20, '#')}), "");
    EXPECT_EQ(asked, 0);
}

TEST(HlsInput, StopsWaitingOnRequest) {
    const WebStream stream(12);
    for (const char* const silent : {"/master.m3u8", "/touch.m3u8", "segment"}) {
        std::stop_source told;
        const std::string path = std::string(silent) == "segment" ? stream.segment("touch", 0) : silent;
        WebServer server([&](const std::string& of) {
            if (of != path) return stream.reply(of);
            told.request_stop();
            return WebReply{.is_silent = true};
        });
        const auto begin = Clock::now();
        const StopScope until(told.get_token());
        const HlsReceived all = received_at(server.url("/master.m3u8"), stream.frames);
        EXPECT_NE(all.error, "") << silent;
        EXPECT_LT(Clock::now() - begin, std::chrono::seconds(8)) << silent;  // 10 without the request
    }
}

/// On which FFmpeg counts for a minute.
TEST(HlsInput, RejectsTracksWithoutNumber) {
    const WebStream stream(12);
    WebServer server([&](const std::string& path) {
        WebReply reply = stream.reply(path);
        if (path.ends_with("init.mp4")) reply.body.replace(reply.body.find("tkhd"), 4, "free");
        return reply;
    });
    const auto begin = Clock::now();
    EXPECT_NE(received_at(server.url("/master.m3u8"), stream.frames).error, "");
    EXPECT_LT(Clock::now() - begin, std::chrono::seconds(5));
}

/// Bytes of segments changed at random: what comes is what was sent.
TEST(HlsInput, DamageNeverChangesSamples) {
    const WebStream stream(30);
    std::size_t lost = 0;
    for (std::uint64_t seed = 0; seed < 70; seed += sweep_step()) {
        Random numbers(seed);
        WebServer server([&](const std::string& path) {
            WebReply reply = stream.reply(path);
            if (path.ends_with("m3u8") || numbers.below(2) == 0) return reply;
            for (int flips = 1 + numbers.below(3); flips > 0; --flips) {
                auto& byte =
                    reply.body[static_cast<std::size_t>(numbers.below(static_cast<int>(reply.body.size())))];
                byte = static_cast<char>(byte ^ (1 << numbers.below(8)));
            }
            return reply;
        });
        const HlsReceived all = received_at(server.url("/master.m3u8"), stream.frames);
        lost += 90 - std::min<std::size_t>(90, all.came.size());
    }
    EXPECT_GT(lost, 0U);
}

}  // namespace
}  // namespace touchable::test

namespace touchable {
namespace {

using test::is_refused;
using test::must;

const std::string web = "http://host:8080/live/clip/master.m3u8?token=1";
const std::string home = "file:/srv/a b/master.m3u8";

std::string resolved(const std::string& base, const std::string& named) {
    const auto place = resolved_place(base, named);
    return place ? *place : "refused";
}

TEST(HlsPlaylist, ResolvesPlacesBesideIt) {
    EXPECT_EQ(resolved(web, "touch.m3u8"), "http://host:8080/live/clip/touch.m3u8");
    EXPECT_EQ(resolved(web, "a/b.m4s?x=1"), "http://host:8080/live/clip/a/b.m4s?x=1");
    EXPECT_EQ(resolved(web, "/b.m4s"), "http://host:8080/b.m4s");
    EXPECT_EQ(resolved(web, "../b.m4s"), "http://host:8080/live/b.m4s");
    EXPECT_EQ(resolved(web, "../../../../b.m4s"), "http://host:8080/b.m4s");
    EXPECT_EQ(resolved(web, "/.."), "http://host:8080/");
    EXPECT_EQ(resolved(web, ".."), "http://host:8080/live/");
    EXPECT_EQ(resolved(web, "a/./.?x=1"), "http://host:8080/live/clip/a/?x=1");
    EXPECT_EQ(resolved(web, "?x=2"), "http://host:8080/live/clip/master.m3u8?x=2");
    EXPECT_EQ(resolved(web, "HTTP://Host:8080/b"), "http://host:8080/b");
    EXPECT_EQ(resolved(web, "//host:8080/b"), "http://host:8080/b");
    EXPECT_EQ(resolved("http://host", "b"), "http://host/b");
    EXPECT_EQ(resolved(home, "touch.m3u8"), "file:/srv/a b/touch.m3u8");
    EXPECT_EQ(resolved(home, "sub/x 1.m4s"), "file:/srv/a b/sub/x 1.m4s");
}

TEST(HlsPlaylist, RejectsPlacesElsewhere) {
    for (const char* const named :
         {"http://other/b", "http://host:8081/b", "https://host:8080/b", "file:/etc/passwd",
          "file:///etc/passwd", "data:text/plain,x", "concat:a|b", "//other/b", "tcp://host:8080", "a b",
          "a\tb", "a\\b", "", "http://host:8080@other/b", "crypto:b", "pipe:0"})
        EXPECT_EQ(resolved(web, named), "refused") << named;
    for (const char* const named :
         {"../x", "a/../../x", "/etc/passwd", "http://host/b", "file:/srv/a b/x", ".."})
        EXPECT_EQ(resolved(home, named), "refused") << named;
    EXPECT_EQ(resolved(web, "https://other/b"), "refused");
    EXPECT_EQ(resolved(web, "file:/etc/passwd"), "refused");
    EXPECT_EQ(resolved(home, "http://other/b"), "refused");
}

TEST(HlsPlaylist, MasterLeadsToLowLevel) {
    const HlsShown full{"colour.m3u8", 2000, "avc1.64001f", 640, 480, 30},
        low{"low.m3u8", 1000, "", 640, 480, 30};
    const auto places = must(places_in_playlist(master_text(full, low), web));
    EXPECT_EQ(places.colour, "http://host:8080/live/clip/colour.m3u8");
    EXPECT_EQ(places.low_touch, "http://host:8080/live/clip/touch-low.m3u8");
    EXPECT_EQ(places.low_colour, "http://host:8080/live/clip/low.m3u8");
    // A second variant alone is no low level.
    const auto others = must(
        places_in_playlist(master_text(full) + "#EXT-X-STREAM-INF:BANDWIDTH=1\nhttp://other/c.m3u8\n", web));
    EXPECT_EQ(others.low_touch + others.low_colour, "");
    // Without colour its variants are the planes.
    const HlsShown grey{"touch.m3u8", 2000, "", 640, 480, 30},
        low_grey{"touch-low.m3u8", 1000, "", 640, 480, 15};
    const auto planes = must(places_in_playlist(master_text(grey, low_grey), web));
    EXPECT_EQ(planes.low_touch, "http://host:8080/live/clip/touch-low.m3u8");
    EXPECT_EQ(planes.colour + planes.low_colour, "");
}

TEST(HlsPlaylist, ColourNamesMaster) {
    for (const std::string name : {"colour.m3u8", "colour-low.m3u8?token=1"}) {
        const auto refused = places_in_playlist(text_of(HlsMedia()), "http://host/live/" + name);
        ASSERT_FALSE(refused);
        EXPECT_TRUE(test::has_words(refused.error().message, "open master.m3u8 beside it"));
    }
}

std::string numbered_playlist() {
    return "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXT-X-MEDIA-SEQUENCE:7\n#EXT-X-MAP:URI=\"i.mp4\"\n"
           "#EXTINF:1.000000,\na.m4s\n#EXT-X-DISCONTINUITY\n#EXTINF:0.5,\nb.m4s\n#EXTINF:x,\na.m4s\n"
           "#EXT-X-ENDLIST\n";
}

TEST(HlsPlaylist, FindsSegments) {
    const std::string text = numbered_playlist(), a = "http://host:8080/live/clip/a.m4s";
    const auto first = segment_in(text, web, a, 0);
    ASSERT_TRUE(first);
    EXPECT_EQ(first->number, 7);
    EXPECT_EQ(first->duration_ns, 1'000'000'000);
    const auto again = segment_in(text, web, a, 8);
    ASSERT_TRUE(again);
    EXPECT_EQ(again->number, 9);
    EXPECT_EQ(again->duration_ns, 0);
    EXPECT_FALSE(segment_in(text, web, a, 10));
    EXPECT_FALSE(segment_in(text, web, "http://host:8080/live/clip/c.m4s", 0));
}

TEST(HlsPlaylist, BeginsAtSegment) {
    EXPECT_EQ(playlist_from(numbered_playlist(), 8),
              "#EXTM3U\n#EXT-X-MEDIA-SEQUENCE:8\n#EXT-X-TARGETDURATION:1\n#EXT-X-MAP:URI=\"i.mp4\"\n"
              "#EXT-X-DISCONTINUITY\n#EXTINF:0.5,\nb.m4s\n#EXTINF:x,\na.m4s\n#EXT-X-ENDLIST\n");
    EXPECT_FALSE(playlist_from(numbered_playlist(), 10));
}

TEST(HlsPlaylist, RejectsHostileMasters) {
    const std::string head = "#EXTM3U\n#EXT-X-SESSION-DATA:DATA-ID=\"com.touchable.planes\",VALUE=\"";
    const std::string colour = "\"\n#EXT-X-STREAM-INF:BANDWIDTH=1\n",
                      low = "t.m3u8\"\n#EXT-X-SESSION-DATA:DATA-ID=\"com.touchable.planes.low\",VALUE=\"";
    for (const std::string& text :
         {std::string(), std::string("#EXTM3U8\n"), std::string("<html>"),
          std::string("#EXTM3U\n#EXT-X-STREAM-INF:BANDWIDTH=1\nvideo.m3u8\n"),
          head + "master.m3u8?token=1" + colour + "c.m3u8\n",
          head + "t.m3u8" + colour + "/live/clip/./master.m3u8?token=1\n",
          head + "http://other/t.m3u8" + colour + "c.m3u8\n", head + "file:/etc/passwd" + colour + "c.m3u8\n",
          head + "t.m3u8" + colour + "ftp://host/c\n",
          head + low + "http://other/l.m3u8" + colour + "c.m3u8\n",
          head + low + "master.m3u8?token=1" + colour + "c.m3u8\n",
          head + low + "l.m3u8" + colour + "c.m3u8\n#EXT-X-STREAM-INF:BANDWIDTH=1\nfile:/etc/passwd\n",
          head + "t.m3u8" + colour + "c.m3u8\n" + std::string(largest_hls_playlist, '\n'),
          head + "t.m3u8" + colour + "c.m3u8\n" + std::string(1, '\0')}) {
        EXPECT_TRUE(is_refused(places_in_playlist(text, web), "", ErrorKind::input)) << text.substr(0, 200);
    }
}

TEST(HlsPlaylist, RejectsHostileMediaPlaylists) {
    const std::string head = "#EXTM3U\n#EXT-X-TARGETDURATION:1\n", end = "#EXTINF:1,\na.m4s\n";
    ASSERT_TRUE(check_hls_media(head + end, web));
    for (const std::string& line :
         {std::string("#EXT-X-STREAM-INF:BANDWIDTH=1\nb.m3u8\n"),
          std::string("#EXTINF:1,\nmaster.m3u8?token=1\n"),
          std::string("#EXT-X-KEY:METHOD=AES-128,URI=\"key\"\n"), std::string("#EXT-X-KEY:URI=\"key\"\n"),
          std::string("#EXT-X-MAP:URI=\"file:/etc/passwd\"\n"), std::string("#EXT-X-MAP:BYTERANGE=\"1@1\"\n"),
          std::string("#EXT-X-MAP:URI=\"a\"\n#EXT-X-MAP:URI=\"b\"\n"),
          std::string("#EXTINF:1,\nhttp://169.254.169.254/latest\n"),
          std::string("#EXT-X-MEDIA-SEQUENCE:-1\n"), std::string("#EXT-X-MEDIA:TYPE=AUDIO,URI=\"x\"\n")})
        EXPECT_FALSE(check_hls_media(head + line + end, web)) << line;
    EXPECT_FALSE(check_hls_media(head, web)) << "no segment";
}

TEST(HlsText, WritesLiveWindow) {
    HlsMedia media;
    media.target_s = 1;
    media.first = 7;
    media.header = "touch-init.mp4";
    media.segments = {{"touch-7.m4s", 1'000'000'000, 1'700'000'000'250'000'000},
                      {"touch-8.m4s", 966'666'667, 0, true}};
    const std::string head =
        "#EXTM3U\n#EXT-X-VERSION:7\n## written by touchable\n#EXT-X-INDEPENDENT-SEGMENTS\n"
        "#EXT-X-TARGETDURATION:1\n#EXT-X-MEDIA-SEQUENCE:7\n";
    const std::string rest =
        "#EXT-X-MAP:URI=\"touch-init.mp4\"\n"
        "#EXT-X-PROGRAM-DATE-TIME:2023-11-14T22:13:20.250Z\n#EXTINF:1.000000,\ntouch-7.m4s\n"
        "#EXT-X-DISCONTINUITY\n#EXTINF:0.966667,\ntouch-8.m4s\n";
    EXPECT_EQ(text_of(media), head + rest);
    EXPECT_EQ(next_segment_of(text_of(media)), 9);
    media.is_whole = media.has_ended = true;
    EXPECT_EQ(text_of(media), head + "#EXT-X-PLAYLIST-TYPE:VOD\n" + rest + "#EXT-X-ENDLIST\n");
}

TEST(HlsText, CountsFromZeroWithoutPlaylist) {
    EXPECT_EQ(next_segment_of(""), 0);
    EXPECT_EQ(next_segment_of("#EXTM3U\n#EXT-X-MEDIA-SEQUENCE:-5\n"), 0);
    EXPECT_EQ(next_segment_of("#EXTM3U\n#EXT-X-MEDIA-SEQUENCE:99999999999999999999\n"), 0);
}

TEST(HlsText, MasterNamesBothLevels) {
    const HlsShown full{"colour.m3u8", 2'500'000, "avc1.64001f,mp4a.40.2", 640, 480, 30000.0 / 1001},
        low{"colour-low.m3u8", 1'250'000, "avc1.64001e", 640, 480, 30};
    EXPECT_EQ(master_text(full, low),
              "#EXTM3U\n#EXT-X-VERSION:7\n## written by touchable\n#EXT-X-INDEPENDENT-SEGMENTS\n"
              "#EXT-X-SESSION-DATA:DATA-ID=\"com.touchable.planes\",VALUE=\"touch.m3u8\"\n"
              "#EXT-X-SESSION-DATA:DATA-ID=\"com.touchable.planes.low\",VALUE=\"touch-low.m3u8\"\n"
              "#EXT-X-STREAM-INF:BANDWIDTH=2500000,CODECS=\"avc1.64001f,mp4a.40.2\",RESOLUTION=640x480,"
              "FRAME-RATE=29.970\ncolour.m3u8\n"
              "#EXT-X-STREAM-INF:BANDWIDTH=1250000,CODECS=\"avc1.64001e\",RESOLUTION=640x480,"
              "FRAME-RATE=30.000\ncolour-low.m3u8\n");
}

TEST(HlsText, NamesCodecs) {
    constexpr std::array<std::uint8_t, 12> header{0, 0, 0, 1, 0x67, 0x64, 0x00, 0x1f, 0xac, 0, 0, 1};
    EXPECT_EQ(avc_codec_name(header), "avc1.64001f");
    EXPECT_FALSE(avc_codec_name(std::span(header).first(7)));
    EXPECT_FALSE(avc_codec_name({}));
}

}  // namespace
}  // namespace touchable
