#include "player/commands/clip_findings.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/scene/terraces.hpp"
#include "engine/surface/filter_choice.hpp"
#include "player/session/filter_words.hpp"

namespace touchable {
namespace {

struct MarkColour {
    const char* name;
    std::array<std::uint8_t, 3> rgb;
};
constexpr std::array<MarkColour, 6> mark_colours{{{"red", {255, 40, 40}},
                                                  {"yellow", {255, 230, 0}},
                                                  {"cyan", {0, 230, 255}},
                                                  {"magenta", {255, 60, 255}},
                                                  {"green", {60, 255, 60}},
                                                  {"orange", {255, 150, 0}}}};

std::string number(double value) {
    return short_number(value, 3);
}

std::string per_cent(double share) {
    return number(100 * share) + " %";
}

/// "1 frame is", "2 frames are".
std::string frames(std::int64_t count, const char* one, const char* several) {
    return std::to_string(count) + (count == 1 ? " frame " : " frames ") + (count == 1 ? one : several);
}

class Findings {
public:
    Findings(const ClipFacts& facts, const ClipQuality& quality) : facts_(facts), quality_(quality) {}

    std::vector<Finding> all() {
        look_at_times();
        look_at_pumping();
        look_at_filters();
        look_at_codes();
        look_at_colour();
        look_at_haptic();
        return std::move(found_);
    }

private:
    void add(const char* name, std::string what, std::string mend,
             const std::vector<std::uint8_t>* where = nullptr) {
        found_.push_back({name, std::move(what), std::move(mend), where});
    }
    double mm(double scene_units) const { return scene_units * facts_.scene.metres_per_unit * 1000; }
    std::string clip() const { return shell_word(facts_.clip); }

    void look_at_times();
    void look_at_pumping();
    void look_at_filters();
    void look_at_codes();
    void look_at_colour();
    void look_at_haptic();

    const ClipFacts& facts_;
    const ClipQuality& quality_;
    std::vector<Finding> found_;
};

void Findings::look_at_times() {
    const FrameTimes& times = quality_.times;
    if (times.jumps > 0)
        add("times",
            frames(times.jumps, "is", "are") +
                " dated before the one before, at once with it, or within a quarter of the usual time after "
                "it: the surface jumps there",
            "times that ascend evenly: those of a folder are in its list of times (docs/scene_file.md)");
    if (times.missing > 0)
        add("missing",
            frames(times.missing, "is", "are") + " missing: the surface stands still for up to " +
                number(times.longest_ms) + " ms (before frame " + std::to_string(times.longest_at) +
                "), usual are " + number(times.usual_ms),
            "touchable convert " + clip() + " OUT.mkv --from ... --to ... leaves them out");
    if (times.repeated == 0) return;
    const double every =
        static_cast<double>(times.changed + times.repeated) / static_cast<double>(times.changed);
    const auto nth = static_cast<int>(std::lround(every));
    const bool is_regular = nth > 1 && std::abs(every - nth) < 0.1;
    add("repeated",
        std::to_string(times.repeated) + " of " + std::to_string(times.frames) +
            " frames repeat the surface of the one before" +
            (times.of_new_colour > 0 ? ", under new colour in " + std::to_string(times.of_new_colour) : "") +
            ": what moves steadily is felt in jerks",
        is_regular ? "touchable convert " + clip() + " OUT.mkv --every " + std::to_string(nth)
                   : "record depth at the rate of the clip, or convert at its own");
}

void Findings::look_at_pumping() {
    if (quality_.blank > 0)
        add("blank",
            frames(quality_.blank, "has", "have") + " no depth at all, the first is " +
                std::to_string(quality_.first_blank) + ": a finger falls through there",
            "touchable convert " + clip() + " OUT.mkv --from ... --to ... leaves them out");
    const double share = quality_.pumping.value_or(0);
    if (share < 0.001 || !facts_.measured) return;
    const bool may_be_aligned = facts_.scene.depth.kind == DepthCodingKind::linear ||
                                facts_.scene.depth.kind == DepthCodingKind::inverse;
    add("pumping",
        "the depth of whole pictures goes to and fro by " + per_cent(share) + " from frame to frame, " +
            number(mm(share * facts_.measured->median)) + " mm at " +
            number(mm(facts_.measured->median) / 1000) + " m: a finger at rest feels a pulse",
        may_be_aligned
            ? "touchable convert " + clip() + " OUT.mkv --align on"
            : "frames that are of one place and one scale; depth of a network that is none in metres is "
              "aligned where it is opened with --preset relative-inverse");
}

/// Filters that measurement would choose, and that are off.
void Findings::look_at_filters() {
    if (!facts_.measured) return;
    Scene automatic = facts_.scene;
    automatic.filter = {};
    choose_filters(facts_.measured, all_unstated, automatic);
    const FilterSettings &wanted = automatic.filter, &has = facts_.scene.filter;
    const double per_unit = facts_.scene.metres_per_unit;
    if (wanted.terraces == TerraceRemoval::on && has.terraces != TerraceRemoval::on)
        add("terraces",
            "flat places are stairs: levels are " + levels_in_words(*facts_.measured, per_unit) +
                ", and their removal is off",
            "touchable touch " + clip() + " --terraces on", &quality_.where.level_steps);
    if (wanted.temporal && !has.temporal)
        add("flicker",
            "depth flickers where nothing moves (" + noise_in_words(*facts_.measured, per_unit) +
                "), and averaging is off",
            "touchable touch " + clip() + " --temporal on");
    if (wanted.fill_holes > 0 && has.fill_holes == 0)
        add("holes",
            per_cent(facts_.measured->tiny_holes) +
                " of the pixels are tiny holes, in which a finger gets caught",
            "touchable touch " + clip() + " --fill-holes " + std::to_string(wanted.fill_holes));
    if (wanted.flying_pixels != DepthLength{} && has.flying_pixels == DepthLength{})
        add("flying",
            per_cent(facts_.measured->flying) + " of the pixels hang between two surfaces: rims are slopes",
            "touchable touch " + clip() + " --filters auto");
}

void Findings::look_at_codes() {
    if (!facts_.measured || facts_.measured->kappa < kappa_of_terraces) return;
    Scene scene = facts_.scene;
    scene.filter.levels = facts_.measured->levels;
    if (has_working_codes(scene)) return;
    add("codes",
        "codes are too coarse for their pixels: one step is " + number(mm(facts_.measured->distance)) +
            " mm deep, a pixel " + number(mm(facts_.measured->pixel)) +
            " mm wide, and there is no room for finer ones between them",
        "record or export with near and far planes closer to what is there", &quality_.where.level_steps);
}

void Findings::look_at_colour() {
    if (!quality_.colour) return;
    const ColourEdges::Fit& fit = *quality_.colour;
    const double right = fit.right.value_or(0), below = fit.below.value_or(0);
    const auto* where = &quality_.where.colour_edges;
    const char* colour_camera =
        "a scene file that says where the colour camera stands: colour_camera (docs/scene_file.md)";
    if (!fit.agrees())
        return add(
            "registration",
            "colour's edges do not lie at depth's: only " + per_cent(fit.agreement) + " of " +
                std::to_string(fit.edges) +
                " agree on a place, so colour lies far beside depth, or is of something else: a finger "
                "touches something else than it seems to touch",
            colour_camera, where);
    if (std::max(std::abs(right), std::abs(below)) >= 1.5)
        add("registration",
            "colour is not where depth is: " + number(std::abs(right)) + " pixels to the " +
                (right < 0 ? "left" : "right") + ", " + number(std::abs(below)) +
                (below < 0 ? " above" : " below") + " (" + std::to_string(fit.edges) +
                " edges): a finger touches beside what it seems to touch",
            "a scene file that says where the colour camera stands: colour_camera (docs/scene_file.md)",
            where);
    if (std::abs(fit.rim) >= 1.5)
        add("rims",
            fit.rim > 0
                ? "near surfaces reach " + number(fit.rim) +
                      " pixels beyond their colour: the background's colour bleeds onto their rims"
                : "near surfaces end " + number(-fit.rim) +
                      " pixels before their colour does: their colour bleeds onto what is behind them",
            "touchable relief " + clip() +
                " OUT.mkv leaves two pixels at rims without relief; depth made at colour's size has less of "
                "it",
            where);
}

void Findings::look_at_haptic() {
    if (!quality_.haptic) return;
    const HapticValues& values = *quality_.haptic;
    const auto& where = quality_.where.haptic;
    const auto track = std::find_if(facts_.tracks.begin(), facts_.tracks.end(),
                                    [](const TrackInfo& info) { return info.role == "haptic"; });
    if (track != facts_.tracks.end() && !track->lossless && values.mixed > 0.02)
        add("mixed",
            "stiffness and friction wander from pixel to pixel in " + per_cent(values.mixed) +
                " of the surface: their coding, " + track->codec + " in " + track->pixel_format +
                ", mixes materials",
            "touchable convert ORIGINAL OUT.mkv, of the pictures before they were coded so", &where.mixed);
    if (values.too_stiff > 0)
        add("stiffness",
            per_cent(values.too_stiff) + " of the surface is stiffer than " + number(stiffest_of_devices) +
                " N/mm (up to " + number(values.stiffest) +
                "): no hand-held device renders more, so all of that feels alike",
            "a scene file with a smaller haptic.stiffness range, which keeps their differences",
            &where.too_stiff);
    if (values.more_dynamic > 0)
        add("friction",
            per_cent(values.more_dynamic) +
                " of the surface has more dynamic than static friction; nothing has, so static friction "
                "counts for both",
            "a scene file with other ranges of haptic.static_friction and haptic.dynamic_friction",
            &where.more_dynamic);
}

/// Whether it is anywhere in the first frame.
bool is_marked(const Finding& finding) {
    return finding.where != nullptr &&
           std::find(finding.where->begin(), finding.where->end(), 1) != finding.where->end();
}

/// Of findings that are marked, one after the other. Those that are at the same places share a colour.
std::size_t colour_index(const std::vector<Finding>& findings, std::size_t k) {
    std::vector<const void*> places;
    for (const Finding& finding : findings)
        if (is_marked(finding) && std::find(places.begin(), places.end(), finding.where) == places.end())
            places.push_back(finding.where);
    const auto at = std::find(places.begin(), places.end(), findings[k].where) - places.begin();
    return static_cast<std::size_t>(at) % mark_colours.size();
}

}  // namespace

std::vector<Finding> findings_of(const ClipFacts& facts, const ClipQuality& quality) {
    return Findings(facts, quality).all();
}

std::string colour_of(const std::vector<Finding>& findings, std::size_t k) {
    return is_marked(findings[k]) ? mark_colours[colour_index(findings, k)].name : std::string();
}

Image picture_of(const std::vector<Finding>& findings, const Image& first_frame) {
    Image image = first_frame;
    for (std::uint8_t& value : image.samples) value = static_cast<std::uint8_t>(value / 2);
    for (std::size_t k = 0; k < findings.size(); ++k) {
        if (!is_marked(findings[k])) continue;
        const auto& rgb = mark_colours[colour_index(findings, k)].rgb;
        for (std::size_t pixel = 0; pixel < findings[k].where->size(); ++pixel)
            if ((*findings[k].where)[pixel] != 0)
                std::copy(rgb.begin(), rgb.end(),
                          image.samples.begin() + static_cast<std::ptrdiff_t>(3 * pixel));
    }
    return image;
}

}  // namespace touchable
