#pragma once

#include <cstdint>
#include <vector>

#include "engine/frame/surface_frame.hpp"
#include "engine/surface/row_bands.hpp"

namespace touchable {

/// An invalid pixel with at least this many valid 8-neighbours is filled with their lower median.
inline constexpr int neighbours_to_fill = 3;

/// Fills holes from their rims: in each pass every pixel is judged by the state before the pass, and
/// neighbours outside the picture do not exist.
class HoleFiller {
public:
    /// Changes codes and validity of `frame` in place. No allocation once it has seen the size.
    void fill(int passes, RowBands& bands, SurfaceFrame& frame);

private:
    bool fill_once(RowBands& bands, SurfaceFrame& frame);
    bool fill_rows(const RowBand& band, SurfaceFrame& frame) const;

    std::vector<std::uint32_t> before_;  // validity before the pass
};

}  // namespace touchable
