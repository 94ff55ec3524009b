#include "device/falcon_protocol.hpp"

namespace touchable {
namespace {

constexpr auto first_byte = std::byte{'<'}, last_byte = std::byte{'>'};
constexpr std::size_t state_place = 13;  // lamps and homing out, buttons and homing in
constexpr unsigned homing_bit = 1, homed_bits = 0x70;

constexpr std::byte letter(unsigned bits) {
    return static_cast<std::byte>('A' + bits);
}
constexpr unsigned bits_of(std::byte letter) {
    return std::to_integer<unsigned>(letter) - 'A';
}

/// Lowest four bits first.
void put_word(FalconPacket& packet, std::size_t place, std::int16_t value) {
    const auto bits = static_cast<std::uint16_t>(value);
    for (unsigned digit = 0; digit < 4; ++digit) packet[place + digit] = letter(bits >> 4 * digit & 15U);
}
std::int16_t word_at(const FalconPacket& packet, std::size_t place) {
    unsigned bits = 0;
    for (unsigned digit = 0; digit < 4; ++digit) bits |= bits_of(packet[place + digit]) << 4 * digit;
    return static_cast<std::int16_t>(static_cast<std::uint16_t>(bits));
}

/// The state has seven bits in one letter. What the letter after it says is not known.
bool may_stand(std::byte byte, std::size_t place) {
    if (place == falcon_packet_bytes - 1) return byte == last_byte;
    if (byte < letter(0)) return false;
    if (place < state_place) return byte <= letter(15);
    return place > state_place || byte <= letter(0x7F);
}

}  // namespace

FalconPacket encode(const FalconCommand& command) {
    FalconPacket packet;
    packet.fill(letter(0));
    packet.front() = first_byte;
    for (std::size_t arm = 0; arm < 3; ++arm) put_word(packet, 1 + 4 * arm, command.motors[arm]);
    packet[state_place] = letter(homing_bit | static_cast<unsigned>(command.lamp));
    packet.back() = last_byte;
    return packet;
}

std::optional<FalconReport> FalconReader::take(std::byte byte) {
    if (byte == first_byte) {
        if (filled_ > 0) ++damaged_;
        packet_[0] = byte;
        filled_ = 1;
        return std::nullopt;
    }
    if (filled_ == 0) return std::nullopt;
    if (!may_stand(byte, filled_)) {
        ++damaged_;
        filled_ = 0;
        return std::nullopt;
    }
    packet_[filled_++] = byte;
    if (filled_ < falcon_packet_bytes) return std::nullopt;
    filled_ = 0;
    FalconReport report;
    for (std::size_t arm = 0; arm < 3; ++arm) report.counts[arm] = word_at(packet_, 1 + 4 * arm);
    const unsigned state = bits_of(packet_[state_place]);
    report.buttons = static_cast<std::uint8_t>(state & 15U);
    report.homed = (state & homed_bits) == homed_bits;
    return report;
}

}  // namespace touchable
