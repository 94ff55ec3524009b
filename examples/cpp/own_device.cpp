// Your own device: a loop of 1 kHz that reads where the hand is and sends it the force. Replace OwnDevice by
// yours; this one is a handle on a spring in no hand, which the surface holds up.
//     c++ -std=c++17 own_device.cpp $(pkg-config --cflags --libs touchable) -o own_device && ./own_device
#include <chrono>
#include <cstdio>
#include <thread>
#include <touchable.hpp>

struct OwnDevice {  // metres, newtons
    touch_vec3 place{0, 0, -0.4}, speed{0, 0, 0};
    touch_vec3 read() const { return place; }
    void send(const touch_vec3& force) {  // 0.2 kg, pushed down by 1 N, damped; a millisecond
        speed.z += 0.001 * (force.z - 1 - 3 * speed.z) / 0.2;
        place.z += 0.001 * speed.z;
    }
};

int main(int count, char**) {
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
    const bool is_real_time = count == 1;  // with any word: as fast as it goes
    const auto begin = std::chrono::steady_clock::now();
    for (std::int64_t tick = 0; tick < 3000; ++tick) {
        if (is_real_time) std::this_thread::sleep_until(begin + std::chrono::milliseconds(tick));
        if (is_real_time && std::chrono::steady_clock::now() - begin > std::chrono::milliseconds(tick + 20))
            solver.come_back();  // this thread stood still: force returns by its ramp
        const touch_vec3 goal = device.read();
        touch_contact contact;
        const bool ticked = solver.tick(touch::tick_at(tick), &goal, &contact) == TOUCH_OK;
        device.send(ticked ? contact.force_n : touch_vec3{0, 0, 0});
        if (tick % 500 == 0) std::printf("%4d ms: %7.4f m, %6.3f N\n", int(tick), goal.z, contact.force_n.z);
    }
    device.send({0, 0, 0});  // whatever ends the loop
    const bool is_held = device.place.z > -0.51 && device.place.z < -0.49;
    return is_held ? 0 : 1;
}
