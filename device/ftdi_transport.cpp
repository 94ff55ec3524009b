#include "device/ftdi_transport.hpp"

#include <algorithm>

#include "engine/base/try.hpp"

namespace touchable {

FtdiCommand ftdi_latency(std::chrono::milliseconds waits) {
    return {9, static_cast<std::uint16_t>(waits.count())};
}
FtdiCommand ftdi_divisor(std::uint16_t encoded) {
    return {3, encoded};
}
FtdiCommand ftdi_eight_bits() {
    return {4, 8};
}
FtdiCommand ftdi_no_flow_control() {
    return {2, 0};
}
FtdiCommand ftdi_dtr(bool high) {
    return {1, static_cast<std::uint16_t>(high ? 0x101 : 0x100)};
}
FtdiCommand ftdi_rts(bool high) {
    return {1, static_cast<std::uint16_t>(high ? 0x202 : 0x200)};
}
FtdiCommand ftdi_purge_received() {
    return {0, 1};
}
FtdiCommand ftdi_purge_to_send() {
    return {0, 2};
}

Result<void> FtdiTransport::purge() {
    next_ = end_ = 0;
    for (const FtdiCommand& each : {ftdi_purge_received(), ftdi_purge_to_send()})
        if (auto done = port_->command(each); !done.ok()) return done;
    // Packets that were on their way are not the converter's any more.
    for (int most = 8; most > 0; --most) {
        TRY_ASSIGN(const auto came, port_->read(packet_, std::chrono::microseconds(0)));
        if (came == 0) break;
    }
    return {};
}

/// A converter that has nothing sends its state alone, again and again.
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

}  // namespace touchable
