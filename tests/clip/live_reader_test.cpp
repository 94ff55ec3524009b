// The rules that all live sources share, by a source that has what the test gives it.
#include <deque>
#include <functional>
#include <thread>

#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

using std::chrono::steady_clock;

/// A frame that a source counts as `count`, and has so many ns after the test's moment.
struct Given {
    std::uint32_t count = 0;
    std::int64_t after_ns = 0;
};

class GivenSource final : public LiveReader {
public:
    GivenSource() : LiveReader("/dev/given") {}
    /// Waiting ends with this; by default nothing comes any more, which a source says after so many waits.
    std::function<void()> on_wait = [] {};
    std::deque<Given> there;
    std::string end;  ///< why no more will come
    int waits = 0;
    const steady_clock::time_point zero = steady_clock::now();

    using LiveReader::damaged_;

private:
    MaybeTaken take() override {
        while (has_begun() && there.size() > 1) there.pop_front();
        if (there.empty()) return end.empty() ? MaybeTaken(std::nullopt) : gone(end);
        const Given given = there.front();
        there.pop_front();
        return std::optional(Taken{given.count, steady_ns_of(zero) + given.after_ns, 7});
    }
    void wait() override {
        ++waits;
        on_wait();
    }
    std::optional<Error> nothing_came(Moment) const override {
        return waits < 3 ? std::nullopt : std::optional(input_error("waited in vain"));
    }
    void drain() override {}
};

class LiveSource : public ::testing::Test {
protected:
    /// Number and time of the next frame.
    std::pair<std::int64_t, std::int64_t> next() {
        const auto frame = source.next();
        EXPECT_EQ(message(frame), "");
        return frame && *frame ? std::pair((*frame)->number, (*frame)->time_ns)
                               : std::pair<std::int64_t, std::int64_t>(-1, -1);
    }
    std::pair<std::int64_t, std::int64_t> next(Given given) {
        source.there.push_back(given);
        return next();
    }
    GivenSource source;
};

TEST_F(LiveSource, CountsEachFrameBeforeIt) {
    source.there = {{5, 0}, {9, 0}, {9, 0}};
    for (std::int64_t n = 0; n < 3; ++n) EXPECT_EQ(next(), std::pair(n, n * ns_before_a_run));
    EXPECT_EQ(source.seek(4).error().kind, ErrorKind::usage);
    ASSERT_EQ(message(source.seek(1)), "");
    EXPECT_EQ(next({9, 0}), std::pair(std::int64_t{1}, ns_before_a_run));
}

TEST_F(LiveSource, GivesNewestAndCountsGaps) {
    next({100, 0});
    ASSERT_EQ(message(source.begin(source.zero)), "");
    EXPECT_EQ(source.seek(0).error().kind, ErrorKind::usage);
    EXPECT_EQ(next({200, 5'000}), std::pair(std::int64_t{1}, std::int64_t{5'000}))
        << "no gap before its first";
    source.there = {{201, 6'000}, {202, 7'000}, {203, 8'000}};
    EXPECT_EQ(next(), std::pair(std::int64_t{4}, std::int64_t{8'000}));
    EXPECT_EQ(next({203, 9'000}).first, 5) << "a count that stands still";
    EXPECT_EQ(next({3, 10'000}).first, 6) << "a count that begins anew";
    EXPECT_EQ(next({3 + 1'000'000, 11'000}).first, 6 + 1'000'000);
    EXPECT_EQ(next({3 + 2'000'001, 12'000}).first, 7 + 1'000'000) << "another count";
    EXPECT_EQ(source.taken_before(4), 7);
    EXPECT_EQ(source.taken_before(3), 0);
}

TEST_F(LiveSource, TimesNeverGoBack) {
    ASSERT_EQ(message(source.begin(source.zero)), "");
    source.on_wait = [&] { source.there.push_back({2, 3'000}); };
    EXPECT_EQ(next({1, -1}).second, 3'000) << "it was taken before the run";
    EXPECT_EQ(next({3, 2'000}).second, 3'001);
    EXPECT_EQ(next({4, -9'000}).second, 3'002);
    EXPECT_EQ(next({5, 4'000}).second, 4'000);
}

TEST_F(LiveSource, EndsWithItsSource) {
    source.end = "was unplugged";
    EXPECT_EQ(message(source.next()), "the camera, /dev/given, was unplugged");
    GivenSource other;
    ASSERT_EQ(message(other.begin(other.zero)), "");
    other.end = "was unplugged";
    other.damaged_ = 2;
    for (int again = 0; again < 2; ++again) {
        const auto frame = other.next();
        ASSERT_EQ(message(frame), "");
        EXPECT_FALSE(*frame);
    }
    const auto remarks = other.remarks();
    ASSERT_EQ(remarks.size(), 2U);
    EXPECT_EQ(remarks[0], "2 of the camera's frames were damaged or cut short, and left out");
    EXPECT_TRUE(remarks[1].starts_with("the camera, /dev/given, was unplugged after ")) << remarks[1];
    EXPECT_TRUE(remarks[1].ends_with(" s; its last frame stands still")) << remarks[1];
}

TEST_F(LiveSource, IsWaitedForAsLongAsItLasts) {
    EXPECT_EQ(message(source.next()), "waited in vain");
    EXPECT_EQ(source.waits, 3);
    ASSERT_EQ(message(source.begin(source.zero)), "");
    source.on_wait = [&] {
        if (source.waits == 100) source.there.push_back({1, 5});
    };
    EXPECT_EQ(next().second, 5);
}

TEST_F(LiveSource, IsInterruptedAndBeginsAgain) {
    ASSERT_EQ(message(source.begin(source.zero)), "");
    EXPECT_EQ(next({1, 2'000'000}).first, 0);
    std::stop_source given_up;
    source.on_wait = [&] { given_up.request_stop(); };
    for (int again = 0; again < 2; ++again) {
        const auto told = work_until(given_up.get_token(), [&] { return source.next(); });
        ASSERT_FALSE(told);
        EXPECT_EQ(told.error().kind, ErrorKind::interrupted);
        EXPECT_EQ(message(told), "the camera was told to stop before it gave frame 1");
    }
    EXPECT_EQ(source.waits, 1);
    ASSERT_EQ(message(source.begin(source.zero)), "");
    EXPECT_EQ(next({9, 3'000'000}), std::pair(std::int64_t{1}, std::int64_t{3'000'000}))
        << "what came between is no gap";
}

}  // namespace
}  // namespace touchable::test
