#include "engine/stream/sending.hpp"

#include <gtest/gtest.h>

#include <map>

#include "engine/clip/tracks.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t sender_ms = 1'000'000, sender_utc_ns = 1'800'000'000'000'000'000;

/// Passes while somebody waits, or where it is told to.
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
class MadeClip final : public ClipReader {
public:
    MadeClip(const Scene& scene, int frames, VirtualTime* camera_time = nullptr)
        : scene_(scene), frames_(frames), camera_time_(camera_time) {}
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override { return std::nullopt; }
    const std::vector<std::string>& notes() const override { return notes_; }
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
    Result<void> rewind() override {
        number_ = 0;
        return {};
    }
    bool is_live() const override { return camera_time_ != nullptr; }
    Result<void> begin(std::chrono::steady_clock::time_point zero) override {
        begun_ns_ = std::chrono::nanoseconds(zero.time_since_epoch()).count();
        return {};
    }

    std::vector<std::int64_t> times;
    std::int64_t delay_ns = 0;  // from when a frame is taken to when it is there

private:
    const Scene scene_;
    const int frames_;
    VirtualTime* const camera_time_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    std::int64_t number_ = 0, begun_ns_ = 0;
};

/// Of which nothing but what it was told is a block's content.
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

TEST(StreamSender, FramesGoAtTheClipsTimes) {
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

TEST(StreamSender, KeysAreNeverFarApart) {
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

// Whenever somebody comes, the first frameset that they are given is a key not half a second old.
TEST(StreamSender, WhoComesLateBeginsAtOnce) {
    for (const std::int64_t rate : {5, 30, 60}) {
        Sent sent;
        const Scene scene = scene_of_rate(rate);
        std::int64_t joined = 0;
        sent.ring.watch([&] {
            auto late = sent.ring.join();
            const auto first = sent.ring.next(late);
            if (!first) return;
            EXPECT_TRUE(first->is_key);
            const auto& note = sent.notes[static_cast<std::size_t>(first->frame)];
            EXPECT_LE(sent.notes.back().time_ns - note.time_ns, 500 * sender_ms);
            ++joined;
        });
        ASSERT_EQ(message(sent.send(std::make_unique<MadeClip>(scene, 100))), "");
        EXPECT_EQ(joined, 101) << "after each frameset, and the end";
    }
}

TEST(StreamSender, ALoopGoesOnInNumbersAndTimes) {
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

TEST(StreamSender, ACamerasFramesGoAtOnceAndSayWhenTheyWereTaken) {
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

TEST(StreamSender, ASteppedClockIsBelieved) {
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
TEST(StreamSender, WhoWasHeldUpDoesNotMakeUpForIt) {
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

TEST(StreamSender, EndsWhenItIsTold) {
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

TEST(StreamSender, AClipOfNoFramesEndsALoopToo) {
    Sent sent;
    ASSERT_EQ(message(sent.send(std::make_unique<MadeClip>(scene_of_rate(30), 0), {.loop = true})), "");
    EXPECT_EQ(sent.figures.framesets, 0);
}

// What a listener in a loop saves is a clip of all rounds, from the key on at which it came.
TEST(StreamSender, RoundsOfALoopAreOneClip) {
    const TemporaryFolder folder;
    const Scene scene = scene_of_rate(30);
    VirtualTime time;
    StreamRing ring({.framesets = 1000});
    auto first = ring.join();
    auto muxer = open_matroska_stream(scene);
    ASSERT_EQ(message(muxer), "");
    std::vector<StreamSender::Channel> channels;
    channels.push_back({std::move(*muxer), ring});
    StreamSender sender(std::make_unique<MadeClip>(scene, 7), std::move(channels),
                        {.loop = true, .longest_ns = 1'000 * sender_ms}, time);
    ASSERT_EQ(message(sender.run()), "");
    std::string bytes(ring.header()->begin(), ring.header()->end());
    while (const auto block = ring.next(first)) bytes.append(block->bytes.begin(), block->bytes.end());
    write_bytes(folder / "rounds.mkv", bytes);
    const auto read = read_clip(folder / "rounds.mkv");
    ASSERT_EQ(message(read), "");
    ASSERT_EQ(read->size(), 30U);
    for (std::int64_t n = 0; n < 30; ++n) {
        const RawFrame sent = test_frame(scene, n % 7, {false, true, false, false});
        EXPECT_TRUE(same_touch_planes((*read)[static_cast<std::size_t>(n)], sent)) << n;
    }
}

}  // namespace
}  // namespace touchable::test
