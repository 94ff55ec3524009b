// SPDX-License-Identifier: Apache-2.0
#include "player/window/persistent_device.hpp"

#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// A failed device's fault; empty: it works.
std::string words_of_fault(const PersistentDevice& hand) {
    if (hand.is_looked_for()) return "looking for the " + hand.name();
    const auto health = hand.health();
    const std::string why = health ? hand.name() + " has failed" : health.error().message;
    if (hand.is_gone()) return "no device: " + why + " - press F to look for it again";
    return health ? std::string() : "the device is away: " + why;
}

}  // namespace

PersistentDevice::PersistentDevice(std::shared_ptr<HapticDevice> device)
    : device_(std::move(device)),
      age_s_(never),
      zeros_(static_cast<std::size_t>(device_->fingers()), glm::dvec3(0)) {}

PersistentDevice::~PersistentDevice() {
    ending_.request_stop();
    if (looking_.joinable()) looking_.join();
    device_->close();
}

Result<void> PersistentDevice::open() {
    if (state() != State::closed) return {};
    const StopScope work = StopScope::for_all();  // independent of clips given up meanwhile
    const StopScope until(ending_.get_token());
    TRY(device_->open());
    state_.store(State::open, std::memory_order_release);
    return {};
}

bool PersistentDevice::read_positions(std::span<glm::dvec3> device_metres) {
    if (state() == State::closed) return false;
    if (state() == State::open && device_->read_positions(device_metres)) {
        age_s_.store(device_->age_s(), std::memory_order_relaxed);
        return true;
    }
    auto expected = State::open;
    state_.compare_exchange_strong(expected, State::gone, std::memory_order_acq_rel);
    age_s_.store(never, std::memory_order_relaxed);
    std::ranges::fill(device_metres, glm::dvec3(std::numeric_limits<double>::quiet_NaN()));
    return true;
}

bool PersistentDevice::write_forces(std::span<const glm::dvec3> newtons) {
    if (state() == State::closed) return false;
    const bool is_unpowered = is_unpowered_.load(std::memory_order_acquire);
    if (state() == State::open && !device_->write_forces(is_unpowered ? zeros_ : newtons))
        state_.store(State::gone, std::memory_order_release);
    return true;
}

void PersistentDevice::look_again() {
    if (state() != State::gone) return;
    if (looking_.joinable()) looking_.join();
    state_.store(State::looked_for, std::memory_order_release);
    const auto begun = start_thread(looking_, "device-search", "that looks for the device", [this] {
        const StopScope until(ending_.get_token());
        const bool is_there = bool(device_->open());
        if (!is_there && stop_requested()) return;  // the window ends, and the search did not finish
        state_.store(is_there ? State::open : State::gone, std::memory_order_release);
    });
    if (!begun) state_.store(State::gone, std::memory_order_release);
}

HandState hand_state(const PersistentDevice& hand, const HandControl& control, bool is_inside) {
    using What = HandState::What;
    if (std::string fault = words_of_fault(hand); !fault.empty()) return {What::away, std::move(fault), {}};
    std::string remark = hand.prompt();
    if (remark.empty() && !(hand.age_s() <= HapticDevice::oldest_s)) remark = "no position comes from it";
    if (!remark.empty()) remark = hand.name() + ": " + remark;
    const DeviceCapabilities has = hand.capabilities();
    if (has.axes_driven == 0)
        return {What::has_no_force, "the " + hand.name() + " exerts no force: you see what you touch",
                remark};
    if (control.is_repositioned())
        return {What::repositioned, "no force while the hand is repositioned", remark};
    if (control.force_is_asked()) {
        const bool has_to_come_out = remark.empty() && (is_inside || control.waits_to_be_free());
        if (has_to_come_out) remark = "lift the finger off the surface: then it is felt";
        return {What::on, "forces on - F turns them off", remark, has_to_come_out};
    }
    const std::string button = has.buttons > 0 ? std::string(" or ") + has.first_button : "";
    return {What::off, "forces off - press F" + button, remark};
}

}  // namespace touchable
