// SPDX-License-Identifier: Apache-2.0
#include "player/commands/convert_command.hpp"

#include <iostream>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/commands.hpp"
#include "player/run/terminal.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t last_frame = 999'999'999;

struct ConvertTyped {
    ClipTyped clip;
    ConvertOptions options;
    std::optional<std::string> from, to, crop, size;
    std::string every = "1";
    const CLI::App* command = nullptr;
};

/// "45", a frame; "1.5s", a time.
Result<ClipMoment> read_moment(const std::string& option, std::string_view text) {
    const auto refused = [&] {
        return not_allowed(option, text, "a frame's number, such as 45, or seconds, such as 1.5s");
    };
    if (!text.ends_with('s')) {
        const auto frame = read_whole_number<std::int64_t>(option, text, 0, last_frame);
        if (!frame) return refused();
        return ClipMoment{*frame};
    }
    text.remove_suffix(1);
    const auto seconds = parsed_number(text);
    if (!seconds || *seconds < 0 || *seconds > 1e6) return refused();
    return ClipMoment{0, std::llround(*seconds * 1e9)};
}

/// "X,Y,WxH".
Result<ClipPart::Crop> read_crop(const std::string& text) {
    const auto refused = [&] {
        return not_allowed("--crop", text,
                           "X,Y,WxH: the column and row that it begins with, from 0, and its size, such as "
                           "100,50,320x240");
    };
    const std::string_view view = text;
    const std::size_t first = view.find(','), second = view.find(',', first + 1);
    if (first == std::string_view::npos || second == std::string_view::npos) return refused();
    const auto x = read_whole_number("--crop", view.substr(0, first), 0, 16383);
    const auto y = read_whole_number("--crop", view.substr(first + 1, second - first - 1), 0, 16383);
    const auto size = read_pixel_size("--crop", view.substr(second + 1), 1, 16384);
    if (!x || !y || !size) return refused();
    return ClipPart::Crop{*x, *y, size->width, size->height};
}

Result<ClipForm> read_form(const fs::path& out) {
    if (!out.has_filename()) return ClipForm::folder;
    const std::string ending = small_letters(out.extension().string());
    if (ending == ".mkv" || ending == ".mp4") return ClipForm::archive;
    if (ending == ".png") return ClipForm::still;
    if (ending == ".bt") return ClipForm::scene_text;
    if (ending == ".gltf") return ClipForm::gltf;
    if (ending == ".npy") return ClipForm::floats;
    if (ending == ".exr") return ClipForm::float_still;
    std::error_code ignored;
    if (ending.empty() || fs::is_directory(out, ignored)) return ClipForm::folder;
    return not_allowed("OUT", out.string(),
                       "NAME.mkv, NAME.mp4, NAME.gltf, NAME.png, NAME.npy, NAME.exr, NAME.bt, or the name "
                       "of a folder, which ends in / if it has a dot");
}

/// Refuses options without effect.
Result<void> refuse_idle_options(const ConvertTyped& typed) {
    const auto only = [&](bool given, const char* option, const char* what) -> Result<void> {
        if (!given) return {};
        return usage_error(std::string(option) + " is for " + what);
    };
    const ClipForm form = typed.options.form;
    const ClipStorage& storage = typed.options.storage;
    const bool archive = form == ClipForm::archive || form == ClipForm::gltf, one_frame = is_one_frame(form);
    const char* why = "clips, NAME.mkv, NAME.mp4 and NAME.gltf; pictures keep every value";
    TRY(only(!archive && typed.command->count("--archive") > 0, "--archive", why));
    TRY(only(!archive && storage.exact_colour, "--exact-colour", why));
    if (typed.options.still && storage.fragmented)
        return usage_error("--still is one frame, which has no fragments: leave --fragmented out");
    const bool is_mp4_clip = form == ClipForm::archive && is_mp4_name(typed.options.out);
    TRY(only(!is_mp4_clip && storage.fragmented, "--fragmented", fragmented_names));
    const char* one =
        "clips and folders; NAME.png, NAME.exr, NAME.bt and --still are one frame, --from says which";
    TRY(only(one_frame && typed.to, "--to", one));
    return only(one_frame && typed.command->count("--every") > 0, "--every", one);
}

Result<ConvertOptions> read_words(const ConvertTyped& typed) {
    ConvertTyped read = typed;
    ConvertOptions& options = read.options;
    TRY_ASSIGN(options.form, read_form(options.out));
    if (options.still && !is_mp4_name(options.out))
        return usage_error("--still is for NAME.mp4; NAME.png and NAME.bt are one frame as they are");
    if (options.still) options.form = ClipForm::mp4_still;
    if (options.lerobot && (options.still || !is_mp4_name(options.out)))
        return usage_error("--lerobot is for NAME.mp4" +
                           std::string(options.still ? ", without --still" : ""));
    if (options.lerobot) options.form = ClipForm::lerobot;
    if (options.web && options.form != ClipForm::folder)
        return usage_error("--web is for a folder: a name without a dot, or with / at its end");
    if (options.web) options.form = ClipForm::web;
    TRY(refuse_idle_options(read));
    TRY_ASSIGN(options.clip, read_clip(typed.clip));
    options.filtered = typed.clip.filtered;
    if (typed.from) TRY(assign(options.from, read_moment("--from", *typed.from)));
    if (typed.to) TRY(assign(options.to, read_moment("--to", *typed.to)));
    TRY_ASSIGN(options.every, read_whole_number<std::int64_t>("--every", typed.every, 1, 1'000'000));
    if (typed.crop) TRY(assign(options.crop, read_crop(*typed.crop)));
    if (typed.size) TRY(assign(options.size, read_pixel_size("--size", *typed.size, 1, 16384)));
    return options;
}

bool is_there(const fs::path& path) {
    std::error_code ignored;
    return fs::exists(fs::symlink_status(path, ignored));
}

Result<void> make_folder(const fs::path& folder) {
    std::error_code failure;
    fs::create_directories(folder, failure);
    if (fs::is_directory(folder, failure)) return {};
    if (is_there(folder.parent_path()))
        return usage_error("'" + printable(folder.parent_path().string()) + "' is a file, and no folder");
    return usage_error("'" + printable(folder.string()) + "' cannot be made: " + failure.message());
}

/// File name for a clip in an output folder: "b.mkv" for "a/b.bag" and for "a/b/scene.json".
fs::path name_in_folder(const fs::path& clip) {
    std::error_code ignored;
    fs::path whole = fs::absolute(clip, ignored).lexically_normal();
    if (!whole.has_filename() || whole.filename() == "scene.json") whole = whole.parent_path();
    std::string name = fs::is_directory(whole, ignored) ? whole.filename().string() : whole.stem().string();
    return (name.empty() ? std::string("clip") : name) + ".mkv";
}

/// Output file of each clip; two clips with the same one are refused.
Result<std::vector<fs::path>> places(const std::vector<fs::path>& clips, const fs::path& folder) {
    std::map<fs::path, fs::path> taken;
    std::vector<fs::path> outs;
    for (const fs::path& clip : clips) {
        outs.push_back(folder / name_in_folder(clip));
        const auto [place, is_new] = taken.emplace(outs.back(), clip);
        if (!is_new)
            return usage_error("'" + printable(place->second.string()) + "' and '" +
                               printable(clip.string()) + "' would both be '" +
                               printable(outs.back().string()) + "'; use two folders, one after the other");
    }
    return outs;
}

}  // namespace

CLI::Option* ManyClips::add_option(CLI::App& sub, const std::string& out) {
    return add_file_option(sub, "OUT", rest,
                           out + "; or further clips, and the folder that all of them go into (FOLDER/)")
        ->expected(1, -1);
}

Result<void> ManyClips::for_each(const fs::path& first, Existing existing, const One& one) const {
    const fs::path& out = rest.back();
    if (!is_for_several()) return one(first, out);
    // An existing folder may be a clip of pictures, so an output folder's name must end in a slash.
    if (out.has_filename())
        return usage_error("'" + printable(out.string()) +
                           "' is no folder, and several clips go into one; must be FOLDER/");
    std::vector<fs::path> clips{first};
    clips.insert(clips.end(), rest.begin(), rest.end() - 1);
    TRY_ASSIGN(const auto outs, places(clips, out));
    for (std::size_t k = 0; k < clips.size(); ++k)
        for (const fs::path& clip : clips)
            if (std::error_code ignored; fs::equivalent(clip, outs[k], ignored))
                return usage_error("'" + printable(outs[k].string()) +
                                   "' is one of the clips, and would be written; give another folder");
    TRY(make_folder(out));
    std::optional<Error> failed;
    std::size_t failures = 0;
    for (std::size_t k = 0; k < clips.size(); ++k) {
        const fs::path& place = outs[k];
        if (existing == Existing::keep && is_there(place)) {
            std::cout << one_line(place.string()) << ": is there already\n";
            continue;
        }
        auto done = one(clips[k], place);
        if (done) continue;
        if (done.error().kind == ErrorKind::interrupted) return done;
        if (existing == Existing::keep && is_there(place)) {
            std::cout << one_line(place.string()) << ": another program has made it meanwhile\n";
            continue;
        }
        std::cout.flush();
        say_on_stderr(done.error().message);
        if (!failed) failed = done.error();
        ++failures;
    }
    if (!failed) return {};
    failed->message =
        std::to_string(failures) + " of " + std::to_string(clips.size()) + " clips were not made";
    return *failed;
}

void add_convert_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand(
        "convert", "write a clip in another form, or a part of it: a clip, pictures or an MPEG-4 scene");
    auto typed = std::make_shared<ConvertTyped>();
    typed->command = sub;
    ConvertOptions& options = typed->options;
    add_clip_options(*sub, typed->clip)->required();
    add_file_option(
        *sub, "OUT", options.out,
        "what to write: .mkv, .mp4, .gltf, .png, .npy, .exr, .bt or a folder. NAME.mkv: a clip; NAME.mp4: "
        "the same as "
        "MPEG-4; NAME.gltf: a glTF scene for any glTF viewer, beside its NAME.mp4; a name without a dot, or "
        "with / at its end: a folder of pictures that opens again; NAME.png: a depth picture with its scene "
        "file NAME.json; NAME.npy: depth of all frames as floats of metres, an array (frames, height, "
        "width), "
        "NAME.exr: of one frame; NAME.bt: one frame as the paper sends a static scene, a text beside its "
        "pictures")
        ->required();
    add_camera_options(*sub, typed->clip.camera);
    begin_topic(*sub, files_topic);
    add_overwrite_option(*sub, options.existing);
    add_storage_options(*sub, options.storage);
    sub->add_flag("--still", options.still,
                  "write NAME.mp4 with one frame, as the paper's static scene. Its pictures are PNG");
    sub->add_flag(
        "--lerobot", options.lerobot,
        "write NAME.mp4 with depth alone, as LeRobot stores it (HEVC, 12 bits). NAME.info.json gets "
        "the entry for a data set's meta/info.json");
    sub->add_flag(
        "--web", options.web,
        "write a folder with a page in which browsers show the clip and let people touch it, for any "
        "web server");
    begin_topic(*sub, "Part");
    sub->add_option("--from", typed->from, "first frame: its number, from 0, or seconds such as 1.5s")
        ->type_name("N|SECONDS");
    sub->add_option("--to", typed->to, "last frame: its number, or the seconds at which it ends")
        ->type_name("N|SECONDS");
    sub->add_option("--every", typed->every, "keep only every Nth frame. The rate is so much lower")
        ->type_name("N");
    sub->add_option("--crop", typed->crop, "keep only these pixels: first column and row, and size")
        ->type_name("X,Y,WxH");
    sub->add_option("--size", typed->size,
                    "scale pictures to this size, after --crop. Depth, haptic and height by the nearest "
                    "samples, colour by the mean; needs --allow-lossy")
        ->type_name("WxH");
    sub->add_flag(
        "--allow-lossy", options.allow_lossy,
        "let values of what is touched change. The report says by how much, and what that does to forces");
    add_filtered_options(*sub, typed->clip, "write");
    set_work(*sub, command, [typed]() -> Result<void> {
        TRY_ASSIGN(const auto chosen, read_words(*typed));
        return run_convert(chosen);
    });
}

}  // namespace touchable
