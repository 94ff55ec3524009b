#include "engine/surface/median.hpp"

#include <algorithm>

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
        median_of_row(unit, window, out.codes.data() + out.index(0, y), out.width);
        window[radius]->write_validity(out.validity_row(y));
    }
}

}  // namespace

void MedianFilter::begin(const RawFrame& raw, RowBands& bands) {
    lines_->begin(raw, bands);
    rings_.resize(static_cast<std::size_t>(bands.threads()));
    for (std::vector<CodeLine>& ring : rings_) {
        ring.resize(static_cast<std::size_t>(side_));
        for (CodeLine& line : ring) line.resize(raw.depth.width, side_ / 2);
    }
}

void MedianFilter::make(const RowBand& band, SurfaceFrame& out) {
    const auto filter = side_ == 3 ? filter_band<3> : filter_band<5>;
    filter(band, *lines_, rings_[static_cast<std::size_t>(band.thread)], unit_, out);
}

}  // namespace touchable
