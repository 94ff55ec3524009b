#include "player/clip_facts.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "engine/frame/stored_code.hpp"
#include "engine/trigonometry.hpp"

namespace touchable {
namespace {

/// Angle that `pixels` span, seen from the centre `c` at focal length `f`.
double field_of_view_degrees(int pixels, double c, double f) {
    return (arctangent((c + 0.5) / f) + arctangent((pixels - 0.5 - c) / f)) * 180.0 / pi;
}

Kappa kappa_at(const Scene& scene, double depth) {
    const DepthCoding& coding = scene.depth;
    if (coding.valid_min >= coding.valid_max) return {depth, 0};
    const std::uint16_t code = std::min(coding.code(depth), static_cast<std::uint16_t>(coding.valid_max - 1));
    const double step = std::fabs(coding.depth(static_cast<std::uint16_t>(code + 1)) - coding.depth(code));
    return {depth, step / (depth / scene.camera.fx)};
}

/// Share of invalid stored values and the range of the valid ones, in the first frame.
void add_first_frame(const RawFrame& frame, ClipFacts& facts) {
    const DepthCoding& coding = facts.scene.depth;
    std::int64_t invalid = 0;
    std::uint16_t least = 65535, greatest = 0;
    for (int y = 0; y < frame.depth.height; ++y)
        for (int x = 0; x < frame.depth.width; ++x) {
            const std::uint16_t code = stored_code(frame.depth, coding, x, y);
            if (!coding.is_valid(code)) {
                ++invalid;
                continue;
            }
            least = std::min(least, code);
            greatest = std::max(greatest, code);
        }
    const auto pixels = static_cast<double>(frame.depth.width) * frame.depth.height;
    facts.invalid_pct = 100.0 * static_cast<double>(invalid) / pixels;
    if (least > greatest) return;
    facts.nearest = coding.depth(coding.deeper_is_higher() ? least : greatest);
    facts.farthest = coding.depth(coding.deeper_is_higher() ? greatest : least);
}

const char* kind_name(DepthCodingKind kind) {
    switch (kind) {
        case DepthCodingKind::linear:
            return "linear";
        case DepthCodingKind::inverse:
            return "inverse";
        case DepthCodingKind::metric:
            return "metric";
        case DepthCodingKind::hue:
            return "hue";
    }
    return "";
}

const char* semantics_name(DepthSemantics semantics) {
    return semantics == DepthSemantics::range ? "range" : "planar";
}

std::string coding_words(const DepthCoding& coding) {
    std::ostringstream words;
    if (coding.kind == DepthCodingKind::metric)
        words << "metric, " << coding.scale << " units a code";
    else
        words << kind_name(coding.kind) << (coding.kind == DepthCodingKind::inverse ? " (1/depth)" : "")
              << " between two planes, largest code at the " << (coding.near_is_high ? "near" : "far")
              << " one";
    if (coding.kind == DepthCodingKind::hue) words << ", no depth where R + G + B < " << coding.least_sum;
    words << (coding.semantics == DepthSemantics::range ? "; range along the pixel's ray"
                                                        : "; planar, along -Z");
    return words.str();
}

/// "400..4400 without 1000".
std::string valid_words(const DepthCoding& coding) {
    std::ostringstream words;
    words << coding.valid_min << ".." << coding.valid_max;
    const char* separator = " without ";
    for (int k = 0; k < coding.invalid_code_count; ++k) {
        const std::uint16_t code = coding.invalid_codes[static_cast<std::size_t>(k)];
        if (code < coding.valid_min || code > coding.valid_max) continue;
        words << separator << code;
        separator = ", ";
    }
    return words.str();
}

std::string range_words(const PropertyRange& range) {
    std::ostringstream words;
    words << range.min << ".." << range.max;
    return words.str();
}

std::string filter_words(const FilterSettings& filter) {
    const std::string median =
        filter.median == 0 ? "off" : std::to_string(filter.median) + "x" + std::to_string(filter.median);
    return "median " + median + ", fill holes " +
           (filter.fill_holes == 0 ? "off" : std::to_string(filter.fill_holes) + " passes");
}

}  // namespace

bool ClipFacts::has_track(const std::string& role) const {
    return std::any_of(tracks.begin(), tracks.end(),
                       [&](const TrackInfo& track) { return track.role == role; });
}

Result<ClipFacts> clip_facts(const std::filesystem::path& clip,
                             const std::optional<std::filesystem::path>& scene) {
    auto reader = open_clip(clip, scene);
    if (!reader.ok()) return reader.error();
    ClipFacts facts;
    facts.clip = clip.string();
    const auto first = (*reader)->next();
    if (!first.ok()) return first.error();
    if (!*first) return input_error(clip.string() + " has no frames; a clip needs at least one");
    facts.scene = (*reader)->scene();
    facts.tracks = (*reader)->tracks();
    facts.frames = (*reader)->frame_count();
    facts.notes = (*reader)->notes();
    add_first_frame(**first, facts);

    const Camera& camera = facts.scene.camera;
    facts.fov_x_degrees = field_of_view_degrees(facts.scene.width, camera.cx, camera.fx);
    facts.fov_y_degrees = field_of_view_degrees(facts.scene.height, camera.cy, camera.fy);
    const DepthCoding& coding = facts.scene.depth;
    const double near = coding.near > 0 ? coding.near : facts.nearest > 0 ? facts.nearest : coding.far;
    facts.near = kappa_at(facts.scene, near);
    facts.mid = kappa_at(facts.scene, 0.5 * (near + coding.far));
    facts.far = kappa_at(facts.scene, coding.far);
    return facts;
}

nlohmann::ordered_json to_json(const ClipFacts& facts) {
    using nlohmann::ordered_json;
    const Scene& scene = facts.scene;
    const DepthCoding& coding = scene.depth;
    const double mm = scene.metres_per_unit * 1000.0;
    const auto range = [](const PropertyRange& r) { return ordered_json::array({r.min, r.max}); };
    const auto kappa = [&](const Kappa& k) { return ordered_json{{"depth", k.depth}, {"kappa", k.kappa}}; };

    ordered_json out;
    out["clip"] = facts.clip;
    out["name"] = scene.name;
    out["width"] = scene.width;
    out["height"] = scene.height;
    out["frames"] = facts.frames ? ordered_json(*facts.frames) : ordered_json(nullptr);
    out["rate"] = {{"num", scene.rate.num}, {"den", scene.rate.den}};
    out["tracks"] = ordered_json::array();
    for (const TrackInfo& track : facts.tracks)
        out["tracks"].push_back({{"role", track.role},
                                 {"codec", track.codec},
                                 {"pixel_format", track.pixel_format},
                                 {"width", track.width},
                                 {"height", track.height}});
    out["metres_per_unit"] = scene.metres_per_unit;
    out["camera"] = {{"fx", scene.camera.fx},
                     {"fy", scene.camera.fy},
                     {"cx", scene.camera.cx},
                     {"cy", scene.camera.cy},
                     {"fov_x_degrees", facts.fov_x_degrees},
                     {"fov_y_degrees", facts.fov_y_degrees}};
    auto& depth = out["depth"];
    depth = {{"kind", kind_name(coding.kind)}, {"semantics", semantics_name(coding.semantics)}};
    depth["description"] = coding_words(coding);
    if (coding.kind == DepthCodingKind::metric)
        depth["scale"] = coding.scale;
    else
        depth["near_is_high"] = coding.near_is_high;
    depth["near"] = coding.near;
    depth["far"] = coding.far;
    depth["near_mm"] = coding.near * mm;
    depth["far_mm"] = coding.far * mm;
    depth["bits"] = scene.depth_bits;
    depth["code_max"] = coding.code_max;
    if (coding.kind == DepthCodingKind::hue) depth["least_sum"] = coding.least_sum;
    depth["valid_codes"] = {coding.valid_min, coding.valid_max};
    depth["invalid_codes"] = ordered_json::array();
    for (int k = 0; k < coding.invalid_code_count; ++k)
        depth["invalid_codes"].push_back(coding.invalid_codes[static_cast<std::size_t>(k)]);
    out["first_frame"] = {
        {"invalid_pct", facts.invalid_pct}, {"nearest", facts.nearest}, {"farthest", facts.farthest}};
    out["kappa"] = {{"near", kappa(facts.near)}, {"mid", kappa(facts.mid)}, {"far", kappa(facts.far)}};
    out["filter"] = {{"median", scene.filter.median}, {"fill_holes", scene.filter.fill_holes}};
    out["interpolation"] = scene.interpolation == FrameInterpolation::hold ? "hold" : "linear";
    if (facts.has_track("haptic"))
        out["haptic"] = {{"stiffness_n_per_mm", range(scene.haptic.stiffness)},
                         {"static_friction", range(scene.haptic.static_friction)},
                         {"dynamic_friction", range(scene.haptic.dynamic_friction)}};
    else
        out["default_properties"] = {{"stiffness_n_per_m", scene.default_properties.stiffness},
                                     {"static_friction", scene.default_properties.static_friction},
                                     {"dynamic_friction", scene.default_properties.dynamic_friction}};
    if (facts.has_track("height"))
        out["height_coding"] = {
            {"max_height", scene.height_coding.max_height},
            {"units", scene.height_coding.units == HeightUnits::levels ? "levels" : "world"},
            {"code_max", scene.height_coding.code_max},
            {"largest", largest_height(scene.height_coding, coding)}};
    out["notes"] = facts.notes;
    return out;
}

std::string to_text(const ClipFacts& facts) {
    const Scene& scene = facts.scene;
    const DepthCoding& coding = scene.depth;
    const double mm = scene.metres_per_unit * 1000.0;
    std::ostringstream out;
    const auto line = [&](const char* label) -> std::ostream& {
        out << "  " << label << std::string(13 - std::char_traits<char>::length(label), ' ');
        return out;
    };

    out << facts.clip;
    if (!scene.name.empty()) out << ": " << scene.name;
    out << '\n';
    line("picture") << scene.width << "x" << scene.height << " pixels, ";
    if (facts.frames) out << *facts.frames << " frames, ";
    const double rate = static_cast<double>(scene.rate.num) / static_cast<double>(scene.rate.den);
    out << rate << " frames/s";
    if (facts.frames) out << ", " << static_cast<double>(*facts.frames) / rate << " s";
    out << '\n';
    for (const TrackInfo& track : facts.tracks)
        line("track") << track.role << ": " << track.codec << ", " << track.pixel_format << ", "
                      << track.width << "x" << track.height << '\n';
    line("camera") << "fx " << scene.camera.fx << ", fy " << scene.camera.fy << ", cx " << scene.camera.cx
                   << ", cy " << scene.camera.cy << " pixels; field of view " << facts.fov_x_degrees << " x "
                   << facts.fov_y_degrees << " degrees\n";
    line("depth") << coding_words(coding) << '\n';
    line("codes") << (coding.kind == DepthCodingKind::hue ? "3 x " : "") << scene.depth_bits << " bits, 0.."
                  << coding.code_max << ", of which valid " << valid_words(coding) << '\n';
    line("range") << coding.near << ".." << coding.far << " units = " << coding.near * mm << ".."
                  << coding.far * mm << " mm\n";
    line("first frame") << "depths " << facts.nearest << ".." << facts.farthest << " units, "
                        << facts.invalid_pct << " % of the pixels invalid\n";
    line("kappa") << facts.near.kappa << " at " << facts.near.depth << ", " << facts.mid.kappa << " at "
                  << facts.mid.depth << ", " << facts.far.kappa << " at " << facts.far.depth
                  << " units (depth step of one code / width of a pixel)\n";
    line("filters") << filter_words(scene.filter) << '\n';
    line("in between") << (scene.interpolation == FrameInterpolation::hold ? "hold the earlier frame"
                                                                           : "linear between two frames")
                       << '\n';
    if (facts.has_track("haptic"))
        line("touch") << "per pixel: stiffness " << range_words(scene.haptic.stiffness) << " N/mm, friction "
                      << range_words(scene.haptic.static_friction) << " static, "
                      << range_words(scene.haptic.dynamic_friction) << " dynamic\n";
    else
        line("touch") << "everywhere: stiffness " << scene.default_properties.stiffness / 1000.0
                      << " N/mm, friction " << scene.default_properties.static_friction << " static, "
                      << scene.default_properties.dynamic_friction << " dynamic\n";
    if (facts.has_track("height"))
        line("height") << "up to " << scene.height_coding.max_height
                       << (scene.height_coding.units == HeightUnits::levels ? " levels = "
                                                                            : " scene units = ")
                       << largest_height(scene.height_coding, coding) * mm << " mm\n";
    for (const std::string& note : facts.notes) line("note") << note << '\n';
    return out.str();
}

}  // namespace touchable
