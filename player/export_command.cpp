#include "player/export_command.hpp"

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <iostream>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/media/clip.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/frame_files.hpp"
#include "player/interrupt.hpp"
#include "player/outputs_apart.hpp"
#include "player/progress.hpp"
#include "player/staged_folder.hpp"

namespace touchable {
namespace {

/// The clip's scene as this export applies it. The folder it may have come from is no part of what is
/// written.
Result<Scene> effective_scene(const ClipReader& reader, const ExportOptions& options) {
    Scene scene = reader.scene();
    if (options.median) scene.filter.median = *options.median;
    if (options.fill_holes) scene.filter.fill_holes = *options.fill_holes;
    scene.folder.reset();
    if (auto valid = validate(scene); !valid.ok()) return usage_error(valid.error().message);
    return scene;
}

Result<void> draw(PictureOrder& picture, const RawFrame& raw, const Scene& scene,
                  const SurfaceFrame& surface) {
    FramePair still;
    still.prev = still.next = {raw.number, raw.time_ns, &surface};
    return picture.deliver(HeightField(scene, still), still, raw.colour, {});
}

Result<void> export_frame(const RawFrame& raw, const Scene& scene, const SurfaceFrame& surface,
                          const ExportOptions& options) {
    if (options.out.empty()) return {};
    auto folder = StagedFolder::create(options.folder_per_frame ? options.out / std::to_string(raw.number)
                                                                : options.out);
    if (!folder.ok()) return folder.error();
    if (auto written = write_frame_files(folder->path(), raw, surface, scene, options.mesh); !written.ok())
        return written;
    return folder->commit(frame_file_names);
}

Error beyond_the_end(const ExportOptions& options, std::int64_t wanted, std::int64_t frames) {
    return usage_error("frame " + std::to_string(wanted) + " is beyond the end of " + options.clip.string() +
                       ": it has " + std::to_string(frames) + " frames, 0 to " + std::to_string(frames - 1));
}

/// "all", "A-B" or "A".
Result<void> read_frames(const std::string& text, ExportOptions& out) {
    if (text == "all") return {};
    const auto number = [](std::string_view digits) -> std::optional<std::int64_t> {
        std::int64_t value = 0;
        const auto [end, failure] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (failure != std::errc() || end != digits.data() + digits.size() || value < 0) return std::nullopt;
        return value;
    };
    const std::string_view view = text;
    const std::size_t dash = view.find('-');
    const auto first = number(view.substr(0, dash));
    const auto last = dash == std::string::npos ? first : number(view.substr(dash + 1));
    if (!first || !last || *last < *first)
        return usage_error("--frames " + text +
                           " is no range; right would be A-B with A <= B, such as 0-9, or all");
    out.first = *first;
    out.last = *last;
    return {};
}

}  // namespace

Result<void> run_export(const ExportOptions& options) {
    if (auto checked = check_gpu_options(options.builder, options.picture.draws_on_gpu()); !checked.ok())
        return checked;
    auto reader = open_clip(options.clip, options.scene);
    if (!reader.ok()) return reader.error();
    const auto frames = (*reader)->frame_count();
    const std::int64_t wanted = options.last.value_or(options.first);
    if (frames && wanted >= *frames) return beyond_the_end(options, wanted, *frames);
    const auto scene = effective_scene(**reader, options);
    if (!scene.ok()) return scene.error();
    RunGpu gpu(options.builder.gpu);
    const auto builder = make_builder(options.builder, *scene, gpu);
    if (!builder.ok()) return builder.error();
    auto picture = order_picture(options.picture, options.builder, gpu);
    if (!picture.ok()) return picture.error();

    std::vector<NamedFile> outputs, inputs{{"the clip", options.clip}};
    if (options.picture.file) outputs.push_back({"--picture", *options.picture.file});
    if (!options.out.empty()) outputs.push_back({"scene.json of --out", options.out / "scene.json"});
    if (options.scene) inputs.push_back({"--scene", *options.scene});
    if (auto apart = keep_outputs_apart(outputs, inputs); !apart.ok()) return apart;

    Progress progress("exporting frame", options.last ? *options.last + 1 : frames.value_or(0));
    SurfaceFrame surface;
    std::int64_t number = 0;
    for (; !options.last || number <= *options.last; ++number) {
        if (interrupted()) return interrupted_error();
        const auto raw = (*reader)->next();
        if (!raw.ok()) return raw.error();
        if (!*raw) break;
        progress.at(number);
        if (number < options.first) continue;
        if (auto built = (*builder)->build(**raw, surface); !built.ok()) return built;
        if (auto done = export_frame(**raw, *scene, surface, options); !done.ok()) return done;
        if (*picture)
            if (auto drawn = draw(**picture, **raw, *scene, surface); !drawn.ok()) return drawn;
    }
    if (number <= wanted) return beyond_the_end(options, wanted, number);
    return {};
}

void add_export_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand("export", "write frames as pictures, mesh and scene description");
    auto options = std::make_shared<ExportOptions>();
    auto range = std::make_shared<std::string>();
    auto mesh = std::make_shared<bool>(false);
    sub->add_option("CLIP", options->clip, "a clip, a folder of images, or a scene file")->required();
    auto* folder =
        sub->add_option("--out", options->out, "folder to write to; may be left out with --picture");
    auto* one = sub->add_option("--frame", options->first, "this frame, from 0, into the folder itself")
                    ->check(CLI::NonNegativeNumber);
    auto* many =
        sub->add_option("--frames", *range, "A-B or all: each frame n into the folder's n/, without mesh")
            ->excludes(one);
    add_picture_options(*sub, options->picture);
    many->excludes("--picture");
    sub->add_flag("--mesh", *mesh, "with --frames: write the meshes too")->needs(many);
    sub->add_option("--scene", options->scene, "scene file that describes the clip instead of its own");
    sub->add_option("--median", options->median, "window side instead of the scene's: 0 (off), 3 or 5");
    sub->add_option("--fill-holes", options->fill_holes, "passes instead of the scene's: 0 to 16");
    add_builder_options(*sub, options->builder, {"cpu", "vulkan", "reference"});
    sub->callback([options, range, mesh, folder, one, many, &command] {
        command = [=]() -> Result<void> {
            ExportOptions chosen = *options;
            if (folder->count() > 0 && chosen.out.empty())
                return usage_error("--out names no folder; right would be --out FOLDER");
            if (one->count() + many->count() == 0)
                return usage_error("export needs --frame N or --frames A-B|all; see touchable export -h");
            if (chosen.out.empty() && !chosen.picture.file)
                return usage_error("export needs --out FOLDER, or --picture FILE; see touchable export -h");
            if (one->count() > 0) {
                chosen.last = chosen.first;
                return run_export(chosen);
            }
            chosen.folder_per_frame = true;
            chosen.mesh = *mesh;
            if (auto read = read_frames(*range, chosen); !read.ok()) return read;
            return run_export(chosen);
        };
    });
}

}  // namespace touchable
