#include "device/drivers/network_device.hpp"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace touchable::test {
namespace {

std::vector<std::byte> bytes_of(std::string_view hex) {
    std::vector<std::byte> bytes;
    for (std::size_t at = 0; at + 1 < hex.size(); at += 2)
        bytes.push_back(static_cast<std::byte>(std::stoi(std::string(hex.substr(at, 2)), nullptr, 16)));
    return bytes;
}

// By Python: struct.pack("<4sBBBBIIQ3d", b"TCHD", 1, 1, 1, 0, 0x01020304, 5, 0x1122334455667788, 0.5, -0.25,
// 0.125) and zlib.crc32 of it, "<I"; the second one with two fingers, kind 2, flags 1.
const auto places = bytes_of(
    "544348440101010004030201050000008877665544332211000000000000e03f000000000000d0bf000000000000c03f"
    "9d2bdd51");
const auto forces = bytes_of(
    "544348440102020107000000000000000900000000000000000000000000f03f00000000000000400000000000000840"
    "00000000000010c000000000000000009a9999999999b93fe59c275e");

TEST(NetworkPacket, IsTheseBytes) {
    NetworkPacket packet;
    packet.sequence = 0x01020304;
    packet.buttons = 5;
    packet.time_ns = 0x1122334455667788;
    packet.vectors[0] = {0.5, -0.25, 0.125};
    EXPECT_EQ(encode(packet), places);
    packet = {.kind = NetworkPacket::Kind::forces,
              .sequence = 7,
              .buttons = 0,
              .time_ns = 9,
              .last = true,
              .fingers = 2,
              .vectors = {}};
    packet.vectors[0] = {1, 2, 3};
    packet.vectors[1] = {-4, 0, 0.1};
    EXPECT_EQ(encode(packet), forces);
}

TEST(NetworkPacket, IsReadFromTheseBytes) {
    const auto packet = decode_network_packet(places);
    ASSERT_TRUE(packet) << packet.error().message;
    EXPECT_EQ(packet->kind, NetworkPacket::Kind::places);
    EXPECT_EQ(packet->sequence, 0x01020304U);
    EXPECT_EQ(packet->buttons, 5U);
    EXPECT_EQ(packet->time_ns, 0x1122334455667788U);
    EXPECT_FALSE(packet->last);
    EXPECT_EQ(packet->fingers, 1);
    EXPECT_EQ(packet->vectors[0], glm::dvec3(0.5, -0.25, 0.125));
    const auto last = decode_network_packet(forces);
    ASSERT_TRUE(last);
    EXPECT_EQ(last->kind, NetworkPacket::Kind::forces);
    EXPECT_TRUE(last->last);
    EXPECT_EQ(last->vectors[1], glm::dvec3(-4, 0, 0.1));
}

TEST(NetworkPacket, EveryCutAndEveryChangedBitIsRefused) {
    for (const auto& whole : {places, forces}) {
        for (std::size_t length = 0; length < whole.size(); ++length)
            EXPECT_FALSE(decode_network_packet(std::span(whole).first(length))) << length;
        auto longer = whole;
        longer.push_back(std::byte{0});
        EXPECT_FALSE(decode_network_packet(longer));
        for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
            auto changed = whole;
            changed[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
            EXPECT_FALSE(decode_network_packet(changed)) << "bit " << bit;
        }
    }
}

TEST(NetworkPacket, AnotherVersionIsRefusedByName) {
    auto newer = places;
    newer[4] = std::byte{2};
    EXPECT_NE(decode_network_packet(newer).error().message.find("version 2"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
