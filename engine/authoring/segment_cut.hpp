#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/authoring/nearest_label.hpp"

namespace touchable {

/// A line drawn over a frame, pixel by pixel of the depth plane: where it crosses a segment, the segment is
/// two from then on, in all frames. One that comes back to where it began parts what is inside of it.
struct SegmentCut {
    struct Point {
        int x = 0, y = 0;
        bool operator==(const Point&) const = default;
    };
    std::int64_t frame = 0;
    std::vector<Point> stroke{};  ///< 2 and more
    bool operator==(const SegmentCut&) const = default;
};

/// The label on which most of the stroke lies, of a picture of labels with that width; 0: none. The stroke
/// lies in the picture.
std::uint16_t label_under(const SegmentCut& cut, const std::vector<std::uint16_t>& labels, int width);

/// Parts one segment along a stroke, and follows both parts from frame to frame.
class CutFollower {
public:
    /// Of a picture of width x height labels; `part` is the label of the smaller part.
    CutFollower(std::uint16_t label, std::uint16_t part, int width, int height);

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
    std::vector<std::uint16_t> known_;  // which part a place belongs to, since it was seen; 0: nobody knows
    Box known_box_;                     // outside of it nothing is known
    Place middle_;                      // of the segment in the last frame that had it
    std::vector<std::uint16_t> near_;   // of a box
    NearestLabel nearest_;
};

}  // namespace touchable
