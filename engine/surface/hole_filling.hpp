#pragma once

#include <cstdint>
#include <vector>

#include "engine/surface/code_rows.hpp"

namespace touchable {

/// An invalid pixel with at least this many valid 8-neighbours is filled with their lower median.
inline constexpr int neighbours_to_fill = 3;

/// Fills holes from their rims: in each pass every pixel is judged by the state before the pass, and
/// neighbours outside the picture do not exist.
class HoleFiller final : public LineSource {
public:
    HoleFiller(std::unique_ptr<LineSource> lines, int passes)
        : before_filling_(std::move(lines)), passes_(passes) {}
    void begin(const RawFrame& raw, RowBands& bands) override;
    void load(int y, CodeLine& line) const override { line.copy(picture_, y); }

private:
    bool fill_once(RowBands& bands);
    bool fill_rows(const RowBand& band);

    UnfilteredBands before_filling_;
    const int passes_;
    SurfaceFrame picture_;
    std::vector<std::uint32_t> before_;  // validity before the pass
};

}  // namespace touchable
