#include "engine/surface/temporal_filter.hpp"

#include <algorithm>

#include "engine/surface/validity_strip.hpp"

namespace touchable {

void TemporalSmoother::begin(const RawFrame& raw, RowBands& bands) {
    before_->begin(raw, bands);
    words_ = static_cast<std::size_t>((raw.depth.width + strip_pixels - 1) / strip_pixels);
    const std::size_t words = words_ * static_cast<std::size_t>(raw.depth.height);
    codes_.resize(words * strip_pixels);
    for (auto* bits : {&known_, &held_low_, &held_high_}) {
        bits->resize(words);
        if (!last_ || !last_->is_before(raw)) std::fill(bits->begin(), bits->end(), 0U);
    }
    last_.emplace(raw);
}

void TemporalSmoother::make(const RowBand& band, SurfaceFrame& out) {
    before_->make(band, out);
    for (int y = band.first; y < band.last; ++y) {
        const std::size_t word = words_ * static_cast<std::size_t>(y);
        smooth_row(unit_, filter_, out.width, out.codes.data() + out.index(0, y), out.validity_row(y),
                   {codes_.data() + word * strip_pixels, known_.data() + word, held_low_.data() + word,
                    held_high_.data() + word});
    }
}

}  // namespace touchable
