#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A segment as its pixels have it so far in this frame.
struct Segment {
    std::uint16_t label;  ///< 1 and up, the same through the whole clip; never used again for something else
    std::int32_t pixels;
    std::array<std::uint8_t, 3> colour;  ///< mean, RGB; 0 where the clip has none
    std::int32_t x, y;                   ///< a pixel of it, near its middle and inside of it
    std::int32_t contrast;  ///< mean absolute deviation of brightness from its blur, 1/16 levels: how
                            ///< textured it is; 0 without colour
    bool operator==(const Segment&) const = default;
};

struct Segmentation {
    int width = 0, height = 0;
    std::vector<std::uint16_t> labels;  ///< row by row; 0: no surface (a hole), no segment
    std::vector<Segment> segments;      ///< by label, ascending; only those in this frame
};

/// Follows segments through a clip. Feed it frames in order.
class Segmenter {
public:
    /// `threads`: 0: as many as pay; the result is the same with any number.
    explicit Segmenter(const Scene& scene, int threads = 0);
    ~Segmenter();
    Segmenter(Segmenter&&) noexcept;
    Segmenter& operator=(Segmenter&&) noexcept;

    /// The frame's segments, valid until the next call. `follows`: it is the one right after the last (else
    /// segments are matched by place and colour as far as they can be). Whole numbers throughout: the same
    /// frames have the same labels on every machine.
    const Segmentation& next(const RawFrame& frame, bool follows);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace touchable
