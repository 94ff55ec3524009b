#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "engine/scene/flying_pixels.hpp"
#include "engine/surface/code_rows.hpp"

namespace touchable {

/// The code of a pixel once it does not fly. `at(dx, dy)`: the code of a neighbour, negative where it is
/// invalid or outside the picture; that of the pixel itself is valid.
template <class At>
std::uint16_t landed(const At& at, int gate) {
    const int code = at(0, 0);
    int landed = code, least = 65536;
    const auto differ = [&](int a, int b) { return a > b ? a - b > gate : b - a > gate; };
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
        const int next_a = at(-dx, -dy), next_b = at(dx, dy);
        if (next_a < 0 || next_b < 0 || (!differ(code, next_a) && !differ(code, next_b))) continue;
        const int a = at(-2 * dx, -2 * dy), b = at(2 * dx, 2 * dy);
        if (a < 0 || b < 0) continue;
        const int low = std::min(a, b), high = std::max(a, b);
        if (code - low <= 2 * gate || high - code <= 2 * gate) continue;
        const int beyond_a = at(-3 * dx, -3 * dy), beyond_b = at(3 * dx, 3 * dy);
        if (beyond_a < 0 || beyond_b < 0 || differ(a, beyond_a) || differ(b, beyond_b)) continue;
        for (const auto& [side, distance] : {std::pair{low, code - low}, {high, high - code}})
            if (distance < least || (distance == least && side < landed)) {
                landed = side;
                least = distance;
            }
    }
    return static_cast<std::uint16_t>(landed);
}

/// Each pixel is judged by what the picture was before.
class FlyingPixelFilter final : public LineSource {
public:
    FlyingPixelFilter(std::unique_ptr<LineSource> lines, const FlyingPixels& filter,
                      const DepthCoding& coding, VectorUnit unit);
    void begin(const RawFrame& raw, RowBands& bands) override;
    void load(int y, CodeLine& line) const override { line.copy(picture_, y); }

private:
    void land_rows(const RowBand& band);
    void land(int x, int y);

    UnfilteredBands before_landing_;
    const FlyingPixels filter_;
    const bool zero_is_code_;
    const VectorUnit unit_;
    SurfaceFrame before_, picture_;
    std::vector<std::vector<std::uint32_t>> suspects_;  // bits of a row, of each thread
};

}  // namespace touchable
