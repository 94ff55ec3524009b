// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <iostream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <system_error>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/option_types.hpp"
#include "player/commands/run_options.hpp"
#include "player/run/terminal.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/clip_choice.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

Error unwritable(const fs::path& place, const std::error_code& why) {
    return input_error(place.string() + " cannot be written: " + why.message() + "; name a folder that can");
}

/// Moves a folder's files aside to make room for others; the destructor moves them back unless discarded.
class Aside : NonCopyable {
public:
    explicit Aside(fs::path place) : place_(std::move(place)), folder_(hidden_name(place_)) {}
    ~Aside() {
        std::error_code ignored;
        for (const char* name : names_) fs::rename(folder_ / name, place_ / name, ignored);
        if (made_) fs::remove(folder_, ignored);
    }

    /// Moves the file of that name aside, if it exists.
    Result<void> take(const char* name, Existing existing) {
        std::error_code failure;
        const auto status = fs::symlink_status(place_ / name, failure);
        if (!fs::exists(status)) return {};
        if (existing == Existing::keep)
            return input_error((place_ / name).string() + ": is there by now; it stays as it is");
        if (fs::is_directory(status))
            failure = std::make_error_code(std::errc::is_a_directory);
        else if (!made_)
            made_ = fs::create_directory(folder_, failure);
        if (made_ && !failure) fs::rename(place_ / name, folder_ / name, failure);
        if (failure) return unwritable(place_ / name, failure);
        names_.push_back(name);
        return {};
    }

    void discard() {
        std::error_code ignored;
        for (const char* name : std::exchange(names_, {})) fs::remove(folder_ / name, ignored);
    }

private:
    fs::path place_, folder_;
    bool made_ = false;
    std::vector<const char*> names_;
};

/// A folder whose files appear together: they are invisible until `commit`, and a new folder appears with all
/// of them in it. In an existing folder an error half-way restores the earlier files.
class StagedFolder {
public:
    /// `place`: the files' folder; created with its parents if missing.
    static Result<StagedFolder> create(const fs::path& place, Existing existing) {
        std::error_code failure;
        fs::path whole = fs::absolute(place, failure).lexically_normal();
        if (!whole.has_filename()) whole = whole.parent_path();
        fs::path ground = whole;
        while (!fs::exists(ground, failure) && ground.has_relative_path()) ground = ground.parent_path();
        if (!fs::is_directory(ground, failure))
            return unwritable(place, std::make_error_code(std::errc::not_a_directory));
        return StagedFolder(whole, ground, existing);
    }

    /// Adds a file with this name; write and close it before `commit`.
    NewFile& add(const std::string& name) {
        return *(files_[name] = std::make_unique<NewFile>(place_ / name, Existing::keep, ground_));
    }

    std::size_t count() const { return files_.size(); }
    /// `names`: all files that such a folder may hold; those not added are removed if an earlier run left
    /// them. Old files go from the last to the first, new ones appear from the first to the last.
    Result<void> commit(std::span<const char* const> names) {
        return place_ == ground_ ? replace(names) : appear(names);
    }

private:
    StagedFolder(fs::path place, fs::path ground, Existing existing)
        : place_(std::move(place)), ground_(std::move(ground)), existing_(existing) {}

    Result<void> appear(std::span<const char* const> names) {
        std::error_code failure;
        const fs::path above = place_.parent_path(), hidden = hidden_name(above);
        fs::create_directories(above, failure);
        if (!failure) fs::create_directory(hidden, failure);
        Result<void> done;
        if (failure) done = unwritable(place_, failure);
        if (done) done = name_in(hidden, names);
        if (done)
            if (const int why = move_to_free_name(hidden, place_))
                done = unwritable(place_, std::error_code(why, std::generic_category()));
        if (done) return sync_names(above, place_);
        fs::remove_all(hidden, failure);
        // Remove the folders created for it; remove() refuses folders that hold other files by now.
        for (fs::path p = above; p != ground_; p = p.parent_path()) fs::remove(p, failure);
        return done;
    }

    Result<void> replace(std::span<const char* const> names) {
        Aside aside(place_);
        for (auto name = names.rbegin(); name != names.rend(); ++name) TRY(aside.take(*name, existing_));
        auto done = name_in(place_, names);
        if (done) {
            aside.discard();
            return {};
        }
        std::error_code ignored;
        for (const auto& [name, file] : files_)
            if (file->committed()) fs::remove(place_ / name, ignored);
        return done;
    }

    /// Gives the files their names in `folder`.
    Result<void> name_in(const fs::path& folder, std::span<const char* const> names) {
        for (const char* name : names)
            if (const auto file = files_.find(name); file != files_.end())
                TRY(file->second->commit_as(folder / name));
        return {};
    }

    fs::path place_;
    fs::path ground_;  ///< the nearest existing folder: `place_` or one above it
    Existing existing_;
    std::map<std::string, std::unique_ptr<NewFile>> files_;
};

/// Every file that `write_frame_files` may write.
constexpr std::array<const char*, 10> frame_file_names{"colour.png", "depth.png",  "codes.png",  "codes.json",
                                                       "valid.png",  "haptic.png", "height.png", "errors.png",
                                                       "mesh.ply",   "scene.json"};

Image validity_image(const SurfaceFrame& surface) {
    Image image{surface.width, surface.height, 1, 1, {}};
    image.samples.reserve(surface.codes.size());
    for (int y = 0; y < surface.height; ++y)
        for (int x = 0; x < surface.width; ++x)
            image.samples.push_back(surface.is_valid(x, y) ? std::uint8_t{255} : std::uint8_t{0});
    return image;
}

/// Error bars of the force's direction, hundredths of a degree; 65535: not known.
std::vector<std::uint16_t> error_hundredths(const SurfaceFrame& surface) {
    std::vector<std::uint16_t> hundredths(surface.codes.size(), 65535);
    for (int y = 0; y < surface.height; ++y)
        for (int x = 0; x < surface.width; ++x)
            if (const double degrees = surface.signs.bar_at(x, y).degrees;
                surface.is_valid(x, y) && degrees >= 0)
                hundredths[surface.index(x, y)] = static_cast<std::uint16_t>(100 * degrees + 0.5);
    return hundredths;
}

/// The scene of one frame's pictures, so that their folder is a clip again.
Scene as_still(Scene scene, const RawFrame& raw) {
    const auto name_of = [](const PlaneView& plane, const char* name) {
        return plane.empty() ? std::string() : std::string(name);
    };
    scene.video.reset();
    scene.folder = FolderSource{"depth.png",
                                name_of(raw.colour, "colour.png"),
                                name_of(raw.haptic, "haptic.png"),
                                name_of(raw.height, "height.png"),
                                0,
                                0};
    scene.stored = {};  // codes
    return scene;
}

/// The codes' meaning in the form of a scene file's depth: filters may have made the codes finer.
std::string codes_to_json(const SurfaceFrame& surface, Scene scene) {
    scene.depth = surface.coding;
    scene.depth_bits = 16;
    scene.folder.reset();
    scene.video.reset();
    scene.stored = {};  // codes
    const auto whole = nlohmann::ordered_json::parse(scene_to_json(scene));
    return nlohmann::ordered_json{{"depth", whole.at("depth")}}.dump(2);
}

/// Writes one frame, raw and built, into `folder` without committing it. `surface`: built from `raw`, with
/// codes (not lazy).
Result<void> write_frame_files(StagedFolder& folder, const RawFrame& raw, const SurfaceFrame& surface,
                               const Scene& scene, bool with_mesh) {
    const Image validity = validity_image(surface);
    const std::vector<std::uint16_t> errors = error_hundredths(surface);
    const std::pair<const char*, PlaneView> pictures[] = {
        {"colour.png", raw.colour},
        {"depth.png", raw.depth},
        {"codes.png", plane_of_codes(surface.codes.data(), surface.width, surface.height)},
        {"valid.png", validity.view()},
        {"haptic.png", raw.haptic},
        {"height.png", raw.height},
        {"errors.png", plane_of_codes(errors.data(), surface.width, surface.height)}};
    for (const auto& [name, plane] : pictures)
        if (!plane.empty()) TRY(write_png(folder.add(name), plane));
    if (with_mesh) TRY(write_ply(folder.add("mesh.ply"), make_mesh(surface, scene), raw.colour));
    TRY(folder.add("codes.json").write(codes_to_json(surface, scene) + "\n"));
    return folder.add("scene.json").write(scene_to_json(as_still(scene, raw)) + "\n");
}

struct ExportOptions {
    ClipChoice clip;
    std::filesystem::path out;           ///< empty: only the picture
    Existing existing = Existing::keep;  ///< what becomes of files that are there
    std::int64_t first = 0;
    std::optional<std::int64_t> last;  ///< inclusive; nothing: to the end
    bool folder_per_frame = false;     ///< out/<n>/ instead of out/
    bool mesh = false;
    BuilderChoice builder;
    PictureOptions picture;  ///< of a single frame
};

Result<void> draw(PictureOrder& picture, const RawFrame& raw, const Scene& scene,
                  const SurfaceFrame& surface) {
    FramePair still;
    still.prev = still.next = {raw.number, raw.time_ns, &surface};
    return picture.deliver(HeightField(scene, still), still, raw.colour, {});
}

/// `files`: incremented by the number of files written.
Result<void> export_frame(const RawFrame& raw, const Scene& scene, const SurfaceFrame& surface,
                          const ExportOptions& options, std::size_t& files) {
    if (options.out.empty()) return {};
    TRY_ASSIGN(auto folder,
               StagedFolder::create(
                   options.folder_per_frame ? options.out / std::to_string(raw.number) : options.out,
                   options.existing));
    TRY(write_frame_files(folder, raw, surface, scene, options.mesh));
    files += folder.count();
    return folder.commit(frame_file_names);
}

Error no_such_frame(const ExportOptions& options, std::int64_t wanted, std::int64_t frames) {
    return not_allowed(options.folder_per_frame ? "--frames" : "--frame", std::to_string(wanted),
                       "0 to " + std::to_string(frames - 1) + "; " + options.clip.file.string() + " has " +
                           counted(frames, "frame"));
}

// Beyond any clip's last frame, and small enough to be incremented.
constexpr std::int64_t last_number = std::numeric_limits<std::int64_t>::max() - 1;

/// "all", "A-B" or "A".
Result<void> read_frames(const std::string& text, ExportOptions& out) {
    if (text == "all") return {};
    const std::string_view view = text;
    const std::size_t dash = view.find('-');
    const auto number = [](std::string_view digits) {
        return read_whole_number<std::int64_t>("--frames", digits, 0, last_number);
    };
    const auto first = number(view.substr(0, dash));
    const auto last = dash == std::string::npos ? first : number(view.substr(dash + 1));
    if (!first || !last || *last < *first)
        return not_allowed("--frames", text, "A-B with A <= B, such as 0-9, or all");
    out.first = *first;
    out.last = *last;
    return {};
}

struct ExportTyped {
    ClipTyped clip;
    ExportOptions options;
    std::optional<std::string> one, many;  ///< --frame or --frames; only one is set
};

Result<void> read_frames(const ExportTyped& typed, ExportOptions& out) {
    if (typed.many && out.picture.file)
        return usage_error("--picture draws a single frame; use --frame N instead of --frames");
    if (typed.one) {
        // The clip's length tells which of them are right.
        const auto number = read_whole_number<std::int64_t>("--frame", *typed.one, INT64_MIN, INT64_MAX);
        if (!number && typed.one->find('-', 1) != std::string::npos)
            return not_allowed("--frame", *typed.one, "one frame's number; several are --frames A-B");
        if (!number) return number.error();
        out.first = *number;
        out.last = *number;
        return {};
    }
    if (!typed.many)
        return usage_error(out.picture.file
                               ? "--picture draws a single frame; use --frame N as well"
                               : "export needs --frame N or --frames A-B|all; see touchable export -h");
    out.folder_per_frame = true;
    return read_frames(*typed.many, out);
}

/// Every file that may be written; with a folder per frame, only those in existing folders.
std::vector<NamedFile> files_of(const ExportOptions& options) {
    std::vector<NamedFile> files;
    if (options.picture.file) files.push_back({"--picture", *options.picture.file});
    const auto add_folder = [&](const std::filesystem::path& folder) {
        for (const char* name : frame_file_names) files.push_back({"--out", folder / name});
    };
    if (options.out.empty()) return files;
    if (!options.folder_per_frame) {
        add_folder(options.out);
        return files;
    }
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(options.out, ignored)) {
        const auto number = read_whole_number<std::int64_t>(
            "", entry.path().filename().string(), options.first, options.last.value_or(last_number));
        if (number) add_folder(entry.path());
    }
    return files;
}

/// Takes the scale from frame 0 of the clip; another frame may suggest another scale.
Result<void> find_scale(ClipReader& reader, Scene& scene, SurfaceBuilder& builder) {
    if (scene.device_metres_per_unit) return {};
    TRY_ASSIGN(const auto first, reader.next());
    if (!first) return {};
    SurfaceFrame surface;
    TRY(builder.build(*first, surface));
    scene.device_metres_per_unit = clip_workspace(scene, surface).metres_per_scene_unit;
    return {};
}

/// With a folder per frame, the frames before the failed one are whole and stay.
Error with_what_stays(Error error, const ExportOptions& options, std::int64_t failed) {
    if (!options.folder_per_frame || options.out.empty() || failed <= options.first) return error;
    error.message += "; frames " + std::to_string(options.first) + " to " + std::to_string(failed - 1) +
                     " are whole in " + options.out.string();
    return error;
}

/// Number of the frame after the last one exported, and the number of files written.
struct Exported {
    std::int64_t number = 0;
    std::size_t files = 0;
};

std::string in_words(const ExportOptions& options, const Exported& done) {
    const std::string picture = options.picture.file ? options.picture.file->string() : "";
    if (options.out.empty()) return picture + " is written";
    const std::int64_t first = options.first, last = done.number - 1;
    return options.out.string() + " is written: frame" +
           (last > first ? "s " + std::to_string(first) + " to " + std::to_string(last)
                         : ' ' + std::to_string(first)) +
           (options.folder_per_frame && last > first ? ", a folder each, " : ", ") +
           counted(done.files, "file") + (picture.empty() ? "" : "; and " + picture);
}

/// Reads, builds and writes from `options.first` on. A temporal filter begins empty some frames before the
/// first (docs/conventions.md).
Result<void> export_frames(ClipReader& reader, const Scene& scene, const ExportOptions& options,
                           SurfaceBuilder& builder, std::optional<PictureOrder>& picture,
                           Exported& exported) {
    std::int64_t& number = exported.number;
    Progress progress("exporting frame", options.last ? *options.last + 1 : reader.frame_count().value_or(0));
    SurfaceFrame surface;
    number = std::max<std::int64_t>(0, options.first - (scene.filter.temporal ? temporal_warm_up_frames : 0));
    TRY(reader.seek(number));
    for (; !options.last || number <= *options.last; ++number) {
        if (stop_requested()) return interrupted_error();
        TRY_ASSIGN(auto raw, reader.next());
        if (!raw) break;
        raw->epoch = 1;  // a new epoch, different from find_scale's
        progress.at(number);
        TRY(builder.build(*raw, surface));
        if (number < options.first) continue;
        TRY(export_frame(*raw, scene, surface, options, exported.files));
        if (picture) TRY(draw(*picture, *raw, scene, surface));
    }
    return {};
}

/// `at_work`: set to what memory is needed for, once known.
Result<void> export_clip(const ExportOptions& options, std::string& at_work) {
    TRY(check_gpu_options(options.builder, options.picture.draws_on_gpu()));
    TRY_ASSIGN(auto clip, open_chosen(options.clip, Colour::wanted));
    const auto& reader = clip.reader;
    Scene& scene = clip.scene;
    at_work = frames_in_words(scene);
    const auto frames = reader->frame_count();
    const std::int64_t wanted = options.last.value_or(options.first);
    if (frames && (wanted < 0 || wanted >= *frames)) return no_such_frame(options, wanted, *frames);
    if (wanted < 0 || wanted > last_number)
        return not_allowed("--frame", std::to_string(wanted), "0 or more");
    TRY(check_outputs({files_of(options), options.existing}, inputs_of(options.clip, *reader)));
    RunGpu gpu(options.builder.gpu);
    TRY_ASSIGN(auto plain, make_builder(options.builder, scene, gpu));
    const auto builder = with_error_bars(std::move(plain), scene);
    TRY_ASSIGN(auto picture, order_picture(options.picture, options.existing, options.builder, gpu));

    TRY(find_scale(*reader, scene, *builder));
    Exported exported;
    const std::int64_t& number = exported.number;
    if (auto done = export_frames(*reader, scene, options, *builder, picture, exported); !done)
        return with_what_stays(done.error(), options, number);
    if (number <= wanted) return with_what_stays(no_such_frame(options, wanted, number), options, number);
    if (clip.chosen) say_on_stderr("filters: " + filters_in_words(scene, clip.chosen));
    std::cout << one_line(in_words(options, exported)) << '\n';
    return {};
}

/// Writes frames as pictures, mesh and scene description: colour.png, depth.png (as stored), codes.png
/// (filtered, 16 bits), valid.png (0 or 255), errors.png (16 bits), haptic.png and height.png if the clip has
/// them, mesh.ply, scene.json. The files of a frame appear together or not at all. The picture of a single
/// frame is a separate file.
Result<void> run_export(const ExportOptions& options) {
    std::string at_work = "the frames of " + options.clip.file.string();
    return within_memory(at_work, [&] { return export_clip(options, at_work); });
}

}  // namespace

void add_export_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand("export", "write frames as pictures, mesh and scene description");
    auto typed = std::make_shared<ExportTyped>();
    ExportOptions& options = typed->options;
    add_clip_options(*sub, typed->clip)->required();
    begin_topic(*sub, files_topic);
    add_file_option(*sub, "--out", options.out, "folder to write to. May be left out with --picture")
        ->type_name("FOLDER");
    add_overwrite_option(*sub, options.existing);
    auto* one = sub->add_option("--frame", typed->one, "write this frame, from 0, into the folder itself")
                    ->type_name("N");
    auto* many = sub->add_option("--frames", typed->many,
                                 "write these frames, each into a folder of its number. Without meshes; "
                                 "touchable convert unpacks a clip so that it opens again")
                     ->type_name(type_with_words("A-B|all", std::array{"all"}))
                     ->excludes(one);
    sub->add_flag("--mesh", options.mesh, "write the meshes too, with --frames")->needs(many);
    add_picture_options(*sub, options.picture);
    add_camera_options(*sub, typed->clip.camera);
    add_filter_options(*sub, typed->clip);
    add_builder_options(*sub, options.builder, {"cpu", "vulkan", "reference"});
    set_work(*sub, command, [typed]() -> Result<void> {
        ExportOptions chosen = typed->options;
        if (chosen.out.empty() && !chosen.picture.file)
            return usage_error("export needs --out FOLDER, or --picture FILE; see touchable export -h");
        TRY(read_frames(*typed, chosen));
        TRY_ASSIGN(chosen.clip, read_clip(typed->clip));
        chosen.mesh = chosen.mesh || typed->one;
        return run_export(chosen);
    });
}

}  // namespace touchable
