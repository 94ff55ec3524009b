#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/given_file.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/picture/coded_image.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/file_option.hpp"
#include "player/commands/many_clips.hpp"
#include "player/commands/materials_run.hpp"
#include "player/commands/outputs.hpp"
#include "player/commands/typed_numbers.hpp"
#include "player/window/brush_words.hpp"

namespace touchable {
namespace {

constexpr std::int64_t last_segment_frame = 999'999'999;

struct MaterialsTyped {
    ClipTyped clip;
    ManyClips many;
    MaterialsOptions options;
    bool list = false;
    std::vector<std::string> materials, places;  // each with its own
    std::filesystem::path segments, map;
    std::string otherwise, frame;
};

/// "X,Y" or "X,Y,FRAME", of the first frame where it names none.
Result<PixelOfFrame> read_place(const std::string& text) {
    auto place = read_pixel_of_frame(text);
    if (!place)
        return usage_error(
            "--at " + in_quotes(text) +
            " is no pixel; right would be X,Y or X,Y,FRAME: its column, its row and its frame, "
            "from 0, such as 120,80 or 120,80,45");
    place->frame = std::max<std::int64_t>(place->frame, 0);
    return *place;
}

/// "NAME=MATERIAL" and where that is.
Result<NamedSegment> read_named(const std::string& text, const std::string& place) {
    const std::size_t equals = text.rfind('=');
    if (equals == std::string::npos || equals == 0)
        return usage_error("--material " + in_quotes(text) +
                           " will not do; right would be NAME=MATERIAL, such as table=wood");
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
        TRY_ASSIGN(auto read, parse_segment_names(text, where));
        names = std::move(read);
    }
    if (typed.materials.size() != typed.places.size())
        return usage_error("--material is given " + std::to_string(typed.materials.size()) +
                           " times and --at " + std::to_string(typed.places.size()) +
                           "; each --material needs its --at, X,Y of a pixel of the segment");
    for (std::size_t k = 0; k < typed.materials.size(); ++k) {
        TRY_ASSIGN(auto named, read_named(typed.materials[k], typed.places[k]));
        names.segments.push_back(std::move(named));
    }
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

/// What is asked for before anything is read.
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
            "a "
            "map under a clip");
    return {};
}

/// Of one clip; `out` may be empty.
Result<void> run_one(const MaterialsTyped& typed, const std::filesystem::path& clip,
                     const std::filesystem::path& out) {
    MaterialsOptions options = typed.options;
    options.out = out;
    if (auto fits = check_words(typed, options); !fits.ok()) return fits;
    TRY_ASSIGN(const auto choice, read_clip(typed.clip));
    options.clip = choice;
    options.clip.file = clip;
    TRY_ASSIGN(auto names, read_names(typed));
    options.materials.names = std::move(names);
    if (!typed.frame.empty()) {
        TRY_ASSIGN(const auto frame,
                   read_whole_number<std::int64_t>("--frame", typed.frame, 0, last_segment_frame));
        options.frame = frame;
    }
    if (!typed.segments.empty()) options.read.push_back(typed.segments);
    if (!typed.map.empty()) {
        TRY_ASSIGN(auto map, read_map(typed.map));
        options.materials.map = std::move(map);
        options.read.push_back(typed.map);
    }
    return run_materials(options);
}

Result<void> run_typed(const MaterialsTyped& typed) {
    const auto& first = typed.clip.choice.file;
    if (typed.list && !first.empty())
        return usage_error("--list prints the materials, and takes no CLIP; leave out one of both");
    if (typed.list) return print_palette();
    if (first.empty())
        return usage_error("CLIP is missing: whose segments; --list needs none, and prints the materials");
    if (typed.many.rest.empty()) return run_one(typed, first, {});
    if (typed.many.is_for_several() && !typed.options.save.empty())
        return usage_error(
            "--save is one file, for one clip; FOLDER/ is for several: right would be CLIP "
            "NAME.mkv");
    return typed.many.for_each(first, typed.options.existing, [&typed](const auto& clip, const auto& out) {
        return run_one(typed, clip, out);
    });
}

}  // namespace

void add_materials_command(CLI::App& app, Command& command) {
    auto* sub =
        app.add_subcommand("materials", "write a clip whose segments feel like wood, metal, cloth, ...");
    auto typed = std::make_shared<MaterialsTyped>();
    add_clip_options(*sub, typed->clip);
    typed->many.add_option(*sub,
                           "NAME.mkv: the clip with what its segments feel like; NAME.png: a map of one "
                           "frame for --haptic; nothing: its segments are only told");
    add_camera_options(*sub, typed->clip.camera);
    add_overwrite_option(*sub, typed->options.existing);
    sub->add_flag("--list", typed->list, "print the materials, their values and where these are from");
    sub->add_option("--material", typed->materials,
                    "what a segment is, with --at behind it; as often as needed")
        ->allow_extra_args(false)
        ->type_name("NAME=MATERIAL");
    sub->add_option("--at", typed->places, "a pixel of that segment, and its frame (0)")
        ->allow_extra_args(false)
        ->type_name("X,Y[,FRAME]");
    add_file_option(*sub, "--segments", typed->segments, "what segments are, NAME.json, as --save writes it");
    add_file_option(*sub, "--map", typed->map,
                    "which segment of frame 0 is which: a PNG with a palette, or grey, whose values are the "
                    "index of --segments");
    sub->add_option("--otherwise", typed->otherwise,
                    "material of all segments that are not named, rather than a guess for each")
        ->type_name("MATERIAL");
    sub->add_flag("--scale-relief", typed->options.materials.scale_relief,
                  "heights of touchable relief as high as each material's relief says");
    sub->add_option("--frame", typed->frame, "of NAME.png, or whose segments are told; from 0")
        ->type_name("N");
    add_file_option(*sub, "--save", typed->options.save,
                    "write what was used, guesses of frame 0 too, for --segments, NAME.json");
    sub->callback([typed, &command] { command = [typed] { return run_typed(*typed); }; });
}

}  // namespace touchable
