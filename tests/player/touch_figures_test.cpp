// The figures of a report, tick by tick, against ones that are counted by hand.
#include "player/session/run_record.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "engine/content/seeded_noise.hpp"

namespace touchable::test {
namespace {

/// A tick of two fingers, both free; each in contact has 600 N/m.
class TwoFingers {
public:
    /// A finger in contact.
    void press(std::size_t finger, double newtons, std::uint32_t reasons = guard_none) {
        contacts[finger].touching = true;
        contacts[finger].properties.stiffness = 600;
        forces[finger].force = {0, newtons, 0};
        forces[finger].reasons = reasons;
    }
    TouchTick tick() {
        TouchTick made;
        made.contacts = contacts;
        made.forces = forces;
        return made;
    }

    std::array<Contact, 2> contacts;
    std::array<GuardedForce, 2> forces;
};

nlohmann::ordered_json figures_of(std::vector<TwoFingers> ticks) {
    TouchFigures figures;
    for (TwoFingers& one : ticks) EXPECT_TRUE(figures.take(one.tick()));
    return figures.to_json();
}

TEST(TouchFigures, OfATickWithoutAnythingAreZero) {
    const auto report = figures_of({TwoFingers{}});
    EXPECT_EQ(report["ticks"], 1);
    for (const char* count : {"contact_ticks", "proxy_behind_mesh_ticks", "nonfinite_ticks", "capped_ticks",
                              "guarded_ticks", "waiting_ticks", "late_ticks"})
        EXPECT_EQ(report[count], 0) << count;
    for (const char* figure : {"finger_contact_pct", "events_mean"}) EXPECT_EQ(report[figure], 0.0) << figure;
    EXPECT_EQ(report["force_n"]["max"], 0.0);
    EXPECT_EQ(report["stiffness_limited"]["smallest_n_mm"], 0.0);
}

TEST(TouchFigures, CountEachTickOnceHoweverManyFingersItIsOf) {
    TwoFingers nothing, both, one;
    both.press(0, 3);
    both.press(1, 5);
    one.press(1, 1);
    for (Contact& contact : both.contacts) contact.counts = {6, 0, true};
    one.contacts[1].counts = {3, 0, false};
    for (GuardedForce& force : both.forces)
        force.reasons = guard_stiffness | guard_force | guard_waiting | guard_jump;
    const auto report = figures_of({nothing, both, one, nothing, nothing});
    EXPECT_EQ(report["ticks"], 5);
    EXPECT_EQ(report["contact_ticks"], 2);
    EXPECT_EQ(report["finger_contact_pct"], 30.0) << "3 of 10";
    EXPECT_EQ(report["capped_ticks"], 1);
    EXPECT_EQ(report["guarded_ticks"], 1);
    EXPECT_EQ(report["waiting_ticks"], 1);
    EXPECT_EQ(report["stiffness_limited"]["ticks"], 1);
    EXPECT_EQ(report["force_limited"]["finger_ticks"], 2);
    EXPECT_EQ(report["events_mean"], 5.0) << "6, 6 and 3";
    EXPECT_EQ(report["force_n"]["mean"], 3.0) << "3, 5 and 1";
    EXPECT_EQ(report["force_n"]["max"], 5.0);
}

/// A window's pointer has five fingers, most of which stay away.
TEST(TouchFigures, KnowHowManyFingersWereLed) {
    TouchFigures figures;
    const auto take = [&](double goal, bool pressed) {
        TwoFingers two;
        two.contacts[0].goal = {0, 0, goal};
        two.contacts[1].goal = {1, 2, 3};
        if (pressed) two.press(0, 1);
        EXPECT_TRUE(figures.take(two.tick()));
        return figures.to_json();
    };
    EXPECT_EQ(take(1, false)["fingers_led"], 0);
    const auto led = take(2, true);
    EXPECT_EQ(led["fingers_led"], 1);
    EXPECT_EQ(led["finger_contact_pct"], 50.0) << "of the one finger's time";
    figures.end_part();  // whose scene may lie elsewhere
    TwoFingers two;
    two.contacts[1].goal = {4, 5, 6};
    EXPECT_TRUE(figures.take(two.tick()));
    EXPECT_EQ(figures.to_json()["fingers_led"], 1);
}

TEST(TouchFigures, CountTicksThatAreNoNumberOrBehindTheSurface) {
    const double nan = std::nan("");
    for (const double bad : {nan, HUGE_VAL, -HUGE_VAL}) {
        std::vector<TwoFingers> ticks(7);
        for (glm::length_t axis = 0; axis < 3; ++axis) {
            ticks[static_cast<std::size_t>(axis)].contacts[1].proxy[axis] = bad;
            ticks[static_cast<std::size_t>(axis) + 3].forces[0].force[axis] = bad;
        }
        EXPECT_EQ(figures_of(ticks)["nonfinite_ticks"], 6) << bad;
    }
    TouchFigures figures;
    for (const bool behind : {true, false, true}) {
        TwoFingers two;
        TouchTick tick = two.tick();
        tick.behind = behind;
        EXPECT_TRUE(figures.take(tick));
    }
    EXPECT_EQ(figures.to_json()["proxy_behind_mesh_ticks"], 2);
}

TEST(TouchFigures, KnowTheLongestTimeAtTheLimitAndInAHoleOfAnyFinger) {
    TouchFigures figures;
    const auto take = [&](bool limited, bool in_hole, int ticks) {
        for (int k = 0; k < ticks; ++k) {
            TwoFingers two;
            two.press(0, 1);
            two.press(1, 10, limited ? guard_force : guard_none);
            two.contacts[1].in_hole = in_hole;
            EXPECT_TRUE(figures.take(two.tick()));
        }
    };
    take(true, false, 3);
    take(false, true, 2);
    take(true, true, 4);
    EXPECT_TRUE(figures.force_limited_in_holes());
    take(false, false, 1);
    take(true, true, 2);
    figures.end_part();  // nothing goes on in a row
    take(true, true, 5);
    const auto report = figures.to_json();
    EXPECT_EQ(report["force_limited"]["finger_ticks"], 14);
    EXPECT_EQ(report["force_limited"]["longest_ticks"], 5);
    EXPECT_EQ(report["hole_contact"]["finger_ticks"], 13);
    EXPECT_DOUBLE_EQ(report["hole_contact"]["contact_pct"].get<double>(), 100 * 13.0 / 34);
    EXPECT_EQ(report["hole_contact"]["longest_ticks"], 6);
    EXPECT_EQ(report["hole_contact"]["force_limited_ticks"], 11);
}

TEST(TouchFigures, HaveTheSmallestAndLargestStiffnessInContactInNewtonsPerMillimetre) {
    TwoFingers two;
    two.press(0, 1);
    two.press(1, 1);
    two.contacts[0].properties.stiffness = 250;
    two.contacts[1].properties.stiffness = 4000;
    TwoFingers free;
    free.contacts[0].properties.stiffness = 1;
    const auto stiffness = figures_of({free, two})["stiffness_limited"];
    EXPECT_EQ(stiffness["smallest_n_mm"], 0.25);
    EXPECT_EQ(stiffness["largest_n_mm"], 4.0);
}

// In joules of each finger up to the newest tick; of all parts of a run.
TEST(TouchFigures, SumTheEnergyOfFingersAndParts) {
    TouchFigures figures;
    const auto take = [&](double times) {
        TwoFingers two;
        for (GuardedForce& force : two.forces) {
            force.energy.created = 0.001 * times;
            force.energy.bound = 0.002 * times;
            force.energy.surface = 0.003 * times;
            force.energy.work = 0.004 * times;
        }
        EXPECT_TRUE(figures.take(two.tick()));
    };
    take(7);
    take(1);
    figures.end_part();
    take(2);
    const auto energy = figures.to_json()["energy_mj"];
    EXPECT_NEAR(energy["created"].get<double>(), 6, 1e-12);
    EXPECT_NEAR(energy["zoh_bound"].get<double>(), 12, 1e-12);
    EXPECT_NEAR(energy["surface"].get<double>(), 18, 1e-12);
    EXPECT_NEAR(energy["on_hand"].get<double>(), 24, 1e-12);
}

/// Ticks that took and were late by so many microseconds.
struct Timed {
    explicit Timed(const std::vector<double>& us);
    TouchFigures figures;
};
Timed::Timed(const std::vector<double>& us) {
    TwoFingers two;
    for (const double time : us) {
        TouchTick tick = two.tick();
        tick.solve_us = time;
        tick.late_us = 2 * time;
        EXPECT_TRUE(figures.take(tick));
    }
}

TEST(TouchFigures, CountLateTicksOnceEachBelowEveryLimit) {
    const Timed timed({0, 4.99, 5, 9, 10, 24.9, 25, 49, 50, 99, 100, 249, 250, 499.9, 500, 1e6, 1e6});
    const auto histogram = timed.figures.late_histogram();
    const std::vector<std::pair<int, int>> expected{{10, 2},  {20, 2},  {50, 2},  {100, 2},
                                                    {200, 2}, {500, 2}, {1000, 2}};
    ASSERT_EQ(histogram.size(), expected.size() + 1);
    for (std::size_t k = 0; k < expected.size(); ++k) {
        EXPECT_EQ(histogram[k]["below_us"], expected[k].first);
        EXPECT_EQ(histogram[k]["ticks"], expected[k].second) << expected[k].first;
    }
    EXPECT_EQ(histogram.back(), nlohmann::ordered_json({{"ticks", 3}}));
}

void expect_within_a_percent(const Spread& found, std::vector<double> us) {
    std::sort(us.begin(), us.end());
    double sum = 0;
    for (const double time : us) sum += time;
    const auto ranked = [&](double share) {
        return us[static_cast<std::size_t>(share * static_cast<double>(us.size()))];
    };
    EXPECT_NEAR(found.mean, sum / static_cast<double>(us.size()), 1e-9 * found.mean);
    EXPECT_EQ(found.max, us.back());
    EXPECT_NEAR(found.p50, ranked(0.5), 0.01 * ranked(0.5));
    EXPECT_NEAR(found.p99, ranked(0.99), 0.01 * ranked(0.99));
    EXPECT_NEAR(found.p999, ranked(0.999), 0.01 * ranked(0.999));
}

TEST(TouchFigures, TimesHaveThePercentilesOfAllTimesToAPercent) {
    SplitMix64 random(5);
    std::vector<double> even, uneven, two_kinds;
    for (int k = 0; k < 20'000; ++k) {
        even.push_back(k + 1);
        uneven.push_back(std::exp(random.within(-6, 14)));  // 2 ns to 1 s
        two_kinds.push_back(random.next() % 60 == 0 ? random.within(800, 900) : random.within(0.2, 0.4));
    }
    for (const auto& us :
         {even, uneven, two_kinds, std::vector<double>{3.7}, std::vector<double>{1, 2, 4e12}}) {
        const Timed timed(us);
        expect_within_a_percent(timed.figures.tick_us(), us);
        std::vector<double> late;
        for (const double time : us) late.push_back(2 * time);
        expect_within_a_percent(timed.figures.late_us(), late);
    }
    const auto spread = Timed(even).figures.to_json()["tick_us"];
    EXPECT_NEAR(spread["p50"].get<double>(), 10'000, 100);
    EXPECT_NEAR(spread["p99"].get<double>(), 19'800, 198);
    EXPECT_NEAR(spread["p999"].get<double>(), 19'980, 199.8);
    EXPECT_EQ(spread["max"], 20'000.0);
    EXPECT_NEAR(spread["mean"].get<double>(), 10'000.5, 1e-6);
}

TEST(TouchFigures, OfTicksThatAreNeverLateSayZero) {
    const Spread late = Timed(std::vector<double>(1000, 0.0)).figures.late_us();
    for (const double each : {late.mean, late.p50, late.p99, late.p999, late.max}) EXPECT_EQ(each, 0);
    const Spread none = TouchFigures().tick_us();
    for (const double each : {none.mean, none.p50, none.p99, none.p999, none.max}) EXPECT_EQ(each, 0);
}

TEST(TouchFigures, ExactPercentilesAreAtTheirRank) {
    std::vector<double> values;
    for (int k = 1000; k > 0; --k) values.push_back(k);
    const Spread spread = spread_of(values);
    EXPECT_EQ(spread.mean, 500.5);
    EXPECT_EQ(spread.p50, 501);
    EXPECT_EQ(spread.p99, 991);
    EXPECT_EQ(spread.p999, 1000);
    EXPECT_EQ(spread.max, 1000);
    EXPECT_EQ(spread_of({}).max, 0);
}

// An hour has 3.6 million ticks.
TEST(TouchFigures, MemoryDoesNotGrowWithTheRun) {
    TouchFigures figures;
    TwoFingers two;
    two.press(0, 1);
    const auto take = [&](int ticks) {
        for (int k = 0; k < ticks; ++k) {
            TouchTick tick = two.tick();
            tick.solve_us = 0.1 + k % 1000;
            tick.late_us = k % 777;
            EXPECT_TRUE(figures.take(tick));
        }
    };
    take(10);
    const auto before = mallinfo2().uordblks;
    take(100'000);
    EXPECT_EQ(mallinfo2().uordblks, before);
    EXPECT_EQ(figures.ticks(), 100'010);
}

}  // namespace
}  // namespace touchable::test
