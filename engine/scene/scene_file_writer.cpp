#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "engine/scene/folder_json.hpp"
#include "engine/scene/materials_json.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/scene/scene_words.hpp"

namespace touchable {
namespace {

using namespace scene_words;

/// Members stay in the order a person would write them.
using OrderedJson = nlohmann::ordered_json;

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
    if (disparity)
        json.update({{"baseline", stored.baseline}, {"scale", stored.scale}, {"offset", stored.offset}});
    if (!disparity) json["near"] = depth.near;
    if (!described.unstated.far && !disparity) json["far"] = depth.far;
    json["bits"] = scene.depth_bits;
    if (stored.bytes_swapped) json["bytes"] = "swapped";
    if (stored.rotated > 0) json["rotated"] = stored.rotated;
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

/// Those that are left open stay open.
OrderedJson write_filter(const FilterSettings& filter, const UnstatedFilters& open) {
    OrderedJson json = OrderedJson::object();
    if (!open.median) json["median"] = filter.median;
    if (!open.fill_holes) json["fill_holes"] = filter.fill_holes;
    if (!open.terraces) json["terraces"] = name_of(terrace_names, filter.terraces);
    if (filter.terrace_noise != 0) json["terrace_noise"] = filter.terrace_noise;
    const bool is_removal_open = open.terraces || filter.terraces == TerraceRemoval::automatic;
    if (!open.terrace_reach && (filter.terrace_reach != least_terrace_reach || is_removal_open))
        json["terrace_reach"] = filter.terrace_reach;
    if (filter.levels != DepthLength{}) json["levels"] = {filter.levels.constant, filter.levels.quadratic};
    if (!open.temporal) json["temporal"] = name_of(temporal_names, filter.temporal);
    if (filter.temporal_noise != DepthLength{})
        json["temporal_noise"] = {filter.temporal_noise.constant, filter.temporal_noise.quadratic};
    if (!open.flying_pixels)
        json["flying_pixels"] = {filter.flying_pixels.constant, filter.flying_pixels.quadratic};
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

std::string scene_to_json(const SceneDescription& described) {
    const Scene& scene = described.scene;
    const Unstated& open = described.unstated;
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
