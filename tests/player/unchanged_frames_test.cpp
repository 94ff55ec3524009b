#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "player/run/surface_feed.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

// A frame in which nothing that can be touched has changed is the one before once more; and in virtual time
// frames are begun before they are asked for, where their builder works at several.
namespace touchable::test {
namespace {

constexpr int width = 20, height = 12;

struct Planes {
    std::vector<std::uint8_t> depth = std::vector<std::uint8_t>(width * height, 100);
    std::vector<std::uint8_t> haptic = std::vector<std::uint8_t>(3 * width * height, 7);
    std::vector<std::uint8_t> heights = std::vector<std::uint8_t>(width * height, 3);
    std::vector<std::uint8_t> colour = std::vector<std::uint8_t>(3 * width * height, 50);
};

Scene small_scene() {
    Scene scene;
    scene.width = width;
    scene.height = height;
    scene.camera = {20, 20, 9.5, 5.5};
    scene.depth.code_max = 255;
    scene.depth.near = 100;
    scene.depth.far = 200;
    return scene;
}

class Planned final : public ClipReader {
public:
    /// `fails_at`: the frame that cannot be read.
    explicit Planned(std::vector<Planes> frames, std::int64_t fails_at = -1)
        : scene_(small_scene()), frames_(std::move(frames)), fails_at_(fails_at) {}
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override {
        return static_cast<std::int64_t>(frames_.size());
    }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<void> rewind() override {
        number_ = 0;
        return {};
    }
    Result<std::optional<RawFrame>> next() override {
        if (number_ == static_cast<std::int64_t>(frames_.size())) return std::optional<RawFrame>();
        if (number_ == fails_at_) return input_error("the disk is out");
        // Each frame in memory of its own, which is gone once nobody holds it.
        auto planes = std::make_shared<Planes>(frames_[static_cast<std::size_t>(number_)]);
        RawFrame raw;
        raw.number = number_;
        raw.time_ns = scene_.rate.time_ns(number_);
        raw.depth = {planes->depth.data(), width, width, height, 1, 1};
        raw.haptic = {planes->haptic.data(), 3 * width, width, height, 1, 3};
        raw.height = {planes->heights.data(), width, width, height, 1, 1};
        raw.colour = {planes->colour.data(), 3 * width, width, height, 1, 3};
        raw.storage = std::move(planes);
        ++number_;
        return std::optional<RawFrame>(std::move(raw));
    }

private:
    Scene scene_;
    std::vector<Planes> frames_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    const std::int64_t fails_at_;
    std::int64_t number_ = 0;
};

class Counting final : public SurfaceBuilder {
public:
    explicit Counting(int& built, const Scene& scene = small_scene())
        : built_(built), builder_(make_reference_builder(scene)) {}
    std::string_view name() const override { return "counting"; }
    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        ++built_;
        return builder_->build(raw, out);
    }

private:
    int& built_;
    std::unique_ptr<SurfaceBuilder> builder_;
};

TEST(UnchangedFrames, AreNotBuiltAgain) {
    Planes still, new_colour, new_haptic, new_depth, new_height;
    new_colour.colour[5] = 1;
    new_haptic.haptic.back() = 8;
    new_depth = new_haptic;
    new_depth.depth.back() = 101;
    new_height = new_depth;
    new_height.heights.front() = 4;
    int built = 0;
    SurfaceFeed feed(std::make_unique<Planned>(std::vector{still, still, new_colour, new_haptic, new_depth,
                                                           new_depth, new_height, still}),
                     std::make_unique<Counting>(built), small_scene());
    const Scene scene = small_scene();
    const std::vector<int> built_by{1, 1, 1, 2, 3, 3, 4, 5};
    const SurfaceFrame* before = nullptr;
    for (std::int64_t n = 0; n < 8; ++n) {
        const auto pair = feed.pair_at(scene.rate.time_ns(n));
        ASSERT_TRUE(pair);
        EXPECT_EQ(pair->prev.number, n);
        EXPECT_EQ(pair->prev.time_ns, scene.rate.time_ns(n));
        const auto k = static_cast<std::size_t>(n);
        EXPECT_EQ(pair->prev.frame == before, n > 0 && built_by[k] == built_by[k - 1]) << n;
        EXPECT_EQ(pair->prev.frame->codes[width * height - 1], n >= 4 && n < 7 ? 101 : 100) << n;
        EXPECT_EQ(built, built_by[std::min(k + 1, built_by.size() - 1)]) << "with the frame after";
        before = pair->prev.frame;
    }
    EXPECT_EQ(feed.frames(), 8);
    EXPECT_EQ(feed.unchanged_frames(), 3);
    EXPECT_EQ(feed.end_ns(), scene.rate.time_ns(8));
}

// From 100 to 101 levels: what is shown nears the new one frame by frame, though nothing in the clip changes.
TEST(UnchangedFrames, AreBuiltAgainByATemporalFilterBecauseItSettles) {
    Scene scene = small_scene();
    scene.filter.temporal = true;
    scene.filter.temporal_noise = {1, 0};
    Planes still, moved;
    moved.depth.assign(moved.depth.size(), 101);
    int built = 0;
    SurfaceFeed feed(std::make_unique<Planned>(std::vector{still, still, moved, moved, moved, moved}),
                     std::make_unique<Counting>(built, scene), scene);
    const int expected[] = {0, 0, 32, 56, 74, 87};
    for (std::int64_t n = 0; n < 6; ++n) {
        const auto pair = feed.pair_at(scene.rate.time_ns(n));
        ASSERT_TRUE(pair);
        EXPECT_EQ(pair->prev.frame->codes[0], 126 * 100 + expected[n]) << n;
    }
    EXPECT_EQ(built, 6);
    EXPECT_EQ(feed.unchanged_frames(), 0);
}

// More of them than the timeline has entries, with a hand that does not move on.
TEST(UnchangedFrames, WaitForTheHandLikeOthers) {
    int built = 0;
    SurfaceFeed feed(std::make_unique<Planned>(std::vector<Planes>(60)), std::make_unique<Counting>(built),
                     small_scene());
    int published = 0;
    auto raw = feed.read_next();
    while (raw && *raw) {
        const auto done = feed.publish(**raw);
        ASSERT_TRUE(done);
        if (!*done) break;
        ++published;
        raw = feed.read_next();
    }
    EXPECT_GT(published, 3);
    EXPECT_LT(published, 60);
    EXPECT_EQ(built, 1);
    FramePair pair;
    ASSERT_TRUE(feed.timeline().pair_at((*raw)->raw.time_ns, pair));
    const auto later = feed.publish(**raw);
    EXPECT_TRUE(later && *later);
}

/// Works at three frames, which it builds when they are finished.
class ThreeAtOnce final : public SurfaceBuilder {
public:
    explicit ThreeAtOnce(std::size_t& most) : most_(most) {}
    std::string_view name() const override { return "three"; }
    int frames_in_flight() const override { return 3; }
    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        EXPECT_TRUE(begun_.empty());
        return builder_->build(raw, out);
    }
    Result<void> begin(const RawFrame& raw) override {
        begun_.push_back(raw);
        most_ = std::max(most_, begun_.size());
        return {};
    }
    Result<void> finish(SurfaceFrame& out) override {
        const RawFrame raw = std::move(begun_.front());
        begun_.pop_front();
        return builder_->build(raw, out);
    }

private:
    std::size_t& most_;
    std::unique_ptr<SurfaceBuilder> builder_ = make_reference_builder(small_scene());
    std::deque<RawFrame> begun_;
};

/// Frames of which the first are each the one before once more or another one in turn.
std::vector<Planes> some_frames() {
    std::vector<Planes> frames(9);
    for (std::size_t n = 0; n < frames.size(); ++n)
        frames[n].depth.back() = static_cast<std::uint8_t>(100 + 3 * (n < 4 ? n / 2 : n));
    return frames;
}

TEST(FramesAhead, GiveTheSamePairsInEveryEpoch) {
    const Scene scene = small_scene();
    std::size_t most = 0;
    int built = 0;
    SurfaceFeed ahead(std::make_unique<Planned>(some_frames()), std::make_unique<ThreeAtOnce>(most), scene),
        plain(std::make_unique<Planned>(some_frames()), std::make_unique<Counting>(built), scene);
    ahead.work_ahead();
    const auto compare = [&](const MediaMoment& moment) {
        const auto a = ahead.pair_at(moment), b = plain.pair_at(moment);
        ASSERT_TRUE(a && b);
        EXPECT_EQ(a->prev.number, b->prev.number);
        EXPECT_EQ(a->next.number, b->next.number);
        EXPECT_EQ(a->epoch, b->epoch);
        EXPECT_EQ(a->prev.frame->codes, b->prev.frame->codes) << b->prev.number;
        EXPECT_EQ(a->next.frame->codes, b->next.frame->codes) << b->next.number;
    };
    const auto time = [&](std::int64_t frame) { return scene.rate.time_ns(frame); };
    for (std::int64_t n = 0; n < 4; ++n) compare({0, time(n), 0});
    for (std::int64_t n = 2; n < 12; ++n) compare({1, time(n), time(2)});
    for (std::int64_t n = 7; n < 12; ++n) compare({2, time(n), time(7)});
    for (std::int64_t n = 0; n < 3; ++n) compare({3, time(n), 0});
    EXPECT_EQ(most, 3U);
    EXPECT_EQ(ahead.frames(), plain.frames());
    EXPECT_EQ(ahead.unchanged_frames(), plain.unchanged_frames());
    EXPECT_EQ(ahead.built(), plain.built());
    EXPECT_EQ(ahead.planes_hash(), plain.planes_hash());
}

TEST(FramesAhead, AreNotBegunByAFeedWhoseFramesThreadsAskFor) {
    std::size_t most = 0;
    SurfaceFeed feed(std::make_unique<Planned>(some_frames()), std::make_unique<ThreeAtOnce>(most),
                     small_scene());
    ASSERT_TRUE(feed.pair_at(0));
    EXPECT_EQ(most, 1U);
    EXPECT_EQ(feed.place().next_number, 2);
}

TEST(FramesAhead, AnErrorIsToldWhenItsFrameIsAskedFor) {
    std::size_t most = 0;
    SurfaceFeed feed(std::make_unique<Planned>(some_frames(), 5), std::make_unique<ThreeAtOnce>(most),
                     small_scene());
    feed.work_ahead();
    const FrameRate rate = small_scene().rate;
    for (std::int64_t n = 0; n < 4; ++n) EXPECT_TRUE(feed.pair_at(rate.time_ns(n))) << n;
    const auto pair = feed.pair_at(rate.time_ns(4));
    ASSERT_FALSE(pair);
    EXPECT_EQ(pair.error().message, "the disk is out");
}

/// The memory of one frame's planes may be another's later.
TEST(WatchedPlanes, NumberTheColoursOfEachFrame) {
    const auto planes = std::make_shared<Planes>();
    WatchedPlanes watched;
    std::vector<std::uint64_t> contents;
    for (std::int64_t n = 0; n < 2; ++n) {
        RawFrame raw;
        raw.number = n;
        raw.colour = {planes->colour.data(), std::ptrdiff_t{3} * width, width, height, 1, 3};
        raw.storage = planes;
        for (int again = 0; again < 2; ++again) {
            watched.put(raw);
            contents.push_back(watched.find(0, n)->colour.content);
        }
    }
    EXPECT_NE(contents[0], 0U);
    EXPECT_EQ(contents[1], contents[0]);
    EXPECT_NE(contents[2], contents[0]);
    EXPECT_EQ(contents[3], contents[2]);
}

TEST(UnchangedFrames, AreToldInTheReport) {
    const TemporaryFolder folder;
    make_clip("bumps", folder / "still.mkv", {"--size", "72x48", "--frames", "5"});
    make_clip("moving", folder / "moving.mkv", {"--size", "72x48", "--frames", "5"});
    EXPECT_EQ(touch({folder / "still.mkv", "--hand", "wander"})["skipped_tiles_pct"], 80);
    EXPECT_EQ(touch({folder / "moving.mkv", "--hand", "wander"})["skipped_tiles_pct"], 0);
}

}  // namespace
}  // namespace touchable::test
