// Labels of whole clips in little memory, and segments that a stroke cuts in two.
#include "engine/authoring/segments.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/clip/clip_fixture.hpp"
#include "tests/materials/drawn_segments.hpp"

namespace touchable::test {
namespace {

using Rows = std::vector<std::string>;

std::vector<std::string> after(const SegmentStore& store, const SegmentCut& cut, std::int64_t frame = 0) {
    const auto made = store.with_cut(cut);
    EXPECT_EQ(message(made), "");
    return made ? drawing(*made, frame) : Rows{};
}

TEST(SegmentStore, GivesBackWhatItWasGiven) {
    const std::vector<Rows> frames{{"aabb", "a..b"}, {"abbb", ".ccb"}};
    const SegmentStore store = stored(frames);
    EXPECT_EQ(store.frames(), 2);
    for (std::size_t frame = 0; frame < 2; ++frame) {
        EXPECT_EQ(drawing(store, static_cast<std::int64_t>(frame)), frames[frame]);
        for (int y = 0; y < 2; ++y)
            for (int x = 0; x < 4; ++x)
                EXPECT_EQ(store.label_at(static_cast<std::int64_t>(frame), x, y),
                          drawn(frames[frame]).labels[static_cast<std::size_t>(4 * y + x)]);
    }
    ASSERT_EQ(store.seen().size(), 3U);
    EXPECT_EQ(store.find(3)->frame, 1);
    EXPECT_EQ(store.find(3)->segment.pixels, 2);
    EXPECT_EQ(store.find(4), nullptr);
    EXPECT_EQ(store.segmentation(0).segments.size(), 2U);
    EXPECT_EQ(store.segmentation(1).segments.size(), 3U);
}

TEST(SegmentStore, HoldsRunsLongerThanACounterOfThem) {
    Segmentation frame{400, 300, std::vector<std::uint16_t>(120'000, 7), {{7, 120'000, {}, 1, 1, 0}}};
    SegmentStore store(400, 300);
    store.add(frame);
    EXPECT_EQ(store.segmentation(0).labels, frame.labels);
    EXPECT_EQ(store.label_at(0, 399, 299), 7);
    EXPECT_LE(store.bytes(), 16U);
}

TEST(SegmentCut, PartsWhatItCrosses) {
    const SegmentStore store = stored({{"aaaaaab", "aaaaaab", "aaaaaab"}});
    // The stroke's own pixels go to the nearest part, the upper left one where two are as near.
    EXPECT_EQ(after(store, {0, {{2, 0}, {2, 2}}}), (Rows{"cccaaab", "cccaaab", "cccaaab"}));
    EXPECT_EQ(after(store, {0, {{2, 1}, {2, 2}}}), (Rows{"cccaaab", "cccaaab", "cccaaab"}))
        << "an end inside of the segment goes on to its border";
    EXPECT_EQ(drawing(store, 0)[0], "aaaaaab") << "the store that was cut is as it was";
    const auto made = store.with_cut({0, {{2, 0}, {2, 2}}});
    ASSERT_EQ(message(made), "");
    EXPECT_EQ(made->find(3)->segment.pixels, 9);
    EXPECT_EQ(made->find(3)->segment.colour, made->find(1)->segment.colour);
    EXPECT_EQ(made->find(1)->segment.pixels, 9);
    for (const std::uint16_t label : {1, 2, 3})
        EXPECT_EQ(made->label_at(0, made->find(label)->segment.x, made->find(label)->segment.y), label);
}

TEST(SegmentCut, PartsWhatIsInsideOfALoop) {
    const SegmentStore store = stored({Rows(12, std::string(16, 'a'))});
    const auto made = after(store, {0, {{3, 3}, {9, 3}, {9, 8}, {3, 8}, {3, 4}}});
    EXPECT_EQ(made[5], "aaaabbbbbbaaaaaa") << "inside, and what is nearest to it of the stroke";
    EXPECT_EQ(made[0], std::string(16, 'a'));
    EXPECT_EQ(made[11], std::string(16, 'a'));
}

TEST(SegmentCut, LeavesWhatTheStrokeDoesNotTouch) {
    // Another piece of the same segment, beyond something before it.
    const SegmentStore store = stored({{"aaaabbaa", "aaaabbaa"}});
    EXPECT_EQ(after(store, {0, {{1, 0}, {1, 1}}}), (Rows{"ccaabbaa", "ccaabbaa"}));
}

TEST(SegmentCut, ABorderStaysWhereNothingMoves) {
    // A hand passes before it.
    const SegmentStore store = stored({{"aaaaaaaa", "aaaaaaaa"},
                                       {"bbaaaaaa", "bbaaaaaa"},
                                       {"bbbbaaaa", "bbbbaaaa"},
                                       {"aabbbbaa", "aabbbbaa"},
                                       {"aaaaaabb", "aaaaaabb"}});
    for (const std::int64_t drawn_at : {0, 4}) {
        const auto made = store.with_cut({drawn_at, {{2, 0}, {2, 1}}});
        ASSERT_EQ(message(made), "");
        EXPECT_EQ(drawing(*made, 0)[0], "cccaaaaa");
        EXPECT_EQ(drawing(*made, 1)[0], "bbcaaaaa");
        EXPECT_EQ(drawing(*made, 2)[0], "bbbbaaaa");
    }
}

TEST(SegmentCut, ABorderGoesWithWhatMoves) {
    std::vector<Rows> frames;
    for (int k = 0; k < 5; ++k) {
        std::string row(20, 'a');
        std::fill_n(row.begin() + 2 + 2 * k, 6, 'b');
        frames.push_back({row, row, row});
    }
    const SegmentStore store = stored(frames);
    for (const std::int64_t drawn_at : {0, 2, 4}) {
        const int left = 2 + 2 * static_cast<int>(drawn_at);
        const auto made = store.with_cut({drawn_at, {{left + 1, 0}, {left + 1, 2}}});
        ASSERT_EQ(message(made), "");
        for (int k = 0; k < 5; ++k) {
            std::string row(20, 'a');
            std::fill_n(row.begin() + 2 + 2 * k, 2, 'c');
            std::fill_n(row.begin() + 4 + 2 * k, 4, 'b');
            EXPECT_EQ(drawing(*made, k)[1], row) << drawn_at;
        }
        EXPECT_EQ(made->find(3)->frame, 0);
    }
}

TEST(SegmentCut, IsRefusedWhereItPartsNothing) {
    const SegmentStore store = stored({{"aaaa...", "aaaa...", "aaaa..."}});
    EXPECT_NE(message(store.with_cut({0, {{4, 0}, {6, 0}}})).find("no surface"), std::string::npos);
    EXPECT_NE(message(store.with_cut({0, {{0, 0}, {0, 2}}})).find("does not part"), std::string::npos);
    EXPECT_NE(message(store.with_cut({1, {{0, 0}, {0, 2}}})).find("frame 1"), std::string::npos);
    EXPECT_NE(message(store.with_cut({0, {{1, 0}, {7, 2}}})).find("7,2"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
