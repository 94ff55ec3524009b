// SPDX-License-Identifier: Apache-2.0
#pragma once

// 3Dconnexion's pucks, from their reports up to `--device spacemouse`.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string_view>

#include "device/drivers/device_driver.hpp"
#include "device/drivers/hid_transport.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// Whether the ids are those of a 3Dconnexion puck or of its receiver: 046d:c603 to c63f (sold under
/// Logitech's id), and 256f except its ordinary mice (CadMouse).
bool is_spacemouse(std::uint16_t vendor, std::uint16_t product);

/// Content of one report of a SpaceMouse; rotation moves no finger and is left out.
struct SpaceMouseReport {
    std::optional<glm::ivec3> translation{};  ///< counts: x right, y towards the person, z down
    std::optional<std::uint32_t> buttons{};   ///< one bit per pressed button
};

/// Decodes a report that begins with its number; integers of 16 bits, low byte first. 1 is the translation,
/// followed by the rotation on some models; 2 the rotation; 3 the buttons. Others (a battery's charge) have
/// no content. Refuses a report that is too short for its number.
Result<SpaceMouseReport> decode_spacemouse_report(std::span<const std::byte> bytes);

/// How a puck that is pushed moves a finger.
struct SpaceMousePace {
    double speed = 0.1;   ///< m/s at full deflection
    double reach = 0.08;  ///< m to each side of the centre, where the finger stops
};

/// Position of a finger that moves while a puck is deflected. Device metres, axes as in HapticDevice. Times
/// are nanoseconds, and do not go back.
class SpaceMouseMotion {
public:
    static constexpr double full_deflection = 350;  ///< counts
    static constexpr double dead_zone = 0.05;       ///< share of it, in any direction: hands rest unevenly
    static constexpr std::int64_t released_ns = 200'000'000;  ///< without a report, the puck is at rest

    SpaceMouseMotion(const SpaceMousePace& pace, std::int64_t now_ns) : pace_(pace), now_ns_(now_ns) {}

    /// Sets the deflection from now on, in a report's counts (x right, y towards the person, z down).
    void deflect(const glm::ivec3& counts, std::int64_t now_ns) {
        place(now_ns);
        const glm::dvec3 pushed = glm::dvec3(counts.x, -counts.z, counts.y) / full_deflection;
        const double length = glm::length(pushed);
        const double share = std::min((length - dead_zone) / (1 - dead_zone), 1.0);
        velocity_ = share > 0 ? pushed * (pace_.speed * share / length) : glm::dvec3(0);
        told_ns_ = now_ns;
    }
    /// Moves the finger up to `now_ns` and returns its position.
    glm::dvec3 place(std::int64_t now_ns) {
        const std::int64_t until = std::min(now_ns, told_ns_ + released_ns);
        if (until > now_ns_)
            place_ = glm::clamp(place_ + velocity_ * (static_cast<double>(until - now_ns_) * 1e-9),
                                glm::dvec3(-pace_.reach), glm::dvec3(pace_.reach));
        now_ns_ = std::max(now_ns_, now_ns);
        return place_;
    }

private:
    SpaceMousePace pace_;
    glm::dvec3 place_{0.0};
    glm::dvec3 velocity_{0.0};
    std::int64_t now_ns_;       // time of `place_`
    std::int64_t told_ns_ = 0;  // time of `velocity_`
};

/// A 3Dconnexion SpaceMouse as a finger. It exerts no force. It sends reports only while it is pushed;
/// without reports the finger stays where it is, for as long as the node can be read.
class SpaceMouseDriver final : public DeviceDriver {
public:
    SpaceMouseDriver(const SpaceMousePace& pace, OpenReports open, DriverClock clock = boot_ns)
        : pace_(pace), open_(std::move(open)), clock_(std::move(clock)) {}

    std::string name() const override { return "SpaceMouse (exerts no force)"; }
    /// These forces are not felt; they are only drawn.
    DeviceLimits limits() const override { return {1, 500}; }
    DeviceCapabilities capabilities() const override {
        return {.axes_driven = 0, .reach = glm::dvec3(pace_.reach), .rate_hz = 1000, .buttons = 32};
    }
    Result<void> connect() override;
    void disconnect() noexcept override { transport_.reset(); }
    Result<void> send(std::span<const glm::dvec3>) override { return {}; }
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) override;

    std::int64_t left_out() const override { return left_out_; }  ///< reports that were too short, so far

private:
    void take(std::span<const std::byte> report);

    const SpaceMousePace pace_;
    const OpenReports open_;
    const DriverClock clock_;
    std::unique_ptr<ReportTransport> transport_;
    std::optional<SpaceMouseMotion> motion_;
    std::uint32_t buttons_ = 0;
    std::int64_t left_out_ = 0;
};

struct SpaceMouseSettings {
    std::string node;  ///< empty: the first that is connected
    SpaceMousePace pace{};
};

/// Settings of "spacemouse[:key=value,...]" (docs/devices.md). Refuses (ErrorKind::usage) invalid keys.
Result<SpaceMouseSettings> read_spacemouse_settings(std::string_view keys);
Result<std::unique_ptr<DeviceDriver>> make_spacemouse_driver(std::string_view keys);

}  // namespace touchable
