#include "player/window/long_work.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>

namespace touchable::test {
namespace {

class Opening : public LongWork<int> {
public:
    Opening() : LongWork("test-work", "that a test needs") {}
};

Opening::Make at_once(int value) {
    return [value]() -> Result<int> { return value; };
}
/// Until it is given up, which it says.
Opening::Make never(std::atomic<int>& begun, std::atomic<int>& given_up) {
    return [&begun, &given_up]() -> Result<int> {
        ++begun;
        while (!stop_requested()) std::this_thread::yield();
        ++given_up;
        return input_error("given up");
    };
}

std::optional<Result<int>> wait_for(Opening& opening) {
    for (int k = 0; k < 5000; ++k) {
        if (auto made = opening.take()) return made;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return std::nullopt;
}

TEST(LongWork, GivesWhatWasAskedForOnce) {
    Opening opening;
    EXPECT_FALSE(opening.is_busy());
    EXPECT_EQ(opening.words(), "");
    opening.ask("opening seven", at_once(7));
    EXPECT_EQ(opening.words(), "opening seven");
    const auto made = wait_for(opening);
    ASSERT_TRUE(made && *made);
    EXPECT_EQ(**made, 7);
    EXPECT_FALSE(opening.is_busy());
    EXPECT_FALSE(opening.take());
}

TEST(LongWork, LaterWishTakesThePlaceOfTheOnesBefore) {
    std::atomic<int> begun{0}, given_up{0}, skipped{0};
    Opening opening;
    opening.ask("the first", never(begun, given_up));
    while (begun == 0) std::this_thread::yield();
    opening.ask("the second", never(skipped, skipped));
    opening.ask("the third", at_once(3));
    EXPECT_EQ(opening.words(), "the third");
    const auto made = wait_for(opening);
    ASSERT_TRUE(made && *made);
    EXPECT_EQ(**made, 3);
    EXPECT_EQ(given_up, 1);
    EXPECT_EQ(skipped, 0) << "nobody wanted it any more when its turn had come";
}

TEST(LongWork, EndsWhileSomethingIsOnItsWay) {
    std::atomic<int> begun{0}, given_up{0};
    {
        Opening opening;
        opening.ask("a long work", never(begun, given_up));
        while (begun == 0) std::this_thread::yield();
        opening.ask("another", never(begun, given_up));
    }
    EXPECT_EQ(begun, 1);
    EXPECT_EQ(given_up, 1);
}

TEST(LongWork, LettingGoWaitsForNothing) {
    std::atomic<int> begun{0}, given_up{0};
    std::atomic<bool> may_end{false};
    Opening opening;
    // Asks late whether to stop.
    opening.ask("a long work", [&]() -> Result<int> {
        ++begun;
        while (!may_end) std::this_thread::yield();
        given_up += stop_requested() ? 1 : 0;
        return 1;
    });
    while (begun == 0) std::this_thread::yield();
    opening.let_go();
    EXPECT_FALSE(opening.is_busy());
    EXPECT_EQ(opening.words(), "");
    EXPECT_FALSE(opening.take());
    std::atomic<bool> is_alone{false};
    opening.ask("the next", [&]() -> Result<int> {
        is_alone = may_end.load();
        return 2;
    });
    EXPECT_TRUE(opening.is_busy());
    EXPECT_EQ(opening.words(), "the next");
    EXPECT_FALSE(opening.take()) << "the one before has not ended";
    may_end = true;
    const auto made = wait_for(opening);
    ASSERT_TRUE(made && *made);
    EXPECT_EQ(**made, 2);
    EXPECT_EQ(given_up, 1);
    EXPECT_TRUE(is_alone);
}

TEST(LongWork, WhatIsThrownIsAnError) {
    Opening opening;
    opening.ask("opening a.mkv", []() -> Result<int> { throw std::bad_alloc(); });
    auto made = wait_for(opening);
    ASSERT_TRUE(made && !*made);
    EXPECT_EQ(made->error().message, "opening a.mkv: memory does not suffice");
    opening.ask("opening b.mkv", []() -> Result<int> { throw std::runtime_error("no such thing"); });
    made = wait_for(opening);
    ASSERT_TRUE(made && !*made);
    EXPECT_EQ(made->error().kind, ErrorKind::internal);
}

}  // namespace
}  // namespace touchable::test
