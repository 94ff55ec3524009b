#include "player/session/relief_choice.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"
#include "engine/surface/code_picture.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/run/clip_workspace.hpp"

namespace touchable {
namespace {

/// What the first frame says of how the clip lies in the hand.
struct InTheHand {
    double metres_per_unit = 0;  ///< of the hand, for a scene unit, where no device of its own says otherwise
    double pixel = 0;            ///< width of a pixel at the median depth, scene units; 0: no pixel is valid
};

Result<InTheHand> in_the_hand(ClipReader& clip) {
    TRY_ASSIGN(const auto first, clip.next());
    if (!first) return input_error(clip.inputs().front().string() + ": has no frames");
    const Scene& scene = clip.scene();
    InTheHand hand;
    if (scene.device_metres_per_unit) {
        hand.metres_per_unit = *scene.device_metres_per_unit;
    } else {
        SurfaceFrame surface;
        TRY(make_cpu_builder(scene)->build(*first, surface));
        hand.metres_per_unit = clip_workspace(scene, surface).metres_per_scene_unit;
    }
    std::vector<int> codes = code_picture(first->depth, scene.depth).codes;
    std::erase(codes, CodePicture::invalid);
    if (!codes.empty()) {
        const auto middle = codes.begin() + static_cast<std::ptrdiff_t>(codes.size() / 2);
        std::nth_element(codes.begin(), middle, codes.end());
        hand.pixel = scene.depth.depth(static_cast<std::uint16_t>(*middle)) / scene.camera.fx;
    }
    TRY(clip.rewind());
    return hand;
}

/// What a finger gets of it: no detail is finer than two pixels.
std::string finest_in_words(const InTheHand& hand, const ClipReader& clip) {
    const double mm = hand.pixel * hand.metres_per_unit * 1000;
    std::string words = formatted(
        "relief: a pixel is %.3g mm of the hand at the median depth; at 100 mm/s a finger feels its finest "
        "details, of two pixels, %.3g times a second",
        mm, 50 / mm);
    const auto colour = std::find_if(clip.tracks().begin(), clip.tracks().end(),
                                     [](const TrackInfo& track) { return track.role == "colour"; });
    const Scene& scene = clip.scene();
    if (colour != clip.tracks().end() && (colour->width != scene.width || colour->height != scene.height))
        words += formatted("; colour of %dx%d is felt in depth's %dx%d pixels", colour->width, colour->height,
                           scene.width, scene.height);
    return words;
}

}  // namespace

std::optional<ReliefRange> ReliefMemory::range(const Bands& bands) const {
    const std::lock_guard lock(mutex_);
    const auto found = ranges_.find(bands);
    return found == ranges_.end() ? std::nullopt : std::optional(found->second);
}

void ReliefMemory::keep(const Bands& bands, const ReliefRange& range) {
    const std::lock_guard lock(mutex_);
    ranges_[bands] = range;
}

Result<std::unique_ptr<ClipReader>> with_chosen_relief(std::unique_ptr<ClipReader> clip,
                                                       const ReliefChoice& choice, ReliefMemory* memory) {
    if (clip->is_live())
        return usage_error(
            "relief is made of clips, whose colour can be looked at beforehand; this is a camera");
    TRY_ASSIGN(const auto hand, in_the_hand(*clip));
    const double metres_per_unit = choice.is_of_world ? clip->scene().metres_per_unit : hand.metres_per_unit;
    const double max_height = choice.height_mm / 1000 / metres_per_unit;
    std::vector<std::string> notes;
    notes.push_back(formatted("relief: %.3g mm of the hand are %.3g mm of what was recorded",
                              max_height * hand.metres_per_unit * 1000,
                              max_height * clip->scene().metres_per_unit * 1000));
    if (hand.pixel > 0) notes.push_back(finest_in_words(hand, *clip));
    const auto& bands = choice.settings.bands;
    const auto known = memory ? memory->range(bands) : std::nullopt;
    auto looked = known ? LookedAt{std::move(clip), *known} : LookedAt{};
    if (!known) {
        TRY_ASSIGN(auto found, look_at_relief(std::move(clip), choice.settings));
        looked = std::move(found);
        if (memory) memory->keep(bands, looked.range);
    }
    return with_relief(std::move(looked.clip), choice.settings, looked.range, max_height, std::move(notes));
}

}  // namespace touchable
