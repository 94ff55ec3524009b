#include "engine/authoring/segment_names.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "engine/authoring/segment_json.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

using NamesNode = checked_json::Node;
using NamesJson = nlohmann::ordered_json;

constexpr int format_version = 1;
constexpr std::size_t most_segments = 65535;
constexpr std::pair<const char*, bool> said_by_whom[] = {{"guess", true}, {"hand", false}};
constexpr double stiffest_segment = 10, roughest_segment = 10;  // N/mm, coefficient

double number_between(const NamesNode& node, double least, double most, const char* right) {
    const double number = node.number();
    if (!(number >= least && number <= most)) node.refuse(right);
    return number;
}

/// Values that are said beside a material, or in its place.
void read_feel(const NamesNode& node, NamedSegment& segment) {
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
            1000 * number_between(node["stiffness"], 0.001, stiffest_segment, "from 0.001 to 10 N/mm");
    if (node.has("static_friction"))
        properties.static_friction =
            number_between(node["static_friction"], 0, roughest_segment, "from 0 to 10");
    if (node.has("dynamic_friction"))
        properties.dynamic_friction =
            number_between(node["dynamic_friction"], 0, roughest_segment, "from 0 to 10");
    if (properties.dynamic_friction > properties.static_friction)
        node.refuse("of a dynamic_friction that is not above static_friction");
    if (node.has("relief")) segment.feel.relief = static_cast<int>(node["relief"].integer(0, 400));
}

/// One place, or a list of them.
std::vector<PixelOfFrame> read_places(const NamesNode& node) {
    const auto first = node.element(0);
    if (!first || first->size() < 2) return {segment_json::read_place(node)};
    std::vector<PixelOfFrame> places;
    for (const NamesNode& place : node.elements(1, most_segments, "a list of places"))
        places.push_back(segment_json::read_place(place));
    return places;
}

NamedSegment read_segment(const NamesNode& node) {
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
    if (node.has("index")) segment.index = static_cast<int>(node["index"].integer(0, 255));
    return segment;
}

SegmentNames read_names(const NamesNode& node, std::string_view where) {
    node.allow_only({"touchable_segments", "otherwise", "cuts", "segments"});
    if (node["touchable_segments"].integer(1, 1'000'000) != format_version)
        node["touchable_segments"].refuse("1, the version that is read here");
    SegmentNames names;
    names.said_by = where;
    if (node.has("otherwise")) {
        names.otherwise = node["otherwise"].text();
        if (find_material(names.otherwise) == nullptr) node["otherwise"].refuse("one of " + material_names());
    }
    if (node.has("cuts"))
        for (const NamesNode& cut : node["cuts"].elements(0, most_cuts, "a list of up to 1000 cuts"))
            names.cuts.push_back(segment_json::read_cut(cut));
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
    for (const PixelOfFrame& at : segment.at) places.push_back(segment_json::write_place(at));
    if (!places.empty()) json["at"] = places.size() == 1 ? places.front() : places;
    if (segment.index) json["index"] = *segment.index;
    return json;
}

}  // namespace

Result<SegmentNames> parse_segment_names(std::string_view json, std::string_view where) {
    const auto refusal = [&](const std::string& message) {
        return input_error(std::string(where) + ": " + message);
    };
    try {
        const checked_json::Json text = checked_json::parse(json, largest_segment_names);
        return read_names(NamesNode(text, ""), where);
    } catch (const checked_json::Refusal& reason) {
        return refusal(reason.message);
    } catch (const checked_json::Json::exception& fault) {
        return refusal(fault.what());
    }
}

std::string segment_names_to_json(const SegmentNames& names) {
    const auto in_ascii = [](const NamesJson& json) {
        return json.dump(-1, ' ', true, NamesJson::error_handler_t::replace);
    };
    // A line for each segment, so that a person finds it.
    std::string text = "{\"touchable_segments\": " + std::to_string(format_version);
    if (!names.otherwise.empty()) text += ",\n \"otherwise\": " + in_ascii(names.otherwise);
    if (!names.cuts.empty()) text += ",\n \"cuts\": [";
    for (const SegmentCut& cut : names.cuts)
        text += (&cut == &names.cuts.front() ? "\n  " : ",\n  ") + in_ascii(segment_json::write_cut(cut));
    if (!names.cuts.empty()) text += "\n ]";
    text += ",\n \"segments\": [";
    const char* between = "\n  ";
    for (const NamedSegment& segment : names.segments) {
        text += between + in_ascii(write_segment(segment));
        between = ",\n  ";
    }
    return text + "\n ]}\n";
}

}  // namespace touchable
