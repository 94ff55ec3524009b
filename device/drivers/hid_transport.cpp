// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/hid_transport.hpp"

#include <fcntl.h>
#include <hidapi.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstring>

#include "device/drivers/known_devices.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// ---- Nodes

/// Parses BUS:VENDOR:PRODUCT, all hexadecimal.
bool take_ids(std::string_view text, HidNode& node) {
    const auto bus = hexadecimal_id(cut_part(text, ':')), vendor = hexadecimal_id(cut_part(text, ':')),
               product = hexadecimal_id(text);
    if (!bus || !vendor || !product) return false;
    node.bus = *bus;
    node.vendor = *vendor;
    node.product = *product;
    return true;
}

/// hidraw10 comes after hidraw9.
bool node_comes_before(const HidNode& a, const HidNode& b) {
    return a.node.size() != b.node.size() ? a.node.size() < b.node.size() : a.node < b.node;
}

// ---- The transport

// hidapi keeps the message of a failed opening in one place for all threads.
std::mutex hid_opening;

/// hidapi's message in printable ASCII; other characters become '?'.
std::string in_plain_letters(const wchar_t* words) {
    std::string text;
    for (; words && *words; ++words)
        text += *words >= L' ' && *words <= L'~' ? static_cast<char>(*words) : '?';
    return text;
}

Error hid_not_opened(const std::string& node, int failure) {
    if (failure == EACCES || failure == EPERM) return not_permitted(node);
    const bool is_missing = failure == ENOENT;
    std::string words =
        node + (is_missing ? ": does not exist"
                           : std::string(": cannot be opened (") + std::strerror(failure) + ")");
    if (is_missing || failure == ENODEV || failure == ENXIO)
        words += "; must be the node of a device that is plugged in, as 'ls /dev/hidraw*' shows";
    return device_error(std::move(words));
}

}  // namespace

// ---- Nodes

std::int16_t report_word(std::span<const std::byte> report, std::size_t at) {
    return static_cast<std::int16_t>(
        number_in_bytes({reinterpret_cast<const char*>(&report[at]), sizeof(std::int16_t)}, false));
}

std::optional<std::uint16_t> hexadecimal_id(std::string_view text) {
    return parsed_as<std::uint16_t>(text, 16);
}

std::optional<HidNode> read_hid_uevent(std::string_view text) {
    constexpr std::string_view id = "HID_ID=", name = "HID_NAME=";
    HidNode node;
    bool known = false;
    while (!text.empty()) {
        const std::string_view line = cut_line(text);
        if (line.starts_with(id)) known = take_ids(line.substr(id.size()), node);
        if (line.starts_with(name)) node.name = line.substr(name.size());
    }
    return known ? std::optional(node) : std::nullopt;
}

std::vector<HidNode> hid_nodes(const ConnectedSystem& system) {
    std::vector<HidNode> nodes;
    for (const std::string& name : system.names("/sys/class/hidraw")) {
        auto node = read_hid_uevent(system.text("/sys/class/hidraw/" + name + "/device/uevent"));
        if (!node) continue;
        node->node = "/dev/" + name;
        nodes.push_back(std::move(*node));
    }
    std::ranges::sort(nodes, node_comes_before);
    return nodes;
}

// ---- The transport

Result<std::unique_ptr<ReportTransport>> HidTransport::open(const std::string& node) {
    Descriptor spare(::open(node.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC));
    if (spare.get() < 0) return hid_not_opened(node, errno);
    // hidapi 0.13 frees memory that it does not own if a node is no HID device.
    if (int bytes = 0; ioctl(spare.get(), HIDIOCGRDESCSIZE, &bytes) < 0)
        return device_error(node + ": is no HID device; must be a node such as /dev/hidraw0");
    const std::lock_guard lock(hid_opening);
    if (hid_device* const device = hid_open_path(node.c_str()))
        return std::unique_ptr<ReportTransport>(new HidTransport(node, device, std::move(spare)));
    return device_error(node + ": hidapi cannot use it (" + in_plain_letters(hid_error(nullptr)) + ")");
}

HidTransport::~HidTransport() {
    hid_close(device_);
}

Error HidTransport::gone(const char* doing) const {
    return device_error(node_ + ": " + doing + " failed (" + in_plain_letters(hid_error(device_)) +
                        "); is it still plugged in?");
}

Result<void> HidTransport::send(std::span<const std::byte> report) {
    const int sent = hid_write(device_, reinterpret_cast<const unsigned char*>(report.data()), report.size());
    if (sent != static_cast<int>(report.size())) return gone("a write");
    return {};
}

Result<std::size_t> HidTransport::receive(std::span<std::byte> room, std::chrono::microseconds patience) {
    const auto wait_ms = static_cast<int>((patience.count() + 999) / 1000);
    const int came =
        hid_read_timeout(device_, reinterpret_cast<unsigned char*>(room.data()), room.size(), wait_ms);
    if (came < 0) return gone("a read");
    return static_cast<std::size_t>(came);
}

Result<std::unique_ptr<ReportTransport>> open_hid(const std::string& node,
                                                  bool (*is_one)(std::uint16_t vendor, std::uint16_t product),
                                                  const Error& none) {
    if (!node.empty()) return HidTransport::open(node);
    for (const HidNode& each : hid_nodes(ConnectedSystem()))
        if (is_one(each.vendor, each.product)) return HidTransport::open(each.node);
    return none;
}

}  // namespace touchable
