#include "player/window/touch_labels.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/scene/checked_json.hpp"
#include "player/window/plain_line.hpp"

namespace touchable {
namespace {

using LabelNode = checked_json::Node;

constexpr int largest_side = 16384;
constexpr std::size_t most_corners = 1000;

/// A text of any language, or an object of a text for each.
template <class Said>
std::map<std::string, Said> read_said(const LabelNode& node) {
    if (!node.is_object()) return {{"", read_plain_line(node)}};
    std::map<std::string, Said> said;
    for (const std::string& language : node.members()) {
        if (!is_language(language)) node.refuse("an object of languages, such as {\"en\": ..., \"de\": ...}");
        said.emplace(language, read_plain_line(node[language.c_str()]));
    }
    if (said.empty()) node.refuse("a text, or an object of one for each language");
    return said;
}

glm::dvec2 read_corner(const LabelNode& node) {
    const auto numbers = node.elements(2, 2, "a pixel [x, y]");
    const auto at = [](const LabelNode& number) {
        return static_cast<double>(number.integer(0, largest_side));
    };
    return {at(numbers[0]), at(numbers[1])};
}

std::vector<glm::dvec2> read_rectangle(const LabelNode& node) {
    const auto numbers = node.elements(4, 4, "[left, top, right, bottom], pixels");
    double side[4];
    for (std::size_t k = 0; k < 4; ++k) side[k] = static_cast<double>(numbers[k].integer(0, largest_side));
    if (side[0] > side[2] || side[1] > side[3])
        node.refuse("[left, top, right, bottom], right not before left and bottom not above top");
    return {{side[0], side[1]}, {side[2], side[1]}, {side[2], side[3]}, {side[0], side[3]}};
}

void read_place(const LabelNode& node, TouchLabel& label) {
    if (node.has("rectangle") + node.has("polygon") + node.has("segment") != 1)
        node.refuse("of one place: rectangle, polygon or segment");
    if (node.has("rectangle")) label.corners = read_rectangle(node["rectangle"]);
    if (node.has("segment")) label.segment = read_plain_line(node["segment"]);
    if (!node.has("polygon")) return;
    for (const LabelNode& corner : node["polygon"].elements(3, most_corners, "3 to 1000 pixels [x, y]"))
        label.corners.push_back(read_corner(corner));
}

TouchLabel read_label(const LabelNode& node, const std::filesystem::path& folder) {
    node.allow_only({"caption", "sound", "rectangle", "polygon", "segment", "frames"});
    TouchLabel label;
    label.captions = read_said<std::string>(node["caption"]);
    if (node.has("sound"))
        for (auto& [language, file] : read_said<std::filesystem::path>(node["sound"]))
            label.sounds.emplace(language, folder / file);
    read_place(node, label);
    if (!node.has("frames")) return label;
    const auto frames = node["frames"].elements(2, 2, "the first frame and the last, [0, 99]");
    label.first = frames[0].integer(0, std::int64_t{1} << 40);
    label.last = frames[1].integer(0, std::int64_t{1} << 40);
    if (label.last < label.first) node["frames"].refuse("the first frame and the last, in that order");
    return label;
}

/// By how often a line to the right crosses its border; the border itself is inside, half a pixel wide.
bool is_inside_of(const std::vector<glm::dvec2>& corners, const glm::dvec2& at) {
    constexpr double border = 0.5;
    bool is_inside = false;
    for (std::size_t k = 0; k < corners.size(); ++k) {
        const glm::dvec2 a = corners[k], b = corners[(k + 1) % corners.size()], way = b - a, off = at - a;
        const double length2 = way.x * way.x + way.y * way.y;
        const double share =
            length2 > 0 ? std::clamp((off.x * way.x + off.y * way.y) / length2, 0.0, 1.0) : 0.0;
        const glm::dvec2 gap = off - share * way;
        if (gap.x * gap.x + gap.y * gap.y <= border * border) return true;
        if ((a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / way.y * way.x) is_inside = !is_inside;
    }
    return is_inside;
}

std::string name_of_label(const TouchLabels& labels, std::size_t k) {
    return labels.said_by + ": labels[" + std::to_string(k) + "]";
}

}  // namespace

std::optional<std::size_t> TouchLabels::at(const glm::dvec2& pixel, std::int64_t frame,
                                           std::string_view segment) const {
    for (std::size_t k = 0; k < labels.size(); ++k) {
        const TouchLabel& label = labels[k];
        if (frame < label.first || frame > label.last) continue;
        if (label.segment.empty() ? is_inside_of(label.corners, pixel) : label.segment == segment) return k;
    }
    return std::nullopt;
}

Result<void> TouchLabels::fits(int width, int height, std::int64_t frames) const {
    for (std::size_t k = 0; k < labels.size(); ++k) {
        for (const glm::dvec2& corner : labels[k].corners)
            if (corner.x >= width || corner.y >= height)
                return input_error(name_of_label(*this, k) + " reaches pixel " +
                                   std::to_string(static_cast<int>(corner.x)) + ", " +
                                   std::to_string(static_cast<int>(corner.y)) + ": the clip is " +
                                   std::to_string(width) + "x" + std::to_string(height) +
                                   ", and its pixels begin with 0, 0");
        if (frames > 0 && labels[k].first >= frames)
            return input_error(name_of_label(*this, k) + " begins with frame " +
                               std::to_string(labels[k].first) + ": the clip has " + std::to_string(frames) +
                               ", and the first is 0");
    }
    return {};
}

Result<void> TouchLabels::has_segments(const std::vector<std::string>& names) const {
    for (std::size_t k = 0; k < labels.size(); ++k)
        if (const std::string& name = labels[k].segment;
            !name.empty() && std::ranges::find(names, name) == names.end())
            return input_error(name_of_label(*this, k) + " is of a segment " + in_quotes(name) +
                               ", which no file of segments names");
    return {};
}

Result<TouchLabels> parse_touch_labels(std::string_view json, std::string_view where,
                                       const std::filesystem::path& folder) {
    try {
        const checked_json::Json text = checked_json::parse(json, largest_labels);
        const LabelNode node(text, "");
        node.allow_only({"touchable_labels", "labels"});
        if (node["touchable_labels"].integer(1, 1'000'000) != 1)
            node["touchable_labels"].refuse("1, the version that is read here");
        TouchLabels labels{.labels = {}, .said_by = std::string(where)};
        for (const LabelNode& label : node["labels"].elements(
                 1, most_labels, "a list of 1 to " + std::to_string(most_labels) + " labels"))
            labels.labels.push_back(read_label(label, folder));
        return labels;
    } catch (const checked_json::Refusal& reason) {
        return input_error(std::string(where) + ": " + reason.message);
    }
}

}  // namespace touchable
