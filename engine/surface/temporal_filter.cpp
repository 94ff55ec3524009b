#include "engine/surface/temporal_filter.hpp"

#include <algorithm>

#include "engine/surface/validity_strip.hpp"

namespace touchable {

void TemporalSmoother::begin(const SurfaceFrame& frame, std::int64_t number) {
    words_ = static_cast<std::size_t>(frame.validity_words_per_row());
    const std::size_t words = words_ * static_cast<std::size_t>(frame.height);
    codes_.resize(words * strip_pixels);
    for (auto* bits : {&known_, &held_low_, &held_high_}) {
        bits->resize(words);
        if (!last_ || *last_ + 1 != number) std::fill(bits->begin(), bits->end(), 0U);
    }
    last_ = number;
}

void TemporalSmoother::smooth(const RowBand& band, const TemporalFilter& filter, SurfaceFrame& frame) {
    for (int y = band.first; y < band.last; ++y) {
        const std::size_t word = words_ * static_cast<std::size_t>(y);
        smooth_row(unit_, filter, frame.width, frame.codes.data() + frame.index(0, y), frame.validity_row(y),
                   {codes_.data() + word * strip_pixels, known_.data() + word, held_low_.data() + word,
                    held_high_.data() + word});
    }
}

}  // namespace touchable
