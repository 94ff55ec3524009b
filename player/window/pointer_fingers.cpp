#include "player/window/pointer_fingers.hpp"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <limits>

#include "device/finger_circle.hpp"
#include "player/view/surface_pick.hpp"

namespace touchable {
namespace {

/// How far several fingers are from the pointer, of the picture's height.
constexpr double spread = 0.08;
/// What is less high than that is not gone over, device metres.
constexpr double step_m = 0.003;

}  // namespace

void PointerFingers::set_pointer(std::optional<glm::dvec2> at) {
    pointer_ = at;
    if (!at) device_.intend({}, glm::dvec3(0.0));  // now, not with the next picture
}

void PointerFingers::deepen(double metres) {
    rest_m_ = std::clamp(rest_m_ + metres, highest_m, deepest_m);
}

double PointerFingers::depth_m() const {
    return held_ ? std::max(press_m, rest_m_) : rest_m_;
}

/// World.
std::optional<glm::dvec3> PointerFingers::place_of(int finger, const HeightField& field,
                                                   const ViewCamera& camera, const glm::dvec3* goal) {
    const glm::dvec2 offset = finger_offset(finger, count_, spread * camera.height);
    const glm::dvec2 at = *pointer_ + glm::dvec2(offset.x, -offset.y);
    glm::dvec3 direction = glm::normalize(camera.unproject(at.x, at.y, 0.5) - camera.eye);
    const auto met = pick(field, camera, at.x, at.y);
    const bool is_there = met && met->drawn && met->from_front;
    if (is_there) distance_ = glm::length(met->point - camera.eye);
    if (!distance_) return std::nullopt;
    const double deep_m = is_there ? depth_m() : std::min(depth_m(), hover_m);
    const double distance = *distance_ + deep_m / workspace_.metres_per_scene_unit;
    if (goal && deep_m < 0) {
        const glm::dvec3 sight = *goal - camera.eye;
        const double beyond_m = (glm::length(sight) - distance) * workspace_.metres_per_scene_unit;
        if (beyond_m > step_m) direction = glm::normalize(sight);
    }
    return camera.eye + direction * distance;
}

void PointerFingers::intend(const HeightField& field, const ViewCamera& camera,
                            std::span<const glm::dvec3> goals) {
    std::array<glm::dvec3, most> places;
    places.fill(glm::dvec3(std::numeric_limits<double>::quiet_NaN()));  // changes nothing for its finger
    for (int finger = 0; pointer_ && finger < count_; ++finger) {
        const auto k = static_cast<std::size_t>(finger);
        const auto place = place_of(finger, field, camera, k < goals.size() ? &goals[k] : nullptr);
        if (place) places[k] = workspace_.to_device(*place);
    }
    device_.intend(std::span(places).first(static_cast<std::size_t>(shown())),
                   workspace_.to_device(camera.eye));
}

}  // namespace touchable
