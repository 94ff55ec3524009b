// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <malloc.h>

#include <array>
#include <atomic>
#include <chrono>
#include <limits>
#include <map>
#include <memory>
#include <new>
#include <stop_token>
#include <thread>
#include <vector>

#include "engine/base/threads.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/clip_choice.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/limits.hpp"
#include "tests/must.hpp"
#include "tests/player/in_process.hpp"
#include "tests/sweep.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

/// A device that is pulled out in the middle.
class PulledOut final : public HapticPort {
public:
    explicit PulledOut(std::int64_t tick = 20) : tick_(tick) {}
    bool read_goals(std::int64_t tick, const HeightField&, std::span<glm::dvec3> goals) override {
        for (glm::dvec3& goal : goals) goal = {0, 0, 0};
        is_out = is_out || tick >= tick_;
        return !is_out;
    }
    bool write_forces(std::span<const glm::dvec3>) override { return !is_out; }
    std::atomic<bool> is_out{false};

private:
    const std::int64_t tick_;
};

/// A file that cannot be written from then on.
class FailsThen final : public TouchSink {
public:
    explicit FailsThen(const PulledOut& port) : port_(port) {}
    Result<void> consume(const TouchTick&) override {
        while (!port_.is_out) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        has_failed = true;
        return input_error("the disk is full");
    }
    bool has_failed = false;

private:
    const PulledOut& port_;
};

/// A person ends the run once it has begun.
class StopsRun final : public TouchSink {
public:
    Result<void> consume(const TouchTick&) override {
        asked.request_stop();
        return {};
    }
    std::stop_source asked;
};

std::unique_ptr<TouchSetup> setup_of_globe(const TemporaryFolder& folder) {
    SessionOptions options;
    options.clip.file = folder / "clip.mkv";
    options.live = true;
    must(write_generated_clip("globe", options.clip.file, {.width = 32, .height = 24, .properties = true},
                              30));
    return must(setup_from_options(options));
}

TEST(LiveSession, ReportsFaultThatEndedIt) {
    const TemporaryFolder folder;
    const auto setup = setup_of_globe(folder);
    TouchSetup& s = *setup;
    PulledOut port;
    FailsThen sink(port);
    TouchSink* const sinks[] = {&sink};
    LiveSession session(*s.feed, port, *s.solver, s.options);
    ASSERT_TRUE(session.run(sinks)) << "what was touched until then counts";
    ASSERT_TRUE(sink.has_failed);
    ASSERT_TRUE(session.facts().failure);
    EXPECT_EQ(session.facts().failure->kind, ErrorKind::device) << session.facts().failure->message;
}

TEST(LiveSession, KeepsInterruptedRun) {
    const TemporaryFolder folder;
    const auto setup = setup_of_globe(folder);
    TouchSetup& s = *setup;
    PulledOut port(std::numeric_limits<std::int64_t>::max());
    StopsRun sink;
    TouchSink* const sinks[] = {&sink};
    LiveSession session(*s.feed, port, *s.solver, s.options);
    const StopScope until(sink.asked.get_token());
    ASSERT_TRUE(session.run(sinks)) << "what was touched until then counts";
    EXPECT_TRUE(session.facts().interrupted);
    EXPECT_GT(session.facts().loop.ticks, 0);
}

// Tracks of large pictures are decoded on threads of their own: the reader may be slow, fast, or gone.

constexpr Planes ramps{true, false, false, false};
constexpr int clip_frames = 17;

class DecodingThreads : public ::testing::TestWithParam<Archive> {
protected:
    void SetUp() override {
        scene_ = small_scene(320, 160, 16);  // large enough for threads
        ASSERT_EQ(message(write_clip(file(), scene_, clip_frames, ramps, {GetParam(), true})), "");
    }
    std::filesystem::path file() const { return folder_ / "clip.mkv"; }
    std::unique_ptr<ClipReader> open() const {
        auto reader = open_clip(file());
        EXPECT_EQ(message(reader), "");
        return reader ? std::move(*reader) : nullptr;
    }
    void expect_frames(ClipReader& reader, int from, int to) const {
        for (int n = from; n < to; ++n) {
            const auto frame = reader.next();
            ASSERT_EQ(message(frame), "");
            ASSERT_TRUE(frame->has_value()) << n;
            EXPECT_TRUE(same_frame(**frame, test_frame(scene_, n, ramps))) << n;
        }
    }

    TemporaryFolder folder_;
    Scene scene_;
};

TEST_P(DecodingThreads, ServeSlowAndFastReaders) {
    const auto fast = open(), slow = open();
    ASSERT_TRUE(fast && slow);
    expect_frames(*fast, 0, clip_frames);
    for (int n = 0; n < 6; ++n) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        expect_frames(*slow, n, n + 1);
    }
    EXPECT_FALSE((*fast->next()).has_value());
}

TEST_P(DecodingThreads, EndWithTheirReader) {
    for (int read = 0; read < 4; ++read) expect_frames(*open(), 0, read);
}

TEST_P(DecodingThreads, RestartAfterSeek) {
    const auto reader = open();
    for (const int from : {12, 3, 14, 0}) {
        ASSERT_EQ(message(reader->seek(from)), "");
        expect_frames(*reader, from, from + 3);
    }
}

TEST_P(DecodingThreads, ReportDamagedFrame) {
    std::string bytes = read_bytes(file());
    bytes[bytes.size() * 9 / 10] ^= 0x08;
    write_bytes(file(), bytes);
    const auto reader = open();
    ASSERT_TRUE(reader);
    const Result<std::vector<RawFrame>> frames = test::read_all(static_cast<ClipReader&>(*reader));
    EXPECT_NE(message(frames).find("is damaged"), std::string::npos) << message(frames);
    EXPECT_NE(message(reader->next()), "");  // and goes on telling
}

INSTANTIATE_TEST_SUITE_P(, DecodingThreads, ::testing::Values(Archive::fast, Archive::small),
                         [](const auto& archive) {
                             return std::string(archive.param == Archive::fast ? "Fast" : "Small");
                         });

// The threads of a live session's frames when the machine has nothing more to give, and when commands lead
// elsewhere than where they had read ahead.

/// A clip that takes all the memory there is.
class Insatiable final : public OwnClip {
public:
    Insatiable() : OwnClip({}, 3) {
        scene_.width = 720;
        scene_.height = 480;
    }
    Result<std::optional<RawFrame>> next() override {
        refuse_allocations();
        throw std::bad_alloc();
    }
};

TEST(FeedThreads, ReportExhaustedMemory) {
    auto reader = std::make_unique<Insatiable>();
    const Scene scene = reader->scene();
    SurfaceFeed feed(std::move(reader), make_reference_builder(scene), scene);
    FeedThreads threads(
        feed, [](const RawFrame&) { return false; }, PlaybackClock(FrameRate{}),
        [] { return MediaMoment{}; });
    ASSERT_TRUE(threads.start());
    while (!threads.error()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    threads.stop();
    EXPECT_EQ(threads.error()->kind, ErrorKind::input);
    EXPECT_EQ(threads.error()->message, "memory does not suffice for frames of 720x480 pixels");
}

/// Pictures of two pixels, 30 a second, whose number is their depth.
class Numbered final : public OwnClip {
public:
    explicit Numbered(std::int64_t count = frames) : OwnClip({}, count) {
        scene_.width = 2;
        scene_.height = 1;
        scene_.camera = {1, 1, 1, 0.5};
        scene_.depth.code_max = scene_.depth.valid_max = 255;
        scene_.depth.near = 100;
        scene_.depth.far = 300;
    }
    Result<void> seek(std::int64_t frame) override {
        number_ = frame;
        return {};
    }
    Result<std::optional<RawFrame>> next() override {
        if (number_ == count_) return std::optional<RawFrame>();
        auto pixels = std::make_shared<std::vector<std::uint8_t>>(2, static_cast<std::uint8_t>(number_ + 1));
        RawFrame raw;
        raw.number = number_;
        raw.time_ns = scene_.rate.time_ns(number_++);
        raw.depth = {pixels->data(), 2, 2, 1, 1, 1};
        raw.storage = std::move(pixels);
        ++read;
        return std::optional(std::move(raw));
    }
    static constexpr std::int64_t frames = 60;
    std::atomic<int> read{0};
};

TEST(SurfaceFeed, MemoryStaysConstant) {
    constexpr std::int64_t some = 1000, frames = 60'000;  // half an hour
    auto reader = std::make_unique<Numbered>(frames);
    const Scene scene = reader->scene();
    SurfaceFeed feed(std::move(reader), make_reference_builder(scene), scene);
    feed.leave_out_hash();
    const auto feed_up_to = [&](std::int64_t end) {
        for (std::int64_t n = feed.frames(); n < end; ++n)
            ASSERT_TRUE(feed.pair_at(scene.rate.time_ns(n - 1)));
    };
    feed_up_to(some);
    const auto taken = [] { return mallinfo2().uordblks + mallinfo2().hblkhd; };
    const auto before = taken();
    feed_up_to(frames);
    EXPECT_LT(taken(), before + 65536) << "after " << feed.frames() << " frames";
    EXPECT_GT(feed.read_ms().spread().max, 0);
    feed.forget_times();
    EXPECT_EQ(feed.build_ms().spread().max, 0);
}

/// A hand that the test moves from tick to tick, in a loop of frames 3 to 6.
class LoopedFeed : public testing::Test {
protected:
    LoopedFeed() {
        log->take(0);
        go_to(0);
        EXPECT_TRUE(threads.start());
    }
    void go_to(std::int64_t tick) {
        tick_ = tick;
        log->take(tick);
        board.set(clock.state_at(tick));
        threads.look_at_commands();
    }
    /// Waits until the hand holds these frames.
    void expect_held(std::uint64_t epoch, std::int64_t prev, std::int64_t next) {
        FramePair pair;
        for (int k = 0; k < 20000; ++k) {
            if (timeline().pair_at(board.moment(), pair) && pair.epoch == epoch && pair.prev.number == prev &&
                pair.next.number == next)
                return;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        FAIL() << "at tick " << tick_ << ": " << pair.epoch << ", " << pair.prev.number << ", "
               << pair.next.number;
    }
    /// More has been read than frames 0 to 6: from the loop's begin, which the hand has not come to.
    void expect_way_back_read() {
        for (int k = 0; k < 20000 && reader->read < 9; ++k)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ASSERT_GE(reader->read, 9);
    }
    SurfaceTimeline& timeline() { return feed.timeline(); }

    static constexpr std::int64_t ms = 1'000'000;
    Numbered* reader = new Numbered;
    std::shared_ptr<PlaybackLog> log = std::make_shared<PlaybackLog>(
        std::vector<PlaybackCommand>{{0, PlaybackVerb::loop, 100 * ms, 200 * ms}}, 8);
    PlaybackClock clock{{30, 1}, log};
    PlaybackBoard board;
    SurfaceFeed feed{std::unique_ptr<ClipReader>(reader), make_reference_builder(reader->scene()),
                     reader->scene()};
    FeedThreads threads{feed, [](const RawFrame&) { return false; }, clock,
                        [this] { return board.moment(); }};

private:
    std::int64_t tick_ = 0;
};

TEST_F(LoopedFeed, LoopsFrames) {
    for (const auto& [tick, epoch, prev, next] : {std::array{0, 0, 0, 1},
                                                  {150, 0, 4, 5},
                                                  {199, 0, 5, 6},
                                                  {200, 1, 3, 4},
                                                  {299, 1, 5, 6},
                                                  {310, 2, 3, 4}}) {
        go_to(tick);
        expect_held(static_cast<std::uint64_t>(epoch), prev, next);
    }
}

TEST_F(LoopedFeed, UnloopDiscardsPrefetchedLoopStart) {
    go_to(150);
    expect_held(0, 4, 5);
    expect_way_back_read();
    ASSERT_TRUE(log->ask(PlaybackVerb::unloop, 0, 0));
    for (const std::int64_t tick : {151, 210, 250, 300}) {
        go_to(tick);
        expect_held(0, tick * 30 / 1000, tick * 30 / 1000 + 1);
    }
    EXPECT_EQ(feed.dropped_frames(), 0);
}

TEST_F(LoopedFeed, SeekDiscardsPrefetchedLoopStart) {
    go_to(150);
    expect_held(0, 4, 5);
    expect_way_back_read();
    ASSERT_TRUE(log->ask(PlaybackVerb::seek, 20 * 1000 * ms / 30, 0));
    ASSERT_TRUE(log->ask(PlaybackVerb::unloop, 0, 0));
    go_to(160);
    expect_held(1, 20, 21);
    threads.stop();
    for (const FrameRun& run : feed.built()) EXPECT_TRUE(run.first == 0 || run.first >= 20) << run.first;
}

TEST_F(LoopedFeed, SeeksToLastFrame) {
    ASSERT_TRUE(log->ask(PlaybackVerb::pause, 0, 0));
    ASSERT_TRUE(log->ask(PlaybackVerb::seek, 1999 * ms, 0));
    go_to(50);
    expect_held(1, 59, 59);
    ASSERT_TRUE(log->ask(PlaybackVerb::seek, 0, 0));
    go_to(60);
    expect_held(2, 0, 1);
}

// The haptic thread's part.
TEST_F(LoopedFeed, TakesCommandsWithoutAllocation) {
    for (const auto verb : {PlaybackVerb::seek, PlaybackVerb::step, PlaybackVerb::unloop})
        ASSERT_TRUE(log->ask(verb, 0, 0));
    const std::size_t before = allocations();
    for (std::int64_t tick = 1; tick < 100; ++tick) {
        log->take(tick);
        board.set(clock.state_at(tick));
    }
    EXPECT_EQ(allocations(), before);
    EXPECT_EQ(board.moment().epoch, 1U);
}

// A clip that is opened once for several runs over it.

constexpr std::int64_t shared_frames = 200;

/// The fate of a clip's frames.
struct ReadFrames {
    int opened = 0;
    std::map<std::int64_t, int> times;  ///< reads of each frame
    std::vector<std::weak_ptr<const void>> storages;
    std::int64_t fails_at = -1;

    int most() const {
        int most = 0;
        for (const auto& [frame, count] : times) most = std::max(most, count);
        return most;
    }
    int in_memory() const {
        int count = 0;
        for (const auto& storage : storages) count += !storage.expired();
        return count;
    }
};

/// Pictures whose number is their depth; `width` makes them large, in words alone.
class Counted final : public OwnClip {
public:
    Counted(ReadFrames& read, int width) : OwnClip({}, shared_frames), read_(read) { scene_.width = width; }
    UnstatedFilters unstated_filters() const override { return {.median = true}; }
    Result<void> seek(std::int64_t frame) override {
        number_ = frame;
        return {};
    }
    Result<std::optional<RawFrame>> next() override {
        if (number_ == shared_frames) return std::optional<RawFrame>();
        if (stop_requested()) return interrupted_error();
        if (number_ == read_.fails_at) {
            number_ = -1;  // the position is unknown
            return input_error("frame " + std::to_string(read_.fails_at) + " is damaged");
        }
        ++read_.times[number_];
        auto pixel = std::make_shared<std::uint8_t>(static_cast<std::uint8_t>(number_));
        RawFrame raw;
        raw.number = number_++;
        raw.depth = {pixel.get(), scene_.width, 1, 1, 1, scene_.width};
        read_.storages.push_back(pixel);
        raw.storage = std::move(pixel);
        return std::optional(std::move(raw));
    }

private:
    ReadFrames& read_;
};

class ClipSharing : public testing::Test {
protected:
    std::unique_ptr<ClipReader> reader(int width = 1) {
        auto opened = shared_->open([this, width]() -> Result<std::unique_ptr<ClipReader>> {
            ++read_.opened;
            return std::unique_ptr<ClipReader>(std::make_unique<Counted>(read_, width));
        });
        EXPECT_TRUE(opened);
        return std::move(*opened);
    }
    static void expect_frames(ClipReader& reader, std::int64_t first, std::int64_t end) {
        for (std::int64_t n = first; n < end; ++n) {
            const auto frame = reader.next();
            ASSERT_TRUE(frame && *frame) << n;
            ASSERT_EQ((*frame)->number, n);
            ASSERT_EQ(*(*frame)->depth.row(0), n);
        }
    }

    ReadFrames read_;
    std::shared_ptr<SharedClip> shared_ = std::make_shared<SharedClip>();
};

TEST_F(ClipSharing, SecondRunReusesDecodedFrames) {
    auto before = reader();
    expect_frames(*before, 0, 60);
    auto next = reader();
    ASSERT_TRUE(next->seek(40));   // by a filter that remembers: frames before its beginning
    expect_frames(*next, 40, 70);  // beyond what the other one has read
    expect_frames(*before, 60, 75);
    before.reset();
    expect_frames(*next, 70, shared_frames);
    EXPECT_FALSE(next->next()->has_value());
    EXPECT_TRUE(next->unstated_filters().median) << "as the clip itself leaves it open";
    EXPECT_EQ(read_.opened, 1);
    EXPECT_EQ(read_.most(), 1);
    ASSERT_TRUE(next->rewind());
    expect_frames(*next, 0, 20);
    EXPECT_FALSE(next->seek(shared_frames + 1));
    EXPECT_FALSE(next->seek(-1));
}

// Both runs share the decoded frames: a clip that was left in the middle of a frame would be damaged for
// both.
TEST_F(ClipSharing, CancelledRunFinishesItsFrame) {
    const auto other = reader();
    auto run = reader();
    std::stop_source given_up;
    given_up.request_stop();
    const StopScope until(given_up.get_token());
    expect_frames(*run, 0, 5);
}

TEST_F(ClipSharing, ReadersSeekIndependently) {
    std::vector<std::unique_ptr<ClipReader>> readers;
    std::vector<std::int64_t> at{0, 0, 0};
    for (std::size_t k = 0; k < at.size(); ++k) readers.push_back(reader());
    Random random(3);
    for (int turn = 0; turn < 500; ++turn) {
        const auto k = static_cast<std::size_t>(random.below(3));
        if (random.below(8) == 0) {
            at[k] = random.below(shared_frames);
            ASSERT_TRUE(readers[k]->seek(at[k]));
        }
        const std::int64_t end = std::min<std::int64_t>(at[k] + random.below(5), shared_frames);
        ASSERT_NO_FATAL_FAILURE(expect_frames(*readers[k], at[k], end));
        at[k] = end;
    }
}

TEST_F(ClipSharing, KeepsFirstFramesForSurvey) {
    auto before = reader();
    expect_frames(*before, 0, 100);
    expect_frames(*reader(), 0, DepthEstimator::frames);
    EXPECT_EQ(read_.most(), 1);
    expect_frames(*before, 100, 110);
    EXPECT_EQ(read_.most(), 1) << "the run that goes on reads on";
    shared_->forget_first_frames();
    expect_frames(*reader(), 0, DepthEstimator::frames);
    EXPECT_EQ(read_.most(), 2);
}

TEST_F(ClipSharing, LimitsFramesInMemory) {
    expect_frames(*reader(), 0, 150);
    EXPECT_EQ(read_.in_memory(), 32 + DepthEstimator::frames);
    for (const auto& [bytes, kept] :
         {std::pair{50 << 20, 12}, {83 << 20, 12}, {300 << 20, 3}, {700 << 20, 2}}) {
        read_ = {};
        shared_ = std::make_shared<SharedClip>();
        expect_frames(*reader(bytes), 0, 100);
        EXPECT_EQ(read_.in_memory(), kept) << bytes;
    }
}

// Otherwise the run before and the one that takes its place, by a filter that remembers, take turns at one
// decoder, each by a seek.
TEST_F(ClipSharing, DecodesEachFrameOnce) {
    constexpr int with_all_planes = 1920 * 1080 * (2 + 3 + 3 + 1);
    auto before = reader(with_all_planes);
    expect_frames(*before, 0, 60);
    auto next = reader(with_all_planes);
    ASSERT_TRUE(next->seek(60 - 12 - 16));
    for (int turn = 0; turn < 40; ++turn) {
        expect_frames(*next, 32 + turn, 33 + turn);
        expect_frames(*before, 60 + turn, 61 + turn);
    }
    EXPECT_EQ(read_.most(), 1);
}

TEST_F(ClipSharing, SeeksPastDamage) {
    read_.fails_at = 20;
    auto before = reader();
    expect_frames(*before, 0, 20);
    const auto damaged = before->next();
    ASSERT_FALSE(damaged);
    EXPECT_EQ(damaged.error().message, "frame 20 is damaged");
    auto next = reader();
    ASSERT_TRUE(next->seek(18));
    expect_frames(*next, 18, 20);
    EXPECT_FALSE(next->next());
    ASSERT_TRUE(next->seek(21));
    expect_frames(*next, 21, 30);
}

TEST_F(ClipSharing, RetriesFailedOpen) {
    const auto refused =
        shared_->open([]() -> Result<std::unique_ptr<ClipReader>> { return input_error("not there yet"); });
    ASSERT_FALSE(refused);
    expect_frames(*reader(), 0, 3);
}

TEST(CameraFilm, HasNoFramesOnceBroken) {
    const TemporaryFolder folder;
    CameraCapture film{SceneDescription(small_scene(32, 24))};
    ASSERT_TRUE(film.open(folder / "film.mkv", Existing::keep));
    ASSERT_TRUE(film.keep(test_frame(small_scene(16, 12), 0, {})));  // cannot be written: another size
    EXPECT_TRUE(film.finish());
    EXPECT_TRUE(film.fault());
    EXPECT_TRUE(film.frames().empty());
}

TEST(CameraChoice, ReplayNamesClip) {
    const auto camera = must(read_live_camera("replay:takes/clip.mkv,fps=15"));
    ClipChoice choice;
    choice.choose(camera);
    EXPECT_EQ(choice.file, "takes/clip.mkv");
    EXPECT_TRUE(choice.is_camera());
}

TEST_F(ClipSharing, ServesTwoThreads) {
    auto a = reader(), b = reader();
    std::thread beside([&] { expect_frames(*b, 0, shared_frames); });
    expect_frames(*a, 0, shared_frames);
    beside.join();
}

}  // namespace
}  // namespace touchable::test
