// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "engine/authoring/materials.hpp"
#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/image.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/convert_command.hpp"
#include "player/commands/option_types.hpp"
#include "player/run/terminal.hpp"
#include "player/session/clip_choice.hpp"
#include "player/window/window_command.hpp"

namespace touchable {
namespace {

struct MaterialsOptions {
    ClipChoice clip;
    std::filesystem::path out;   ///< NAME.mkv, NAME.png; empty: segments are only printed
    std::filesystem::path save;  ///< output file of the segments' names; empty: none
    Existing existing = Existing::keep;
    MaterialSettings materials{};             ///< its `ranges` are ignored
    std::optional<std::int64_t> frame;        ///< to describe or write as NAME.png; nothing: the first
    std::vector<std::filesystem::path> read;  ///< other files read, besides the clip
};

/// Unnamed segments smaller than this share are not printed one by one.
constexpr std::int64_t told_permille = 5;

std::string segment_line(const MaterialReport::Seen& segment, double of_pixels) {
    std::string at = std::to_string(segment.at.x) + ',' + std::to_string(segment.at.y);
    if (segment.at.frame > 0) at += ',' + std::to_string(segment.at.frame);
    const std::string material = segment.paint.material.empty() ? "own values" : segment.paint.material;
    std::string line = formatted("  %5d  %-14s %6.1f %%  #%02x%02x%02x  %-10s ", segment.label, at.c_str(),
                                 100 * segment.pixels / of_pixels, segment.colour[0], segment.colour[1],
                                 segment.colour[2], material.c_str());
    line += segment.paint.is_guess       ? "guess"
            : segment.paint.name.empty() ? "all others"
                                         : printable(segment.paint.name);
    const HapticProperties& felt = segment.paint.feel.properties;
    return line + formatted(": %.3g N/mm, friction %.3g and %.3g\n", felt.stiffness / 1000,
                            felt.static_friction, felt.dynamic_friction);
}

/// `has_cuts`: the segments were found earlier, so the time it took is unknown.
std::string report_in_words(const MaterialReport& report, const Scene& scene, bool has_cuts) {
    const double of_pixels = static_cast<double>(scene.width) * scene.height;
    std::vector<MaterialReport::Seen> told = report.segments;
    std::erase_if(told, [&](const MaterialReport::Seen& segment) {
        return (segment.paint.name.empty() || segment.paint.is_guess) &&
               std::int64_t{1000} * segment.pixels < told_permille * scene.width * scene.height;
    });
    std::ranges::stable_sort(told, std::greater(), &MaterialReport::Seen::pixels);
    std::string words = "  label  --at            share  colour   material\n";
    bool guessed = false;
    for (const MaterialReport::Seen& segment : told) {
        words += segment_line(segment, of_pixels);
        guessed = guessed || segment.paint.is_guess;
    }
    if (const std::size_t small = report.segments.size() - told.size(); small > 0)
        words += "  and " + std::to_string(small) + " of less than half a per cent of the picture\n";
    if (guessed)
        words +=
            "  Guesses are by colour and roughness alone. --material NAME=MATERIAL --at X,Y says what a "
            "segment is; --list has the materials.\n";
    if (report.compared > 0)
        words +=
            formatted("  steady   %.3f %% of the pixels change their segment from frame to frame\n",
                      100.0 * static_cast<double>(report.changed) / static_cast<double>(report.compared));
    if (report.seconds > 0 && !has_cuts)
        words += formatted("  speed    %.1f frames/s for segments and materials\n",
                           static_cast<double>(report.frames) / report.seconds);
    return words;
}

/// Names for --segments that repeat this run: the given names, and the first frame's guesses for correction.
SegmentNames used_names(const MaterialReport& report, const SegmentNames& given) {
    SegmentNames used;
    used.otherwise = given.otherwise;
    used.cuts = given.cuts;
    for (const MaterialReport::Seen& segment : report.segments) {
        const bool is_first_guess = segment.paint.is_guess && segment.at.frame == 0;
        if (segment.paint.name.empty() && !is_first_guess) continue;
        const auto known = std::ranges::find_if(used.segments, [&](const auto& name) {
            return !segment.paint.name.empty() && name.name == segment.paint.name &&
                   name.feel == segment.paint.feel && name.is_guess == segment.paint.is_guess;
        });
        if (known != used.segments.end()) {
            known->at.push_back(segment.at);
            continue;
        }
        NamedSegment name;
        name.name =
            segment.paint.name.empty() ? "segment " + std::to_string(segment.label) : segment.paint.name;
        name.material = segment.paint.material;
        name.feel = segment.paint.feel;
        name.at = {segment.at};
        name.is_guess = segment.paint.is_guess;
        used.segments.push_back(std::move(name));
    }
    return used;
}

/// Prints where a material's values are clamped to the clip's own ranges.
void say_what_is_cut(const MaterialReport& report, const HapticRanges& ranges) {
    for (const MaterialReport::Seen& segment : report.segments) {
        const auto say = [&](const char* what, double value, const PropertyRange& range) {
            const double felt = std::clamp(value, range.min, range.max);
            if (formatted("%.3g", felt) == formatted("%.3g", value)) return;
            std::cout << "  note: segment " << segment.label << ": " << what << ' '
                      << formatted("%.3g becomes %.3g", value, felt)
                      << ", as the clip's haptic ranges have it; NAME.mkv keeps it\n";
        };
        const HapticProperties& properties = segment.paint.feel.properties;
        say("stiffness", properties.stiffness / 1000, ranges.stiffness);
        say("static friction", properties.static_friction, ranges.static_friction);
        say("dynamic friction", properties.dynamic_friction, ranges.dynamic_friction);
    }
}

/// Writes the clip with its segments' materials, or one frame's haptic picture, or nothing; prints the
/// segments, their materials and their stability.
class MaterialsRun {
public:
    explicit MaterialsRun(const MaterialsOptions& options) : options_(options) {}
    Result<void> run() {
        const bool is_clip = options_.out.extension() == ".mkv";
        TRY(is_clip ? write_clip() : look());
        return save();
    }

private:
    Result<void> check_places(const ClipReader& clip) {
        std::vector<NamedFile> inputs = inputs_of(options_.clip, clip), outputs;
        for (const auto& file : options_.read) inputs.push_back({"a file that is read", file});
        if (!options_.out.empty()) outputs.push_back({"OUT", options_.out});
        if (!options_.save.empty()) outputs.push_back({"--save", options_.save});
        TRY(check_outputs({outputs, options_.existing}, inputs));
        if (options_.save.empty()) return {};
        saved_ = std::make_unique<NewFile>(options_.save, options_.existing);
        return saved_->hold();
    }

    Result<void> write_clip() {
        ConvertOptions convert;
        convert.clip = options_.clip;
        convert.out = options_.out;
        convert.existing = options_.existing;
        convert.made = {PlaneRole::haptic};
        if (options_.materials.scale_relief) convert.made.push_back(PlaneRole::height);
        convert.content = [this](std::unique_ptr<ClipReader> clip) -> Result<std::unique_ptr<ClipReader>> {
            TRY(check_places(*clip));
            scene_ = clip->scene();
            for (const TrackInfo& track : clip->tracks()) had_haptic_ = had_haptic_ || track.role == "haptic";
            return with_materials(std::move(clip), options_.materials, begin_segments, report_);
        };
        TRY(run_convert(convert));
        std::cout << report_in_words(*report_, scene_, !options_.materials.names.cuts.empty());
        if (options_.materials.scale_relief && had_haptic_)
            std::cout << "  note: CLIP has haptic pictures already: where --scale-relief made them with its "
                         "heights, these are scaled twice now\n";
        return {};
    }

    /// Describes one frame and, if requested, writes its haptic picture.
    Result<void> look() {
        TRY_ASSIGN(auto clip, options_.clip.open());
        TRY(check_places(*clip));
        if (!options_.out.empty() && !options_.frame && clip->frame_count() != 1)
            return usage_error("OUT " + options_.out.string() +
                               " is a map of one frame, but the clip has more: --frame says which one; "
                               "NAME.mkv holds them all");
        scene_ = clip->scene();
        MaterialSettings settings = options_.materials;
        if (!options_.out.empty()) settings.ranges = scene_.haptic;
        TRY_ASSIGN(auto felt, with_materials(std::move(clip), settings, begin_segments, report_));
        TRY_ASSIGN(const auto haptic, haptic_of(*felt));
        if (!options_.out.empty()) {
            NewFile file(options_.out, options_.existing);
            TRY(file.check());
            TRY(write_png(file, haptic.view(), PngColours::indexed_if_few));
            TRY(file.commit());
            std::cout << one_line(options_.out.string()) << ": what frame " << options_.frame.value_or(0)
                      << " feels like, for touchable play " << shell_word(options_.clip.file.string())
                      << " --haptic " << shell_word(options_.out.string()) << '\n';
            say_what_is_cut(*report_, scene_.haptic);
        }
        std::cout << report_in_words(*report_, scene_, !options_.materials.names.cuts.empty());
        return {};
    }

    /// The haptic picture of the chosen frame; segments are tracked through all frames before it.
    Result<Image> haptic_of(ClipReader& clip) {
        const std::int64_t wanted = options_.frame.value_or(0);
        Progress progress("looking at frame", wanted + 1);
        for (std::int64_t number = 0;; ++number) {
            if (stop_requested()) return interrupted_error();
            progress.at(number + 1);
            TRY_ASSIGN(const auto frame, clip.next());
            if (!frame)
                return usage_error("--frame " + std::to_string(wanted) + " is beyond the clip, which has " +
                                   counted(number, "frame"));
            if (number < wanted) continue;
            const PlaneView& haptic = frame->haptic;
            Image image{haptic.width, haptic.height, 1, 3, {}};
            for (int y = 0; y < haptic.height; ++y)
                image.samples.insert(image.samples.end(), haptic.row(y), haptic.row(y) + 3 * haptic.width);
            return image;
        }
    }

    Result<void> save() {
        if (!saved_) return {};
        const auto text = segment_names_to_json(used_names(*report_, options_.materials.names));
        TRY(saved_->write(text));
        TRY(saved_->commit());
        std::cout << "  saved    " << one_line(options_.save.string()) << ", for --segments\n";
        return {};
    }

    const MaterialsOptions& options_;
    const std::shared_ptr<MaterialReport> report_ = std::make_shared<MaterialReport>();
    std::unique_ptr<NewFile> saved_;
    Scene scene_;              // of the source clip
    bool had_haptic_ = false;  // of the source clip
};

constexpr std::int64_t last_segment_frame = 999'999'999;

struct MaterialsTyped {
    ClipTyped clip;
    ManyClips many;
    MaterialsOptions options;
    bool list = false;
    std::vector<std::string> materials, places;  // places[k] belongs to materials[k]
    std::filesystem::path segments, map;
    std::string otherwise, frame;
    std::optional<std::filesystem::path> json;
};

/// "X,Y" or "X,Y,FRAME"; without FRAME the first frame.
Result<PixelOfFrame> read_place(const std::string& text) {
    auto place = read_pixel_of_frame(text);
    if (!place)
        return usage_error("--at " + in_quotes(text) +
                           "; must be X,Y or X,Y,FRAME: a pixel's column, its row and its "
                           "frame, from 0, such as 120,80 or 120,80,45");
    place->frame = std::max<std::int64_t>(place->frame, 0);
    return *place;
}

/// "NAME=MATERIAL" and its place.
Result<NamedSegment> read_named(const std::string& text, const std::string& place) {
    const std::size_t equals = text.rfind('=');
    if (equals == std::string::npos || equals == 0)
        return usage_error("--material " + in_quotes(text) +
                           " is not allowed; must be NAME=MATERIAL, such as table=wood");
    NamedSegment named;
    named.name = text.substr(0, equals);
    named.material = text.substr(equals + 1);
    const PaletteMaterial* const known = find_material(named.material);
    if (known == nullptr) return usage_error("--material: " + no_such_material(named.material));
    named.feel = known->feel();
    named.said_by = "--at " + place;
    TRY_ASSIGN(const auto at, read_place(place));
    named.at = {at};
    return named;
}

Result<SegmentNames> read_names(const MaterialsTyped& typed) {
    SegmentNames names;
    if (!typed.segments.empty()) {
        const std::string where = typed.segments.string();
        TRY_ASSIGN(const auto text,
                   read_given_file(typed.segments, where, "a file of segments (JSON, docs/content.md)",
                                   largest_segment_names));
        TRY_ASSIGN(names, parse_segment_names(text, where));
    }
    for (std::size_t k = 0; k < typed.materials.size(); ++k) {
        TRY_ASSIGN(auto named,
                   read_named(typed.materials[k], k < typed.places.size() ? typed.places[k] : "0,0"));
        names.segments.push_back(std::move(named));
    }
    if (typed.materials.size() != typed.places.size())
        return usage_error("each --material needs its --at, X,Y of a pixel of the segment; given: " +
                           counted(std::ssize(typed.materials), "material") + ", " +
                           counted(std::ssize(typed.places), "place"));
    if (!typed.otherwise.empty()) names.otherwise = typed.otherwise;
    if (!names.otherwise.empty() && find_material(names.otherwise) == nullptr)
        return usage_error("--otherwise: " + no_such_material(names.otherwise));
    return names;
}

Result<SegmentMap> read_map(const std::filesystem::path& file) {
    TRY_ASSIGN(const auto bytes, read_picture_bytes(file));
    TRY_ASSIGN(auto indices, decode_indices(bytes, file.string()));
    return SegmentMap{file.string(), std::move(indices)};
}

/// Checks the options before anything is read.
Result<void> check_words(const MaterialsTyped& typed, const MaterialsOptions& options) {
    const std::string ending = options.out.extension().string();
    if (!options.out.empty() && ending != ".mkv" && ending != ".png")
        return usage_error("OUT " + in_quotes(options.out.string()) +
                           " does not end in .mkv, a clip with its materials, or .png, a map of one frame; "
                           "touchable convert makes anything else of a clip");
    if (ending == ".mkv" && !typed.frame.empty())
        return usage_error("--frame is for NAME.png, and for no OUT at all; NAME.mkv has all frames");
    if (ending != ".mkv" && options.materials.scale_relief)
        return usage_error("--scale-relief is for NAME.mkv, which has heights");
    if (typed.clip.choice.maps.haptic)
        return usage_error(
            "--haptic does nothing here: materials make haptic pictures of their own; touchable convert lays "
            "a map under a clip");
    return {};
}

/// Prints the palette, a line per material.
Result<void> print_palette(const JsonOutput& json) {
    TRY(json.check());
    nlohmann::ordered_json materials;
    for (const PaletteMaterial& material : palette())
        materials.push_back({{"name", material.name},
                             {"stiffness", material.stiffness},
                             {"static_friction", material.static_friction},
                             {"dynamic_friction", material.dynamic_friction},
                             {"relief_percent", material.relief},
                             {"stiffness_from", material.stiffness_source},
                             {"friction_from", material.friction_source}});
    const nlohmann::ordered_json whole{{"touchable_materials", 1}, {"materials", std::move(materials)}};
    if (json.replaces_words()) return json.write(whole);
    std::cout << "material    stiffness  static, dynamic friction  relief  from\n";
    for (const PaletteMaterial& material : palette())
        std::cout << formatted("%-10s  %4.2f N/mm             %4.2f, %5.3f    %3d %%  ",
                               std::string(material.name).c_str(), material.stiffness,
                               material.static_friction, material.dynamic_friction, material.relief)
                  << "stiffness: " << material.stiffness_source << "; friction: " << material.friction_source
                  << '\n';
    std::cout << "As stiff as the device can: " << as_stiff_as_the_device
              << " N/mm, and what a device renders less of is limited to what it does.\n"
                 "HaTT: medians of the kinetic friction of a tool's tip, Culbertson, Lopez Delgado and "
                 "Kuchenbecker, IEEE Haptics Symposium 2014. Zhang and Mak: In vivo friction properties of "
                 "human skin, Prosthetics and Orthotics International 23, 1999.\n"
                 "Static friction, four thirds of the dynamic one, and relief are estimates.\n";
    return json.write(whole);
}

/// Runs the command on one clip; `out` may be empty.
Result<void> run_one(const MaterialsTyped& typed, const std::filesystem::path& clip,
                     const std::filesystem::path& out) {
    MaterialsOptions options = typed.options;
    options.out = out;
    TRY(check_words(typed, options));
    TRY_ASSIGN(options.clip, read_clip(typed.clip));
    options.clip.file = clip;
    TRY_ASSIGN(options.materials.names, read_names(typed));
    if (!typed.frame.empty())
        TRY(assign(options.frame,
                   read_whole_number<std::int64_t>("--frame", typed.frame, 0, last_segment_frame)));
    if (!typed.segments.empty()) options.read.push_back(typed.segments);
    if (!typed.map.empty()) {
        TRY_ASSIGN(options.materials.map, read_map(typed.map));
        options.read.push_back(typed.map);
    }
    return MaterialsRun(options).run();
}

Result<void> run_typed(const MaterialsTyped& typed) {
    const auto& first = typed.clip.choice.file;
    if (typed.list && !first.empty())
        return usage_error("--list prints the materials, and takes no CLIP; leave out one of both");
    if (typed.list) return print_palette({typed.json, typed.options.existing});
    if (first.empty())
        return usage_error("CLIP is missing: whose segments; --list needs none, and prints the materials");
    if (typed.many.rest.empty()) return run_one(typed, first, {});
    if (typed.many.is_for_several() && !typed.options.save.empty())
        return usage_error("--save is one file, for one clip; FOLDER/ is for several: use CLIP NAME.mkv");
    return typed.many.for_each(first, typed.options.existing, [&typed](const auto& clip, const auto& out) {
        return run_one(typed, clip, out);
    });
}

}  // namespace

void add_materials_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand("materials",
                                   "write a clip whose segments feel like materials, such as wood or cloth");
    auto typed = std::make_shared<MaterialsTyped>();
    add_clip_options(*sub, typed->clip);
    typed->many.add_option(*sub,
                           "clip to write, NAME.mkv, or a map of one frame for --haptic, NAME.png. Left out: "
                           "the segments are only listed");
    add_camera_options(*sub, typed->clip.camera);
    add_overwrite_option(*sub, typed->options.existing);
    begin_topic(*sub, "Materials");
    std::vector<std::string> materials;
    for (const PaletteMaterial& material : palette()) materials.emplace_back(material.name);
    auto* const list =
        sub->add_flag("--list", typed->list, "print all materials, their values and where these are from");
    add_json_option(*sub, typed->json, "with --list: print the same as JSON")->needs(list);
    sub->add_option("--material", typed->materials,
                    "material of the segment at the --at behind it. Give it as often as needed")
        ->allow_extra_args(false)
        ->type_name("NAME=MATERIAL");
    sub->add_option("--at", typed->places, "pixel in that segment, and its frame (by default 0)")
        ->allow_extra_args(false)
        ->type_name("X,Y[,FRAME]");
    add_file_option(*sub, "--segments", typed->segments,
                    "materials of segments, NAME.json, as --save writes it");
    add_file_option(*sub, "--map", typed->map,
                    "PNG that says which pixel of frame 0 is in which segment. With a palette, or grey; its "
                    "values are the index of --segments");
    sub->add_option("--otherwise", typed->otherwise,
                    "material of all other segments. By default a guess for each")
        ->type_name(type_with_words("MATERIAL", materials));
    sub->add_flag("--scale-relief", typed->options.materials.scale_relief,
                  "scale the heights of touchable relief by each material's relief");
    sub->add_option("--frame", typed->frame, "frame of NAME.png, or whose segments are listed, from 0")
        ->type_name("N");
    add_file_option(*sub, "--save", typed->options.save,
                    "write what was used, guesses of frame 0 too, as NAME.json for --segments");
    set_work(*sub, command, [typed] { return run_typed(*typed); });
}

}  // namespace touchable
