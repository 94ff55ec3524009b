// A clip that is opened once for several runs over it.
#include "player/session/clip_choice.hpp"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <stop_token>
#include <thread>
#include <vector>

#include "engine/base/threads.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "tests/frame/random.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t shared_frames = 200;

/// What became of a clip's frames.
struct ReadFrames {
    int opened = 0;
    std::map<std::int64_t, int> times;  ///< that each was read
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
class Counted final : public ClipReader {
public:
    Counted(ReadFrames& read, int width) : read_(read) { scene_.width = width; }
    const Scene& scene() const override { return scene_; }
    UnstatedFilters unstated_filters() const override { return {.median = true}; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override { return shared_frames; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override {
        number_ = frame;
        return {};
    }
    Result<std::optional<RawFrame>> next() override {
        if (number_ == shared_frames) return std::optional<RawFrame>();
        if (stop_requested()) return interrupted_error();
        if (number_ == read_.fails_at) {
            number_ = -1;  // nobody knows where
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
    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    std::int64_t number_ = 0;
};

class Shared : public testing::Test {
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

TEST_F(Shared, ARunThatBeginsWhereAnotherOneIsReadsNothingAgain) {
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

// What a run reads is the other's too: a clip that was left in the middle of a frame would be damaged for
// both.
TEST_F(Shared, AFrameIsReadToItsEndThoughItsRunIsGivenUp) {
    const auto other = reader();
    auto run = reader();
    std::stop_source given_up;
    given_up.request_stop();
    const StopScope until(given_up.get_token());
    expect_frames(*run, 0, 5);
}

TEST_F(Shared, EachRunHasItsFramesWhereverTheOtherReads) {
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

TEST_F(Shared, KeepsTheFirstFramesForASurveyUntilItIsMade) {
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

TEST_F(Shared, KeepsAFewFramesThoughTheyAreLargeAndNeverMoreThanSome) {
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
TEST_F(Shared, OfAFullHdClipTwoRunsReadEachFrameOnceThoughOneOfThemFiltersFromSixteenFramesBefore) {
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

TEST_F(Shared, AfterDamageItIsKnownAgainWhereTheClipIs) {
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

TEST_F(Shared, OpensAgainWhereItCouldNotBeOpened) {
    const auto refused =
        shared_->open([]() -> Result<std::unique_ptr<ClipReader>> { return input_error("not there yet"); });
    ASSERT_FALSE(refused);
    expect_frames(*reader(), 0, 3);
}

TEST_F(Shared, IsReadByTwoThreads) {
    auto a = reader(), b = reader();
    std::thread beside([&] { expect_frames(*b, 0, shared_frames); });
    expect_frames(*a, 0, shared_frames);
    beside.join();
}

}  // namespace
}  // namespace touchable::test
