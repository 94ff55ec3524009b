#include "device/network_packet.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <type_traits>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

// "TCHD", version, kind, fingers, flags, sequence, buttons, time; then vectors and the CRC of all before.
constexpr std::array<std::byte, 4> magic{std::byte{'T'}, std::byte{'C'}, std::byte{'H'}, std::byte{'D'}};
constexpr std::size_t head_bytes = 24;
constexpr std::size_t vector_bytes = 24;
constexpr std::size_t crc_bytes = 4;
constexpr std::uint8_t last_flag = 1, still_flag = 2;

std::size_t bytes_of(std::size_t fingers) {
    return head_bytes + fingers * vector_bytes + crc_bytes;
}

std::uint32_t crc_of(std::span<const std::byte> bytes) {
    return static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

class Writer {
public:
    explicit Writer(std::vector<std::byte>& out) : out_(out) {}
    template <class Word>
    void put(Word word) {
        static_assert(std::is_unsigned_v<Word>);
        for (std::size_t byte = 0; byte < sizeof word; ++byte)
            out_.push_back(static_cast<std::byte>(word >> (8 * byte) & 0xff));
    }
    void put(double number) { put(std::bit_cast<std::uint64_t>(number)); }

private:
    std::vector<std::byte>& out_;
};

class Reader {
public:
    explicit Reader(std::span<const std::byte> in) : in_(in) {}
    template <class Word>
    Word take() {
        Word word = 0;
        for (std::size_t byte = 0; byte < sizeof word; ++byte)
            word = static_cast<Word>(word | static_cast<Word>(in_[at_ + byte]) << (8 * byte));
        at_ += sizeof word;
        return word;
    }
    double number() { return std::bit_cast<double>(take<std::uint64_t>()); }

private:
    std::span<const std::byte> in_;
    std::size_t at_ = 0;
};

Result<void> check_frame(std::span<const std::byte> bytes) {
    if (bytes.size() < bytes_of(1) || !std::equal(magic.begin(), magic.end(), bytes.begin()))
        return input_error(
            "a packet of " + std::to_string(bytes.size()) +
            " bytes does not begin with TCHD and a whole head; right would be docs/network-hand.md's");
    if (const auto version = std::to_integer<int>(bytes[4]); version != NetworkPacket::version)
        return input_error("a packet is of version " + std::to_string(version) +
                           "; this program speaks version " + std::to_string(NetworkPacket::version));
    const auto fingers = std::to_integer<std::size_t>(bytes[6]);
    if (fingers < 1 || fingers > NetworkPacket::most_fingers || bytes.size() != bytes_of(fingers))
        return input_error("a packet of " + std::to_string(bytes.size()) + " bytes says it has " +
                           std::to_string(fingers) +
                           " fingers; right would be 1 to 10, and 28 + 24 bytes for each");
    Reader crc(bytes.last(crc_bytes));
    if (crc.take<std::uint32_t>() != crc_of(bytes.first(bytes.size() - crc_bytes)))
        return input_error(
            "a packet's CRC-32 does not fit its bytes; it was damaged on the way, or it is not the CRC of "
            "all bytes before it");
    return {};
}

}  // namespace

std::vector<std::byte> encode(const NetworkPacket& packet) {
    assert(packet.fingers >= 1 && packet.fingers <= static_cast<int>(NetworkPacket::most_fingers));
    std::vector<std::byte> bytes(magic.begin(), magic.end());
    bytes.reserve(NetworkPacket::most_bytes);
    Writer out(bytes);
    out.put(NetworkPacket::version);
    out.put(static_cast<std::uint8_t>(packet.kind));
    out.put(static_cast<std::uint8_t>(packet.fingers));
    out.put(
        static_cast<std::uint8_t>((packet.last ? last_flag : 0) | (packet.stands_still ? still_flag : 0)));
    out.put(packet.sequence);
    out.put(packet.buttons);
    out.put(packet.time_ns);
    for (int finger = 0; finger < packet.fingers; ++finger)
        for (int axis = 0; axis < 3; ++axis) out.put(packet.vectors[static_cast<std::size_t>(finger)][axis]);
    out.put(crc_of(bytes));
    return bytes;
}

Result<NetworkPacket> decode_network_packet(std::span<const std::byte> bytes) {
    TRY(check_frame(bytes));
    Reader in(bytes.subspan(magic.size() + 1));
    NetworkPacket packet;
    const auto kind = in.take<std::uint8_t>();
    if (kind != 1 && kind != 2)
        return input_error("a packet is of kind " + std::to_string(kind) +
                           "; right would be 1 (places) or 2 (forces)");
    packet.kind = static_cast<NetworkPacket::Kind>(kind);
    packet.fingers = in.take<std::uint8_t>();
    const auto flags = in.take<std::uint8_t>();
    packet.last = (flags & last_flag) != 0;
    packet.stands_still = (flags & still_flag) != 0;
    packet.sequence = in.take<std::uint32_t>();
    packet.buttons = in.take<std::uint32_t>();
    packet.time_ns = in.take<std::uint64_t>();
    for (int finger = 0; finger < packet.fingers; ++finger)
        for (int axis = 0; axis < 3; ++axis)
            packet.vectors[static_cast<std::size_t>(finger)][axis] = in.number();
    return packet;
}

}  // namespace touchable
