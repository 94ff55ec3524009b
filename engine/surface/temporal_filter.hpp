#pragma once

#include <optional>
#include <vector>

#include "engine/base/vectors.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/surface/code_rows.hpp"

namespace touchable {

/// The remembered state of a row: finer codes, in whole words of 32 of them, and bits for each, in words:
/// whether it is known, and for how many frames it has only been held (low and high bit).
struct TemporalRow {
    std::uint16_t* codes;
    std::uint32_t *known, *held_low, *held_high;
};

/// Averages noise from frame to frame (docs/conventions.md). Depends on the frame before: it has to get all
/// of them, in order.
class TemporalSmoother final : public BandSource {
public:
    TemporalSmoother(std::unique_ptr<BandSource> before, const TemporalFilter& filter, VectorUnit unit)
        : before_(std::move(before)), filter_(filter), unit_(unit) {}
    /// Forgets the remembered frame, unless it is an earlier one of the same epoch.
    void begin(const RawFrame& raw, RowBands& bands) override;
    /// Makes codes finer and smooth, and more of them valid.
    void make(const RowBand& band, SurfaceFrame& out) override;

private:
    const std::unique_ptr<BandSource> before_;
    const TemporalFilter filter_;
    const VectorUnit unit_;
    std::size_t words_ = 0;  // per row
    std::vector<std::uint16_t> codes_;
    std::vector<std::uint32_t> known_, held_low_, held_high_;
    std::optional<RawFrame::Place> last_;
};

}  // namespace touchable
