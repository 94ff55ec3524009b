// Random calls in random order: sizes that cannot be, NULL, handles of others and of the dead, numbers that
// are none, huge counts. Each gives a status; sanitizers see to the rest.
#include <gtest/gtest.h>

#include <array>

#include "tests/capi/hill.hpp"
#include "tests/capi/spoiled_values.hpp"

namespace touchable::test {
namespace {

/// A program that does everything wrong, sometimes.
class Hostile : SpoiledValues {
public:
    explicit Hostile(unsigned seed) : SpoiledValues(seed) {}
    ~Hostile() {
        for (const touch_solver solver : solvers_) touch_solver_destroy(solver);
        for (const touch_surface surface : surfaces_) touch_surface_destroy(surface);
        for (const touch_scene scene : scenes_) touch_scene_destroy(scene);
    }

    touch_status call() {
        using Call = touch_status (Hostile::*)();
        static constexpr std::array<Call, 16> calls{&Hostile::defaults,
                                                    &Hostile::scene_from_camera,
                                                    &Hostile::scene_from_text,
                                                    &Hostile::scene_text,
                                                    &Hostile::describe,
                                                    &Hostile::with_filters,
                                                    &Hostile::end_something,
                                                    &Hostile::surface,
                                                    &Hostile::push,
                                                    &Hostile::push,
                                                    &Hostile::epochs,
                                                    &Hostile::scale,
                                                    &Hostile::solver,
                                                    &Hostile::forces_at,
                                                    &Hostile::tick,
                                                    &Hostile::tick};
        return (this->*calls[upto(calls.size())])();
    }

private:
    touch_status scene_from_camera() {
        touch_camera camera = Hill::camera();
        camera.struct_size = spoilt(camera.struct_size);
        camera.width = spoilt(camera.width);
        camera.fx_px = spoilt(camera.fx_px);
        camera.cy_px = spoilt(camera.cy_px);
        camera.metres_per_code = spoilt(camera.metres_per_code);
        camera.far_m = spoilt(camera.far_m);
        camera.frames_per_second = spoilt(camera.frames_per_second);
        camera.stiffness_n_per_m = spoilt(camera.stiffness_n_per_m);
        touch_scene made{};
        const touch_status status = touch_scene_from_camera(or_null(&camera), or_null(&made), error());
        if (status == TOUCH_OK) scenes_.push_back(made);
        return status;
    }
    touch_status scene_from_text() {
        std::string text = R"({"touchable_scene": 1, "size": [4, 4], "camera": {"fx": 3, "fy": 3}})";
        text[upto(text.size())] = static_cast<char>(random_());
        touch_scene made{};
        const touch_status status =
            touch_scene_from_text(or_null(text.data()), text.size(), or_null(&made), error());
        if (status == TOUCH_OK) scenes_.push_back(made);
        return status;
    }
    touch_status scene_text() {
        std::array<char, 100> text;
        std::size_t length;
        return touch_scene_text(one_of(scenes_), or_null(text.data()), upto(101), or_null(&length));
    }
    touch_status defaults() {
        const auto size = static_cast<std::uint32_t>(spoilt(std::uint32_t{64}));
        touch_camera camera;
        touch_frame frame;
        touch_surface_settings shape;
        touch_solver_settings solver;
        touch_camera_defaults(or_null(&camera), rarely() ? std::uint32_t{sizeof camera} : size);
        touch_frame_defaults(or_null(&frame), rarely() ? std::uint32_t{sizeof frame} : size);
        touch_surface_settings_defaults(or_null(&shape), rarely() ? std::uint32_t{sizeof shape} : size);
        std::int64_t newest;
        touch_surface_newest_ns(one_of(surfaces_), or_null(&newest));
        return touch_solver_settings_defaults(or_null(&solver),
                                              rarely() ? std::uint32_t{sizeof solver} : size);
    }
    touch_status describe() {
        touch_scene_facts facts;
        facts.struct_size = spoilt(std::uint32_t{sizeof facts});
        return touch_scene_describe(one_of(scenes_), or_null(&facts));
    }
    touch_status with_filters() {
        const touch_frame frame = spoilt_frame();
        touch_scene made{};
        const touch_status status = touch_scene_with_filters(
            one_of(scenes_), or_null(&frame), spoilt(sizeof frame), upto(2), or_null(&made), error());
        if (status == TOUCH_OK) scenes_.push_back(made);
        return status;
    }
    /// The handle stays in the list, so that calls come to what has ended.
    touch_status end_something() {
        switch (upto(3)) {
            case 0:
                return touch_scene_destroy(one_of(scenes_));
            case 1:
                return touch_surface_destroy(one_of(surfaces_));
            default:
                return touch_solver_destroy(one_of(solvers_));
        }
    }
    touch_status surface() {
        touch_surface_settings settings;
        touch_surface_settings_defaults(&settings, sizeof settings);
        settings.struct_size = spoilt(settings.struct_size);
        settings.threads = spoilt(settings.threads);
        settings.frames = spoilt(settings.frames);
        touch_surface made{};
        const touch_status status =
            touch_surface_create(one_of(scenes_), or_null(&settings), or_null(&made), error());
        if (status == TOUCH_OK) surfaces_.push_back(made);
        return status;
    }
    touch_frame spoilt_frame() {
        touch_frame frame = hill_.frame(++number_);
        frame.struct_size = spoilt(frame.struct_size);
        frame.number = spoilt(frame.number);
        frame.time_ns = spoilt(frame.time_ns);
        touch_plane* const planes[] = {&frame.depth, &frame.colour, &frame.haptic, &frame.height};
        touch_plane& plane = *planes[rarely() ? upto(4) : 0];
        plane = frame.depth;
        if (rarely()) frame.lost_pixels = &lost_;
        if (rarely()) plane.data = nullptr;
        // Larger than the memory that there is only in ways that are seen to be wrong.
        if (rarely()) plane.width = static_cast<std::int32_t>(upto(2) ? -5 : 1 << 20);
        if (rarely()) plane.height = static_cast<std::int32_t>(upto(2) ? 0 : 1 << 30);
        if (rarely()) plane.stride_bytes = upto(2) ? std::numeric_limits<std::int64_t>::min() : 7;
        if (rarely()) plane.sample = static_cast<std::int32_t>(upto(2) ? 3 : 77);
        if (rarely()) plane.channels = static_cast<std::int32_t>(upto(2) ? 2 : -1);
        return frame;
    }
    touch_status push() {
        const touch_frame frame = spoilt_frame();
        return touch_surface_push(one_of(surfaces_), or_null(&frame), error());
    }
    touch_status epochs() {
        if (upto(2)) return touch_surface_end_epoch(one_of(surfaces_));
        return touch_surface_begin_epoch(one_of(surfaces_), spoilt(++epoch_), error());
    }
    touch_status scale() {
        double found;
        return touch_surface_hand_scale(one_of(surfaces_), or_null(&found), error());
    }
    touch_status solver() {
        touch_solver_settings settings;
        touch_solver_settings_defaults(&settings, sizeof settings);
        settings.struct_size = spoilt(settings.struct_size);
        settings.fingers =
            rarely() ? spoilt(settings.fingers) : 1 + static_cast<std::int32_t>(upto(most_fingers_));
        settings.metres_per_scene_unit = spoilt(1.0);
        settings.max_force_n = spoilt(settings.max_force_n);
        settings.max_stiffness_n_per_m = spoilt(settings.max_stiffness_n_per_m);
        settings.damping_n_s_per_m = spoilt(settings.damping_n_s_per_m);
        settings.stribeck_m_per_s = spoilt(settings.stribeck_m_per_s);
        settings.stale_after_ns = spoilt(settings.stale_after_ns);
        settings.ramp_in_ticks = spoilt(settings.ramp_in_ticks);
        settings.ramp_out_ticks = spoilt(settings.ramp_out_ticks);
        touch_solver made{};
        const touch_status status =
            touch_solver_create(one_of(surfaces_), or_null(&settings), or_null(&made), error());
        if (status == TOUCH_OK) solvers_.push_back(made);
        return status;
    }
    touch_status forces_at() {
        touch_solver_settings settings;
        touch_solver_settings_defaults(&settings, sizeof settings);
        settings.struct_size = spoilt(settings.struct_size);
        settings.fingers = spoilt(settings.fingers);
        settings.max_force_n = spoilt(settings.max_force_n);
        settings.stribeck_m_per_s = spoilt(settings.stribeck_m_per_s);
        touch_tick at = tick_at(number_ * 33);
        at.struct_size = spoilt(at.struct_size);
        at.time_ns = spoilt(at.time_ns);
        std::array<touch_vec3, most_fingers_> points;
        for (touch_vec3& point : points) {
            point = goal_at(number_);
            point.y = spoilt(point.y);
        }
        const std::size_t stride = spoilt(sizeof(touch_contact));
        const bool is_wide = stride > sizeof(touch_contact);
        const std::size_t count = rarely() ? SIZE_MAX : upto(points.size() + 1);
        const touch_status status = touch_surface_forces_at(
            one_of(surfaces_), or_null(&settings), or_null(&at), spoilt(1), or_null(points.data()), count,
            or_null(contacts_.data()), is_wide ? SIZE_MAX : stride, error());
        for (const touch_contact& contact : contacts_)
            EXPECT_TRUE(std::isfinite(contact.force_n.x + contact.force_n.y + contact.force_n.z));
        return status;
    }
    touch_status tick() {
        const touch_solver solver = one_of(solvers_);
        if (rarely()) {
            std::uint64_t hash;
            return upto(2) ? touch_solver_come_back(solver) : touch_solver_force_hash(solver, or_null(&hash));
        }
        touch_tick at = tick_at(++tick_);
        at.struct_size = spoilt(at.struct_size);
        at.tick = spoilt(at.tick);
        at.time_ns = spoilt(at.time_ns);
        at.epoch = rarely() ? spoilt(epoch_) : 0;
        at.epoch_start_ns = spoilt(at.epoch_start_ns);
        std::array<touch_vec3, most_fingers_> goals;
        for (touch_vec3& goal : goals) {
            goal = goal_at(tick_);
            goal.x = spoilt(goal.x);
            goal.z = spoilt(goal.z);
        }
        if (rarely()) {  // counts that no array has room for, or that have none
            static constexpr std::size_t counts[] = {0, (std::size_t{1} << 40) + 1, SIZE_MAX};
            return touch_solver_run(solver, or_null(&at), counts[upto(3)], or_null(goals.data()),
                                    or_null(contacts_.data()), sizeof(touch_contact));
        }
        // Room for as many fingers as any solver of this program has.
        const std::size_t stride = spoilt(sizeof(touch_contact));
        const bool is_wide = stride > sizeof(touch_contact);
        const touch_status status = touch_solver_tick(solver, or_null(&at), or_null(goals.data()),
                                                      or_null(contacts_.data()), is_wide ? SIZE_MAX : stride);
        for (const touch_contact& contact : contacts_)
            EXPECT_TRUE(std::isfinite(contact.force_n.x + contact.force_n.y + contact.force_n.z));
        return status;
    }

    static constexpr std::size_t most_fingers_ = 4;
    const Hill hill_;
    std::int64_t number_ = 0, tick_ = 0, lost_ = 0;
    std::uint64_t epoch_ = 0;
    std::vector<touch_scene> scenes_;
    std::vector<touch_surface> surfaces_;
    std::vector<touch_solver> solvers_;
    std::array<touch_contact, 256> contacts_{};
};

TEST(HostileCalls, EachGivesAStatus) {
    std::array<int, 256> seen{};
    for (unsigned seed = 1; seed <= 40; ++seed) {
        Hostile program(seed);
        for (int k = 0; k < 1000; ++k) {
            const touch_status status = program.call();
            ASSERT_STRNE(touch_status_name(status), "unknown status");
            ASSERT_NE(status, TOUCH_INTERNAL);
            ++seen[static_cast<std::size_t>(status)];
        }
    }
    for (const touch_status status :
         {TOUCH_OK, TOUCH_USAGE, TOUCH_INPUT, TOUCH_STALE, TOUCH_BUSY, TOUCH_FULL})
        EXPECT_GT(seen[static_cast<std::size_t>(status)], 10) << touch_status_name(status);
    EXPECT_GT(seen[TOUCH_OK], 4000) << "hardly anything was called as it should be";
}

}  // namespace
}  // namespace touchable::test
