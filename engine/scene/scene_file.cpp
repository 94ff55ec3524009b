// SPDX-License-Identifier: Apache-2.0
#include "engine/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

using checked_json::Node;
using OrderedJson = nlohmann::ordered_json;  // members stay in the order a person would write them

/// A value of `depth.coding`: a coding of codes, or of stored values whose coding the frames settle.
struct Coding {
    DepthCodingKind kind;
    StoredDepth::Kind stored = StoredDepth::Kind::codes;
    bool operator==(const Coding&) const = default;
};
constexpr std::pair<const char*, Coding> coding_names[] = {
    {"linear", {DepthCodingKind::linear}},
    {"inverse", {DepthCodingKind::inverse}},
    {"metric", {DepthCodingKind::metric}},
    {"hue", {DepthCodingKind::hue}},
    {"log", {DepthCodingKind::log}},
    {"disparity", {DepthCodingKind::inverse, StoredDepth::Kind::disparity}},
    {"relative", {DepthCodingKind::linear, StoredDepth::Kind::relative}},
    {"relative-inverse", {DepthCodingKind::inverse, StoredDepth::Kind::relative}}};
constexpr std::pair<const char*, bool> byte_order_names[] = {{"plain", false}, {"swapped", true}};
constexpr std::pair<const char*, Packing> packed_names[] = {
    {"plain", Packing::none},      {"rgb24", Packing::rgb24},     {"bgr24", Packing::bgr24},
    {"bgr255", Packing::bgr255},   {"rg16", Packing::rg16},       {"gr16", Packing::gr16},
    {"rgba32f", Packing::rgba32f}, {"bgra32f", Packing::bgra32f}, {"abgr32f", Packing::abgr32f},
    {"half", Packing::half}};
constexpr std::pair<const char*, DepthSemantics> semantics_names[] = {{"range", DepthSemantics::range},
                                                                      {"planar", DepthSemantics::planar}};
constexpr std::pair<const char*, bool> near_is_high_names[] = {{"high", true}, {"low", false}};
constexpr std::pair<const char*, HeightUnits> unit_names[] = {{"levels", HeightUnits::levels},
                                                              {"world", HeightUnits::world}};
constexpr std::pair<const char*, FrameInterpolation> interpolation_names[] = {
    {"hold", FrameInterpolation::hold}, {"linear", FrameInterpolation::linear}};
constexpr std::pair<const char*, VideoLayout> layout_names[] = {{"alone", VideoLayout::alone},
                                                                {"left", VideoLayout::left},
                                                                {"right", VideoLayout::right},
                                                                {"top", VideoLayout::top},
                                                                {"bottom", VideoLayout::bottom}};
constexpr std::pair<const char*, VideoValues> value_names[] = {
    {"grey", VideoValues::grey}, {"mean", VideoValues::mean}, {"hue", VideoValues::hue}};

constexpr std::string_view guess_mark = "guessed: ";
/// Kinds of remarks by how their texts begin, of this and all earlier releases; the first that fits counts.
/// The only place where words of remarks mean something: a scene file holds nothing else of a remark, so that
/// earlier releases can read it. A remark in new words of its own kind needs a new row.
constexpr std::pair<std::string_view, RemarkKind> remark_beginnings[] = {
    {"the median depth is ", RemarkKind::unit_doubt},
    {"guessed: values are lengths, though they are larger", RemarkKind::direction},
    {"guessed: depth is a renderer's depth buffer", RemarkKind::planes},
    {"guessed: depth has no scale", RemarkKind::scale},
    {"guessed: values are heights", RemarkKind::scale},
    {"guessed: red is ", RemarkKind::scale},
    {"guessed: depth goes from ", RemarkKind::scale},
    {"guessed: depth is as LeRobot usually stores it", RemarkKind::scale},
    {"guessed: the camera sees ", RemarkKind::camera},
    {"guessed: the camera is ", RemarkKind::camera},
    {"guessed: a code is ", RemarkKind::unit},
    {"guessed: depth codes are ", RemarkKind::unit},
    {"guessed: values go from plane to plane", RemarkKind::storage},
    {"guessed: the upper third of the picture is nearer", RemarkKind::storage},
    {"guessed: values are ", RemarkKind::unit},
    {"guessed: lengths are metres", RemarkKind::unit},
    {"guessed: its disparities are 1/metres", RemarkKind::unit},
    {"guessed: it is as preset ", RemarkKind::unit},
    {"guessed: depth is as preset ", RemarkKind::storage},
    {"guessed: depth is disparities, as the name says", RemarkKind::storage},
    {"guessed: depth goes along ", RemarkKind::axis},
    {"guessed: colour lies on depth's pixels", RemarkKind::colour_place}};

std::string read_pictures(const Node& node, PictureNumbers& numbers) {
    if (!node.is_object()) return node.text();
    node.allow_only({"files", "first", "step"});
    if (node.has("first")) numbers.first = node["first"].whole();
    if (node.has("step")) numbers.step = node["step"].whole();
    return node["files"].text();
}

OrderedJson write_pictures(const std::string& pattern, const PictureNumbers& numbers) {
    if (!numbers.any()) return pattern;
    OrderedJson json = {{"files", pattern}};
    if (numbers.first) json["first"] = *numbers.first;
    if (numbers.step) json["step"] = *numbers.step;
    return json;
}

/// The member `folder` of a scene file: a plane is a name, or an object of `files`, `first` and `step`.
/// Throws `checked_json::Refusal`.
FolderSource read_folder(const Node& node) {
    node.allow_only({"depth", "colour", "haptic", "height", "cameras", "first", "count"});
    FolderSource folder;
    PictureNumbers of_depth;
    folder.depth = read_pictures(node["depth"], of_depth);
    if (of_depth.first && node.has("first"))
        node["first"].refuse("left out where folder.depth.first is given");
    folder.first = of_depth.first.value_or(0);
    folder.step = of_depth.step.value_or(1);
    if (node.has("colour")) folder.colour = read_pictures(node["colour"], folder.colour_numbers);
    if (node.has("haptic")) folder.haptic = read_pictures(node["haptic"], folder.haptic_numbers);
    if (node.has("height")) folder.height = read_pictures(node["height"], folder.height_numbers);
    if (node.has("cameras")) folder.cameras = read_pictures(node["cameras"], folder.camera_numbers);
    if (node.has("first")) folder.first = node["first"].whole();
    if (node.has("count")) folder.count = node["count"].whole();
    return folder;
}

OrderedJson write_folder(const FolderSource& folder) {
    PictureNumbers of_depth;
    if (folder.step != 1) of_depth.step = folder.step;
    OrderedJson json = {{"depth", write_pictures(folder.depth, of_depth)}};
    if (!folder.colour.empty()) json["colour"] = write_pictures(folder.colour, folder.colour_numbers);
    if (!folder.haptic.empty()) json["haptic"] = write_pictures(folder.haptic, folder.haptic_numbers);
    if (!folder.height.empty()) json["height"] = write_pictures(folder.height, folder.height_numbers);
    if (!folder.cameras.empty()) json["cameras"] = write_pictures(folder.cameras, folder.camera_numbers);
    json["first"] = folder.first;
    json["count"] = folder.count;
    return json;
}

constexpr double stiffest = 1e6;  // N/mm

/// Parses a name that is an index, written as a number is.
int read_index(const Node& materials, const std::string& name) {
    const int index = parsed_as<int>(name).value_or(-1);
    if (name != std::to_string(index) || index < 0 || index > largest_material_index)
        materials.refuse(
            "an object whose names are material indices from 0 to 65535, such as \"1\", and not " +
            in_quotes(name));
    return index;
}

void check(const Node& node, const HapticProperties& properties) {
    const double stiffness = properties.stiffness / 1000;
    if (!(stiffness > 0 && stiffness <= stiffest)) node.refuse("of a stiffness above 0 and at most 1e6 N/mm");
    if (!(properties.dynamic_friction >= 0)) node.refuse("of a dynamic_friction of 0 or more");
    if (!(properties.static_friction >= properties.dynamic_friction))
        node.refuse("of a static_friction (" + OrderedJson(properties.static_friction).dump() +
                    ") that is not below dynamic_friction (" +
                    OrderedJson(properties.dynamic_friction).dump() + ")");
}

/// Widens a range that is not stated to hold `value`; refuses a stated one that does not hold it.
void hold(const Node& haptic, const char* member, bool is_first, double value, PropertyRange& range) {
    if (!haptic.has(member)) {
        range = is_first ? PropertyRange{value, value}
                         : PropertyRange{std::min(range.min, value), std::max(range.max, value)};
    } else if (value < range.min || value > range.max) {
        haptic[member].refuse("a range that holds " + OrderedJson(value).dump() +
                              ", which a material or default_properties has (or be left out)");
    }
}

/// The member `default_properties`, or an entry of `haptic.materials`: what it leaves out stays.
void read_properties(const Node& node, HapticProperties& properties) {
    node.allow_only({"stiffness", "stiffness_n_per_m", "static_friction", "dynamic_friction"});
    if (node.has("stiffness") && node.has("stiffness_n_per_m"))
        node["stiffness_n_per_m"].refuse("left out where stiffness (in N/mm) is given");
    if (node.has("stiffness")) properties.stiffness = node["stiffness"].number() * 1000.0;
    if (node.has("stiffness_n_per_m")) properties.stiffness = node["stiffness_n_per_m"].number();
    if (node.has("static_friction")) properties.static_friction = node["static_friction"].number();
    if (node.has("dynamic_friction")) properties.dynamic_friction = node["dynamic_friction"].number();
}

OrderedJson write_properties(const HapticProperties& properties) {
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

/// The member `haptic.materials`: properties by index. What an entry leaves out comes from `otherwise`. A
/// range that `haptic` does not state becomes that of the materials and of `otherwise`; a stated one must
/// hold them.
std::vector<SceneDescription::Material> read_materials(const Node& haptic, const HapticProperties& otherwise,
                                                       HapticRanges& ranges) {
    const Node node = haptic["materials"];
    const std::vector<std::string> names = node.members();
    if (names.empty() || names.size() > most_materials)
        node.refuse("an object of 1 to 256 materials, such as {\"1\": {\"stiffness\": 0.8}}");
    std::vector<SceneDescription::Material> materials;
    for (const std::string& name : names) {
        SceneDescription::Material material{read_index(node, name), otherwise};
        read_properties(node[name.c_str()], material.properties);
        check(node[name.c_str()], material.properties);
        materials.push_back(material);
    }
    std::ranges::sort(materials, {}, &SceneDescription::Material::index);
    const auto hold_all = [&](const HapticProperties& properties, bool is_first) {
        hold(haptic, "stiffness", is_first, properties.stiffness / 1000, ranges.stiffness);
        hold(haptic, "static_friction", is_first, properties.static_friction, ranges.static_friction);
        hold(haptic, "dynamic_friction", is_first, properties.dynamic_friction, ranges.dynamic_friction);
    };
    hold_all(otherwise, true);
    for (const SceneDescription::Material& material : materials) hold_all(material.properties, false);
    return materials;
}

OrderedJson write_materials(const std::vector<SceneDescription::Material>& materials) {
    OrderedJson json = OrderedJson::object();
    for (const SceneDescription::Material& material : materials)
        json[std::to_string(material.index)] = write_properties(material.properties);
    return json;
}

void check_version(const Node& version) {
    if (version.integer(1, std::numeric_limits<int>::max()) > scene_format_version)
        version.refuse("at most " + std::to_string(scene_format_version) +
                       ": this program is older than the scene's format");
}

FrameRate read_rate(const Node& node) {
    const std::vector<Node> terms =
        node.elements(2, 2, "[frames, seconds], two whole numbers such as [30000, 1001]");
    return {terms[0].whole(), terms[1].whole()};
}

LensDistortion read_distortion(const Node& node) {
    const char* const right = "[k1, k2, p1, p2], with k3 or with k3, k4, k5, k6 behind them";
    const std::vector<Node> terms = node.elements(4, 8, right);
    if (terms.size() == 6 || terms.size() == 7) node.refuse(right);
    LensDistortion lens;
    for (std::size_t k = 0; k < terms.size(); ++k) lens.terms[k] = terms[k].number();
    return lens;
}

Camera read_intrinsics(const Node& node) {
    return {node["fx"].number(),
            std::fabs(node["fy"].number()),  // some data sets flip the rows by a negative fy
            node["cx"].number(), node["cy"].number()};
}

void read_camera(const Node& node, Scene& scene) {
    node.allow_only({"fx", "fy", "cx", "cy", "focal_length", "pixel_width", "distortion"});
    if (node.has("distortion")) scene.lens = read_distortion(node["distortion"]);
    if (!node.has("focal_length") && !node.has("pixel_width")) {
        scene.camera = read_intrinsics(node);
        return;
    }
    node.allow_only({"focal_length", "pixel_width", "distortion"});
    const double focal_length = node["focal_length"].number(), pixel_width = node["pixel_width"].number();
    if (!(pixel_width > 0.0)) node["pixel_width"].refuse("greater than 0");
    scene.camera = camera_from_focal_length(focal_length, pixel_width, scene.width, scene.height);
}

CameraPose read_pose(const Node& node) {
    const char* const right =
        "a matrix of 16 numbers, row by row: a rotation with its translation, then 0, 0, 0, 1";
    const std::vector<Node> terms = node.elements(16, 16, right);
    CameraPose pose;
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 3; ++column)
            pose.rotation[3 * row + column] = terms[4 * row + column].number();
        pose.translation[row] = terms[4 * row + 3].number();
    }
    for (std::size_t k = 12; k < 16; ++k)
        if (terms[k].number() != (k == 15 ? 1 : 0)) node.refuse(right);
    return pose;
}

ColourCamera read_colour_camera(const Node& node) {
    node.allow_only({"width", "height", "fx", "fy", "cx", "cy", "distortion", "from_depth", "to_depth"});
    ColourCamera colour;
    colour.width = node["width"].whole();
    colour.height = node["height"].whole();
    colour.camera = read_intrinsics(node);
    if (node.has("distortion")) colour.lens = read_distortion(node["distortion"]);
    if (node.has("to_depth") && node.has("from_depth"))
        node["to_depth"].refuse("left out where from_depth is given");
    colour.from_depth =
        node.has("to_depth") ? read_pose(node["to_depth"]).inverse() : read_pose(node["from_depth"]);
    return colour;
}

void read_invalid_codes(const Node& node, int largest, DepthCoding& depth) {
    for (const Node& code : node.elements(0, DepthCoding::max_invalid_codes, "an array of at most 4 codes"))
        depth.invalid_codes[static_cast<std::size_t>(depth.invalid_code_count++)] =
            static_cast<std::uint16_t>(code.integer(0, largest));
}

/// Reads how the bits of a stored value are ordered or packed.
void read_order(const Node& node, Scene& scene) {
    if (node.has("bytes")) scene.stored.bytes_swapped = node["bytes"].one_of(byte_order_names);
    if (node.has("rotated")) scene.stored.rotated = node["rotated"].whole(0, 15);
    if (node.has("used_bits")) scene.stored.used_bits = node["used_bits"].whole(8, 16);
    if (node.has("packed")) scene.stored.packed = node["packed"].one_of(packed_names);
    const StoredDepth& stored = scene.stored;
    const bool is_packed = stored.packed != Packing::none;
    if (stored.packed == Packing::rgb24 && scene.depth.kind != DepthCodingKind::metric)
        node["packed"].refuse("left out: 24 bits of whole numbers are of coding metric");
    if (is_packed && (scene.depth.kind == DepthCodingKind::hue || stored.is_reordered()))
        node["packed"].refuse("left out: hues and words in another order are not packed");
    if (!stored.is_reordered()) return;
    if (scene.depth_bits != 16 || scene.depth.kind == DepthCodingKind::hue)
        node[stored.used_bits < 16 ? "used_bits"
             : stored.rotated > 0  ? "rotated"
                                   : "bytes"]
            .refuse("left out: depth.bits is not 16");
}

void read_disparity(const Node& node, Scene& scene) {
    StoredDepth& stored = scene.stored;
    for (const char* settled : {"near", "far", "near_is", "code_max"})
        if (node.has(settled)) node[settled].refuse("left out: disparities in the frames settle it");
    stored.baseline = node["baseline"].number();
    if (node.has("scale")) stored.scale = node["scale"].number();
    if (node.has("offset")) stored.offset = node["offset"].number();
    if (!(stored.baseline > 0)) node["baseline"].refuse("greater than 0");
    if (stored.scale == 0) node["scale"].refuse("other than 0");
    // Placeholders, in the right order, until the frames settle them.
    scene.depth.near = scene.camera.fx * stored.baseline / 65536;
    scene.depth.far = scene.camera.fx * stored.baseline;
}

void read_depth(const Node& node, SceneDescription& described) {
    Scene& scene = described.scene;
    DepthCoding& depth = scene.depth;
    node.allow_only({"coding", "semantics", "near", "far", "scale", "bits", "code_max", "near_is", "shift",
                     "least_sum", "invalid", "baseline", "offset", "bytes", "rotated", "used_bits", "packed",
                     "float_scale"});
    const Coding coding = node["coding"].one_of(coding_names);
    depth.kind = coding.kind;
    scene.stored.kind = coding.stored;
    const bool metric = depth.kind == DepthCodingKind::metric, hue = depth.kind == DepthCodingKind::hue;
    const bool disparity = coding.stored == StoredDepth::Kind::disparity;
    depth.semantics = depth.kind == DepthCodingKind::linear ? DepthSemantics::range : DepthSemantics::planar;
    if (node.has("semantics")) depth.semantics = node["semantics"].one_of(semantics_names);
    if (metric && node.has("near_is")) node["near_is"].refuse("left out: a metric depth grows with its code");
    if (!metric && !disparity && node.has("scale"))
        node["scale"].refuse("left out: only metric depth and disparity have a scale");
    if (!metric && node.has("float_scale"))
        node["float_scale"].refuse("left out: only metric depth has a scale of floats");
    if (node.has("shift")) {
        if (coding != Coding{DepthCodingKind::inverse} && coding != Coding{DepthCodingKind::log})
            node["shift"].refuse("left out: only inverse and log depth have a shift");
        depth.shift = node["shift"].number();
    }
    if (!hue && node.has("least_sum")) node["least_sum"].refuse("left out: only a hue has a least sum");
    depth.near_is_high = !hue;
    if (node.has("near_is")) depth.near_is_high = node["near_is"].one_of(near_is_high_names);

    const bool usually_16 = metric || coding.stored != StoredDepth::Kind::codes;
    scene.depth_bits = node.has("bits") ? node["bits"].whole(8, 16) : usually_16 ? 16 : 8;
    const int largest = hue ? DepthCoding::hue_circle : (1 << scene.depth_bits) - 1;
    depth.code_max =
        static_cast<std::uint16_t>(node.has("code_max") ? node["code_max"].integer(1, largest) : largest);
    if (node.has("invalid")) read_invalid_codes(node["invalid"], largest, depth);

    if (node.has("least_sum")) depth.least_sum = node["least_sum"].whole(0, 3 * 255);
    read_order(node, scene);
    if (disparity) return read_disparity(node, scene);
    if (metric) depth.scale = node["scale"].number();
    if (node.has("float_scale")) scene.float_scale = node["float_scale"].number();
    if (!metric || node.has("near")) depth.near = node["near"].number();
    described.unstated.far = metric && !node.has("far");
    depth.far = described.unstated.far ? depth.scale * depth.code_max : node["far"].number();
}

void read_height_map(const Node& node, HeightCoding& height) {
    node.allow_only({"max", "units", "bits"});
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

void read_haptic(const Node& node, SceneDescription& described) {
    HapticRanges& haptic = described.scene.haptic;
    node.allow_only({"stiffness", "static_friction", "dynamic_friction", "materials"});
    read_range(node, "stiffness", haptic.stiffness);
    read_range(node, "static_friction", haptic.static_friction);
    read_range(node, "dynamic_friction", haptic.dynamic_friction);
    if (node.has("materials"))
        described.materials = read_materials(node, described.scene.default_properties, haptic);
}

DepthLength read_length(const Node& node) {
    const std::vector<Node> terms =
        node.elements(2, 2, "[constant, quadratic], two numbers such as [1.5, 0]");
    return {terms[0].number(), terms[1].number()};
}

DepthLength read_value(const Node& node, const SettingRange& range) {
    if (range.is_length) return read_length(node);
    if (range.has_names()) return {static_cast<double>(node.one_of(range.words))};
    return {range.whole ? node.whole() : node.number()};
}

void read_filter(const Node& node, FilterSettings& filter, UnstatedFilters& unstated) {
    std::vector<std::string> names;
    for (const FilterSetting& setting : filter_settings()) names.emplace_back(setting.name);
    names.emplace_back("detail");
    node.allow_only(names);
    if (node.has("detail")) unstated.detail = node["detail"].number();
    if (const auto& detail = unstated.detail; detail && !(*detail >= 0 && *detail <= 1))
        node["detail"].refuse("a number from 0 (smooth) to 1 (as recorded)");
    if (node.has("detail") && node.has("levels"))
        node["levels"].refuse("left out, as filter.detail chooses levels");
    for (const FilterSetting& setting : filter_settings()) {
        const bool is_stated = node.has(setting.name);
        if (is_stated) setting.value.set(filter, read_value(node[setting.name], setting.range));
        if (setting.open)
            unstated.*setting.open = !is_stated && setting.is_open_if_left_out(filter, unstated);
    }
}

VideoSource read_video(const Node& node, const Scene& scene) {
    node.allow_only({"depth", "colour", "haptic", "height", "layout", "values"});
    VideoSource video;
    video.depth = node["depth"].text();
    if (node.has("colour")) video.colour = node["colour"].text();
    if (node.has("haptic")) video.haptic = node["haptic"].text();
    if (node.has("height")) video.height = node["height"].text();
    if (node.has("layout")) video.layout = node["layout"].one_of(layout_names);
    video.values = usual_values(scene.depth.kind);
    if (node.has("values")) video.values = node["values"].one_of(value_names);
    return video;
}

std::vector<Remark> read_remarks(const Node& node) {
    const std::string right = "an array of at most " + std::to_string(most_remarks) + " texts";
    std::vector<Remark> remarks;
    for (const Node& remark : node.elements(0, most_remarks, right)) {
        const std::string text = remark.text();
        if (text.size() > longest_remark)
            remark.refuse("a text of at most " + std::to_string(longest_remark) + " bytes");
        remarks.push_back(remark_of_text(text));
    }
    return remarks;
}

SceneDescription read_scene(const Node& node) {
    check_version(node["touchable_scene"]);  // first: a newer format may well have more members
    node.allow_only({"touchable_scene", "name", "width", "height", "rate", "metres_per_unit", "camera",
                     "colour_camera", "depth", "height_map", "haptic", "default_properties", "hole_stiffness",
                     "filter", "interpolation", "device_metres_per_unit", "folder", "video", "remarks"});
    SceneDescription described;
    Scene& scene = described.scene;
    SceneDescription::Unstated& open = described.unstated;
    if (node.has("remarks")) scene.remarks = read_remarks(node["remarks"]);
    if (node.has("name")) scene.name = node["name"].text();
    scene.width = node["width"].whole();
    scene.height = node["height"].whole();
    open.rate = !node.has("rate");
    if (node.has("rate")) scene.rate = read_rate(node["rate"]);
    if (node.has("metres_per_unit")) scene.metres_per_unit = node["metres_per_unit"].number();
    open.camera = !node.has("camera") && node.has("folder") && node["folder"].has("cameras");
    if (open.camera)
        scene.camera = {1.0 * scene.width, 1.0 * scene.width, 0.5 * scene.width, 0.5 * scene.height};
    else
        read_camera(node["camera"], scene);
    if (node.has("colour_camera")) scene.colour_camera = read_colour_camera(node["colour_camera"]);
    read_depth(node["depth"], described);
    if (node.has("height_map")) read_height_map(node["height_map"], scene.height_coding);
    if (node.has("default_properties")) read_properties(node["default_properties"], scene.default_properties);
    if (node.has("haptic")) read_haptic(node["haptic"], described);
    if (node.has("hole_stiffness")) scene.hole_stiffness = node["hole_stiffness"].number();
    open.filters = all_unstated;
    if (node.has("filter")) read_filter(node["filter"], scene.filter, open.filters);
    if (node.has("interpolation")) scene.interpolation = node["interpolation"].one_of(interpolation_names);
    if (node.has("device_metres_per_unit"))
        scene.device_metres_per_unit = node["device_metres_per_unit"].number();
    if (node.has("folder")) scene.folder = read_folder(node["folder"]);
    if (node.has("video")) scene.video = read_video(node["video"], scene);
    if (!described.materials.empty() && !(scene.folder && !scene.folder->haptic.empty()))
        node["haptic"]["materials"].refuse(
            "left out where no folder.haptic names pictures of material indices");
    return described;
}

template <class Choice, std::size_t n>
const char* name_of(const std::pair<const char*, Choice> (&choices)[n], Choice sought) {
    for (const auto& [name, choice] : choices)
        if (choice == sought) return name;
    return "";
}

OrderedJson write_remarks(const std::vector<Remark>& remarks) {
    OrderedJson json = OrderedJson::array();
    for (const Remark& remark : remarks) json.push_back(remark_text(remark));
    return json;
}

OrderedJson write_camera(const Camera& camera, const LensDistortion& lens) {
    OrderedJson json = {{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}};
    if (lens.any()) json["distortion"] = lens.terms;
    return json;
}

OrderedJson write_colour_camera(const ColourCamera& colour) {
    OrderedJson json = {{"width", colour.width}, {"height", colour.height}};
    json.update(write_camera(colour.camera, colour.lens));
    const auto& r = colour.from_depth.rotation;
    const auto& t = colour.from_depth.translation;
    json["from_depth"] = {r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2], 0, 0, 0, 1};
    return json;
}

OrderedJson write_depth(const SceneDescription& described) {
    const Scene& scene = described.scene;
    const DepthCoding& depth = scene.depth;
    const StoredDepth& stored = scene.stored;
    const bool metric = depth.kind == DepthCodingKind::metric;
    const bool disparity = stored.kind == StoredDepth::Kind::disparity;
    OrderedJson json = {{"coding", name_of(coding_names, Coding{depth.kind, stored.kind})},
                        {"semantics", name_of(semantics_names, depth.semantics)}};
    if (metric) json["scale"] = depth.scale;
    if (scene.float_scale > 0) json["float_scale"] = scene.float_scale;
    if (disparity)
        json.update({{"baseline", stored.baseline}, {"scale", stored.scale}, {"offset", stored.offset}});
    if (!disparity) json["near"] = depth.near;
    if (!described.unstated.far && !disparity) json["far"] = depth.far;
    json["bits"] = scene.depth_bits;
    if (stored.bytes_swapped) json["bytes"] = "swapped";
    if (stored.rotated > 0) json["rotated"] = stored.rotated;
    if (stored.used_bits < 16) json["used_bits"] = stored.used_bits;
    if (stored.packed != Packing::none) json["packed"] = name_of(packed_names, stored.packed);
    if (!disparity) json["code_max"] = depth.code_max;
    if (!metric && !disparity) json["near_is"] = name_of(near_is_high_names, depth.near_is_high);
    if (depth.kind == DepthCodingKind::log || depth.shift != 0) json["shift"] = depth.shift;
    if (depth.kind == DepthCodingKind::hue) json["least_sum"] = depth.least_sum;
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

OrderedJson write_haptic(const SceneDescription& described) {
    const HapticRanges& haptic = described.scene.haptic;
    OrderedJson json = {{"stiffness", write_range(haptic.stiffness)},
                        {"static_friction", write_range(haptic.static_friction)},
                        {"dynamic_friction", write_range(haptic.dynamic_friction)}};
    if (!described.materials.empty()) json["materials"] = write_materials(described.materials);
    return json;
}

OrderedJson write_value(const DepthLength& value, const SettingRange& range) {
    if (range.is_length) return OrderedJson::array({value.constant, value.quadratic});
    if (range.has_names()) return range.word_of(value.constant);
    return range.whole ? OrderedJson(static_cast<int>(value.constant)) : OrderedJson(value.constant);
}

/// Settings that are left open stay open.
OrderedJson write_filter(const FilterSettings& filter, const UnstatedFilters& open) {
    OrderedJson json = OrderedJson::object();
    if (open.detail) json["detail"] = *open.detail;
    for (const FilterSetting& setting : filter_settings())
        if (!(setting.open && open.*setting.open) &&
            (setting.is_open_if_left_out(filter, open) || !setting.is_default(filter)))
            json[setting.name] = write_value(setting.value.of(filter), setting.range);
    return json;
}

OrderedJson write_video(const VideoSource& video) {
    OrderedJson json = {{"depth", video.depth}};
    if (!video.colour.empty()) json["colour"] = video.colour;
    if (!video.haptic.empty()) json["haptic"] = video.haptic;
    if (!video.height.empty()) json["height"] = video.height;
    json["layout"] = name_of(layout_names, video.layout);
    json["values"] = name_of(value_names, video.values);
    return json;
}

}  // namespace

std::string remark_text(const Remark& remark) {
    return (remark.is_guess ? std::string(guess_mark) : std::string()) + remark.what;
}

Remark remark_of_text(std::string_view text) {
    const auto begins = [&](const auto& row) { return text.starts_with(row.first); };
    const auto row = std::ranges::find_if(remark_beginnings, begins);
    const RemarkKind kind = row == std::end(remark_beginnings) ? RemarkKind::other : row->second;
    const bool is_guess = text.starts_with(guess_mark);
    if (is_guess) text.remove_prefix(guess_mark.size());
    return {std::string(text), is_guess, {}, {}, kind};
}

Result<SceneDescription> parse_scene(std::string_view json, std::string_view where) {
    TRY_ASSIGN(auto described,
               checked_json::read_checked(json, checked_json::largest_text, where, read_scene));
    derive_valid_range(described.scene.depth);
    TRY(error_at(std::string(where), validate(described)));
    return described;
}

Result<SceneDescription> read_scene_file(const std::filesystem::path& file) {
    TRY_ASSIGN(const auto text,
               read_given_file(file, file.string(), "a scene file (JSON, docs/scene_file.md)",
                               checked_json::largest_text));
    return parse_scene(text, file.string());
}

std::string scene_to_json(const SceneDescription& described) {
    const Scene& scene = described.scene;
    const SceneDescription::Unstated& open = described.unstated;
    OrderedJson json = {{"touchable_scene", scene_format_version}};
    if (!scene.remarks.empty()) json["remarks"] = write_remarks(scene.remarks);
    json.update({{"name", scene.name}, {"width", scene.width}, {"height", scene.height}});
    if (!open.rate && !scene.rate.own_times) json["rate"] = {scene.rate.num, scene.rate.den};
    json["metres_per_unit"] = scene.metres_per_unit;
    if (!open.camera) json["camera"] = write_camera(scene.camera, scene.lens);
    if (scene.colour_camera) json["colour_camera"] = write_colour_camera(*scene.colour_camera);
    json.update({{"depth", write_depth(described)},
                 {"height_map", write_height_map(scene.height_coding)},
                 {"haptic", write_haptic(described)},
                 {"default_properties", write_properties(scene.default_properties)},
                 {"filter", write_filter(scene.filter, open.filters)},
                 {"interpolation", name_of(interpolation_names, scene.interpolation)}});
    if (scene.hole_stiffness) json["hole_stiffness"] = *scene.hole_stiffness;
    if (scene.device_metres_per_unit) json["device_metres_per_unit"] = *scene.device_metres_per_unit;
    if (scene.folder) json["folder"] = write_folder(*scene.folder);
    if (scene.video) json["video"] = write_video(*scene.video);
    return json.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

}  // namespace touchable
