#include "engine/formats/guessed_scene.hpp"

#include <optional>
#include <utility>

#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/picture_roles.hpp"
#include "engine/formats/scene_guess.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

Result<const Preset*> known_preset(const SourceDescription& known) {
    if (known.preset.empty()) return static_cast<const Preset*>(nullptr);
    if (const Preset* preset = preset_named(known.preset)) return preset;
    if (video_values_named(known.preset))
        return usage_error("preset " + known.preset + " is of videos of depth", {{Setting::preset}});
    std::string names;
    for (const Preset& each : all_presets()) names += (names.empty() ? "" : ", ") + std::string(each.name);
    return usage_error("preset " + known.preset + " is not known: must be one of " + names,
                       {{Setting::preset}});
}

}  // namespace

Result<GuessedScene> guess_folder(const fs::path& folder, const SourceDescription& known) {
    TRY_ASSIGN(const auto preset, known_preset(known));
    const auto pictures = std::make_shared<ReadPictures>();
    TRY_ASSIGN(const auto groups, readable_groups(folder, *pictures));
    std::vector<const PictureGroup*> depths = depths_among(groups, *pictures);
    const bool is_relative = preset != nullptr && preset->stored.kind == StoredDepth::Kind::relative;
    if (depths.empty() &&
        (is_relative || has_word(fs::weakly_canonical(folder).filename().string(), {"depth"})))
        depths = greys_among(groups, *pictures);
    if (depths.empty() && stop_requested()) return interrupted_looking(folder);
    if (depths.empty()) return without_depth(folder, groups);
    const PictureGroup* const depth = depths.front();
    const PictureGroup* const colour = colour_among(groups, depths, *pictures);
    if (stop_requested()) return interrupted_looking(folder);  // so it may not be that there is none
    FolderSource all;
    all.depth = depth->pattern;
    const auto files = depth_files(folder, all);
    TRY_ASSIGN(const auto told, telling_depth(files ? files->files : std::vector{depth->first}, *pictures));
    const StoredImage& stored = *told;
    std::optional<GuessedCameras> cameras;
    if (!known.intrinsics && !known.fov) {
        TRY_ASSIGN(auto found,
                   guess_cameras(folder, depth->pattern, stored.image.width, stored.image.height));
        cameras = std::move(found);
    }
    const bool is_arkit = cameras && preset == nullptr && !known.metres_per_code && holds_words(stored);
    const bool is_open = preset == nullptr && !known.metres_per_code && !is_arkit;
    const EvidentPreset evident = is_open ? evident_preset(stored) : EvidentPreset();
    SceneGuess guess(known, is_arkit         ? preset_named("arkitscenes")
                            : evident.preset ? evident.preset
                                             : preset);
    if (cameras) guess.know_cameras(*cameras);
    if (is_list_of_depth(depth->pattern)) guess.know_list(depth->pattern);
    guess.know_place({.folder = folder, .within = folder_of(*depth), .is_whole_folder = true});
    if (auto described = guess.describe(folder, stored); !described)
        return error_at(folder.string(), described.error());
    if (is_arkit)
        guess.say("a code is 1 mm and 0 is no depth, as ARKitScenes has them", Hints{{Setting::depth_unit}});
    guess.tell_of_preset(evident);
    guess.tell_of_jpeg(stored);
    Scene& scene = guess.scene();
    scene.name = fs::weakly_canonical(folder).filename().string();
    scene.folder.emplace();
    scene.folder->depth = depth->pattern;
    if (cameras && !is_still(cameras->files) && scene.stored.kind != StoredDepth::Kind::disparity)
        scene.folder->cameras = cameras->files;
    const BesideDepth* const beside = stored.beside.get();
    const bool has_own_colour = colour == nullptr && beside != nullptr && beside->colour;
    if (colour != nullptr) scene.folder->colour = colour->pattern;
    if (has_own_colour) scene.folder->colour = depth->pattern;
    for (const PictureGroup& group : groups)
        if (has_word(group.pattern, {"haptic"}) && scene.folder->haptic.empty())
            scene.folder->haptic = group.pattern;
    for (const std::string& remark : unusable_lists(folder)) guess.say(remark);
    guess.say("depth is " + depth->pattern +
              (colour != nullptr ? ", colour is " + colour->pattern
               : has_own_colour  ? ", colour is in the same files"
                                 : ", there is no colour"));
    if (beside != nullptr) guess.tell_of_layers(*beside, has_own_colour);
    if (const std::string others = left_out(depths); !others.empty())
        guess.say("left out: " + others, "name one of these to open it");
    if (colour != nullptr) guess.place_colour(folder, colour->first, *pictures);
    if (depth->count > 1) TRY(guess.find_rate(folder));
    GuessedScene made = guess.made();
    pictures->keep_only({depth->first, colour != nullptr ? colour->first : fs::path()});
    made.pictures = pictures;
    return made;
}

Result<GuessedScene> guess_scene(const fs::path& folder, const StoredImage& depth,
                                 const SourceDescription& known, const DepthCoding* coding) {
    TRY_ASSIGN(const auto preset, known_preset(known));
    SceneGuess guess(known, preset);
    TRY(guess.describe(folder, depth, coding));
    return guess.made();
}

Result<GuessedScene> guess_picture(const SourceFile& source, const SourceDescription& known) {
    const fs::path& file = source.path();
    TRY_ASSIGN(const auto preset, known_preset(known));
    const std::string name = file.filename().string();
    if (!is_still(name))
        return input_error(file.string() + ": has a % or * in its name, which stand for numbers: rename it");
    const auto pictures = std::make_shared<ReadPictures>(source);
    pictures->trust_from(known.least_confidence);
    TRY_ASSIGN(const auto told, telling_depth({file}, *pictures));
    const StoredImage& stored = *told;
    const bool is_open = preset == nullptr && !known.metres_per_code;
    const EvidentPreset evident = is_open ? evident_preset(stored) : EvidentPreset();
    SceneGuess guess(known, evident.preset ? evident.preset : preset);
    guess.know_place({.folder = file.parent_path(), .within = {}, .stem = file.stem().string()});
    if (auto described = guess.describe(file.parent_path(), stored); !described)
        return error_at(file.string(), described.error());
    guess.tell_of_preset(evident);
    guess.tell_of_jpeg(stored);
    guess.scene().name = file.stem().string();
    guess.scene().folder.emplace();
    guess.scene().folder->depth = name;
    if (const auto colour = colour_beside(file, *pictures)) {
        guess.scene().folder->colour = colour->filename().string();
        guess.say("colour is " + guess.scene().folder->colour);
        guess.place_colour(file.parent_path(), *colour, *pictures);
    } else if (stored.beside && stored.beside->colour) {
        guess.scene().folder->colour = name;
    }
    if (stored.beside) guess.tell_of_layers(*stored.beside, guess.scene().folder->colour == name);
    GuessedScene made = guess.made();
    made.pictures = pictures;
    return made;
}

}  // namespace touchable
