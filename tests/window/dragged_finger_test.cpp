// A finger that is pressed and dragged goes on to what is under the pointer, whatever is in its way; and
// feels what is on its way as before.
#include "tests/window/dragged_finger.hpp"

namespace touchable::test {
namespace {

constexpr int rows = 20;
constexpr double pixels_per_s = 400;

/// Nowhere caught: seldom at the greatest force, never far from where the pointer means it.
void expect_free(const Dragged& dragged) {
    EXPECT_LE(dragged.limit_share(), 0.05);
    EXPECT_LT(dragged.quantile(0.95), 0.02);
    EXPECT_EQ(dragged.behind, 0) << "it went through the surface";
    EXPECT_EQ(dragged.beyond_camera, 0);
    EXPECT_GT(dragged.touching, dragged.ticks / 8) << "it only went over it";
}

struct DraggedClip {
    const char *name, *file, *scene;  ///< below the test data; of tests/scenes, empty: the clip's own
};

class DraggedOverRecording : public ::testing::TestWithParam<DraggedClip> {};

TEST_P(DraggedOverRecording, IsNotCaught) {
    const auto file = real_data(GetParam().file);
    TOUCHABLE_NEEDS_DATA(file);
    const auto clip = built_recording(file, GetParam().scene);
    expect_free(DraggedFinger(*clip).sweep(rows, pixels_per_s));
}

INSTANTIATE_TEST_SUITE_P(, DraggedOverRecording,
                         ::testing::Values(DraggedClip{"castel_sr300", "castel_sr300", "castel_sr300"},
                                           DraggedClip{"cube", "visp_cube_realsense", "visp_cube_realsense"},
                                           DraggedClip{"redwood5", "stills/redwood5", "redwood5"},
                                           DraggedClip{"icl_nuim5", "stills/icl_nuim5", "icl_nuim5"},
                                           DraggedClip{"depthkit", "depthkit_typing/Test.mov", ""}),
                         [](const auto& run) { return std::string(run.param.name); });

class DraggedOverScene : public ::testing::TestWithParam<const char*> {};

TEST_P(DraggedOverScene, IsNotCaught) {
    const auto clip = built_scene(GetParam(), 720, 480);
    expect_free(DraggedFinger(*clip).sweep(rows, pixels_per_s));
}

/// Walls are not drawn there, and in the way of sight.
TEST_P(DraggedOverScene, IsNotCaughtSeenFromTheSide) {
    const auto clip = built_scene(GetParam(), 720, 480);
    DraggedFinger finger(*clip);
    finger.view().turn(35, 15);
    expect_free(finger.sweep(rows, pixels_per_s));
}

TEST_P(DraggedOverScene, IsNotCaughtByAFlick) {
    const auto clip = built_scene(GetParam(), 720, 480);
    const Dragged dragged = DraggedFinger(*clip).sweep(rows, 5 * pixels_per_s);
    EXPECT_LE(dragged.limit_share(), 0.05);
    EXPECT_EQ(dragged.behind, 0);
}

INSTANTIATE_TEST_SUITE_P(, DraggedOverScene, ::testing::Values("globe", "spheres", "step"),
                         [](const auto& run) { return std::string(run.param); });

/// What a finger feels that is led by the pointer, as `settings` say, and that goes over nothing.
std::vector<glm::dvec3> forces_of_stroke(const BuiltClip& clip, const PointerSettings& settings,
                                         bool goes_over, double row, double speed) {
    DraggedFinger finger(clip, settings, goes_over);
    std::vector<glm::dvec3> forces;
    const glm::dvec2 from(480, row), to(800, row);
    const auto keep = [&](const TouchTick& tick) { forces.push_back(tick.forces[0].force); };
    finger.drag(from, to, speed, keep, 2000);
    return forces;
}

/// On land and sea, strokes of 5 to 67 mm/s: friction that sticks, and relief.
TEST(DraggedFinger, FeelsFrictionAndReliefAsWithoutAllThat) {
    const auto globe = built_scene("globe", 720, 480);
    for (const double speed : {30.0, 120.0, 400.0})
        for (const double row : {250.0, 360.0, 470.0}) {
            const auto felt = forces_of_stroke(*globe, {}, true, row, speed);
            const auto plain = forces_of_stroke(*globe, {.leash = 1}, false, row, speed);
            ASSERT_EQ(felt.size(), plain.size());
            double difference = 0, newtons = 0, change = 0;
            for (std::size_t k = 1; k < felt.size(); ++k) {
                difference += glm::dot(felt[k] - plain[k], felt[k] - plain[k]);
                newtons += glm::dot(plain[k], plain[k]);
                change += glm::length(plain[k] - plain[k - 1]);
            }
            EXPECT_GT(change, 0.1) << "nothing was felt there";
            EXPECT_LT(std::sqrt(difference / newtons), 0.01) << speed << " pixels/s, row " << row;
        }
}

/// A ledge that is no step is felt before it is gone over.
TEST(DraggedFinger, FeelsALedge) {
    const auto ledges = built_scene("step", 720, 480);
    DraggedFinger finger(*ledges);
    double most = 0;
    finger.drag({200, 360}, {1000, 360}, 100,
                [&](const TouchTick& tick) { most = std::max(most, glm::length(tick.forces[0].force)); });
    EXPECT_GT(most, 4);
    EXPECT_LT(most, 0.9 * DraggedFinger::max_newtons);
}

}  // namespace
}  // namespace touchable::test
