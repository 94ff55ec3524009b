// SPDX-License-Identifier: Apache-2.0
#include "player/commands/reports.hpp"

#include "engine/base/hand_thresholds.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/option_types.hpp"
#include "player/run/terminal.hpp"

namespace touchable {

using Json = nlohmann::ordered_json;

namespace {

Json length(const DepthLength& value) {
    return {value.constant, value.quadratic};
}

/// Roughness that each tried filter set leaves on the clip's smooth places.
Json tried_json(const std::vector<TriedFilters>& tried) {
    Json out = Json::array();
    for (const TriedFilters& one : tried) {
        Json filters{{"temporal", one.temporal}, {"median", one.median}, {"terraces", one.terraces}};
        if (one.terraces) filters["levels"] = length(one.levels);
        filters["left_degrees"] = one.left_deg;
        filters["left_jnd"] = direction_jnd(one.left_deg);
        out.push_back(std::move(filters));
    }
    return out;
}

Json measured_json(const MeasuredDepth& measured) {
    return {{"median_depth", measured.median},
            {"farthest_depth", measured.farthest},
            {"pixel_width", measured.pixel},
            {"levels", length(measured.levels)},
            {"level_distance", measured.distance},
            {"kappa", measured.kappa},
            {"contour_width", measured.contours.width},
            {"contour_height", measured.contours.height},
            {"noise", length(measured.noise)},
            {"noise_at_median", measured.noise_at_median()},
            {"noise_at_edges", measured.noise_at_edges},
            {"noise_at_rims", measured.noise_at_rims},
            {"roughness", measured.roughness},
            {"wide_roughness", measured.wide_roughness},
            {"smooth", measured.smooth},
            {"changing", measured.changing},
            {"dropouts", measured.dropouts},
            {"tiny_holes", measured.tiny_holes},
            {"flying", measured.flying},
            {"midway", measured.midway},
            {"clean_edges", measured.clean_edges},
            {"from_a_camera", measured.from_a_camera()},
            {"searched", measured.is_searched()},
            {"tried", tried_json(measured.tried)}};
}

/// Angle that `pixels` span, seen from the centre `c` at focal length `f`.
double field_of_view_degrees(int pixels, double c, double f) {
    return (arctangent((c + 0.5) / f) + arctangent((pixels - 0.5 - c) / f)) * 180.0 / pi;
}

/// From the first frame: share of invalid stored values, range of the valid ones, share of torn neighbours.
void add_first_frame(const RawFrame& frame, ClipFacts& facts) {
    const DepthCoding& coding = facts.scene.depth;
    std::vector<float> depths(65536);  // by code; 0: invalid
    for (std::size_t code = 0; code < depths.size(); ++code)
        if (coding.is_valid(static_cast<std::uint16_t>(code)))
            depths[code] = static_cast<float>(coding.depth(static_cast<std::uint16_t>(code)));
    std::int64_t invalid = 0, neighbours = 0, torn = 0;
    std::uint16_t least = 65535, greatest = 0;
    for (int y = 0; y < frame.depth.height && !stop_requested(); ++y) {
        float left = 0;
        for (int x = 0; x < frame.depth.width; ++x) {
            const std::uint16_t code = stored_code(frame.depth, coding, x, y);
            const float depth = depths[code];
            if (left > 0 && depth > 0) {
                ++neighbours;
                torn += left > 2 * depth || depth > 2 * left;
            }
            left = depth;
            if (!coding.is_valid(code)) {
                ++invalid;
                continue;
            }
            least = std::min(least, code);
            greatest = std::max(greatest, code);
        }
    }
    if (neighbours > 0) facts.torn = static_cast<double>(torn) / static_cast<double>(neighbours);
    const auto pixels = static_cast<double>(frame.depth.width) * frame.depth.height;
    facts.invalid_pct = 100.0 * static_cast<double>(invalid) / pixels;
    if (least > greatest) return;
    facts.nearest = coding.depth(coding.deeper_is_higher() ? least : greatest);
    facts.farthest = coding.depth(coding.deeper_is_higher() ? greatest : least);
}

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

/// A finding and its mask of the first frame, 1 at affected pixels; nullptr: no place.
struct PlacedFinding : Finding {
    const std::vector<std::uint8_t>* where;
};

/// Whether what looks like noise in one picture may be relief: the clip says that its depth has no noise.
bool may_be_relief(const ClipFacts& facts) {
    return facts.measured && !facts.measured->from_a_camera() && facts.chosen && !facts.chosen->chosen.median;
}

/// All findings, the most important for the hand first. PlacedFinding::where points into `quality`.
class Findings {
public:
    Findings(const ClipFacts& facts, const ClipQuality& quality) : facts_(facts), quality_(quality) {}

    std::vector<PlacedFinding> all() {
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
        found_.push_back({{name, std::move(what), std::move(mend)}, where});
    }
    double mm(double scene_units) const { return scene_units * facts_.scene.metres_per_unit * 1000; }
    std::string clip() const { return shell_word(facts_.clip); }

    void look_at_times() {
        const ClipQuality::FrameTimes& times = quality_.times;
        if (times.jumps > 0)
            add("times",
                counted(times.jumps, "frame is", "frames are") +
                    " dated before the one before, at once with it, or within a quarter of the usual time "
                    "after it: the surface jumps there",
                "times that ascend evenly: those of a folder are in its list of times (docs/scene_file.md)");
        if (times.missing > 0)
            add("missing",
                counted(times.missing, "frame is", "frames are") +
                    " missing: the surface stands still for up to " + number(times.longest_ms) +
                    " ms (before frame " + std::to_string(times.longest_at) + "), usual are " +
                    number(times.usual_ms),
                "touchable convert " + clip() + " OUT.mkv --from ... --to ... leaves them out");
        if (times.repeated == 0) return;
        const double every =
            static_cast<double>(times.changed + times.repeated) / static_cast<double>(times.changed);
        const auto nth = static_cast<int>(std::lround(every));
        const bool is_regular = nth > 1 && std::abs(every - nth) < 0.1;
        add("repeated",
            std::to_string(times.repeated) + " of " + std::to_string(times.frames) +
                " frames repeat the surface of the one before" +
                (times.of_new_colour > 0 ? ", under new colour in " + std::to_string(times.of_new_colour)
                                         : "") +
                ": what moves steadily is felt in jerks",
            is_regular ? "touchable convert " + clip() + " OUT.mkv --every " + std::to_string(nth)
                       : "record depth at the rate of the clip, or convert at its own");
    }
    void look_at_pumping() {
        if (quality_.blank > 0)
            add("blank",
                counted(quality_.blank, "frame has", "frames have") + " no depth at all, the first is " +
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
            may_be_aligned ? "touchable convert " + clip() + " OUT.mkv --align on"
                           : "frames that are of one place and one scale; depth of a network that is none in "
                             "metres is aligned where it is opened with --preset relative-inverse");
    }
    /// Filters that are off although measurement would choose them.
    void look_at_filters() {
        if (!facts_.measured) return;
        Scene automatic = facts_.scene;
        automatic.filter = {};
        UnstatedFilters open = all_unstated;
        if (may_be_relief(facts_)) open.median = open.temporal = false;
        choose_filters(facts_.measured, open, automatic);
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
                per_cent(facts_.measured->flying) +
                    " of the pixels hang between two surfaces: rims are slopes",
                "touchable touch " + clip() + " --filters auto");
    }
    void look_at_codes() {
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
    void look_at_colour() {
        if (!quality_.colour) return;
        const ClipQuality::ColourFit& fit = *quality_.colour;
        const double right = fit.right.value_or(0), below = fit.below.value_or(0);
        const auto* where = &quality_.where.colour_edges;
        const char* colour_camera =
            "a scene file that says where the colour camera stands: colour_camera (docs/scene_file.md)";
        if (!fit.agrees())
            return add("registration",
                       "colour's edges do not lie at depth's: only " + per_cent(fit.agreement) + " of " +
                           std::to_string(fit.edges) +
                           " agree on a place, so colour lies far beside depth, or is of something else: a "
                           "finger touches something else than it seems to touch",
                       colour_camera, where);
        if (std::max(std::abs(right), std::abs(below)) >= 1.5)
            add("registration",
                "colour is not where depth is: " + number(std::abs(right)) + " pixels to the " +
                    (right < 0 ? "left" : "right") + ", " + number(std::abs(below)) +
                    (below < 0 ? " above" : " below") + " (" + std::to_string(fit.edges) +
                    " edges): a finger touches beside what it seems to touch",
                colour_camera, where);
        if (std::abs(fit.rim) >= 1.5)
            add("rims",
                fit.rim > 0
                    ? "near surfaces reach " + number(fit.rim) +
                          " pixels beyond their colour: the background's colour bleeds onto their rims"
                    : "near surfaces end " + number(-fit.rim) +
                          " pixels before their colour does: their colour bleeds onto what is behind them",
                "touchable relief " + clip() +
                    " OUT.mkv leaves two pixels at rims without relief; depth made at colour's size has less "
                    "of it",
                where);
    }
    void look_at_haptic() {
        if (!quality_.haptic) return;
        const ClipQuality::HapticValues& values = *quality_.haptic;
        const auto& where = quality_.where.haptic;
        const auto track = std::ranges::find(facts_.tracks, "haptic", &TrackInfo::role);
        if (track != facts_.tracks.end() && !track->lossless && values.mixed > 0.02)
            add("mixed",
                "stiffness and friction wander from pixel to pixel in " + per_cent(values.mixed) +
                    " of the surface: their coding, " + track->codec + " in " + track->pixel_format +
                    ", mixes materials",
                "touchable convert ORIGINAL OUT.mkv, of the pictures before they were coded so",
                &where.mixed);
        if (values.too_stiff > 0)
            add("stiffness",
                per_cent(values.too_stiff) + " of the surface is stiffer than " +
                    number(stiffest_of_devices) + " N/mm (up to " + number(values.stiffest) +
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

    const ClipFacts& facts_;
    const ClipQuality& quality_;
    std::vector<PlacedFinding> found_;
};

/// Whether the finding marks any pixel of the first frame.
bool is_marked(const PlacedFinding& finding) {
    return finding.where != nullptr && std::ranges::find(*finding.where, 1) != finding.where->end();
}

/// Returns each finding's colour, nullptr for one that marks nothing. Findings with the same `where` share a
/// colour.
std::vector<const MarkColour*> colours_of(const std::vector<PlacedFinding>& findings) {
    std::vector<const void*> places;
    std::vector<const MarkColour*> colours;
    for (const PlacedFinding& finding : findings) {
        auto at = std::ranges::find(places, finding.where);
        if (is_marked(finding) && at == places.end()) at = places.insert(at, finding.where);
        const auto index = static_cast<std::size_t>(at - places.begin()) % mark_colours.size();
        colours.push_back(is_marked(finding) ? &mark_colours[index] : nullptr);
    }
    return colours;
}

/// The first frame, darkened, with the places of findings in their colours.
Image picture_of(const std::vector<PlacedFinding>& findings, const std::vector<const MarkColour*>& colours,
                 const Image& first_frame) {
    Image image = first_frame;
    for (std::uint8_t& value : image.samples) value = static_cast<std::uint8_t>(value / 2);
    for (std::size_t k = 0; k < findings.size(); ++k)
        for (std::size_t pixel = 0; colours[k] && pixel < findings[k].where->size(); ++pixel)
            if ((*findings[k].where)[pixel] != 0)
                std::ranges::copy(colours[k]->rgb,
                                  image.samples.begin() + static_cast<std::ptrdiff_t>(3 * pixel));
    return image;
}

nlohmann::ordered_json measures_json(const ClipQuality& quality) {
    const ClipQuality::FrameTimes& times = quality.times;
    nlohmann::ordered_json json{{"frames", times.frames},
                                {"repeated", times.repeated},
                                {"missing", times.missing},
                                {"jumps", times.jumps},
                                {"longest_ms", times.longest_ms}};
    if (quality.pumping) json["pumping"] = *quality.pumping;
    if (quality.colour) {
        const ClipQuality::ColourFit& fit = *quality.colour;
        const auto known = [](const std::optional<double>& value) {
            return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
        };
        json["colour_edges"] = {{"edges", fit.edges},
                                {"agreement", fit.agreement},
                                {"right", known(fit.right)},
                                {"below", known(fit.below)},
                                {"rim", fit.rim}};
    }
    if (quality.haptic)
        json["haptic"] = {{"stiffest_n_per_mm", quality.haptic->stiffest},
                          {"too_stiff", quality.haptic->too_stiff},
                          {"more_dynamic", quality.haptic->more_dynamic},
                          {"mixed", quality.haptic->mixed}};
    return json;
}

std::string measures_in_words(const ClipQuality& quality, bool has_colour) {
    std::string words = counted(quality.times.frames, "frame");
    if (quality.pumping) words += "; depth goes to and fro by " + number(100 * *quality.pumping) + " %";
    if (!has_colour) return words + "; no colour, which could be beside depth";
    if (!quality.colour) return words + "; too few edges to tell whether colour is where depth is";
    const ClipQuality::ColourFit& fit = *quality.colour;
    words += "; colour against depth at " + std::to_string(fit.edges) + " edges (" +
             number(100 * fit.agreement) + " % agree):";
    if (fit.right) words += ' ' + number(*fit.right) + " pixels to the right,";
    if (fit.below) words += ' ' + number(*fit.below) + " below,";
    return words + " rims " + number(fit.rim) + " wide";
}

/// Smooth places whose slope varies by more than this feel rough.
constexpr double rough_deg = 10;
/// Filters that leave less than this share of the active filters' roughness are worth mentioning.
constexpr double worth_while = 0.67;
constexpr int frames_to_settle = 8;
constexpr double many_holes_pct = 60, nearly_all_holes_pct = 90;
/// Share of neighbours an octave apart: a third and more if values are not depth but swapped bytes or packed
/// numbers; below a twentieth for a room's depth.
constexpr double much_torn = 0.2;

/// What the verdict says of a guess; the most important first.
struct GuessWords {
    RemarkKind kind;
    const char* name;           ///< beside a more important one
    const char* verdict;        ///< before the remark
    const char *cure, *option;  ///< around "touchable play CLIP"
};
constexpr GuessWords guess_words[] = {
    {RemarkKind::direction, "whether it is inside out", "may be inside out", "",
     " --preset relative-inverse"},
    {RemarkKind::planes, "its near and far plane", "not true to shape", "say both, ",
     " --near METRES --far METRES"},
    {RemarkKind::scale, "its size", "good to touch if its size is right",
     "say the unit if values are lengths, ", " --depth-unit METRES, or near and far in a scene file"},
    {RemarkKind::unclear_unit, "the unit", "good to touch if the unit is right", "say it, ",
     " --depth-unit METRES"},
    {RemarkKind::camera, "the camera", "good to touch if the camera is right", "say what it sees, ",
     " --fov DEGREES"},
    {RemarkKind::unit, "the unit", "good to touch if the unit is right", "say it, ", " --depth-unit METRES"},
    {RemarkKind::storage, "how depth is stored", "good to touch if the way in which depth is stored is right",
     "name it, ", " --preset NAME"},
    {RemarkKind::axis, "range or planar", "good to touch if depth is", "say which, ",
     " --depth planar, or --depth range"},
    {RemarkKind::colour_place, "where colour lies", "good to touch; colour may be shifted", "", ""}};

/// Guesses that, if wrong, would change forces by more than a tenth or displace colour; the most important
/// first.
std::vector<std::pair<const GuessWords*, const Remark*>> guesses_that_matter(const ClipFacts& facts) {
    constexpr double much = 0.1, nearest = 0.1, farthest = 20;  // metres; usual distances of a camera's scene
    const double median = facts.measured ? facts.measured->median * facts.scene.metres_per_unit : 1;
    const Scene& scene = facts.scene;
    std::vector<std::pair<const GuessWords*, const Remark*>> guesses;
    for (const Remark& remark : scene.remarks) {
        const bool is_far = median < nearest || median > farthest;
        const RemarkKind kind =
            remark.kind == RemarkKind::unit && is_far ? RemarkKind::unclear_unit : remark.kind;
        const auto* const words = std::ranges::find(guess_words, kind, &GuessWords::kind);
        if (words == std::end(guess_words)) continue;
        if (kind == RemarkKind::axis && scene.camera.longest_ray(scene.width, scene.height) < 1 / (1 - much))
            continue;
        guesses.emplace_back(words, &remark);
    }
    std::ranges::stable_sort(guesses, {}, [](const auto& guess) { return guess.first; });
    return guesses;
}

/// Names the most important guess and how to correct it.
std::string verdict_on_guess(const GuessWords& words, const Remark& remark, const ClipFacts& facts) {
    const std::string clip = shell_word(facts.clip);
    std::string verdict = words.verdict;
    if (words.kind == RemarkKind::axis)
        verdict += facts.scene.depth.semantics == DepthSemantics::range ? " range" : " planar";
    verdict += " (" + remark.what;
    if (words.kind == RemarkKind::unclear_unit && !remark.otherwise.empty())
        verdict += "; " + remark.otherwise;
    verdict += "): ";
    if (words.kind == RemarkKind::colour_place)
        return verdict + "a scene file's colour_camera says where it lies";
    if (words.kind == RemarkKind::direction) verdict += "if what is near looks far, ";
    // A clip with its own scene takes no such options (SceneDescription), and some need a scene file.
    const bool takes_option = !remark.hints.empty() && remark.hints.front().setting != Setting::scene_file;
    return verdict + (takes_option ? words.cure + ("touchable play " + clip) + words.option
                                   : "touchable init-scene " + clip + " writes a scene file to say it in");
}

std::string degrees(double value) {
    return short_number(value, 2) + " degrees";
}

}  // namespace

Json filters_json(const Scene& scene, const std::optional<ChosenFilters>& chosen,
                  const std::optional<MeasuredDepth>& measured) {
    const FilterSettings& filter = scene.filter;
    Json out;
    for (const FilterSetting& setting : filter_settings()) {
        const SettingRange& range = setting.range;
        const DepthLength value = setting.value.of(filter);
        out[setting.name] = range.is_length     ? length(value)
                            : range.has_names() ? Json(range.word_of(value.constant) == "on")
                            : range.whole       ? Json(static_cast<int>(value.constant))
                                                : Json(value.constant);
    }
    out["in_words"] = filters_in_words(scene, chosen);
    if (measured) out["measured"] = measured_json(*measured);
    if (const auto to = measured ? measured->trusted_to(filter) : std::nullopt) out["trusted_to"] = *to;
    if (!chosen) return out;
    // List the reach only if terrace removal is on and was not itself chosen.
    FilterSet told = chosen->chosen;
    told.terrace_reach = told.terrace_reach && !told.terraces && filter.terraces == TerraceRemoval::on;
    out["chosen"] = Json::array();
    for (const FilterSetting& setting : filter_settings())
        if (setting.open && told.*setting.open) out["chosen"].push_back(setting.name);
    return out;
}

/// Of the last of a few frames, as filters in time need some: measure_depth has kept them in memory.
Result<void> add_error_bars(const RawFrame& first, ClipReader& reader, ClipFacts& facts) {
    const auto builder = with_error_bars(make_cpu_builder(facts.scene), facts.scene);
    SurfaceFrame surface;
    TRY(builder->build(first, surface));
    for (int n = 1; n < (facts.scene.filter.temporal ? frames_to_settle : 1) && !stop_requested(); ++n) {
        const auto frame = reader.next();
        if (!frame || !*frame) break;
        TRY(builder->build(**frame, surface));
    }
    const MeasuredDepth& measured = *facts.measured;
    const FilterSettings& filter = facts.scene.filter;
    facts.bars_hold = measured.trusted_to(filter) != 0;
    std::vector<double> bars;
    for (const ErrorSigns::Block& block : surface.signs.blocks)
        if (const double bar = surface.signs.bar(block).degrees;
            bar >= 0 && (!facts.bars_hold || error_bars_hold(measured, filter, block.depth)))
            bars.push_back(bar);
    if (bars.empty()) return {};
    const auto below = [&](std::size_t tenths) { return sorted_element(bars, bars.size() * tenths / 10); };
    facts.error_degrees = {{below(1), below(5), below(9)}};
    return {};
}

Result<ClipFacts> clip_facts(const ClipChoice& choice) {
    TRY_ASSIGN(auto clip, open_chosen(choice, Colour::left_out));
    ClipFacts facts;
    facts.clip = without_passphrase(choice.file.string());
    facts.scene = clip.scene;
    facts.chosen = clip.chosen;
    if (facts.chosen) {
        facts.measured = facts.chosen->measured;
    } else {
        TRY_ASSIGN(auto measured, measure_depth(clip.reader, facts.scene));
        facts.measured = std::move(measured.measured);
    }
    TRY_ASSIGN(const auto first, clip.reader->next());
    if (!first) return input_error(facts.clip + " has no frames; a clip needs at least one");
    facts.tracks = clip.reader->tracks();
    facts.frames = clip.reader->frame_count();
    std::vector<Remark> remarks = remarks_of(*clip.reader);
    if (facts.measured)
        if (auto doubt = unit_doubt(facts.measured->median * facts.scene.metres_per_unit,
                                    "a scene file's metres_per_unit and depth say otherwise",
                                    {{Setting::scene_file, "FILE"}})) {
            const auto there = std::ranges::find(remarks, RemarkKind::unit_doubt, &Remark::kind);
            facts.unit_doubt = remark_with_options(there == remarks.end() ? *doubt : *there);
            if (there == remarks.end()) remarks.push_back(std::move(*doubt));
        }
    facts.notes = remarks_with_options(remarks);
    add_first_frame(*first, facts);
    if (facts.measured && facts.measured->is_searched()) TRY(add_error_bars(*first, *clip.reader, facts));
    if (stop_requested()) return interrupted_error();

    const Camera& camera = facts.scene.camera;
    facts.fov_x_degrees = field_of_view_degrees(facts.scene.width, camera.cx, camera.fx);
    facts.fov_y_degrees = field_of_view_degrees(facts.scene.height, camera.cy, camera.fy);
    const DepthCoding& coding = facts.scene.depth;
    const double near = coding.near > 0 ? coding.near : facts.nearest > 0 ? facts.nearest : coding.far;
    const auto kappa_at = [&](double depth) { return Kappa{depth, kappa_of_depth(facts.scene, depth)}; };
    facts.near = kappa_at(near);
    facts.mid = kappa_at(0.5 * (near + coding.far));
    facts.far = kappa_at(coding.far);
    return facts;
}

Result<Verified> verify_clip(const ClipChoice& choice, const ClipFacts& facts, const VerifyPicture& picture) {
    TRY_ASSIGN(auto clip, open_chosen(choice, Colour::wanted));
    std::optional<NewFile> file;
    if (picture.file) {
        TRY(check_outputs({{{"--picture", *picture.file}}, picture.existing},
                          inputs_of(choice, *clip.reader)));
        file.emplace(*picture.file, picture.existing);
        TRY(file->hold());
    }
    Scene scene = facts.scene;
    if (facts.measured) scene.filter.levels = facts.measured->levels;
    Progress progress("looking at frame", facts.frames.value_or(0));
    TRY_ASSIGN(const auto quality,
               measure_quality(*clip.reader, scene, [&](std::int64_t frames) { progress.at(frames); }));
    const auto findings = Findings(facts, quality).all();
    Verified verified;
    verified.findings.assign(findings.begin(), findings.end());
    if (file) {
        const auto colours = colours_of(findings);
        TRY(write_png(*file, picture_of(findings, colours, quality.where.picture).view()));
        TRY(file->commit());
        for (std::size_t k = 0; k < findings.size(); ++k)
            if (colours[k]) verified.findings[k].colour = colours[k]->name;
    }
    verified.drawn = file.has_value();
    verified.measures = measures_json(quality);
    verified.measures_in_words = measures_in_words(quality, facts.has_track("colour"));
    return verified;
}

std::string verified_in_words(const Verified& verified) {
    std::string words = "  verified     " + verified.measures_in_words + '\n';
    if (verified.findings.empty()) words += "  fine         nothing was found that would feel wrong\n";
    for (const Finding& finding : verified.findings) {
        words += "  wrong        " + finding.name + ": " + finding.what +
                 (finding.colour.empty() ? std::string() : " (" + finding.colour + " in the picture)") + '\n';
        words += "  mended by    " + finding.mend + '\n';
    }
    const bool is_marked = std::ranges::any_of(
        verified.findings, [](const Finding& finding) { return !finding.colour.empty(); });
    if (verified.drawn && !is_marked)
        words += "  picture      has no marks: nothing of this has a place in the first frame\n";
    return words;
}

void add_verified(const Verified& verified, nlohmann::ordered_json& json) {
    json["measures"] = verified.measures;
    json["findings"] = nlohmann::ordered_json::array();
    for (const Finding& finding : verified.findings) {
        json["findings"].push_back({{"name", finding.name}, {"what", finding.what}, {"mend", finding.mend}});
        if (!finding.colour.empty()) json["findings"].back()["colour"] = finding.colour;
    }
}

std::string verdict_on(const ClipFacts& facts, const std::vector<Finding>* findings) {
    const std::string clip = shell_word(facts.clip);
    if (facts.nearest == 0 && facts.farthest == 0) return "nothing to touch: the first frame has no depth";
    if (!facts.unit_doubt.empty()) return facts.unit_doubt;
    if (facts.torn > much_torn)
        return "hardly depth: " + per_cent(facts.torn) +
               " of neighbouring pixels differ by more than a factor of two: the values may mean something "
               "else, touchable formats lists what is known by name (--preset NAME)";
    if (facts.measured && facts.measured->alternates_by > 1)
        return "frames of two kinds take turns, one " + number(facts.measured->alternates_by) +
               " times as deep as the next: two kinds of pictures may lie in one folder, or two cameras in "
               "one clip; give one alone";
    const auto* const measured = facts.measured ? &*facts.measured : nullptr;
    const TriedFilters* const now = measured ? found_among(measured->tried, facts.scene.filter) : nullptr;
    const TriedFilters* const best =
        measured ? mildest_of_the_best(measured->tried, measured->is_noisy(facts.scene.width)) : nullptr;
    const bool is_rough = now && best && now->left_deg > rough_deg && !may_be_relief(facts);
    if (is_rough && best->left_deg < worth_while * now->left_deg)
        return "rough: smooth places lean " + degrees(now->left_deg) + " to and fro (" +
               direction_jnd_words(now->left_deg) + "), and " + degrees(best->left_deg) +
               " with other filters: touchable play " + clip + " --filters auto";
    if (findings != nullptr && !findings->empty())
        return findings->front().name + ", see above: " + findings->front().mend;
    const std::string little =
        "little to touch: " + short_number(facts.invalid_pct, 2) + " % of the first frame has no depth";
    if (facts.invalid_pct > nearly_all_holes_pct) return little;
    if (const auto guesses = guesses_that_matter(facts); !guesses.empty()) {
        const auto& [words, remark] = guesses.front();
        std::vector<std::string> others;
        for (const auto& [other, what] : std::span(guesses).subspan(1))
            if (other != words && (others.empty() || others.back() != other->name))
                others.emplace_back(other->name);
        return verdict_on_guess(*words, *remark, facts) +
               (others.empty() ? "" : "; guessed too: " + listed(others));
    }
    if (facts.invalid_pct > many_holes_pct) return little;
    if (is_rough && measured->is_searched() && best->left_deg > rough_deg)
        return "rough: smooth places lean " + degrees(now->left_deg) + " to and fro (" +
               direction_jnd_words(now->left_deg) +
               "), whatever the filters: record from nearer, or with more light";
    if (facts.error_degrees && (*facts.error_degrees)[0] > hand_thresholds::felt_degrees)
        return "rough: at nine of ten places 5 of 100 forces err by more than " +
               degrees((*facts.error_degrees)[0]) + " (" + direction_jnd_words((*facts.error_degrees)[0]) +
               "): record from nearer, or with more light";
    if (measured && measured->trusted_to(facts.scene.filter) == 0)
        return "hardly to be felt: relief is smoothed away with its noise: record from nearer, or with more "
               "light";
    return "good to touch: touchable play " + clip;
}

}  // namespace touchable
