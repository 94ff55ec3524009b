#pragma once

#include <array>
#include <memory>

#include "device/steady_time.hpp"
#include "device/transport.hpp"
#include "device/usb_port.hpp"

namespace touchable {

// Commands, as FTDI's chips of this generation take them.
FtdiCommand ftdi_latency(std::chrono::milliseconds waits);  ///< 1 to 255 ms, for a packet to become full
FtdiCommand ftdi_divisor(std::uint16_t encoded);            ///< of 3 MHz; bits 14 and 15: eighths
FtdiCommand ftdi_eight_bits();                              ///< of data, no parity, one stop bit
FtdiCommand ftdi_no_flow_control();
FtdiCommand ftdi_dtr(bool high);
FtdiCommand ftdi_rts(bool high);
FtdiCommand ftdi_purge_received();
FtdiCommand ftdi_purge_to_send();

/// Bytes through such a converter. Its packets begin with two bytes of line state, which are no data.
class FtdiTransport final : public Transport {
public:
    static constexpr std::size_t state_bytes = 2;

    explicit FtdiTransport(std::unique_ptr<UsbPort> port, DriverClock clock = steady_ns)
        : port_(std::move(port)), clock_(std::move(clock)) {}

    Result<void> command(const FtdiCommand& command) { return port_->command(command); }
    /// Whatever has come and was not received, here and in the converter, is dropped.
    Result<void> purge();
    Result<void> send(std::span<const std::byte> bytes) override { return port_->write(bytes); }
    Result<std::size_t> receive(std::span<std::byte> room, std::chrono::microseconds patience) override;
    int usbfs() const { return port_->usbfs(); }
    std::int64_t now_ns() const { return clock_(); }

private:
    std::unique_ptr<UsbPort> port_;
    DriverClock clock_;
    std::array<std::byte, UsbPort::packet_bytes> packet_{};
    std::size_t next_ = 0, end_ = 0;  // of what came and was not received
};

}  // namespace touchable
