#include "engine/content/materials/material_clip.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "engine/clip/plane_role.hpp"
#include "engine/clip/reader_around.hpp"
#include "engine/content/materials/haptic_painter.hpp"
#include "engine/content/materials/material_guess.hpp"
#include "engine/stop_request.hpp"

namespace touchable {
namespace {

/// Which guesses are made of.
Result<void> check_colour(const RawFrame& frame, const ClipReader& clip) {
    if (!frame.colour.empty()) return {};
    return input_error(clip.inputs().front().string() + ": frame " + std::to_string(frame.number) +
                       " has no colour, by which materials are guessed; say what all segments are that are "
                       "not named");
}

/// Those that are to be scaled.
Result<void> check_heights(const RawFrame& frame, const ClipReader& clip) {
    const auto refuse = [&](const char* why) {
        return input_error(clip.inputs().front().string() + ": frame " + std::to_string(frame.number) + why);
    };
    if (frame.height.empty()) return refuse(" has no heights to be scaled; touchable relief makes some");
    if (frame.height.bytes_per_sample != 1 || clip.scene().height_coding.code_max != 255)
        return refuse(" has heights of more than 8 bits; those of touchable relief can be scaled");
    return {};
}

struct Materials {
    LabelNames named;
    const PaletteMaterial* otherwise = nullptr;  // null: a guess for each
    bool scale_relief = false;
};

class MaterialReader final : public ReaderAround {
public:
    MaterialReader(std::unique_ptr<ClipReader> clip, Scene scene, Materials materials, BeginSegments begin,
                   std::shared_ptr<MaterialReport> report);

    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override;
    Result<void> seek(std::int64_t frame) override;
    std::int64_t access_point(std::int64_t) const override { return 0; }
    /// Segments are made of it.
    void leave_out_colour() override {}

private:
    void start();
    void describe();
    void meet(const Segment& segment, std::int64_t frame);
    void count_changes(const Segmentation& segmentation);

    const Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    const Materials materials_;
    const BeginSegments begin_;
    const std::shared_ptr<MaterialReport> report_;

    SegmentFrames segments_of_;
    HapticPainter painter_;
    std::vector<bool> met_;  // by label
    std::vector<std::uint16_t> labels_before_;
    std::optional<FramePlace> before_;
};

MaterialReader::MaterialReader(std::unique_ptr<ClipReader> clip, Scene scene, Materials materials,
                               BeginSegments begin, std::shared_ptr<MaterialReport> report)
    : ReaderAround(std::move(clip)),
      scene_(std::move(scene)),
      tracks_(inner().tracks()),
      notes_(inner().notes()),
      materials_(std::move(materials)),
      begin_(std::move(begin)),
      report_(std::move(report)),
      painter_(scene_.haptic) {
    describe();
    start();
}

/// A haptic track instead of another, or of none.
void MaterialReader::describe() {
    const std::string haptic(role_name(PlaneRole::haptic)), height(role_name(PlaneRole::height));
    std::erase_if(tracks_, [&](const TrackInfo& track) { return track.role == haptic; });
    const auto after = std::find_if(tracks_.begin(), tracks_.end(),
                                    [&](const TrackInfo& track) { return track.role == height; });
    tracks_.insert(after, {haptic, "materials of segments", "rgb24", scene_.width, scene_.height, true});
    const auto of_none = default_touch_note(false, inner().scene());
    std::erase_if(notes_, [&](const std::string& note) {
        return note.starts_with(haptic + " is ") || (of_none && note == *of_none);
    });
}

/// Before the first frame.
void MaterialReader::start() {
    segments_of_ = begin_(scene_);
    painter_ = HapticPainter(scene_.haptic);
    painter_.set(0, {scene_.default_properties, 100});
    met_.assign(65536, false);
    before_.reset();
    *report_ = {};
}

void MaterialReader::meet(const Segment& segment, std::int64_t frame) {
    SeenSegment seen{segment.label, {segment.x, segment.y, frame}, segment.pixels, segment.colour};
    const auto named = materials_.named.find(segment.label);
    if (named != materials_.named.end()) {
        seen.name = named->second.name;
        seen.is_guess = named->second.is_guess;
        seen.material = named->second.material;
        seen.feel = named->second.feel;
    } else {
        seen.is_guess = materials_.otherwise == nullptr;
        const PaletteMaterial& material = seen.is_guess
                                              ? guess_material({segment.colour, segment.contrast,
                                                                segment.pixels, scene_.width * scene_.height})
                                              : *materials_.otherwise;
        seen.material = material.name;
        seen.feel = material.feel();
    }
    painter_.set(segment.label, seen.feel);
    met_[segment.label] = true;
    report_->segments.push_back(std::move(seen));
}

void MaterialReader::count_changes(const Segmentation& segmentation) {
    for (std::size_t k = 0; k < labels_before_.size(); ++k) {
        const std::uint16_t now = segmentation.labels[k], earlier = labels_before_[k];
        report_->compared += now != 0 && earlier != 0;
        report_->changed += now != 0 && earlier != 0 && now != earlier;
    }
}

Result<std::optional<RawFrame>> MaterialReader::next() {
    auto frame = ReaderAround::next();
    if (!frame || !*frame) return frame;
    RawFrame& raw = **frame;
    if (materials_.otherwise == nullptr)
        if (auto fit = check_colour(raw, inner()); !fit) return fit.error();
    if (materials_.scale_relief)
        if (auto fit = check_heights(raw, inner()); !fit) return fit.error();
    const auto begun = std::chrono::steady_clock::now();
    const bool follows = before_ && before_->is_before(raw) && raw.number == before_->number + 1;
    const Segmentation& segmentation = segments_of_(raw, follows);
    for (const Segment& segment : segmentation.segments)
        if (!met_[segment.label]) meet(segment, raw.number);
    if (follows) count_changes(segmentation);
    labels_before_ = segmentation.labels;
    before_.emplace(raw);
    Image haptic = painter_.haptic(segmentation);
    if (materials_.scale_relief)
        add_plane(raw, PlaneRole::height, plane_from(painter_.scaled(raw.height), 8));
    add_plane(raw, PlaneRole::haptic, plane_from(std::move(haptic)));
    ++report_->frames;
    report_->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    return frame;
}

Result<void> MaterialReader::seek(std::int64_t frame) {
    const auto count = frame_count();
    if (count && frame > *count) return inner().seek(frame);  // which refuses it
    if (auto back = inner().seek(0); !back) return back;
    start();
    for (std::int64_t number = 0; number < frame; ++number) {
        if (stop_requested()) return interrupted_error();
        const auto passed = next();
        if (!passed) return passed.error();
        if (!*passed) break;
    }
    return {};
}

}  // namespace

Result<std::unique_ptr<ClipReader>> with_materials(std::unique_ptr<ClipReader> clip,
                                                   const MaterialSettings& settings,
                                                   const BeginSegments& begin,
                                                   std::shared_ptr<MaterialReport> report) {
    Prefetch ahead(std::move(clip));
    auto named = find_named_segments(ahead, settings.names, settings.map, begin);
    if (!named) return named.error();
    auto again = ahead.finish();
    if (!again) return again.error();
    Scene scene = (*again)->scene();
    std::vector<Feel> others;
    for (const NamedSegment& name : settings.names.segments) others.push_back(name.feel);
    scene.haptic = settings.ranges.value_or(ranges_of_palette(scene, others));
    if (auto valid = validate(scene); !valid) return valid.error();
    Materials materials{std::move(*named), find_material(settings.names.otherwise), settings.scale_relief};
    return std::unique_ptr<ClipReader>(std::make_unique<MaterialReader>(
        std::move(*again), std::move(scene), std::move(materials), begin, std::move(report)));
}

}  // namespace touchable
