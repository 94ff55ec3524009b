// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/source_description.hpp"

#include "engine/base/same_bits.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

using Kind = StoredDepth::Kind;

constexpr Intrinsics kinect{525, 525, 319.5, 239.5, 640, 480},
    kinect_infrared{582.62, 582.69, 313.04, 238.44, 640, 480};

constexpr SourceDescription::Preset packed(const char* name, const char* what, Packing packing) {
    return {.name = name, .what = what, .fov = 60, .stored = {.packed = packing}};
}

/// From the descriptions of the data sets. Where a description gives one number for baseline x fx, `baseline`
/// is that number divided by the preset's fx.
const SourceDescription::Preset presets[] = {
    {"tum", "TUM RGB-D: 5000 codes a metre", kinect, 0, 1.0 / 5000},
    {"redwood", "Redwood and Open3D: millimetres", kinect, 0, 0.001},
    {"icl", "ICL-NUIM: 5000 codes a metre", {481.2, 480, 319.5, 239.5, 640, 480}, 0, 1.0 / 5000},
    {"7scenes", "7-Scenes: millimetres, 65535 is none", {585, 585, 320, 240, 640, 480}, 0, 0.001, 65535},
    {"scannet", "ScanNet: millimetres", {577.87, 577.87, 319.5, 239.5, 640, 480}, 0, 0.001},
    {"arkitscenes", "ARKitScenes: millimetres, with the camera of each frame (.pincam)", {}, 60, 0.001},
    {.name = "nyu",
     .what = "NYU Depth, raw: disparities of a Kinect with their bytes swapped",
     .intrinsics = kinect_infrared,
     .invalid = 2047,
     .stored = {Kind::disparity, 351.3 / 582.62, -1, 1092.5, true}},
    {.name = "kinect-raw",
     .what = "a Kinect's own disparities, of 11 bits (libfreenect): 2047 is none",
     .intrinsics = kinect_infrared,
     .invalid = 2047,
     .stored = {Kind::disparity, 351.3 / 582.62, -1, 1092.5}},
    {.name = "kinect-sdk1",
     .what = "Kinect for Windows SDK 1: millimetres, with the number of a person in the 3 lowest bits",
     .fov = 58.5,
     .metres_per_code = 0.001,
     .stored = {.rotated = 3, .used_bits = 13}},
    {.name = "depth16",
     .what = "Android's DEPTH16: millimetres, with a confidence in the 3 highest bits",
     .fov = 60,
     .metres_per_code = 0.001,
     .stored = {.used_bits = 13}},
    {"sun", "SUN RGB-D: millimetres, bits rotated by 3", {}, 60, 0.001, 0, {.rotated = 3}},
    {"realsense", "RealSense D400: millimetres", {}, 79, 0.001},
    {.name = "kitti",
     .what = "KITTI depth: 256 codes a metre",
     .intrinsics = {721.5377, 721.5377, 609.5593, 172.854, 1242, 375},
     .metres_per_code = 1.0 / 256},
    {"unreal", "Unreal's WorldDepth: centimetres", {}, 60, 0.01},
    {"void", "VOID: 256 codes a metre", {}, 60, 1.0 / 256},
    {.name = "vkitti",
     .what = "Virtual KITTI: centimetres, 65535 is the sky",
     .intrinsics = {725.0087, 725.0087, 620.5, 187, 1242, 375},
     .metres_per_code = 0.01,
     .invalid = 65535},
    {.name = "carla",
     .what = "CARLA: 24 bits of 1 km in red, green and blue",
     .fov = 90,
     .metres_per_code = 1000.0 / 0xffffff,
     .stored = {.packed = Packing::rgb24}},
    {.name = "middlebury",
     .what = "Middlebury stereo: disparities, with the calib.txt beside them",
     .stored = {.kind = Kind::disparity}},
    {.name = "relative-inverse",
     .what = "guessed from one picture (MiDaS and the like): 1/depth without a scale",
     .fov = 60,
     .stored = {.kind = Kind::relative}},
    packed("bgr24", "24 bits, blue, green, red: shares of a far plane, whose metres are the unit",
           Packing::bgr24),
    packed("bgr255", "the same to base 255 (Unity's EncodeFloatRGBA)", Packing::bgr255),
    packed("rg16", "16 bits: red + 256 green", Packing::rg16),
    packed("gr16", "16 bits: green + 256 red", Packing::gr16),
    packed("rgba32f", "a float in the bytes of red, green, blue, alpha", Packing::rgba32f),
    packed("bgra32f", "a float in the bytes of blue, green, red, alpha (TartanAir V2)", Packing::bgra32f),
    packed("abgr32f", "a float in the bytes of alpha, blue, green, red", Packing::abgr32f),
    packed("half", "a 16-bit float in grey of 16 bits (Mid-Air, CO3D)", Packing::half),
};

constexpr std::pair<const char*, VideoValues> of_videos[] = {{"hue", VideoValues::hue},
                                                             {"mean", VideoValues::mean}};

// --- The table of settings

/// Gives a row its member: a text, empty if not stated, or an optional number.
template <auto member>
SourceSetting source_row(SourceSetting row) {
    constexpr bool is_text = std::is_same_v<decltype(member), std::string SourceDescription::*>;
    row.get = [](const SourceDescription& known) -> std::optional<SourceSetting::Value> {
        if constexpr (is_text)
            if ((known.*member).empty()) return std::nullopt;
        return known.*member;
    };
    row.set = [](const SourceSetting::Value& value, SourceDescription& known) {
        known.*member = std::get<std::conditional_t<is_text, std::string, double>>(value);
    };
    return row;
}

SourceSetting semantics_row() {
    SourceSetting row{.name = Setting::depth_kind,
                      .what =
                          "how depth is measured. range: along each pixel's ray; planar: along the "
                          "camera's axis; for pictures without a scene file",
                      .form = "WORD",
                      .range = {.words = {"range", "planar"}}};
    row.get = [](const SourceDescription& known) -> std::optional<SourceSetting::Value> {
        if (!known.semantics) return std::nullopt;
        return known.semantics == DepthSemantics::range ? "range" : "planar";
    };
    row.set = [](const SourceSetting::Value& value, SourceDescription& known) {
        const bool is_range = std::get<std::string>(value) == "range";
        known.semantics = is_range ? DepthSemantics::range : DepthSemantics::planar;
    };
    return row;
}

std::vector<SourceSetting> all_source_settings() {
    using Known = SourceDescription;
    std::vector<const char*> preset_names;
    for (const Known::Preset& preset : presets) preset_names.push_back(preset.name);
    for (const auto& [name, values] : of_videos) preset_names.push_back(name);
    return {source_row<&Known::fov>({.name = Setting::field_of_view,
                                     .what = "horizontal field of view. For pictures without a scene file",
                                     .form = "DEGREES",
                                     .range = {.least = 1, .most = 179}}),
            source_row<&Known::metres_per_code>(
                {.name = Setting::depth_unit,
                 .what = "length of a stored 1. For pictures without a scene file",
                 .form = "METRES",
                 .range = {.least = 1e-9, .most = 1e6}}),
            source_row<&Known::near>({.name = Setting::near,
                                      .what = "near plane of a renderer's depth buffer (0 to 1), or the "
                                              "nearest depth where it has no scale; beside the far one. For "
                                              "pictures without a scene file",
                                      .form = "METRES",
                                      .range = {.least = 1e-6, .most = 1e6}}),
            source_row<&Known::far>({.name = Setting::far,
                                     .what = "far plane, or the farthest depth",
                                     .form = "METRES",
                                     .range = {.least = 1e-6, .most = 1e9}}),
            semantics_row(),
            source_row<&Known::least_confidence>(
                {.name = "least_confidence",
                 .what = "ignore depth with less confidence. For a .npz with an array conf beside depth; by "
                         "default half the median of frame 0",
                 .form = "NUMBER",
                 .range = {.least = -1e9, .most = 1e9},
                 .describes = false}),
            source_row<&Known::channel>(
                {.name = Setting::channel,
                 .what = "channel or layer of an OpenEXR rendering that is depth. By default found by its "
                         "name",
                 .describes = false}),
            source_row<&Known::dataset>(
                {.name = Setting::dataset,
                 .what = "data set or array of an HDF5 or .npz file that is depth, such as "
                         "/data/demo_0/obs/depth. By default found by its name",
                 .describes = false}),
            source_row<&Known::preset>(
                {.name = Setting::preset,
                 .what = "how a camera, program or data set stores depth. For pictures and videos without a "
                         "scene file; touchable formats lists what each is",
                 .range = {.words = std::move(preset_names)}})};
}

}  // namespace

Camera scaled_camera(const Intrinsics& said, int width, int height) {
    Intrinsics intrinsics = said;
    if (said.fx <= 0 && (said.fov_x > 0 || said.fov_y > 0)) {
        const bool is_of_these = said.width <= 0 || said.height <= 0;
        const double w = is_of_these ? width : said.width, h = is_of_these ? height : said.height;
        const auto focal = [](double degrees, double side) {
            return 0.5 * side * cosine(degrees * pi / 360) / sine(degrees * pi / 360);
        };
        intrinsics.fx = said.fov_x > 0 ? focal(said.fov_x, w) : focal(said.fov_y, h);
        intrinsics.fy = said.fov_y > 0 ? focal(said.fov_y, h) : intrinsics.fx;
        constexpr double rounded = 0.005;  // relative; a smaller difference means square pixels
        if (std::abs(intrinsics.fy - intrinsics.fx) < rounded * intrinsics.fx) intrinsics.fy = intrinsics.fx;
    }
    Camera camera{intrinsics.fx, intrinsics.fy, 0.5 * (width - 1), 0.5 * (height - 1)};
    const bool has_size = intrinsics.width > 0 && intrinsics.height > 0;
    double x = has_size ? static_cast<double>(width) / intrinsics.width : 1,
           y = has_size ? static_cast<double>(height) / intrinsics.height : 1;
    // For pictures of another shape: cameras crop and do not stretch.
    if (std::abs(x - y) > 0.01 * x) x = y = std::max(x, y);
    camera.fx *= x;
    camera.fy *= y;
    const auto centre = [](double at, int from, double scale, int to) {
        return (at - 0.5 * (from - 1)) * scale + 0.5 * (to - 1);
    };
    if (intrinsics.cx)
        camera.cx = has_size ? centre(*intrinsics.cx, intrinsics.width, x, width) : *intrinsics.cx;
    if (intrinsics.cy)
        camera.cy = has_size ? centre(*intrinsics.cy, intrinsics.height, y, height) : *intrinsics.cy;
    return camera;
}

std::span<const SourceDescription::Preset> all_presets() {
    return presets;
}

const SourceDescription::Preset* preset_named(const std::string& name) {
    return named_in(presets, name, &SourceDescription::Preset::name);
}

const SourceDescription::Preset* preset_of(Packing packing) {
    const auto* const found = std::ranges::find_if(
        presets, [&](const SourceDescription::Preset& preset) { return preset.stored.packed == packing; });
    return packing == Packing::none ? nullptr : found;
}

std::optional<VideoValues> video_values_named(const std::string& name) {
    for (const auto& [known, values] : of_videos)
        if (name == known) return values;
    return std::nullopt;
}

bool SourceSetting::state(const Value& value, SourceDescription& known) const {
    const auto* const number = std::get_if<double>(&value);
    const auto* const text = std::get_if<std::string>(&value);
    if (number && !range.has(*number)) return false;
    if (text && !range.words.empty() && !range.value_of(*text)) return false;
    set(value, known);
    return true;
}

std::span<const SourceSetting> source_settings() {
    static const std::vector<SourceSetting> settings = all_source_settings();
    return settings;
}

const SourceSetting* source_setting(Setting::Name name) {
    const auto all = source_settings();
    return named_in(all, name, &SourceSetting::name);
}

}  // namespace touchable
