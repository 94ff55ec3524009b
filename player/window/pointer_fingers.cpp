#include "player/window/pointer_fingers.hpp"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <limits>

#include "device/finger_circle.hpp"
#include "player/draw/surface_pick.hpp"

namespace touchable {
namespace {

/// How far several fingers are from the pointer, of the picture's height.
constexpr double spread = 0.08;
// Device metres. What is less high than a step is not gone over, and what is clear of the surface by so much
// has nothing in its way. Who is by so much too far from where it presses to is caught. A finger slips alike
// off places that are that near to each other.
constexpr double step_m = 0.003, clear_m = 0.0005, caught_m = 0.005, again_m = 0.001;
// It is lifted to so far beyond what it goes over, and by that share of the way there farther: meant to be
// higher than it has to, it is there sooner.
constexpr double lift_m = 2 * PointerFingers::hover_m, lift_share = 0.5;
// A finger comes from so far before the surface: there before it is missed.
constexpr double arrives_m = 0.008;

}  // namespace

void PointerFingers::set_pointer(std::optional<glm::dvec2> at) {
    pointer_ = at;
    if (at || is_touched()) return;
    device_.intend({}, glm::dvec3(0.0));  // now, not with the next picture
}

int PointerFingers::shown() const {
    if (is_touched()) return distance_ ? touched() : 0;
    return pointer_ && distance_ ? count_ : 0;
}

std::optional<glm::dvec2> PointerFingers::looked_at() const {
    for (const auto& touch : touches_)
        if (touch) return touch;
    return pointer_;
}

std::optional<std::size_t> PointerFingers::put_down(const glm::dvec2& at) {
    const auto free = std::find(touches_.begin(), touches_.end(), std::nullopt);
    if (free == touches_.end()) return std::nullopt;
    *free = at;
    was_pressed_ = true;
    const auto finger = static_cast<std::size_t>(free - touches_.begin());
    goes_over_[finger] = false;
    return finger;
}

bool PointerFingers::has_free() const {
    return std::find(touches_.begin(), touches_.end(), std::nullopt) != touches_.end();
}

void PointerFingers::lift(std::size_t finger) {
    touches_[finger].reset();
    device_.withdraw(finger);
}

/// Up to the last that is down.
int PointerFingers::touched() const {
    for (int k = most; k > 0; --k)
        if (touches_[static_cast<std::size_t>(k - 1)]) return k;
    return 0;
}

void PointerFingers::deepen(double metres) {
    rest_m_ = std::clamp(rest_m_ + metres, highest_m, deepest_m);
}

double PointerFingers::depth_m() const {
    return held_ || is_touched() ? std::max(press_m, rest_m_) : rest_m_;
}

std::optional<PointerFingers::Meant> PointerFingers::meant_at(std::size_t finger, const glm::dvec2& at,
                                                              const HeightField& field,
                                                              const ViewCamera& camera, const Contact* felt) {
    const glm::dvec3 direction = ray_of(camera, at.x, at.y).direction;
    const auto met = pick(field, camera, at.x, at.y);
    const bool is_there = met && met->drawn && met->from_front;
    if (is_there) distance_ = glm::length(met->point - camera.eye);
    if (!distance_) return std::nullopt;
    const double deep_m = is_there ? depth_m() : std::min(depth_m(), hover_m);
    const std::optional<glm::dvec3> ground = is_there ? std::optional(met->point) : std::nullopt;
    if (felt)
        if (const auto over = way_over(finger, field, camera.eye + direction * *distance_, deep_m, *felt))
            return Meant{*over, ground};
    return Meant{camera.eye + direction * (*distance_ + deep_m / workspace_.metres_per_scene_unit), ground};
}

/// Where the finger is to go instead, if it is not to go straight to the `ground` that is meant.
std::optional<glm::dvec3> PointerFingers::way_over(std::size_t finger, const HeightField& field,
                                                   const glm::dvec3& ground, double deep_m,
                                                   const Contact& felt) {
    const Camera& camera = field.scene().camera;
    const double metres = workspace_.metres_per_scene_unit;
    const auto from = project(camera, felt.proxy), to = project(camera, ground);
    const auto surface = surface_on_way(field, felt.proxy, ground);
    bool& goes_over = goes_over_[finger];
    if (!from || !to || !surface) {
        goes_over = false;
        return std::nullopt;
    }
    const auto at = [&](const ImagePoint& pixel, double beyond_nearest_m) {
        const double depth = surface->nearest + beyond_nearest_m / metres;
        return unproject(camera, pixel.x, pixel.y, std::max(depth, surface->nearest / 2));
    };
    const double behind_m = surface->behind * metres,
                 below_m = (from->planar_depth - surface->nearest) * metres;
    const bool is_blocked = behind_m > step_m, is_below = below_m > step_m, went_over = goes_over;
    if (went_over)
        goes_over = felt.touching || behind_m > clear_m || below_m > -clear_m;
    else if (is_caught(felt, deep_m))
        goes_over = true;
    else  // where it did not stay it would slip again and again
        goes_over = is_blocked && is_below && glm::distance(ground, lifted_to_[finger]) * metres > again_m;
    if (goes_over && !went_over) lifted_to_[finger] = ground;
    if (goes_over) return below_m > -clear_m ? at(*from, lift_m - below_m * lift_share) : at(*to, hover_m);
    // From something near: not through it, but on to its edge.
    if (is_blocked && !is_below) return at(*to, deep_m);
    return std::nullopt;
}

/// It stays farther from where it presses to than that, friction and slopes explain.
bool PointerFingers::is_caught(const Contact& felt, double deep_m) const {
    if (!felt.touching) return false;
    const glm::dvec3 pull = (felt.goal - felt.proxy) * workspace_.metres_per_scene_unit;
    const glm::dvec3 ray = glm::normalize(felt.proxy);
    const double pressed_m = std::max(deep_m, 0.0) + step_m, along_m = glm::dot(pull, ray),
                 aside_m = glm::length(pull - ray * along_m);
    return along_m > pressed_m + caught_m || aside_m > pressed_m * felt.properties.static_friction + caught_m;
}

void PointerFingers::intend(const HeightField& field, const ViewCamera& camera,
                            std::span<const Contact> felt) {
    const bool by_touch = is_touched();
    for (std::size_t k = 0; k < touches_.size(); ++k) {
        std::optional<glm::dvec2> at = touches_[k];
        if (!by_touch && pointer_ && k < static_cast<std::size_t>(count_)) {
            const glm::dvec2 offset = finger_offset(static_cast<int>(k), count_, spread * camera.height);
            at = *pointer_ + glm::dvec2(offset.x, -offset.y);
        }
        if (at)
            lead(k, *at, field, camera, k < felt.size() ? &felt[k] : nullptr);
        else
            device_.withdraw(k);
    }
}

/// A finger that comes begins a little before the surface, on the way there from the clip's camera, where
/// nothing can be in between: a pointer has no hand that such a jump could hurt.
void PointerFingers::lead(std::size_t finger, const glm::dvec2& at, const HeightField& field,
                          const ViewCamera& camera, const Contact* felt) {
    const auto meant = meant_at(finger, at, field, camera, felt);
    if (!meant) return;
    glm::dvec3 from(std::numeric_limits<double>::quiet_NaN());
    if (meant->ground) {
        const double nearer = arrives_m / workspace_.metres_per_scene_unit;
        from = workspace_.to_device(*meant->ground * std::max(1 - nearer / glm::length(*meant->ground), 0.0));
    }
    device_.intend(finger, workspace_.to_device(meant->place), from, workspace_.to_device(camera.eye));
}

}  // namespace touchable
