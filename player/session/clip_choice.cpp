// SPDX-License-Identifier: Apache-2.0
#include "player/session/clip_choice.hpp"

#include <nlohmann/json.hpp>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

namespace {

/// Scale of the clip in the user's hand, from its first frame.
struct InTheHand {
    double metres_per_unit = 0;  ///< hand metres per scene unit: the scene's device scale if stated
    double pixel = 0;            ///< width of a pixel at the median depth, scene units; 0: no pixel is valid
};

Result<InTheHand> in_the_hand(ClipReader& clip) {
    TRY_ASSIGN(const auto first, clip.next());
    if (!first) return input_error(clip.name() + ": has no frames");
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
        const int middle = sorted_element(codes, codes.size() / 2);
        hand.pixel = scene.depth.depth(static_cast<std::uint16_t>(middle)) / scene.camera.fx;
    }
    TRY(clip.rewind());
    return hand;
}

/// How fine relief can be felt: no detail is finer than two pixels.
std::string finest_in_words(const InTheHand& hand, const ClipReader& clip) {
    const double mm = hand.pixel * hand.metres_per_unit * 1000;
    std::string words = formatted(
        "relief: a pixel is %.3g mm of the hand at the median depth; at 100 mm/s a finger feels its finest "
        "details, of two pixels, %.3g times a second",
        mm, 50 / mm);
    const auto colour = std::ranges::find(clip.tracks(), "colour", &TrackInfo::role);
    const Scene& scene = clip.scene();
    if (colour != clip.tracks().end() && (colour->width != scene.width || colour->height != scene.height))
        words += formatted("; colour of %dx%d is felt in depth's %dx%d pixels", colour->width, colour->height,
                           scene.width, scene.height);
    return words;
}

// A run with new settings begins where the previous run is. The previous run reads 12 frames ahead of the
// hand and a temporal filter needs 16 frames before its start, so 28 must be cached; otherwise the two runs
// take turns seeking in one decoder. At 1920x1080 with all four planes these frames take less than 576 MiB.
// Larger frames: 12, enough without such a filter, if they take less than 1 GiB (3840x2160).
constexpr std::size_t most_kept = 32, kept_without_memory = 12, least_kept = 2;
constexpr std::size_t most_newest_bytes = std::size_t{576} << 20, most_first_bytes = std::size_t{128} << 20;

/// Whether the cache exceeds its limit of frames or bytes.
bool is_too_much(std::size_t frames, std::size_t bytes) {
    const std::size_t most = frames > kept_without_memory ? most_newest_bytes : std::size_t{1} << 30;
    return frames > most_kept || (frames > least_kept && bytes > most);
}

std::size_t kept_bytes_of(const RawFrame& frame) {
    std::size_t bytes = 0;
    for (const PlaneView* plane : {&frame.depth, &frame.colour, &frame.haptic, &frame.height})
        bytes += plane->row_bytes() * static_cast<std::size_t>(plane->height);
    return bytes;
}

void apply(const ClipChoice::Filters& choice, FilterSettings& filter, FilterSet& unstated) {
    if (choice.measured.any()) unstated.detail.reset();
    if (choice.measured.detail) {
        unstated.detail = choice.measured.detail;
        unstated.median = unstated.terraces = unstated.temporal = unstated.terrace_reach = true;
        filter.levels = {};
        filter.terrace_reach = least_terrace_reach;
    }
    for (const FilterSetting& setting : filter_settings()) {
        if (!setting.open || !(choice.stated.*setting.open || choice.measured.*setting.open)) continue;
        setting.copy(choice.settings, filter);
        unstated.*setting.open = choice.measured.*setting.open;
    }
    // Enabling terrace removal does not state a reach, so it is measured.
    if ((choice.stated.terraces || choice.measured.terraces) && filter.terrace_reach == least_terrace_reach)
        unstated.terrace_reach = true;
}

/// The clip's description with the user's choices applied.
Result<SceneDescription> applied(const ClipChoice& choice, SceneDescription described) {
    Scene& scene = described.scene;
    FilterSet& unstated = described.unstated.filters;
    apply(choice.filters, scene.filter, unstated);
    apply(choice.single_filters, scene.filter, unstated);
    if (choice.interpolation) scene.interpolation = *choice.interpolation;
    // Terrace removal depends on the level spacing and the temporal filter on noise; neither is measured yet.
    Scene without = scene;
    without.filter.terraces = TerraceRemoval::off;
    without.filter.temporal = false;
    if (auto valid = validate(without); !valid) return usage_error(valid.error().message);
    return described;
}

}  // namespace

Result<std::unique_ptr<ClipReader>> with_chosen_relief(std::unique_ptr<ClipReader> clip,
                                                       const ReliefChoice& choice, SharedClip* shared) {
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
    const auto known = shared ? shared->relief_range(bands) : std::nullopt;
    TRY_ASSIGN(auto looked, known ? Result<LookedAt>({std::move(clip), *known})
                                  : look_at_relief(std::move(clip), choice.settings));
    if (shared) shared->keep_relief_range(bands, looked.range);
    return with_relief(std::move(looked.clip), choice.settings, looked.range, max_height, std::move(notes));
}

/// The clip's description is constant once the clip is open, so reading it takes no lock.
class SharedClip::Reader final : public ReaderAround {
public:
    explicit Reader(std::shared_ptr<SharedClip> shared)
        : ReaderAround(std::shared_ptr<ClipReader>(shared, shared->clip_.get())),
          shared_(std::move(shared)) {}
    void leave_out_colour() override {}  // another reader may want it
    Result<std::optional<RawFrame>> next() override {
        auto frame = shared_->frame(next_number_, is_from_the_beginning_);
        if (frame && *frame) next_number_ = (*frame)->number + 1;
        return frame;
    }
    /// Sets the next frame only. The shared clip seeks when a frame is read that is not cached.
    Result<void> seek(std::int64_t frame) override {
        const auto count = frame_count();
        if (frame < 0 || (count && frame > *count))
            return usage_error("frame " + std::to_string(frame) + ": must be 0 to the clip's last" +
                               (count ? ", " + std::to_string(*count - 1) : std::string()));
        next_number_ = frame;
        is_from_the_beginning_ = false;
        return {};
    }
    std::int64_t access_point(std::int64_t frame) const override {
        const std::lock_guard lock(shared_->mutex_);
        return inner().access_point(frame);
    }

private:
    std::shared_ptr<SharedClip> shared_;
    std::int64_t next_number_ = 0;
    bool is_from_the_beginning_ = true;
};

Result<std::unique_ptr<ClipReader>> SharedClip::open(const Open& open_clip) {
    if (!clip_) {
        TRY(assign(clip_, open_clip()));
        position_ = 0;
    }
    return std::unique_ptr<ClipReader>(std::make_unique<Reader>(shared_from_this()));
}

Result<std::optional<RawFrame>> SharedClip::frame(std::int64_t number, bool is_from_the_beginning) {
    const std::lock_guard lock(mutex_);
    if (!keeps_first_) first_.clear();
    if (const RawFrame* const there = kept(number, is_from_the_beginning)) return std::optional(*there);
    // Not cancellable by one run: a cancelled read would leave the shared clip in the middle of a frame.
    const StopScope work = StopScope::for_all();
    // Unknown after a failed read.
    if (std::exchange(position_, std::nullopt) != number) TRY(clip_->seek(number));
    auto frame = clip_->next();
    if (!frame) return frame;
    position_ = *frame ? (*frame)->number + 1 : number;
    if (*frame) keep(**frame);
    return frame;
}

/// The first frames serve only readers that have not seeked since the beginning, such as measure_depth; for
/// others reading on from them would need a seek.
const RawFrame* SharedClip::kept(std::int64_t number, bool is_from_the_beginning) const {
    for (const RawFrame& frame : newest_)
        if (frame.number == number) return &frame;
    const auto index = static_cast<std::size_t>(number);
    return is_from_the_beginning && index < first_.size() ? &first_[index] : nullptr;
}

void SharedClip::keep(const RawFrame& frame) {
    const std::size_t bytes = kept_bytes_of(frame);
    newest_.push_back(frame);
    newest_bytes_ += bytes;
    while (is_too_much(newest_.size(), newest_bytes_)) {
        newest_bytes_ -= kept_bytes_of(newest_.front());
        newest_.pop_front();
    }
    if (!keeps_first_ || first_.size() == DepthEstimator::frames ||
        frame.number != static_cast<std::int64_t>(first_.size()))
        return;
    first_.push_back(frame);
    first_bytes_ += bytes;
    if (first_bytes_ > most_first_bytes) {
        keeps_first_ = false;
        first_.clear();
    }
}

std::optional<ReliefRange> SharedClip::relief_range(const Bands& bands) const {
    const std::lock_guard lock(relief_mutex_);
    const auto found = relief_ranges_.find(bands);
    return found == relief_ranges_.end() ? std::nullopt : std::optional(found->second);
}

ClipChoice::Filters ClipChoice::Filters::off() {
    Filters choice;
    for (const FilterSetting& setting : filter_settings())
        if (setting.open && *setting.in_list) choice.stated.*setting.open = true;
    return choice;
}

void ClipChoice::choose(const LiveCamera& of) {
    plugged = of.plugged;
    if (plugged) {
        file = name_of(*plugged);
        return;
    }
    file = of.recording;
    as_camera = of.delivery;
}

Result<std::unique_ptr<ClipReader>> ClipChoice::open(Colour colour) const {
    auto reader = open_stored(relief ? Colour::wanted : colour);
    if (relief && reader) reader = with_chosen_relief(std::move(*reader), *relief, shared_clip.get());
    if (painted && reader) reader = with_painted_segments(std::move(*reader), painted);
    return reader;
}

Result<std::unique_ptr<ClipReader>> ClipChoice::open_anew(Colour colour) const {
    if (fill_from_motion && is_camera())
        return usage_error(file.string() +
                           ": is touched as a camera, of which no later frame can tell what is behind a "
                           "hole: leave filling from motion off");
    const Colour read = fill_from_motion ? Colour::wanted : colour;  // colour shows what is behind a hole
    auto opened = !plugged        ? open_clip(file, scene_file, camera, read, alignment)
                  : shared_camera ? shared_camera->open(*plugged, camera, scene_file)
                                  : open_plugged_camera(*plugged, camera, scene_file);
    if (fill_from_motion && opened) opened = with_filled_holes(std::move(*opened));
    auto reader = with_still_maps(std::move(opened), maps);
    if (!reader) return reader;
    if (colour == Colour::left_out) (*reader)->leave_out_colour();
    if (plugged) return reader;
    if (filmed) return make_filmed_camera(std::move(*reader), *filmed, file);
    if (as_camera) return make_replay_camera(std::move(*reader), *as_camera);
    return reader;
}

Result<ClipChoice::Opened> open_chosen(const ClipChoice& choice, Colour colour) {
    TRY_ASSIGN(auto reader, choice.open(colour));
    TRY_ASSIGN(auto wanted, applied(choice, reader->described()));
    TRY_ASSIGN(auto chosen, settle_filters(reader, wanted.unstated.filters, wanted.scene, choice.measured));
    return ClipChoice::Opened{std::move(reader), std::move(wanted.scene), std::move(chosen)};
}

Result<ClipChoice::Opened> open_filtered(const ClipChoice& choice, Colour colour) {
    TRY_ASSIGN(auto opened, open_chosen(choice, colour));
    opened.reader = with_filtered_depth(std::move(opened.reader), opened.scene,
                                        filters_in_words(opened.scene, opened.chosen));
    opened.scene = opened.reader->scene();
    return opened;
}

Result<SegmentStore> read_chosen_segments(const ClipChoice& choice,
                                          const std::function<void(std::int64_t frame)>& progress) {
    if (choice.is_camera())
        return usage_error(
            "materials are painted on clips, whose segments can be found beforehand; this is a camera");
    ClipChoice own = choice;
    own.shared_clip.reset();
    own.relief.reset();  // segments do not depend on relief
    own.painted.reset();
    TRY_ASSIGN(const auto reader, own.open());
    return read_segments(*reader, begin_segments, progress);
}

std::string segments_depend_on(const ClipChoice& choice) {
    const auto whole = [](const std::filesystem::path& file) {
        std::error_code failed;
        const auto name = std::filesystem::weakly_canonical(file, failed);
        return failed ? file.string() : name.string();
    };
    nlohmann::ordered_json said = nlohmann::ordered_json::object();
    if (choice.scene_file) said["scene"] = whole(*choice.scene_file);
    const SourceDescription& of_camera = choice.camera;
    if (const auto& lens = of_camera.intrinsics) {
        said["intrinsics"] = {lens->fx, lens->fy, lens->cx.value_or(-1), lens->cy.value_or(-1)};
        if (lens->fx <= 0) said["seen"] = {lens->fov_x, lens->fov_y};
    }
    // The order stays, as the text names the brush's history: what describes pictures, preset last; the rest.
    for (const bool describes : {true, false})
        for (const SourceSetting& setting : source_settings()) {
            if (setting.describes != describes) continue;
            if (setting.name == Setting::preset && !of_camera.file.empty())
                said["camera-file"] = whole(of_camera.file);
            if (const auto value = setting.get(of_camera))
                std::visit([&](const auto& stated) { said[with_dashes(setting.name)] = stated; }, *value);
        }
    if (choice.alignment != DepthAlignment::automatic)
        said["align"] = choice.alignment == DepthAlignment::on ? "on" : "off";
    if (choice.fill_from_motion) said["fill-from-motion"] = true;
    if (said.empty()) return {};
    return said.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace touchable
