// SPDX-License-Identifier: Apache-2.0
// Does the force point where the true surface's normal points, and does the proxy follow the hand?

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/content/exact_touch.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/reference/solver.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

constexpr double degrees = 180.0 / 3.14159265358979323846;

/// Root mean square of the angle between force and true normal, in degrees, over polar angles 0-15, 15-30,
/// 30-45, 45-58.1, and over all.
struct AngleHistogram {
    std::array<double, 5> sum{};
    std::array<int, 5> count{};

    void add(double polar_degrees, double angle) {
        const std::size_t bin = polar_degrees < 45 ? static_cast<std::size_t>(polar_degrees / 15) : 3;
        for (const std::size_t k : {bin, std::size_t{4}}) {
            sum[k] += angle * angle;
            ++count[k];
        }
    }
    double rms(std::size_t k) const { return count[k] ? std::sqrt(sum[k] / count[k]) : 0; }
};

/// By default of preset B, 720x480, 16 bits.
AngleHistogram globe_error(const SceneOptions& options, TouchRig::Depth depth, TouchMetric metric,
                           int& not_touching) {
    TouchRig rig("globe", options, depth);
    rig.settings.metric = metric;
    const GlobeStroke stroke(options.preset, options.width, options.height);
    AngleHistogram histogram;
    for (int tick = 0; tick < GlobeStroke::approach_ticks + GlobeStroke::stroke_ticks; ++tick) {
        const auto goal = stroke.at(tick);
        const Contact& contact = rig.tick(goal.goal);
        if (tick < GlobeStroke::approach_ticks) continue;
        if (!contact.touching) {
            ++not_touching;
            continue;
        }
        const dvec3 f = contact.force / length(contact.force);
        const double angle = 2 * std::asin(std::min(1.0, length(f - goal.normal) / 2)) * degrees;
        histogram.add(goal.polar_angle * degrees, angle);
    }
    std::cout << "force direction error, degrees RMS: 0-15 " << histogram.rms(0) << ", 15-30 "
              << histogram.rms(1) << ", 30-45 " << histogram.rms(2) << ", 45-58 " << histogram.rms(3)
              << ", all " << histogram.rms(4) << '\n';
    return histogram;
}

TEST(Accuracy, GlobeForceFollowsTrueNormal) {
    int not_touching = 0;
    const auto histogram = globe_error({}, TouchRig::Depth::codes, TouchMetric::world, not_touching);
    EXPECT_EQ(not_touching, 0);
    for (const int count : histogram.count) EXPECT_GT(count, 500);
    EXPECT_LT(histogram.rms(4), 2.5);
    // Facets make the error grow towards the limb.
    EXPECT_LT(histogram.rms(0), 0.5);
    EXPECT_LT(histogram.rms(2), 1.0);
}

TEST(Accuracy, PixelMetricErrsFarMore) {
    int not_touching = 0;
    const auto histogram = globe_error({}, TouchRig::Depth::codes, TouchMetric::pixel, not_touching);
    EXPECT_GT(histogram.count[4], 15000);
    // 49 degrees was measured for preset B with an independent prototype.
    EXPECT_GT(histogram.rms(4), 40);
    EXPECT_LT(histogram.rms(4), 60);
}

struct ScaledError {
    CameraPreset preset;
    double least, most;  // degrees
};
class ScaledMetric : public testing::TestWithParam<ScaledError> {};

// 0.45, 2.0 and 3.6 degrees were measured with an independent prototype. What is left is the slant of the
// rays, so it grows with the field of view.
TEST_P(ScaledMetric, ErrsFewDegrees) {
    SceneOptions options;
    options.preset = GetParam().preset;
    int not_touching = 0;
    const auto histogram = globe_error(options, TouchRig::Depth::exact, TouchMetric::scaled, not_touching);
    EXPECT_EQ(not_touching, 0);
    EXPECT_GT(histogram.rms(4), GetParam().least);
    EXPECT_LT(histogram.rms(4), GetParam().most);
}

INSTANTIATE_TEST_SUITE_P(Cameras, ScaledMetric,
                         testing::Values(ScaledError{CameraPreset::a, 0, 0.45},
                                         ScaledError{CameraPreset::a_prime, 0.7, 2.0},
                                         ScaledError{CameraPreset::b, 1.8, 3.6}));

/// Two fingers a way apart, so with different scales, and each of them alone.
TEST(ScaledMetric, KeepsScalePerFinger) {
    SceneOptions options;
    const GlobeStroke stroke(options.preset, options.width, options.height);
    TouchRig rig("globe", options, TouchRig::Depth::codes);
    TouchSettings settings = rig.settings;
    settings.metric = TouchMetric::scaled;
    const auto solver = TouchSolver::create(rig.scene(), settings);
    std::array<FingerState, 2> both, alone;
    std::array<Contact, 2> contacts;
    int touching = 0;
    for (int tick = 0; tick < 2000; ++tick) {
        const std::array goals{stroke.at(tick).goal, stroke.at(tick + 5000).goal};
        solver.value().tick(rig.field(), goals, both, contacts);
        for (std::size_t k = 0; k < 2; ++k) {
            const Contact contact = tick_one(*solver, rig.field(), alone[k], goals[k]);
            ASSERT_EQ(contact.force, contacts[k].force) << "tick " << tick << ", finger " << k;
            touching += contact.touching;
        }
    }
    EXPECT_GT(touching, 3000);
}

class BumpsStroke : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(BumpsStroke, StaysOnSurface) {
    const auto& [width, height] = GetParam();
    TouchRig rig("bumps", sized(width, height), TouchRig::Depth::codes);
    rig.scene().default_properties = {600, 0, 0};
    const ExactSurface exact("bumps");
    ReliefStroke stroke(Relief::bumps, width, height, 0.3);
    const int ticks = 10000;
    int touching = 0, off = 0;
    double worst = 0;
    dvec3 truth(0.0);
    bool tracking = false;
    for (int tick = 0; tick < ticks; ++tick) {
        const auto goal = stroke.next();
        const Contact& contact = rig.tick(goal.goal);
        if (goal.under <= 0) continue;
        ++touching;
        ASSERT_TRUE(contact.touching) << "tick " << tick;
        truth = exact.closest(goal.goal, tracking ? truth : contact.proxy, 0)->point;
        tracking = true;
        const double distance = length(contact.proxy - truth);
        worst = std::max(worst, distance);
        off += distance > 2.0;
    }
    EXPECT_GT(touching, ticks / 2);
    EXPECT_EQ(off, 0) << "worst distance " << worst << " mm";
    std::cout << width << 'x' << height << ": worst distance " << worst << " mm\n";
}

INSTANTIATE_TEST_SUITE_P(Bumps, BumpsStroke,
                         testing::Values(std::pair{320, 240}, std::pair{720, 480}, std::pair{1280, 720},
                                         std::pair{1920, 1080}));

// The solver on rough fields: uniform noise, cliffs, and grain, under a goal that jumps.

struct NoiseCase {
    const char* scene;
    int bits;
    double friction;
};

void PrintTo(const NoiseCase& c, std::ostream* out) {
    *out << c.scene << ' ' << c.bits << " bits, mu " << c.friction;
}

class RoughField : public testing::TestWithParam<NoiseCase> {};

TEST_P(RoughField, ProxyRestsAtMinimum) {
    SceneOptions options = sized(128, 128);
    options.bits = GetParam().bits;
    TouchRig rig(GetParam().scene, options, TouchRig::Depth::codes);
    rig.scene().default_properties = {1000, GetParam().friction, GetParam().friction * 0.7};
    RandomWalk walk(rig.scene(), 7);

    const int ticks = 60000;
    int touching = 0, capped = 0, leaves = 0, most_events = 0;
    long double worst_excess = 0, worst_deficit = 0;
    bool touched = false;
    for (int tick = 0; tick < ticks; ++tick) {
        const Contact& contact = rig.tick(walk.next());
        ASSERT_TRUE(std::isfinite(length(contact.proxy))) << "tick " << tick;
        most_events = std::max(most_events, contact.counts.events);
        leaves += touched && !contact.touching;
        touched = contact.touching;
        capped += contact.counts.capped;
        const reference::Surface surface(rig.scene(), rig.pair);
        worst_deficit = std::max(worst_deficit, reference::depth_behind(surface, contact.proxy));
        if (!touched) continue;
        ++touching;
        if (contact.counts.capped || GetParam().friction > 0) continue;
        const long double excess = reference::excess_over_minimum(surface, rig.finger().proxy, contact.goal);
        ASSERT_LT(excess, 1e-9L * (1 + length(contact.proxy - contact.goal)))
            << "tick " << tick << " feature " << static_cast<int>(rig.finger().proxy.feature) << " at ("
            << rig.finger().proxy.x() << ", " << rig.finger().proxy.y() << "), " << contact.counts.events
            << " events, goal " << contact.goal.x << ' ' << contact.goal.y << ' ' << contact.goal.z
            << " proxy " << contact.proxy.x << ' ' << contact.proxy.y << ' ' << contact.proxy.z;
        worst_excess = std::max(worst_excess, excess);
    }
    RecordProperty("touching", touching);
    RecordProperty("most_events", most_events);
    EXPECT_LT(worst_deficit, 1e-9L);
    EXPECT_GT(touching, ticks / 10) << "the run was nearly empty";
    EXPECT_GT(leaves, 20) << "the run never left the surface";
    EXPECT_EQ(capped, 0) << "most events in a tick: " << most_events;
    std::cout << GetParam().scene << ": touching " << touching << " of " << ticks << ", most events "
              << most_events << ", excess " << static_cast<double>(worst_excess) << ", q deficit "
              << static_cast<double>(worst_deficit) << '\n';
}

/// A scene in units 2^k times as long has the same touch to the bit: no length in the solver is absolute.
TEST(RoughGround, IgnoresUnitOfLength) {
    for (const double scale : {0x1p-40, 0x1p-8, 0x1p40}) {
        SmallField one(24, 24, 100.0, DepthSemantics::planar), other(24, 24, 100.0, DepthSemantics::planar);
        Random random(8);
        std::vector<double> depths(24 * 24);
        for (double& depth : depths) depth = 60.0 + random.within(0, 60);
        const auto depth = [&](int x, int y) { return depths[static_cast<std::size_t>(24 * y + x)]; };
        one.shape(one.prev, depth);
        other.scene.depth.near *= scale;
        other.scene.depth.far *= scale;
        other.prev.coding = other.next.coding = other.scene.depth;
        other.shape(other.prev, [&](int x, int y) { return depth(x, y) * scale; });
        TouchSettings settings, scaled;
        scaled.metres_per_scene_unit = settings.metres_per_scene_unit / scale;
        FingerState finger, scaled_finger;
        int touching = 0;
        for (int tick = 0; tick < 20000; ++tick) {
            const dvec3 goal = unproject(one.scene.camera, random.within(-2, 26), random.within(-2, 26),
                                         random.within(50, tick % 3 ? 150 : 70));
            const Contact contact = one.touch(finger, goal, 0, settings);
            const Contact same = other.touch(scaled_finger, goal * scale, 0, scaled);
            ASSERT_EQ(contact.proxy * scale, same.proxy) << "tick " << tick;
            ASSERT_EQ(contact.counts.events, same.counts.events) << "tick " << tick;
            touching += contact.touching;
        }
        EXPECT_GT(touching, 5000);
    }
}

INSTANTIATE_TEST_SUITE_P(Fields, RoughField,
                         testing::Values(NoiseCase{"noise", 8, 0}, NoiseCase{"noise", 16, 0},
                                         NoiseCase{"cliffs", 8, 0}, NoiseCase{"grain", 8, 0},
                                         NoiseCase{"noise", 8, 0.6}, NoiseCase{"grain", 8, 0.6}));

}  // namespace
}  // namespace touchable::test
