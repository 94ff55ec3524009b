#pragma once

#include <cstdint>
#include <vector>

#include "engine/surface/code_rows.hpp"

namespace touchable {

/// The lower median, in code order, of the valid codes in a window of 3x3 or 5x5 pixels; positions outside
/// the picture replicate the border pixel, and an invalid centre stays invalid.
class MedianFilter final : public BandSource {
public:
    /// `side`: 3 or 5.
    MedianFilter(std::unique_ptr<LineSource> lines, int side, VectorUnit unit)
        : lines_(std::move(lines)), side_(side), unit_(unit) {}
    void begin(const RawFrame& raw, RowBands& bands) override;
    void make(const RowBand& band, SurfaceFrame& out) override;

private:
    const std::unique_ptr<LineSource> lines_;
    const int side_;
    const VectorUnit unit_;
    std::vector<std::vector<CodeLine>> rings_;  // of each thread: row y in [y % side]
};

}  // namespace touchable
