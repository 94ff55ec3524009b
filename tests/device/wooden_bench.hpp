// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "device/drivers/hid_transport.hpp"
#include "device/drivers/woodenhaptics_device.hpp"

namespace touchable {

using Bytes = std::vector<std::byte>;

inline Bytes bytes_of(std::initializer_list<int> values) {
    Bytes bytes;
    for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
    return bytes;
}

/// The reports that a test sees, and those that it lays down for a driver. A wait for a report that does not
/// come moves the clock instead, unless `waits`.
class FakeWire {
public:
    void lay(Bytes report) {
        const std::lock_guard lock(mutex_);
        coming_.push_back(std::move(report));
        came_.notify_all();
    }
    void unplug() {
        const std::lock_guard lock(mutex_);
        gone_ = true;
        came_.notify_all();
    }
    void plug_in() {
        const std::lock_guard lock(mutex_);
        gone_ = false;
        coming_.clear();
    }
    std::vector<Bytes> sent() const {
        const std::lock_guard lock(mutex_);
        return sent_;
    }
    Bytes last_sent() const {
        const std::lock_guard lock(mutex_);
        return sent_.empty() ? Bytes{} : sent_.back();
    }
    std::int64_t now_ns() const {
        const std::lock_guard lock(mutex_);
        return now_ns_;
    }
    void pass(std::int64_t ns) {
        const std::lock_guard lock(mutex_);
        now_ns_ += ns;
    }

    bool waits = false;
    bool remembers = true;                                ///< all that was sent, not only the last
    std::function<void(FakeWire&, const Bytes&)> answer;  ///< to each report that goes out

private:
    friend class FakeReports;
    mutable std::mutex mutex_;
    std::condition_variable came_;
    std::deque<Bytes> coming_;
    std::vector<Bytes> sent_;
    std::int64_t now_ns_ = 1;
    bool gone_ = false;
};

class FakeReports final : public ReportTransport {
public:
    explicit FakeReports(std::shared_ptr<FakeWire> wire, int spare = -1)
        : wire_(std::move(wire)), spare_(spare) {}

    Result<void> send(std::span<const std::byte> report) override {
        {
            const std::lock_guard lock(wire_->mutex_);
            if (wire_->gone_) return Error{ErrorKind::device, "fake: unplugged"};
            if (!wire_->remembers) wire_->sent_.clear();
            wire_->sent_.emplace_back(report.begin(), report.end());
        }
        if (wire_->answer) wire_->answer(*wire_, Bytes(report.begin(), report.end()));
        return {};
    }
    Result<std::size_t> receive(std::span<std::byte> room, std::chrono::microseconds patience) override {
        std::unique_lock lock(wire_->mutex_);
        const auto is_there = [&] { return wire_->gone_ || !wire_->coming_.empty(); };
        if (wire_->waits)
            wire_->came_.wait_for(lock, patience, is_there);
        else if (!is_there())
            wire_->now_ns_ += std::chrono::nanoseconds(patience).count();
        if (wire_->gone_) return Error{ErrorKind::device, "fake: unplugged"};
        if (wire_->coming_.empty()) return std::size_t{0};
        const Bytes report = std::move(wire_->coming_.front());
        wire_->coming_.pop_front();
        const std::size_t bytes = std::min(room.size(), report.size());
        std::copy_n(report.begin(), bytes, room.begin());
        return bytes;
    }
    int spare_descriptor() const override { return spare_; }

private:
    const std::shared_ptr<FakeWire> wire_;
    const int spare_;
};

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

/// The firmware's answers to reports, written from its description.
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
    /// A turn of the device's thread.
    Result<bool> turn(const glm::dvec3& newtons) {
        const std::array<glm::dvec3, 1> forces{newtons};
        if (auto sent = driver->send(forces); !sent) return sent.error();
        return driver->receive(sample, std::chrono::microseconds(5000));
    }
    bool has_place() const { return !std::isnan(sample.metres[0].x); }
};

}  // namespace touchable
