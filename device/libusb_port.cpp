#include "device/libusb_port.hpp"

#include <fcntl.h>
#include <libusb.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;
using std::chrono::microseconds;

constexpr unsigned char endpoint_out = 0x02, endpoint_in = 0x81;
constexpr int its_interface = 0;
constexpr unsigned longest_transfer_ms = 50;  // HapticDevice::silence_s: a hand must not wait longer

Error usb_error(const std::string& name, const std::string& doing, int code) {
    if (code == LIBUSB_ERROR_NO_DEVICE) return {ErrorKind::device, name + ": was unplugged"};
    return {ErrorKind::device, name + ": " + doing + " failed: " + libusb_strerror(code)};
}

/// A device's word for a number or an identity: the first word of a small file.
std::string word_in(const fs::path& file) {
    std::ifstream in(file);
    std::string word;
    in >> word;
    return word;
}

class LibusbPort final : public UsbPort {
public:
    LibusbPort(std::string name, int node) : name_(std::move(name)), node_(node) {}
    ~LibusbPort() override;
    Result<void> hold();

    Result<void> command(const FtdiCommand& command) override;
    Result<void> write(std::span<const std::byte> bytes) override;
    Result<std::size_t> read(std::span<std::byte> room, microseconds patience) override;
    int usbfs() const override { return node_; }

private:
    /// Two take turns, so that the next packet finds one waiting.
    struct Reading {
        libusb_transfer* transfer = nullptr;
        std::array<unsigned char, packet_bytes> bytes{};
        bool under_way = false;
    };
    static void LIBUSB_CALL came(libusb_transfer* transfer);
    Result<void> ask_again(Reading& reading);
    void cancel_readings();

    const std::string name_;
    int node_;
    libusb_context* context_ = nullptr;
    libusb_device_handle* handle_ = nullptr;
    bool claimed_ = false;
    std::array<std::unique_ptr<Reading>, 2> readings_{std::make_unique<Reading>(),
                                                      std::make_unique<Reading>()};
    std::size_t next_ = 0;  // of readings_, in the order in which they come
};

LibusbPort::~LibusbPort() {
    cancel_readings();
    if (claimed_) libusb_release_interface(handle_, its_interface);
    if (handle_) libusb_close(handle_);
    if (context_) libusb_exit(context_);
    ::close(node_);
}

Result<void> LibusbPort::hold() {
    // Whoever may open the node needs nothing else; looking through all devices may be forbidden.
    libusb_set_option(nullptr, LIBUSB_OPTION_NO_DEVICE_DISCOVERY);
    if (const int code = libusb_init(&context_); code != 0) return usb_error(name_, "starting libusb", code);
    if (const int code = libusb_wrap_sys_device(context_, node_, &handle_); code != 0)
        return usb_error(name_, "taking hold of it", code);
    libusb_set_auto_detach_kernel_driver(handle_, 1);
    const int code = libusb_claim_interface(handle_, its_interface);
    if (code == LIBUSB_ERROR_BUSY)
        return Error{ErrorKind::device, name_ + ": another program holds it; end that one"};
    if (code != 0) return usb_error(name_, "claiming it", code);
    claimed_ = true;
    for (const auto& each : readings_) {
        Reading& reading = *each;
        reading.transfer = libusb_alloc_transfer(0);
        if (!reading.transfer) return usb_error(name_, "reading", LIBUSB_ERROR_NO_MEM);
        libusb_fill_bulk_transfer(reading.transfer, handle_, endpoint_in, reading.bytes.data(),
                                  static_cast<int>(reading.bytes.size()), came, &reading, 0);
        if (auto asked = ask_again(reading); !asked.ok()) return asked;
    }
    return {};
}

void LIBUSB_CALL LibusbPort::came(libusb_transfer* transfer) {
    static_cast<Reading*>(transfer->user_data)->under_way = false;
}

Result<void> LibusbPort::ask_again(Reading& reading) {
    if (const int code = libusb_submit_transfer(reading.transfer); code != 0)
        return usb_error(name_, "reading", code);
    reading.under_way = true;
    return {};
}

/// libusb writes into them until it says that it does not.
void LibusbPort::cancel_readings() {
    for (const auto& reading : readings_)
        if (reading->under_way) libusb_cancel_transfer(reading->transfer);
    for (auto& reading : readings_) {
        for (int tries = 0; reading->under_way && tries < 20; ++tries) {
            timeval patience{0, 50'000};
            libusb_handle_events_timeout_completed(context_, &patience, nullptr);
        }
        if (reading->under_way) [[maybe_unused]]
            const auto left_to_libusb = reading.release();
        else
            libusb_free_transfer(reading->transfer);
    }
}

Result<void> LibusbPort::command(const FtdiCommand& command) {
    constexpr std::uint8_t to_device_of_vendor = 0x40;
    const int code = libusb_control_transfer(handle_, to_device_of_vendor, command.request, command.value, 0,
                                             nullptr, 0, longest_transfer_ms);
    if (code < 0) return usb_error(name_, "setting its line", code);
    return {};
}

Result<void> LibusbPort::write(std::span<const std::byte> bytes) {
    std::array<unsigned char, packet_bytes> room{};
    if (bytes.size() > room.size()) return usb_error(name_, "writing", LIBUSB_ERROR_INVALID_PARAM);
    std::memcpy(room.data(), bytes.data(), bytes.size());
    int written = 0;
    const int code = libusb_bulk_transfer(handle_, endpoint_out, room.data(), static_cast<int>(bytes.size()),
                                          &written, longest_transfer_ms);
    if (code != 0) return usb_error(name_, "writing", code);
    if (written != static_cast<int>(bytes.size())) return usb_error(name_, "writing", LIBUSB_ERROR_IO);
    return {};
}

Result<std::size_t> LibusbPort::read(std::span<std::byte> room, microseconds patience) {
    using Clock = std::chrono::steady_clock;
    Reading& reading = *readings_[next_];
    const auto until = Clock::now() + patience;
    for (bool last = false; reading.under_way && !last;) {
        const auto left = std::chrono::duration_cast<microseconds>(until - Clock::now());
        last = left.count() <= 0;
        timeval wait{last ? 0 : left.count() / 1'000'000, last ? 0 : left.count() % 1'000'000};
        const int code = libusb_handle_events_timeout_completed(context_, &wait, nullptr);
        if (code != 0 && code != LIBUSB_ERROR_INTERRUPTED) return usb_error(name_, "reading", code);
    }
    if (reading.under_way) return std::size_t{0};
    if (reading.transfer->status != LIBUSB_TRANSFER_COMPLETED)
        return usb_error(
            name_, "reading",
            reading.transfer->status == LIBUSB_TRANSFER_NO_DEVICE ? LIBUSB_ERROR_NO_DEVICE : LIBUSB_ERROR_IO);
    const auto bytes = static_cast<std::size_t>(reading.transfer->actual_length);
    const std::size_t given = std::min(room.size(), bytes);
    std::memcpy(room.data(), reading.bytes.data(), given);
    TRY(ask_again(reading));
    next_ = (next_ + 1) % readings_.size();
    return given;
}

}  // namespace

fs::path find_usb_device(const std::string& vendor, const std::string& product, const UsbFolders& folders) {
    std::vector<fs::path> nodes;
    std::error_code fault;
    for (fs::directory_iterator entry(folders.devices, fault), end; !fault && entry != end;
         entry.increment(fault)) {
        const fs::path& device = entry->path();
        if (word_in(device / "idVendor") != vendor || word_in(device / "idProduct") != product) continue;
        const auto three_digits = [](const std::string& word) {
            return std::string(3 - std::min<std::size_t>(3, word.size()), '0') + word;
        };
        nodes.push_back(folders.nodes / three_digits(word_in(device / "busnum")) /
                        three_digits(word_in(device / "devnum")));
    }
    return nodes.empty() ? fs::path() : *std::min_element(nodes.begin(), nodes.end());
}

Result<std::unique_ptr<UsbPort>> open_usb_port(const fs::path& node, const std::string& name) {
    const std::string named = name + " at " + node.string();
    const int descriptor = ::open(node.c_str(), O_RDWR | O_CLOEXEC);
    if (descriptor < 0 && (errno == EACCES || errno == EPERM))
        return Error{ErrorKind::device,
                     named + ": no permission; the program's rules of udev give it; then plug it in again",
                     {{Setting::device_rules}}};
    if (descriptor < 0) return Error{ErrorKind::device, named + ": " + std::strerror(errno)};
    auto port = std::make_unique<LibusbPort>(named, descriptor);
    TRY(port->hold());
    return std::unique_ptr<UsbPort>(std::move(port));
}

Result<std::unique_ptr<UsbPort>> open_falcon(const UsbFolders& folders) {
    const fs::path node = find_usb_device("0403", "cb48", folders);
    if (node.empty())
        return Error{ErrorKind::device,
                     "no Novint Falcon is plugged in (USB 0403:cb48); plug in its power, then its USB cable"};
    return open_usb_port(node, "Novint Falcon");
}

}  // namespace touchable
