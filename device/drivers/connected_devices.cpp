// SPDX-License-Identifier: Apache-2.0
// Known hardware, and which of it is connected: read from /sys, /proc and /dev without opening a device.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include "device/drivers/hid_transport.hpp"
#include "device/drivers/known_devices.hpp"
#include "device/drivers/spacemouse_device.hpp"
#include "device/drivers/woodenhaptics_device.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// ---- Known devices

using Through = KnownDevice::Through;

template <std::uint16_t vendor_id, std::uint16_t product_id>
bool is_exactly(std::uint16_t vendor, std::uint16_t product) {
    return vendor == vendor_id && product == product_id;
}

template <std::uint16_t vendor_id>
bool is_of(std::uint16_t vendor, std::uint16_t) {
    return vendor == vendor_id;
}

/// Some models swap the vendor and the product id.
bool is_touch(std::uint16_t vendor, std::uint16_t product) {
    return vendor == 0x2988 || (vendor == 0x0301 && product == 0x2988);
}

const std::array<KnownDevice, 9> known_hardware{{
    {.what = "Novint Falcon",
     .has_ids = is_exactly<0x0403, 0xcb48>,
     .through = Through::usb,
     .word = "falcon",
     .driven = "falcon:firmware=FILE",
     .firmware = "is loaded into it after each power-up; whether it is there shows when it is opened"},
    {.what = "3Dconnexion SpaceMouse: moves a finger, exerts no force",
     .has_ids = is_spacemouse,
     .through = Through::hidraw,
     .word = "spacemouse",
     .is_shared = true},
    {.what = "3Dconnexion CadMouse",
     .has_ids = is_of<0x256f>,
     .why = "it is an ordinary mouse",
     .instead = "use it as the window's mouse"},
    {.what = "WoodenHaptics or Polhem (or another board with the ids of its example)",
     .has_ids = is_woodenhaptics,
     .through = Through::hidraw,
     .word = "woodenhaptics",
     .driven = "woodenhaptics:file=FILE"},
    {.what = "a Teensy with RawHID, perhaps a later Polhem",
     .has_ids = is_exactly<0x16c0, 0x0486>,
     .why = "its reports of 64 bytes are not those of WoodenHaptics' firmware",
     .instead = "let a program of yours speak with it, and pass its places on to the device network"},
    {.what = "3D Systems Touch",
     .has_ids = is_touch,
     .why = "its protocol is closed: only its vendor's driver and OpenHaptics speak it",
     .instead = "install both, and let a program of yours pass its places on to the device network"},
    {.what = "a device of Force Dimension (omega, delta, sigma, lambda)",
     .has_ids = is_of<0x1451>,
     .why = "its protocol is closed: only its vendor's SDK speaks it",
     .instead = "install it, and let a program of yours pass its places on to the device network"},
    {.what = "Leap Motion Controller: sees hands, exerts no force",
     .has_ids = is_exactly<0xf182, 0x0003>,
     .why = "only its vendor's service reads it",
     .instead = "let a program of yours pass its places on to the device network"},
    {.what = "Haply Inverse3",
     .in_name = "Inverse3",
     .through = Through::service,
     .word = "inverse3",
     .instead = "start Haply's Inverse Service, which listens at TCP port 10001",
     .port = 10001},
}};

// ---- What Linux shows

namespace fs = std::filesystem;

/// Whether a line such as "  0: 0100007F:2711 00000000:0000 0A ..." of /proc/net/tcp listens at `port`.
bool line_listens(const std::string& line, std::uint16_t port) {
    constexpr unsigned listening = 0x0A;
    unsigned number = 0, state = 0;
    const int read = std::sscanf(line.c_str(), "%*s %*[^:]:%x %*s %x", &number, &state);
    return read == 2 && state == listening && number == port;
}

// ---- What is connected

/// A device node and its device's path in /sys.
struct SystemNode {
    std::string node;
    std::string at;
};

std::vector<SystemNode> nodes_of_class(const ConnectedSystem& system, const std::string& kind,
                                       const std::string& prefix) {
    std::vector<SystemNode> nodes;
    for (const std::string& name : system.names("/sys/class/" + kind))
        if (name.starts_with(prefix))
            nodes.push_back({"/dev/" + name, system.resolved("/sys/class/" + kind + "/" + name + "/device")});
    return nodes;
}

/// "bcdDevice" is four digits: 0110 is release 1.10.
std::string release_in_words(const std::string& digits) {
    if (digits.size() != 4) return {};
    const std::size_t first = digits[0] == '0' ? 1 : 0;
    return "release " + digits.substr(first, 2 - first) + "." + digits.substr(2);
}

/// Other processes that have `node` open, such as "spacenavd (process 812)", as far as this user may see.
std::vector<std::string> holders_of(const ConnectedSystem& system, const std::string& node) {
    std::vector<std::string> holders;
    const std::string own = std::to_string(getpid());
    for (const std::string& process : system.names("/proc")) {
        if (!is_digits(process) || process == own) continue;
        const std::string open = "/proc/" + process + "/fd";
        const auto descriptors = system.names(open);
        if (std::ranges::any_of(
                descriptors, [&](const std::string& each) { return system.link(open + "/" + each) == node; }))
            holders.push_back(system.text("/proc/" + process + "/comm") + " (process " + process + ")");
    }
    return holders;
}

/// The step that makes the device ready; empty: it is ready.
std::string what_is_missing(const ConnectedSystem& system, const KnownDevice& known,
                            const ConnectedDevice& device) {
    if (known.through == Through::service)
        return has_listener(system, known.port) ? std::string() : std::string(known.instead);
    if (device.node.empty() || !system.has(device.node))
        return known.through == Through::hidraw
                   ? "sudo modprobe usbhid   (it has no hidraw node; then plug it in again)"
                   : "plug it in again (it has no node in /dev/bus/usb)";
    if (const std::string rules = installed_udev_rules(system); !device.may_use)
        return rules.empty() ? std::string(udev_rules_command) + "   (then plug it in again)"
                             : "plug it in again (its udev rules are installed; over ssh see " + rules + ")";
    if (!known.is_shared && !device.held_by.empty())
        return "close " + listed(device.held_by) + ", which has it open";
    return {};
}

void judge(const ConnectedSystem& system, const KnownDevice& known, ConnectedDevice& device) {
    device.what = known.what;
    if (!known.firmware.empty()) device.firmware = known.firmware;
    for (const std::string& node : device.nodes)
        for (std::string& holder : holders_of(system, node)) device.held_by.push_back(std::move(holder));
    if (known.word.empty()) {
        device.why_not = known.why;
        device.next = known.instead;
        return;
    }
    device.driven = known.driven.empty() ? known.word : known.driven;
    const std::string prefix = known.through == Through::hidraw ? "/dev/hidraw" : "/dev/bus/usb/";
    const auto node =
        std::ranges::find_if(device.nodes, [&](const std::string& each) { return each.starts_with(prefix); });
    if (known.through != Through::service && node != device.nodes.end()) device.node = *node;
    device.may_use = !device.node.empty() && system.may_use(device.node);
    if (known.through != Through::service && !device.may_use && installed_udev_rules(system).empty())
        device.rules = udev_rules_of(device.vendor);
    device.next = what_is_missing(system, known, device);
    device.ready = device.next.empty();
}

std::optional<ConnectedDevice> usb_device(const ConnectedSystem& system, const std::string& name,
                                          const std::vector<SystemNode>& others) {
    const std::string at = "/sys/bus/usb/devices/" + name;
    const auto vendor = hexadecimal_id(system.text(at + "/idVendor")),
               product = hexadecimal_id(system.text(at + "/idProduct"));
    if (!vendor || !product) return std::nullopt;
    const std::string maker = system.text(at + "/manufacturer"), words = system.text(at + "/product");
    const KnownDevice* const known = known_device(*vendor, *product, maker, words);
    if (!known) return std::nullopt;
    ConnectedDevice device;
    device.place = "usb " + name;
    device.vendor = *vendor;
    device.product = *product;
    device.name = maker.empty() || words.starts_with(maker) ? words : maker + " " + words;
    device.firmware = release_in_words(system.text(at + "/bcdDevice"));
    const std::string there = system.resolved(at);
    for (const SystemNode& other : others)
        if (!there.empty() && other.at.starts_with(there + "/")) device.nodes.push_back(other.node);
    if (std::string node = usbfs_node(system, at); !node.empty()) device.nodes.push_back(std::move(node));
    judge(system, *known, device);
    return device;
}

/// A HID device whose USB device is not in /sys, or that has none.
std::optional<ConnectedDevice> lone_hid_device(const ConnectedSystem& system, const HidNode& hid) {
    constexpr int bluetooth = 5;
    const KnownDevice* const known = known_device(hid.vendor, hid.product, {}, hid.name);
    if (!known) return std::nullopt;
    ConnectedDevice device;
    device.place = hid.bus == bluetooth ? "bluetooth" : "other";
    device.vendor = hid.vendor;
    device.product = hid.product;
    device.name = hid.name;
    device.nodes = {hid.node};
    judge(system, *known, device);
    return device;
}

}  // namespace

// ---- Known devices

std::span<const KnownDevice> known_devices() {
    return known_hardware;
}

const KnownDevice* known_device(std::uint16_t vendor, std::uint16_t product, std::string_view maker,
                                std::string_view name) {
    const auto fits = [&](const KnownDevice& each) {
        if (each.has_ids) return each.has_ids(vendor, product);
        return name.find(each.in_name) != std::string_view::npos ||
               maker.find(each.in_name) != std::string_view::npos;
    };
    const auto found = std::ranges::find_if(known_hardware, fits);
    return found == known_hardware.end() ? nullptr : &*found;
}

std::vector<std::string> udev_rules_of(std::uint16_t vendor) {
    const std::array marks{formatted("idVendor}==\"%04x\"", vendor), formatted(":%04X:", vendor)};
    std::vector<std::string> rules;
    std::istringstream file(udev_rules());
    for (std::string line; std::getline(file, line);)
        if (!line.starts_with("#") && std::ranges::any_of(marks, [&](const std::string& mark) {
                return line.find(mark) != std::string::npos;
            }))
            rules.push_back(line);
    return rules;
}

std::string installed_udev_rules(const ConnectedSystem& system) {
    for (const std::string folder : {"/etc", "/run", "/usr/local/lib", "/usr/lib"})
        if (const std::string file = folder + "/udev/rules.d/70-touchable.rules"; system.has(file))
            return file;
    return {};
}

bool has_udev_rules() {
    return !installed_udev_rules(ConnectedSystem()).empty();
}

Error not_permitted(const std::string& node, const ConnectedSystem& system) {
    const std::string what = node + ": may not be opened by this user; ";
    const std::string rules = installed_udev_rules(system);
    if (rules.empty())
        return device_error(what + "install the program's udev rules, then plug it in again",
                            {{Setting::device_rules}});
    return device_error(what + "its udev rules are installed: plug it in again; over ssh see " + rules);
}

// ---- What Linux shows

std::vector<std::string> ConnectedSystem::names(const std::string& folder) const {
    std::vector<std::string> names;
    std::error_code failure;
    for (fs::directory_iterator each(below(folder), failure), end; !failure && each != end;
         each.increment(failure))
        names.push_back(each->path().filename().string());
    std::ranges::sort(names);
    return names;
}

bool ConnectedSystem::has(const std::string& path) const {
    std::error_code ignored;
    return fs::exists(below(path), ignored);
}

std::string ConnectedSystem::text(const std::string& path, std::size_t most) const {
    std::ifstream in(below(path), std::ios::binary);
    std::string text(most, '\0');
    if (in) in.read(text.data(), static_cast<std::streamsize>(most));
    text.resize(in.gcount() > 0 ? static_cast<std::size_t>(in.gcount()) : 0);
    while (!text.empty() && (text.back() == '\n' || text.back() == '\0')) text.pop_back();
    return text;
}

std::string ConnectedSystem::link(const std::string& path) const {
    std::error_code failure;
    const fs::path target = fs::read_symlink(below(path), failure);
    return failure ? std::string() : target.string();
}

std::string ConnectedSystem::resolved(const std::string& path) const {
    std::error_code failure;
    const fs::path whole = fs::canonical(below(path), failure);
    if (failure) return {};
    const fs::path top = fs::canonical(root_, failure);
    if (failure) return {};
    return "/" + whole.lexically_relative(top).string();
}

std::string usbfs_node(const ConnectedSystem& system, const std::string& at) {
    const std::string bus = system.text(at + "/busnum"), number = system.text(at + "/devnum");
    const auto padded = [](const std::string& digits) {
        return std::string(digits.size() < 3 ? 3 - digits.size() : 0, '0') + digits;
    };
    return bus.empty() || number.empty() ? std::string()
                                         : "/dev/bus/usb/" + padded(bus) + "/" + padded(number);
}

bool has_listener(const ConnectedSystem& system, std::uint16_t port) {
    constexpr std::size_t many_sockets = 1 << 20;
    for (const char* table : {"/proc/net/tcp", "/proc/net/tcp6"}) {
        std::istringstream lines(system.text(table, many_sockets));
        for (std::string line; std::getline(lines, line);)
            if (line_listens(line, port)) return true;
    }
    return false;
}

// ---- What is connected

std::vector<ConnectedDevice> connected_devices() {
    return connected_devices(ConnectedSystem());
}

std::vector<ConnectedDevice> connected_devices(const ConnectedSystem& system) {
    std::vector<SystemNode> nodes = nodes_of_class(system, "hidraw", "hidraw");
    for (SystemNode& serial : nodes_of_class(system, "tty", "ttyACM")) nodes.push_back(std::move(serial));
    std::vector<ConnectedDevice> devices;
    for (const std::string& name : system.names("/sys/bus/usb/devices"))
        if (auto device = usb_device(system, name, nodes)) devices.push_back(std::move(*device));
    for (const HidNode& hid : hid_nodes(system)) {
        const bool is_listed = std::ranges::any_of(devices, [&](const ConnectedDevice& each) {
            return std::ranges::find(each.nodes, hid.node) != each.nodes.end();
        });
        if (is_listed) continue;
        if (auto device = lone_hid_device(system, hid)) devices.push_back(std::move(*device));
    }
    return devices;
}

}  // namespace touchable
