#include "engine/authoring/relief_clip.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/authoring/relief_estimator.hpp"
#include "engine/authoring/relief_heights.hpp"
#include "engine/base/number_words.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/far_plane.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/clip/prefetch.hpp"
#include "engine/clip/reader_around.hpp"

namespace touchable {
namespace {

Result<void> check_colour(const RawFrame& frame, const ClipReader& clip) {
    if (!frame.colour.empty()) return {};
    return input_error(clip.inputs().front().string() + ": frame " + std::to_string(frame.number) +
                       " has no colour, which relief is made of");
}

class ReliefReader final : public ReaderAround {
public:
    ReliefReader(std::unique_ptr<ClipReader> clip, const Scene& scene, const ReliefSettings& settings,
                 const ReliefRange& range, std::vector<std::string> notes);

    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override;
    /// Relief is made of it.
    void leave_out_colour() override {}

private:
    const Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    ReliefFilter filter_;
    ReliefHeights heights_;
    std::optional<FramePlace> before_;
    bool has_told_flicker_ = false;

    void add_flicker();
};

ReliefReader::ReliefReader(std::unique_ptr<ClipReader> clip, const Scene& scene,
                           const ReliefSettings& settings, const ReliefRange& range,
                           std::vector<std::string> notes)
    : ReaderAround(std::move(clip)),
      scene_(scene),
      tracks_(inner().tracks()),
      notes_(inner().notes()),
      filter_(settings, scene.depth),
      heights_(range, settings.amount) {
    const std::string height(role_name(PlaneRole::height));
    std::erase_if(tracks_, [&](const TrackInfo& track) { return track.role == height; });
    tracks_.push_back({height, "relief of colour", "gray", scene.width, scene.height, true});
    std::move(notes.begin(), notes.end(), std::back_inserter(notes_));
}

Result<std::optional<RawFrame>> ReliefReader::next() {
    auto frame = ReaderAround::next();
    if (frame && !*frame) add_flicker();
    if (!frame || !*frame) return frame;
    RawFrame& raw = **frame;
    TRY(check_colour(raw, inner()));
    if (!before_ || !before_->is_before(raw) || raw.number != before_->number + 1) heights_.forget();
    before_.emplace(raw);
    Image image{scene_.width, scene_.height, 1, 1, heights_.next(filter_.apply(raw))};
    add_plane(raw, PlaneRole::height, plane_from(std::move(image), 8));
    return frame;
}

/// After the last frame.
void ReliefReader::add_flicker() {
    const auto flicker = heights_.flicker();
    if (!flicker || has_told_flicker_) return;
    has_told_flicker_ = true;
    notes_.push_back("relief: where colour changes no more than by noise, heights change by " +
                     short_number(flicker->mean, 3) + " of 255 levels a frame, and " +
                     short_number(100 * flicker->more_than_one, 3) + " % of them by more than one");
}

/// What the telling frames have of relief.
Result<ReliefRange> look(Prefetch& ahead, const ReliefSettings& settings) {
    ReliefFilter filter(settings, ahead.clip().scene().depth);
    ReliefEstimator estimator;
    std::optional<std::int64_t> newest;
    const auto add = [&](const RawFrame& frame) -> Result<void> {
        if (stop_requested()) return interrupted_error();
        if (auto fit = check_colour(frame, ahead.clip()); !fit) return fit;
        const NumberField& relief = filter.apply(frame);
        estimator.add(relief, filter.confidence(), newest && frame.number == *newest + 1);
        newest = frame.number;
        return {};
    };
    for (std::int64_t k = 0; k < first_frames; ++k) {
        TRY_ASSIGN(const auto frame, ahead.next());
        if (!frame) return estimator.range();
        TRY(add(*frame));
    }
    for (const std::int64_t wanted : telling_frames(ahead.clip().frame_count().value_or(0))) {
        if (wanted < first_frames) continue;
        const auto frame = ahead.at(wanted);
        if (!frame && frame.error().kind == ErrorKind::interrupted) return frame.error();
        if (!frame || !*frame) break;  // damaged: who reads on learns of it
        TRY(add(**frame));
    }
    return estimator.range();
}

/// The scene with such heights, and what a person should know of them.
Scene with_heights(Scene scene, double max_height, std::vector<std::string>& notes) {
    DepthCoding& depth = scene.depth;
    if (depth.kind == DepthCodingKind::metric && depth.near < 2 * max_height) {
        depth.near = 2 * max_height;
        derive_valid_range(depth);
        notes.push_back("depths below " + short_number(depth.near * scene.metres_per_unit * 1000, 3) +
                        " mm are taken for none, so that heights have room before the camera");
    }
    const double room = depth.nearest_depth() / 2;
    if (max_height > room)
        notes.push_back("heights reach half of the nearest depth, " +
                        short_number(room * scene.metres_per_unit * 1000, 3) +
                        " mm: more would leave no room before the camera");
    scene.height_coding = {std::min(max_height, room), HeightUnits::world, 255};
    return scene;
}

/// What a person should know of it: where it is mostly noise, and where there is none.
std::string range_in_words(const ReliefRange& range) {
    if (range.full <= 1)
        return "relief: nothing of it can be felt: colour is even, in deep shadow, in highlights, or not "
               "seen "
               "by its camera";
    const auto levels = [](std::int32_t number) { return short_number(number / 16.0, 3); };
    std::string words = "relief: the largest height stands for details of " + levels(range.full) +
                        " of 255 levels of brightness";
    if (!range.noise) return words;
    words += "; noise from frame to frame is " + levels(*range.noise);
    // Of noise alone 99 % are within 2.6 deviations.
    if (range.full < 4 * *range.noise)
        words += ", so most of what is felt is noise: a smaller amount or height lessens it";
    return words;
}

}  // namespace

Result<LookedAt> look_at_relief(std::unique_ptr<ClipReader> clip, const ReliefSettings& settings) {
    Prefetch ahead(std::move(clip));
    TRY_ASSIGN(const auto range, look(ahead, settings));
    TRY_ASSIGN(auto again, ahead.finish());
    return LookedAt{std::move(again), range};
}

Result<std::unique_ptr<ClipReader>> with_relief(std::unique_ptr<ClipReader> clip,
                                                const ReliefSettings& settings, const ReliefRange& range,
                                                double max_height, std::vector<std::string> notes) {
    const Scene scene = with_heights(clip->scene(), max_height, notes);
    TRY(validate(scene));
    notes.push_back(range_in_words(range));
    return std::unique_ptr<ClipReader>(
        std::make_unique<ReliefReader>(std::move(clip), scene, settings, range, std::move(notes)));
}

}  // namespace touchable
