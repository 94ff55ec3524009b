// The C API gives the forces of the rooms behind it, to the bit: same frames, goals and times.
#include <gtest/gtest.h>

#include <string>

#include "capi/frames.hpp"
#include "engine/content/scenes.hpp"
#include "engine/frame/surface_timeline.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/force_hash.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "tests/capi/hill.hpp"
#include "tests/frame/allocations.hpp"

namespace touchable::test {
namespace {

constexpr int fingers = 3;
constexpr std::int64_t ticks = 400;

/// Frames of a moving scene with all planes, and a path over it.
class Globe {
public:
    Globe() {
        SceneOptions options;
        options.width = 96;
        options.height = 64;
        options.properties = true;
        auto made = make_scene("globe", options);
        EXPECT_TRUE(made.ok());
        analytic_ = std::move(*made);
        for (std::int64_t n = 0; n * 33 < ticks + 40; ++n) frames_.push_back(analytic_->frame(n));
    }
    const Scene& scene() const { return analytic_->scene(); }
    std::int64_t frames() const { return static_cast<std::int64_t>(frames_.size()); }
    const RawFrame& frame(std::int64_t n) const { return frames_[static_cast<std::size_t>(n)]; }
    double hand_scale() const { return *scene().device_metres_per_unit; }
    glm::dvec3 goal(std::int64_t tick, int finger) const {
        const double phase = static_cast<double>(tick) / 130 + finger;
        const double deep = scene().depth.far * 0.45 + scene().depth.near * 0.55;
        return {0.1 * deep * std::sin(phase), 0.1 * deep * std::cos(phase),
                -deep * (1 + 0.1 * std::sin(2 * phase))};
    }

private:
    std::unique_ptr<AnalyticScene> analytic_;
    std::vector<RawFrame> frames_;
};

std::uint64_t forces_of_the_rooms(const Globe& globe) {
    const Scene& scene = globe.scene();
    auto builder = make_reference_builder(scene);
    SurfaceTimeline timeline(4);
    TouchSettings settings;
    settings.metres_per_scene_unit = globe.hand_scale();
    const auto solver = TouchSolver::create(scene, settings);
    EXPECT_TRUE(solver.ok());
    TouchStep step(*solver, GuardSettings{}, fingers);
    ForceHash hash;
    FramePair pair;
    std::int64_t next = 0;
    for (std::int64_t tick = 0; tick < ticks; ++tick) {
        while (next < globe.frames() && timeline.newest_time() <= tick * 1'000'000) {
            const RawFrame raw = globe.frame(next++);
            EXPECT_TRUE(builder->build(raw, *timeline.acquire()).ok());
            EXPECT_TRUE(timeline.publish(raw.number, raw.time_ns).ok());
        }
        timeline.pair_at(tick * 1'000'000, pair);
        for (int k = 0; k < fingers; ++k) step.goals()[static_cast<std::size_t>(k)] = globe.goal(tick, k);
        for (const GuardedForce& force : step.run(tick, tick * 1'000'000, scene, pair).forces)
            hash.add(force.force);
    }
    return hash.value();
}

struct Touched {
    std::uint64_t hash = 0;
    double most = 0;
    std::size_t allocations = 0;  ///< in ticks
};

Touched forces_of_the_api(const Globe& globe, int threads) {
    const std::string text = scene_to_json(globe.scene());
    touch_error error{sizeof error, 0, {}};
    touch_scene scene{};
    EXPECT_EQ(touch_scene_from_text(text.data(), text.size(), &scene, &error), TOUCH_OK) << error.line;
    touch_surface_settings shape;
    touch_surface_settings_defaults(&shape, sizeof shape);
    shape.threads = threads;
    touch_surface surface{};
    EXPECT_EQ(touch_surface_create(scene, &shape, &surface, &error), TOUCH_OK) << error.line;
    touch_solver_settings settings;
    touch_solver_settings_defaults(&settings, sizeof settings);
    settings.fingers = fingers;
    settings.metres_per_scene_unit = globe.hand_scale();
    touch_solver solver{};
    EXPECT_EQ(touch_solver_create(surface, &settings, &solver, &error), TOUCH_OK) << error.line;
    Touched touched;
    std::int64_t next = 0;
    for (std::int64_t tick = 0; tick < ticks; ++tick) {
        std::int64_t newest = 0;
        while (touch_surface_newest_ns(surface, &newest),
               next < globe.frames() && newest <= tick * 1'000'000) {
            const RawFrame raw = globe.frame(next++);
            touch_frame frame;
            touch_frame_defaults(&frame, sizeof frame);
            frame.number = raw.number;
            frame.time_ns = raw.time_ns;
            frame.depth = capi::plane_for_program(raw.depth);
            frame.haptic = capi::plane_for_program(raw.haptic);
            frame.height = capi::plane_for_program(raw.height);
            EXPECT_EQ(touch_surface_push(surface, &frame, &error), TOUCH_OK) << error.line;
        }
        touch_vec3 goals[fingers];
        for (int k = 0; k < fingers; ++k) {
            const glm::dvec3 goal = globe.goal(tick, k);
            goals[k] = {goal.x, goal.y, goal.z};
        }
        touch_contact contacts[fingers];
        const touch_tick at = tick_at(tick);
        const std::size_t before = allocations();
        EXPECT_EQ(touch_solver_tick(solver, &at, goals, contacts, sizeof contacts[0]), TOUCH_OK);
        touched.allocations += allocations() - before;
        for (const touch_contact& contact : contacts)
            touched.most = std::max(touched.most, std::abs(contact.force_n.z));
    }
    EXPECT_EQ(touch_solver_force_hash(solver, &touched.hash), TOUCH_OK);
    EXPECT_EQ(touch_solver_destroy(solver), TOUCH_OK);
    EXPECT_EQ(touch_surface_destroy(surface), TOUCH_OK);
    EXPECT_EQ(touch_scene_destroy(scene), TOUCH_OK);
    return touched;
}

TEST(SameForces, AsTheRoomsBehindToTheBit) {
    const Globe globe;
    const std::uint64_t expected = forces_of_the_rooms(globe);
    for (const int threads : {1, 3}) {
        const Touched touched = forces_of_the_api(globe, threads);
        EXPECT_EQ(touched.hash, expected) << "with threads: " << threads;
        EXPECT_GT(touched.most, 0.5) << "hardly anything was touched";
        EXPECT_EQ(touched.allocations, 0U);
    }
}

TEST(SameForces, BatchesAreTicks) {
    TouchedHill one, many;
    std::vector<touch_vec3> goals;
    std::vector<touch_contact> singly(500), together(500);
    for (std::int64_t tick = 0; tick < 500; ++tick) {
        goals.push_back(goal_at(tick));
        const touch_tick at = tick_at(tick);
        ASSERT_EQ(touch_solver_tick(one.solver, &at, &goals.back(), &singly[static_cast<std::size_t>(tick)],
                                    sizeof(touch_contact)),
                  TOUCH_OK);
    }
    const touch_tick first = tick_at(0);
    const std::size_t before = allocations();
    ASSERT_EQ(
        touch_solver_run(many.solver, &first, 500, goals.data(), together.data(), sizeof(touch_contact)),
        TOUCH_OK);
    std::uint64_t hash = 0, same = 1;
    std::int64_t newest = 0;
    touch_scene_facts facts;
    facts.struct_size = sizeof facts;
    touch_solver_force_hash(one.solver, &hash);
    touch_solver_force_hash(many.solver, &same);
    touch_solver_come_back(many.solver);
    touch_surface_newest_ns(many.surface, &newest);
    touch_scene_describe(many.scene, &facts);
    EXPECT_EQ(allocations(), before) << "what is said to be real-time";
    EXPECT_EQ(hash, same);
    double most = 0;
    for (std::size_t k = 0; k < singly.size(); ++k) {
        EXPECT_EQ(singly[k].force_n.z, together[k].force_n.z);
        most = std::max(most, singly[k].force_n.z);
    }
    EXPECT_GT(most, 0.5);
}

/// Floats of metres are the codes that they round to; rows from below, and at odd places, are the same
/// picture.
TEST(SameForces, WhateverMemoryDepthLiesIn) {
    const Hill hill;
    std::vector<float> metres;
    for (const std::uint16_t code : hill.codes()) metres.push_back(static_cast<float>(code) * 0.001F);
    constexpr std::size_t row = 2 * Hill::width, rows = Hill::height;
    std::vector<std::uint8_t> upside_down(row * rows), odd(row * rows + 1);
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(hill.codes().data());
    for (std::size_t y = 0; y < rows; ++y)
        std::copy_n(bytes + row * y, row, upside_down.data() + row * (rows - 1 - y));
    std::copy_n(bytes, row * rows, odd.data() + 1);
    const touch_plane planes[] = {
        hill.frame().depth,
        {metres.data(), 4 * Hill::width, Hill::width, Hill::height, TOUCH_F32, 1},
        {upside_down.data() + row * (rows - 1), -static_cast<std::int64_t>(row), Hill::width, Hill::height,
         TOUCH_U16, 1},
        {odd.data() + 1, row, Hill::width, Hill::height, TOUCH_U16, 1},
    };
    std::vector<std::uint64_t> hashes;
    for (const touch_plane& plane : planes) {
        TouchedHill touched;
        touch_frame frame = hill.frame(1);
        frame.depth = plane;
        touch_error error{sizeof error, 0, {}};
        ASSERT_EQ(touch_surface_push(touched.surface, &frame, &error), TOUCH_OK) << error.line;
        for (std::int64_t tick = 40; tick < 300; ++tick) {
            const touch_tick at = tick_at(tick);
            const touch_vec3 goal = goal_at(tick);
            touch_contact contact;
            ASSERT_EQ(touch_solver_tick(touched.solver, &at, &goal, &contact, sizeof contact), TOUCH_OK);
        }
        hashes.emplace_back();
        touch_solver_force_hash(touched.solver, &hashes.back());
    }
    for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes.front());
}

}  // namespace
}  // namespace touchable::test
