#include "device/pointer_device.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

namespace touchable {
namespace {

constexpr double reading_s = 0.001;  // from one to the next
constexpr double arrival = 0.004;    // device metres: nearer along the view, a finger is there

/// Unit vector from one to the other; zero where there is none.
glm::dvec3 direction(const glm::dvec3& from, const glm::dvec3& to) {
    const glm::dvec3 way = to - from;
    const double length = std::sqrt(glm::dot(way, way));
    return length > 1e-9 && std::isfinite(length) ? way / length : glm::dvec3(0);
}

/// Not what is no number.
bool is_near(const glm::dvec3& place) {
    return glm::dot(place, place) <= PointerDevice::farthest * PointerDevice::farthest;
}

}  // namespace

PointerDevice::PointerDevice(int fingers, const glm::dvec3& refuge, const PointerSettings& settings)
    : settings_(settings),
      refuge_(refuge),
      led_(static_cast<std::size_t>(fingers),
           Led{LedPoint(settings.times, reading_s),
               LedPoint({settings.times.across_s, settings.times.across_s}, reading_s)}) {
    assert(fingers >= 1 && fingers <= most_fingers);
    assert(settings.max_speed > 0 && settings.approach_speed > 0 && settings.limits.max_force > 0 &&
           settings.limits.max_stiffness > 0);
    retreat();
}

Result<void> PointerDevice::open() {
    fault_.store(nullptr, std::memory_order_relaxed);
    opening_.store(++openings_, std::memory_order_release);
    return {};
}

void PointerDevice::close() {
    opening_.store(0, std::memory_order_release);
}

bool PointerDevice::works() const {
    return opening_.load(std::memory_order_acquire) != 0 && !fault_.load(std::memory_order_relaxed);
}

Result<void> PointerDevice::health() const {
    if (const char* fault = fault_.load(std::memory_order_relaxed))
        return Error{ErrorKind::device, "pointer " + std::string(fault) + "; open it again"};
    return {};
}

void PointerDevice::retreat() {
    for (Led& led : led_) {
        led.point.put(refuge_);
        led.quick.put(refuge_);
        led.comes = true;
        led.has_begun = false;
    }
}

void PointerDevice::lead(const Meant& meant, Led& led) const {
    if (!meant.place) {
        led.comes = true;
        led.has_begun = false;
        led.point.follow(refuge_, glm::dvec3(0), settings_.max_speed);
        led.quick.put(led.point.place());
        return;
    }
    if (led.comes && meant.from && !std::exchange(led.has_begun, true)) {
        led.point.put(*meant.from);
        led.quick.put(*meant.from);
    }
    const double speed = led.comes ? settings_.approach_speed : settings_.max_speed;
    const glm::dvec3 before = led.point.place();
    led.point.follow(*meant.place, meant.along, speed);
    led.quick.follow(*meant.place, meant.along, speed);
    const double beyond = glm::dot(led.point.place() - led.quick.place(), meant.along);
    led.point.shift((std::clamp(beyond, -settings_.leash, settings_.leash) - beyond) * meant.along);
    const glm::dvec3 step = led.point.place() - before;
    const double length = std::sqrt(glm::dot(step, step)), farthest_step = speed * reading_s;
    if (length > farthest_step) led.point.shift(step * (farthest_step / length - 1));
    led.comes = led.comes && std::abs(glm::dot(*meant.place - led.point.place(), meant.along)) > arrival;
}

bool PointerDevice::read_positions(std::span<glm::dvec3> device_metres) {
    if (!works()) return false;
    assert(device_metres.size() == led_.size());
    const std::uint32_t opening = opening_.load(std::memory_order_acquire);
    const std::uint32_t force = force_.load(std::memory_order_acquire);
    // Whoever stopped it and let it go on between two readings has stopped it all the same.
    if (opening != seen_opening_ || force != seen_force_) retreat();
    seen_opening_ = opening;
    seen_force_ = force;
    const auto& meant = intents_.read();
    for (std::size_t finger = 0; finger < led_.size(); ++finger) {
        if (is_on(force)) lead(meant[finger], led_[finger]);
        device_metres[finger] = led_[finger].point.place();
    }
    return true;
}

bool PointerDevice::write_forces(std::span<const glm::dvec3> newtons) {
    if (!works()) return false;
    assert(newtons.size() == led_.size());
    for (const glm::dvec3& force : newtons)
        if (!std::isfinite(glm::length(force))) {
            fault_.store("was given a force that is not finite", std::memory_order_relaxed);
            return false;
        }
    return true;
}

void PointerDevice::intend(std::span<const glm::dvec3> places, const glm::dvec3& eye) {
    assert(places.size() <= led_.size());
    for (std::size_t finger = 0; finger < meant_.size(); ++finger) {
        if (finger >= places.size())
            meant_[finger].place.reset();
        else if (is_near(places[finger]))
            meant_[finger] = {places[finger], direction(eye, places[finger])};
    }
    intents_.write(meant_);
}

void PointerDevice::intend(std::size_t finger, const glm::dvec3& place, const glm::dvec3& from,
                           const glm::dvec3& eye) {
    assert(finger < led_.size());
    if (!is_near(place)) return;
    meant_[finger] = {place, direction(eye, place), is_near(from) ? std::optional(from) : std::nullopt};
    intents_.write(meant_);
}

void PointerDevice::withdraw(std::size_t finger) {
    assert(finger < led_.size());
    meant_[finger].place.reset();
    intents_.write(meant_);
}

void PointerDevice::set_force(bool on) {
    std::uint32_t now = force_.load(std::memory_order_relaxed);
    while (is_on(now) != on && !force_.compare_exchange_weak(now, now + 1, std::memory_order_acq_rel,
                                                             std::memory_order_relaxed)) {
    }
}

}  // namespace touchable
