#include "engine/surface/median.hpp"

#include <algorithm>
#include <cassert>

#include "engine/surface/median_row.hpp"

namespace touchable {
namespace {

template <int Side>
void filter_band(const RowBand& band, const LineSource& source, std::vector<CodeLine>& ring, VectorUnit unit,
                 SurfaceFrame& out) {
    constexpr int radius = Side / 2;
    const int bottom = out.height - 1;
    int loaded = std::max(band.first - radius, 0);
    for (int y = band.first; y < band.last; ++y) {
        for (; loaded <= std::min(y + radius, bottom); ++loaded)
            source.load(loaded, ring[static_cast<std::size_t>(loaded % Side)]);
        const CodeLine* window[Side];
        for (int k = 0; k < Side; ++k)
            window[k] = &ring[static_cast<std::size_t>(std::clamp(y + k - radius, 0, bottom) % Side)];
        std::uint16_t* codes = out.codes.data() + out.index(0, y);
        if constexpr (Side == 1)
            window[0]->write_codes(codes);
        else
            median_of_row(unit, window, codes, out.width);
        window[radius]->write_validity(out.validity_row(y));
    }
}

}  // namespace

void MedianFilter::begin(int side, int width, int threads) {
    assert(side == 1 || side == 3 || side == 5);
    side_ = side;
    lines_.resize(static_cast<std::size_t>(threads));
    for (std::vector<CodeLine>& ring : lines_) {
        if (ring.size() < static_cast<std::size_t>(side)) ring.resize(static_cast<std::size_t>(side));
        for (CodeLine& line : ring) line.resize(width, side / 2);
    }
}

void MedianFilter::filter(const RowBand& band, const LineSource& source, SurfaceFrame& out) {
    std::vector<CodeLine>& ring = lines_[static_cast<std::size_t>(band.thread)];
    if (side_ == 1) filter_band<1>(band, source, ring, unit_, out);
    if (side_ == 3) filter_band<3>(band, source, ring, unit_, out);
    if (side_ == 5) filter_band<5>(band, source, ring, unit_, out);
}

}  // namespace touchable
