#include "engine/scene/scene_file.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/given_file.hpp"
#include "engine/base/try.hpp"
#include "engine/scene/checked_json.hpp"
#include "engine/scene/folder_json.hpp"
#include "engine/scene/materials_json.hpp"
#include "engine/scene/scene_words.hpp"

namespace touchable {
namespace {

using checked_json::Node;
using namespace scene_words;

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

/// Words of 16 bits whose bits stand in another order.
void read_order(const Node& node, Scene& scene) {
    if (node.has("bytes")) scene.stored.bytes_swapped = node["bytes"].one_of(byte_order_names);
    if (node.has("rotated")) scene.stored.rotated = static_cast<int>(node["rotated"].integer(0, 15));
    if (!scene.stored.bytes_swapped && scene.stored.rotated == 0) return;
    if (scene.depth_bits != 16 || scene.depth.kind == DepthCodingKind::hue)
        node[scene.stored.rotated > 0 ? "rotated" : "bytes"].refuse("left out: depth.bits is not 16");
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
    // Until then: planes that are in order.
    scene.depth.near = scene.camera.fx * stored.baseline / 65536;
    scene.depth.far = scene.camera.fx * stored.baseline;
}

void read_depth(const Node& node, SceneDescription& described) {
    Scene& scene = described.scene;
    DepthCoding& depth = scene.depth;
    node.allow_only({"coding", "semantics", "near", "far", "scale", "bits", "code_max", "near_is", "shift",
                     "least_sum", "invalid", "baseline", "offset", "bytes", "rotated"});
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
    if (depth.kind == DepthCodingKind::log) {
        if (node.has("shift")) depth.shift = node["shift"].number();
    } else if (node.has("shift")) {
        node["shift"].refuse("left out: only log depth has a shift");
    }
    if (!hue && node.has("least_sum")) node["least_sum"].refuse("left out: only a hue has a least sum");
    depth.near_is_high = !hue;
    if (node.has("near_is")) depth.near_is_high = node["near_is"].one_of(near_is_high_names);

    const bool usually_16 = metric || coding.stored != StoredDepth::Kind::codes;
    scene.depth_bits = node.has("bits") ? static_cast<int>(node["bits"].integer(8, 16)) : usually_16 ? 16 : 8;
    const int largest = hue ? DepthCoding::hue_circle : (1 << scene.depth_bits) - 1;
    depth.code_max =
        static_cast<std::uint16_t>(node.has("code_max") ? node["code_max"].integer(1, largest) : largest);
    if (node.has("invalid")) read_invalid_codes(node["invalid"], largest, depth);

    if (node.has("least_sum")) depth.least_sum = static_cast<int>(node["least_sum"].integer(0, 3 * 255));
    read_order(node, scene);
    if (disparity) return read_disparity(node, scene);
    if (metric) depth.scale = node["scale"].number();
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

void read_filter(const Node& node, FilterSettings& filter, UnstatedFilters& unstated) {
    node.allow_only({"median", "fill_holes", "terraces", "terrace_noise", "terrace_reach", "levels",
                     "temporal", "temporal_noise", "flying_pixels"});
    if (node.has("median")) filter.median = node["median"].whole();
    if (node.has("fill_holes")) filter.fill_holes = node["fill_holes"].whole();
    if (node.has("terraces")) filter.terraces = node["terraces"].one_of(terrace_names);
    if (node.has("terrace_noise")) filter.terrace_noise = node["terrace_noise"].number();
    if (node.has("terrace_reach")) filter.terrace_reach = node["terrace_reach"].whole();
    if (node.has("levels")) filter.levels = read_length(node["levels"]);
    if (node.has("temporal")) filter.temporal = node["temporal"].one_of(temporal_names);
    if (node.has("temporal_noise")) filter.temporal_noise = read_length(node["temporal_noise"]);
    unstated = {!node.has("median"), !node.has("fill_holes"), !node.has("terraces"), !node.has("temporal"),
                !node.has("flying_pixels")};
    // Removal that is stated is as it was before there was a reach, above all where a recording repeats it.
    unstated.terrace_reach =
        !node.has("terrace_reach") && (unstated.terraces || filter.terraces == TerraceRemoval::automatic);
    if (node.has("flying_pixels")) filter.flying_pixels = read_length(node["flying_pixels"]);
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
    Unstated& open = described.unstated;
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

}  // namespace

Result<SceneDescription> parse_scene(std::string_view json, std::string_view where) {
    const auto refusal = [&](const std::string& message) {
        return input_error(std::string(where) + ": " + message);
    };
    SceneDescription described;
    try {
        const checked_json::Json text = checked_json::parse(json);
        described = read_scene(Node(text, ""));
    } catch (const checked_json::Refusal& reason) {
        return refusal(reason.message);
    } catch (const checked_json::Json::exception& fault) {
        return refusal(fault.what());
    }
    derive_valid_range(described.scene.depth);
    if (const auto valid = validate(described); !valid) return refusal(valid.error().message);
    return described;
}

Result<SceneDescription> read_scene_file(const std::filesystem::path& file) {
    TRY_ASSIGN(const auto text,
               read_given_file(file, file.string(), "a scene file (JSON, docs/scene_file.md)",
                               checked_json::largest_text));
    return parse_scene(text, file.string());
}

}  // namespace touchable
