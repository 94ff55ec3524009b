#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "device/drivers/falcon_device.hpp"

namespace touchable::test {

inline std::vector<std::byte> bytes_of(const std::string& text) {
    std::vector<std::byte> bytes(text.size());
    std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
    return bytes;
}

/// A Falcon at the other end of a USB cable, as its owners have described it; it shares no code with the
/// driver. It is what stays when the cable is pulled and put in again. Any thread's.
class FakeFalcon {
public:
    // Its state.
    bool plugged = true, has_firmware = true, homed = true;
    std::array<int, 3> counts{};
    unsigned buttons = 0;
    std::string image;  // that makes it run

    // Its faults. Each is asked for the next answer that it is about to send.
    std::function<std::string(const std::string&)>
        spoil;  // an answer of running firmware -> what comes of it
    std::function<std::string(const std::string&)> spoil_echo;  // while firmware is loaded
    int deaf_greetings = 0;
    bool zero_before_welcome = false;
    std::size_t longest_packet = 62;
    bool holds_next = false;      // an answer, until the next question
    std::size_t empty_reads = 0;  // before an answer comes
    bool silent = false, babbles = false;

    // Its record of a session.
    std::vector<FtdiCommand> commands;
    std::string written;  // since it was made
    std::string loaded;
    std::vector<std::size_t> blocks;
    std::array<int, 3> motors{};  // that act now
    int state = 0;                // of the last command: homing and lamps
    int questions = 0;
    int opened = 0;

    std::mutex mutex;

    std::string last_bytes(std::size_t count) {
        const std::lock_guard lock(mutex);
        return written.substr(written.size() - std::min(count, written.size()));
    }
    void pull_power() {
        const std::lock_guard lock(mutex);
        has_firmware = homed = false;
        motors = {};
        loaded.clear();
        coming.clear();
    }

    bool command(const FtdiCommand& command) {
        const std::lock_guard lock(mutex);
        if (!plugged) return false;
        commands.push_back(command);
        if (command == FtdiCommand{3, 0x4138}) loaded.clear(), marked_ = greeted_ = false;
        if (command.request == 3) divisor_ = command.value;
        if (command.request == 1 && (command.value & 0x100) != 0) dtr_ = (command.value & 1) != 0;
        if (command == FtdiCommand{0, 1}) coming.clear();
        if (divisor_ == 2 && !image.empty() && loaded == image) has_firmware = true;
        return true;
    }
    bool write(std::span<const std::byte> bytes) {
        const std::lock_guard lock(mutex);
        if (!plugged) return false;
        std::string text;
        for (const std::byte byte : bytes) text += static_cast<char>(byte);
        written += text;
        if (divisor_ == 0x4138 && dtr_ && text == "\x0a\x43\x0d") greet();
        if (divisor_ == 0x15 && greeted_ && !dtr_) load(text);
        if (divisor_ == 2 && has_firmware) run(text);
        return true;
    }
    /// The next packet to the driver, with the two bytes before its text.
    std::optional<std::vector<std::byte>> next_packet() {
        const std::lock_guard lock(mutex);
        if (!plugged) return std::nullopt;
        std::string packet = "\x01\x60";
        if (babbles) {
            packet += std::string(62, 'x');
        } else if (!silent && !coming.empty()) {
            packet += coming.front();
            coming.pop_front();
        }
        return bytes_of(packet);
    }

    std::deque<std::string> coming;  // at most 62 bytes each

private:
    void send(const std::string& bytes) {
        for (std::size_t at = 0; at < bytes.size(); at += longest_packet)
            coming.push_back(bytes.substr(at, longest_packet));
    }
    void greet() {
        if (deaf_greetings-- > 0) return;
        greeted_ = true;
        send((zero_before_welcome ? std::string(1, '\0') : std::string()) + "\x0a\x44\x2c\x0d");
    }
    void load(const std::string& block) {
        const std::string echo = spoil_echo ? spoil_echo(block) : block;
        if (!marked_ && block == "A") {
            marked_ = true;
        } else {
            loaded += block;
            blocks.push_back(block.size());
        }
        send(echo);
    }
    void run(const std::string& text) {
        for (const char byte : text) {
            if (byte == '<') begun_.clear();
            begun_ += byte;
            if (begun_.size() != 16 || begun_[0] != '<' || byte != '>') continue;
            for (std::size_t arm = 0; arm < 3; ++arm) {
                int word = 0;
                for (std::size_t digit = 4; digit-- > 0;)
                    word = 16 * word + (begun_[1 + 4 * arm + digit] - 'A');
                motors[arm] = word >= 32768 ? word - 65536 : word;
            }
            state = begun_[13] - 'A';
            ++questions;
            const std::string next = spoil ? spoil(answer()) : answer();
            if (std::exchange(holds_next, false)) {
                held_ = next;
                continue;
            }
            send(std::exchange(held_, std::string()));
            coming.insert(coming.end(), empty_reads, std::string());
            send(next);
        }
    }
    std::string answer() const {
        std::string packet = "<";
        for (const int count : counts) {
            unsigned bits = static_cast<unsigned>(count) & 0xFFFFU;
            for (int digit = 0; digit < 4; ++digit, bits /= 16) packet += static_cast<char>('A' + bits % 16);
        }
        packet += static_cast<char>('A' + static_cast<int>(buttons) + (homed && (state & 1) != 0 ? 0x70 : 0));
        return packet + "A>";
    }

    unsigned divisor_ = 0;
    bool dtr_ = false, greeted_ = false, marked_ = false;
    std::string begun_, held_;
};

/// An open port to it.
class FakeFalconPort final : public UsbPort {
public:
    explicit FakeFalconPort(std::shared_ptr<FakeFalcon> falcon) : falcon_(std::move(falcon)) {}

    Result<void> command(const FtdiCommand& command) override {
        return falcon_->command(command) ? Result<void>() : gone();
    }
    Result<void> write(std::span<const std::byte> bytes) override {
        return falcon_->write(bytes) ? Result<void>() : gone();
    }
    Result<std::size_t> read(std::span<std::byte> room, std::chrono::microseconds) override {
        const auto packet = falcon_->next_packet();
        if (!packet) return gone();
        std::copy(packet->begin(), packet->end(), room.begin());
        return packet->size();
    }
    int usbfs() const override { return 77; }

private:
    static Error gone() { return {ErrorKind::device, "fake: was unplugged"}; }
    std::shared_ptr<FakeFalcon> falcon_;
};

}  // namespace touchable::test
