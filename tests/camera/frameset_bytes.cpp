#include "tests/camera/frameset_bytes.hpp"

#include <bit>

namespace touchable::test {
namespace {

void put(std::string& to, std::uint64_t value, int size) {
    for (int k = 0; k < size; ++k) to += static_cast<char>(value >> (8 * k) & 0xff);
}

}  // namespace

std::uint32_t plain_crc32(const std::string& bytes) {
    std::uint32_t crc = 0xffffffff;
    for (const char byte : bytes) {
        crc ^= static_cast<unsigned char>(byte);
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xedb88320U : 0U);
    }
    return ~crc;
}

std::string FramesetBytes::payload() const {
    std::string made;
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) put(made, depth(x, y), 2);
    for (std::uint32_t k = 0; k < 3 * colour_width * colour_height; ++k) put(made, k % 251, 1);
    return made;
}

std::string FramesetBytes::bytes() const {
    const std::string shown = payload();
    std::string head = "FRAMESET";
    put(head, version, 4);
    put(head, 100, 4);
    put(head, number, 8);
    put(head, static_cast<std::uint64_t>(time_ns), 8);
    put(head, width, 4);
    put(head, height, 4);
    for (const double value : {unit, fx, fy, cx, cy}) put(head, std::bit_cast<std::uint64_t>(value), 8);
    put(head, colour_width, 4);
    put(head, colour_height, 4);
    put(head, flags, 4);
    put(head, plain_crc32(shown), 4);
    put(head, plain_crc32(head), 4);
    return head + shown;
}

}  // namespace touchable::test
