#pragma once

#include <cstdint>
#include <vector>

#include "engine/frame/surface_frame.hpp"

namespace touchable {

/// The lower median, in code order, of the valid codes in a window of 3x3 or 5x5 pixels; positions outside
/// the picture replicate the border pixel, and an invalid centre stays invalid.
class MedianFilter {
public:
    /// `side`: 3 or 5. Changes the codes of `frame` in place; validity stays. No allocation once it has seen
    /// the size.
    void apply(int side, SurfaceFrame& frame);

private:
    /// One row before the filter. Codes are shifted to start at -32768, because signed 16-bit minima are what
    /// CPUs have; row and masks go on to both sides by the window's radius, so that windows need no clamping.
    struct Line {
        std::vector<std::int16_t> values;
        std::vector<std::uint16_t> invalid;  // masks
        std::vector<std::uint32_t> holes;    // invalid pixels as bits, none outside the picture
    };
    template <int Side>
    void filter(SurfaceFrame& frame);
    template <int Side>
    void filter_row(const Line* const (&window)[Side], std::uint16_t* codes, int width) const;
    static void load(const SurfaceFrame& frame, int y, Line& line);

    std::vector<Line> lines_;  // a ring: row y in lines_[y % side]
};

}  // namespace touchable
