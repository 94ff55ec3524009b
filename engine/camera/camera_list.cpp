#include "engine/camera/camera_list.hpp"

#include <algorithm>
#include <vector>

#include "engine/base/printable.hpp"
#include "engine/camera/node_facts.hpp"

namespace touchable {
namespace {

constexpr std::size_t most_modes = 8;  // of a format, on a screen

const NodeFormat* first_format(const NodeFacts& facts, bool (*is_one)(std::uint32_t)) {
    const auto found = std::find_if(facts.formats.begin(), facts.formats.end(),
                                    [is_one](const NodeFormat& format) { return is_one(format.code); });
    return found == facts.formats.end() ? nullptr : &*found;
}

bool has_depth(const NodeFacts& facts) {
    return first_format(facts, is_depth_format) != nullptr;
}
bool has_colour(const NodeFacts& facts) {
    return !has_depth(facts) && first_format(facts, is_colour_format) != nullptr;
}

std::string format_line(const NodeFormat& format) {
    std::string line = "    " + format_text(format.code);
    line.resize(std::max<std::size_t>(line.size() + 2, 12), ' ');
    for (std::size_t k = 0; k < std::min(format.modes.size(), most_modes); ++k)
        line += (k == 0 ? "" : "; ") + mode_text(format.modes[k]);
    if (format.modes.size() > most_modes)
        line += "; and " + std::to_string(format.modes.size() - most_modes) + " more sizes";
    if (format.modes.empty()) line += "its driver does not say which sizes";
    if (format.any_size) line += "; and sizes between";
    return line + '\n';
}

/// How to touch it, with the colour of the same camera where there is one.
std::string touch_line(const NodeFacts& facts, const std::vector<NodeFacts>& all, const HowToTouch& how) {
    const auto beside = std::find_if(all.begin(), all.end(), [&](const NodeFacts& other) {
        return has_colour(other) && !other.bus.empty() && other.bus == facts.bus;
    });
    const std::string camera = "v4l2:" + facts.node;
    return how(camera, beside == all.end() ? "" : camera + ",colour=" + beside->node);
}

std::string node_lines(const NodeFacts& facts, const std::vector<NodeFacts>& all, const HowToTouch& how) {
    std::string words = facts.node + "  " + printable(facts.card) + " (" + printable(facts.driver) +
                        (facts.bus.empty() ? "" : ", " + printable(facts.bus)) + ")\n";
    for (const NodeFormat& format : facts.formats) words += format_line(format);
    if (has_depth(facts)) return words + touch_line(facts, all, how);
    if (!facts.captures) return words + "    gives no pictures: a node of metadata or of another kind\n";
    return words + (has_colour(facts) ? "    colour alone: there is nothing to touch\n"
                                      : "    nothing that can be touched (Z16, Y16) or shown\n");
}

/// Of cameras that have depth, and do not show it here.
std::string missing_depth(const std::vector<NodeFacts>& all) {
    const auto is_realsense = [](const NodeFacts& facts) {
        return facts.card.find("RealSense") != std::string::npos;
    };
    const bool any = std::any_of(all.begin(), all.end(), is_realsense);
    const bool shown = std::any_of(all.begin(), all.end(), [&](const NodeFacts& facts) {
        return is_realsense(facts) && has_depth(facts);
    });
    if (!any || shown) return {};
    return "The RealSense has no node of depth (Z16): the driver uvcvideo of this kernel may not know its "
           "formats. Intel's librealsense has the patches for it "
           "(scripts/patch-realsense-ubuntu-lts-hwe.sh), "
           "and the rules for its permissions (scripts/setup_udev_rules.sh).\n";
}

}  // namespace

std::string cameras_in_words(VideoSystem& system, const HowToTouch& how) {
    const std::vector<std::string> nodes = system.nodes();
    if (nodes.empty())
        return "No camera is there (no /dev/video*): plug one in. Where one is plugged in, its driver is "
               "missing: sudo modprobe uvcvideo is that of USB cameras.\n";
    std::vector<NodeFacts> all;
    std::string closed, words;
    for (const std::string& node : nodes) {
        auto facts = look_at_node(system, node);
        if (facts)
            all.push_back(std::move(*facts));
        else
            closed += facts.error().message + '\n';
    }
    for (const NodeFacts& facts : all) words += node_lines(facts, all, how);
    words += closed + missing_depth(all);
    if (closed.empty() && std::none_of(all.begin(), all.end(), has_depth))
        words += "None of them gives depth (Z16, or Y16) that can be touched.\n";
    return words;
}

}  // namespace touchable
