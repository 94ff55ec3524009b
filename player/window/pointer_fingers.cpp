#include "player/window/pointer_fingers.hpp"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>

#include "device/finger_circle.hpp"
#include "player/view/surface_pick.hpp"

namespace touchable {
namespace {

/// How far several fingers are from the pointer, of the picture's height.
constexpr double spread = 0.08;

}  // namespace

void PointerFingers::deepen(double metres) {
    rest_m_ = std::clamp(rest_m_ + metres, highest_m, deepest_m);
}

double PointerFingers::depth_m() const {
    return held_ ? std::max(press_m, rest_m_) : rest_m_;
}

/// World.
std::optional<glm::dvec3> PointerFingers::place_of(int finger, const HeightField& field,
                                                   const ViewCamera& camera) {
    const glm::dvec2 offset = finger_offset(finger, count_, spread * camera.height);
    const glm::dvec2 at = *pointer_ + glm::dvec2(offset.x, -offset.y);
    const glm::dvec3 direction = glm::normalize(camera.unproject(at.x, at.y, 0.5) - camera.eye);
    const auto met = pick(field, camera, at.x, at.y);
    if (met) distance_ = glm::length(met->point - camera.eye);
    if (!distance_) return std::nullopt;
    return camera.eye + direction * (*distance_ + depth_m() / workspace_.metres_per_scene_unit);
}

void PointerFingers::intend(const HeightField& field, const ViewCamera& camera) {
    std::array<glm::dvec3, most> places{};
    std::size_t count = 0;
    if (pointer_)
        for (int finger = 0; finger < count_; ++finger)
            if (const auto place = place_of(finger, field, camera))
                places[count++] = workspace_.to_device(*place);
    device_.intend(std::span(places).first(count), workspace_.to_device(camera.eye));
}

}  // namespace touchable
