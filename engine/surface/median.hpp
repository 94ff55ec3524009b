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

    /// `side`: 1, 3 or 5. `source` has the size that `out` has; writes its codes and validity. No allocation
    /// once it has seen the size.
    void apply(int side, const LineSource& source, RowBands& bands, SurfaceFrame& out);

private:
    VectorUnit unit_;
    std::vector<std::vector<CodeLine>> lines_;  // of each thread a ring: row y in [y % side]
};

}  // namespace touchable
