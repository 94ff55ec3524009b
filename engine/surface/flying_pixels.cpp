#include "engine/surface/flying_pixels.hpp"

#include <algorithm>
#include <cstring>

namespace touchable {
namespace {

/// Codes from below and above differ by more than `gate` from one of their eight neighbours. Of inner pixels.
void suspect(const std::uint16_t* above, const std::uint16_t* here, const std::uint16_t* below, int width,
             int gate, std::uint8_t* suspicious) {
    const auto limit = static_cast<std::uint16_t>(gate);
    for (int x = 1; x < width - 1; ++x) {
        std::uint16_t least = here[x], greatest = here[x];
        for (const std::uint16_t* row : {above, here, below})
            for (int dx = -1; dx <= 1; ++dx) {
                least = std::min(least, row[x + dx]);
                greatest = std::max(greatest, row[x + dx]);
            }
        suspicious[x] = static_cast<std::uint16_t>(greatest - here[x]) > limit ||
                        static_cast<std::uint16_t>(here[x] - least) > limit;
    }
}

}  // namespace

// A gate grows towards one end of the codes or the other.
FlyingPixelLander::FlyingPixelLander(std::unique_ptr<LineSource> lines, const FlyingPixels& filter,
                                     const DepthCoding& coding)
    : before_landing_(std::move(lines)),
      filter_(filter),
      least_gate_(std::min(filter.gate_at(coding.valid_min), filter.gate_at(coding.valid_max))) {}

void FlyingPixelLander::begin(const RawFrame& raw, RowBands& bands) {
    before_landing_.make_all(raw, bands, before_);
    picture_.width = before_.width;
    picture_.height = before_.height;
    picture_.codes.resize(before_.codes.size());
    picture_.validity.resize(before_.validity.size());
    std::copy(before_.validity.begin(), before_.validity.end(), picture_.validity.begin());
    suspicious_.resize(static_cast<std::size_t>(bands.threads()));
    // The first and the last row and column have lines along themselves only.
    for (auto& row : suspicious_) row.assign(static_cast<std::size_t>(before_.width), 1);
    bands.for_each_band(before_.height, TileGrid::cells, [&](const RowBand& band) { land_rows(band); });
}

void FlyingPixelLander::land_rows(const RowBand& band) {
    std::vector<std::uint8_t>& suspicious = suspicious_[static_cast<std::size_t>(band.thread)];
    const auto row = [&](int y) { return before_.codes.data() + before_.index(0, y); };
    for (int y = band.first; y < band.last; ++y) {
        std::memcpy(picture_.codes.data() + picture_.index(0, y), row(y),
                    static_cast<std::size_t>(before_.width) * sizeof(std::uint16_t));
        if (y == 0 || y == before_.height - 1)
            std::fill(suspicious.begin(), suspicious.end(), std::uint8_t{1});
        else
            suspect(row(y - 1), row(y), row(y + 1), before_.width, least_gate_, suspicious.data());
        land_row(y, suspicious.data());
    }
}

void FlyingPixelLander::land_row(int y, const std::uint8_t* suspicious) {
    for (int x = 0; x < before_.width; ++x) {
        if (suspicious[x] == 0 || !before_.is_valid(x, y)) continue;
        const auto at = [&](int dx, int dy) {
            const int tx = x + dx, ty = y + dy;
            if (tx < 0 || tx >= before_.width || ty < 0 || ty >= before_.height) return -1;
            return before_.is_valid(tx, ty) ? int{before_.codes[before_.index(tx, ty)]} : -1;
        };
        const std::uint16_t code = before_.codes[before_.index(x, y)];
        picture_.codes[picture_.index(x, y)] = landed(at, filter_.gate_at(code));
    }
}

}  // namespace touchable
