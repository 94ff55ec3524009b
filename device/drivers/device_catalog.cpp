// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/device_catalog.hpp"

#include <nlohmann/json.hpp>

#include "device/drivers/falcon_device.hpp"
#include "device/drivers/inverse3_device.hpp"
#include "device/drivers/known_devices.hpp"
#include "device/drivers/network_device.hpp"
#include "device/drivers/recorded_device.hpp"
#include "device/drivers/spacemouse_device.hpp"
#include "device/drivers/woodenhaptics_device.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

constexpr DeviceKind kinds_of_devices[] = {
    {"falcon", "a Novint Falcon (USB)", ":firmware=FILE", make_falcon_driver},
    {"inverse3", "a Haply Inverse3, through the service of its makers", "", make_inverse3_driver},
    {"woodenhaptics", "WoodenHaptics and Polhem, open hardware (HID); its build is described in a file",
     ":file=FILE", make_woodenhaptics_driver},
    {"spacemouse", "a 3Dconnexion SpaceMouse (HID) moves the finger; it exerts no force", "",
     make_spacemouse_driver},
    {"network", "any program that sends UDP datagrams (docs/devices.md)", "", make_network_driver},
    {"recorded", "replays a device log", ":FILE", make_recorded_driver},
};

/// An unusable file and missing hardware are reported together, not one after the other.
Error also_unplugged(Error error, std::string_view name) {
    const auto known = known_devices();
    const bool is_hardware =
        std::ranges::any_of(known, [&](const KnownDevice& each) { return each.word == name; });
    if (error.kind != ErrorKind::input || !is_hardware) return error;
    const auto connected = connected_devices();
    const bool is_there = std::ranges::any_of(connected, [&](const ConnectedDevice& each) {
        return KeyedValues::name_and_pairs(each.driven).first == name;
    });
    if (!is_there) error.message += "; and no " + std::string(name) + " is connected";
    return error;
}

Error unknown_device(const std::string& name) {
    if (name == "mouse")
        return usage_error("device mouse is the window's, where no device is needed: touchable play CLIP",
                           {{Setting::device}});
    std::vector<std::string> words;
    for (const std::string& each : device_words())
        words.emplace_back(KeyedValues::name_and_pairs(each).first);
    const std::string nearest = nearest_word(name, words);
    return usage_error("unknown device '" + printable(name) + "'" +
                       (nearest.empty() ? "; there are " : "; did you mean " + nearest + "? There are ") +
                       listed(words) + "; and mouse, in the window alone (touchable play)");
}

// ---- In words

constexpr const char* simulated_words = "a handle that a scripted hand holds, in a run without a window";

std::string ids_in_words(const ConnectedDevice& device) {
    return formatted("%04x:%04x", device.vendor, device.product);
}

std::string device_lines(const ConnectedDevice& device, const std::string& naming) {
    std::string words = device.what + "  (" + device.place + ", " + ids_in_words(device);
    if (!device.name.empty()) words += ", " + in_quotes(device.name);
    words += ")\n";
    if (!device.driven.empty()) words += "    drive it with:  " + naming + device.driven + "\n";
    if (!device.why_not.empty()) words += "    known, but cannot be driven: " + device.why_not + "\n";
    if (!device.firmware.empty()) words += "    firmware: " + printable(device.firmware) + "\n";
    if (!device.node.empty())
        words += "    node: " + device.node +
                 (device.may_use ? ", may be used" : ", may not be used by you") + "\n";
    for (const std::string& rule : device.rules) words += "    rule: " + rule + "\n";
    if (!device.held_by.empty())
        words +=
            "    open in: " + listed(device.held_by, [](const auto& each) { return printable(each); }) + "\n";
    if (device.ready) return words + "    ready\n";
    if (device.next.empty()) return words;
    words +=
        (device.why_not.empty() ? "    not ready; do:  " : "    instead: ") + printable(device.next, 400);
    if (!device.why_not.empty() && device.next.ends_with("the device network"))
        words += " (" + naming + "network)";
    return words + '\n';
}

}  // namespace

std::span<const DeviceKind> device_kinds() {
    return kinds_of_devices;
}

std::vector<std::string> device_words() {
    std::vector<std::string> words;
    for (const DeviceKind& each : kinds_of_devices)
        words.push_back(std::string(each.name) + std::string(each.keys));
    words.emplace_back("simulated");
    return words;
}

Result<std::unique_ptr<HapticDevice>> make_device(const std::string& description,
                                                  const DrivenSettings& driven) {
    const auto [name, pairs] = KeyedValues::name_and_pairs(description);
    const auto kind = std::ranges::find(kinds_of_devices, name, &DeviceKind::name);
    if (kind == std::end(kinds_of_devices)) return unknown_device(std::string(name));
    auto driver = kind->make_driver(pairs);
    if (!driver) return also_unplugged(driver.error(), name);
    return std::make_unique<DrivenDevice>(std::move(*driver), driven);
}

// ---- In words

std::string devices_in_words(const std::vector<ConnectedDevice>& devices, const std::string& naming,
                             bool has_rules) {
    const std::string permit =
        std::string(" Most have to be permitted, once for all of them:\n    ") + udev_rules_command;
    if (devices.empty())
        return "No device that is known here is connected: plug one in and switch it on." +
               (has_rules ? "" : permit) +
               "\nYou need no device: the mouse works in the window (touchable play), and any program can "
               "drive the finger (" +
               naming + "network).\n";
    std::string words;
    for (const ConnectedDevice& device : devices) words += device_lines(device, naming);
    return words;
}

std::string device_words_in_words(const std::string& with_simulated) {
    constexpr std::size_t column = 24;
    std::string words;
    const auto line = [&words](std::string_view word, std::string_view what) {
        words += "    " + std::string(word) +
                 std::string(word.size() < column ? column - word.size() : 1, ' ') + std::string(what) + "\n";
    };
    for (const DeviceKind& kind : device_kinds())
        line(std::string(kind.name) + std::string(kind.keys), kind.words);
    line("simulated", simulated_words + (with_simulated.empty() ? "" : ": " + with_simulated));
    return words;
}

std::string devices_in_json(const std::vector<ConnectedDevice>& devices) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const ConnectedDevice& device : devices)
        list.push_back({{"place", device.place},
                        {"ids", ids_in_words(device)},
                        {"name", device.name},
                        {"what", device.what},
                        {"driven", device.driven},
                        {"why_not", device.why_not},
                        {"firmware", device.firmware},
                        {"nodes", device.nodes},
                        {"node", device.node},
                        {"may_use", device.may_use},
                        {"rules", device.rules},
                        {"held_by", device.held_by},
                        {"ready", device.ready},
                        {"next", device.next}});
    nlohmann::ordered_json words = nlohmann::ordered_json::array();
    for (const DeviceKind& kind : device_kinds())
        words.push_back({{"word", kind.name}, {"keys", kind.keys}, {"what", kind.words}});
    words.push_back({{"word", "simulated"}, {"keys", ""}, {"what", simulated_words}});
    const nlohmann::ordered_json whole = {
        {"touchable_devices", 1}, {"devices", std::move(list)}, {"words", std::move(words)}};
    return whole.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace touchable
