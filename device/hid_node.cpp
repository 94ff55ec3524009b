#include "device/hid_node.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <system_error>

namespace touchable {
namespace {

std::optional<std::uint32_t> hexadecimal(std::string_view text) {
    std::uint32_t number = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number, 16);
    if (fault != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
}

/// Of BUS:VENDOR:PRODUCT, all hexadecimal.
bool take_ids(std::string_view text, HidNode& node) {
    const std::size_t first = text.find(':');
    const std::size_t second = first == std::string_view::npos ? first : text.find(':', first + 1);
    if (second == std::string_view::npos) return false;
    const auto bus = hexadecimal(text.substr(0, first));
    const auto vendor = hexadecimal(text.substr(first + 1, second - first - 1));
    const auto product = hexadecimal(text.substr(second + 1));
    if (!bus || !vendor || !product || std::max({*bus, *vendor, *product}) > 0xffff) return false;
    node.bus = static_cast<std::uint16_t>(*bus);
    node.vendor = static_cast<std::uint16_t>(*vendor);
    node.product = static_cast<std::uint16_t>(*product);
    return true;
}

/// hidraw10 comes after hidraw9.
bool comes_before(const HidNode& a, const HidNode& b) {
    return a.node.size() != b.node.size() ? a.node.size() < b.node.size() : a.node < b.node;
}

}  // namespace

std::optional<HidNode> read_hid_uevent(std::string_view text) {
    constexpr std::string_view id = "HID_ID=", name = "HID_NAME=";
    HidNode node;
    bool known = false;
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        if (line.starts_with(id)) known = take_ids(line.substr(id.size()), node);
        if (line.starts_with(name)) node.name = line.substr(name.size());
    }
    return known ? std::optional(node) : std::nullopt;
}

std::vector<HidNode> hid_nodes(const std::filesystem::path& root) {
    std::vector<HidNode> nodes;
    std::error_code ignored;
    for (std::filesystem::directory_iterator each(root / "sys/class/hidraw", ignored), end; each != end;
         each.increment(ignored)) {
        std::ifstream in(each->path() / "device/uevent");
        const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
        auto node = read_hid_uevent(text);
        if (!node) continue;
        node->node = "/dev/" + each->path().filename().string();
        nodes.push_back(std::move(*node));
    }
    std::sort(nodes.begin(), nodes.end(), comes_before);
    return nodes;
}

std::optional<HidNode> find_hid_node(
    const std::function<bool(std::uint16_t vendor, std::uint16_t product)>& is_one,
    const std::filesystem::path& root) {
    for (const HidNode& node : hid_nodes(root))
        if (is_one(node.vendor, node.product)) return node;
    return std::nullopt;
}

}  // namespace touchable
