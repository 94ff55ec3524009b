// SPDX-License-Identifier: Apache-2.0
// Noise averaged from frame to frame, vectorised.
#include <optional>
#include <vector>

#include "engine/base/vectors.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/surface/code_rows.hpp"

namespace touchable {
namespace {

/// Without comparisons, see code_rows.cpp: one of `above` and `below` is 0, and so is the part kept of it.
template <class Lanes>
[[gnu::always_inline]] inline Lanes smoothed(const Lanes& code, const Lanes& before, const Lanes& gate) {
    const Lanes least = lesser(code, before), above = code - least, below = before - least;
    const Lanes distance = above | below, narrow = lesser(distance, gate);
    const Lanes tent = narrow + narrow - lesser<Lanes>(distance, gate + gate);
    const Lanes kept = tent - ((tent + 3) >> 2);
    return code - lesser(kept, above) + lesser(kept, below);
}

/// Bits of a word's pixels: which have a code in this frame, which had one in the frame before, which keep
/// that one.
struct WordBits {
    std::uint32_t now, known, held;
};

/// All ones in lanes whose bit is set, from the lowest bit on. In vectors, because masks that are written
/// narrow and read wide wait for memory.
template <class Lanes>
[[gnu::always_inline]] inline Lanes lanes_of_bits(std::uint32_t bits) {
    static constexpr std::uint16_t low[strip_pixels] = {
        1, 2, 4, 8, 0x10, 0x20, 0x40, 0x80, 0x0100, 0x0200, 0x0400, 0x0800, 0x1000, 0x2000, 0x4000, 0x8000};
    static constexpr std::uint16_t high[strip_pixels] = {
        0, 0, 0, 0, 0,    0,    0,    0,    0,      0,      0,      0,      0,      0,      0,      0,
        1, 2, 4, 8, 0x10, 0x20, 0x40, 0x80, 0x0100, 0x0200, 0x0400, 0x0800, 0x1000, 0x2000, 0x4000, 0x8000};
    Lanes set = load_lanes<Lanes>(low) & (Lanes{} + static_cast<std::uint16_t>(bits));
    if constexpr (lane_count < Lanes >> 16)
        set |= load_lanes<Lanes>(high) & (Lanes{} + static_cast<std::uint16_t>(bits >> 16));
    return Lanes{} - lesser<Lanes>(set, Lanes{} + std::uint16_t{1});
}

/// The remembered state of a row: finer codes, in whole words of 32 of them, and bits for each, in words:
/// whether it is known, and for how many frames it has only been held (low and high bit).
struct TemporalRow {
    std::uint16_t* codes;
    std::uint32_t *known, *held_low, *held_high;
};

/// Smooths one row, `width` codes and their validity. The remembered row becomes the same.
struct RowSmoothing {
    const TemporalFilter& filter;
    int width;
    std::uint16_t* codes;
    std::uint32_t* validity;
    const TemporalRow& remembered;

    template <class Kind>
    [[gnu::always_inline]] void operator()(Kind) const {
        using Lanes = typename Kind::type;
        const int whole = width / strip_pixels;
        for (int word = 0; word < whole; ++word) smooth_word<Lanes>(word, codes + word * strip_pixels);
        if (const int rest = width % strip_pixels; rest > 0) {
            std::uint16_t strip[strip_pixels] = {};
            std::uint16_t* last = codes + whole * strip_pixels;
            std::copy_n(last, rest, strip);
            smooth_word<Lanes>(whole, strip);
            std::copy_n(strip, rest, last);
        }
    }

    template <class Lanes>
    [[gnu::always_inline]] void smooth_word(int word, std::uint16_t* at) const {
        std::uint16_t* before = remembered.codes + word * strip_pixels;
        const std::uint32_t now = validity[word], known = remembered.known[word];
        if ((now & known) == ~std::uint32_t{0}) {
            smooth_all<Lanes>(at, before);
            remembered.held_low[word] = remembered.held_high[word] = 0;
            return;
        }
        const std::uint32_t held = ~now & known & ~(remembered.held_low[word] & remembered.held_high[word]);
        smooth_some<Lanes>(at, before, {now, known, held});
        validity[word] = remembered.known[word] = now | held;
        count_held(word, held);
    }

    /// Counts held frames in two bits.
    [[gnu::always_inline]] void count_held(int word, std::uint32_t held) const {
        static_assert(temporal_hold_frames == 3);
        std::uint32_t &low = remembered.held_low[word], &high = remembered.held_high[word];
        high = held & (high ^ low);
        low = held & ~low;
    }

    template <class Lanes>
    [[gnu::always_inline]] void smooth_all(std::uint16_t* at, std::uint16_t* before) const {
        for (int k = 0; k < strip_pixels; k += lane_count<Lanes>) {
            const Lanes code = finer_codes<Lanes>(at + k);
            store<Lanes>(smoothed(code, load_lanes<Lanes>(before + k), curve_at(filter.gate, code)), at + k,
                         before + k);
        }
    }
    /// The difference of a pixel that is new, held or invalid is 0.
    template <class Lanes>
    [[gnu::always_inline]] void smooth_some(std::uint16_t* at, std::uint16_t* before,
                                            const WordBits& bits) const {
        for (int k = 0; k < strip_pixels; k += lane_count<Lanes>) {
            const Lanes now = lanes_of_bits<Lanes>(bits.now >> k),
                        held = lanes_of_bits<Lanes>(bits.held >> k);
            const Lanes both = now & lanes_of_bits<Lanes>(bits.known >> k);
            const Lanes old = load_lanes<Lanes>(before + k);
            const Lanes code = (finer_codes<Lanes>(at + k) & now) | (old & held);
            store<Lanes>(smoothed<Lanes>(code, (old & both) | (code & ~both), curve_at(filter.gate, code)),
                         at + k, before + k);
        }
    }

    template <class Lanes>
    [[gnu::always_inline]] Lanes finer_codes(const std::uint16_t* at) const {
        const WorkingCodes& working = filter.working;
        if (!working.table) return load_lanes<Lanes>(at) * static_cast<std::uint16_t>(working.factor);
        std::uint16_t found[lane_count<Lanes>];
        working.row(at, lane_count<Lanes>, found);
        return load_lanes<Lanes>(found);
    }
    template <class Lanes>
    [[gnu::always_inline]] void store(const Lanes& result, std::uint16_t* at, std::uint16_t* before) const {
        store_lanes(result, at);
        store_lanes(result, before);
    }
};

/// Averages noise from frame to frame (docs/conventions.md). Depends on the frame before: it has to get all
/// of them, in order.
class TemporalSmoother final : public BandSource {
public:
    TemporalSmoother(std::unique_ptr<BandSource> before, const TemporalFilter& filter, VectorUnit unit)
        : before_(std::move(before)), filter_(filter), unit_(unit) {}

    /// Forgets the remembered frame, unless it is an earlier one of the same epoch.
    void begin(const RawFrame& raw, RowBands& bands) override {
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

    /// Makes codes as many times finer and smooth, 0 if invalid, and more of them valid.
    void make(const RowBand& band, SurfaceFrame& out) override {
        before_->make(band, out);
        for (int y = band.first; y < band.last; ++y) {
            const std::size_t word = words_ * static_cast<std::size_t>(y);
            const TemporalRow remembered{codes_.data() + word * strip_pixels, known_.data() + word,
                                         held_low_.data() + word, held_high_.data() + word};
            run_vectors(unit_, RowSmoothing{filter_, out.width, out.codes.data() + out.index(0, y),
                                            out.validity_row(y), remembered});
        }
    }

private:
    const std::unique_ptr<BandSource> before_;
    const TemporalFilter filter_;
    const VectorUnit unit_;
    std::size_t words_ = 0;  // per row
    std::vector<std::uint16_t> codes_;
    std::vector<std::uint32_t> known_, held_low_, held_high_;
    std::optional<RawFrame::Place> last_;
};

}  // namespace

std::unique_ptr<BandSource> make_temporal_smoother(std::unique_ptr<BandSource> before,
                                                   const TemporalFilter& filter, VectorUnit unit) {
    return std::make_unique<TemporalSmoother>(std::move(before), filter, unit);
}

}  // namespace touchable
