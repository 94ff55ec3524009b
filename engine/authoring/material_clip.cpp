#include "engine/authoring/material_clip.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "engine/authoring/haptic_painter.hpp"
#include "engine/authoring/haptic_track.hpp"
#include "engine/authoring/segment_paint.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/plane_role.hpp"

namespace touchable {
namespace {

constexpr std::size_t most_segment_bytes = std::size_t{1} << 30;

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

class MaterialReader final : public HapticTrackReader {
public:
    MaterialReader(std::unique_ptr<ClipReader> clip, const HapticRanges& ranges, Materials materials,
                   BeginSegments begin, std::shared_ptr<MaterialReport> report);

    Result<std::optional<RawFrame>> next() override;
    Result<void> seek(std::int64_t frame) override;
    std::int64_t access_point(std::int64_t) const override { return 0; }
    /// Segments are made of it.
    void leave_out_colour() override {}

private:
    void start();
    void meet(const Segment& segment, std::int64_t frame);
    void count_changes(const Segmentation& segmentation);

    const Materials materials_;
    const BeginSegments begin_;
    const std::shared_ptr<MaterialReport> report_;

    SegmentFrames segments_of_;
    HapticPainter painter_;
    std::vector<bool> met_;  // by label
    std::vector<std::uint16_t> labels_before_;
    std::optional<FramePlace> before_;
};

MaterialReader::MaterialReader(std::unique_ptr<ClipReader> clip, const HapticRanges& ranges,
                               Materials materials, BeginSegments begin,
                               std::shared_ptr<MaterialReport> report)
    : HapticTrackReader(std::move(clip), ranges),
      materials_(std::move(materials)),
      begin_(std::move(begin)),
      report_(std::move(report)),
      painter_(ranges) {
    start();
}

/// Before the first frame.
void MaterialReader::start() {
    segments_of_ = begin_(scene());
    painter_ = HapticPainter(scene().haptic);
    painter_.set(0, {scene().default_properties, 100});
    met_.assign(65536, false);
    before_.reset();
    *report_ = {};
}

void MaterialReader::meet(const Segment& segment, std::int64_t frame) {
    SegmentPaint paint =
        paint_of(segment, scene().width * scene().height, materials_.named, materials_.otherwise);
    painter_.set(segment.label, paint.feel);
    met_[segment.label] = true;
    report_->segments.push_back(
        {segment.label, {segment.x, segment.y, frame}, segment.pixels, segment.colour, std::move(paint)});
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
    if (materials_.otherwise == nullptr) TRY(check_colour(raw, inner()));
    if (materials_.scale_relief) TRY(check_heights(raw, inner()));
    const auto begun = std::chrono::steady_clock::now();
    const bool follows = before_ && before_->is_before(raw) && raw.number == before_->number + 1;
    const Segmentation& segmentation = segments_of_(raw, follows);
    for (const Segment& segment : segmentation.segments)
        if (!met_[segment.label]) meet(segment, raw.number);
    if (follows) count_changes(segmentation);
    labels_before_ = segmentation.labels;
    before_.emplace(raw);
    Image haptic = painter_.haptic(segmentation.labels, scene().width, scene().height);
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
        TRY_ASSIGN(const auto passed, next());
        if (!passed) break;
    }
    return {};
}

Result<std::unique_ptr<ClipReader>> begin_reading(std::unique_ptr<ClipReader> clip,
                                                  const MaterialSettings& settings, LabelNames named,
                                                  const BeginSegments& begin,
                                                  std::shared_ptr<MaterialReport> report) {
    std::vector<Feel> others;
    for (const NamedSegment& name : settings.names.segments) others.push_back(name.feel);
    Scene scene = clip->scene();
    scene.haptic = settings.ranges.value_or(ranges_of_palette(scene, others));
    TRY(validate(scene));
    Materials materials{std::move(named), find_material(settings.names.otherwise), settings.scale_relief};
    return std::unique_ptr<ClipReader>(std::make_unique<MaterialReader>(
        std::move(clip), scene.haptic, std::move(materials), begin, std::move(report)));
}

/// Cuts are followed both ways through time, so that all frames are read before.
Result<std::unique_ptr<ClipReader>> with_cut_materials(std::unique_ptr<ClipReader> clip,
                                                       const MaterialSettings& settings,
                                                       const BeginSegments& begin,
                                                       std::shared_ptr<MaterialReport> report) {
    TRY_ASSIGN(auto read, read_segments(*clip, begin, {}));
    TRY_ASSIGN(auto cut, with_cuts(std::move(read), settings.names));
    TRY_ASSIGN(auto named, find_named_segments(cut, settings.names, settings.map));
    TRY(clip->rewind());
    struct Known {
        SegmentStore segments;
        Segmentation now;
    };
    const auto known = std::make_shared<Known>(Known{std::move(cut), {}});
    return begin_reading(
        std::move(clip), settings, std::move(named),
        [known](const Scene&) {
            return [known](const RawFrame& frame, bool) -> const Segmentation& {
                return known->now = known->segments.segmentation(frame.number);
            };
        },
        std::move(report));
}

}  // namespace

Result<SegmentStore> read_segments(ClipReader& clip, const BeginSegments& begin,
                                   const std::function<void(std::int64_t frame)>& progress) {
    const Scene& scene = clip.scene();
    SegmentStore segments(scene.width, scene.height);
    const SegmentFrames segments_of = begin(scene);
    for (;;) {
        if (stop_requested()) return interrupted_error();
        TRY_ASSIGN(const auto frame, clip.next());
        if (!frame) break;
        if (frame->number != segments.frames())
            return input_error(clip.inputs().front().string() + ": frame " + std::to_string(frame->number) +
                               " comes after frame " + std::to_string(segments.frames() - 1) +
                               "; must be the next one");
        if (progress) progress(frame->number);
        segments.add(segments_of(*frame, segments.frames() > 0));
        if (segments.bytes() > most_segment_bytes)
            return input_error(
                clip.inputs().front().string() + ": its first " + std::to_string(segments.frames()) +
                " frames have segments of 1 GiB, as many as are kept; a shorter clip would do");
    }
    if (segments.frames() == 0) return input_error(clip.inputs().front().string() + ": has no frames");
    return segments;
}

Result<std::unique_ptr<ClipReader>> with_materials(std::unique_ptr<ClipReader> clip,
                                                   const MaterialSettings& settings,
                                                   const BeginSegments& begin,
                                                   std::shared_ptr<MaterialReport> report) {
    if (!settings.names.cuts.empty()) return with_cut_materials(std::move(clip), settings, begin, report);
    Prefetch ahead(std::move(clip));
    TRY_ASSIGN(auto named, find_named_segments(ahead, settings.names, settings.map, begin));
    TRY_ASSIGN(auto again, ahead.finish());
    return begin_reading(std::move(again), settings, std::move(named), begin, std::move(report));
}

}  // namespace touchable
