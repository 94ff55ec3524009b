// The solver on fields that have no mercy: uniform noise, cliffs, and grain, under a goal that jumps.
#include <gtest/gtest.h>

#include "engine/content/height_fields.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/reference/certificate.hpp"

namespace touchable::test {
namespace {

struct NoiseCase {
    const char* scene;
    int bits;
    double friction;
};

void PrintTo(const NoiseCase& c, std::ostream* out) {
    *out << c.scene << ' ' << c.bits << " bits, mu " << c.friction;
}

class Noise : public testing::TestWithParam<NoiseCase> {};

TEST_P(Noise, ProxyNeverGoesBehindAndEndsAtAMinimum) {
    SceneOptions options;
    options.width = options.height = 128;
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

INSTANTIATE_TEST_SUITE_P(Fields, Noise,
                         testing::Values(NoiseCase{"noise", 8, 0}, NoiseCase{"noise", 16, 0},
                                         NoiseCase{"cliffs", 8, 0}, NoiseCase{"grain", 8, 0},
                                         NoiseCase{"noise", 8, 0.6}, NoiseCase{"grain", 8, 0.6}));

}  // namespace
}  // namespace touchable::test
