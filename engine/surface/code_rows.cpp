#include "engine/surface/code_rows.hpp"

namespace touchable {

void BandSource::make_all(const RawFrame& raw, RowBands& bands, SurfaceFrame& out,
                          const BandFinished& finished) {
    begin(raw, bands);
    out.width = raw.depth.width;
    out.height = raw.depth.height;
    out.codes.resize(out.index(0, out.height));
    out.validity.resize(static_cast<std::size_t>(out.validity_words_per_row()) *
                        static_cast<std::size_t>(out.height));
    bands.for_each_band(out.height, TileGrid::cells, [&](const RowBand& band) {
        make(band, out);
        if (finished) finished(band);
    });
}

void UnfilteredBands::begin(const RawFrame& raw, RowBands& bands) {
    lines_->begin(raw, bands);
    line_.resize(static_cast<std::size_t>(bands.threads()));
    for (CodeLine& line : line_) line.resize(raw.depth.width, 0);
}

void UnfilteredBands::make(const RowBand& band, SurfaceFrame& out) {
    CodeLine& line = line_[static_cast<std::size_t>(band.thread)];
    for (int y = band.first; y < band.last; ++y) {
        lines_->load(y, line);
        line.write_codes(out.codes.data() + out.index(0, y));
        line.write_validity(out.validity_row(y));
    }
}

}  // namespace touchable
