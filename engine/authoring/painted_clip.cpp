#include "engine/authoring/painted_clip.hpp"

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "engine/authoring/haptic_painter.hpp"
#include "engine/authoring/haptic_track.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/plane_role.hpp"

namespace touchable {
namespace {

class PaintedReader final : public HapticTrackReader {
public:
    PaintedReader(std::unique_ptr<ClipReader> clip, const HapticRanges& ranges,
                  std::shared_ptr<const PaintedSegments> painted)
        : HapticTrackReader(std::move(clip), ranges), painted_(std::move(painted)), painter_(ranges) {
        painter_.set(0, {scene().default_properties, 100});
        for (const auto& [label, paint] : painted_->by_label) painter_.set(label, paint.feel);
    }

    Result<std::optional<RawFrame>> next() override {
        auto frame = ReaderAround::next();
        if (!frame || !*frame) return frame;
        RawFrame& raw = **frame;
        const SegmentStore& segments = *painted_->segments;
        if (raw.number >= segments.frames())
            return input_error(inner().inputs().front().string() + ": frame " + std::to_string(raw.number) +
                               " was not there when the clip's " + std::to_string(segments.frames()) +
                               " frames were divided into segments");
        segments.read_labels(raw.number, labels_);
        add_plane(raw, PlaneRole::haptic,
                  plane_from(painter_.haptic(labels_, segments.width(), segments.height())));
        return frame;
    }

private:
    const std::shared_ptr<const PaintedSegments> painted_;
    HapticPainter painter_;
    std::vector<std::uint16_t> labels_;
};

}  // namespace

Result<std::unique_ptr<ClipReader>> with_painted_segments(std::unique_ptr<ClipReader> clip,
                                                          std::shared_ptr<const PaintedSegments> painted) {
    if (clip->is_live())
        return usage_error("materials are of clips, whose frames are all known; this is a camera");
    Scene scene = clip->scene();
    const SegmentStore& segments = *painted->segments;
    if (segments.width() != scene.width || segments.height() != scene.height)
        return usage_error("the segments are of pictures of " + std::to_string(segments.width()) + 'x' +
                           std::to_string(segments.height()) + ", and the clip's depth has " +
                           std::to_string(scene.width) + 'x' + std::to_string(scene.height));
    std::vector<Feel> feels;
    for (const auto& [label, paint] : painted->by_label) feels.push_back(paint.feel);
    scene.haptic = ranges_of_palette(scene, feels);
    TRY(validate(scene));
    return std::unique_ptr<ClipReader>(
        std::make_unique<PaintedReader>(std::move(clip), scene.haptic, std::move(painted)));
}

}  // namespace touchable
