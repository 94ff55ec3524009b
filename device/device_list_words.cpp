#include <array>
#include <nlohmann/json.hpp>

#include "device/device_catalog.hpp"
#include "device/device_list.hpp"
#include "device/udev_rules.hpp"
#include "engine/base/printable.hpp"

namespace touchable {
namespace {

constexpr const char* simulated_words = "a handle that a scripted hand holds, in a run without a window";

std::string ids_in_words(const ConnectedDevice& device) {
    constexpr const char* digits = "0123456789abcdef";
    std::string words;
    for (const int id : {int{device.vendor}, int{device.product}}) {
        if (!words.empty()) words += ':';
        for (int shift = 12; shift >= 0; shift -= 4) words += digits[id >> shift & 15];
    }
    return words;
}

std::string listed(const std::vector<std::string>& items) {
    std::string words;
    for (const std::string& item : items) words += (words.empty() ? "" : ", ") + printable(item);
    return words;
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
    if (!device.held_by.empty()) words += "    open in: " + listed(device.held_by) + "\n";
    if (device.ready) return words + "    ready\n";
    if (device.next.empty()) return words;
    words +=
        (device.why_not.empty() ? "    not ready; do:  " : "    instead: ") + printable(device.next, 400);
    if (!device.why_not.empty() && device.next.ends_with("the device network"))
        words += " (" + naming + "network)";
    return words + '\n';
}

}  // namespace

std::string devices_in_words(const std::vector<ConnectedDevice>& devices, const std::string& naming) {
    if (devices.empty())
        return std::string(
                   "No device that is known here is connected: plug one in and switch it on. Most have to be "
                   "permitted, once for all of them:\n    ") +
               udev_rules_command + "\nNone is needed: any program can be the hand (" + naming +
               "network), and in the window the mouse is (touchable play).\n";
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
