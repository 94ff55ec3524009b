// Segments of generated clips, of which it is known what every pixel shows.
#include "engine/authoring/segmentation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <map>
#include <set>

#include "engine/base/same_bits.hpp"
#include "tests/segments/generated_table.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

const bool short_sweeps = sweep_step() > 1;

TEST(Segmenter, FindsThingsOnATable) {
    double sum = 0, least = 1;
    constexpr int scenes = 8;
    std::size_t most_segments = 0;
    for (int seed = 0; seed < scenes; ++seed) {
        const GeneratedTable table = random_table(static_cast<std::uint64_t>(seed));
        Segmenter segmenter(table.scene());
        const GeneratedFrame frame = generate(table, 0);
        const Segmentation& found = segmenter.next(frame.raw(), false);
        const double iou = mean_iou(frame.truth, found.labels);
        std::printf("scene %d: mean IoU %.3f, %zu segments\n", seed, iou, found.segments.size());
        sum += iou;
        least = std::min(least, iou);
        most_segments = std::max(most_segments, found.segments.size());
    }
    std::printf("mean of %d scenes: %.3f\n", scenes, sum / scenes);
    EXPECT_GE(sum / scenes, 0.8);
    EXPECT_GE(least, 0.7);
    EXPECT_LE(most_segments, 40U);
}

/// As good at the sizes of other cameras. What a frame takes is printed: 640x480 has to be 5 a second.
TEST(Segmenter, FindsThemInPicturesOfAnySize) {
    for (const auto& [width, height] : {std::pair{640, 480}, {1920, 1080}}) {
        if (short_sweeps && width > 640) continue;
        const GeneratedTable table = random_table(3, width, height);
        Segmenter segmenter(table.scene());
        const GeneratedFrame first = generate(table, 0), second = generate(table, 1);
        double iou = mean_iou(first.truth, segmenter.next(first.raw(0), false).labels);
        const auto wall = std::chrono::steady_clock::now();
        const std::clock_t cpu = std::clock();
        iou = std::min(iou, mean_iou(second.truth, segmenter.next(second.raw(1), true).labels));
        const double all_ms = 1000.0 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
        const double ms =
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall).count();
        std::printf("%dx%d: mean IoU %.3f, a frame takes %.0f ms, %.0f ms of CPU\n", width, height, iou, ms,
                    all_ms);
        EXPECT_GE(iou, 0.8);
    }
}

/// Per cent of the pixels seen in both frames whose label is another than it was, in the mean and at most.
struct Changes {
    double mean = 0, most = 0;
};
Changes changes_of(const GeneratedTable& table, int frames, int from) {
    Segmenter segmenter(table.scene());
    GeneratedFrame before;
    std::vector<std::uint16_t> labels;
    Changes changes;
    std::set<std::uint16_t> all;
    for (int n = 0; n < frames; ++n) {
        GeneratedFrame now = generate(table, n);
        const Segmentation& found = segmenter.next(now.raw(n), n > 0);
        for (const Segment& segment : found.segments) all.insert(segment.label);
        if (n >= from) {
            double seen = 0, changed = 0;
            for (std::size_t k = 0; k < now.truth.size(); ++k) {
                const auto there = place_before(table, now, before, n, k);
                if (!there) continue;
                ++seen;
                changed += labels[*there] != found.labels[k] ? 1 : 0;
            }
            const double share = 100 * changed / seen;
            changes.mean += share / (frames - from);
            changes.most = std::max(changes.most, share);
        }
        labels = found.labels;
        before = std::move(now);
    }
    std::printf("%zu labels in %d frames; %.3f %% change, at most %.3f %%\n", all.size(), frames,
                changes.mean, changes.most);
    return changes;
}

TEST(Segmenter, IsSteadyBeforeAStillCamera) {
    for (const int seed : short_sweeps ? std::vector{0, 2} : std::vector{0, 1, 2}) {
        GeneratedTable table = random_table(static_cast<std::uint64_t>(seed));
        table.colour_noise = 5;
        const Changes changes = changes_of(table, short_sweeps ? 8 : 16, 1);
        EXPECT_LE(changes.mean, 0.5);
    }
}

TEST(Segmenter, FollowsWhatMoves) {
    for (const int seed : short_sweeps ? std::vector{0, 2} : std::vector{0, 1, 2}) {
        GeneratedTable table = random_table(static_cast<std::uint64_t>(seed));
        if (seed != 1) table.things[3].speed = {0.008, 0, 0};
        if (seed != 1) table.things[5].speed = {-0.004, 0, 0.003};
        if (seed != 0) table.camera_speed = {0.01, 0, -0.003};
        const Changes changes = changes_of(table, short_sweeps ? 8 : 20, 1);
        EXPECT_LE(changes.mean, 3);
    }
}

/// All that is found of some frames of a clip that moves, of which some are left out.
class HashedClip {
public:
    HashedClip() {
        table_.things[3].speed = {0.01, 0, 0};
        table_.camera_speed = {-0.006, 0, 0};
        for (const int n : {0, 1, 2, 3, 9, 10}) frames_.push_back(generate(table_, n));
    }
    std::uint64_t hash(int threads) const {
        Segmenter segmenter(table_.scene(), threads);
        ByteHash hash;
        for (std::size_t n = 0; n < frames_.size(); ++n) {
            const bool follows = n != 0 && n != 4;
            const Segmentation& found = segmenter.next(frames_[n].raw(), follows);
            hash.add(found.labels.data(), 2 * found.labels.size());
            for (const Segment& segment : found.segments) {
                const std::array<std::int32_t, 8> figures{
                    segment.label,    segment.pixels,    segment.x,         segment.y,
                    segment.contrast, segment.colour[0], segment.colour[1], segment.colour[2]};
                hash.add(figures.data(), sizeof figures);
            }
        }
        return hash.value();
    }

private:
    GeneratedTable table_ = random_table(11);
    std::vector<GeneratedFrame> frames_;
};

/// Of GCC, Clang, with and without optimisation, and with any number of threads.
TEST(Segmenter, HasTheSameBitsEverywhere) {
    const HashedClip clip;
    for (const int threads : {1, 2, 4}) EXPECT_EQ(clip.hash(threads), 14712688257145656365U) << threads;
}

/// After a cut things that are where they were, and look as they did, have the labels that they had.
TEST(Segmenter, KnowsThingsAgainAfterACut) {
    GeneratedTable table = random_table(3), other = random_table(4);
    Segmenter segmenter(table.scene());
    const GeneratedFrame frame = generate(table, 0), later = generate(table, 1), cut = generate(other, 0);
    const std::vector<std::uint16_t> before = segmenter.next(frame.raw(), false).labels;
    segmenter.next(cut.raw(), false);
    const std::vector<std::uint16_t>& after = segmenter.next(later.raw(), false).labels;
    std::size_t same = 0;
    for (std::size_t k = 0; k < before.size(); ++k) same += before[k] == after[k] ? 1U : 0U;
    EXPECT_GE(same * 100, before.size() * 97);
}

/// Somebody draws the curtains: things do not look as they did, but are where they were.
TEST(Segmenter, KeepsLabelsWhereTheLightChanges) {
    const GeneratedTable table = random_table(3);
    Segmenter segmenter(table.scene());
    GeneratedFrame frame = generate(table, 0);
    const std::vector<std::uint16_t> before = segmenter.next(frame.raw(0), false).labels;
    for (std::uint8_t& sample : frame.colour) sample = static_cast<std::uint8_t>(sample / 2);
    const std::vector<std::uint16_t>& after = segmenter.next(frame.raw(1), true).labels;
    std::size_t same = 0;
    for (std::size_t k = 0; k < before.size(); ++k) same += before[k] == after[k] ? 1U : 0U;
    EXPECT_GE(same * 100, before.size() * 97);
}

}  // namespace
}  // namespace touchable::test
