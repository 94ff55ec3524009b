// SPDX-License-Identifier: Apache-2.0
// The saved moment of a run (TouchRun::save), past the hash of its bytes.
#include <cmath>
#include <vector>

#include "engine/run/touch_run.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

constexpr int width = 24, height = 18, head = 32;  // bytes that name version, rules and settings

Scene small_scene() {
    Scene scene;
    scene.width = width;
    scene.height = height;
    scene.camera = {20, 20, 0.5 * (width - 1), 0.5 * (height - 1)};
    scene.depth.near = 50;
    scene.depth.far = 200;
    derive_valid_range(scene.depth);
    return scene;
}

void seal(std::vector<std::uint8_t>& moment) {
    ByteHash hash;
    hash.add(moment.data(), moment.size() - 8);
    for (int k = 0; k < 8; ++k)
        moment[moment.size() - 8 + static_cast<std::size_t>(k)] =
            static_cast<std::uint8_t>(hash.value() >> (8 * k));
}

bool parse_snapshot(std::string_view bytes) {
    const Scene scene = small_scene();
    SurfaceQueue surface(scene, make_cpu_builder(scene, CpuPlan{1}));
    std::vector<std::uint8_t> depth(width * height);
    for (std::size_t k = 0; k < depth.size(); ++k) depth[k] = static_cast<std::uint8_t>(100 + k % 97);
    RawFrame raw;
    raw.depth = {depth.data(), width, width, height};
    require(bool(surface.give({raw})), "a frame is not built");
    const GuardSettings guard;
    TouchRun run(surface, nullptr, TouchSolver::create(scene, {}).value(), guard, 2);
    const auto tick_to = [&](std::int64_t tick, const MediaMoment& moment) {
        run.meet(tick, moment);
        for (glm::dvec3& goal : run.goals()) goal = {0, 1, -130 - 0.1 * static_cast<double>(tick % 100)};
        for (const GuardedForce& felt : run.solve().forces) {
            const double square =
                felt.force.x * felt.force.x + felt.force.y * felt.force.y + felt.force.z * felt.force.z;
            require(square <= guard.max_force * guard.max_force * 1.000001,
                    "a force is beyond the limit, or none");
        }
    };
    tick_to(0, {});
    const std::vector<std::uint8_t> own = run.save();
    std::vector<std::uint8_t> moment(bytes.begin(), bytes.end());
    if (moment.size() > head + 8) {
        std::copy_n(own.begin(), head, moment.begin());
        seal(moment);
    }
    if (!is_taken(run.load(moment))) {
        require(run.save() == own, "a refused moment changed the run");
        return false;
    }
    (void)is_taken(run.resume());
    const MediaMoment from = run.moment();
    for (std::int64_t k = 1; k <= 20; ++k)
        tick_to(run.tick() + 1, {from.epoch, from.time_ns + k * tick_ns, from.start_ns});
    return true;
}

const Registered snapshot_target{{.name = "snapshot", .parse = parse_snapshot, .cuts_are_refused = true}};

}  // namespace
}  // namespace touchable::fuzz
