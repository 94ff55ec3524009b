// SPDX-License-Identifier: Apache-2.0
#pragma once

// HID devices: their nodes in Linux, and their reports through hidapi.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "device/drivers/device_driver.hpp"
#include "engine/base/files.hpp"

struct hid_device_;

namespace touchable {

class ConnectedSystem;

/// Carries HID reports. A sent report begins with its number, 0 if the device does not number reports; a
/// received report begins with its number only if the device does.
class ReportTransport : public Transport {
public:
    /// Another descriptor of the same device, through which the watchdog's process sends zero force in the
    /// form that `send` takes. -1: none.
    virtual int spare_descriptor() const { return -1; }
};

/// Opens a device, looked for anew each time: after replugging it may have another node.
using OpenReports = std::function<Result<std::unique_ptr<ReportTransport>>()>;

/// Reads a 16-bit integer of a report, low byte first.
std::int16_t report_word(std::span<const std::byte> report, std::size_t at);

/// A HID device as Linux's hidraw shows it.
struct HidNode {
    std::string node;       ///< "/dev/hidraw0"
    std::uint16_t bus = 0;  ///< 3: USB, 5: Bluetooth
    std::uint16_t vendor = 0, product = 0;
    std::string name;  ///< as the device reports it
};

/// Parses a 16-bit id in hexadecimal digits; nothing for any other text.
std::optional<std::uint16_t> hexadecimal_id(std::string_view text);
/// Parses a device's `uevent` ("HID_ID=0003:0000046D:0000C626" and others); nothing: it has no id.
std::optional<HidNode> read_hid_uevent(std::string_view text);

/// All HID nodes, by their numbers.
std::vector<HidNode> hid_nodes(const ConnectedSystem& system);

/// A hidraw node of Linux, through hidapi. A failed read or an incomplete write means that the device is
/// gone.
class HidTransport final : public ReportTransport {
public:
    /// Opens "/dev/hidrawN". Error (device): missing, not permitted (and what permits it), or not HID.
    static Result<std::unique_ptr<ReportTransport>> open(const std::string& node);
    ~HidTransport() override;

    Result<void> send(std::span<const std::byte> report) override;
    Result<std::size_t> receive(std::span<std::byte> room, std::chrono::microseconds patience) override;
    int spare_descriptor() const override { return spare_.get(); }

private:
    HidTransport(std::string node, hid_device_* device, Descriptor spare)
        : node_(std::move(node)), device_(device), spare_(std::move(spare)) {}
    Error gone(const char* doing) const;

    const std::string node_;
    hid_device_* const device_;
    const Descriptor spare_;
};

/// Opens `node` or, if empty, the first device whose ids `is_one` accepts. Error: HidTransport::open's, or
/// `none` if there is no such device.
Result<std::unique_ptr<ReportTransport>> open_hid(const std::string& node,
                                                  bool (*is_one)(std::uint16_t vendor, std::uint16_t product),
                                                  const Error& none);

}  // namespace touchable
