// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "engine/scene/filter_codes.hpp"
#include "engine/surface/code_rows.hpp"

namespace touchable {

/// An invalid pixel with at least this many valid 8-neighbours is filled with their lower median.
inline constexpr int neighbours_to_fill = 3;

/// Fills holes from their rims: each pass judges every pixel by the state before the pass, and neighbours
/// outside the picture do not exist.
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

/// The surface that a line away from a pixel meets.
struct RampEnd {
    int code = -1;  ///< negative: none
    int steps = 0;  ///< pixels from the pixel to there
};

/// The second pixel along a line, or the end of a ramp that only falls, or only rises, by more than the gate
/// with each step. Two neighbours that differ by less are a surface. `at(n)`: the code n pixels away,
/// negative if there is none; at(0) and at(1) exist.
template <class At>
RampEnd ramp_end(const At& at, int gate) {
    const auto differ = [gate](int a, int b) { return a > b ? a - b > gate : b - a > gate; };
    int before = at(0), here = at(1), next = at(2);
    bool is_ramp = differ(before, here);
    for (int n = 2; n < flying_reach; ++n) {
        const int beyond = next < 0 ? -1 : at(n + 1);
        if (beyond < 0) return {};
        const bool steps_on = differ(here, next);
        is_ramp = is_ramp && steps_on && (next > here) == (here > before);
        if (n > 2 && !is_ramp) return {};
        if (!differ(next, beyond)) return {next, steps_on ? n : 1};
        before = here;
        here = next;
        next = beyond;
    }
    return {};
}

/// Calls `hangs(low, high)` for each line along which a pixel hangs between two surfaces, with their codes.
/// `at(dx, dy)`: a neighbour's code, negative if it is invalid or outside the picture; the pixel's own is
/// valid.
template <class At, class Hangs>
void for_each_hanging(const At& at, int gate, const Hangs& hangs) {
    const int code = at(0, 0);
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
        const int next_a = at(-dx, -dy), next_b = at(dx, dy);
        if (next_a < 0 || next_b < 0 || std::max(std::abs(code - next_a), std::abs(code - next_b)) <= gate)
            continue;
        const RampEnd a = ramp_end([&, x = dx, y = dy](int n) { return at(-n * x, -n * y); }, gate);
        if (a.code < 0) continue;
        const RampEnd b = ramp_end([&, x = dx, y = dy](int n) { return at(n * x, n * y); }, gate);
        if (b.code < 0 || a.steps + b.steps > widest_ramp) continue;
        const int low = std::min(a.code, b.code), high = std::max(a.code, b.code);
        if (code - low > 2 * gate && high - code > 2 * gate) hangs(low, high);
    }
}

/// The code of a pixel after it was pulled in; `at` as above. It is pulled along the line whose sides are
/// farthest apart: along the edge, other pixels of the same ramp look like a surface.
template <class At>
std::uint16_t landed(const At& at, int gate) {
    const int code = at(0, 0);
    int landed = code, widest = 0;
    for_each_hanging(at, gate, [&](int low, int high) {
        const int side = code - low <= high - code ? low : high;
        if (high - low < widest || (high - low == widest && side >= landed)) return;
        landed = side;
        widest = high - low;
    });
    return static_cast<std::uint16_t>(landed);
}

/// Each pixel is judged by the picture before the filter.
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
    std::vector<std::vector<std::uint32_t>> suspects_;  // bits of a row, per thread
};

}  // namespace touchable
