// SPDX-License-Identifier: Apache-2.0
#include "engine/authoring/segments.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "engine/authoring/segment_parts.hpp"
#include "engine/base/words.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {

namespace {

constexpr double hard = as_stiff_as_the_device;
constexpr std::string_view limit = "as stiff as the device can", estimate = "estimate";

// Friction from HaTT is that of a hand-held tool's sliding tip: the median of its materials of a kind. HaTT
// has no static friction: that is estimated as four thirds of the dynamic one.
constexpr std::array<PaletteMaterial, 20> materials{{
    {"wood", hard, 0.29, 0.216, 100, limit, "HaTT: MDF, painted, stained and plain wood"},
    {"metal", hard, 0.36, 0.268, 40, limit, "HaTT: aluminium (2), mesh, shelving, textured metal"},
    {"glass", hard, 0.18, 0.137, 0, limit, "estimate: HaTT's glazed ceramic"},
    {"ceramic", hard, 0.18, 0.137, 30, limit, "HaTT: ceramic"},
    {"plastic", hard, 0.27, 0.206, 40, limit, "HaTT: ABS, acrylic (2), plastic mesh (2)"},
    {"paper", 1.2, 0.32, 0.24, 20, estimate, "HaTT: paper of 10 kinds"},
    {"cardboard", 1, 0.37, 0.28, 50, estimate, "HaTT: cardboard, gift box"},
    {"cloth", 0.5, 0.41, 0.307, 100, estimate, "HaTT: cotton, denim, silk and other cloth (10)"},
    {"felt", 0.5, 0.6, 0.447, 60, estimate, "HaTT: felt"},
    {"leather", 0.8, 0.53, 0.398, 100, estimate, "HaTT: fronts of leather (2)"},
    {"rubber", 1.1, 0.82, 0.612, 50, "flat punch of 4 mm radius, E 0.1 MPa", "HaTT: textured rubber"},
    {"foam", 0.22, 1.21, 0.911, 80, "flat punch of 4 mm radius, E 25 kPa",
     "HaTT: EPDM, pink and polyethylene foam"},
    {"cork", 1.5, 0.77, 0.578, 100, estimate, "HaTT: cork"},
    {"skin", 0.3, 0.61, 0.46, 60, estimate, "Zhang and Mak 1999: mean of all measurements"},
    {"stone", hard, 0.93, 0.699, 120, limit, "HaTT: stone tile (2)"},
    {"brick", hard, 0.68, 0.509, 150, limit, "HaTT: brick (2), painted brick"},
    {"carpet", 0.4, 1.34, 1.003, 150, estimate, "HaTT: carpet (4)"},
    {"fur", 0.15, 0.72, 0.54, 80, estimate, "estimate: HaTT's blanket, fleece, towel, velvet"},
    {"grass", 0.2, 1.48, 1.111, 150, estimate, "HaTT: artificial grass"},
    {"water", 0.05, 0.03, 0.02, 0, estimate, "estimate"},
}};

/// All materials, separated by commas.
std::string material_names() {
    return listed(materials, &PaletteMaterial::name);
}

constexpr std::int64_t last_pixel = 16383, last_frame = 999'999'999;
constexpr std::size_t most_points = 10000;

using NamesJson = nlohmann::ordered_json;

constexpr std::size_t most_segments = 65535;
constexpr std::pair<const char*, bool> said_by_whom[] = {{"guess", true}, {"hand", false}};
constexpr double stiffest_segment = 10, roughest_segment = 10;  // N/mm, coefficient

/// Reads a material, or values beside it or in its place.
void read_feel(const checked_json::Node& node, NamedSegment& segment) {
    HapticProperties& properties = segment.feel.properties;
    if (node.has("material")) {
        segment.material = node["material"].text();
        const PaletteMaterial* const found = find_material(segment.material);
        if (found == nullptr) node["material"].refuse("one of " + material_names());
        segment.feel = found->feel();
    } else if (!(node.has("stiffness") && node.has("static_friction") && node.has("dynamic_friction"))) {
        node.refuse("of a material, or of stiffness, static_friction and dynamic_friction");
    }
    if (node.has("stiffness"))
        properties.stiffness =
            1000 * node["stiffness"].within(0.001, stiffest_segment, "from 0.001 to 10 N/mm");
    if (node.has("static_friction"))
        properties.static_friction = node["static_friction"].within(0, roughest_segment, "from 0 to 10");
    if (node.has("dynamic_friction"))
        properties.dynamic_friction = node["dynamic_friction"].within(0, roughest_segment, "from 0 to 10");
    if (properties.dynamic_friction > properties.static_friction)
        node.refuse("of a dynamic_friction that is not above static_friction");
    if (node.has("relief")) segment.feel.relief = node["relief"].whole(0, 400);
}

/// One place, or a list of them.
std::vector<PixelOfFrame> read_places(const checked_json::Node& node) {
    const auto first = node.element(0);
    if (!first || first->size() < 2) return {read_place(node)};
    std::vector<PixelOfFrame> places;
    for (const checked_json::Node& place : node.elements(1, most_segments, "a list of places"))
        places.push_back(read_place(place));
    return places;
}

NamedSegment read_segment(const checked_json::Node& node) {
    node.allow_only({"name", "material", "at", "index", "stiffness", "static_friction", "dynamic_friction",
                     "relief", "by"});
    NamedSegment segment;
    segment.name = node["name"].text();
    if (segment.name.empty()) node["name"].refuse("a name");
    segment.kind = ErrorKind::input;
    read_feel(node, segment);
    if (node.has("by")) segment.is_guess = node["by"].one_of(said_by_whom);
    if (node.has("at") == node.has("index"))
        node.refuse("of either at, a pixel of the segment, or index, its value in a map");
    if (node.has("at")) segment.at = read_places(node["at"]);
    if (node.has("index")) segment.index = node["index"].whole(0, 255);
    return segment;
}

SegmentNames read_names(const checked_json::Node& node, std::string_view where) {
    node.allow_only({"touchable_segments", "otherwise", "cuts", "segments"});
    node.check_version("touchable_segments");
    SegmentNames names;
    names.said_by = where;
    if (node.has("otherwise")) {
        names.otherwise = node["otherwise"].text();
        if (find_material(names.otherwise) == nullptr) node["otherwise"].refuse("one of " + material_names());
    }
    if (node.has("cuts"))
        for (const checked_json::Node& cut : node["cuts"].elements(0, most_cuts, "a list of up to 1000 cuts"))
            names.cuts.push_back(read_cut(cut));
    const auto segments = node["segments"].elements(0, most_segments, "a list of up to 65535 segments");
    for (std::size_t k = 0; k < segments.size(); ++k) {
        names.segments.push_back(read_segment(segments[k]));
        names.segments.back().said_by = std::string(where) + ": segments[" + std::to_string(k) + "]";
    }
    return names;
}

NamesJson write_segment(const NamedSegment& segment) {
    NamesJson json = {{"name", segment.name}};
    const PaletteMaterial* const known = find_material(segment.material);
    if (known != nullptr) json["material"] = segment.material;
    if (known == nullptr || !(known->feel() == segment.feel)) {
        json["stiffness"] = segment.feel.properties.stiffness / 1000;
        json["static_friction"] = segment.feel.properties.static_friction;
        json["dynamic_friction"] = segment.feel.properties.dynamic_friction;
        json["relief"] = segment.feel.relief;
    }
    if (segment.is_guess) json["by"] = "guess";
    NamesJson places = NamesJson::array();
    for (const PixelOfFrame& at : segment.at) places.push_back(write_place(at));
    if (!places.empty()) json["at"] = places.size() == 1 ? places.front() : places;
    if (segment.index) json["index"] = *segment.index;
    return json;
}

}  // namespace

std::span<const PaletteMaterial> palette() {
    return materials;
}

const PaletteMaterial* find_material(std::string_view name) {
    return named_in(materials, name, &PaletteMaterial::name);
}

std::string no_such_material(std::string_view name) {
    std::vector<std::string> names;
    for (const PaletteMaterial& material : materials) names.emplace_back(material.name);
    const std::string meant = nearest_word(name, names);
    return in_quotes(name) + " is no material" + (meant.empty() ? "" : " (" + meant + "?)") +
           "; must be one of " + material_names();
}

PixelOfFrame read_place(const checked_json::Node& node) {
    const auto numbers = node.elements(2, 3, "[X, Y] or [X, Y, FRAME]");
    PixelOfFrame place;
    place.x = numbers[0].whole(0, last_pixel);
    place.y = numbers[1].whole(0, last_pixel);
    if (numbers.size() == 3) place.frame = numbers[2].integer(0, last_frame);
    return place;
}

nlohmann::ordered_json write_place(const PixelOfFrame& place) {
    return {place.x, place.y, place.frame};
}

SegmentCut read_cut(const checked_json::Node& node) {
    node.allow_only({"frame", "stroke"});
    SegmentCut cut;
    cut.frame = node["frame"].integer(0, last_frame);
    for (const checked_json::Node& point :
         node["stroke"].elements(2, most_points, "a list of 2 to 10000 points, [X, Y] each")) {
        const auto numbers = point.elements(2, 2, "[X, Y]");
        cut.stroke.push_back({numbers[0].whole(0, last_pixel), numbers[1].whole(0, last_pixel)});
    }
    return cut;
}

nlohmann::ordered_json write_cut(const SegmentCut& cut) {
    nlohmann::ordered_json stroke = nlohmann::ordered_json::array();
    for (const SegmentCut::Point& point : cut.stroke)
        stroke.push_back(nlohmann::ordered_json::array({point.x, point.y}));
    nlohmann::ordered_json json;
    json["frame"] = cut.frame;
    json["stroke"] = std::move(stroke);
    return json;
}

Result<SegmentNames> parse_segment_names(std::string_view json, std::string_view where) {
    return checked_json::read_checked(
        json, largest_segment_names, where,
        [&](const checked_json::Node& node) { return read_names(node, where); });
}

std::string segment_names_to_json(const SegmentNames& names) {
    const auto in_ascii = [](const NamesJson& json) {
        return json.dump(-1, ' ', true, NamesJson::error_handler_t::replace);
    };
    // A line for each cut and each segment, so that a person finds it.
    const auto lines = [&](const auto& list, auto write) {
        std::string all;
        for (const auto& each : list) all += (all.empty() ? "\n  " : ",\n  ") + in_ascii(write(each));
        return all;
    };
    std::string text = "{\"touchable_segments\": 1";
    if (!names.otherwise.empty()) text += ",\n \"otherwise\": " + in_ascii(names.otherwise);
    if (!names.cuts.empty()) text += ",\n \"cuts\": [" + lines(names.cuts, write_cut) + "\n ]";
    return text + ",\n \"segments\": [" + lines(names.segments, write_segment) + "\n ]}\n";
}

}  // namespace touchable
