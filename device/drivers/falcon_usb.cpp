// SPDX-License-Identifier: Apache-2.0
// The Falcon below its packets: its USB port, the serial converter in it, and how its firmware is loaded.
#include <fcntl.h>
#include <libusb.h>
#include <sys/time.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

#include "device/drivers/falcon_device.hpp"
#include "device/drivers/known_devices.hpp"
#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// ---- The USB port

using std::chrono::microseconds;

constexpr unsigned char endpoint_in = 0x81;
constexpr int its_interface = 0;
constexpr unsigned longest_transfer_ms = 50;  // not longer than HapticDevice::silence_s

Error usb_error(const std::string& name, const std::string& doing, int code) {
    if (code == LIBUSB_ERROR_NO_DEVICE) return device_error(name + ": was unplugged");
    return device_error(name + ": " + doing + " failed: " + libusb_strerror(code));
}

class LibusbPort final : public UsbPort {
public:
    LibusbPort(std::string name, Descriptor node) : name_(std::move(name)), node_(std::move(node)) {}
    ~LibusbPort() override {
        cancel_readings();
        if (claimed_) libusb_release_interface(handle_, its_interface);
        if (handle_) libusb_close(handle_);
        if (context_) libusb_exit(context_);
    }

    Result<void> hold() {
        // A user who may open the node needs nothing else; a scan of all devices may be forbidden.
        libusb_set_option(nullptr, LIBUSB_OPTION_NO_DEVICE_DISCOVERY);
        if (const int code = libusb_init(&context_); code != 0)
            return usb_error(name_, "starting libusb", code);
        if (const int code = libusb_wrap_sys_device(context_, node_.get(), &handle_); code != 0)
            return usb_error(name_, "taking hold of it", code);
        libusb_set_auto_detach_kernel_driver(handle_, 1);
        const int code = libusb_claim_interface(handle_, its_interface);
        if (code == LIBUSB_ERROR_BUSY)
            return device_error(name_ + ": another program holds it; end that one");
        if (code != 0) return usb_error(name_, "claiming it", code);
        claimed_ = true;
        for (const auto& each : readings_) {
            Reading& reading = *each;
            reading.transfer = libusb_alloc_transfer(0);
            if (!reading.transfer) return usb_error(name_, "reading", LIBUSB_ERROR_NO_MEM);
            libusb_fill_bulk_transfer(reading.transfer, handle_, endpoint_in, reading.bytes.data(),
                                      static_cast<int>(reading.bytes.size()), came, &reading, 0);
            TRY(ask_again(reading));
        }
        return {};
    }

    Result<void> command(const FtdiCommand& command) override {
        constexpr std::uint8_t to_device_of_vendor = 0x40;
        const int code = libusb_control_transfer(handle_, to_device_of_vendor, command.request, command.value,
                                                 0, nullptr, 0, longest_transfer_ms);
        if (code < 0) return usb_error(name_, "setting its line", code);
        return {};
    }

    Result<void> write(std::span<const std::byte> bytes) override {
        std::array<unsigned char, packet_bytes> room{};
        if (bytes.size() > room.size()) return usb_error(name_, "writing", LIBUSB_ERROR_INVALID_PARAM);
        std::memcpy(room.data(), bytes.data(), bytes.size());
        int written = 0;
        const int code = libusb_bulk_transfer(handle_, FalconDriver::usb_endpoint_out, room.data(),
                                              static_cast<int>(bytes.size()), &written, longest_transfer_ms);
        if (code != 0) return usb_error(name_, "writing", code);
        if (written != static_cast<int>(bytes.size())) return usb_error(name_, "writing", LIBUSB_ERROR_IO);
        return {};
    }

    Result<std::size_t> read(std::span<std::byte> room, microseconds patience) override {
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
            return usb_error(name_, "reading",
                             reading.transfer->status == LIBUSB_TRANSFER_NO_DEVICE ? LIBUSB_ERROR_NO_DEVICE
                                                                                   : LIBUSB_ERROR_IO);
        const auto bytes = static_cast<std::size_t>(reading.transfer->actual_length);
        const std::size_t given = std::min(room.size(), bytes);
        std::memcpy(room.data(), reading.bytes.data(), given);
        TRY(ask_again(reading));
        next_ = (next_ + 1) % readings_.size();
        return given;
    }

    int usbfs() const override { return node_.get(); }

private:
    /// Two readings alternate, so that one is always waiting for the next packet.
    struct Reading {
        libusb_transfer* transfer = nullptr;
        std::array<unsigned char, packet_bytes> bytes{};
        bool under_way = false;
    };
    static void LIBUSB_CALL came(libusb_transfer* transfer) {
        static_cast<Reading*>(transfer->user_data)->under_way = false;
    }

    Result<void> ask_again(Reading& reading) {
        if (const int code = libusb_submit_transfer(reading.transfer); code != 0)
            return usb_error(name_, "reading", code);
        reading.under_way = true;
        return {};
    }

    /// libusb writes into the buffers until a reading is reported as cancelled.
    void cancel_readings() {
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

    const std::string name_;
    const Descriptor node_;
    libusb_context* context_ = nullptr;
    libusb_device_handle* handle_ = nullptr;
    bool claimed_ = false;
    std::array<std::unique_ptr<Reading>, 2> readings_{std::make_unique<Reading>(),
                                                      std::make_unique<Reading>()};
    std::size_t next_ = 0;  // index of the reading that completes next
};

/// Opens a USB device with one interface by its node: endpoint 0x02 out, 0x81 in. A kernel driver is detached
/// while the port is open. `name` is the device's, for messages.
Result<std::unique_ptr<UsbPort>> open_usb_port(const std::filesystem::path& node, const std::string& name) {
    const std::string named = name + " at " + node.string();
    Descriptor opened(::open(node.c_str(), O_RDWR | O_CLOEXEC));
    if (opened.get() < 0 && (errno == EACCES || errno == EPERM)) return not_permitted(named);
    if (opened.get() < 0) return device_error(named + ": " + std::strerror(errno));
    auto port = std::make_unique<LibusbPort>(named, std::move(opened));
    TRY(port->hold());
    return port;
}

// ---- Firmware

using std::chrono::milliseconds;

// 3 MHz over 312.5, 21 and 2.
constexpr std::uint16_t divisor_9600 = 0x4138, divisor_140000 = 0x15, divisor_1500000 = 2;
constexpr std::size_t block_bytes = 62;  // with the converter's two, a full packet on the way back
constexpr std::size_t least_firmware = 1024, most_firmware = 65536;

constexpr std::array<std::byte, 3> greeting{std::byte{0x0a}, std::byte{0x43}, std::byte{0x0d}};
constexpr std::array<std::byte, 4> welcome{std::byte{0x0a}, std::byte{0x44}, std::byte{0x2c},
                                           std::byte{0x0d}};
constexpr std::array<std::byte, 1> begin_mark{std::byte{'A'}};

Error load_error(const std::string& what) {
    return device_error("Novint Falcon: loading its firmware: " + what);
}

Result<void> command_all(FtdiTransport& transport, std::initializer_list<FtdiCommand> commands) {
    for (const FtdiCommand& each : commands) TRY(transport.command(each));
    return {};
}

/// Receives up to room.size() bytes within `patience`; returns how many came.
Result<std::size_t> gather(FtdiTransport& transport, std::span<std::byte> room, milliseconds patience) {
    const std::int64_t until = transport.now_ns() + std::chrono::nanoseconds(patience).count();
    std::size_t filled = 0;
    while (filled < room.size()) {
        if (stop_requested()) return interrupted_error();
        const microseconds left((until - transport.now_ns()) / 1000);
        if (left.count() <= 0) break;
        TRY_ASSIGN(const auto came,
                   transport.receive(room.subspan(filled), std::min<microseconds>(left, milliseconds(30))));
        filled += came;
    }
    return filled;
}

/// The device may send a zero before its answer, and may miss the first greetings.
Result<void> greet(FtdiTransport& transport, milliseconds patience) {
    constexpr int most_greetings = 30;
    for (int greetings = 0; greetings < most_greetings; ++greetings) {
        TRY(transport.send(greeting));
        std::array<std::byte, 16> room;
        std::size_t filled = 0;
        for (bool more = true; more && filled < room.size();) {
            TRY_ASSIGN(const auto came, gather(transport, std::span(room).subspan(filled, 1), patience));
            more = came > 0;
            filled += came;
            const auto received = std::span(room).first(filled);
            if (std::search(received.begin(), received.end(), welcome.begin(), welcome.end()) !=
                received.end())
                return {};
        }
    }
    return load_error("it does not answer; pull its power plug, wait ten seconds and put it in again");
}

Result<void> send_and_compare(FtdiTransport& transport, std::span<const std::byte> bytes,
                              const std::string& what, milliseconds patience) {
    TRY(transport.send(bytes));
    std::array<std::byte, block_bytes> room;
    const auto echo = std::span(room).first(bytes.size());
    TRY_ASSIGN(const auto came, gather(transport, echo, patience));
    if (came < bytes.size())
        return load_error(what + ": " + std::to_string(came) + " of " + std::to_string(bytes.size()) +
                          " bytes came back");
    if (!std::ranges::equal(bytes, echo)) return load_error(what + " came back changed");
    return {};
}

}  // namespace

// ---- The USB port

Result<std::unique_ptr<UsbPort>> open_falcon(const ConnectedSystem& system) {
    std::string first;
    for (const std::string& name : system.names("/sys/bus/usb/devices")) {
        const std::string at = "/sys/bus/usb/devices/" + name;
        if (system.text(at + "/idVendor") != "0403" || system.text(at + "/idProduct") != "cb48") continue;
        const std::string node = usbfs_node(system, at);
        if (first.empty() || (!node.empty() && node < first)) first = node;
    }
    if (first.empty())
        return device_error(
            "no Novint Falcon is plugged in (USB 0403:cb48); plug in its power, then its USB cable");
    return open_usb_port(system.below(first), "Novint Falcon");
}

Result<void> FtdiTransport::purge() {
    next_ = end_ = 0;
    for (const FtdiCommand& each : {FtdiCommand::purge_received(), FtdiCommand::purge_to_send()})
        TRY(port_->command(each));
    // Packets under way have left the converter, so purging does not drop them.
    for (int most = 8; most > 0; --most) {
        TRY_ASSIGN(const auto came, port_->read(packet_, std::chrono::microseconds(0)));
        if (came == 0) break;
    }
    return {};
}

/// A converter without data keeps sending its state alone.
Result<std::size_t> FtdiTransport::receive(std::span<std::byte> room, std::chrono::microseconds patience) {
    const std::int64_t until = now_ns() + std::chrono::nanoseconds(patience).count();
    while (next_ == end_) {
        const std::chrono::microseconds left((until - now_ns()) / 1000);
        TRY_ASSIGN(const auto came, port_->read(packet_, std::max(left, std::chrono::microseconds(0))));
        next_ = std::min(state_bytes, came);
        end_ = came;
        if (next_ == end_ && left.count() <= 0) return std::size_t{0};
    }
    const std::size_t given = std::min(room.size(), end_ - next_);
    std::copy_n(packet_.begin() + static_cast<std::ptrdiff_t>(next_), given, room.begin());
    next_ += given;
    return given;
}

// ---- Firmware

Result<std::vector<std::byte>> read_falcon_firmware(const std::string& path) {
    const std::string named = "the Falcon's firmware " + printable(path);
    constexpr const char* right = "the image, which docs/devices.md says where an owner finds";
    TRY_ASSIGN(auto file, GivenFile::open(path, named, right));
    if (file.size() < least_firmware || file.size() > most_firmware)
        return input_error(named + ": has " + std::to_string(file.size()) +
                           " bytes; must be the image, of 7 to 9 thousand");
    std::vector<std::byte> bytes(static_cast<std::size_t>(file.size()));
    TRY(error_at(named, file.read(0, reinterpret_cast<char*>(bytes.data()), bytes.size())));
    return bytes;
}

Result<void> load_falcon_firmware(FtdiTransport& transport, std::span<const std::byte> firmware,
                                  const FalconPatience& patience) {
    TRY(transport.purge());
    // Packets must not be cut by a short latency here, or greetings fail.
    TRY(command_all(transport, {FtdiCommand::latency(milliseconds(16)), FtdiCommand::divisor(divisor_9600),
                                FtdiCommand::eight_bits(), FtdiCommand::no_flow_control(),
                                FtdiCommand::rts(false), FtdiCommand::dtr(false), FtdiCommand::dtr(true)}));
    TRY(greet(transport, patience.greeting));
    TRY(command_all(transport, {FtdiCommand::dtr(false), FtdiCommand::divisor(divisor_140000)}));
    // After a late answer, the answer to a second greeting is still under way.
    TRY(transport.purge());
    TRY(send_and_compare(transport, begin_mark, "the mark that begins it", patience.echo));
    const std::size_t blocks = (firmware.size() + block_bytes - 1) / block_bytes;
    for (std::size_t block = 0; block < blocks; ++block) {
        const auto rest = firmware.subspan(block * block_bytes);
        const std::string what = "block " + std::to_string(block + 1) + " of " + std::to_string(blocks);
        TRY(send_and_compare(transport, rest.first(std::min(rest.size(), block_bytes)), what, patience.echo));
    }
    return {};
}

Result<void> begin_falcon_run(FtdiTransport& transport) {
    TRY(command_all(transport,
                    {FtdiCommand::latency(milliseconds(1)), FtdiCommand::divisor(divisor_1500000)}));
    return transport.purge();
}

}  // namespace touchable
