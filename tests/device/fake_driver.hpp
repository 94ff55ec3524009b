#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "device/drivers/device_driver.hpp"

namespace touchable::test {

/// Hardware that does what a test says. The test and whoever drives it take turns, or only one of them is at
/// work while the other looks.
class FakeHardware {
public:
    enum class Fault {
        none,
        error,
        throws,
        silent,
        not_a_number,
        beyond_the_room,
        leap,
        refuses_force,
        no_place
    };

    bool plugged = true;
    Fault fault = Fault::none;
    glm::dvec3 place{0.0};
    std::uint32_t buttons = 0;
    std::string prompt;
    std::optional<ZeroForcePacket> zero_force_packet;
    std::string not_opened_because;  ///< what it says when it is connected without being plugged; empty: gone
    std::int64_t kept_ns = 0;        ///< for how long it has had what it tells
    int descriptor = -1;             ///< of hardware that speaks by itself
    bool over = false;

    bool connected = false;
    glm::dvec3 force{0.0};  ///< of finger 0, that was sent last
    std::int64_t sent = 0, connections = 0, forgotten = 0;
    std::function<void()> as_it_is_waited_for;  ///< in a call that waits for what it tells

    Error gone() const { return {ErrorKind::device, "fake: gone"}; }
};

/// One finger on it.
class FakeDriver final : public DeviceDriver {
public:
    explicit FakeDriver(FakeHardware& hardware) : hardware_(hardware) {}

    std::string name() const override { return "fake"; }
    int fingers() const override { return 1; }
    DeviceLimits limits() const override { return {10, 3000}; }
    DeviceCapabilities capabilities() const override { return {.reach = glm::dvec3(0.1), .buttons = 2}; }
    Result<void> connect() override {
        if (!hardware_.plugged && !hardware_.not_opened_because.empty())
            return Error{ErrorKind::device, hardware_.not_opened_because};
        if (!hardware_.plugged) return hardware_.gone();
        hardware_.connected = true;
        hardware_.force = glm::dvec3(0);
        ++hardware_.connections;
        told_ = false;
        return {};
    }
    void disconnect() noexcept override {
        hardware_.connected = false;
        hardware_.force = glm::dvec3(0);
    }
    Result<void> send(std::span<const glm::dvec3> newtons) override {
        if (!hardware_.plugged || hardware_.fault == FakeHardware::Fault::refuses_force)
            return hardware_.gone();
        hardware_.force = newtons[0];
        ++hardware_.sent;
        return {};
    }
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds) override {
        using Fault = FakeHardware::Fault;
        if (hardware_.as_it_is_waited_for) hardware_.as_it_is_waited_for();
        constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
        if (!hardware_.plugged || hardware_.fault == Fault::error) return hardware_.gone();
        if (hardware_.fault == Fault::throws) throw std::runtime_error("bytes that cannot be");
        if (hardware_.fault == Fault::silent) return false;
        sample.metres[0] = hardware_.place;
        sample.buttons = hardware_.buttons;
        sample.kept_ns = hardware_.kept_ns;
        if (hardware_.fault == Fault::not_a_number) sample.metres[0].y = no_number;
        if (hardware_.fault == Fault::no_place) sample.metres[0] = glm::dvec3(no_number);
        if (hardware_.fault == Fault::beyond_the_room) sample.metres[0].x += 100;
        // (Where a finger is first, it may be anywhere.)
        if (hardware_.fault == Fault::leap && told_) sample.metres[0].z -= 0.2;
        told_ = told_ || hardware_.fault == Fault::none;
        return hardware_.fault != Fault::leap || told_;
    }
    Result<void> forget_what_came() override {
        ++hardware_.forgotten;
        return {};
    }
    int descriptor() const override { return hardware_.descriptor; }
    bool is_over() const override { return hardware_.over; }
    std::string prompt() const override { return hardware_.prompt; }
    std::optional<ZeroForcePacket> zero_force_packet() const override { return hardware_.zero_force_packet; }

private:
    FakeHardware& hardware_;
    bool told_ = false;  // a sound place since it was connected
};

}  // namespace touchable::test
