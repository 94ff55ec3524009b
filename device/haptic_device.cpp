// SPDX-License-Identifier: Apache-2.0
#include "device/haptic_device.hpp"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <string_view>

#include "device/force_gate.h"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {
namespace {

/// The device that make_device_group returns.
class DeviceGroup final : public HapticDevice {
public:
    explicit DeviceGroup(std::vector<std::unique_ptr<HapticDevice>> devices) : devices_(std::move(devices)) {
        assert(!devices_.empty());
        for (const auto& device : devices_) fingers_ += device->fingers();
    }

    std::string name() const override { return all_said(&HapticDevice::name, ", "); }
    DeviceLimits limits() const override {
        DeviceLimits least = devices_.front()->limits();
        for (const auto& device : devices_) {
            least.max_force = std::min(least.max_force, device->limits().max_force);
            least.max_stiffness = std::min(least.max_stiffness, device->limits().max_stiffness);
        }
        return least;
    }
    int fingers() const override { return fingers_; }
    DeviceCapabilities capabilities() const override {
        DeviceCapabilities all = devices_.front()->capabilities();
        for (const auto& device : devices_) {
            const DeviceCapabilities one = device->capabilities();
            all.axes_sensed = std::min(all.axes_sensed, one.axes_sensed);
            all.axes_driven = std::max(all.axes_driven, one.axes_driven);
            all.reach = glm::min(all.reach, one.reach);
            all.rate_hz = std::min(all.rate_hz, one.rate_hz);
            all.buttons = std::max(all.buttons, one.buttons);
            all.own_watchdog = all.own_watchdog && one.own_watchdog;
            if (std::string_view(all.first_button) != one.first_button)
                all.first_button = DeviceCapabilities().first_button;
        }
        return all;
    }

    Result<void> open() override {
        for (const auto& device : devices_)
            if (auto opened = device->open(); !opened) {
                close();
                return opened;
            }
        return {};
    }
    void close() override {
        for (const auto& device : devices_) device->close();
    }
    bool read_positions(std::span<glm::dvec3> device_metres) override {
        return each_has_its_share(device_metres, &HapticDevice::read_positions);
    }
    bool write_forces(std::span<const glm::dvec3> newtons) override {
        return each_has_its_share(newtons, &HapticDevice::write_forces);
    }
    /// Buttons that are pressed on any of the devices.
    std::uint32_t buttons() override {
        std::uint32_t pressed = 0;
        for (const auto& device : devices_) pressed |= device->buttons();
        return pressed;
    }
    /// Age of the oldest positions.
    double age_s() const override {
        double oldest = 0;
        for (const auto& device : devices_) oldest = std::max(oldest, device->age_s());
        return oldest;
    }

    /// Whether all devices are over.
    bool is_over() const override {
        return std::ranges::all_of(devices_, [](const auto& device) { return device->is_over(); });
    }
    std::string prompt() const override { return all_said(&HapticDevice::prompt, "; "); }
    std::string why_no_position() const override { return all_said(&HapticDevice::why_no_position, "; "); }
    Result<void> health() const override {
        for (const auto& device : devices_) TRY(device->health());
        return {};
    }

private:
    /// The texts of all devices, without empty ones.
    std::string all_said(std::string (HapticDevice::*says)() const, const char* between) const {
        std::string all;
        for (const auto& device : devices_)
            if (const std::string said = (*device.*says)(); !said.empty())
                all += (all.empty() ? "" : between) + said;
        return all;
    }
    /// Calls every device, even after a failure: no device keeps a force because another has failed.
    template <class Vector>
    bool each_has_its_share(std::span<Vector> fingers, bool (HapticDevice::*call)(std::span<Vector>)) {
        bool all = true;
        for (const auto& device : devices_) {
            const auto own = static_cast<std::size_t>(device->fingers());
            all = (*device.*call)(fingers.first(own)) && all;
            fingers = fingers.subspan(own);
        }
        return all;
    }

    const std::vector<std::unique_ptr<HapticDevice>> devices_;
    int fingers_ = 0;
};

constexpr double tick_of_handles_s = 0.001, pointer_reading_s = 0.001;  // periods
constexpr double pointer_arrival = 0.004;  // device metres along the view; a nearer finger has arrived
// A finger that hovers is in front of the surface by more than this share of its distance; device metres that
// it comes out at least.
constexpr double front_share = 1e-6, out_of_it = 0.001;

constexpr HandleDynamics standard_handle;
constexpr std::array<KeyedValues::Key, 8> simulated_keys{{
    {"mass", "kg", 0.05, 10, standard_handle.mass},
    {"damping", "N s/m", 0, 50, standard_handle.damping},
    {"friction", "N", 0, 5, standard_handle.friction},
    {"quantum", "um", 0, 1000, standard_handle.quantum * 1e6},
    {"hand", "N/mm", 0.01, 5, standard_handle.hand_stiffness / 1000},
    {"force", "N", 0.1, 1000, 10},
    {"stiffness", "N/mm", 0.01, 1000, 10},
    {"unplug", "s", 0.001, 1e6, 0},
}};

bool is_finite(const glm::dvec3& v) {
    return std::isfinite(glm::dot(v, v));
}

/// Unit vector from one point to the other; zero if there is none.
glm::dvec3 direction_between(const glm::dvec3& from, const glm::dvec3& to) {
    const glm::dvec3 way = to - from;
    const double length = std::sqrt(glm::dot(way, way));
    return length > 1e-9 && std::isfinite(length) ? way / length : glm::dvec3(0);
}

/// Whether a position is within `farthest`; false for NaN.
bool is_near(const glm::dvec3& place) {
    return glm::dot(place, place) <= PointerDevice::farthest * PointerDevice::farthest;
}

}  // namespace

std::unique_ptr<HapticDevice> make_device_group(std::vector<std::unique_ptr<HapticDevice>> devices) {
    return std::make_unique<DeviceGroup>(std::move(devices));
}

// ---- SimulatedDevice

SimulatedDevice::SimulatedDevice(int fingers, DeviceLimits limits, const HandleDynamics& handle)
    : limits_(limits),
      handles_(static_cast<std::size_t>(fingers), HeldHandle(handle, tick_of_handles_s)),
      exerted_(static_cast<std::size_t>(fingers), glm::dvec3(0)) {
    assert(fingers > 0 && limits.max_force > 0 && limits.max_stiffness > 0);
}

bool SimulatedDevice::read_positions(std::span<glm::dvec3> device_metres) {
    if (!open_ || fault_) return false;
    assert(device_metres.size() == handles_.size());
    for (std::size_t finger = 0; finger < handles_.size(); ++finger)
        device_metres[finger] = handles_[finger].reading();
    return true;
}

bool SimulatedDevice::write_forces(std::span<const glm::dvec3> newtons) {
    if (!open_ || fault_) return false;
    assert(newtons.size() == exerted_.size());
    for (std::size_t finger = 0; finger < newtons.size(); ++finger) {
        if (!std::isfinite(glm::length(newtons[finger]))) {
            fail("was given a force that is not finite");
            return false;
        }
        exerted_[finger] = newtons[finger];
        force_gate(glm::value_ptr(exerted_[finger]), limits_.max_force, limits_.max_force, 0);
    }
    silent_ticks_ = 0;
    return true;
}

void SimulatedDevice::put(int finger, const glm::dvec3& device_metres) {
    if (is_finite(device_metres))
        handles_[static_cast<std::size_t>(finger)].put(device_metres, glm::dvec3(0));
    intend(finger, device_metres);
}

void SimulatedDevice::intend(int finger, const glm::dvec3& device_metres) {
    if (is_finite(device_metres)) handles_[static_cast<std::size_t>(finger)].intend(device_metres);
}

void SimulatedDevice::pass_tick() {
    for (std::size_t finger = 0; finger < handles_.size(); ++finger)
        handles_[finger].advance(exerted_[finger]);
    ++silent_ticks_;
    if (silent_ticks_ * tick_of_handles_s > silence_s) power_off();
    if (ticks_to_unplugging_ && --*ticks_to_unplugging_ <= 0) {
        ticks_to_unplugging_.reset();
        fail("was unplugged");
    }
}

Result<std::unique_ptr<SimulatedDevice>> make_simulated_device(const std::string& description, int fingers) {
    const auto [name, pairs] = KeyedValues::name_and_pairs(description);
    if (name != "simulated")
        return usage_error("unknown device '" + std::string(name) + "'; the one there is is simulated");
    TRY_ASSIGN(const auto given, KeyedValues::parse("device 'simulated'", pairs, simulated_keys));
    HandleDynamics handle;
    handle.mass = given.number("mass");
    handle.damping = given.number("damping");
    handle.friction = given.number("friction");
    handle.quantum = given.number("quantum") / 1e6;
    handle.hand_stiffness = given.number("hand") * 1000;
    const DeviceLimits limits{given.number("force"), given.number("stiffness") * 1000};
    auto device = std::make_unique<SimulatedDevice>(fingers, limits, handle);
    if (given.given("unplug"))
        device->unplug_after(static_cast<std::int64_t>(given.number("unplug") / tick_of_handles_s + 0.5));
    return device;
}

// ---- PointerDevice

PointerDevice::PointerDevice(int fingers, const glm::dvec3& refuge, const PointerSettings& settings)
    : settings_(settings),
      refuge_(refuge),
      led_(static_cast<std::size_t>(fingers),
           Led{LedPoint({settings.across_s, settings.along_s}, pointer_reading_s),
               LedPoint({settings.across_s, settings.across_s}, pointer_reading_s)}) {
    assert(fingers >= 1 && fingers <= most_fingers);
    assert(settings.max_speed > 0 && settings.approach_speed > 0 && settings.limits.max_force > 0 &&
           settings.limits.max_stiffness > 0);
    retreat();
}

void PointerDevice::retreat() {
    for (Led& led : led_) {
        led.point.put(refuge_);
        led.quick.put(refuge_);
        led.comes = true;
        led.has_begun = false;
        led.clear.reset();
    }
}

void PointerDevice::lead(const Meant& meant, Led& led) const {
    led.hovers = !meant.place || meant.hovers;
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
    const double length = std::sqrt(glm::dot(step, step)), farthest_step = speed * pointer_reading_s;
    if (length > farthest_step) led.point.shift(step * (farthest_step / length - 1));
    led.comes =
        led.comes && std::abs(glm::dot(*meant.place - led.point.place(), meant.along)) > pointer_arrival;
}

bool PointerDevice::read_positions(std::span<glm::dvec3> device_metres) {
    if (!works()) return false;
    assert(device_metres.size() == led_.size());
    const std::uint32_t opening = opening_.load(std::memory_order_acquire);
    const std::uint32_t force = force_.load(std::memory_order_acquire);
    // A stop between two readings counts, even if the force was on again before the second one.
    if (opening != seen_opening_ || force != seen_force_) retreat();
    seen_opening_ = opening;
    seen_force_ = force;
    const auto& meant = newest_.read();
    for (std::size_t finger = 0; finger < led_.size(); ++finger) {
        if (is_on(force)) lead(meant[finger], led_[finger]);
        device_metres[finger] = led_[finger].point.place();
    }
    return true;
}

/// The next goal of a free finger at `from` that wants to get to `wanted`.
glm::dvec3 PointerDevice::next_clear(const HeightField& field, const Workspace& workspace,
                                     const glm::dvec3& from, const glm::dvec3& wanted) const {
    const double metres = workspace.metres_per_scene_unit;
    if (is_behind_surface(field, from, -front_share)) {
        // The surface has passed it. It comes out by as much as it is in: the side of an object that the
        // proxy was pushed to does not hold it back then.
        const auto pixel = project(field.scene().camera, from);
        const glm::dvec3 surface = point_under(field, pixel->x, pixel->y);
        const double by = std::max(glm::distance(from, surface), out_of_it / metres);
        return surface * std::max(1 - by / glm::length(surface), 0.5);
    }
    if (!is_behind_surface(field, wanted, -front_share) && is_way_free(field, from, wanted)) return wanted;
    const glm::dvec3 beside = wanted * (from.z / wanted.z);
    if (wanted.z < from.z && is_way_free(field, from, beside)) return beside;
    return from * std::max(1 - settings_.max_speed * pointer_reading_s / metres / glm::length(from), 0.0);
}

void PointerDevice::keep_clear(const HeightField& field, const Workspace& workspace,
                               std::span<glm::dvec3> goals) {
    for (std::size_t finger = 0; finger < goals.size(); ++finger) {
        Led& led = led_[finger];
        glm::dvec3& goal = goals[finger];
        if (!led.hovers) led.clear.reset();
        if (!led.hovers || (!led.clear && is_behind_surface(field, goal, -front_share))) continue;
        const glm::dvec3 next = led.clear ? next_clear(field, workspace, *led.clear, goal) : goal;
        led.point.shift((next - goal) * workspace.metres_per_scene_unit);
        led.quick.shift((next - goal) * workspace.metres_per_scene_unit);
        led.clear = goal = next;
    }
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
            meant_[finger] = {places[finger], direction_between(eye, places[finger])};
    }
    newest_.write(meant_);
}

void PointerDevice::intend(std::size_t finger, const glm::dvec3& place, const glm::dvec3& from,
                           const glm::dvec3& eye, bool hovers) {
    assert(finger < led_.size());
    if (!is_near(place)) return;
    meant_[finger] = {place, direction_between(eye, place),
                      is_near(from) ? std::optional(from) : std::nullopt, hovers};
    newest_.write(meant_);
}

void PointerDevice::withdraw(std::size_t finger) {
    assert(finger < led_.size());
    meant_[finger].place.reset();
    newest_.write(meant_);
}

}  // namespace touchable
