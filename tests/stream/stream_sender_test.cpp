// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <poll.h>

#include <map>
#include <thread>

#include "engine/clip/containers.hpp"
#include "engine/stream/sending.hpp"
#include "engine/stream/stream_url.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/stream/relay.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t sender_ms = 1'000'000, sender_utc_ns = 1'800'000'000'000'000'000;

/// Passes while a thread waits, or where a test sets it.
class VirtualTime final : public StreamSender::Time {
public:
    std::int64_t now_ns() override { return now; }
    std::int64_t utc_ns() override { return sender_utc_ns + now + stepped; }
    bool wait_until(std::int64_t at_ns) override {
        now = std::max(now, at_ns);
        if (on_wait) on_wait();
        return !stop_requested();
    }

    std::int64_t now = 5'000 * sender_ms, stepped = 0;
    std::function<void()> on_wait;
};

/// Frames of so many planes, as a clip or as a camera that takes them at its own times, which pass while it
/// is waited for.
class MadeClip final : public OwnClip {
public:
    MadeClip(const Scene& scene, int frames, VirtualTime* camera_time = nullptr)
        : OwnClip(scene), frames_(frames), camera_time_(camera_time) {}
    Result<std::optional<RawFrame>> next() override {
        if (number_ == frames_) return std::optional<RawFrame>{};
        RawFrame frame = test_frame(scene_, number_, {false, true, false, false});
        if (camera_time_) {
            frame.time_ns = times[static_cast<std::size_t>(number_)];
            frame.number = 3 * number_;  // others were missed
            camera_time_->now = std::max(camera_time_->now, begun_ns_ + frame.time_ns + delay_ns);
        }
        ++number_;
        return std::optional(std::move(frame));
    }
    bool is_live() const override { return camera_time_ != nullptr; }
    Result<void> begin(std::chrono::steady_clock::time_point zero) override {
        begun_ns_ = std::chrono::nanoseconds(zero.time_since_epoch()).count();
        return {};
    }

    std::vector<std::int64_t> times;
    std::int64_t delay_ns = 0;  // from when a frame is taken to when it is there

private:
    const int frames_;
    VirtualTime* const camera_time_;
    std::int64_t begun_ns_ = 0;
};

/// Notes what is added; its blocks hold three bytes.
class NotingMuxer final : public StreamMuxer {
public:
    struct Note {
        PictureLabel label;
        std::int64_t time_ns, added_at_ns;
        std::uint64_t epoch;
        bool is_key;
    };
    NotingMuxer(std::vector<Note>& notes, StreamSender::Time& time) : notes_(notes), time_(time) {}
    std::span<const std::uint8_t> header() const override { return header_; }
    Result<StreamMuxer::Block> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                                   bool is_key) override {
        notes_.push_back({label, time_ns, time_.now_ns(), frame.epoch, is_key});
        return StreamMuxer::Block{label.frame, is_key, {1, 2, 3}};
    }

private:
    std::vector<Note>& notes_;
    StreamSender::Time& time_;
    std::vector<std::uint8_t> header_{7};
};

struct Sent {
    VirtualTime time;
    StreamRing ring;
    std::vector<NotingMuxer::Note> notes;
    StreamSender::Figures figures;

    Result<void> send(std::unique_ptr<ClipReader> clip, const StreamSender::Settings& settings = {}) {
        std::vector<StreamSender::Channel> channels;
        channels.push_back({std::make_unique<NotingMuxer>(notes, time), ring});
        StreamSender sender(std::move(clip), std::move(channels), settings, time);
        auto run = sender.run();
        figures = sender.figures();
        EXPECT_EQ(sender.framesets(), figures.framesets);
        return run;
    }
};

Scene scene_of_rate(std::int64_t num, std::int64_t den = 1) {
    Scene scene = small_scene(8, 6);
    scene.rate = {num, den};
    return scene;
}

TEST(StreamSender, SendsAtTheClipsTimes) {
    Sent sent;
    const Scene scene = scene_of_rate(30000, 1001);
    std::map<std::int64_t, std::int64_t> released;  // by frame, when it was there for listeners
    auto cursor = sent.ring.join();
    sent.ring.watch([&] {
        if (const auto block = sent.ring.next(cursor)) released[block->frame] = sent.time.now;
    });
    const std::int64_t begin_ns = sent.time.now + StreamSender::lead_ns;
    ASSERT_EQ(message(sent.send(std::make_unique<MadeClip>(scene, 50))), "");
    ASSERT_EQ(released.size(), 50U);
    for (std::int64_t n = 0; n < 50; ++n) {
        EXPECT_EQ(released[n], begin_ns + scene.rate.time_ns(n));
        const auto& note = sent.notes[static_cast<std::size_t>(n)];
        EXPECT_EQ(note.label.frame, n);
        EXPECT_EQ(note.label.taken_ns, sender_utc_ns + begin_ns + scene.rate.time_ns(n));
        EXPECT_EQ(note.time_ns, scene.rate.time_ns(n));
        EXPECT_LE(note.added_at_ns, released[n]) << "encoded before its time comes";
    }
    EXPECT_TRUE(sent.ring.is_over(cursor));
    EXPECT_EQ(sent.figures.framesets, 50);
    EXPECT_EQ(sent.figures.bytes, 150);
    EXPECT_EQ(sent.figures.latest_ns, 0);
    EXPECT_EQ(sent.figures.held_up_ns, 0);
}

TEST(StreamSender, SendsKeysOften) {
    for (const std::int64_t rate : {1, 2, 7, 10, 29, 30, 31, 60, 240, 1000}) {
        Sent sent;
        ASSERT_EQ(message(sent.send(std::make_unique<MadeClip>(scene_of_rate(rate), 100))), "");
        ASSERT_TRUE(sent.notes.front().is_key);
        std::size_t key = 0;
        std::int64_t keys = 0;
        for (std::size_t n = 0; n < sent.notes.size(); ++n) {
            if (sent.notes[n].is_key) {
                key = n;
                ++keys;
            }
            EXPECT_LT(n - key, 15U);
            EXPECT_LE(sent.notes[n].time_ns - sent.notes[key].time_ns, 500 * sender_ms);
        }
        EXPECT_EQ(keys, sent.figures.keys);
        EXPECT_TRUE(rate < 30 || keys == 7) << "no more often than that takes, at " << rate;
    }
}

TEST(StreamSender, CountsOnInLoop) {
    Sent sent;
    const Scene scene = scene_of_rate(25, 2);
    const StreamSender::Settings settings{.loop = true, .longest_ns = 2'000 * sender_ms};
    ASSERT_EQ(message(sent.send(std::make_unique<MadeClip>(scene, 10), settings)), "");
    ASSERT_EQ(sent.notes.size(), 25U);
    EXPECT_EQ(sent.figures.rounds, 3);
    for (std::int64_t n = 0; n < 25; ++n) {
        const auto& note = sent.notes[static_cast<std::size_t>(n)];
        EXPECT_EQ(note.label.frame, n);
        EXPECT_EQ(note.time_ns, scene.rate.time_ns(n));
        EXPECT_EQ(note.epoch, static_cast<std::uint64_t>(n / 10));
    }
}

TEST(StreamSender, SendsCameraFramesAtOnce) {
    Sent sent;
    auto camera = std::make_unique<MadeClip>(scene_of_rate(30), 5, &sent.time);
    camera->times = {3 * sender_ms, 40 * sender_ms, 150 * sender_ms, 151 * sender_ms, 900 * sender_ms};
    camera->delay_ns = 8 * sender_ms;
    const std::int64_t begin_ns = sent.time.now;
    const auto times = camera->times;
    ASSERT_EQ(message(sent.send(std::move(camera), {.loop = true})), "");  // which is for clips
    ASSERT_EQ(sent.notes.size(), 5U);
    for (std::size_t n = 0; n < 5; ++n) {
        EXPECT_EQ(sent.notes[n].label.frame, static_cast<std::int64_t>(n));
        EXPECT_EQ(sent.notes[n].time_ns, times[n]);
        EXPECT_EQ(sent.notes[n].label.taken_ns, sender_utc_ns + begin_ns + times[n]);
        EXPECT_EQ(sent.notes[n].added_at_ns, begin_ns + times[n] + 8 * sender_ms);
    }
    EXPECT_TRUE(sent.notes[4].is_key);
}

TEST(StreamSender, FollowsSteppedClock) {
    Sent sent;
    const Scene scene = scene_of_rate(10);
    int waits = 0;
    sent.time.on_wait = [&] {
        if (++waits == 3) sent.time.stepped = 3'600'000 * sender_ms;
    };
    ASSERT_EQ(message(sent.send(std::make_unique<MadeClip>(scene, 6))), "");
    EXPECT_EQ(sent.notes[3].label.taken_ns - sent.notes[2].label.taken_ns, (3'600'000 + 100) * sender_ms);
    EXPECT_EQ(sent.notes[3].time_ns - sent.notes[2].time_ns, 100 * sender_ms);
}

// As by a machine that was stopped for a while: no hurry of a thousand frames follows.
TEST(StreamSender, NeverCatchesUpAfterStop) {
    Sent sent;
    const Scene scene = scene_of_rate(10);
    int waits = 0;
    std::vector<std::int64_t> at;
    sent.time.on_wait = [&] {
        if (++waits == 4) sent.time.now += 60'000 * sender_ms;
        if (waits == 8) sent.time.now += 150 * sender_ms;
        at.push_back(sent.time.now);
    };
    ASSERT_EQ(message(sent.send(std::make_unique<MadeClip>(scene, 12))), "");
    EXPECT_EQ(at[4] - at[3], 100 * sender_ms);
    EXPECT_EQ(at[8] - at[7], 0) << "what is little is made up for";
    EXPECT_EQ(at[11] - at[3], 800 * sender_ms);
    EXPECT_EQ(sent.figures.held_up_ns, 60'000 * sender_ms);
    EXPECT_EQ(sent.figures.latest_ns, 60'000 * sender_ms);
}

TEST(StreamSender, EndsOnRequest) {
    Sent sent;
    std::vector<StreamSender::Channel> channels;
    channels.push_back({std::make_unique<NotingMuxer>(sent.notes, sent.time), sent.ring});
    StreamSender sender(std::make_unique<MadeClip>(scene_of_rate(30), 10), std::move(channels),
                        {.loop = true}, sent.time);
    int waits = 0;
    sent.time.on_wait = [&] {
        if (++waits == 100) sender.end();
    };
    ASSERT_EQ(message(sender.run()), "");
    EXPECT_EQ(sender.framesets(), 99);
    auto cursor = sent.ring.join();
    while (sent.ring.next(cursor)) {
    }
    EXPECT_TRUE(sent.ring.is_over(cursor));
}

TEST(StreamSender, EndsLoopOfEmptyClip) {
    Sent sent;
    ASSERT_EQ(message(sent.send(std::make_unique<MadeClip>(scene_of_rate(30), 0), {.loop = true})), "");
    EXPECT_EQ(sent.figures.framesets, 0);
}

// A listener that saves a loop has a clip of all rounds, from the key on at which it joined.
TEST(StreamSender, SavesLoopAsOneClip) {
    const TemporaryFolder folder;
    const Scene scene = scene_of_rate(30);
    VirtualTime time;
    StreamRing ring({.framesets = 1000});
    auto first = ring.join();
    auto muxer = must(open_matroska_stream(scene));
    std::vector<StreamSender::Channel> channels;
    channels.push_back({std::move(muxer), ring});
    StreamSender sender(std::make_unique<MadeClip>(scene, 7), std::move(channels),
                        {.loop = true, .longest_ns = 1'000 * sender_ms}, time);
    ASSERT_EQ(message(sender.run()), "");
    std::string bytes(ring.header()->begin(), ring.header()->end());
    while (const auto block = ring.next(first)) bytes.append(block->bytes.begin(), block->bytes.end());
    write_bytes(folder / "rounds.mkv", bytes);
    const auto read = must(read_clip(folder / "rounds.mkv"));
    ASSERT_EQ(read.size(), 30U);
    for (std::int64_t n = 0; n < 30; ++n) {
        const RawFrame sent = test_frame(scene, n % 7, {false, true, false, false});
        EXPECT_TRUE(same_touch_planes(read[static_cast<std::size_t>(n)], sent)) << n;
    }
}

// The network that other tests stand in.

/// A socket for datagrams on this machine's loopback, closed with it.
class End {
public:
    explicit End(int port) {
        const sockaddr_in address = loopback(port);
        const auto* const plain = reinterpret_cast<const sockaddr*>(&address);
        const int status =
            port == 0 ? ::bind(of_, plain, sizeof address) : ::connect(of_, plain, sizeof address);
        EXPECT_EQ(status, 0);
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
    const int of_ = ::socket(AF_INET, SOCK_DGRAM, 0);
};

TEST(Relay, LosesStatedShareOfDatagrams) {
    const End server(0);
    const auto relay = must(Relay::open(Relay::Kind::udp, server.port(), {.loss = 0.1, .burst = 3}));
    const End client(relay->port());
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
        while (relay->passed() + relay->lost() <= k) ::poll(nullptr, 0, 1);
        while (arrived < relay->passed()) take_one();
    }
    EXPECT_NEAR(static_cast<double>(relay->lost()) / count, 0.1, 0.04);
    relay->stall(true);
    const std::int64_t before = relay->passed();
    const int more = count;
    ASSERT_GT(::send(client.get(), &more, sizeof more, 0), 0);
    while (relay->passed() + relay->lost() <= count) ::poll(nullptr, 0, 1);
    EXPECT_EQ(relay->passed(), before);
}

}  // namespace
}  // namespace touchable::test

namespace touchable {
namespace {

using test::is_refused;
using test::must;

constexpr std::chrono::milliseconds long_enough{60'000};

void add_blocks(StreamRing& ring, std::int64_t from, std::int64_t to, std::int64_t keys = 15,
                std::size_t bytes = 10) {
    for (std::int64_t n = from; n < to; ++n)
        ring.add({n, n % keys == 0, std::vector<std::uint8_t>(bytes, static_cast<std::uint8_t>(n))});
}

std::int64_t next_frame(const StreamRing& ring, StreamRing::Cursor& cursor) {
    const auto block = ring.next(cursor);
    return block ? block->frame : -1;
}

TEST(StreamRing, GivesAllFromTheBeginning) {
    StreamRing ring;
    auto cursor = ring.join();
    EXPECT_EQ(ring.header(), nullptr);
    EXPECT_EQ(ring.next(cursor), nullptr);
    const std::vector<std::uint8_t> header{1, 2, 3};
    ring.begin(header);
    EXPECT_EQ(*ring.header(), header);
    add_blocks(ring, 0, 30);  // none was taken meanwhile, and a key passed by
    for (std::int64_t n = 0; n < 30; ++n) EXPECT_EQ(next_frame(ring, cursor), n);
    EXPECT_EQ(ring.next(cursor), nullptr);
    EXPECT_FALSE(ring.is_over(cursor));
    add_blocks(ring, 30, 31);
    ring.end();
    EXPECT_FALSE(ring.is_over(cursor));
    EXPECT_EQ(next_frame(ring, cursor), 30);
    EXPECT_TRUE(ring.is_over(cursor));
    EXPECT_EQ(cursor.dropped(), 0);
}

TEST(StreamRing, LateCursorBeginsAtKey) {
    for (std::int64_t there = 1; there < 100; ++there) {
        StreamRing ring;
        add_blocks(ring, 0, there);
        auto cursor = ring.join();
        add_blocks(ring, there, there + 3);
        const auto first = ring.next(cursor);
        ASSERT_TRUE(first);
        EXPECT_TRUE(first->is_key);
        EXPECT_LT(there - 1 - first->frame, 15);
        EXPECT_EQ(next_frame(ring, cursor), first->frame + 1);
        EXPECT_EQ(cursor.dropped(), 0);
    }
}

TEST(StreamRing, GoesToNewestKeyAhead) {
    StreamRing ring;
    add_blocks(ring, 0, 18);
    auto cursor = ring.join();  // 15
    EXPECT_FALSE(ring.go_to_newest_key(cursor));
    EXPECT_EQ(next_frame(ring, cursor), 15);
    EXPECT_FALSE(ring.go_to_newest_key(cursor));
    add_blocks(ring, 18, 32);
    EXPECT_TRUE(ring.has_next(cursor));
    EXPECT_TRUE(ring.go_to_newest_key(cursor));
    EXPECT_EQ(cursor.dropped(), 14);
    EXPECT_EQ(next_frame(ring, cursor), 30);
    EXPECT_EQ(next_frame(ring, cursor), 31);
    EXPECT_FALSE(ring.has_next(cursor));
}

// A cursor that is behind by more than the bound goes on with the newest key; others do not notice.
TEST(StreamRing, SlowCursorMissesWholeFramesets) {
    StreamRing ring({.framesets = 20, .bytes = 1'000'000});
    auto quick = ring.join(), slow = ring.join();
    for (std::int64_t n = 0; n < 20; ++n) {
        add_blocks(ring, n, n + 1);
        EXPECT_EQ(next_frame(ring, quick), n);
    }
    EXPECT_EQ(next_frame(ring, slow), 0);
    add_blocks(ring, 20, 47);
    EXPECT_EQ(next_frame(ring, slow), 45);
    EXPECT_EQ(slow.dropped(), 44);
    EXPECT_EQ(next_frame(ring, slow), 46);
    EXPECT_EQ(next_frame(ring, quick), 45) << "it had taken nothing for 27 either";
    EXPECT_EQ(quick.dropped(), 25);
}

TEST(StreamRing, BoundsBytes) {
    StreamRing ring({.framesets = 1000, .bytes = 10'000});
    auto cursor = ring.join();
    add_blocks(ring, 0, 10, 5, 1000);
    EXPECT_EQ(next_frame(ring, cursor), 0);
    add_blocks(ring, 10, 13, 5, 1000);
    EXPECT_EQ(next_frame(ring, cursor), 10);
    EXPECT_EQ(cursor.dropped(), 9);
    // From the newest key on everything is kept, however large, so that decoding can begin.
    auto late = ring.join();
    add_blocks(ring, 13, 15, 5, 50'000);
    for (std::int64_t n = 10; n < 15; ++n) EXPECT_EQ(next_frame(ring, late), n);
    std::weak_ptr<const StreamMuxer::Block> old;
    {
        auto first = ring.join();
        old = ring.next(first);
    }
    EXPECT_FALSE(old.expired());
    add_blocks(ring, 15, 16, 5, 1000);
    EXPECT_TRUE(old.expired()) << "a key more, and what is before it goes";
}

TEST(StreamRing, WakesWaitingThread) {
    StreamRing ring;
    int woken = 0;
    ring.watch([&woken] { ++woken; });
    std::thread sender([&ring] {
        add_blocks(ring, 0, 3);
        ring.end();
    });
    auto cursor = ring.join();
    for (std::int64_t n = 0; n < 3; ++n) {
        const auto block = ring.wait_next(cursor, long_enough);
        ASSERT_TRUE(block);
        EXPECT_EQ(block->frame, n);
    }
    EXPECT_EQ(ring.wait_next(cursor, long_enough), nullptr);
    EXPECT_TRUE(ring.is_over(cursor));
    sender.join();
    EXPECT_EQ(woken, 4);
}

TEST(StreamUrl, ReadsParts) {
    const auto srt = must(read_stream_url("srt://192.168.0.5:7000?mode=caller&latency=60000"));
    EXPECT_EQ(srt.transport, StreamTransport::srt);
    EXPECT_EQ(srt.host, "192.168.0.5");
    EXPECT_EQ(srt.port, 7000);
    EXPECT_EQ(srt.value("mode"), "caller");
    EXPECT_EQ(srt.value("latency"), "60000");
    EXPECT_EQ(srt.value("late"), "");
    EXPECT_EQ(srt.protocols(), "") << "FFmpeg has no part in it";
    const auto web = must(read_stream_url("https://example.org/a/clip.m3u8?key=1"));
    EXPECT_EQ(web.path, "/a/clip.m3u8");
    EXPECT_EQ(web.port, 443);
    EXPECT_EQ(read_stream_url("http://example.org")->port, 80);
    EXPECT_EQ(read_stream_url("http://0.0.0.0:0/live")->port, 0);
    EXPECT_EQ(web.protocols(), "https,tls,tcp");
    const auto six = must(read_stream_url("tcp://[::1]:0"));
    EXPECT_EQ(six.host, "::1");
    EXPECT_EQ(read_stream_url("-")->text, "pipe:0");
    EXPECT_EQ(read_stream_url("pipe:3")->text, "pipe:3");
}

TEST(StreamUrl, HidesPassphraseInName) {
    EXPECT_EQ(read_stream_url("srt://h:1?passphrase=0123456789&latency=5")->name(),
              "srt://h:1?passphrase=...&latency=5");
    EXPECT_EQ(without_passphrase("srt://h:1?latency=5&passphrase=latency=50"),
              "srt://h:1?latency=5&passphrase=...");
    EXPECT_EQ(without_passphrase("srt://h?Passphrase=0123456789"), "srt://h?Passphrase=...");
    EXPECT_EQ(without_passphrase("http://me:secret@h/a.mkv"), "http://...@h/a.mkv");
    for (const char* const words :
         {"srt://h:99999?passphrase=0123456789", "srt://h:1?passphrase=012345", "http://me:0123456789@h/"}) {
        const auto url = read_stream_url(words);
        ASSERT_FALSE(url) << words;
        EXPECT_EQ(url.error().message.find("01234"), std::string::npos) << url.error().message;
    }
    EXPECT_EQ(without_passphrase("clip.mkv"), "clip.mkv");
}

TEST(TypedPath, IsThatOfFileUrl) {
    EXPECT_EQ(typed_path("file:///a/my%20clip%25.mkv"), "/a/my clip%.mkv");
    EXPECT_EQ(typed_path("file://localhost/a.mkv"), "/a.mkv");
    for (const char* const other :
         {"file://host/a%20b", "file:a%20b", "a%20b.mkv", "tcp://h:1?a=%20", "file:///a%00.mkv", ""})
        EXPECT_EQ(typed_path(other), other);
}

TEST(StreamUrl, RejectsInvalid) {
    for (const char* const words :
         {"tcp://host", "tcp://host:", "tcp://host:65536", "tcp://host:-1", "tcp://host:1x", "tcp://host:1/a",
          "tcp://[::1:5", "tcp://[]:5", "tcp://a b:5", "tcp://u@h:5", "http://", "http:///a", "pipe:x",
          "pipe:-1", "srt://h:5?mode=caller&foo=1", "udp://h:5?latency=1", "tcp://h:5?listen=1", "file:/a",
          "rtmp://h/a"}) {
        EXPECT_TRUE(is_refused(read_stream_url(words), "", ErrorKind::usage)) << words;
    }
    const std::string read = "; streams begin with tcp://, http://, https://, srt://, udp://, pipe:";
    for (const std::string begin : {"rtsp://", "rtmp://", "ws://", "ftp://", "tcp:/"}) {
        EXPECT_TRUE(is_stream_url(begin + "h:1/x")) << begin;
        EXPECT_TRUE(is_refused(read_stream_url(begin + "h:1/x"), ": " + begin + " is not read" + read,
                               ErrorKind::usage));
    }
    EXPECT_TRUE(is_refused(read_stream_url("srt://h:1?latncy=1"),
                           "no setting \"latncy=1\" (did you mean latency?); there are mode, latency, "
                           "passphrase, pbkeylen, streamid",
                           ErrorKind::usage));
    EXPECT_TRUE(test::message(read_stream_url("srt://h:1?latncy=1")).ends_with("streamid"));
    for (const char* const path : {"file:///a/clip.mkv", "C:/clip.mkv", "notes:/clip.mkv", "a/b://c"})
        EXPECT_FALSE(is_stream_url(path)) << path;
    EXPECT_FALSE(is_stream_url("clip.mkv"));
    EXPECT_FALSE(is_stream_url("folder/tcp"));
    EXPECT_TRUE(is_stream_url("tcp://anything"));
}

}  // namespace
}  // namespace touchable
