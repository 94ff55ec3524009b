// A tick allocates nothing, with one finger or ten, in the air or on the ground, at still and at moving
// surfaces.
#include <gtest/gtest.h>

#include "engine/content/height_fields.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "tests/frame/allocations.hpp"
#include "tests/haptics/touch_rig.hpp"

namespace touchable::test {
namespace {

using MakeBuilder = std::unique_ptr<SurfaceBuilder> (*)(const Scene&);

std::size_t allocations_in_ticks(MakeBuilder make_builder) {
    SceneOptions options;
    options.width = 320;
    options.height = 240;
    options.properties = true;
    const auto content = std::move(make_scene("globe", options)).value();
    Scene scene = content->scene();
    scene.filter.median = 5;
    scene.filter.fill_holes = 1;
    std::vector<SurfaceFrame> frames(2);
    const auto builder = make_builder(scene);
    for (int n : {0, 1}) EXPECT_TRUE(builder->build(content->frame(n), frames[static_cast<std::size_t>(n)]));
    TouchSettings settings;
    settings.metres_per_scene_unit = *scene.device_metres_per_unit;
    settings.stribeck_speed = 0.05;
    const auto solver = TouchSolver::create(scene, settings);
    const GlobeStroke stroke(options.preset, options.width, options.height);
    std::vector<glm::dvec3> goals(10);
    std::vector<FingerState> fingers(10);
    std::vector<Contact> contacts(10);
    GuardSettings everything;
    everything.rise.paid = true;
    everything.damping = 1;
    everything.passivity = 10;
    std::vector<ForceGuard> guards(10, ForceGuard(everything, settings.metres_per_scene_unit));

    int touching = 0;
    const std::size_t before = allocations();
    for (int tick = 0; tick < 2000; ++tick) {
        const FramePair pair{{0, 0, &frames[0]}, {1, 1, &frames[1]}, tick % 100 * 0.01};
        for (std::size_t k = 0; k < goals.size(); ++k)
            goals[k] = stroke.at((tick + 100 * static_cast<int>(k)) % 2000).goal;
        solver.value().tick(HeightField(scene, pair), goals, fingers, contacts);
        for (std::size_t k = 0; k < goals.size(); ++k) {
            guards[k].guard(contacts[k]);
            touching += contacts[k].touching;
        }
    }
    const std::size_t during = allocations() - before;
    EXPECT_GT(touching, 10000);
    return during;
}

TEST(NoAllocation, InATickOnAFilteredFrame) {
    EXPECT_EQ(allocations_in_ticks([](const Scene& scene) { return make_cpu_builder(scene); }), 0U);
}
TEST(NoAllocation, InATickOnALazyFrame) {
    EXPECT_EQ(allocations_in_ticks(make_lazy_builder), 0U);
}

TEST(NoAllocation, TheCounterCounts) {
    const std::size_t before = allocations();
    std::vector<int> grown(100);
    grown.resize(1000);
    EXPECT_EQ(allocations() - before, 2U);
}

/// Not one for each tick that it has room for: it is made between two sessions of a hand.
TEST(NoAllocation, OfALogOfTicksButAFew) {
    const std::size_t before = allocations();
    const TickLog log(4096, 5);
    EXPECT_LE(allocations() - before, 8U);
}

}  // namespace
}  // namespace touchable::test
