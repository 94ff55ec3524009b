// The C++ wrapper is the C API: same forces, objects that end themselves, errors that are thrown.
#include "capi/touchable.hpp"

#include <gtest/gtest.h>

#include <type_traits>

#include "tests/capi/hill.hpp"

namespace touchable::test {
namespace {

std::uint64_t hash_of(touch::Solver& solver) {
    for (std::int64_t tick = 0; tick < 300; ++tick) {
        const touch_vec3 goal = goal_at(tick);
        touch_contact contact;
        EXPECT_EQ(solver.tick(touch::tick_at(tick), &goal, &contact), TOUCH_OK);
    }
    return solver.force_hash();
}

TEST(Wrapper, GivesTheSameForces) {
    const Hill hill;
    touch::Scene scene(Hill::camera());
    touch::Surface surface(scene);
    EXPECT_TRUE(surface.push(hill.frame()));
    touch::Solver solver(surface);
    TouchedHill touched;
    for (std::int64_t tick = 0; tick < 300; ++tick) {
        const touch_tick at = tick_at(tick);
        const touch_vec3 goal = goal_at(tick);
        touch_contact contact;
        ASSERT_EQ(touch_solver_tick(touched.solver, &at, &goal, &contact, sizeof contact), TOUCH_OK);
    }
    std::uint64_t expected = 0;
    touch_solver_force_hash(touched.solver, &expected);
    EXPECT_EQ(hash_of(solver), expected);
}

TEST(Wrapper, EndsWhatItMadeAndThrowsWhatIsRefused) {
    static_assert(!std::is_copy_constructible_v<touch::Surface>);
    touch_surface left{};
    {
        const touch::Scene scene(Hill::camera());
        EXPECT_EQ(touch::Scene(scene.text()).text(), scene.text());
        touch::Surface surface(scene);
        touch::Surface moved(std::move(surface));
        left = moved.get();
        EXPECT_THROW(moved.hand_scale(), touch::Error) << "no frame yet";
        EXPECT_TRUE(moved.push(Hill().frame()));
        EXPECT_GT(moved.hand_scale(), 0);
        EXPECT_THROW(moved.push(Hill().frame()), touch::Error) << "not later";
    }
    EXPECT_EQ(touch_surface_destroy(left), TOUCH_STALE);
    try {
        const touch::Scene scene(std::string_view("{}"));
        FAIL() << "no scene at all";
    } catch (const touch::Error& error) {
        EXPECT_EQ(error.status(), TOUCH_INPUT);
        EXPECT_GT(std::string(error.what()).size(), 10U);
    }
}

}  // namespace
}  // namespace touchable::test
