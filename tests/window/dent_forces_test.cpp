// A surface that gives way in the picture is felt, and pointed at, as one that does not.
#include "haptics_cpu/touch_step.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/pictures.hpp"
#include "tests/window/dragged_finger.hpp"

namespace touchable::test {
namespace {

/// All that came of a drag.
struct Felt {
    std::string forces;  // their hash
    std::vector<glm::dvec3> goals, picks;
    std::vector<std::uint8_t> last_picture;
};

/// Over the globe, with friction, while it is drawn 60 times a second.
Felt felt_where(bool is_dented) {
    const auto clip = built_scene("globe", 180, 120);
    DraggedFinger finger(*clip);
    CpuDrawing drawing;
    Felt felt;
    ForceHash forces;
    const Viewpoint::Subject subject = subject_of(HeightField(clip->scene, clip->pair(0)));
    const MarkSizes sizes = mark_sizes(clip->scene, subject.middle);
    const ViewCamera camera = finger.camera();
    finger.drag({560, 330}, {760, 390}, 600, [&](const TouchTick& tick) {
        for (const GuardedForce& force : tick.forces) forces.add(force.force);
        felt.goals.insert(felt.goals.end(), tick.goals.begin(), tick.goals.end());
        if (tick.tick % 100 != 0) return;
        const HeightField field(clip->scene, tick.pair);
        FingerMark mark{tick.contacts[0].goal, tick.contacts[0].proxy, tick.forces[0].force,
                        tick.contacts[0].touching};
        mark.under = under_finger(field, mark.proxy, sizes.finger_radius);
        if (is_dented)
            mark.given_way =
                given_way(mark.force, tick.contacts[0].properties.stiffness, tick.metres_per_scene_unit);
        drawing.show(field, tick.pair, {}, Lighting::lit);
        const auto picture = drawing.draw(camera, std::span(&mark, 1), sizes);
        ASSERT_TRUE(picture);
        felt.last_picture = (*picture)->samples;
        if (const auto at = camera.project(mark.proxy))
            if (const auto met = pick(field, camera, at->x, at->y)) felt.picks.push_back(met->point);
    });
    felt.forces = forces.hex();
    return felt;
}

TEST(Dents, ChangeNoForceAndNoPick) {
    const Felt flat = felt_where(false), dented = felt_where(true);
    EXPECT_EQ(dented.forces, flat.forces);
    EXPECT_EQ(dented.goals, flat.goals);
    EXPECT_EQ(dented.picks, flat.picks);
    EXPECT_GE(flat.picks.size(), 3U);
    EXPECT_NE(dented.last_picture, flat.last_picture) << "there was no dent";
}

}  // namespace
}  // namespace touchable::test
