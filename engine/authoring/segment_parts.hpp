#pragma once

// What the sources of segments and of their materials share: cuts, what a segment feels like, places in JSON.

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "engine/authoring/materials.hpp"
#include "engine/authoring/segments.hpp"
#include "engine/scene/checked_json.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Gives pixels without a label (0) that of the nearest one that has any, by a distance transform.
class NearestLabel {
public:
    /// `labels`: width x height, row by row. Where none has a label all stay as they are.
    void fill(std::vector<std::uint16_t>& labels, int width, int height);

private:
    std::vector<std::int32_t> distances_;  // to the label, a third of a pixel
};

/// The label on which most of the stroke lies, of a picture of labels with that width; 0: none. The stroke
/// lies in the picture.
std::uint16_t label_under(const SegmentCut& cut, const std::vector<std::uint16_t>& labels, int width);

/// Parts one segment along a stroke, and follows both parts from frame to frame.
class CutFollower {
public:
    /// Of a picture of width x height labels; `part` is the label of the smaller part.
    CutFollower(std::uint16_t label, std::uint16_t part, int width, int height)
        : label_(label),
          part_(part),
          width_(width),
          height_(height),
          known_(pixel_count(width, height)),
          known_box_{width, height, 0, 0} {}

    /// The frame in which it was drawn. False: the stroke does not part the segment, and nothing was changed.
    bool begin(const SegmentCut& cut, std::vector<std::uint16_t>& labels);
    /// A frame beside the last one that was given, either way through time. Each pixel of the segment belongs
    /// to the part that it belonged to when it was last seen, once the segment is moved as it moved since
    /// then; one that was never seen, to the nearest part. A frame without the segment stays as it is.
    void next(std::vector<std::uint16_t>& labels);

private:
    struct Box {
        int left, top, right, bottom;  // right and bottom beyond the last pixel
        void hold(const Box& other);
    };
    struct Place {
        std::int64_t x = 0, y = 0;
    };
    /// Where the segment is, and the middle of its pixels; nothing: nowhere.
    struct Seen {
        Box box;
        Place middle;
    };
    std::optional<Seen> find(const std::vector<std::uint16_t>& labels) const;
    std::int64_t overlap(const std::vector<std::uint16_t>& labels, const Box& box, const Place& shift) const;
    void shift_known(const Place& shift);
    void remember(const std::vector<std::uint16_t>& labels, const Seen& seen);

    const std::uint16_t label_, part_;
    const int width_, height_;
    std::vector<std::uint16_t> known_;  // which part a place belongs to, since it was seen; 0: not known
    Box known_box_;                     // outside of it nothing is known
    Place middle_;                      // of the segment in the last frame that had it
    std::vector<std::uint16_t> near_;   // of a box
    NearestLabel nearest_;
};

/// A material that a segment may be of that looks so, in a picture of so many pixels, by a few rules of
/// thumb. Colour tells little: a painted wall is as white as paper. Whole numbers, the same on every machine.
const PaletteMaterial& guess_material(const Segment& segment, std::int32_t of_pixels);

/// Of a segment as it was seen first, in a picture of so many pixels: as it is named, otherwise as all others
/// are; null: as its look suggests.
PaintedSegments::Paint paint_of(const Segment& segment, std::int32_t of_pixels, const LabelNames& named,
                                const PaletteMaterial* otherwise);

/// Ranges that hold the whole palette, the scene's defaults and these: the same for all choices of
/// materials, and one for both frictions, so that rounding never puts the dynamic one above the static one.
HapticRanges ranges_of_palette(const Scene& scene, const std::vector<Feel>& others);

/// The haptic pixel nearest to that.
std::array<std::uint8_t, 3> haptic_code(const HapticProperties& properties, const HapticRanges& ranges);

/// [X, Y] or [X, Y, FRAME]. Throws checked_json::Refusal, as read_cut does.
PixelOfFrame read_place(const checked_json::Node& node);
nlohmann::ordered_json write_place(const PixelOfFrame& place);

/// {"frame": 0, "stroke": [[X, Y], [X, Y]]}
SegmentCut read_cut(const checked_json::Node& node);
nlohmann::ordered_json write_cut(const SegmentCut& cut);

}  // namespace touchable
