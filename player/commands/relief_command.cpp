#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iomanip>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "engine/content/relief/relief_clip.hpp"
#include "engine/surface/code_picture.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/convert_command.hpp"
#include "player/commands/many_clips.hpp"
#include "player/options/clip_options.hpp"
#include "player/options/number_option.hpp"
#include "player/options/outputs.hpp"
#include "player/options/whole_option.hpp"
#include "player/run/clip_workspace.hpp"

namespace touchable {
namespace {

struct ReliefTyped {
    ClipTyped clip;
    ManyClips many;
    ConvertOptions options;
    ReliefSettings relief;
    double height_mm = 0.5;
    bool is_of_world = false;
};

/// What the first frame says of how the clip lies in the hand.
struct InTheHand {
    double metres_per_unit = 0;  ///< of the hand, for a scene unit, where no device of its own says otherwise
    double pixel = 0;            ///< width of a pixel at the median depth, scene units; 0: no pixel is valid
};

Result<InTheHand> in_the_hand(ClipReader& clip) {
    const auto first = clip.next();
    if (!first.ok()) return first.error();
    if (!*first) return input_error(clip.inputs().front().string() + ": has no frames");
    const Scene& scene = clip.scene();
    InTheHand hand;
    if (scene.device_metres_per_unit) {
        hand.metres_per_unit = *scene.device_metres_per_unit;
    } else {
        SurfaceFrame surface;
        if (auto built = make_cpu_builder(scene)->build(**first, surface); !built.ok()) return built.error();
        hand.metres_per_unit = clip_workspace(scene, surface).metres_per_scene_unit;
    }
    std::vector<int> codes = code_picture((*first)->depth, scene.depth).codes;
    std::erase(codes, CodePicture::invalid);
    if (!codes.empty()) {
        const auto middle = codes.begin() + static_cast<std::ptrdiff_t>(codes.size() / 2);
        std::nth_element(codes.begin(), middle, codes.end());
        hand.pixel = scene.depth.depth(static_cast<std::uint16_t>(*middle)) / scene.camera.fx;
    }
    if (auto back = clip.rewind(); !back.ok()) return back.error();
    return hand;
}

/// What a finger gets of it: no detail is finer than two pixels.
std::string finest_in_words(const InTheHand& hand, const ClipReader& clip) {
    const double mm = hand.pixel * hand.metres_per_unit * 1000;
    std::ostringstream words;
    words << std::setprecision(3) << "relief: a pixel is " << mm
          << " mm of the hand at the median depth; at 100 mm/s a finger feels its finest details, of two "
             "pixels, "
          << 50 / mm << " times a second";
    const auto colour = std::find_if(clip.tracks().begin(), clip.tracks().end(),
                                     [](const TrackInfo& track) { return track.role == "colour"; });
    const Scene& scene = clip.scene();
    if (colour != clip.tracks().end() && (colour->width != scene.width || colour->height != scene.height))
        words << "; colour of " << colour->width << "x" << colour->height << " is felt in depth's "
              << scene.width << "x" << scene.height << " pixels";
    return words.str();
}

Result<void> run_relief(const ReliefTyped& typed, const std::filesystem::path& clip,
                        const std::filesystem::path& out) {
    ConvertOptions options = typed.options;
    options.out = out;
    if (options.out.extension() != ".mkv")
        return usage_error("OUT '" + options.out.string() +
                           "' does not end in .mkv, which a clip with relief is; touchable "
                           "convert makes anything else of it");
    const auto choice = read_clip(typed.clip);
    if (!choice.ok()) return choice.error();
    options.clip = *choice;
    options.clip.file = clip;
    if (options.clip.maps.height)
        return usage_error(
            "--height does nothing here: relief makes heights of its own; touchable convert lays a map under "
            "a clip");
    options.made = {PlaneRole::height};
    options.content = [&typed](std::unique_ptr<ClipReader> clip) -> Result<std::unique_ptr<ClipReader>> {
        const auto hand = in_the_hand(*clip);
        if (!hand.ok()) return hand.error();
        const double metres_per_unit =
            typed.is_of_world ? clip->scene().metres_per_unit : hand->metres_per_unit;
        std::vector<std::string> notes;
        if (hand->pixel > 0) notes.push_back(finest_in_words(*hand, *clip));
        return with_relief(std::move(clip), typed.relief, typed.height_mm / 1000 / metres_per_unit,
                           std::move(notes));
    };
    return run_convert(options);
}

}  // namespace

void add_relief_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand("relief", "write a clip with a relief to be felt, made of its colour");
    auto typed = std::make_shared<ReliefTyped>();
    ReliefSettings& relief = typed->relief;
    add_clip_options(*sub, typed->clip)->required();
    typed->many.add_option(*sub, "the clip to write, NAME.mkv");
    add_camera_options(*sub, typed->clip.camera);
    add_overwrite_option(*sub, typed->options.existing);
    const char* share = "per cent, -400 to 400";
    add_whole_option(*sub, "--fine", relief.bands[0], std::string("details of 2 to 4 pixels, ") + share, -400,
                     400)
        ->capture_default_str();
    add_whole_option(*sub, "--medium", relief.bands[1], std::string("details of 5 to 10 pixels, ") + share,
                     -400, 400)
        ->capture_default_str();
    add_whole_option(*sub, "--coarse", relief.bands[2], std::string("details of 11 to 25 pixels, ") + share,
                     -400, 400)
        ->capture_default_str();
    add_whole_option(*sub, "--amount", relief.amount, "of all of it, per cent, 0 to 400", 0, 400)
        ->capture_default_str();
    sub->add_flag("--invert", relief.invert, "what is dark stands out, not what is bright");
    add_number_option(*sub, "--max-height", typed->height_mm,
                      "from the deepest to the highest, mm of the hand, up to 20", 0.001, 20)
        ->capture_default_str();
    sub->add_flag("--of-world", typed->is_of_world,
                  "--max-height is mm of the world that was recorded, not of the hand");
    sub->callback([typed, &command] {
        command = [typed] {
            return typed->many.for_each(
                typed->clip.choice.file, typed->options.existing,
                [typed](const auto& clip, const auto& out) { return run_relief(*typed, clip, out); });
        };
    });
}

}  // namespace touchable
