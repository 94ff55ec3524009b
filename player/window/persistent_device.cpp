#include "player/window/persistent_device.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "engine/base/start_thread.hpp"

namespace touchable {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

}  // namespace

PersistentDevice::PersistentDevice(std::shared_ptr<HapticDevice> device)
    : device_(std::move(device)),
      age_s_(never),
      zeros_(static_cast<std::size_t>(device_->fingers()), glm::dvec3(0)) {}

PersistentDevice::~PersistentDevice() {
    if (looking_.joinable()) looking_.join();
    device_->close();
}

Result<void> PersistentDevice::open() {
    if (state() != State::closed) return {};
    if (auto opened = device_->open(); !opened.ok()) return opened;
    state_.store(State::open, std::memory_order_release);
    return {};
}

void PersistentDevice::close() {
    if (state() == State::open) device_->write_forces(zeros_);
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
    std::fill(device_metres.begin(), device_metres.end(),
              glm::dvec3(std::numeric_limits<double>::quiet_NaN()));
    return true;
}

bool PersistentDevice::write_forces(std::span<const glm::dvec3> newtons) {
    if (state() == State::closed) return false;
    const bool is_unpowered = is_unpowered_.load(std::memory_order_acquire);
    if (state() == State::open && !device_->write_forces(is_unpowered ? zeros_ : newtons))
        state_.store(State::gone, std::memory_order_release);
    return true;
}

std::uint32_t PersistentDevice::buttons() {
    return state() == State::open ? device_->buttons() : 0;
}

void PersistentDevice::look_again() {
    if (state() != State::gone) return;
    if (looking_.joinable()) looking_.join();
    state_.store(State::looked_for, std::memory_order_release);
    const auto begun = start_thread(looking_, "device-search", "that looks for the device", [this] {
        const bool is_there = device_->open().ok();
        state_.store(is_there ? State::open : State::gone, std::memory_order_release);
    });
    if (!begun.ok()) state_.store(State::gone, std::memory_order_release);
}

}  // namespace touchable
