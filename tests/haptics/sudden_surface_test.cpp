// Surfaces that do what surfaces do not: rise through a hand, change at every frame, come late, stop. Through
// the whole tick, as a device feels it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "haptics_cpu/touch_step.hpp"
#include "tests/frame/random.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/reference/solver.hpp"

namespace touchable::test {
namespace {

constexpr double newtons_per_unit = 0.6;  // 600 N/m, a unit is a millimetre
/// The most that a surface may add to a force in a tick where frames are interpolated: slow motion, and the
/// steepest of a fade over the device's 10 N, with a fifth for fades that overlap.
constexpr double largest_rise = 0.1 * newtons_per_unit + 1.2 * 10 * 1.5 / JumpCancellation::fade_ticks;

/// One finger over a small field, through TouchStep; every tick is looked at.
class Stage : public StepRig {
public:
    explicit Stage(FrameInterpolation interpolation) : StepRig(200, DepthSemantics::range) {
        field.scene.default_properties = {600, 0, 0};
        field.scene.interpolation = interpolation;
    }

    /// A tick over a pair of frames; asserts what holds of every tick.
    void tick(std::int64_t number, const FramePair& pair, const dvec3& goal) {
        const TouchTick done = run(number, pair, goal);
        const HeightField surface(field.scene, pair);
        const double before = glm::length(force);
        const dvec3 spring_before = contact.force;
        contact = done.contacts[0];
        force = done.forces[0].force;
        reasons = done.forces[0].reasons;
        const bool exact = settings.metric == TouchMetric::world;  // the paper's surface is a bit another
        ASSERT_FALSE(done.behind && exact);
        ASSERT_FALSE(exact && is_behind_surface(surface, contact.proxy, 1e-12)) << "tick " << number;
        ASSERT_TRUE(std::isfinite(glm::dot(force, force)));
        ASSERT_LE(glm::length(force), guard.max_force * (1 + 1e-12));
        ASSERT_LE(glm::length(force), glm::length(contact.force) * (1 + 1e-12));
        ASSERT_FALSE(contact.counts.capped);
        if (exact && contact.touching && field.scene.default_properties.static_friction == 0) {
            ASSERT_LT(reference::excess_over_minimum({field.scene, pair}, step->states()[0].proxy, goal),
                      1e-9L * (1 + glm::distance(contact.proxy, goal)));
        }
        // The pull from one valley to the next turns a force, which is no rise of the surface.
        const double spring = glm::length(contact.force), was = glm::length(spring_before);
        const double turn =
            contact.jumped || was == 0 ? 0.0 : glm::length(contact.force - spring_before * (spring / was));
        rise = glm::length(force) - before - turn;
        touching += contact.touching;
        jumped += contact.jumped;
    }

    Contact contact;
    dvec3 force{0.0};
    std::uint32_t reasons = 0;
    double rise = 0;  ///< of |force| since the tick before, but for what the solver's force turned by
    int touching = 0, jumped = 0;
};

TEST(SuddenSurface, NeverKicksFreeFinger) {
    Random random(21);
    for (const int levels : {1, 2, 3, 7, 20, 64, 128, 255})
        for (const double rough : {0.0, 0.5, 20.0}) {
            SCOPED_TRACE(std::to_string(levels) + " levels a tick, rough " + std::to_string(rough));
            Stage stage(FrameInterpolation::linear);
            const double level = stage.field.scene.depth.level();
            std::vector<double> grain(33 * 33);
            for (double& g : grain) g = random.within(-rough, rough);
            double most = 0;
            for (int sweep = 0; sweep < 3; ++sweep) {
                stage.begin();
                stage.force = dvec3(0.0);
                const dvec3 goal{random.within(-3, 3), random.within(-3, 3), random.within(-330, -250)};
                double depth = 370;
                for (int tick = 0; tick < 40; ++tick) {
                    stage.field.shape(stage.field.prev, [&](int x, int y) {
                        return std::max(60.0, depth) + grain[static_cast<std::size_t>(33 * y + x)];
                    });
                    const FramePair pair = still(stage.field.prev, tick, tick * 1'000'000);
                    ASSERT_NO_FATAL_FAILURE(stage.tick(tick, pair, goal));
                    most = std::max(most, stage.rise);
                    depth -= levels * level;
                }
            }
            EXPECT_GT(stage.touching, levels > 3 ? 20 : -1);
            EXPECT_LE(most, largest_rise);
        }
}

// The speed of a surface is its way over the time that has passed, however many ticks ran in it; but what
// came in a stall is no smoother for that.
TEST(SuddenSurface, SkippedTicksAreNotSudden) {
    const auto jumps = [](double metres_per_s, int every) {
        Stage stage(FrameInterpolation::linear);
        stage.begin();
        for (int tick = 0; tick <= 400; tick += every) {
            stage.field.fill(stage.field.prev, 200 - metres_per_s * tick);  // a unit is a millimetre
            stage.tick(tick, still(stage.field.prev, tick, tick * 1'000'000), {0, 0, -199});
        }
        EXPECT_GT(stage.touching, 1);
        return stage.jumped;
    };
    for (const int every : {1, 2, 10, 33}) EXPECT_EQ(jumps(0.09, every), 0) << every;
    for (const int every : {1, 2, 10, 33}) EXPECT_GT(jumps(0.11, every), 0) << every;
    EXPECT_GT(jumps(0.09, 100), 0) << "9 mm at once";
}

/// A hand that presses and wanders over frames that have nothing to do with each other.
class CutEveryFrame : public testing::TestWithParam<FrameInterpolation> {};

TEST_P(CutEveryFrame, NeverKicksOrLosesSurface) {
    const bool hold = GetParam() == FrameInterpolation::hold;
    Random random(hold ? 31 : 32);
    Stage stage(GetParam());
    const double spread[] = {4, 15, 60, 150};
    const auto cut = [&](SurfaceFrame& frame, std::int64_t n) {
        const double depth = 200 + random.within(-0.5, 0.5) * spread[n / 8 % 4];
        const double tilt_x = random.within(-0.4, 0.4), tilt_y = random.within(-0.4, 0.4);
        stage.field.shape(frame, [&](int x, int y) { return depth + tilt_x * (x - 16) + tilt_y * (y - 16); });
    };
    stage.begin();
    SurfaceFrame *prev = &stage.field.prev, *next = &stage.field.next;
    cut(*prev, 0);
    double most = 0;
    int felt = 0, blended = 0;
    std::int64_t n = -1;
    const FrameRate& rate = stage.field.scene.rate;
    const int ticks = 8000;
    dvec3 goal(0, 0, -150);
    for (int tick = 0; tick < ticks; ++tick) {
        const std::int64_t time_ns = tick * 1'000'000LL;
        while (rate.time_ns(n + 1) <= time_ns) {
            ++n;
            if (n > 0) std::swap(prev, next);
            cut(*next, n + 1);
        }
        const FramePair pair =
            pair_around(time_ns, rate, [&](std::int64_t m) { return m == n ? prev : next; });
        const dvec3 wanted(3 * std::sin(tick * 0.001), 2 * std::cos(tick * 0.0013),
                           -203 - 3 * std::sin(tick * 0.002));
        const dvec3 way = wanted - goal;
        const double step = std::min(1.0, 0.1 / (1e-9 + glm::length(way)));
        goal += way * step;  // at most 0.1 m/s
        ASSERT_NO_FATAL_FAILURE(stage.tick(tick, pair, goal)) << "tick " << tick;
        // 3.3 mm of a held frame are not sudden.
        most = std::max(most, stage.rise - newtons_per_unit * glm::length(way * step));
        felt += glm::length(stage.force) > 0.1;
        blended += (stage.reasons & guard_jump) != 0;
    }
    EXPECT_LE(most, hold ? newtons_per_unit * 3.34 : largest_rise);
    EXPECT_GT(stage.jumped, 40);
    EXPECT_GT(blended, 500);
    EXPECT_GT(felt, ticks / 20);
    EXPECT_GT(stage.touching, ticks / 4);
    std::cout << "largest rise " << most << " N, " << stage.jumped << " jumps, blended in " << blended
              << ", felt in " << felt << " of " << ticks << " ticks\n";
}

INSTANTIATE_TEST_SUITE_P(Frames, CutEveryFrame,
                         testing::Values(FrameInterpolation::hold, FrameInterpolation::linear), name_of_run);

/// A producer that publishes a wall at some depth; the finger presses on it.
class Producer {
public:
    explicit Producer(Stage& stage) : stage_(stage) { stage.begin(); }
    void publish(std::int64_t n, double depth) {
        SurfaceFrame* slot = timeline.acquire();
        ASSERT_NE(slot, nullptr);
        slot->width = slot->height = 33;
        slot->coding = stage_.field.scene.depth;
        slot->vertices = std::make_unique<ExactVertices>(33, 33, std::vector<double>(33 * 33, depth));
        ASSERT_TRUE(timeline.publish(n, stage_.field.scene.rate.time_ns(n)));
    }
    void tick(std::int64_t tick, const dvec3& goal) {
        FramePair pair;
        ASSERT_TRUE(timeline.pair_at(tick * 1'000'000, pair));
        ASSERT_NO_FATAL_FAILURE(stage_.tick(tick, pair, goal));
    }
    SurfaceTimeline timeline{4};

private:
    Stage& stage_;
};

TEST(SuddenSurface, StoppedProducerStandsStill) {
    for (const auto interpolation : {FrameInterpolation::hold, FrameInterpolation::linear}) {
        Stage stage(interpolation);
        Producer producer(stage);
        for (int n = 0; n < 3; ++n) producer.publish(n, 200 - 2.0 * n);  // 60 mm/s towards the hand
        const dvec3 goal(0, 0, -203);
        double most = 0;
        dvec3 standing(0.0);
        producer.tick(0, {0, 0, -190});
        for (int tick = 1; tick < 3000; ++tick) {
            ASSERT_NO_FATAL_FAILURE(producer.tick(tick, goal));
            if (tick > 1) most = std::max(most, stage.rise);
            if (tick == 67) standing = stage.force;
            if (tick > 67) {
                ASSERT_EQ(stage.force, standing) << "tick " << tick;
            }
        }
        EXPECT_NEAR(glm::length(standing), newtons_per_unit * 7, 1e-3);
        EXPECT_LE(most, newtons_per_unit * (interpolation == FrameInterpolation::hold ? 2.0001 : 0.0601));
        EXPECT_EQ(stage.reasons, 0U);
        EXPECT_EQ(stage.jumped, 0);
    }
}

TEST(SuddenSurface, LateFramesMakeNoKick) {
    for (const auto interpolation : {FrameInterpolation::hold, FrameInterpolation::linear})
        for (const bool dropped : {false, true}) {
            const bool is_held = interpolation == FrameInterpolation::hold;
            SCOPED_TRACE((is_held ? "held " : "linear ") + std::string(dropped ? "dropped" : "late"));
            Stage stage(interpolation);
            Producer producer(stage);
            // 45 mm/s
            const auto depth_of = [](std::int64_t n) { return 206 - 1.5 * static_cast<double>(n); };
            producer.publish(0, depth_of(0));
            std::int64_t published = 0;
            double most = 0;
            producer.tick(0, {0, 0, -190});
            for (int tick = 1; tick < 800; ++tick) {
                // Two frames ahead; but what is due from 100 to 300 ms comes at 300 ms, or never.
                const std::int64_t due = tick * 30 / 1000 + 2;
                while (published < std::min<std::int64_t>(due, 6)) {
                    if (published >= 2 && tick >= 100 && tick < 300) break;
                    ++published;
                    producer.publish(published, depth_of(published));
                }
                if (dropped && tick == 300) {
                    producer.publish(10, depth_of(10));
                    published = 99;
                }
                ASSERT_NO_FATAL_FAILURE(producer.tick(tick, {0, 0, -205}));
                if (tick > 1) most = std::max(most, stage.rise);
            }
            EXPECT_GT(stage.touching, 700);
            EXPECT_LE(most, is_held ? newtons_per_unit * 3.34 : largest_rise);
        }
}

/// A wall at some depth at a moment of the clip, pressed by a resting finger; ticks go on from call to call.
class PressedWall {
public:
    explicit PressedWall(FrameInterpolation interpolation = FrameInterpolation::linear)
        : stage(interpolation) {}
    /// The largest rise of force meanwhile.
    double press(int ticks, double depth, std::int64_t clip_ns, std::uint64_t epoch) {
        stage.field.fill(stage.field.prev, depth);
        FramePair pair = still(stage.field.prev, clip_ns / 33'000'000, clip_ns);
        pair.epoch = epoch;
        double most = 0;
        for (int k = 0; k < ticks; ++k) {
            stage.tick(tick_++, pair, {0, 0, -203});
            if (tick_ > 1) most = std::max(most, stage.rise);
        }
        return most;
    }
    double force() const { return glm::length(stage.force); }
    Stage stage;

private:
    std::int64_t tick_ = 0;
};

// 6 mm at 0.6 N/mm under a finger that rests 3 mm deep.
TEST(SuddenSurface, NewEpochIsAlwaysJump) {
    for (const TouchMetric metric : {TouchMetric::world, TouchMetric::pixel, TouchMetric::scaled})
        for (const std::int64_t clip_ns : {1'000'000'000LL, 500'000'000LL, 2'000'000'000LL}) {
            SCOPED_TRACE(std::string(name_of(metric)) + " to " + std::to_string(clip_ns));
            PressedWall wall;
            wall.stage.settings.metric = metric;
            wall.stage.begin();
            wall.press(200, 200, 1'000'000'000, 4);
            EXPECT_NEAR(wall.force(), 1.8, 1e-3);
            EXPECT_EQ(wall.stage.jumped, 0);
            EXPECT_LE(wall.press(150, 194, clip_ns, 5), 3.6 * 1.51 / JumpCancellation::fade_ticks);
            EXPECT_EQ(wall.stage.jumped, 1);
            EXPECT_NEAR(wall.force(), 5.4, 1e-3);
            EXPECT_LE(wall.press(10, 202, clip_ns, 6), 1e-12) << "what drops, drops at once";
            EXPECT_NEAR(wall.force(), 0.6, 1e-3);
        }
}

TEST(SuddenSurface, NewEpochRisesGently) {
    PressedWall wall;
    wall.stage.begin();
    wall.press(5, 210, 0, 0);
    EXPECT_EQ(wall.force(), 0);
    EXPECT_LE(wall.press(150, 193, 0, 1), 6.01 * 1.51 / JumpCancellation::fade_ticks);
    EXPECT_NEAR(wall.force(), 6, 2e-3);
    EXPECT_LE(wall.press(150, 160, 0, 2), 0) << "beyond the device's force: it fades to nothing";
    EXPECT_EQ(wall.force(), 0);
}

TEST(SuddenSurface, NewEpochStiffnessIsJump) {
    PressedWall wall;
    wall.stage.begin();
    wall.press(200, 200, 0, 0);
    wall.stage.field.scene.default_properties.stiffness = 630;  // 0.09 N: less than other stuff makes
    EXPECT_LE(wall.press(150, 200, 0, 1), 0.0901 * 1.51 / JumpCancellation::fade_ticks);
    EXPECT_EQ(wall.stage.jumped, 1);
    EXPECT_NEAR(wall.force(), 1.89, 1e-3);
}

// The surface's speed under the hand counts, not its speed before the camera.
TEST(SuddenSurface, PlaybackSpeedCounts) {
    const auto jumps = [](double metres_per_s, double rate) {
        PressedWall wall;
        wall.stage.begin();
        for (int tick = 0; tick < 60; ++tick)
            wall.press(1, 200 - metres_per_s * rate * tick, std::llround(1e6 * rate * tick), 0);
        return wall.stage.jumped;
    };
    EXPECT_EQ(jumps(0.5, 0.1), 0);
    EXPECT_GT(jumps(0.5, 1), 50);
    EXPECT_EQ(jumps(0.05, 1), 0);
    EXPECT_GT(jumps(0.05, 8), 50);
}

// Frames 100 ms apart in a clip that says 30 a second: 9 mm of a held frame are 0.09 m/s.
TEST(SuddenSurface, HeldFrameUsesFrameInterval) {
    for (const bool sudden : {false, true}) {
        Stage stage(FrameInterpolation::hold);
        stage.begin();
        for (int n = 0; n < 4; ++n) {
            stage.field.fill(stage.field.prev, 200 - (sudden ? 11 : 9) * n);
            FramePair pair;
            pair.prev = {n, n * 100'000'000LL, &stage.field.prev};
            pair.next = {n + 1, (n + 1) * 100'000'000LL, &stage.field.next};
            for (int tick = 100 * n; tick < 100 * (n + 1); ++tick) {
                pair.blend = 0.01 * (tick % 100);
                stage.tick(tick, pair, {0, 0, -199});
            }
        }
        EXPECT_EQ(stage.jumped, sudden ? 3 : 0);
    }
}

}  // namespace
}  // namespace touchable::test
