#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/frame/surface_frame.hpp"
#include "engine/surface/row_bands.hpp"
#include "engine/surface/temporal_rows.hpp"

namespace touchable {

/// Averages noise from frame to frame (docs/conventions.md). Remembers one frame: it must see all of them, in
/// order.
class TemporalSmoother {
public:
    explicit TemporalSmoother(VectorUnit unit) : unit_(unit) {}

    /// To be called first, of each frame. Nothing is remembered of what is not the frame before this one, by
    /// its number. No allocation once it has seen the size.
    void begin(const SurfaceFrame& frame, std::int64_t number);
    /// The rows of a band, each once: codes become finer and smooth, and more of them valid.
    void smooth(const RowBand& band, const TemporalFilter& filter, SurfaceFrame& frame);

private:
    VectorUnit unit_;
    std::size_t words_ = 0;  // of a row
    std::vector<std::uint16_t> codes_;
    std::vector<std::uint32_t> known_, held_low_, held_high_;
    std::optional<std::int64_t> last_;
};

}  // namespace touchable
