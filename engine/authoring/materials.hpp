#pragma once

// Haptic pictures for a recording that has none: each segment feels like a material.
//
// A guess by colour and place says what a segment may be; what a person says of it counts before that.
// HapticPainter writes a frame's haptic picture and its heights by labels; the clips here are readers around
// a reader, one by names, one as it was painted by a brush.
//
// A reader is one thread's; a stop is heard between frames.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/authoring/segments.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/readers.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What is seen of a segment.
struct SegmentLook {
    std::array<std::uint8_t, 3> colour{};  ///< mean, RGB
    std::int32_t contrast = 0;  ///< mean absolute deviation of brightness from its blur, 1/16 levels
    std::int32_t pixels = 0, of_pixels = 1;  ///< its own, and the picture's
};

/// A material that such a segment may be of, by a few rules of thumb. Colour tells little: a painted wall is
/// as white as paper. Whole numbers, the same on every machine.
const PaletteMaterial& guess_material(const SegmentLook& look);

/// What a segment is like, and who says so.
struct SegmentPaint {
    std::string name{};      ///< empty: nobody gave it one
    std::string material{};  ///< of the palette; empty: values of its own
    Feel feel{};
    bool is_guess = false;
};

/// Of a segment as it was seen first, in a picture of so many pixels: as it is named, otherwise as all others
/// are; null: as its look suggests.
SegmentPaint paint_of(const Segment& segment, std::int32_t of_pixels, const LabelNames& named,
                      const PaletteMaterial* otherwise);

/// Ranges that hold the whole palette, the scene's defaults and these: the same for all choices of
/// materials, and one for both frictions, so that rounding never puts the dynamic one above the static one.
HapticRanges ranges_of_palette(const Scene& scene, const std::vector<Feel>& others);

/// The haptic pixel nearest to that.
std::array<std::uint8_t, 3> haptic_code(const HapticProperties& properties, const HapticRanges& ranges);

/// Paints each pixel as its segment feels. Pixels of no segment, which are holes, get what is nearest: a
/// hole's rim is as hard as what it is in, and so is what filters put there.
class HapticPainter {
public:
    explicit HapticPainter(const HapticRanges& ranges) : ranges_(ranges), codes_(65536), reliefs_(65536) {}

    /// What segments of this label feel like, 0: a picture without any.
    void set(std::uint16_t label, const Feel& feel);
    /// Of labels that were set, row by row; 0: no segment.
    Image haptic(const std::vector<std::uint16_t>& labels, int width, int height);
    /// Of the picture that was painted last: its heights, 8 bits, around level (128) scaled by relief.
    Image scaled(const PlaneView& height) const;

private:
    HapticRanges ranges_;
    std::vector<std::array<std::uint8_t, 3>> codes_;  // by label
    std::vector<int> reliefs_;
    std::vector<std::uint16_t> labels_;  // of all pixels
    NearestLabel nearest_;
};

/// A clip with haptic pictures of these ranges in place of its own, which a class derived from this paints.
class HapticTrackReader : public ReaderAround {
public:
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    const std::vector<std::string>& notes() const override { return notes_; }

protected:
    /// `ranges` are valid (validate).
    HapticTrackReader(std::unique_ptr<ClipReader> clip, const HapticRanges& ranges);

private:
    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
};

/// What all segments of a clip are like: of one moment, never changed.
struct PaintedSegments {
    std::shared_ptr<const SegmentStore> segments;
    using Paint = SegmentPaint;
    std::map<std::uint16_t, Paint> by_label{};  ///< of all that are seen anywhere
};

/// The clip with haptic pictures in place of its own, in which each segment feels as painted: those that
/// with_materials makes of the same names. Any frame at once. Refused (ErrorKind::usage) where the clip has
/// not the segments' size, and for a live source.
Result<std::unique_ptr<ClipReader>> with_painted_segments(std::unique_ptr<ClipReader> clip,
                                                          std::shared_ptr<const PaintedSegments> painted);

struct MaterialSettings {
    SegmentNames names{};
    std::optional<SegmentMap> map{};
    /// Heights (8 bits, 128 is level, as with_relief makes them) are scaled by each material's relief.
    bool scale_relief = false;
    /// That the haptic pictures have; values beyond are cut. Nothing: some that hold all (ranges_of_palette).
    std::optional<HapticRanges> ranges{};
};

/// A segment as it was seen first.
struct SeenSegment {
    std::uint16_t label = 0;
    PixelOfFrame at{};  ///< a pixel of it
    std::int32_t pixels = 0;
    std::array<std::uint8_t, 3> colour{};
    SegmentPaint paint{};
};

/// What was found in the frames read since the clip's beginning.
struct MaterialReport {
    std::vector<SeenSegment> segments;  ///< in the order in which they came
    std::int64_t frames = 0;
    /// Pixels with a segment in two frames that follow each other, and those whose segment is another one.
    std::int64_t compared = 0, changed = 0;
    double seconds = 0;  ///< that segments and haptic pictures took
};

/// The segments of all frames of a clip, which is at its beginning; it is at its end then. `progress`, if
/// any, is called before each frame with its number. Refused: a frame that cannot be read; no frames; more
/// segments than fit into 1 GiB.
Result<SegmentStore> read_segments(ClipReader& clip, const BeginSegments& begin,
                                   const std::function<void(std::int64_t frame)>& progress);

/// The clip with haptic pictures in place of its own, in which each segment feels like its material: as it
/// is named, otherwise as its first look suggests. A segment keeps its material. The report is filled as
/// frames are read. Seeking reads all frames from the first on, since segments are followed; where
/// segments are cut all are read once before. Refused as find_named_segments and with_cuts do; a frame is
/// where its colour is needed for a guess, and where its heights cannot be scaled.
Result<std::unique_ptr<ClipReader>> with_materials(std::unique_ptr<ClipReader> clip,
                                                   const MaterialSettings& settings,
                                                   const BeginSegments& begin,
                                                   std::shared_ptr<MaterialReport> report);

}  // namespace touchable
