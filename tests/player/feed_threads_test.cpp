// The threads of a live session's frames when the machine has nothing more to give, and when commands lead
// elsewhere than where they had read ahead.
#include "player/run/feed_threads.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <array>
#include <atomic>
#include <chrono>
#include <new>
#include <thread>

#include "player/run/playback.hpp"
#include "tests/frame/allocations.hpp"

namespace touchable::test {
namespace {

/// A clip that takes all the memory there is.
class Insatiable final : public ClipReader {
public:
    Insatiable() {
        scene_.width = 720;
        scene_.height = 480;
    }
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override { return 3; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<void> rewind() override { return {}; }
    Result<std::optional<RawFrame>> next() override {
        refuse_allocations();
        throw std::bad_alloc();
    }

private:
    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
};

TEST(FeedThreads, MemoryThatIsGoneIsSaidWithoutMoreOfIt) {
    auto reader = std::make_unique<Insatiable>();
    const Scene scene = reader->scene();
    SurfaceFeed feed(std::move(reader), make_reference_builder(scene), scene);
    FeedThreads threads(feed, [](const RawFrame&) { return false; });
    ASSERT_TRUE(threads.start());
    while (!threads.error()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    threads.stop();
    EXPECT_EQ(threads.error()->kind, ErrorKind::input);
    EXPECT_EQ(threads.error()->message, "memory does not suffice for frames of 720x480 pixels");
}

/// Pictures of two pixels, 30 a second, whose number is their depth.
class Numbered final : public ClipReader {
public:
    explicit Numbered(std::int64_t count = frames) : count_(count) {
        scene_.width = 2;
        scene_.height = 1;
        scene_.camera = {1, 1, 1, 0.5};
        scene_.depth.code_max = scene_.depth.valid_max = 255;
        scene_.depth.near = 100;
        scene_.depth.far = 300;
    }
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override { return count_; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<void> rewind() override { return seek(0); }
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

private:
    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    const std::int64_t count_;
    std::int64_t number_ = 0;
};

TEST(SurfaceFeed, MemoryDoesNotGrowWithTheRun) {
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
class Guided : public testing::Test {
protected:
    Guided() {
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
    /// What the hand holds, once it is that.
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

TEST_F(Guided, GoesRoundALoop) {
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

TEST_F(Guided, GoesOnBeyondALoopWhoseWayBackWasReadAlready) {
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

TEST_F(Guided, GoesElsewhereThanToTheWayBackThatWasRead) {
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

TEST_F(Guided, OfTheLastFrameAloneThereIsAnEnd) {
    ASSERT_TRUE(log->ask(PlaybackVerb::pause, 0, 0));
    ASSERT_TRUE(log->ask(PlaybackVerb::seek, 1999 * ms, 0));
    go_to(50);
    expect_held(1, 59, 59);
    ASSERT_TRUE(log->ask(PlaybackVerb::seek, 0, 0));
    go_to(60);
    expect_held(2, 0, 1);
}

// The haptic thread's part.
TEST_F(Guided, CommandsAreTakenWithoutAllocation) {
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

}  // namespace
}  // namespace touchable::test
