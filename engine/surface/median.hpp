#pragma once

#include <cstdint>
#include <vector>

#include "engine/surface/line_source.hpp"
#include "engine/surface/row_bands.hpp"
#include "engine/surface/vector_unit.hpp"

namespace touchable {

/// The lower median, in code order, of the valid codes in a window of 3x3 or 5x5 pixels; positions outside
/// the picture replicate the border pixel, and an invalid centre stays invalid. Side 1 is no filter.
class MedianFilter {
public:
    explicit MedianFilter(VectorUnit unit) : unit_(unit) {}

    /// To be called before the bands of a frame. `side`: 1, 3 or 5; `threads`: those that will call. No
    /// allocation once it has seen the size.
    void begin(int side, int width, int threads);
    /// Codes and validity of a band of `out`, which has the size that `source` has.
    void filter(const RowBand& band, const LineSource& source, SurfaceFrame& out);

private:
    VectorUnit unit_;
    int side_ = 1;
    std::vector<std::vector<CodeLine>> lines_;  // of each thread a ring: row y in [y % side]
};

}  // namespace touchable
