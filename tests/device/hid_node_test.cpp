#include "device/drivers/hid_transport.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include "tests/device/temporary_file.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

void lay_node(const fs::path& root, const std::string& node, const std::string& uevent) {
    const fs::path device = root / "sys/class/hidraw" / node / "device";
    fs::create_directories(device);
    std::ofstream(device / "uevent") << uevent;
}

TEST(HidNode, IdsAndNameAreReadFromTheUevent) {
    const auto node = read_hid_uevent(
        "DRIVER=hid-generic\nHID_ID=0003:0000256F:0000C635\nHID_NAME=3Dconnexion SpaceMouse Compact\n"
        "HID_PHYS=usb-0000:00:14.0-2/input0\nHID_UNIQ=\nMODALIAS=hid:b0003g0001v0000256Fp0000C635\n");
    ASSERT_TRUE(node);
    EXPECT_EQ(node->bus, 3);
    EXPECT_EQ(node->vendor, 0x256f);
    EXPECT_EQ(node->product, 0xc635);
    EXPECT_EQ(node->name, "3Dconnexion SpaceMouse Compact");
}

TEST(HidNode, TextWithoutIdsIsNone) {
    for (const char* text : {"", "\n\n", "HID_NAME=x\n", "HID_ID=\n", "HID_ID=0003:256F\n", "HID_ID=g:h:i\n",
                             "HID_ID=0003:0001256F:0000C635\n", "HID_ID=0003:0000256F:0000C635:1\n"})
        EXPECT_FALSE(read_hid_uevent(text)) << text;
}

TEST(HidNode, NodesStandByTheirNumbersAndAreFoundByIds) {
    const test::TemporaryFolder root;
    lay_node(root.path(), "hidraw10", "HID_ID=0003:0000256F:0000C635\nHID_NAME=later\n");
    lay_node(root.path(), "hidraw9", "HID_ID=0005:0000256F:0000C63A\nHID_NAME=sooner\n");
    lay_node(root.path(), "hidraw0", "HID_ID=0003:0000046D:0000C077\nHID_NAME=mouse\n");
    lay_node(root.path(), "hidraw1", "nothing that is known\n");
    const auto nodes = hid_nodes(root.path());
    ASSERT_EQ(nodes.size(), 3u);
    EXPECT_EQ(nodes[0].node, "/dev/hidraw0");
    EXPECT_EQ(nodes[1].node, "/dev/hidraw9");
    EXPECT_EQ(nodes[2].node, "/dev/hidraw10");
    const auto found =
        find_hid_node([](std::uint16_t vendor, std::uint16_t) { return vendor == 0x256f; }, root.path());
    ASSERT_TRUE(found);
    EXPECT_EQ(found->name, "sooner");
    EXPECT_FALSE(find_hid_node([](std::uint16_t, std::uint16_t) { return false; }, root.path()));
}

TEST(HidNode, ASystemWithoutHidHasNone) {
    const test::TemporaryFolder root;
    EXPECT_TRUE(hid_nodes(root.path()).empty());
}

TEST(HidTransport, WhatIsNoHidDeviceIsRefusedInALine) {
    const TemporaryFile file("plain", "text");
    for (const std::string& node : {std::string("/dev/hidraw-none"), file.path(), std::string("/dev/null")}) {
        const auto opened = HidTransport::open(node);
        ASSERT_FALSE(opened) << node;
        EXPECT_EQ(opened.error().kind, ErrorKind::device);
        EXPECT_TRUE(opened.error().message.starts_with(node + ": ")) << opened.error().message;
        EXPECT_EQ(opened.error().message.find('\n'), std::string::npos);
    }
}

}  // namespace
}  // namespace touchable
