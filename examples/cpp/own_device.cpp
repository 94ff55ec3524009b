// SPDX-License-Identifier: Apache-2.0
// Your own device: a loop of 1 kHz that reads where the hand is and sends it the force. Replace OwnDevice by
// yours; this one is a handle that is pushed down, which the surface holds up.
//     c++ -std=c++17 own_device.cpp $(pkg-config --cflags --libs touchable) -o own_device && ./own_device
// With a number N it runs as fast as it goes, and its thread stands still once, for N ms.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <touchable.hpp>

struct OwnDevice {  // metres, newtons
    touch_vec3 place{0, 0, -0.4}, speed{0, 0, 0};
    double push = -1;  // of the hand that holds it
    touch_vec3 read() const { return place; }
    void send(const touch_vec3& force) {  // 0.2 kg, damped; a millisecond
        speed.z += 0.001 * (force.z + push - 3 * speed.z) / 0.2;
        place.z += 0.001 * speed.z;
    }
};

int main(int count, char** words) {
    touch_camera camera = touch::camera();
    const touch::Scene scene(camera);
    std::vector<std::uint16_t> wall(640 * 480, 500);  // 0.5 m away
    touch_frame frame = touch::frame();
    frame.depth = {wall.data(), 2 * 640, 640, 480, TOUCH_U16, 1};
    touch::Surface surface(scene);
    surface.push(frame);
    touch_solver_settings settings = touch::solver_settings();
    settings.metres_per_scene_unit = 1;  // the hand moves as far as the finger in the scene
    settings.max_force_n = 5;            // what your device bears
    settings.waits_to_be_free = 1;       // no kick where it begins inside the surface
    touch::Solver solver(surface, settings);

    OwnDevice device;
    const bool is_real_time = count == 1;
    const std::int64_t stall_ms = is_real_time ? 0 : std::atoi(words[1]);
    const auto begin = std::chrono::steady_clock::now();
    std::int64_t next_print = 0;
    for (std::int64_t tick = 0, before = 0; tick < 3000; before = tick++) {
        if (is_real_time) {
            std::this_thread::sleep_until(begin + std::chrono::milliseconds(tick));
            const auto passed =
                std::chrono::steady_clock::now() - begin;  // ticks that were missed are skipped
            tick = std::max<std::int64_t>(
                tick, std::chrono::duration_cast<std::chrono::milliseconds>(passed).count());
        } else if (before == 1000) {
            tick += stall_ms;
        }
        const touch_vec3 goal = device.read();
        touch_contact contact;
        const bool ticked = solver.tick(touch::tick_at(tick), &goal, &contact) == TOUCH_OK;
        if (ticked && (contact.guard & TOUCH_GUARD_GAP) != 0)  // the hand may have been anywhere meanwhile
            std::printf("%4d ms: no tick for %d ms; force returns once the handle has been free\n", int(tick),
                        int(tick - before));
        device.send(ticked ? contact.force_n : touch_vec3{0, 0, 0});
        // Tell the person to lift the handle off the surface. Here the hand does, with 2 N.
        device.push = ticked && (contact.guard & TOUCH_GUARD_WAITING) != 0 ? 2 : -1;
        if (tick < next_print) continue;
        next_print = tick + 500;
        std::printf("%4d ms: %7.4f m, %6.3f N\n", int(tick), goal.z, contact.force_n.z);
    }
    device.send({0, 0, 0});  // whatever ends the loop
    const bool is_held = device.place.z > -0.51 && device.place.z < -0.49;
    return is_held ? 0 : 1;
}
