// SPDX-License-Identifier: Apache-2.0
#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {
namespace {

struct InitSceneOptions {
    std::filesystem::path pictures;
    std::optional<std::filesystem::path> out;
    CameraTyped camera;
    Existing existing = Existing::keep;
};

/// The command that opens the pictures with `target`. If `target` names the pictures, it does so relative to
/// their folder, so it opens by itself only there.
std::string opening(const std::filesystem::path& target, const std::filesystem::path& pictures,
                    bool is_folder, const Scene& scene) {
    std::error_code failure;
    const auto whole = [&](const std::filesystem::path& path) {
        return std::filesystem::weakly_canonical(std::filesystem::absolute(path, failure), failure);
    };
    const auto home = is_folder ? whole(pictures) : whole(pictures).parent_path();
    const bool names_pictures = scene.folder || scene.video;
    if (names_pictures && whole(target).parent_path() == home && target.extension() == ".json")
        return "touchable " + shell_word(target.string());
    return "touchable play " + shell_word(pictures.string()) + " --scene " + shell_word(target.string());
}

Result<void> run_init_scene(const InitSceneOptions& options) {
    TRY_ASSIGN(const auto known, read_camera(options.camera));
    std::error_code ignored;
    const bool is_folder = std::filesystem::is_directory(options.pictures, ignored);
    TRY_ASSIGN(const auto guessed, guess_clip(options.pictures, known));
    std::filesystem::path beside = options.pictures;
    const std::filesystem::path target = options.out ? *options.out
                                         : is_folder ? options.pictures / "scene.json"
                                                     : beside.replace_extension(".json");
    TRY(check_outputs({{{options.out ? "--out" : "the scene file", target}}, options.existing},
                      {{"the pictures", options.pictures}}));
    if (std::filesystem::exists(target, ignored) && !read_scene_file(target))
        return usage_error(target.string() + ": is there, and no scene file: it is not replaced");
    NewFile file(target, options.existing);
    TRY(file.write(scene_to_json(guessed)));
    TRY(file.commit());
    std::cout << one_line(target.string()) << " is written; "
              << opening(target, options.pictures, is_folder, guessed.scene) << " opens the pictures so\n";
    for (const Remark& remark : guessed.scene.remarks)  // without hints: corrected in this scene file
        std::cout << "  " << (remark.hints.empty() ? remark_in_words(remark) : remark_with_options(remark))
                  << '\n';
    return {};
}

}  // namespace

void add_init_scene_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand(
        "init-scene", "write a scene file for pictures or a video, guesses marked, to change it");
    auto options = std::make_shared<InitSceneOptions>();
    add_file_option(*sub, "PICTURES", options->pictures, "pictures or video of depth, .bag, or packed clip")
        ->required();
    begin_topic(*sub, files_topic);
    add_file_option(*sub, "--out", options->out,
                    "file to write. By default scene.json in the folder, or beside the picture");
    add_camera_options(*sub, options->camera);
    add_overwrite_option(*sub, options->existing);
    set_work(*sub, command, [options] { return run_init_scene(*options); });
}

}  // namespace touchable
