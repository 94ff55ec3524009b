// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/geometric.hpp>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "device/drivers/device_catalog.hpp"
#include "device/drivers/device_driver.hpp"
#include "device/hand.hpp"
#include "device/point_motion.hpp"

namespace touchable::test {

/// Hardware that does what a test says. The test and the driver's caller take turns, or only one of them
/// is at work while the other looks.
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

/// A driver of that hardware, with one finger.
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

/// A device on a bench with no hand on it, in virtual time: its force acts so many ticks after it was
/// written, and everything that went out is looked at.
class BenchDevice final : public HapticDevice {
public:
    explicit BenchDevice(const HandleDynamics& dynamics, int delay_ticks = 0)
        : handle_(dynamics, 0.001), forces_(static_cast<std::size_t>(delay_ticks) + 1, glm::dvec3(0)) {}

    std::string name() const override { return "bench device"; }
    DeviceLimits limits() const override { return limit; }
    int fingers() const override { return 1; }
    DeviceCapabilities capabilities() const override { return {.axes_driven = driven}; }
    Result<void> open() override { return {}; }
    void close() override {}
    bool read_positions(std::span<glm::dvec3> metres) override {
        if (broken) return false;
        metres[0] = lost ? glm::dvec3(std::numeric_limits<double>::quiet_NaN()) : handle_.reading();
        return true;
    }
    bool write_forces(std::span<const glm::dvec3> newtons) override {
        spent_ns += takes_ns;
        asked = newtons[0];
        longest = std::max(longest, glm::length(asked));
        return !broken;
    }
    double age_s() const override { return 0.0004; }
    Result<void> health() const override { return Error{ErrorKind::device, "bench device: broke"}; }

    TickPace pace() {
        return {[this] { return pass_tick(); }, [this] { return tick * 1'000'000 + spent_ns; }};
    }
    bool pass_tick() {
        forces_[static_cast<std::size_t>(tick) % forces_.size()] = asked;
        handle_.advance(forces_[static_cast<std::size_t>(tick + 1) % forces_.size()]);
        ++tick;
        if (asked != glm::dvec3(0)) farthest = std::max(farthest, glm::length(handle_.place()));
        broken = broken || (breaks_at > 0 && tick >= breaks_at);
        lost = lost || (loses_place_at > 0 && tick >= loses_place_at);
        return stops_at == 0 || tick < stops_at;
    }

    DeviceLimits limit{8, 20'000};
    int driven = 3;
    std::int64_t tick = 0, breaks_at = 0, loses_place_at = 0, stops_at = 0;
    std::int64_t takes_ns = 0, spent_ns = 0;  ///< a call with forces; all of them
    bool broken = false, lost = false;
    glm::dvec3 asked{0.0};
    double longest = 0, farthest = 0;  ///< newtons; metres from where it rested first, while pushed

private:
    HeldHandle handle_;
    std::vector<glm::dvec3> forces_;
};

}  // namespace touchable::test

namespace touchable {

/// A pinhole picture of whatever depth a test gives each pixel.
class FakeProbe final : public SurfaceProbe {
public:
    using Depth = std::function<std::optional<double>(double x, double y)>;

    FakeProbe(int width, int height, double focal_length, Depth depth)
        : width_(width), height_(height), focal_length_(focal_length), depth_(std::move(depth)) {}

    int width() const override { return width_; }
    int height() const override { return height_; }
    std::optional<double> depth_under(double x, double y) const override {
        if (!(x >= 0 && y >= 0 && x <= width_ - 1 && y <= height_ - 1)) return std::nullopt;
        return depth_(x, y);
    }
    glm::dvec3 unproject(double x, double y, double d) const override {
        return {d * (x - 0.5 * width_) / focal_length_, -d * (y - 0.5 * height_) / focal_length_, -d};
    }
    glm::dvec3 project(const glm::dvec3& p) const override {
        return {0.5 * width_ + focal_length_ * p.x / -p.z, 0.5 * height_ - focal_length_ * p.y / -p.z, -p.z};
    }

private:
    int width_, height_;
    double focal_length_;
    Depth depth_;
};

/// A picture of 640 x 480 pixels in millimetres, about what a depth camera gives.
inline FakeProbe camera_view(FakeProbe::Depth depth) {
    return {640, 480, 500, std::move(depth)};
}

inline FakeProbe flat_view(double depth = 800) {
    return camera_view([depth](double, double) { return depth; });
}

}  // namespace touchable
