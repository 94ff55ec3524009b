// Two solvers in two threads, frames that are pushed while a solver ticks, and a process that was forked.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "tests/capi/hill.hpp"
#include "tests/sanitizers.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

std::uint64_t hash_of_a_run() {
    TouchedHill touched;
    for (std::int64_t tick = 0; tick < 500; ++tick) {
        const touch_tick at = tick_at(tick);
        const touch_vec3 goal = goal_at(tick);
        touch_contact contact;
        EXPECT_EQ(touch_solver_tick(touched.solver, &at, &goal, &contact, sizeof contact), TOUCH_OK);
    }
    std::uint64_t hash = 0;
    EXPECT_EQ(touch_solver_force_hash(touched.solver, &hash), TOUCH_OK);
    return hash;
}

TEST(Threads, TwoSolversInTwoThreads) {
    const std::uint64_t expected = hash_of_a_run();
    std::uint64_t one = 0, other = 0;
    std::thread first([&] { one = hash_of_a_run(); }), second([&] { other = hash_of_a_run(); });
    first.join();
    second.join();
    EXPECT_EQ(one, expected);
    EXPECT_EQ(other, expected);
}

TEST(Threads, OnePushesWhileAnotherTicks) {
    TouchedHill touched;
    constexpr std::int64_t frames = 60;
    std::atomic<bool> pushed_all{false};
    std::thread writer([&] {
        for (std::int64_t n = 1; n < frames; ++n) {
            const Hill hill(static_cast<int>(n % 5));
            const touch_frame frame = hill.frame(n);
            touch_status status = TOUCH_FULL;
            while ((status = touch_surface_push(touched.surface, &frame, nullptr)) == TOUCH_FULL)
                std::this_thread::yield();
            EXPECT_EQ(status, TOUCH_OK);
        }
        pushed_all = true;
    });
    touch_contact contact;
    std::int64_t newest = 0;
    for (std::int64_t tick = 0; !pushed_all; ++tick) {
        touch_tick at = tick_at(tick);
        EXPECT_EQ(touch_surface_newest_ns(touched.surface, &newest), TOUCH_OK);
        at.time_ns = newest;
        const touch_vec3 goal = goal_at(tick);
        EXPECT_EQ(touch_solver_tick(touched.solver, &at, &goal, &contact, sizeof contact), TOUCH_OK);
    }
    writer.join();
    EXPECT_EQ(touch_surface_newest_ns(touched.surface, &newest), TOUCH_OK);
    EXPECT_EQ(newest, (frames - 1) * 33'000'000);
}

/// Whoever tries to destroy what a solver needs gets TOUCH_BUSY, and nobody else notices.
TEST(Threads, WhatCannotBeDestroyedStaysThereForAll) {
    const TouchedHill touched;
    std::atomic<bool> over = false;
    std::thread destroyer([&] {
        while (!over)
            if (touch_surface_destroy(touched.surface) != TOUCH_BUSY) break;
    });
    int stale = 0;
    for (int k = 0; k < 100'000; ++k) {
        std::int64_t newest;
        stale += touch_surface_newest_ns(touched.surface, &newest) != TOUCH_OK;
    }
    over = true;
    destroyer.join();
    EXPECT_EQ(stale, 0);
}

/// What `work` returns in a forked child, 0 to 200; 256 and more where the child hangs.
int in_child(const std::function<int()>& work) {
    const pid_t child = fork();
    if (child == 0) {
        alarm(60);
        _exit(work());
    }
    int status = 0;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 256 + status;
}

/// Of each kind one, with threads where it may have some.
struct HeldObjects {
    TouchedHill hill;
    touch_surface threaded{};
    touch_writer writer{};
    touch_clip clip{};
    touch_frameset frameset{};

    explicit HeldObjects(const TemporaryFolder& folder) {
        touch_surface_settings settings;
        EXPECT_EQ(touch_surface_settings_defaults(&settings, sizeof settings), TOUCH_OK);
        settings.threads = 3;
        EXPECT_EQ(touch_surface_create(hill.scene, &settings, &threaded, nullptr), TOUCH_OK);
        EXPECT_EQ(push(threaded, 0), TOUCH_OK);
        const std::string file = folder / "hill.mkv";
        EXPECT_EQ(touch_writer_create(file.c_str(), hill.scene, nullptr, &writer, nullptr), TOUCH_OK);
        for (int n = 0; n < 8; ++n) EXPECT_EQ(write(), TOUCH_OK);
        EXPECT_EQ(touch_writer_finish(writer, nullptr), TOUCH_OK);
        EXPECT_EQ(touch_clip_open(file.c_str(), nullptr, &clip, nullptr), TOUCH_OK);
        EXPECT_EQ(touch_clip_next(clip, &frameset, nullptr), TOUCH_OK);
        const std::string other = folder / "other.mkv";
        EXPECT_EQ(touch_writer_create(other.c_str(), hill.scene, nullptr, &writer, nullptr), TOUCH_OK);
        EXPECT_EQ(write(), TOUCH_OK);
    }
    ~HeldObjects() {
        EXPECT_EQ(touch_frameset_release(frameset), TOUCH_OK);
        EXPECT_EQ(touch_clip_close(clip), TOUCH_OK);
        EXPECT_EQ(touch_surface_destroy(threaded), TOUCH_OK);
    }
    static touch_status forces_at(touch_surface surface) {
        const touch_tick at = tick_at(0);
        const touch_vec3 point{0, 0, -1};
        touch_contact contact{};
        return touch_surface_forces_at(surface, nullptr, &at, TOUCH_FRICTION_OFF, &point, 1, &contact,
                                       sizeof contact, nullptr);
    }
    static touch_status push(touch_surface surface, int number, touch_error* error = nullptr) {
        const Hill picture(number);
        const touch_frame frame = picture.frame(number);
        return touch_surface_push(surface, &frame, error);
    }
    touch_status write(touch_error* error = nullptr) const {
        const Hill picture;
        const touch_frame frame = picture.frame();
        return touch_writer_write(writer, &frame, error);
    }
    touch_status tick(std::int64_t number) const {
        const touch_tick at = tick_at(number);
        const touch_vec3 goal = goal_at(number);
        touch_contact contact;
        return touch_solver_tick(hill.solver, &at, &goal, &contact, sizeof contact);
    }
};

TEST(Forks, ChildIsRefusedItsParentsObjects) {
    const TemporaryFolder folder;
    HeldObjects held(folder);
    const int refused = in_child([&] {
        touch_error error{sizeof error, 0, {}};
        touch_frameset next{};
        touch_clip_facts facts{};
        facts.struct_size = sizeof facts;
        std::int64_t time = 0;
        std::uint64_t hash = 0;
        touch_solver solver{};
        const touch_status statuses[] = {touch_clip_next(held.clip, &next, &error),
                                         touch_clip_seek(held.clip, 0, &error),
                                         touch_clip_describe(held.clip, &facts),
                                         touch_clip_interrupt(held.clip),
                                         HeldObjects::push(held.threaded, 1, &error),
                                         touch_surface_newest_ns(held.threaded, &time),
                                         touch_solver_create(held.threaded, nullptr, &solver, &error),
                                         held.tick(0),
                                         touch_solver_force_hash(held.hill.solver, &hash),
                                         held.write(&error),
                                         HeldObjects::forces_at(held.threaded),
                                         touch_writer_finish(held.writer, &error)};
        int number = 1;
        for (const touch_status status : statuses) {
            if (status != TOUCH_FORKED) return number;
            ++number;
        }
        if (std::string(touch_status_name(TOUCH_FORKED)) != "belongs to the parent process") return 100;
        return std::string(error.line).starts_with("the writer belongs to the parent process; right would be")
                   ? 0
                   : 101;
    });
    EXPECT_EQ(refused, 0) << "the call of that number";
    EXPECT_EQ(held.tick(0), TOUCH_OK);
    EXPECT_EQ(HeldObjects::push(held.threaded, 1), TOUCH_OK);
    touch_frameset next{};
    EXPECT_EQ(touch_clip_next(held.clip, &next, nullptr), TOUCH_OK);
    EXPECT_EQ(touch_frameset_release(next), TOUCH_OK);
    EXPECT_EQ(held.write(), TOUCH_OK);
    EXPECT_EQ(touch_writer_finish(held.writer, nullptr), TOUCH_OK);
}

TEST(Forks, ChildForgetsAndMakesItsOwn) {
    const TemporaryFolder folder;
    HeldObjects held(folder);
    const int forgotten = in_child([&] {
        touch_frame frame;
        touch_frame_defaults(&frame, sizeof frame);
        if (touch_frameset_frame(held.frameset, &frame) != TOUCH_OK || !frame.depth.data) return 1;
        if (touch_clip_close(held.clip) != TOUCH_OK || touch_clip_close(held.clip) != TOUCH_STALE) return 2;
        if (touch_surface_destroy(held.hill.surface) != TOUCH_OK) return 3;  // though its solver is there
        if (touch_solver_destroy(held.hill.solver) != TOUCH_OK) return 4;
        if (touch_surface_destroy(held.threaded) != TOUCH_OK) return 5;
        if (touch_writer_abandon(held.writer) != TOUCH_OK) return 6;
        if (touch_frameset_release(held.frameset) != TOUCH_OK) return 7;
        std::uint64_t hash = 0;
        touch_surface own{};
        if (touch_surface_create(held.hill.scene, nullptr, &own, nullptr) != TOUCH_OK) return 8;
        touch_solver solver{};
        if (HeldObjects::push(own, 0) != TOUCH_OK) return 9;
        if (touch_solver_create(own, nullptr, &solver, nullptr) != TOUCH_OK) return 10;
        if (touch_solver_force_hash(solver, &hash) != TOUCH_OK) return 11;
        if (touch_solver_destroy(solver) != TOUCH_OK || touch_surface_destroy(own) != TOUCH_OK) return 12;
        return touch_scene_destroy(held.hill.scene) == TOUCH_OK ? 0 : 13;
    });
    EXPECT_EQ(forgotten, 0) << "the step of that number";
    EXPECT_EQ(held.tick(0), TOUCH_OK);
    EXPECT_EQ(touch_writer_abandon(held.writer), TOUCH_OK);
}

/// While other threads make and end objects.
TEST(Forks, ChildFindsTablesFree) {
#ifdef TOUCHABLE_SANITIZED
    GTEST_SKIP() << "a fork finds a sanitizer's own allocator locked by a thread that the child has not";
#endif
    const touch_camera camera = Hill::camera();
    std::atomic<bool> over = false;
    std::thread busy([&] {
        touch_scene scene{};
        while (!over)
            if (touch_scene_from_camera(&camera, &scene, nullptr) == TOUCH_OK) touch_scene_destroy(scene);
    });
    int hung = 0;
    for (int k = 0; k < 200 && hung == 0; ++k)
        hung = in_child([&] {
            touch_scene scene{};
            return touch_scene_from_camera(&camera, &scene, nullptr) == TOUCH_OK &&
                           touch_scene_destroy(scene) == TOUCH_OK
                       ? 0
                       : 1;
        });
    over = true;
    busy.join();
    EXPECT_EQ(hung, 0);
}

}  // namespace
}  // namespace touchable::test
