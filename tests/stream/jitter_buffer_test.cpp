// When what a sender sends is shown.
#include <algorithm>
#include <functional>

#include "engine/clip/readers.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t ms = 1'000'000, a_second = 1'000'000'000, apart = 33'333'333, bound = 200 * ms;
constexpr std::int64_t sender_begins = 1'700'000'000 * a_second;

struct Shown {
    std::vector<std::int64_t> waits, late;  // ns
};

/// 30 a a_second, sent by a clock that is `drift` parts in a million too fast, each `way(n)` under way.
Shown show(JitterBuffer& buffer, int frames, const std::function<std::int64_t(int)>& way,
           std::int64_t drift = 0, int from = 0) {
    Shown shown;
    std::int64_t last_arrived = 0, last_shown = 0;
    for (int n = from; n < from + frames; ++n) {
        const std::int64_t sent = n * apart;
        const std::int64_t arrived = std::max(a_second + sent + way(n), last_arrived);
        const auto moments = buffer.add(sender_begins + sent + sent / 1'000'000 * drift, arrived);
        EXPECT_GE(moments.shown_ns, arrived);
        EXPECT_GE(moments.shown_ns, last_shown);
        EXPECT_LE(moments.taken_ns, arrived);
        EXPECT_LE(moments.shown_ns - arrived, bound);
        shown.waits.push_back(moments.shown_ns - arrived);
        shown.late.push_back(std::max<std::int64_t>(0, arrived - moments.taken_ns - buffer.delay_ns()));
        last_arrived = arrived;
        last_shown = moments.shown_ns;
    }
    return shown;
}

std::int64_t quantile(std::vector<std::int64_t> all, double part) {
    std::sort(all.begin(), all.end());
    return all[static_cast<std::size_t>(part * static_cast<double>(all.size() - 1))];
}

std::function<std::int64_t(int)> jitter_of(std::int64_t most) {
    return [most](int n) {
        Numbers numbers(static_cast<std::uint64_t>(n) + 1);
        return 20 * ms +
               (most > 0 ? static_cast<std::int64_t>(numbers.next() % static_cast<std::uint64_t>(most)) : 0);
    };
}

TEST(JitterBuffer, AddsNothingWhereNothingJitters) {
    JitterBuffer buffer(bound);
    const Shown shown = show(buffer, 900, jitter_of(0));
    EXPECT_EQ(*std::max_element(shown.waits.begin(), shown.waits.end()), 0);
}

TEST(JitterBuffer, ItsDelayIsThatOfNearlyAll) {
    for (const std::int64_t most : {5 * ms, 50 * ms}) {
        JitterBuffer buffer(bound);
        const Shown shown = show(buffer, 900, jitter_of(most));
        EXPECT_GT(buffer.delay_ns(), most * 8 / 10);
        EXPECT_LE(buffer.delay_ns(), most);
        const std::vector<std::int64_t> settled(shown.late.begin() + 300, shown.late.end());
        EXPECT_EQ(quantile(settled, 0.9), 0) << "most are there in time";
    }
}

TEST(JitterBuffer, RisesQuicklyAndFallsSlowly) {
    JitterBuffer buffer(bound);
    show(buffer, 300, jitter_of(0));
    show(
        buffer, 10, [](int n) { return n % 2 == 0 ? 20 * ms : 80 * ms; }, 0, 300);
    const std::int64_t risen = buffer.delay_ns();
    EXPECT_GT(risen, 40 * ms);
    show(buffer, 150, jitter_of(0), 0, 310);  // five seconds
    EXPECT_GT(buffer.delay_ns(), risen / 4);
    show(buffer, 1'500, jitter_of(0), 0, 460);
    EXPECT_LT(buffer.delay_ns(), 2 * ms);
}

TEST(JitterBuffer, OneBurstCostsNobodyElse) {
    JitterBuffer buffer(bound);
    const Shown shown = show(buffer, 600, [](int n) { return n == 200 ? 150 * ms : 20 * ms; });
    const std::vector<std::int64_t> after(shown.waits.begin() + 220, shown.waits.end());
    EXPECT_LT(*std::max_element(after.begin(), after.end()), 5 * ms);
}

TEST(JitterBuffer, FollowsAClockThatDrifts) {
    for (const std::int64_t drift : {200, -200}) {
        JitterBuffer buffer(bound);
        const Shown shown = show(buffer, 30 * 600, jitter_of(0), drift);  // ten minutes: 120 ms
        EXPECT_LE(*std::max_element(shown.waits.begin(), shown.waits.end()), 3 * ms);
        EXPECT_LE(*std::max_element(shown.late.begin(), shown.late.end()), 3 * ms);
    }
}

TEST(JitterBuffer, ClocksThatJumpBeginAnew) {
    for (const std::int64_t jump : {3'600 * a_second, -3'600 * a_second, 100'000'000 * a_second,
                                    -1'600'000'000 * a_second, 500 * ms, -500 * ms}) {
        JitterBuffer buffer(bound);
        std::int64_t last = 0, worst = 0;
        for (int n = 0; n < 900; ++n) {
            const std::int64_t arrived = a_second + n * apart;
            const auto moments = buffer.add(sender_begins + n * apart + (n >= 300 ? jump : 0), arrived);
            EXPECT_GE(moments.shown_ns, last);
            last = moments.shown_ns;
            worst = std::max(worst, moments.shown_ns - arrived);
        }
        EXPECT_LE(worst, bound) << jump;
    }
}

TEST(JitterBuffer, ImpossibleClocksCountFromArrival) {
    Numbers numbers(3);
    JitterBuffer buffer(bound);
    std::int64_t last = 0;
    for (int n = 0; n < 10'000; ++n) {
        const std::int64_t arrived = a_second + n * apart;
        const std::int64_t sent = n % 3 == 0   ? 0
                                  : n % 3 == 1 ? static_cast<std::int64_t>(numbers.next())
                                               : sender_begins;  // stands still
        const auto moments = buffer.add(sent, arrived);
        EXPECT_GE(moments.shown_ns, arrived);
        EXPECT_LE(moments.shown_ns, std::max(arrived + bound, last));
        EXPECT_LE(arrived - moments.taken_ns, JitterBuffer::most_way_ns);
        last = moments.shown_ns;
    }
}

}  // namespace
}  // namespace touchable::test
