#include "engine/scene/scene_file.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

namespace touchable {
namespace {

using Json = nlohmann::json;

constexpr std::size_t largest_text = 1 << 20;

/// Thrown and caught within this file only.
struct Refusal {
    std::string message;
};

/// Text as it can stand in a message: quoted, control characters escaped, whatever its bytes.
std::string quoted(const std::string& text) {
    return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string list(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
    return text;
}

// --- text to JSON
// -------------------------------------------------------------------------------------------------

/// Reads characters for the parser and leaves behind how far it has come, which the parser itself does not
/// tell.
struct CountingIterator {
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    const char* at;
    const char** furthest;

    reference operator*() const { return *at; }
    CountingIterator& operator++() {
        *furthest = std::max(*furthest, ++at);
        return *this;
    }
    bool operator==(const CountingIterator& other) const { return at == other.at; }
    bool operator!=(const CountingIterator& other) const { return at != other.at; }
};

std::string position(std::string_view text, const char* at) {
    const auto line = 1 + std::count(text.data(), at, '\n');
    return "line " + std::to_string(line) + ", byte " + std::to_string(at - text.data());
}

/// JSON of which no object has a member twice.
Json parse_text(std::string_view text) {
    if (text.size() > largest_text)
        throw Refusal{"the text is " + std::to_string(text.size()) + " bytes long: must be at most " +
                      std::to_string(largest_text)};
    const char* furthest = text.data();
    std::vector<std::set<std::string>> members;  // of each object around the place read
    const auto watch = [&](int, Json::parse_event_t event, Json& value) {
        if (event == Json::parse_event_t::object_start) members.emplace_back();
        if (event == Json::parse_event_t::object_end) members.pop_back();
        if (event == Json::parse_event_t::key && !members.back().insert(value.get<std::string>()).second)
            throw Refusal{position(text, furthest) + ": member " + value.dump() + " is given twice"};
        return true;
    };
    try {
        return Json::parse(CountingIterator{text.data(), &furthest},
                           CountingIterator{text.data() + text.size(), &furthest}, watch);
    } catch (const Json::exception& fault) {
        const std::string what = fault.what();  // "[json.exception...] parse error at ...: the reason"
        const std::size_t reason = what.find(": ");
        throw Refusal{position(text, furthest) +
                      ": must be JSON: " + what.substr(reason == std::string::npos ? 0 : reason + 2)};
    }
}

// --- JSON to a scene
// ----------------------------------------------------------------------------------------------

/// A value and its path, such as depth.invalid[1]. Every question about it answers or refuses.
class Node {
public:
    Node(const Json& value, std::string path) : value_(value), path_(std::move(path)) {}

    [[noreturn]] void refuse(const std::string& right) const {
        std::string shown = value_.dump(-1, ' ', false, Json::error_handler_t::replace);
        if (shown.size() > 60) shown = shown.substr(0, 60) + "...";
        throw Refusal{(path_.empty() ? "the scene" : path_) + " is " + shown + ": must be " + right};
    }

    /// This is an object with no members but these.
    void members(const std::vector<std::string>& legal) const {
        if (!value_.is_object()) refuse("an object {...} with members " + list(legal));
        for (const auto& item : value_.items())
            if (std::find(legal.begin(), legal.end(), item.key()) == legal.end())
                throw Refusal{"unknown member " + quoted(member_path(item.key())) + ": " +
                              (path_.empty() ? "a scene" : path_) + " may have " + list(legal)};
    }

    bool is_object() const { return value_.is_object(); }
    bool has(const char* member) const { return value_.contains(member); }

    Node operator[](const char* member) const {
        if (!has(member)) throw Refusal{member_path(member) + " is missing"};
        return {value_.at(member), member_path(member)};
    }

    double number() const {
        if (!value_.is_number()) refuse("a number");
        return value_.get<double>();
    }

    std::int64_t integer(std::int64_t least, std::int64_t most) const {
        const bool fits =
            value_.is_number_integer() &&
            !(value_.is_number_unsigned() && value_.get<std::uint64_t>() > std::uint64_t{1} << 62);
        const std::int64_t number = fits ? value_.get<std::int64_t>() : 0;
        if (!fits || number < least || number > most)
            refuse("a whole number from " + std::to_string(least) + " to " + std::to_string(most));
        return number;
    }
    int whole() const { return static_cast<int>(integer(0, std::numeric_limits<int>::max())); }

    std::string text() const {
        if (!value_.is_string()) refuse("a string");
        return value_.get<std::string>();
    }

    template <class Choice>
    Choice one_of(const std::vector<std::pair<std::string, Choice>>& choices) const {
        std::vector<std::string> names;
        for (const auto& [name, choice] : choices) {
            if (value_.is_string() && value_.get_ref<const std::string&>() == name) return choice;
            names.push_back(quoted(name));
        }
        refuse("one of " + list(names));
    }

    std::vector<Node> elements(std::size_t least, std::size_t most, const std::string& right) const {
        if (!value_.is_array() || value_.size() < least || value_.size() > most) refuse(right);
        std::vector<Node> nodes;
        for (std::size_t k = 0; k < value_.size(); ++k)
            nodes.emplace_back(value_[k], path_ + "[" + std::to_string(k) + "]");
        return nodes;
    }

private:
    std::string member_path(const std::string& member) const {
        return path_.empty() ? member : path_ + "." + member;
    }

    const Json& value_;
    std::string path_;
};

const std::vector<std::pair<std::string, DepthCodingKind>> coding_names = {
    {"linear", DepthCodingKind::linear},
    {"inverse", DepthCodingKind::inverse},
    {"metric", DepthCodingKind::metric}};
const std::vector<std::pair<std::string, DepthSemantics>> semantics_names = {
    {"range", DepthSemantics::range}, {"planar", DepthSemantics::planar}};
const std::vector<std::pair<std::string, bool>> near_is_high_names = {{"high", true}, {"low", false}};
const std::vector<std::pair<std::string, HeightUnits>> unit_names = {{"levels", HeightUnits::levels},
                                                                     {"world", HeightUnits::world}};
const std::vector<std::pair<std::string, FrameInterpolation>> interpolation_names = {
    {"hold", FrameInterpolation::hold}, {"linear", FrameInterpolation::linear}};

void check_version(const Node& scene) {
    const std::int64_t version =
        scene["touchable_scene"].integer(1, std::numeric_limits<std::int64_t>::max());
    if (version > scene_format_version)
        throw Refusal{"touchable_scene is " + std::to_string(version) +
                      ", a newer format than this program reads: "
                      "must be at most " +
                      std::to_string(scene_format_version)};
}

FrameRate read_rate(const Node& node) {
    const std::vector<Node> terms =
        node.elements(2, 2, "[frames, seconds], two whole numbers such as [30000, 1001]");
    return {terms[0].integer(1, 1'000'000'000), terms[1].integer(1, 1'000'000'000)};
}

Camera read_camera(const Node& node, int width, int height) {
    node.members({"fx", "fy", "cx", "cy", "focal_length", "pixel_width"});
    if (!node.has("focal_length") && !node.has("pixel_width"))
        return {node["fx"].number(),
                std::fabs(node["fy"].number()),  // some data sets flip the rows by a negative fy
                node["cx"].number(), node["cy"].number()};
    node.members({"focal_length", "pixel_width"});
    const double focal_length = node["focal_length"].number(), pixel_width = node["pixel_width"].number();
    if (!(pixel_width > 0.0)) node["pixel_width"].refuse("greater than 0");
    return camera_from_focal_length(focal_length, pixel_width, width, height);
}

void read_invalid_codes(const Node& node, int largest, DepthCoding& depth) {
    for (const Node& code : node.elements(0, DepthCoding::max_invalid_codes, "an array of at most 4 codes"))
        depth.invalid_codes[static_cast<std::size_t>(depth.invalid_code_count++)] =
            static_cast<std::uint16_t>(code.integer(0, largest));
}

void read_depth(const Node& node, Scene& scene) {
    DepthCoding& depth = scene.depth;
    node.members({"coding", "semantics", "near", "far", "scale", "bits", "code_max", "near_is", "invalid"});
    depth.kind = node["coding"].one_of(coding_names);
    const bool metric = depth.kind == DepthCodingKind::metric;
    depth.semantics = depth.kind == DepthCodingKind::linear ? DepthSemantics::range : DepthSemantics::planar;
    if (node.has("semantics")) depth.semantics = node["semantics"].one_of(semantics_names);
    if (metric && node.has("near_is")) node["near_is"].refuse("left out: a metric depth grows with its code");
    if (!metric && node.has("scale")) node["scale"].refuse("left out: only a metric coding has a scale");
    if (node.has("near_is")) depth.near_is_high = node["near_is"].one_of(near_is_high_names);

    scene.depth_bits = node.has("bits") ? static_cast<int>(node["bits"].integer(8, 16)) : metric ? 16 : 8;
    const int largest = (1 << scene.depth_bits) - 1;
    depth.code_max =
        static_cast<std::uint16_t>(node.has("code_max") ? node["code_max"].integer(1, largest) : largest);
    if (node.has("invalid")) read_invalid_codes(node["invalid"], largest, depth);

    if (metric) depth.scale = node["scale"].number();
    if (!metric || node.has("near")) depth.near = node["near"].number();
    scene.far_from_frames = metric && !node.has("far");
    depth.far = scene.far_from_frames ? depth.scale * depth.code_max : node["far"].number();
}

void read_height_map(const Node& node, HeightCoding& height) {
    node.members({"max", "units", "bits"});
    height.max_height = node["max"].number();
    if (node.has("units")) height.units = node["units"].one_of(unit_names);
    if (node.has("bits"))
        height.code_max = static_cast<std::uint16_t>((1 << node["bits"].integer(8, 16)) - 1);
}

void read_range(const Node& haptic, const char* member, PropertyRange& range) {
    if (!haptic.has(member)) return;
    const std::vector<Node> ends = haptic[member].elements(2, 2, "[minimum, maximum]");
    range = {ends[0].number(), ends[1].number()};
}

void read_haptic(const Node& node, HapticRanges& haptic) {
    node.members({"stiffness", "static_friction", "dynamic_friction"});
    read_range(node, "stiffness", haptic.stiffness);
    read_range(node, "static_friction", haptic.static_friction);
    read_range(node, "dynamic_friction", haptic.dynamic_friction);
}

void read_default_properties(const Node& node, HapticProperties& properties) {
    node.members({"stiffness", "stiffness_n_per_m", "static_friction", "dynamic_friction"});
    if (node.has("stiffness") && node.has("stiffness_n_per_m"))
        node["stiffness_n_per_m"].refuse("left out where stiffness (in N/mm) is given");
    if (node.has("stiffness")) properties.stiffness = node["stiffness"].number() * 1000.0;
    if (node.has("stiffness_n_per_m")) properties.stiffness = node["stiffness_n_per_m"].number();
    if (node.has("static_friction")) properties.static_friction = node["static_friction"].number();
    if (node.has("dynamic_friction")) properties.dynamic_friction = node["dynamic_friction"].number();
}

void read_filter(const Node& node, FilterSettings& filter) {
    node.members({"median", "fill_holes"});
    if (node.has("median")) filter.median = node["median"].whole();
    if (node.has("fill_holes")) filter.fill_holes = node["fill_holes"].whole();
}

FolderSource read_folder(const Node& node) {
    node.members({"depth", "colour", "haptic", "height", "first", "count"});
    FolderSource folder;
    folder.depth = node["depth"].text();
    if (node.has("colour")) folder.colour = node["colour"].text();
    if (node.has("haptic")) folder.haptic = node["haptic"].text();
    if (node.has("height")) folder.height = node["height"].text();
    if (node.has("first")) folder.first = node["first"].whole();
    if (node.has("count")) folder.count = node["count"].whole();
    return folder;
}

Scene read_scene(const Node& node) {
    if (node.is_object()) check_version(node);  // before its members, which a newer format may well add to
    node.members({"touchable_scene", "name", "width", "height", "rate", "metres_per_unit", "camera", "depth",
                  "height_map", "haptic", "default_properties", "filter", "interpolation",
                  "device_metres_per_unit", "folder"});
    Scene scene;
    if (node.has("name")) scene.name = node["name"].text();
    scene.width = node["width"].whole();
    scene.height = node["height"].whole();
    if (node.has("rate")) scene.rate = read_rate(node["rate"]);
    if (node.has("metres_per_unit")) scene.metres_per_unit = node["metres_per_unit"].number();
    scene.camera = read_camera(node["camera"], scene.width, scene.height);
    read_depth(node["depth"], scene);
    if (node.has("height_map")) read_height_map(node["height_map"], scene.height_coding);
    if (node.has("haptic")) read_haptic(node["haptic"], scene.haptic);
    if (node.has("default_properties"))
        read_default_properties(node["default_properties"], scene.default_properties);
    if (node.has("filter")) read_filter(node["filter"], scene.filter);
    if (node.has("interpolation")) scene.interpolation = node["interpolation"].one_of(interpolation_names);
    if (node.has("device_metres_per_unit"))
        scene.device_metres_per_unit = node["device_metres_per_unit"].number();
    if (node.has("folder")) scene.folder = read_folder(node["folder"]);
    return scene;
}

// --- a scene to JSON
// ----------------------------------------------------------------------------------------------

/// Members stay in the order a person would write them.
using OrderedJson = nlohmann::ordered_json;

template <class Choice>
std::string name_of(const std::vector<std::pair<std::string, Choice>>& choices, Choice sought) {
    for (const auto& [name, choice] : choices)
        if (choice == sought) return name;
    return {};
}

OrderedJson write_depth(const Scene& scene) {
    const DepthCoding& depth = scene.depth;
    const bool metric = depth.kind == DepthCodingKind::metric;
    OrderedJson json = {{"coding", name_of(coding_names, depth.kind)},
                        {"semantics", name_of(semantics_names, depth.semantics)}};
    if (metric) json["scale"] = depth.scale;
    json["near"] = depth.near;
    if (!scene.far_from_frames) json["far"] = depth.far;
    json["bits"] = scene.depth_bits;
    json["code_max"] = depth.code_max;
    if (!metric) json["near_is"] = name_of(near_is_high_names, depth.near_is_high);
    json["invalid"] =
        std::vector<int>(depth.invalid_codes.begin(), depth.invalid_codes.begin() + depth.invalid_code_count);
    return json;
}

OrderedJson write_height_map(const HeightCoding& height) {
    int bits = 8;
    while ((1 << bits) - 1 < height.code_max) ++bits;
    return {{"max", height.max_height}, {"units", name_of(unit_names, height.units)}, {"bits", bits}};
}

OrderedJson write_range(const PropertyRange& range) {
    return OrderedJson::array({range.min, range.max});
}

OrderedJson write_default_properties(const HapticProperties& properties) {
    // Not every double in N/m is a thousand times a double; those are written in N/m.
    OrderedJson json;
    const double in_n_per_mm = properties.stiffness / 1000.0;
    if (in_n_per_mm * 1000.0 == properties.stiffness)
        json["stiffness"] = in_n_per_mm;
    else
        json["stiffness_n_per_m"] = properties.stiffness;
    json["static_friction"] = properties.static_friction;
    json["dynamic_friction"] = properties.dynamic_friction;
    return json;
}

OrderedJson write_folder(const FolderSource& folder) {
    OrderedJson json = {{"depth", folder.depth}};
    if (!folder.colour.empty()) json["colour"] = folder.colour;
    if (!folder.haptic.empty()) json["haptic"] = folder.haptic;
    if (!folder.height.empty()) json["height"] = folder.height;
    json["first"] = folder.first;
    json["count"] = folder.count;
    return json;
}

}  // namespace

Result<Scene> parse_scene(std::string_view json, std::string_view where) {
    const auto refusal = [&](const std::string& message) {
        return input_error(std::string(where) + ": " + message);
    };
    Scene scene;
    try {
        const Json text = parse_text(json);
        scene = read_scene(Node(text, ""));
    } catch (const Refusal& reason) {
        return refusal(reason.message);
    } catch (const Json::exception& fault) {
        return refusal(fault.what());
    }
    if (const auto valid = validate(scene); !valid) return refusal(valid.error().message);
    derive_valid_range(scene.depth);
    return scene;
}

Result<Scene> read_scene_file(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string text(largest_text + 1, '\0');
    if (stream) stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!stream && !stream.eof())
        return input_error(file.string() +
                           ": cannot be read: must be a scene file (JSON, docs/scene_file.md)");
    text.resize(static_cast<std::size_t>(stream.gcount()));
    return parse_scene(text, file.string());
}

std::string scene_to_json(const Scene& scene) {
    OrderedJson json = {
        {"touchable_scene", scene_format_version},
        {"name", scene.name},
        {"width", scene.width},
        {"height", scene.height},
        {"rate", {scene.rate.num, scene.rate.den}},
        {"metres_per_unit", scene.metres_per_unit},
        {"camera",
         {{"fx", scene.camera.fx},
          {"fy", scene.camera.fy},
          {"cx", scene.camera.cx},
          {"cy", scene.camera.cy}}},
        {"depth", write_depth(scene)},
        {"height_map", write_height_map(scene.height_coding)},
        {"haptic",
         {{"stiffness", write_range(scene.haptic.stiffness)},
          {"static_friction", write_range(scene.haptic.static_friction)},
          {"dynamic_friction", write_range(scene.haptic.dynamic_friction)}}},
        {"default_properties", write_default_properties(scene.default_properties)},
        {"filter", {{"median", scene.filter.median}, {"fill_holes", scene.filter.fill_holes}}},
        {"interpolation", name_of(interpolation_names, scene.interpolation)}};
    if (scene.device_metres_per_unit) json["device_metres_per_unit"] = *scene.device_metres_per_unit;
    if (scene.folder) json["folder"] = write_folder(*scene.folder);
    return json.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

}  // namespace touchable
