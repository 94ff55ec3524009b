// SPDX-License-Identifier: Apache-2.0
#include "bench/loop/closed_loop.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bench/clocks.hpp"

namespace touchable {
namespace {

glm::dvec3 point_of(const HeightField& field, int x, int y) {
    const Scene& scene = field.scene();
    return unproject(scene.camera, x, y,
                     planar_depth(scene.camera, scene.depth.semantics, x, y, field.vertex(x, y).depth));
}

}  // namespace

PressedPlace pressed_place(const TouchSurface& surface, int x, int y) {
    const glm::dvec3 point = point_of(HeightField(surface.scene(), surface.pair_at(0)), x, y);
    if (const auto truth = surface.exact().closest(point, point, 0)) return {x, y, truth->normal};
    return {x, y, -point / std::sqrt(glm::dot(point, point))};
}

ClosedLoop::ClosedLoop(const TouchSurface& surface, const LoopCase& c, const PressedPlace& place,
                       double stiffness, const TouchSolver& solver)
    : surface_(surface),
      scene_(surface.scene()),
      solver_(solver),
      workspace_{solver.settings().metres_per_scene_unit, {0, 0, 0}},
      place_(place),
      press_(std::min(press_n, stiffness * deepest)),
      depth_(press_ / stiffness),
      intended_depth_(depth_ + press_ / c.handle.hand_stiffness),
      handle_(c.handle, period_s),
      forces_(static_cast<std::size_t>(c.delay_ticks) + 1, glm::dvec3(0.0)) {
    scene_.default_properties = {stiffness, 0, 0};
}

Result<ClosedLoop> ClosedLoop::create(const TouchSurface& surface, const LoopCase& c,
                                      const PressedPlace& place, double stiffness, double nudge) {
    TouchSettings settings;
    settings.metric = c.touch.metric;
    settings.metres_per_scene_unit = surface.scene().device_metres_per_unit.value();
    const auto solver = TouchSolver::create(surface.scene(), settings);
    if (!solver) return solver.error();
    ClosedLoop loop(surface, c, place, stiffness, *solver);
    loop.handle_.put(loop.surface_now() - place.normal * loop.depth_, -nudge * place.normal);
    // The user pressed before, so the delayed forces in the ring already hold the handle in place.
    for (glm::dvec3& force : loop.forces_) force = loop.press_ * place.normal;
    return loop;
}

glm::dvec3 ClosedLoop::surface_now() const {
    const HeightField field(scene_, surface_.pair_at(tick_ * tick_length_ns));
    return workspace_.to_device(point_of(field, place_.x, place_.y));
}

void ClosedLoop::tick() {
    const glm::dvec3 goal = workspace_.to_scene(handle_.reading());
    const HeightField field(scene_, surface_.pair_at(tick_ * tick_length_ns));
    solver_.tick(field, {&goal, 1}, {&finger_, 1}, {&contact_, 1});
    handle_.intend(surface_now() - place_.normal * intended_depth_);
    const std::size_t slots = forces_.size(), now = static_cast<std::size_t>(tick_) % slots;
    forces_[(now + slots - 1) % slots] = contact_.force;
    handle_.advance(forces_[now]);
    ++tick_;
}

}  // namespace touchable
