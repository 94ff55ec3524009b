// A Falcon's keys, its firmware's file, and what is said where it cannot be had.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "device/drivers/falcon_device.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

void write_file(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
}

Error refusal_of(const std::string& keys) {
    const auto settings = read_falcon_settings(keys);
    return settings ? Error{ErrorKind::internal, "taken"} : settings.error();
}

TEST(FalconKeys, AreForceStiffnessAndFirmware) {
    TemporaryFolder folder;
    write_file(folder / "image.bin", std::string(7318, 'x'));
    const auto plain = read_falcon_settings("");
    ASSERT_TRUE(plain);
    EXPECT_EQ(plain->limits.max_force, 8);
    EXPECT_EQ(plain->limits.max_stiffness, 1000);
    EXPECT_TRUE(plain->firmware.empty());
    const auto set =
        read_falcon_settings("force=5,stiffness=0.5,firmware=" + (folder / "image.bin").string());
    ASSERT_TRUE(set) << set.error().message;
    EXPECT_EQ(set->limits.max_force, 5);
    EXPECT_EQ(set->limits.max_stiffness, 500);
    EXPECT_EQ(set->firmware, std::vector<std::byte>(7318, std::byte{'x'}));
}

TEST(FalconKeys, WhatIsNoneIsRefusedWithTheRightOnes) {
    for (const char* wrong :
         {"force=0", "force=11", "force=nan", "stiffness=-1", "colour=red", "firmware="}) {
        const Error error = refusal_of(wrong);
        EXPECT_EQ(error.kind, ErrorKind::usage) << wrong;
        EXPECT_NE(error.message.find("device 'falcon'"), std::string::npos) << error.message;
    }
}

TEST(FalconKeys, AFileThatCannotBeFirmwareIsBadInput) {
    TemporaryFolder folder;
    write_file(folder / "empty", "");
    write_file(folder / "large", std::string(100000, 'x'));
    for (const std::string name : {"none", "empty", "large", ""}) {
        const Error error = refusal_of("firmware=" + (folder / name).string());
        EXPECT_EQ(error.kind, ErrorKind::input) << name;
        EXPECT_NE(error.message.find("firmware"), std::string::npos) << error.message;
    }
    EXPECT_NE(refusal_of("firmware=" + (folder / "large").string()).message.find("100000 bytes"),
              std::string::npos);
}

class Plugged : public ::testing::Test {
protected:
    void plug(const std::string& name, const std::string& vendor, const std::string& product,
              const std::string& bus, const std::string& number) {
        const fs::path device = folders.devices / name;
        write_file(device / "idVendor", vendor + "\n");
        write_file(device / "idProduct", product + "\n");
        write_file(device / "busnum", bus + "\n");
        write_file(device / "devnum", number + "\n");
    }
    TemporaryFolder folder;
    UsbFolders folders{folder / "devices", folder / "nodes"};
};

TEST_F(Plugged, TheFirstOfItsKindIsFound) {
    EXPECT_EQ(find_usb_device("0403", "cb48", folders), fs::path());
    plug("usb1", "1d6b", "0002", "1", "1");
    plug("1-2", "0403", "6001", "1", "3");
    EXPECT_EQ(find_usb_device("0403", "cb48", folders), fs::path());
    plug("2-1", "0403", "cb48", "2", "4");
    plug("1-1", "0403", "cb48", "1", "12");
    EXPECT_EQ(find_usb_device("0403", "cb48", folders), folders.nodes / "001" / "012");
    fs::create_directories(folders.devices / "1-1:1.0");  // an interface, which has no identity of its own
    EXPECT_EQ(find_usb_device("0403", "cb48", folders), folders.nodes / "001" / "012");
}

TEST_F(Plugged, WhatIsMissingIsSaidInOneLine) {
    const auto absent = open_falcon(folders);
    ASSERT_FALSE(absent);
    EXPECT_EQ(absent.error().kind, ErrorKind::device);
    EXPECT_NE(absent.error().message.find("0403:cb48"), std::string::npos);
    plug("1-1", "0403", "cb48", "1", "2");
    const auto no_node = open_falcon(folders);
    ASSERT_FALSE(no_node);
    EXPECT_NE(no_node.error().message.find("001/002: No such file"), std::string::npos)
        << no_node.error().message;
    write_file(folders.nodes / "001" / "002", "no USB device");
    const auto no_device = open_falcon(folders);
    ASSERT_FALSE(no_device);
    EXPECT_NE(no_device.error().message.find("Novint Falcon at "), std::string::npos);
    EXPECT_EQ(no_device.error().message.find('\n'), std::string::npos);
    if (geteuid() == 0) return;  // root may open anything
    fs::permissions(folders.nodes / "001" / "002", fs::perms::none);
    const auto forbidden = open_falcon(folders);
    ASSERT_FALSE(forbidden);
    EXPECT_NE(forbidden.error().message.find("70-touchable.rules"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
