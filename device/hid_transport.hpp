#pragma once

#include <memory>
#include <string>

#include "device/report_transport.hpp"

struct hid_device_;

namespace touchable {

/// A hidraw node of Linux, by hidapi. A read that failed, or a write that did not go out whole, means that
/// the device is gone.
class HidTransport final : public ReportTransport {
public:
    /// Of "/dev/hidrawN". Error (device): that it is not there, not permitted (and what permits it), not HID.
    static Result<std::unique_ptr<HidTransport>> open(const std::string& node);
    ~HidTransport() override;

    Result<void> send(std::span<const std::byte> report) override;
    Result<std::size_t> receive(std::span<std::byte> room, std::chrono::microseconds patience) override;
    int spare_descriptor() const override { return spare_; }

private:
    HidTransport(std::string node, hid_device_* device, int spare)
        : node_(std::move(node)), device_(device), spare_(spare) {}
    Error gone(const char* doing) const;

    const std::string node_;
    hid_device_* const device_;
    const int spare_;
};

}  // namespace touchable
