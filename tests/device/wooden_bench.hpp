#pragma once

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <memory>

#include "device/drivers/woodenhaptics_device.hpp"
#include "tests/device/fake_reports.hpp"

namespace touchable {

/// The build of 2015 and 2016, as it was published, with its motors on.
inline WoodenParameters published_build() {
    WoodenParameters build;
    build.name = "WoodenHaptics";
    build.drive = true;
    build.joints = {
        {{2000, 1.0 / 16, 0.0259, 1, 0}, {2000, 1.0 / 12, 0.0259, 2, 0}, {2000, 1.0 / 12, 0.0259, 2, 6000}}};
    build.links = {0.080, 0.205, 0.245};
    build.origin = {0.220, 0, 0.080};
    build.reach = 0.1;
    build.limits = {5, 1000};
    return build;
}

inline int word_at(const Bytes& bytes, std::size_t at) {
    const int value = std::to_integer<int>(bytes[at]) | std::to_integer<int>(bytes[at + 1]) << 8;
    return value >= 0x8000 ? value - 0x10000 : value;
}

/// What the firmware does with reports, written from its description.
struct Board {
    std::array<int, 6> counters{};
    std::array<int, 3> milliamperes{};
    bool pressed = false;
    bool silent = false;

    Bytes reading() const {
        Bytes bytes;
        const auto add = [&](int value) {
            bytes.push_back(static_cast<std::byte>(value & 0xff));
            bytes.push_back(static_cast<std::byte>(value >> 8 & 0xff));
        };
        for (const int counter : counters) add(counter);
        add(pressed ? 1 : 0);
        return bytes;
    }
    void hear(FakeWire& wire, const Bytes& report) {
        ASSERT_EQ(report.size(), 15u);
        ASSERT_EQ(report[0], std::byte{0});
        milliamperes = {};
        if (word_at(report, 7) == 1) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                counters[axis] = word_at(report, 9 + 2 * axis);
                counters[3 + axis] = word_at(report, 1 + 2 * axis);
            }
            pressed = false;
        } else {
            for (std::size_t axis = 0; axis < 3; ++axis) milliamperes[axis] = word_at(report, 1 + 2 * axis);
        }
        if (!silent) wire.lay(reading());
    }
};

inline const Bytes unpowered(15, std::byte{0});

struct Bench {
    std::shared_ptr<FakeWire> wire = std::make_shared<FakeWire>();
    std::shared_ptr<Board> board = std::make_shared<Board>();
    std::unique_ptr<WoodenHapticsDriver> driver;
    DeviceSample sample;

    explicit Bench(const WoodenParameters& build = published_build(), bool is_homed = false) {
        wire->answer = [board = board](FakeWire& on, const Bytes& report) { board->hear(on, report); };
        driver = std::make_unique<WoodenHapticsDriver>(
            build, is_homed,
            [wire = wire]() -> Result<std::unique_ptr<ReportTransport>> {
                return std::unique_ptr<ReportTransport>(std::make_unique<FakeReports>(wire, 77));
            },
            [wire = wire] { return wire->now_ns(); });
    }
    Result<void> connect() { return driver->connect(); }
    /// As the device's thread does.
    Result<bool> turn(const glm::dvec3& newtons) {
        const std::array<glm::dvec3, 1> forces{newtons};
        if (auto sent = driver->send(forces); !sent) return sent.error();
        return driver->receive(sample, std::chrono::microseconds(5000));
    }
    bool has_place() const { return !std::isnan(sample.metres[0].x); }
};

}  // namespace touchable
