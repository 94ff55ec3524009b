#pragma once

#include <algorithm>
#include <chrono>
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

namespace touchable {

using Bytes = std::vector<std::byte>;

inline Bytes bytes_of(std::initializer_list<int> values) {
    Bytes bytes;
    for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
    return bytes;
}

/// What a test sees of reports, and lays down for a driver to find. Whoever waits for one that does not come
/// moves the clock instead, unless `waits`.
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

}  // namespace touchable
