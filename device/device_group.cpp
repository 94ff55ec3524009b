#include "device/device_group.hpp"

#include <algorithm>
#include <cassert>
#include <glm/common.hpp>
#include <string_view>
#include <utility>

namespace touchable {

DeviceGroup::DeviceGroup(std::vector<std::unique_ptr<HapticDevice>> devices) : devices_(std::move(devices)) {
    assert(!devices_.empty());
    for (const auto& device : devices_) fingers_ += device->fingers();
}

std::string DeviceGroup::name() const {
    std::string names;
    for (const auto& device : devices_) names += (names.empty() ? "" : ", ") + device->name();
    return names;
}

DeviceLimits DeviceGroup::limits() const {
    DeviceLimits least = devices_.front()->limits();
    for (const auto& device : devices_) {
        least.max_force = std::min(least.max_force, device->limits().max_force);
        least.max_stiffness = std::min(least.max_stiffness, device->limits().max_stiffness);
    }
    return least;
}

DeviceCapabilities DeviceGroup::capabilities() const {
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

Result<void> DeviceGroup::open() {
    for (const auto& device : devices_)
        if (auto opened = device->open(); !opened.ok()) {
            close();
            return opened;
        }
    return {};
}

void DeviceGroup::close() {
    for (const auto& device : devices_) device->close();
}

/// Each gets its share, whatever the others say: none is left with a force because another has failed.
bool DeviceGroup::read_positions(std::span<glm::dvec3> device_metres) {
    bool all = true;
    for (const auto& device : devices_) {
        const auto own = static_cast<std::size_t>(device->fingers());
        all = device->read_positions(device_metres.first(own)) && all;
        device_metres = device_metres.subspan(own);
    }
    return all;
}

bool DeviceGroup::write_forces(std::span<const glm::dvec3> newtons) {
    bool all = true;
    for (const auto& device : devices_) {
        const auto own = static_cast<std::size_t>(device->fingers());
        all = device->write_forces(newtons.first(own)) && all;
        newtons = newtons.subspan(own);
    }
    return all;
}

std::uint32_t DeviceGroup::buttons() {
    std::uint32_t pressed = 0;
    for (const auto& device : devices_) pressed |= device->buttons();
    return pressed;
}

double DeviceGroup::age_s() const {
    double oldest = 0;
    for (const auto& device : devices_) oldest = std::max(oldest, device->age_s());
    return oldest;
}

bool DeviceGroup::is_over() const {
    return std::all_of(devices_.begin(), devices_.end(),
                       [](const auto& device) { return device->is_over(); });
}

std::string DeviceGroup::prompt() const {
    std::string prompts;
    for (const auto& device : devices_)
        if (const std::string prompt = device->prompt(); !prompt.empty())
            prompts += (prompts.empty() ? "" : "; ") + prompt;
    return prompts;
}

std::string DeviceGroup::why_no_position() const {
    std::string all;
    for (const auto& device : devices_) all += (all.empty() ? "" : "; ") + device->why_no_position();
    return all;
}

Result<void> DeviceGroup::health() const {
    for (const auto& device : devices_)
        if (auto healthy = device->health(); !healthy.ok()) return healthy;
    return {};
}

}  // namespace touchable
