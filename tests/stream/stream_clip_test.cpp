// SPDX-License-Identifier: Apache-2.0
// Streams as clips that are read as they come.

#include <fcntl.h>

#include "engine/base/threads.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/stream/receiving.hpp"
#include "engine/stream/stream_bytes.hpp"
#include "tests/must.hpp"
#include "tests/stream/labelled_stream.hpp"
#include "tests/stream/peers.hpp"
#include "tests/stream/servers.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

using std::chrono::milliseconds;

Result<std::unique_ptr<ClipReader>> open(const std::string& url,
                                         milliseconds patience = milliseconds(20'000)) {
    StreamSource source = source_of(url);
    source.patience.frameset = patience;
    return open_stream_clip(source);
}

std::string refusal(const std::string& bytes, milliseconds patience = milliseconds(20'000)) {
    const LoopbackSender sender(bytes);
    const auto clip = open(sender.url(), patience);
    EXPECT_FALSE(clip);
    const std::string why = message(clip);
    EXPECT_TRUE(why.starts_with(sender.url() + ": ")) << why;
    return why;
}

/// From one key to another, and one frame alone.
TEST(StreamClip, GivesTouchWithoutColour) {
    const auto scene = small_scene(64, 48, 16);
    const auto all = make_stream(scene, 30, all_planes);
    const auto sent = make_stream(scene, 30, all_planes, 0, {4, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19});
    EXPECT_LT(sent.bytes().size(), all.bytes().size());
    EXPECT_EQ(sent.blocks[9], all.blocks[9]);
    EXPECT_LT(sent.blocks[10].size(), all.blocks[10].size());
    EXPECT_TRUE(all.blocks[10].starts_with(sent.blocks[10]));
    const LoopbackSender sender(sent.bytes());
    const auto clip = must(open(sender.url()));
    const auto frames = must(read_all(*clip));
    expect_as_sent(frames, sent.frames);
    // It is not waited for until it has come once.
    for (std::size_t n = 21; n < 30; ++n)
        EXPECT_FALSE(same_plane(frames[n].colour, frames[19].colour)) << n << ": it has come back";
}

TEST(StreamClip, ReceivesExactFrames) {
    for (const Planes& planes : {all_planes, Planes{}, Planes{true, false, false}}) {
        for (const int bits : {8, 16}) {
            const auto sent = make_stream(small_scene(64, 48, bits), 17, planes, 1'000);
            const LoopbackSender sender(sent.bytes());
            const auto clip = must(open(sender.url()));
            EXPECT_EQ(clip->scene().name, "small");
            EXPECT_EQ(clip->frame_count(), std::nullopt);
            EXPECT_FALSE(clip->is_live());
            EXPECT_TRUE(clip->inputs().empty());
            expect_as_sent(must(read_all(*clip)), sent.frames);
            EXPECT_TRUE(clip->remarks().empty());
        }
    }
}

/// A file says how long its pictures stay, and labels none.
TEST(StreamClip, ReadsFileAsStream) {
    const TemporaryFolder folder;
    const std::string file = folder / "clip.mkv";
    const Scene scene = small_scene(64, 48, 16);
    ASSERT_EQ(message(write_clip(file, scene, 40, {true, true, true, false})), "");
    const LoopbackSender sender(read_bytes(file));
    const auto clip = must(open_clip(sender.url()));
    const auto frames = must(read_all(*clip));
    EXPECT_TRUE(same_frames(frames, must(read_clip(file))));
}

TEST(StreamClip, ReadsPipe) {
    const auto sent = make_stream(small_scene(64, 48, 16), 6, all_planes);
    int ends[2];
    ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    std::thread writer([&sent, in = ends[1]] {
        const std::string bytes = sent.bytes();
        for (std::size_t at = 0; at < bytes.size();) {
            const auto some = ::write(in, bytes.data() + at, bytes.size() - at);
            if (some <= 0) break;
            at += static_cast<std::size_t>(some);
        }
        ::close(in);
    });
    const auto clip = must(open("pipe:" + std::to_string(ends[0])));
    const auto frames = read_all(*clip);
    writer.join();
    ::close(ends[0]);
    ASSERT_EQ(message(frames), "");
    expect_as_sent(*frames, sent.frames);
    EXPECT_TRUE(is_refused(open("pipe:" + std::to_string(ends[0])), "no open descriptor"));
}

TEST(StreamClip, ReadsHttpWithoutLength) {
    const auto sent = make_stream(small_scene(64, 48), 6, all_planes);
    const LoopbackSender sender([&sent](const LoopbackSender::Listener& to, int) {
        (void)to.request();
        (void)to.send("HTTP/1.1 200 OK\r\nConnection: close\r\nContent-Type: video/x-matroska\r\n\r\n" +
                      sent.bytes());
    });
    const auto clip = must(open_clip(sender.url("http", "/live.mkv")));
    expect_as_sent(must(read_all(*clip)), sent.frames);
    EXPECT_EQ(sender.connections(), 1);
}

TEST(StreamClip, RewindsWithinFirstFrames) {
    const auto sent = make_stream(small_scene(64, 48), 70, {});
    const LoopbackSender sender(sent.bytes());
    auto clip = must(open(sender.url()));
    ASSERT_EQ(message(clip->seek(20)), "");
    EXPECT_EQ((*clip->next())->number, 20);
    ASSERT_EQ(message(clip->rewind()), "");
    EXPECT_TRUE(same_plane((*clip->next())->depth, sent.frames[0].depth));
    ASSERT_EQ(message(clip->seek(60)), "");
    EXPECT_TRUE(same_plane((*clip->next())->depth, sent.frames[60].depth));
    EXPECT_TRUE(is_refused(clip->rewind(), "save it first: touchable convert", ErrorKind::usage));
    EXPECT_TRUE(is_refused(clip->seek(71), "its last is 69"));
}

TEST(StreamClip, LateReceiverBeginsAtKey) {
    const auto sent = make_stream(small_scene(64, 48), 12, all_planes);
    std::string bytes = sent.header;
    for (std::size_t n = 3; n < sent.blocks.size(); ++n) bytes += sent.blocks[n];
    const LoopbackSender sender(bytes);
    const auto clip = must(open(sender.url()));
    const auto frames = must(read_all(*clip));
    ASSERT_EQ(frames.size(), 7U);
    EXPECT_TRUE(same_plane(frames.front().depth, sent.frames[5].depth));
    EXPECT_TRUE(same_plane(frames.front().haptic, sent.frames[5].haptic));
}

/// In place of a frame that is missing, damaged or half there the one before is given, and what depends on
/// it is not decoded.
TEST(StreamClip, HoldsFrameOverDamage) {
    const auto sent = make_stream(small_scene(64, 48), 20, all_planes);
    for (const int harm : {0, 1, 2, 3}) {
        StreamOfFrames harmed = sent;
        std::string& block = harmed.blocks[7];
        if (harm == 0) block.clear();
        if (harm == 1) block.resize(block.size() / 2);
        if (harm == 2) block.erase(0, block.size() / 2);
        if (harm == 3) block[block.size() / 2] = static_cast<char>(block[block.size() / 2] ^ 1);
        const LoopbackSender sender(harmed.bytes());
        const auto clip = must(open(sender.url()));
        const auto frames = must(read_all(*clip));
        ASSERT_EQ(frames.size(), 20U) << harm;
        for (std::size_t n = 0; n < 20; ++n) {
            const RawFrame& frame = frames[n];
            const auto is_of = [&](std::size_t k) { return same_touch_planes(frame, sent.frames[k]); };
            const bool is_held = n >= 7 && n < 10;
            EXPECT_TRUE(is_of(n) || (is_held && (is_of(6) || is_of(n - 1)))) << harm << ": " << n;
        }
        EXPECT_FALSE(clip->remarks().empty()) << harm;
    }
}

TEST(StreamClip, ReportsBrokenConnection) {
    const auto sent = make_stream(small_scene(64, 48), 8, all_planes);
    std::string whole = sent.header;
    for (std::size_t n = 0; n < 6; ++n) whole += sent.blocks[n];
    for (const std::size_t cut :
         {std::size_t{1}, sent.blocks[6].size() / 10, sent.blocks[6].size() * 9 / 10}) {
        const LoopbackSender sender(whole + sent.blocks[6].substr(0, cut));
        const auto clip = must(open(sender.url()));
        EXPECT_TRUE(
            is_refused(read_all(*clip), ": frame 6: the sender closed the connection in the middle of it"))
            << cut;
    }
    const std::string none = refusal(sent.header + sent.blocks[0].substr(0, 50));
    EXPECT_TRUE(has_words(none, "before it sent a whole frameset"));
}

TEST(StreamClip, RejectsOtherBytes) {
    refusal("");
    refusal(std::string(100'000, 'x'));
    Random numbers(1);
    std::string noise;
    for (int n = 0; n < 100'000; ++n) noise += static_cast<char>(numbers.below(256));
    refusal(noise);
    const auto sent = make_stream(small_scene(64, 48), 2, {});
    refusal(sent.header);
    refusal(sent.header + noise);
    refusal(sent.header.substr(0, sent.header.size() / 2) + noise);
}

/// Any message of a sender becomes one line of printable text.
TEST(StreamClip, QuotesSendersRefusalSafely) {
    EXPECT_TRUE(has_words(refusal("touchable serve: there is\x1b[2J no room\nmore"),
                          ": the sender refuses: there is"));
    EXPECT_EQ(refusal("touchable serve: a\x1b\x07z\nmore").find_first_of("\x1b\x07\n"), std::string::npos);
    EXPECT_LT(refusal("touchable serve: " + std::string(100'000, 'x')).size(), 400U);
    for (const char* other : {"touchable serve: ", "touchable serve", "touchable server: no"})
        EXPECT_TRUE(has_words(refusal(other), "neither Matroska"));
}

TEST(StreamClip, BoundsWaitForSilentSender) {
    const auto sent = make_stream(small_scene(64, 48), 3, {});
    for (const std::string& before : {sent.header.substr(0, 12), sent.header.substr(0, 100), sent.header}) {
        const LoopbackSender sender([&](const LoopbackSender::Listener& to, int) {
            (void)to.send(before);
            while (to.wait(milliseconds(20)) && to.send("\xec")) {
            }  // a byte, now and then
        });
        const auto clip = open(sender.url(), milliseconds(300));
        EXPECT_TRUE(is_refused(clip, "sent no whole frameset in time"));
    }
}

TEST(StreamClip, StopsWaitingOnRequest) {
    const LoopbackSender silent(
        [](const LoopbackSender::Listener& to, int) { (void)to.wait(milliseconds(100'000)); });
    std::stop_source told;
    std::jthread teller([&] {
        while (silent.connections() == 0) std::this_thread::yield();
        told.request_stop();
    });
    const auto clip = work_until(told.get_token(), [&] { return open_clip(silent.url()); });
    EXPECT_TRUE(is_refused(clip, "", ErrorKind::interrupted));
}

TEST(StreamWait, TellsLateFromStopped) {
    StreamWait wait;
    wait.at_most(milliseconds(-1));
    const auto waits_in_vain = []() -> Result<int> {
        return stop_requested() ? Result<int>(interrupted_error()) : 7;
    };
    const auto late = wait.in_time(waits_in_vain);
    EXPECT_TRUE(is_refused(late, "", ErrorKind::input));
    std::stop_source told;
    told.request_stop();
    const auto given_up = work_until(told.get_token(), [&] { return wait.in_time(waits_in_vain); });
    EXPECT_TRUE(is_refused(given_up, "", ErrorKind::interrupted));
    wait.at_most(std::chrono::hours(1));
    EXPECT_EQ(wait.in_time(waits_in_vain).value(), 7);
    wait.together_at_most(milliseconds(-1));
    wait.at_most(std::chrono::hours(1));
    EXPECT_FALSE(wait.in_time(waits_in_vain)) << "all of them together are late";
}

TEST(StreamClip, ReportsMissingSender) {
    int port = 0;
    {
        const LoopbackSender gone("");
        port = gone.port();
    }
    EXPECT_TRUE(is_refused(open("tcp://127.0.0.1:" + std::to_string(port)), "does the sender listen there?"));
}

TEST(StreamClip, ReportsUnknownHost) {
    const std::string host(70, 'x');  // longer than any: no name server is asked
    for (const std::string& url :
         {"tcp://" + host + ":7000", "http://" + host + "/a", "srt://" + host + ":1"})
        EXPECT_TRUE(message(open_clip(url)).ends_with(": no connection: no host of that name")) << url;
}

TEST(StreamClip, FollowsNoRedirect) {
    for (const char* to : {"file:///etc/passwd", "http://127.0.0.2:1/", "tcp://127.0.0.1:1"}) {
        const LoopbackSender sender([&](const LoopbackSender::Listener& listener, int) {
            (void)listener.request();
            (void)listener.send("HTTP/1.1 302 Found\r\nLocation: " + std::string(to) +
                                "\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
        });
        EXPECT_TRUE(is_refused(open_clip(sender.url("http", "/a.mkv")), "", ErrorKind::input)) << to;
        EXPECT_EQ(sender.connections(), 1);
    }
}

/// A web server that has a file, gives its first bytes at once, and from there on a byte now and then.
class DrippingServer {
public:
    DrippingServer(std::string file, std::size_t at_once)
        : file_(std::move(file)), sender_([this, at_once](const LoopbackSender::Listener& to, int) {
              const std::string asked = to.request();
              std::size_t at = 0;
              if (const auto range = asked.find("Range: bytes="); range != std::string::npos)
                  at = std::stoul(asked.substr(range + 13));
              const auto size = std::to_string(file_.size());
              (void)to.send("HTTP/1.1 206 Partial Content\r\nAccept-Ranges: bytes\r\nContent-Range: bytes " +
                            std::to_string(at) + "-" + std::to_string(file_.size() - 1) + "/" + size +
                            "\r\nContent-Length: " + std::to_string(file_.size() - at) +
                            "\r\nConnection: close\r\n\r\n");
              if (at < at_once) (void)to.send(file_.substr(at, at_once - at));
              for (std::size_t n = std::max(at, at_once); n < file_.size(); ++n)
                  if (to.is_gone() || !to.wait(milliseconds(20)) || !to.send(file_.substr(n, 1))) return;
          }) {}
    StreamUrl url() const { return *read_stream_url(sender_.url("http", "/clip.mkv")); }
    int connections() const { return sender_.connections(); }

private:
    const std::string file_;
    LoopbackSender sender_;
};

/// The one wait of ten seconds is all that it costs.
TEST(HttpFile, RejectsDrippingServerOnce) {
    const DrippingServer server(std::string(1 << 20, 'x'), 0);
    const auto clip = open_clip(server.url().text);
    EXPECT_TRUE(is_refused(clip, "", ErrorKind::input));
    EXPECT_EQ(message(clip), server.url().name() +
                                 ": comes too slowly: its clip was not open within 10 s; save it first, and "
                                 "open it here");
    EXPECT_EQ(server.connections(), 1);
}

TEST(HttpFile, FailsAtOnceAfterFailure) {
    const DrippingServer server(std::string(4 << 20, 'x'), 1 << 20);
    StreamSource::Patience patience;
    patience.frameset = milliseconds(1'000);
    const auto opened = must(open_http(server.url(), patience));
    ASSERT_TRUE(opened.file);
    ASSERT_EQ(opened.end_opening(), std::nullopt);
    auto file = must(opened.file->open("a clip"));
    char bytes[16];
    ASSERT_EQ(message(file.read(0, bytes, sizeof bytes)), "");
    // Where the last part ends: farther on, FFmpeg may or may not connect anew, and the server may take that
    // late.
    EXPECT_TRUE(is_refused(file.read(1 << 20, bytes, sizeof bytes), "too slowly"));
    const auto begun = std::chrono::steady_clock::now();
    for (std::uint64_t at = 1; at < 40; ++at)
        EXPECT_NE(message(file.read(at * 100'000, bytes, sizeof bytes)), "");
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(20))
        << "39 waits are as many seconds";
    EXPECT_EQ(server.connections(), 1);
}

TEST(StreamClip, FailsAtOnceAfterFailure) {
    const auto sent = make_stream(small_scene(64, 48), 3, {});
    const LoopbackSender stalls([&](const LoopbackSender::Listener& to, int) {
        (void)to.send(sent.header + sent.blocks[0]);
        while (to.wait(milliseconds(20)) && to.send("\xec")) {
        }
    });
    const auto clip = must(open(stalls.url(), milliseconds(1'000)));
    ASSERT_EQ(message(clip->next()), "");
    const std::string first = message(clip->next());
    EXPECT_TRUE(has_words(first, "frame 1: "));
    const auto begun = std::chrono::steady_clock::now();
    for (int n = 0; n < 30; ++n) EXPECT_EQ(message(clip->next()), first);
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(20))
        << "30 waits are as many seconds";
}

TEST(StreamClip, OpensInTimeOrFails) {
    const auto sent = make_stream(small_scene(64, 48), 3, {});
    const LoopbackSender slow([&](const LoopbackSender::Listener& to, int) {
        (void)to.send(sent.header);
        (void)to.wait(std::chrono::hours(1));
    });
    StreamSource source = source_of(slow.url());
    source.patience.opening = milliseconds(2'000);
    source.patience.frameset = std::chrono::hours(1);
    EXPECT_TRUE(is_refused(open_stream_clip(source), "sent no whole frameset in time"));
}

// Streams as live sources. What waits here waits for what happens, and never for a time.

using Clock = std::chrono::steady_clock;

/// The blocks, one every few milliseconds, over and over; their numbers count up from connection to
/// connection where `stream` says so.
LoopbackSender::Say paced(std::shared_ptr<const StreamOfFrames> stream) {
    return [stream](const LoopbackSender::Listener& to, int) {
        if (!to.send(stream->header)) return;
        for (const std::string& block : stream->blocks)
            if (!to.send(block) || !to.wait(std::chrono::milliseconds(4))) return;
    };
}

std::shared_ptr<const StreamOfFrames> stream_of(int frames, const Planes& planes = all_planes,
                                                int width = 64) {
    return std::make_shared<const StreamOfFrames>(make_stream(small_scene(width, 48, 16), frames, planes));
}

StreamSource live_choice(const std::string& url) {
    StreamSource choice = source_of(url);
    choice.patience.back_off = std::chrono::milliseconds(5);
    return choice;
}

bool is_of_one_frame(const RawFrame& frame, const StreamOfFrames& stream) {
    return std::any_of(stream.frames.begin(), stream.frames.end(),
                       [&](const RawFrame& sent) { return same_touch_planes(frame, sent); });
}

bool says(const ClipReader& clip, const std::string& what) {
    const auto remarks = clip.remarks();
    return std::any_of(remarks.begin(), remarks.end(),
                       [&](const std::string& remark) { return remark.find(what) != std::string::npos; });
}

/// Longer than any test looks on.
std::shared_ptr<const StreamOfFrames> long_stream() {
    static const auto made = stream_of(1'000);
    return made;
}

TEST(LiveStream, GivesFramesAsTheyCome) {
    const auto stream = long_stream();
    const LoopbackSender sender(paced(stream));
    const auto clip = must(open_live_stream(live_choice(sender.url())));
    EXPECT_TRUE(clip->is_live());
    EXPECT_EQ(clip->scene().interpolation, FrameInterpolation::hold);
    for (std::int64_t n = 0; n < 5; ++n) {
        const auto frame = must(clip->next());
        EXPECT_EQ(frame->number, n);
        EXPECT_TRUE(is_of_one_frame(*frame, *stream));
    }
    ASSERT_EQ(message(clip->rewind()), "");
    EXPECT_EQ((*clip->next())->number, 0);
    const auto zero = Clock::now();
    ASSERT_EQ(message(clip->begin(zero)), "");
    std::int64_t last = 0, last_ns = 0;
    for (int n = 0; n < 20; ++n) {
        const RawFrame frame = next_of(*clip);
        EXPECT_GT(frame.number, last);
        EXPECT_GT(frame.time_ns, last_ns);
        EXPECT_LE(frame.time_ns, std::chrono::nanoseconds(Clock::now() - zero).count());
        EXPECT_TRUE(is_of_one_frame(frame, *stream));
        EXPECT_FALSE(frame.colour.empty());
        last = frame.number;
        last_ns = frame.time_ns;
    }
    EXPECT_FALSE(clip->seek(3));
    const auto figures = clip->stream_figures();
    ASSERT_TRUE(figures);
    EXPECT_GE(figures->whole, 26);
    EXPECT_EQ(figures->torn + figures->lost + figures->late, 0);
    EXPECT_EQ(figures->connections, 1);
    EXPECT_LE(figures->delay_ms, 200);
}

/// A client that comes in between keys, to a sender that does not care for it, as UDP's: the picture that it
/// shows first is that of the next key, and nothing was damaged.
TEST(LiveStream, LateClientBeginsAtKey) {
    constexpr std::size_t keys_apart = 5;
    // MPEG-TS sends its tables now and then; of it more has to be there before it opens.
    const Scene scene = small_scene(64, 48, 16);
    for (const auto& sent :
         {make_stream(scene, 14, all_planes), make_transport_stream(scene, 100, all_planes)})
        for (std::size_t from = 1; from <= 2 * keys_apart; ++from) {
            const LoopbackSender sender([&](const LoopbackSender::Listener& to, int) {
                (void)to.send(sent.bytes(from));
                to.stay();
            });
            const auto clip = must(open_live_stream(live_choice(sender.url())));
            const std::size_t key = (from + keys_apart - 1) / keys_apart * keys_apart;
            for (std::size_t n = 0; n < 3; ++n) {
                const RawFrame frame = next_of(*clip);
                EXPECT_EQ(frame.number, static_cast<std::int64_t>(n)) << from;
                EXPECT_TRUE(is_as_sent(frame, sent.frames[key + n])) << from << ": " << n;
            }
            EXPECT_EQ(clip->stream_figures()->torn, 0) << from;
        }
}

TEST(LiveStream, ReconnectsToRestartedSender) {
    const auto stream = long_stream();
    auto sender = std::make_unique<LoopbackSender>(paced(stream));
    const int port = sender->port();
    const auto clip = must(open_live_stream(live_choice(sender->url())));
    ASSERT_EQ(message(clip->next()), "");
    ASSERT_EQ(message(clip->begin(Clock::now())), "");
    ASSERT_EQ(message(clip->next()), "");
    for (int again = 1; again <= 2; ++again) {
        sender.reset();
        while (!says(*clip, "connecting again")) std::this_thread::yield();
        EXPECT_TRUE(says(*clip, "the sender ")) << "which how it ended follows";
        sender = std::make_unique<LoopbackSender>(paced(stream), port);
        while (clip->stream_figures()->connections == again) std::this_thread::yield();
        std::int64_t last = -1;
        for (int n = 0; n < 3; ++n) {
            const RawFrame frame = next_of(*clip);
            EXPECT_GT(frame.number, last);
            EXPECT_TRUE(is_of_one_frame(frame, *stream));
            last = frame.number;
        }
    }
    EXPECT_TRUE(says(*clip, "was connected to again, 2 times"));
}

TEST(LiveStream, EndsOnAnotherScene) {
    const auto stream = stream_of(10), other = stream_of(100, all_planes, 80);
    const LoopbackSender sender([&](const LoopbackSender::Listener& to, int number) {
        paced(number == 0 ? stream : other)(to, number);
    });
    const auto clip = must(open_live_stream(live_choice(sender.url())));
    ASSERT_EQ(message(clip->next()), "");
    ASSERT_EQ(message(clip->begin(Clock::now())), "");
    while (true) {
        const auto frame = must(clip->next());
        if (!frame) break;
        EXPECT_EQ(frame->depth.width, 64);
    }
    EXPECT_TRUE(says(*clip, "sends another scene or other planes than before"));
    EXPECT_FALSE(*clip->next()) << "it is gone";
}

TEST(LiveStream, ReconnectsToSilentSender) {
    const auto stream = long_stream();
    const LoopbackSender sender([&](const LoopbackSender::Listener& to, int number) {
        if (number > 0) return paced(stream)(to, number);
        (void)to.send(stream->header + stream->blocks[0] + stream->blocks[1]);
        while (!to.is_gone() && to.wait(std::chrono::milliseconds(5))) {
        }
    });
    StreamSource choice = live_choice(sender.url());
    choice.patience.silence = std::chrono::milliseconds(50);
    const auto clip = must(open_live_stream(choice));
    ASSERT_EQ(message(clip->begin(Clock::now())), "");
    while (clip->stream_figures()->connections < 2) std::this_thread::yield();
    const RawFrame frame = next_of(*clip);
}

TEST(LiveStream, StopsWaitingOnRequest) {
    const auto stream = stream_of(1);
    const LoopbackSender sender([&](const LoopbackSender::Listener& to, int) {
        (void)to.send(stream->header + stream->blocks[0]);
        (void)to.wait(std::chrono::hours(1));
    });
    const auto clip = must(open_live_stream(live_choice(sender.url())));
    ASSERT_EQ(message(clip->begin(Clock::now())), "");
    while (!says(*clip, "has sent no whole frameset for")) std::this_thread::yield();
    EXPECT_GT(clip->stream_figures()->lost, 0) << "by the clip's rate";
    std::stop_source given_up;
    const StopScope until(given_up.get_token());
    std::jthread teller([&] { given_up.request_stop(); });
    auto frame = clip->next();
    while (frame && *frame) frame = clip->next();
    EXPECT_TRUE(is_refused(frame, "", ErrorKind::interrupted));
}

TEST(LiveStream, EndsWithItsPipe) {
    const auto stream = stream_of(5, {});
    int ends[2];
    ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    const std::string bytes = stream->bytes();
    ASSERT_LT(bytes.size(), 65'536U);
    ASSERT_EQ(::write(ends[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    const auto clip = must(open_live_stream(live_choice("pipe:" + std::to_string(ends[0]))));
    ASSERT_EQ(message(clip->begin(Clock::now())), "");
    ::close(ends[1]);
    auto frame = clip->next();
    while (frame && *frame) frame = clip->next();
    ASSERT_EQ(message(frame), "");
    EXPECT_TRUE(says(*clip, "its last frame stands still"));
    ::close(ends[0]);
}

// MPEG-TS, received: as a clip, as a live source, over TCP, SRT and UDP.

/// Sends to a port of this machine, a packet of MPEG-TS at a time, until it has all or is not heard: by SRT
/// to its caller, or by FFmpeg's UDP.
class NetworkSender {
public:
    NetworkSender(bool is_srt, int port, std::shared_ptr<const StreamOfFrames> stream, int pause_ms)
        : thread_([this, is_srt, port, stream = std::move(stream), pause_ms] {
              std::optional<SrtPeer> srt;
              AVIOContext* io = nullptr;
              if (is_srt)
                  srt.emplace(SrtPeer::Kind::listens, port);
              else if (avio_open(&io, ("udp://127.0.0.1:" + std::to_string(port) + "?pkt_size=1316").c_str(),
                                 AVIO_FLAG_WRITE) < 0)
                  return;
              for (std::size_t n = 0; !stopping_ && n < stream->blocks.size(); ++n) {
                  const std::string& block = stream->blocks[n];
                  for (std::size_t at = 0; at < block.size(); at += 1316) {
                      const std::string piece = block.substr(at, 1316);
                      if (srt && !srt->say(piece)) return;
                      if (srt) continue;
                      avio_write(io, reinterpret_cast<const unsigned char*>(piece.data()),
                                 static_cast<int>(piece.size()));
                      avio_flush(io);
                  }
                  std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms));
              }
              if (srt) srt->wait_until_arrived();
              avio_close(io);
          }) {}
    ~NetworkSender() {
        stopping_ = true;
        thread_.join();
    }
    NetworkSender(const NetworkSender&) = delete;
    NetworkSender& operator=(const NetworkSender&) = delete;

private:
    std::atomic<bool> stopping_{false};
    std::thread thread_;
};

TEST(TransportClip, ReceivesExactFrames) {
    for (const Planes& planes : {all_planes, Planes{}, Planes{true, true, false}}) {
        const auto sent = make_transport_stream(small_scene(64, 48, 16), 17, planes);
        const LoopbackSender sender(sent.bytes());
        const auto clip = must(open_stream_clip(source_of(sender.url())));
        EXPECT_EQ(clip->scene().name, "small");
        EXPECT_EQ(clip->tracks().size(), 1U + planes.colour + planes.haptic + planes.height);
        const auto frames = must(read_all(*clip));
        ASSERT_EQ(frames.size(), sent.frames.size());
        for (std::size_t n = 0; n < frames.size(); ++n)
            EXPECT_TRUE(is_as_sent(frames[n], sent.frames[n])) << n;
    }
}

/// Received bytes that were saved end anywhere.
TEST(TransportClip, OpensSavedFile) {
    const TemporaryFolder folder;
    const auto file = folder / "saved.ts";
    const auto sent = make_transport_stream(small_scene(64, 48, 16), 17, all_planes);
    const std::string whole = sent.bytes();
    for (const bool is_cut : {false, true}) {
        write_bytes(file, whole.substr(0, whole.size() - (is_cut ? sent.blocks.back().size() / 2 : 0)));
        const auto clip = must(open_clip(file));
        EXPECT_EQ(clip->scene().name, "small");
        EXPECT_EQ(clip->inputs(), std::vector{file});
        const auto frames = must(read_all(*clip));
        ASSERT_EQ(frames.size(), is_cut ? 16U : 17U);
        for (std::size_t n = 0; n < frames.size(); ++n)
            EXPECT_TRUE(is_as_sent(frames[n], sent.frames[n])) << n;
    }
    write_bytes(file, sent.blocks[0].substr(0, 4 * 188));
    const auto none = open_clip(file);
    ASSERT_FALSE(none);
    EXPECT_EQ(message(none), file.string() + ": ends before it sent a picture of depth that says what it is");
}

/// Its table of tracks names colour, and what waits for that must not fill the memory.
TEST(TransportClip, OpensWithoutAnnouncedColour) {
    const auto sent = make_transport_stream(small_scene(64, 48, 8), 100, {true, false, false, false});
    const std::string all = sent.bytes();
    std::string without;
    for (std::size_t at = 0; at < all.size(); at += 188) {
        const bool is_of_first_track = (all[at + 1] & 0x1f) == 1 && all[at + 2] == 0;  // PID 0x100
        if (!is_of_first_track) without += all.substr(at, 188);
    }
    const LoopbackSender sender(without);
    const auto frames = must(read_all(*must(open_stream_clip(source_of(sender.url())))));
    ASSERT_FALSE(frames.empty());
    EXPECT_LE(frames.size(), 64U);
    EXPECT_TRUE(same_touch_planes(frames.back(), sent.frames.back()));
}

TEST(TransportClip, HoldsFramesOverLostPackets) {
    const auto sent = make_transport_stream(small_scene(64, 48, 16), 40, all_planes);
    for (std::uint64_t seed = 1; seed < 6; ++seed) {
        Random numbers(seed);
        std::string damaged = sent.blocks[0];
        for (std::size_t n = 1; n < sent.blocks.size(); ++n)
            for (std::size_t at = 0; at < sent.blocks[n].size(); at += 188)
                if (numbers.below(100) > 0) damaged += sent.blocks[n].substr(at, 188);
        const LoopbackSender sender(damaged);
        const auto clip = must(open_stream_clip(source_of(sender.url())));
        while (true) {
            const auto frame = clip->next();
            if (!frame || !*frame) break;
            std::size_t of = 0;
            while (of < sent.frames.size() && !is_as_sent(**frame, sent.frames[of])) ++of;
            ASSERT_LT(of, sent.frames.size()) << "planes of different frames";
            EXPECT_LE(static_cast<std::int64_t>(of), (*frame)->number);
        }
        EXPECT_FALSE(clip->remarks().empty());
    }
}

TEST(TransportClip, ReadsSrtAndUdp) {
    const auto sent = std::make_shared<const StreamOfFrames>(
        make_transport_stream(small_scene(64, 48, 16), 300, {true, true, false, false}));
    for (const std::string scheme : {"srt", "udp"}) {
        const int port = unused_port();
        const std::string address = scheme + "://127.0.0.1:" + std::to_string(port);
        const bool is_srt = scheme == "srt";
        const NetworkSender sender(is_srt, port, sent, 10);
        StreamSource source = source_of(address + (is_srt ? "?mode=caller&latency=20" : ""));
        source.patience.connection = std::chrono::seconds(20);
        const auto clip = must(open_stream_clip(source));
        for (int n = 0; n < 20; ++n) {
            const RawFrame frame = next_of(*clip);
            EXPECT_TRUE(std::ranges::any_of(sent->frames,
                                            [&](const RawFrame& other) { return is_as_sent(frame, other); }));
        }
    }
}

/// UDP tells of no other end: what came is a clip.
TEST(TransportClip, EndsWhenUdpFallsSilent) {
    const auto sent = std::make_shared<const StreamOfFrames>(
        make_transport_stream(small_scene(64, 48, 16), 300, {true, true, false, false}));
    const int port = unused_port();
    auto sender = std::make_unique<NetworkSender>(false, port, sent, 10);
    StreamSource source = source_of("udp://127.0.0.1:" + std::to_string(port));
    source.patience.frameset = milliseconds(3'000);
    const auto clip = must(open_stream_clip(source));
    for (int n = 0; n < 20; ++n) (void)next_of(*clip);
    sender.reset();
    const auto rest = must(read_all(*clip));
    const std::size_t last = rest.empty() ? 19 : static_cast<std::size_t>(rest.back().number);
    EXPECT_EQ(clip->remarks().back(), "the sender sent no further whole frameset in time after frame " +
                                          std::to_string(last) + ", so the clip ends there");
    EXPECT_FALSE(must(clip->next())) << "and it stays so";
}

TEST(TransportClip, ReadsMatroskaBySrt) {
    auto made = make_stream(small_scene(64, 48, 16), 60, all_planes);
    made.blocks.insert(made.blocks.begin(), made.header);
    const auto sent = std::make_shared<const StreamOfFrames>(std::move(made));
    const int port = unused_port();
    const std::string address = "srt://127.0.0.1:" + std::to_string(port);
    const NetworkSender sender(true, port, sent, 2);
    StreamSource source = source_of(address + "?mode=caller&latency=20");
    source.patience.connection = std::chrono::seconds(20);
    const auto clip = must(open_stream_clip(source));
    const auto frames = must(read_all(*clip));
    EXPECT_GE(frames.size(), 50U);
    for (std::size_t n = 0; n < frames.size(); ++n) EXPECT_TRUE(is_as_sent(frames[n], sent->frames[n])) << n;
    // SRT does not tell a sender that was killed from one that ended.
    EXPECT_TRUE(clip->remarks().back().ends_with("so the clip ends there")) << clip->remarks().back();
}

}  // namespace
}  // namespace touchable::test
