#include "device/hid_transport.hpp"

#include <fcntl.h>
#include <hidapi.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <mutex>
#include <utility>

namespace touchable {
namespace {

// hidapi keeps its word on a failed opening in one place for all threads.
std::mutex opening;

/// hidapi's words are for people, in plain letters.
std::string narrow(const wchar_t* words) {
    std::string text;
    for (; words && *words; ++words)
        text += *words >= L' ' && *words <= L'~' ? static_cast<char>(*words) : '?';
    return text;
}

Error not_opened(const std::string& node, int failure) {
    const bool is_forbidden = failure == EACCES || failure == EPERM, is_missing = failure == ENOENT;
    std::string words =
        node + (is_missing     ? ": is not there"
                : is_forbidden ? ": may not be opened by this user"
                               : std::string(": cannot be opened (") + std::strerror(failure) + ")");
    if (is_forbidden) words += "; the program's rules of udev permit it; then plug it in again";
    if (is_missing || failure == ENODEV || failure == ENXIO)
        words += "; right would be the node of a device that is plugged in, as 'ls /dev/hidraw*' shows";
    return {ErrorKind::device, std::move(words), is_forbidden ? Hints{{Setting::device_rules}} : Hints()};
}

}  // namespace

Result<std::unique_ptr<HidTransport>> HidTransport::open(const std::string& node) {
    const int spare = ::open(node.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    if (spare < 0) return not_opened(node, errno);
    // hidapi 0.13 frees what it does not own where a node turns out to be no HID device.
    if (int bytes = 0; ioctl(spare, HIDIOCGRDESCSIZE, &bytes) < 0) {
        ::close(spare);
        return Error{ErrorKind::device,
                     node + ": is no HID device; right would be a node such as /dev/hidraw0"};
    }
    const std::lock_guard lock(opening);
    if (hid_device* const device = hid_open_path(node.c_str()))
        return std::unique_ptr<HidTransport>(new HidTransport(node, device, spare));
    const std::string why = narrow(hid_error(nullptr));
    ::close(spare);
    return Error{ErrorKind::device, node + ": hidapi cannot use it (" + why + ")"};
}

HidTransport::~HidTransport() {
    hid_close(device_);
    ::close(spare_);
}

Error HidTransport::gone(const char* doing) const {
    return {ErrorKind::device,
            node_ + ": " + doing + " failed (" + narrow(hid_error(device_)) + "); is it still plugged in?"};
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

}  // namespace touchable
