// SPDX-License-Identifier: Apache-2.0
// A finger that presses on a hill, from another project than touchable's own (docs/install.md).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "haptics_cpu/touch_step.hpp"

using namespace touchable;

int main() {
    // A camera, and one planar depth per pixel: here in metres, of a hill in the middle.
    Scene scene;
    scene.width = scene.height = 200;
    scene.camera = {200, 200, 100, 100};
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.near = 0.3;
    scene.depth.far = 0.6;
    derive_valid_range(scene.depth);
    scene.default_properties = {500, 0.3, 0.2};  // N/m, static and dynamic friction
    if (auto valid = validate(scene); !valid) return std::puts(valid.error().message.c_str()), 1;
    std::vector<double> depths;
    for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 200; ++x)
            depths.push_back(0.5 - 0.05 * std::exp(-std::hypot(x - 100, y - 100) / 30));

    SurfaceFrame frame;
    frame.width = scene.width;
    frame.height = scene.height;
    frame.coding = scene.depth;
    frame.vertices = std::make_unique<ExactVertices>(scene.width, scene.height, depths);
    const FramePair still{{0, 0, &frame}, {0, 0, &frame}, 0};

    TouchSettings settings;
    settings.metres_per_scene_unit = 1;
    const auto solver = TouchSolver::create(scene, settings);
    if (!solver) return std::puts(solver.error().message.c_str()), 1;
    TouchStep step(*solver, GuardSettings{}, 1);
    double most = 0;
    for (int tick = 0; tick < 1000; ++tick) {  // a millisecond each: in, 5 mm below the surface, and out
        step.goals()[0] = {0.01, 0, -0.43 - 0.032 * std::sin(3.14159 * tick / 1000)};
        const TouchTick done = step.run(tick, tick * 1'000'000, scene, still);
        const glm::dvec3 force = done.forces[0].force;
        most = std::max(most, force.z);
        if (tick % 100 == 0) std::printf("%4d ms: %6.3f %6.3f %6.3f N\n", tick, force.x, force.y, force.z);
    }
    return most > 1 ? 0 : 1;
}
