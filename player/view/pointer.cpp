// SPDX-License-Identifier: Apache-2.0
#include "player/view/pointer.hpp"

#include <array>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "device/point_motion.hpp"
#include "engine/base/same_bits.hpp"

namespace touchable {
namespace {

/// Adds columns to the right of the same pixels, and rows below.
ViewCamera with_margins(ViewCamera camera, int columns, int rows) {
    const double across = static_cast<double>(camera.width) / (camera.width + columns),
                 down = static_cast<double>(camera.height) / (camera.height + rows);
    for (glm::dmat4* const matrix : {&camera.clip_from_world, &camera.clip_from_lattice})
        for (int column = 0; column < 4; ++column) {
            glm::dvec4& to = (*matrix)[column];
            to.x = across * to.x - (1 - across) * to.w;
            to.y = down * to.y - (1 - down) * to.w;
        }
    camera.width += columns;
    camera.height += rows;
    return camera;
}

/// Distance of several fingers from the pointer, as a share of the picture's height.
constexpr double finger_spread = 0.08;
// Device metres; docs/play.md gives the reasons. step_m: a finger is lifted over higher steps. caught_m: a
// finger that lags its goal by more is stuck. again_m: a place closer to the last lift's is the same
// obstacle.
constexpr double step_m = 0.003, caught_m = 0.005, again_m = 0.001;

constexpr double metres_per_notch = 0.0005, metres_per_pixel = 0.00003;  // of the hand, into the surface
constexpr double nearer_per_notch = 1.15;

void turn_by(const glm::dvec2& moved, WindowView& view, int height) {
    const glm::dvec2 degrees = moved * (WindowView::degrees_per_height / std::max(height, 1));
    view.turn(-degrees.x, degrees.y);
}

constexpr std::size_t most_touches = 32;
constexpr double least_radius_share = 0.01;  // of the picture's height: closer fingers do not zoom
constexpr double most_nearer = 2;            // per event

InputEvent pointer_event(InputEvent::Kind kind, const glm::dvec2& at) {
    using Kind = InputEvent::Kind;
    const bool is_button = kind == Kind::pressed || kind == Kind::released;
    return {.kind = kind, .x = at.x, .y = at.y, .word = is_button ? "left" : ""};
}

}  // namespace

// On the clip camera's axis, so that the view does not jump on the first turn.
WindowView::WindowView(const Scene& scene, const glm::dvec3& middle) : scene_(scene), home_(0, 0, middle.z) {
    go_home();
}

ViewCamera WindowView::camera(int width, int height) const {
    Viewpoint viewpoint = now_.orbit;
    viewpoint.own = now_.own;
    const auto margin = [](double share, int side) {
        return std::clamp(static_cast<int>(std::lround(share * side)), 0, std::max(side - 1, 0));
    };
    const int right = margin(free_.x, width), below = margin(free_.y, height);
    ViewCamera camera = make_view(viewpoint, scene_, now_.centre, width - right, height - below);
    if (!now_.own) (now_.placing ? *now_.placing : placing(camera.width, camera.height)).apply(camera);
    return right + below > 0 ? with_margins(camera, right, below) : camera;
}

void WindowView::look_at(const glm::dvec3& place) {
    now_.own = false;
    now_.placing = Placing{};
    set_centre(place);
}

void WindowView::note_middle(const HeightField& field) {
    if (!now_.own && !now_.thing.empty()) return;  // a view as another clip's begins turned
    constexpr int columns = 48, rows = 36;
    struct Sample {
        glm::dvec3 at;
        double depth = 0;  // planar; 0: none
        bool is_found = false;
    };
    std::array<Sample, columns * rows> places;
    const Sample* start = nullptr;
    double least = 0;
    for (int k = 0; k < columns * rows; ++k) {
        const int x = (2 * (k % columns) + 1) * scene_.width / (2 * columns),
                  y = (2 * (k / columns) + 1) * scene_.height / (2 * rows);
        const FieldVertex vertex = field.vertex(x, y);
        if (!vertex.valid) continue;
        const double depth = planar_depth(scene_.camera, scene_.depth.semantics, x, y, vertex.depth),
                     off = std::hypot(x - scene_.camera.cx, y - scene_.camera.cy);
        places[static_cast<std::size_t>(k)] = {unproject(scene_.camera, x, y, depth), depth};
        if (start && off >= least) continue;
        start = &places[static_cast<std::size_t>(k)];
        least = off;
    }
    if (!start) return;
    // Neighbours are of one thing unless an edge lies between them.
    constexpr double most_apart = 1.15;
    std::vector<int> found{static_cast<int>(start - places.data())};
    std::vector<double> depths;
    now_.thing.clear();
    places[static_cast<std::size_t>(found[0])].is_found = true;
    for (std::size_t n = 0; n < found.size(); ++n) {
        const Sample& from = places[static_cast<std::size_t>(found[n])];
        now_.thing.push_back(from.at);
        depths.push_back(from.depth);
        for (const int by : {-1, 1, -columns, columns}) {
            const int k = found[n] + by;
            if (k < 0 || k >= columns * rows || (std::abs(by) == 1 && k / columns != found[n] / columns))
                continue;
            Sample& to = places[static_cast<std::size_t>(k)];
            const bool is_near = std::max(from.depth, to.depth) < most_apart * std::min(from.depth, to.depth);
            if (!is_near || std::exchange(to.is_found, true)) continue;
            found.push_back(k);
        }
    }
    now_.centre.z = home_.z = -sorted_element(depths, depths.size() / 2);
}

/// What the thing covers, without outliers, in shares of the picture from -1 to 1.
WindowView::Covered WindowView::covered_by_thing(const Viewpoint& viewpoint, int width, int height) const {
    const ViewCamera camera = make_view(viewpoint, scene_, now_.centre, width, height);
    std::array<std::vector<double>, 2> places;
    for (const glm::dvec3& point : now_.thing)
        if (const auto at = camera.project(point)) {
            places[0].push_back(2 * at->x / width - 1);
            places[1].push_back(2 * at->y / height - 1);
        }
    Covered covered;
    for (int axis = 0; axis < 2 && !places[0].empty(); ++axis) {
        std::vector<double>& of = places[static_cast<std::size_t>(axis)];
        const std::size_t few = of.size() / 50;
        const double least = sorted_element(of, few), greatest = sorted_element(of, of.size() - 1 - few);
        covered.middle[axis] = (least + greatest) / 2;
        covered.size[axis] = greatest - least;
    }
    return covered;
}

/// Keeps the thing where it is in a view that is not turned, and no larger.
WindowView::Placing WindowView::placing(int width, int height) const {
    Viewpoint straight = now_.orbit;
    straight.azimuth = straight.elevation = 0;
    const Covered before = covered_by_thing(straight, width, height),
                  after = covered_by_thing(now_.orbit, width, height);
    Placing placing;
    for (int axis = 0; axis < 2; ++axis)
        if (after.size[axis] > before.size[axis])
            placing.scale = std::min(placing.scale, before.size[axis] / after.size[axis]);
    placing.shift = before.middle - placing.scale * after.middle;
    return placing;
}

void WindowView::Placing::apply(ViewCamera& camera) const {
    camera.focal *= scale;
    for (glm::dmat4* const matrix : {&camera.clip_from_world, &camera.clip_from_lattice})
        for (int column = 0; column < 4; ++column) {
            glm::dvec4& to = (*matrix)[column];
            to.x = scale * to.x + shift.x * to.w;
            to.y = scale * to.y + shift.y * to.w;
        }
}

double WindowView::pixels_per_vertex(int width, int height) const {
    const double whole =
        std::min((1 - free_.x) * width / scene_.width, (1 - free_.y) * height / scene_.height);
    return now_.own ? whole : whole * now_.orbit.zoom.value_or(1);
}

void WindowView::turn(double azimuth, double elevation) {
    now_.own = false;
    now_.orbit.azimuth = std::remainder(now_.orbit.azimuth + azimuth, 360.0);
    now_.orbit.elevation = std::clamp(now_.orbit.elevation + elevation, -89.0, 89.0);
}

void WindowView::pan(double x, double y, int width, int height) {
    now_.own = false;
    if (!now_.placing) now_.placing = placing(std::max(width, 1), std::max(height, 1));
    const ViewCamera camera = this->camera(std::max(width, 1), std::max(height, 1));
    const auto middle = camera.project(now_.centre);
    if (!middle) return;
    const glm::dvec3 moved = now_.centre + camera.unproject(middle->x - x, middle->y - y, middle->z) -
                             camera.unproject(middle->x, middle->y, middle->z);
    set_centre(moved);
}

/// Keeps the eye's distance; zoom is relative to the clip's camera.
void WindowView::set_centre(const glm::dvec3& place) {
    if (!(place.z < 0)) return;
    now_.orbit.zoom = std::clamp(now_.orbit.zoom.value_or(1) * place.z / now_.centre.z, 0.1, 20.0);
    now_.centre = place;
}

void WindowView::look_as(const WindowView& other) {
    go_home();
    now_.own = other.now_.own;
    now_.orbit = other.now_.orbit;
}

bool WindowView::State::looks_as(const State& other) const {
    if (own || other.own) return own == other.own;
    return centre == other.centre && orbit.azimuth == other.orbit.azimuth &&
           orbit.elevation == other.orbit.elevation && orbit.zoom == other.orbit.zoom;
}

void WindowView::go_home() {
    now_.own = true;
    now_.placing.reset();
    now_.orbit = Viewpoint{};
    now_.orbit.zoom = 1;
    now_.orbit.keeps_axis = true;
    now_.centre = home_;
}

void PointerFingers::set_pointer(std::optional<glm::dvec2> at) {
    pointer_ = at;
    if (at || is_touched()) return;
    device_.intend({}, glm::dvec3(0.0));  // at once, not with the next picture
}

std::optional<glm::dvec2> PointerFingers::looked_at() const {
    for (const Finger& finger : fingers_)
        if (finger.touch) return finger.touch;
    return pointer_;
}

std::optional<std::size_t> PointerFingers::put_down(const glm::dvec2& at) {
    const auto free = std::ranges::find_if(fingers_, [](const Finger& finger) { return !finger.touch; });
    if (free == fingers_.end()) return std::nullopt;
    free->touch = at;
    free->is_lifted = false;
    was_pressed_ = true;
    return static_cast<std::size_t>(free - fingers_.begin());
}

/// Number of fingers up to the last that is down.
int PointerFingers::touched() const {
    for (int k = most; k > 0; --k)
        if (fingers_[static_cast<std::size_t>(k - 1)].touch) return k;
    return 0;
}

std::optional<ViewCamera::Pick> PointerFingers::ground_at(const HeightField& field, const ViewCamera& camera,
                                                          const glm::dvec2& at) {
    auto met = pick(field, camera, at.x, at.y);
    return met && met->drawn && met->from_front ? met : std::nullopt;
}

void PointerFingers::intend(const HeightField& field, const ViewCamera& camera,
                            std::span<const Contact> felt) {
    const bool by_touch = is_touched();
    for (std::size_t k = 0; k < fingers_.size(); ++k) {
        std::optional<glm::dvec2> at = fingers_[k].touch;
        if (!by_touch && pointer_ && k < static_cast<std::size_t>(count_)) {
            const glm::dvec2 offset =
                finger_offset(static_cast<int>(k), count_, finger_spread * camera.height);
            at = *pointer_ + glm::dvec2(offset.x, -offset.y);
        }
        if (at)
            lead(k, *at, field, camera, k < felt.size() ? &felt[k] : nullptr);
        else
            device_.withdraw(k);
    }
}

/// A new finger begins highest_m in front of the surface, on the clip camera's ray, where nothing can be in
/// between: a pointer has no hand that such a jump could hurt.
void PointerFingers::lead(std::size_t finger, const glm::dvec2& at, const HeightField& field,
                          const ViewCamera& camera, const Contact* felt) {
    const auto met = ground_at(field, camera, at);
    if (met) distance_ = glm::length(met->point - camera.eye);
    if (!distance_) return;
    const double metres = workspace_.metres_per_scene_unit,
                 deep_m = met ? depth_m() : std::min(depth_m(), hover_m);
    const glm::dvec3 direction = camera.direction(at.x, at.y);
    auto goal = felt ? detour(fingers_[finger], field, camera.eye + direction * *distance_, deep_m, *felt)
                     : std::nullopt;
    if (!goal) goal = camera.eye + direction * (*distance_ + deep_m / metres);
    // In a turned view a place in front of what is drawn may be behind a wall, which is not.
    if (met && deep_m <= 0 && is_behind_surface(field, *goal, 0))
        goal = met->point * std::max(1 + deep_m / metres / glm::length(met->point), 0.0);
    glm::dvec3 from(std::numeric_limits<double>::quiet_NaN());
    if (met)
        from = workspace_.to_device(met->point *
                                    std::max(1 + highest_m / metres / glm::length(met->point), 0.0));
    device_.intend(finger, workspace_.to_device(*goal), from, workspace_.to_device(camera.eye), deep_m <= 0);
}

/// The goal of a finger that must detour on its way to the `ground` under the pointer, world: lifted, or on
/// to the edge of the surface in between. nullopt: it goes straight. The surface on the path is examined
/// along the clip camera's rays: they see all of it, and a lifted finger meets no obstacle there.
std::optional<glm::dvec3> PointerFingers::detour(Finger& finger, const HeightField& field,
                                                 const glm::dvec3& ground, double deep_m,
                                                 const Contact& felt) const {
    const Camera& camera = field.scene().camera;
    const double metres = workspace_.metres_per_scene_unit;
    const auto from = project(camera, felt.proxy), to = project(camera, ground);
    const auto surface = surface_on_way(field, felt.proxy, ground);
    if (!from || !to || !surface) {
        finger.is_lifted = false;
        return std::nullopt;
    }
    // How much nearer to the camera than the finger the surface comes, and whether the path crosses it.
    const double height_m = (from->planar_depth - surface->nearest) * metres;
    const bool is_through = surface->behind * metres > step_m, is_step = is_through && height_m > step_m;
    if (finger.is_lifted)
        finger.is_lifted = height_m > 0;
    else if (is_caught(felt, deep_m) ||
             (is_step && glm::distance(ground, finger.lifted_for) * metres > again_m)) {
        finger.is_lifted = true;
        finger.lifted_for = ground;
    }
    const auto beyond_nearest = [&](const Camera::ImagePoint& pixel, double beyond_m) {
        const double depth = surface->nearest + beyond_m / metres;
        return unproject(camera, pixel.x, pixel.y, std::max(depth, surface->nearest / 2));
    };
    if (finger.is_lifted) return beyond_nearest(*from, highest_m);
    if (is_through && !is_step) return beyond_nearest(*to, deep_m);
    return std::nullopt;
}

/// Whether a finger lags its goal by more than its depth, a slope (step_m) and friction explain.
bool PointerFingers::is_caught(const Contact& felt, double deep_m) const {
    if (!felt.touching) return false;
    if (deep_m <= 0) return true;  // it was pressed, and comes off on its own ray
    const glm::dvec3 pull = (felt.goal - felt.proxy) * workspace_.metres_per_scene_unit;
    const glm::dvec3 ray = glm::normalize(felt.proxy);
    const double pressed_m = std::max(deep_m, 0.0) + step_m, along_m = glm::dot(pull, ray),
                 aside_m = glm::length(pull - ray * along_m);
    return along_m > pressed_m + caught_m || aside_m > pressed_m * felt.properties.static_friction + caught_m;
}

void PointerInput::take(const InputEvent& event, Leads leads, PointerFingers& fingers, WindowView& view,
                        int width, int height) {
    using Kind = InputEvent::Kind;
    const bool leads_fingers = leads == Leads::fingers;
    switch (event.kind) {
        case Kind::moved:
            return drag(move_to({event.x, event.y}, fingers), leads, fingers, view, width, height);
        case Kind::pressed:
            press(event);
            if (leads_fingers && held_ == "left") fingers.press(true);
            return;
        case Kind::released:
            if (leads_fingers && event.word == "left") fingers.press(false);
            return held_.clear();
        case Kind::wheel:
            if (leads_fingers && !event.control) return fingers.deepen(event.y * metres_per_notch);
            return view.near_by(std::pow(nearer_per_notch, event.y));
        case Kind::left_window:
            return leave(fingers);
        default:
            return;
    }
}

/// Returns the pointer's movement.
glm::dvec2 PointerInput::move_to(const glm::dvec2& place, PointerFingers& fingers) {
    const glm::dvec2 moved = place - at_;
    at_ = place;
    fingers.set_pointer(place);
    return moved;
}

void PointerInput::press(const InputEvent& event) {
    // Ctrl and left stand in for a missing middle button.
    held_ = event.word == "left" && event.control ? "middle" : event.word;
    shift_ = event.shift;
}

void PointerInput::drag(const glm::dvec2& moved, Leads leads, PointerFingers& fingers, WindowView& view,
                        int width, int height) {
    const bool is_right = held_ == "right";
    if (leads == Leads::fingers && is_right) return fingers.deepen(moved.y * metres_per_pixel);
    if (held_.empty() || (leads == Leads::fingers && held_ != "middle")) return;
    if (is_right || shift_)
        view.pan(moved.x, moved.y, width, height);
    else
        turn_by(moved, view, height);
}

void PointerInput::move_by(const glm::dvec2& pixels, int width, int height, PointerFingers& fingers) {
    if (!fingers.pointer()) at_ = glm::dvec2(width, height) / 2.0;
    at_ = glm::clamp(at_ + pixels, glm::dvec2(0.0), glm::dvec2(width, height));
    fingers.set_pointer(at_);
}

void PointerInput::leave(PointerFingers& fingers) {
    fingers.press(false);
    fingers.set_pointer(std::nullopt);
    held_.clear();
}

std::vector<InputEvent> TouchInput::take(const InputEvent& event, Ground ground, const Led& led, int width,
                                         int height) {
    using Kind = InputEvent::Kind;
    if (width < 1 || height < 1 || !std::isfinite(event.x) || !std::isfinite(event.y)) return {};
    Touch* const touch = find(event.touch);
    if (event.kind == Kind::touch_began)
        return touch ? std::vector<InputEvent>() : begin(event, ground, led.fingers, height);
    if (!touch) return {};  // it was cancelled
    if (event.kind == Kind::touch_ended) {
        const Touch ended = *touch;
        std::erase_if(touches_, [&](const Touch& other) { return other.id == ended.id; });
        return end(ended, led.fingers);
    }
    move(*touch, event, led, height);
    if (touch->role != Role::pointer) return {};
    return {pointer_event(Kind::moved, touch->at)};
}

std::vector<InputEvent> TouchInput::begin(const InputEvent& event, Ground ground, PointerFingers* fingers,
                                          int height) {
    if (touches_.size() >= most_touches) return {};
    const glm::dvec2 at(event.x, event.y);
    Touch touch{event.touch, role_on(ground, fingers), at, at, event.seconds};
    if (touch.role == Role::pointer) {
        touches_.push_back(touch);
        return {pointer_event(InputEvent::Kind::moved, at), pointer_event(InputEvent::Kind::pressed, at)};
    }
    // No pointer until it moves again: X may report its pointer before the finger that moved it.
    if (fingers) fingers->set_pointer(std::nullopt);
    pair_since_s_ = is_pair(touch, height) ? std::optional(event.seconds) : std::nullopt;
    if (touch.role == Role::finger) {
        const auto finger = fingers->put_down(at);
        touch.finger = finger.value_or(0);
        if (!finger) touch.role = Role::none;
    }
    touches_.push_back(touch);
    return {};
}

TouchInput::Role TouchInput::role_on(Ground ground, const PointerFingers* fingers) const {
    if (!fingers || ground == Ground::pointers) return count(Role::pointer) == 0 ? Role::pointer : Role::none;
    if (gesture_ || ground == Ground::nothing) return Role::view;
    return Role::finger;
}

/// Whether this touch and the only other one are put down together.
bool TouchInput::is_pair(const Touch& second, int height) const {
    if (gesture_ || count(Role::finger) + count(Role::view) != 1) return false;
    const auto first = std::ranges::find_if(touches_, over_picture);
    return second.began_s - first->began_s <= together_s &&
           glm::distance(first->at, first->began) <= moved_share * height;
}

void TouchInput::move(Touch& touch, const InputEvent& event, const Led& led, int height) {
    if (pair_since_s_ && event.seconds - *pair_since_s_ > rest_s) pair_since_s_.reset();
    const glm::dvec2 to(event.x, event.y);
    if (pair_since_s_ && over_picture(touch) && glm::distance(to, touch.began) > moved_share * height)
        begin_gesture(led.fingers);
    const Spread before = spread();
    touch.at = to;
    if (touch.role == Role::finger) led.fingers->move(touch.finger, to);
    if (touch.role != Role::view) return;
    const Spread now = spread();
    turn_by(now.middle - before.middle, *led.view, height);
    const double least = least_radius_share * height;
    if (now.touches > 1 && before.radius > least && now.radius > least)
        led.view->near_by(std::clamp(now.radius / before.radius, 1 / most_nearer, most_nearer));
}

/// The pair releases what it touched.
void TouchInput::begin_gesture(PointerFingers* fingers) {
    pair_since_s_.reset();
    gesture_ = true;
    for (Touch& touch : touches_) {
        if (touch.role == Role::finger) fingers->lift(touch.finger);
        if (over_picture(touch)) touch.role = Role::view;
    }
}

std::vector<InputEvent> TouchInput::end(const Touch& touch, PointerFingers* fingers) {
    if (touch.role == Role::pointer)
        return {pointer_event(InputEvent::Kind::released, touch.at),
                pointer_event(InputEvent::Kind::left_window, touch.at)};
    pair_since_s_.reset();
    if (touch.role == Role::finger) fingers->lift(touch.finger);
    if (count(Role::view) == 0) gesture_ = false;
    return {};
}

std::vector<InputEvent> TouchInput::cancel(PointerFingers* fingers) {
    std::vector<InputEvent> events;
    for (const Touch& touch : touches_) {
        if (touch.role == Role::finger) fingers->lift(touch.finger);
        // Leaves before the release, so that it clicks nothing.
        if (touch.role == Role::pointer)
            events = {pointer_event(InputEvent::Kind::left_window, touch.at),
                      pointer_event(InputEvent::Kind::released, touch.at)};
    }
    *this = TouchInput();
    return events;
}

TouchInput::Spread TouchInput::spread() const {
    Spread spread;
    for (const Touch& touch : touches_) {
        if (touch.role != Role::view) continue;
        spread.middle += touch.at;
        ++spread.touches;
    }
    if (spread.touches == 0) return spread;
    spread.middle /= spread.touches;
    for (const Touch& touch : touches_)
        if (touch.role == Role::view)
            spread.radius += glm::distance(touch.at, spread.middle) / spread.touches;
    return spread;
}

TouchInput::Touch* TouchInput::find(std::int64_t id) {
    const auto found = std::ranges::find(touches_, id, &Touch::id);
    return found == touches_.end() ? nullptr : &*found;
}

}  // namespace touchable
