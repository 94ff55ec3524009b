#include "engine/surface/code_filters.hpp"

#include <algorithm>
#include <cassert>

namespace touchable {

CodeFilters::CodeFilters(const Scene& scene, VectorUnit unit)
    : coding_(scene.depth),
      settings_(scene.filter),
      unit_(unit),
      temporal_(temporal_filter(scene)),
      terraces_(terrace_filter(scene)),
      median_(unit),
      smoother_(unit),
      remover_(unit) {
    assert(settings_.median == 0 || settings_.median == 3 || settings_.median == 5);
}

std::optional<int> CodeFilters::reach() const {
    if (temporal_) return std::nullopt;
    return settings_.fill_holes + settings_.median / 2 + (terraces_ ? terrace_reach : 0);
}

/// A side of 1 decodes and no more.
template <class Then>
void CodeFilters::take_median(int side, const LineSource& source, RowBands& bands, SurfaceFrame& out,
                              Then&& then) {
    median_.begin(side, out.width, bands.threads());
    bands.for_each_band(out.height, TileGrid::cells, [&](const RowBand& band) {
        median_.filter(band, source, out);
        then(band);
    });
}

void CodeFilters::filter(const RawFrame& raw, RowBands& bands, SurfaceFrame& out,
                         const BandFinished& finished) {
    take_size(raw.depth.width, raw.depth.height, out);
    const StoredLines stored(raw.depth, coding_, unit_);
    if (settings_.fill_holes == 0) return finish(stored, raw.number, bands, out, finished);
    take_size(out.width, out.height, filled_);
    take_median(1, stored, bands, filled_, [](const RowBand&) {});
    holes_.fill(settings_.fill_holes, bands, filled_);
    finish(FrameLines(filled_), raw.number, bands, out, finished);
}

/// From the median on.
void CodeFilters::finish(const LineSource& source, std::int64_t frame, RowBands& bands, SurfaceFrame& out,
                         const BandFinished& finished) {
    SurfaceFrame& smooth = terraces_ ? with_terraces_ : out;
    take_size(out.width, out.height, smooth);
    if (temporal_) {
        smoother_.begin(smooth, frame);
        smooth.coding = temporal_->coding;
    }
    take_median(std::max(settings_.median, 1), source, bands, smooth, [&](const RowBand& band) {
        if (temporal_) smoother_.smooth(band, *temporal_, smooth);
        if (!terraces_ && finished) finished(band);
    });
    if (terraces_) remove_terraces(bands, out, finished);
}

void CodeFilters::take_size(int width, int height, SurfaceFrame& frame) const {
    frame.coding = coding_;
    frame.width = width;
    frame.height = height;
    frame.codes.resize(frame.index(0, frame.height));
    frame.validity.resize(static_cast<std::size_t>(frame.validity_words_per_row()) *
                          static_cast<std::size_t>(frame.height));
}

void CodeFilters::remove_terraces(RowBands& bands, SurfaceFrame& out, const BandFinished& finished) {
    out.coding = terraces_->coding;
    remover_.begin(out.width, bands.threads());
    bands.for_each_band(out.height, TileGrid::cells, [&](const RowBand& band) {
        remover_.remove(band, *terraces_, with_terraces_, out);
        if (finished) finished(band);
    });
}

}  // namespace touchable
