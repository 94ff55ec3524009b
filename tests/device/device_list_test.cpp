// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/device_catalog.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>
#include "device/drivers/known_devices.hpp"
#include "tests/temporary_files.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

/// A tree as Linux shows it, in a folder of its own.
class FakeSystem final : public ConnectedSystem {
public:
    explicit FakeSystem(const fs::path& root) : ConnectedSystem(root) {}
    bool may_use(const std::string& node) const override { return permitted.contains(node); }
    std::set<std::string> permitted;
};

class DeviceList : public ::testing::Test {
protected:
    void lay(const std::string& path, const std::string& text) {
        fs::create_directories((root_.path() / path).parent_path());
        std::ofstream(root_.path() / path) << text << '\n';
    }
    void link(const std::string& path, const std::string& target) {
        fs::create_directories((root_.path() / path).parent_path());
        fs::create_symlink(target, root_.path() / path);
    }
    void plug_usb(const std::string& port, const std::string& vendor, const std::string& product,
                  const std::string& maker, const std::string& name) {
        const std::string at = "sys/devices/pci0000:00/usb1/" + port;
        lay(at + "/idVendor", vendor);
        lay(at + "/idProduct", product);
        if (!maker.empty()) lay(at + "/manufacturer", maker);
        lay(at + "/product", name);
        lay(at + "/bcdDevice", "0431");
        lay(at + "/busnum", "1");
        lay(at + "/devnum", "12");
        lay("dev/bus/usb/001/012", "");
        link("sys/bus/usb/devices/" + port, "../../../devices/pci0000:00/usb1/" + port);
    }
    /// `below`: the device's folder in sys/devices.
    void add_hidraw(const std::string& node, const std::string& below, const std::string& uevent) {
        lay("sys/devices/" + below + "/uevent", uevent);
        link("sys/class/hidraw/" + node + "/device", "../../../devices/" + below);
        lay("dev/" + node, "");
    }
    void plug_spacemouse() {
        plug_usb("1-2.3", "046d", "c626", "3Dconnexion", "SpaceNavigator");
        add_hidraw("hidraw4", "pci0000:00/usb1/1-2.3/1-2.3:1.0/0003:046D:C626.0001",
                   "HID_ID=0003:0000046D:0000C626\nHID_NAME=3Dconnexion SpaceNavigator");
    }
    void open_in(const std::string& process, const std::string& program, const std::string& node) {
        lay("proc/" + process + "/comm", program);
        link("proc/" + process + "/fd/0", "/dev/null");
        link("proc/" + process + "/fd/7", node);
    }
    ConnectedDevice only() {
        const auto devices = connected_devices(system_);
        EXPECT_EQ(devices.size(), 1u);
        return devices.empty() ? ConnectedDevice{} : devices[0];
    }

    test::TemporaryFolder root_;
    FakeSystem system_{root_.path()};
};

TEST_F(DeviceList, EmptyListSuggestsPluggingIn) {
    plug_usb("1-1", "046d", "c077", "Logitech", "USB Optical Mouse");
    EXPECT_TRUE(connected_devices(system_).empty());
    EXPECT_NE(devices_in_words({}).find("plug one in"), std::string::npos);
    EXPECT_NE(devices_in_words({}, "--device ").find("any program can drive the finger (--device network)"),
              std::string::npos);
    const test::TemporaryFolder bare;
    EXPECT_TRUE(connected_devices(FakeSystem(bare.path())).empty());
}

TEST_F(DeviceList, PermittedSpaceMouseIsReady) {
    plug_spacemouse();
    system_.permitted = {"/dev/hidraw4"};
    open_in("812", "spacenavd", "/dev/hidraw4");  // both may read it
    const auto device = only();
    EXPECT_EQ(device.place, "usb 1-2.3");
    EXPECT_EQ(device.vendor, 0x046d);
    EXPECT_EQ(device.product, 0xc626);
    EXPECT_EQ(device.name, "3Dconnexion SpaceNavigator");
    EXPECT_EQ(device.driven, "spacemouse");
    EXPECT_EQ(device.firmware, "release 4.31");
    EXPECT_EQ(device.node, "/dev/hidraw4");
    EXPECT_EQ(device.nodes, (std::vector<std::string>{"/dev/hidraw4", "/dev/bus/usb/001/012"}));
    EXPECT_EQ(device.held_by, (std::vector<std::string>{"spacenavd (process 812)"}));
    EXPECT_TRUE(device.ready);
    EXPECT_TRUE(device.next.empty());
    const std::string words = devices_in_words({device});
    for (const char* part :
         {"SpaceMouse", "exerts no force", "usb 1-2.3", "046d:c626", "drive it with:  spacemouse",
          "/dev/hidraw4, may be used", "spacenavd (process 812)", "    ready\n"})
        EXPECT_NE(words.find(part), std::string::npos) << part << " in\n" << words;
}

TEST_F(DeviceList, ForbiddenDeviceNeedsUdevRule) {
    plug_spacemouse();
    const auto device = only();
    EXPECT_FALSE(device.ready);
    EXPECT_FALSE(device.may_use);
    EXPECT_NE(device.next.find("touchable devices --udev-rules | sudo tee"), std::string::npos);
    EXPECT_EQ(device.rules, (std::vector<std::string>{R"(KERNEL=="hidraw*", ATTRS{idVendor}=="046d", )"
                                                      R"(ATTRS{idProduct}=="c6*", TAG+="uaccess")"}));
    EXPECT_NE(devices_in_words({device}).find("may not be used by you"), std::string::npos);
    EXPECT_NE(devices_in_words({device}).find("rule: KERNEL==\"hidraw*\""), std::string::npos);
    EXPECT_NE(devices_in_words({}).find("| sudo tee /etc/udev/rules.d/"), std::string::npos);
    const Error error = not_permitted("/dev/hidraw4", system_);
    EXPECT_EQ(error.message,
              "/dev/hidraw4: may not be opened by this user; install the program's udev rules, then plug it "
              "in again");
    ASSERT_EQ(error.hints.size(), 1u);
    EXPECT_EQ(error.hints[0].setting, Setting::device_rules);
}

TEST_F(DeviceList, InstalledRulesAreNotAskedFor) {
    plug_spacemouse();
    for (const std::string folder : {"usr/lib", "usr/local/lib", "run", "etc"}) {
        lay(folder + "/udev/rules.d/70-touchable.rules", udev_rules());
        const std::string file = '/' + folder + "/udev/rules.d/70-touchable.rules";
        EXPECT_EQ(installed_udev_rules(system_), file) << "udev prefers it to those before";
        const auto device = only();
        EXPECT_FALSE(device.ready);
        EXPECT_TRUE(device.rules.empty());
        EXPECT_EQ(device.next, "plug it in again (its udev rules are installed; over ssh see " + file + ")");
        const Error error = not_permitted("/dev/hidraw4", system_);
        EXPECT_EQ(error.message,
                  "/dev/hidraw4: may not be opened by this user; its udev rules are installed: "
                  "plug it in again; over ssh see " +
                      file);
        EXPECT_TRUE(error.hints.empty());
    }
    const std::string words = devices_in_words({}, "--device ", true);
    EXPECT_NE(words.find("plug one in"), std::string::npos);
    EXPECT_EQ(words.find("sudo"), std::string::npos) << words;
}

TEST_F(DeviceList, DeviceWithoutNodeNeedsDriver) {
    plug_usb("1-2", "256f", "c635", "3Dconnexion", "SpaceMouse Compact");
    system_.permitted = {"/dev/bus/usb/001/012"};
    const auto device = only();
    EXPECT_FALSE(device.ready);
    EXPECT_TRUE(device.node.empty());
    EXPECT_NE(device.next.find("modprobe usbhid"), std::string::npos);
}

TEST_F(DeviceList, IgnoresNodeOfOtherDevice) {
    plug_usb("1-2", "256f", "c635", "3Dconnexion", "SpaceMouse Compact");
    plug_usb("1-21", "1111", "2222", "Nobody", "Keyboard");
    add_hidraw("hidraw0", "pci0000:00/usb1/1-21/1-21:1.0/0003:1111:2222.0001",
               "HID_ID=0003:00001111:00002222\nHID_NAME=Keyboard");
    EXPECT_TRUE(only().node.empty());
}

TEST_F(DeviceList, NamesProcessHoldingWoodenHaptics) {
    plug_usb("3-1", "1234", "0006", "", "HID DEVICE");
    add_hidraw("hidraw1", "pci0000:00/usb1/3-1/3-1:1.0/0003:1234:0006.0002",
               "HID_ID=0003:00001234:00000006\nHID_NAME=mbed.org HID DEVICE");
    system_.permitted = {"/dev/hidraw1"};
    EXPECT_TRUE(only().ready);
    EXPECT_EQ(only().driven, "woodenhaptics:file=FILE");
    open_in("4242", "simulator", "/dev/hidraw1");
    const auto device = only();
    EXPECT_FALSE(device.ready);
    EXPECT_EQ(device.next, "close simulator (process 4242), which has it open");
}

TEST_F(DeviceList, ListsBluetoothDeviceWithoutUsb) {
    add_hidraw("hidraw2", "virtual/misc/uhid/0005:256F:C63A.0003",
               "HID_ID=0005:0000256F:0000C63A\nHID_NAME=SpaceMouse Wireless BT");
    system_.permitted = {"/dev/hidraw2"};
    const auto device = only();
    EXPECT_EQ(device.place, "bluetooth");
    EXPECT_EQ(device.driven, "spacemouse");
    EXPECT_TRUE(device.ready);
}

TEST_F(DeviceList, ExplainsUnsupportedDevicesWithAlternative) {
    const struct {
        const char *vendor, *product, *what, *why;
    } closed[] = {{"2988", "0302", "3D Systems Touch", "OpenHaptics"},
                  {"0301", "2988", "3D Systems Touch", "OpenHaptics"},
                  {"1451", "0402", "Force Dimension", "SDK"},
                  {"f182", "0003", "Leap Motion", "service"},
                  {"256f", "c650", "CadMouse", "ordinary mouse"},
                  {"16c0", "0486", "Teensy", "64 bytes"}};
    int port = 1;
    for (const auto& each : closed)
        plug_usb("1-" + std::to_string(port++), each.vendor, each.product, "Maker", "Thing");
    const auto devices = connected_devices(system_);
    ASSERT_EQ(devices.size(), std::size(closed));
    for (std::size_t k = 0; k < devices.size(); ++k) {
        EXPECT_NE(devices[k].what.find(closed[k].what), std::string::npos) << devices[k].what;
        EXPECT_NE(devices[k].why_not.find(closed[k].why), std::string::npos) << devices[k].why_not;
        EXPECT_TRUE(devices[k].driven.empty());
        EXPECT_FALSE(devices[k].ready);
        EXPECT_FALSE(devices[k].next.empty());
        const std::string words = devices_in_words({devices[k]}, "by ");
        EXPECT_NE(words.find("cannot be driven"), std::string::npos) << words;
        const bool is_a_mouse = devices[k].what.find("CadMouse") != std::string::npos;
        EXPECT_EQ(words.find("the device network (by network)\n") == std::string::npos, is_a_mouse) << words;
        EXPECT_NE(words.find("instead: "), std::string::npos) << words;
    }
}

TEST_F(DeviceList, ShowsNodeOfSerialTouch) {
    plug_usb("1-4", "2988", "0302", "3D Systems", "3D Systems Touch 3D Stylus");
    link("sys/class/tty/ttyACM0/device", "../../../devices/pci0000:00/usb1/1-4/1-4:1.0");
    fs::create_directories(root_ / "sys/devices/pci0000:00/usb1/1-4/1-4:1.0");
    EXPECT_EQ(only().nodes, (std::vector<std::string>{"/dev/ttyACM0", "/dev/bus/usb/001/012"}));
    EXPECT_EQ(only().name, "3D Systems Touch 3D Stylus");
}

/// Devices whose backend is not in this program are known all the same.
TEST_F(DeviceList, DrivesOnlyDevicesInCatalogue) {
    plug_usb("1-5", "0403", "cb48", "Novint", "Falcon");
    plug_usb("1-6", "aaaa", "bbbb", "Haply", "Inverse3");
    std::set<std::string> words;
    for (const DeviceKind& kind : device_kinds()) words.insert(std::string(kind.name));
    const auto devices = connected_devices(system_);
    ASSERT_EQ(devices.size(), 2u);
    EXPECT_EQ(devices[0].driven.empty(), !words.contains("falcon"));
    EXPECT_EQ(devices[0].why_not.empty(), words.contains("falcon"));
    EXPECT_NE(devices[0].firmware.find("power-up"), std::string::npos);
    EXPECT_EQ(devices[1].driven.empty(), !words.contains("inverse3"));
    EXPECT_FALSE(devices[1].ready);
}

TEST_F(DeviceList, DetectsListeningService) {
    const std::string head =
        "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid\n";
    EXPECT_FALSE(has_listener(system_, 10001));
    lay("proc/net/tcp",
        head + "   0: 0100007F:2711 0100007F:A000 01 00000000:00000000 00:00000000 00000000  1000");
    EXPECT_FALSE(has_listener(system_, 10001));  // connected: it is a client's end
    lay("proc/net/tcp",
        head + "   0: 0100007F:2711 00000000:0000 0A 00000000:00000000 00:00000000 00000000  1000");
    EXPECT_TRUE(has_listener(system_, 10001));
    EXPECT_FALSE(has_listener(system_, 10002));
}

TEST_F(DeviceList, RemovesControlCharactersFromNames) {
    plug_usb("1-2", "256f", "c635", "", "Space\n    ready\x1b[31m");
    const std::string words = devices_in_words(connected_devices(system_));
    EXPECT_EQ(words.find("\n    ready"), std::string::npos) << words;
    EXPECT_EQ(words.find('\x1b'), std::string::npos);
}

TEST_F(DeviceList, SkipsInvalidIds) {
    plug_usb("1-2", "256f", "c6zz", "", "SpaceMouse");
    plug_usb("1-3", "", "c635", "", "SpaceMouse");
    plug_usb("1-4", "0256f0", "c635", "", "SpaceMouse");
    EXPECT_TRUE(connected_devices(system_).empty());
}

TEST_F(DeviceList, JsonMatchesList) {
    plug_spacemouse();
    plug_usb("1-9", "1451", "0402", "Force Dimension", "omega\xff.3");
    system_.permitted = {"/dev/hidraw4"};
    const auto json = nlohmann::json::parse(devices_in_json(connected_devices(system_)));
    EXPECT_EQ(json.at("touchable_devices"), 1);
    const auto& mouse = json.at("devices").at(0);
    EXPECT_EQ(mouse.at("place"), "usb 1-2.3");
    EXPECT_EQ(mouse.at("ids"), "046d:c626");
    EXPECT_EQ(mouse.at("driven"), "spacemouse");
    EXPECT_EQ(mouse.at("node"), "/dev/hidraw4");
    EXPECT_EQ(mouse.at("ready"), true);
    EXPECT_EQ(mouse.at("next"), "");
    ASSERT_EQ(json.at("words").size(), device_kinds().size() + 1) << "simulated is one as well";
    EXPECT_EQ(json.at("words").at(0).at("word"), device_kinds()[0].name);
    EXPECT_EQ(json.at("devices").at(1).at("ready"), false);
    EXPECT_NE(json.at("devices").at(1).at("why_not"), "");
}

TEST(UdevRules, EmbeddedRulesMatchFile) {
    std::ifstream in(std::string(TOUCHABLE_SOURCE_DIR) + "/share/udev/70-touchable.rules");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), udev_rules());
    EXPECT_EQ(udev_rules_of(0x256f).size(), 2u) << "by cable, by Bluetooth";
    EXPECT_EQ(udev_rules_of(0x0403).size(), 1u);
    EXPECT_TRUE(udev_rules_of(0x1451).empty()) << "not driven";
}

TEST(DeviceWords, NameEveryDeviceKind) {
    EXPECT_NE(device_words_in_words("do so").find("without a window: do so\n"), std::string::npos);
    const std::string words = device_words_in_words();
    EXPECT_NE(words.find("replays a device log\n"), std::string::npos);
    for (const DeviceKind& kind : device_kinds())
        EXPECT_NE(("\n" + words).find("\n    " + std::string(kind.name) + std::string(kind.keys) + " "),
                  std::string::npos)
            << kind.name;
}

TEST(UdevRules, CoverEveryDeviceWithNode) {
    std::ifstream in(std::string(TOUCHABLE_SOURCE_DIR) + "/share/udev/70-touchable.rules");
    ASSERT_TRUE(in);
    const std::regex ids(
        R"re(ATTRS?\{idVendor\}=="([0-9a-f]{4})"(, ATTRS?\{idProduct\}=="([0-9a-f]+)\*?")?.*TAG\+="uaccess")re");
    std::set<std::string_view> named, driven;
    for (std::string line; std::getline(in, line);) {
        std::smatch found;
        if (!std::regex_search(line, found, ids)) continue;
        const std::string product = found[3].matched ? (found[3].str() + "26").substr(0, 4) : "c635";
        const auto* known =
            known_device(static_cast<std::uint16_t>(std::stoul(found[1].str(), nullptr, 16)),
                         static_cast<std::uint16_t>(std::stoul(product, nullptr, 16)), "", "");
        ASSERT_NE(known, nullptr) << line;
        named.insert(known->word);
    }
    for (const KnownDevice& known : known_devices())
        for (const DeviceKind& kind : device_kinds())
            if (kind.name == known.word &&
                (known.through == KnownDevice::Through::hidraw || known.through == KnownDevice::Through::usb))
                driven.insert(known.word);
    EXPECT_EQ(named, driven);
    EXPECT_GE(driven.size(), 2u);
}

TEST(ConnectedSystem, ReadsThisMachine) {
    const ConnectedSystem here;
    for (const ConnectedDevice& device : connected_devices(here)) EXPECT_FALSE(device.what.empty());
    EXPECT_FALSE(here.text("/proc/self/comm").empty());
}

TEST(DeviceCatalogue, MakesHidDevices) {
    const auto mouse = make_device("spacemouse:speed=0.2", {});
    ASSERT_TRUE(mouse);
    EXPECT_EQ((*mouse)->capabilities().axes_driven, 0);
    EXPECT_NE((*mouse)->name().find("no force"), std::string::npos);
    const auto wooden = make_device(
        std::string("woodenhaptics:file=") + TOUCHABLE_SOURCE_DIR + "/examples/woodenhaptics.json", {});
    ASSERT_TRUE(wooden);
    EXPECT_TRUE((*wooden)->capabilities().own_watchdog);
    EXPECT_EQ(make_device("spacemouse:force=1", {}).error().kind, ErrorKind::usage);
}

}  // namespace
}  // namespace touchable
