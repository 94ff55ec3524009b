#include "engine/stream/receiver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr PlaneRole depth = PlaneRole::depth, colour = PlaneRole::colour, haptic = PlaneRole::haptic,
                    height = PlaneRole::height;
const std::vector<PlaneRole> all_of_them(all_roles.begin(), all_roles.end());

/// A picture that says which frame it is of.
StreamPicture picture(PlaneRole role, std::int64_t number, std::int64_t taken_ns = 0,
                      std::int64_t frames = 1) {
    Image image{
        1, 1, 2, 1, {static_cast<std::uint8_t>(number % 256), static_cast<std::uint8_t>(number / 256)}};
    return {role, number, frames, taken_ns, plane_from(std::move(image))};
}
std::int64_t number_in(const Plane& plane) {
    return plane.view.empty() ? -1 : plane.view.sample(0, 0, 0);
}
const Plane& plane_in(const WholeFrameset& frameset, PlaneRole role) {
    return frameset.planes[static_cast<std::size_t>(role)];
}

std::vector<WholeFrameset> take_all(FramesetAssembler& assembler) {
    std::vector<WholeFrameset> all;
    while (auto frameset = assembler.take()) all.push_back(std::move(*frameset));
    return all;
}
std::vector<std::int64_t> numbers_of(const std::vector<WholeFrameset>& framesets) {
    std::vector<std::int64_t> numbers;
    for (const WholeFrameset& frameset : framesets) numbers.push_back(frameset.number);
    return numbers;
}
using Numbers64 = std::vector<std::int64_t>;

TEST(FramesetAssembler, GivesWhatIsWholeAtOnceAndInOrder) {
    FramesetAssembler assembler({depth, haptic, height});
    assembler.add(picture(depth, 4));
    assembler.add(picture(haptic, 4));
    EXPECT_FALSE(assembler.take());
    assembler.add(picture(height, 4));
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({4}));
    for (const PlaneRole role : {height, depth, haptic}) assembler.add(picture(role, 5));
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({5}));
    EXPECT_EQ(assembler.counts().whole, 2);
    EXPECT_EQ(assembler.counts().lost, 0);
    EXPECT_FALSE(assembler.has_part());
}

/// Every second frame from 4 to 12, all of them before and after.
TEST(FramesetAssembler, FramesThatWereNotSentAreNotLost) {
    const auto counts_without = [](const std::set<std::int64_t>& lost) {
        FramesetAssembler assembler({depth});
        for (std::int64_t number = 0; number < 20; ++number) {
            const bool is_low = number >= 4 && number < 13;
            if ((is_low && number % 2 == 1) || lost.contains(number)) continue;
            StreamPicture sent = picture(depth, number);
            sent.step = is_low ? 2 : 1;
            assembler.add(std::move(sent));
        }
        return assembler.counts();
    };
    EXPECT_EQ(counts_without({}).whole, 20 - 4);  // 5, 7, 9, 11 were not sent
    EXPECT_EQ(counts_without({}).lost, 0);
    EXPECT_EQ(counts_without({8}).lost, 1);
    EXPECT_EQ(counts_without({6, 8}).lost, 2);
    EXPECT_EQ(counts_without({2, 8, 15}).lost, 3);
}

TEST(FramesetAssembler, SaysWhatIsMissingLateTornOrThereTwice) {
    FramesetAssembler assembler({depth, haptic});
    const auto add_whole = [&](std::int64_t number) {
        assembler.add(picture(depth, number));
        assembler.add(picture(haptic, number));
    };
    add_whole(0);
    assembler.add(picture(depth, 1));  // its haptic never comes
    assembler.add(picture(haptic, 2));
    assembler.add_torn(1);  // of 2
    assembler.add(picture(depth, 3));
    assembler.add(picture(haptic, 3));
    assembler.add(picture(haptic, 3));
    add_whole(7);  // of 4 to 6 nothing comes
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({0, 3, 7}));
    FramesetCounts counts = assembler.counts();
    EXPECT_EQ(counts.lost, 4);
    EXPECT_EQ(counts.torn, 1);
    EXPECT_EQ(counts.repeated, 1);
    EXPECT_EQ(counts.late, 0);
    assembler.add(picture(haptic, 1));  // now it comes
    counts = assembler.counts();
    EXPECT_EQ(counts.late, 1);
    EXPECT_EQ(counts.torn, 0) << "as which it was counted";
    EXPECT_EQ(counts.lost, 4);
    assembler.add(picture(depth, 2));
    counts = assembler.counts();
    EXPECT_EQ(counts.late, 2);
    EXPECT_EQ(counts.lost, 3);
    EXPECT_FALSE(assembler.take());
}

TEST(FramesetAssembler, WaitsForColourOnlyUntilItsLaterOneComes) {
    FramesetAssembler assembler({depth, colour});
    assembler.add(picture(depth, 0));
    EXPECT_FALSE(assembler.take());
    assembler.add(picture(colour, 0));
    assembler.add(picture(depth, 1));
    assembler.add(picture(colour, 1));
    assembler.add(picture(depth, 2));  // its colour is lost
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({0, 1}));
    assembler.add(picture(colour, 3));
    const auto held = take_all(assembler);
    ASSERT_EQ(numbers_of(held), Numbers64({2}));
    EXPECT_EQ(number_in(plane_in(held.front(), colour)), 1);
    assembler.add(picture(depth, 3));
    const auto next = take_all(assembler);
    ASSERT_EQ(next.size(), 1U);
    EXPECT_EQ(number_in(plane_in(next.front(), colour)), 3);
    assembler.add(picture(depth, 4));
    EXPECT_FALSE(assembler.take());
    assembler.end();
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({4}));
}

TEST(FramesetAssembler, PicturesThatStayServeAllTheirFrames) {
    FramesetAssembler assembler({depth, haptic});
    assembler.add(picture(depth, 0));
    assembler.add(picture(haptic, 0, 0, 4));
    for (std::int64_t n = 1; n < 4; ++n) assembler.add(picture(depth, n));
    const auto given = take_all(assembler);
    EXPECT_EQ(numbers_of(given), Numbers64({0, 1, 2, 3}));
    for (const WholeFrameset& frameset : given) EXPECT_EQ(number_in(plane_in(frameset, haptic)), 0);
    assembler.add(picture(depth, 4));
    EXPECT_FALSE(assembler.take());
}

TEST(FramesetAssembler, ASenderThatBeginsAnewIsFollowed) {
    FramesetAssembler assembler({depth, haptic});
    const auto add_whole = [&](std::int64_t number, std::int64_t taken_ns) {
        assembler.add(picture(depth, number, taken_ns));
        assembler.add(picture(haptic, number, taken_ns));
    };
    for (std::int64_t n = 10; n < 20; ++n) add_whole(n, 1000 + n);
    assembler.add(picture(depth, 20, 1020));  // then it is killed, and begins again at 0
    for (std::int64_t n = 0; n < 30; ++n) add_whole(n, 5000 + n);
    add_whole(std::int64_t{1} << 40U, 9000);
    const auto given = take_all(assembler);
    ASSERT_EQ(given.size(), 41U);
    EXPECT_EQ(given[10].number, 0);
    EXPECT_EQ(given.back().number, std::int64_t{1} << 40U);
    EXPECT_EQ(assembler.counts().restarts, 2);
}

/// Whatever is lost, torn, sent twice, mixed or out of order: what is given is of one frame each, of one
/// moment, in order, and every frame that came whole and in order is given.
TEST(FramesetAssembler, NeverMixesFrames) {
    Numbers numbers(7);
    for (int round = 0; round < 300; ++round) {
        FramesetAssembler assembler(all_of_them);
        const bool restarts = round % 3 == 0, steps_back = round % 3 == 1;
        const int loss = numbers.below(4) * 5, twice = numbers.below(20),
                  shuffle = steps_back ? 0 : numbers.below(24);
        std::vector<StreamPicture> sent;
        for (int n = 0; n < 200; ++n) {
            const std::int64_t number = restarts && n >= 100 ? n - 95 : n;
            for (const PlaneRole role : all_roles) {
                if (numbers.below(100) < loss) continue;
                const bool is_before_step = steps_back && n < 100;
                sent.push_back(picture(role, number, (is_before_step ? 1'000'000 : 1'000) + n));
                if (numbers.below(100) < twice) sent.push_back(sent.back());
            }
        }
        if (steps_back) {  // one of before the sender's clock was put back comes late
            const std::int64_t of = 80 + numbers.below(20);
            sent.insert(sent.begin() + static_cast<std::ptrdiff_t>(sent.size() * 6 / 10),
                        picture(round % 2 == 0 ? colour : haptic, of, 1'000'000 + of));
        }
        if (shuffle > 0)
            for (std::size_t k = 0; k + 1 < sent.size(); ++k)
                std::swap(
                    sent[k],
                    sent[std::min(sent.size() - 1, k + static_cast<std::size_t>(numbers.below(shuffle)))]);
        std::int64_t last = -1, last_taken = 0, given = 0;
        const auto check = [&] {
            for (const WholeFrameset& frameset : take_all(assembler)) {
                ++given;
                for (const PlaneRole role : {depth, haptic, height})
                    ASSERT_EQ(number_in(plane_in(frameset, role)), frameset.number);
                ASSERT_LE(number_in(plane_in(frameset, colour)),
                          std::max<std::int64_t>(frameset.number, 105));
                ASSERT_TRUE(restarts || frameset.number > last);
                ASSERT_TRUE(frameset.number > last || frameset.taken_ns > last_taken);
                last = frameset.number;
                last_taken = frameset.taken_ns;
            }
        };
        for (StreamPicture& one : sent) {
            assembler.add(std::move(one));
            check();
        }
        assembler.end();
        check();
        const FramesetCounts& counts = assembler.counts();
        EXPECT_EQ(counts.whole, given);
        EXPECT_EQ(counts.restarts, restarts && shuffle == 0 ? 1 : restarts ? counts.restarts : 0) << round;
        EXPECT_TRUE(loss > 0 || shuffle > 1 || given == 200);
        EXPECT_TRUE(restarts || counts.whole + counts.late + counts.lost + counts.torn <= 200);
    }
}

/// 32 MiB by what it says; nobody reads its samples here.
StreamPicture large_picture(PlaneRole role, std::int64_t number) {
    static const std::uint8_t sample = 0;
    StreamPicture large{role, number, 1, 0, {}};
    large.plane.view = {&sample, 8192, 4096, 4096, 2, 1};
    large.plane.storage = std::make_shared<int>(0);
    return large;
}

TEST(FramesetAssembler, KeepsABoundedNumberOfBytes) {
    FramesetAssembler assembler({depth, haptic});
    assembler.add(picture(depth, 0));
    assembler.add(picture(haptic, 0));
    std::vector<std::weak_ptr<const void>> all;
    for (std::int64_t n = 1; n < 60; ++n) {
        StreamPicture large = large_picture(depth, n);
        all.emplace_back(large.plane.storage);
        assembler.add(std::move(large));
        const auto kept = std::ranges::count_if(all, [](const auto& one) { return !one.expired(); });
        EXPECT_EQ(kept, std::min<std::int64_t>(n, 16));
        EXPECT_EQ(all.back().expired(), false);
    }
    assembler.add(picture(haptic, 2));  // whose depth is dropped
    assembler.add(picture(haptic, 59));
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({0, 59}));
    EXPECT_EQ(assembler.counts().lost, 58);
}

/// What waits for its first colour does not wait until it is dropped.
TEST(FramesetAssembler, LargePicturesWithoutColourAreGiven) {
    FramesetAssembler assembler({depth, colour});
    for (std::int64_t n = 0; n < 40; ++n) assembler.add(large_picture(depth, n));
    EXPECT_GT(take_all(assembler).size(), 20U);
}

TEST(FramesetAssembler, KeepsABoundedNumberOfPictures) {
    FramesetAssembler assembler({depth, haptic});
    for (std::int64_t n = 0; n < 10'000; ++n) assembler.add(picture(depth, n));
    assembler.add(picture(haptic, 9'999));
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({9'999}));
    assembler.add(picture(depth, 10'000'000));
    assembler.add(picture(haptic, 10'000'000));
    EXPECT_EQ(assembler.counts().lost, 0) << "numbers that jump so far are of another count";
}

}  // namespace
}  // namespace touchable::test
