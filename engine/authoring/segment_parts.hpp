// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shared by the sources of segments and of their materials: cuts, a segment's touch, places in JSON.

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

/// Gives pixels without a label (0) the nearest label, by a distance transform.
class NearestLabel {
public:
    /// `labels`: width x height, row by row. If no pixel has a label, all stay as they are.
    void fill(std::vector<std::uint16_t>& labels, int width, int height);

private:
    std::vector<std::int32_t> distances_;  // to the label, thirds of a pixel
};

/// The label on which most of the stroke lies, in a picture of labels with that width; 0: none. The stroke
/// must lie in the picture.
std::uint16_t label_under(const SegmentCut& cut, const std::vector<std::uint16_t>& labels, int width);

/// Parts one segment along a stroke, and follows both parts from frame to frame.
class CutFollower {
public:
    /// For pictures of width x height labels; `part` is the label of the smaller part.
    CutFollower(std::uint16_t label, std::uint16_t part, int width, int height)
        : label_(label),
          part_(part),
          width_(width),
          height_(height),
          known_(pixel_count(width, height)),
          known_box_{width, height, 0, 0} {}

    /// Cuts the stroke's frame. Returns false, and changes nothing, if the stroke does not part the segment.
    bool begin(const SegmentCut& cut, std::vector<std::uint16_t>& labels);
    /// Cuts a frame beside the last one that was given, either way through time. Each pixel of the segment
    /// belongs to the part in which it was last seen, once the segment's motion since then is applied; a
    /// pixel that was never seen belongs to the nearest part. A frame without the segment stays as it is.
    void next(std::vector<std::uint16_t>& labels);

private:
    struct Box {
        int left, top, right, bottom;  // right and bottom beyond the last pixel
        void hold(const Box& other);
    };
    struct Place {
        std::int64_t x = 0, y = 0;
    };
    /// Where the segment is, and the middle of its pixels.
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
    std::vector<std::uint16_t> known_;  // the part of each place when last seen; 0: not known
    Box known_box_;                     // outside of it nothing is known
    Place middle_;                      // of the segment in the last frame that had it
    std::vector<std::uint16_t> near_;   // of a box in `known_`
    NearestLabel nearest_;
};

/// Guesses a segment's material from its look, in a picture of so many pixels, by a few rules of thumb.
/// Colour tells little: a painted wall is as white as paper. Integers, the same on every machine.
const PaletteMaterial& guess_material(const Segment& segment, std::int32_t of_pixels);

/// The touch of a segment as first seen, in a picture of so many pixels: of its name, otherwise of
/// `otherwise`; if that is null, as guessed from its look.
PaintedSegments::Paint paint_of(const Segment& segment, std::int32_t of_pixels, const LabelNames& named,
                                const PaletteMaterial* otherwise);

/// Ranges that hold the whole palette, the scene's defaults and `others`: the same for all choices of
/// materials, and one for both frictions, so that rounding never puts the dynamic one above the static one.
HapticRanges ranges_of_palette(const Scene& scene, const std::vector<Feel>& others);

/// The haptic pixel nearest to these properties.
std::array<std::uint8_t, 3> haptic_code(const HapticProperties& properties, const HapticRanges& ranges);

/// [X, Y] or [X, Y, FRAME]. Throws checked_json::Refusal, as read_cut does.
PixelOfFrame read_place(const checked_json::Node& node);
nlohmann::ordered_json write_place(const PixelOfFrame& place);

/// {"frame": 0, "stroke": [[X, Y], [X, Y]]}
SegmentCut read_cut(const checked_json::Node& node);
nlohmann::ordered_json write_cut(const SegmentCut& cut);

}  // namespace touchable
