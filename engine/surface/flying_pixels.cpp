// SPDX-License-Identifier: Apache-2.0
// Filling holes from their rims, and pulling pixels between two surfaces to one of them.
#include "engine/surface/flying_pixels.hpp"

#include "engine/surface/median.hpp"

namespace touchable {
namespace {

/// A picture's validity bits; rows and words outside it hold no valid pixel.
struct ValidityBits {
    const std::vector<std::uint32_t>& words;
    int words_per_row, height;

    std::uint32_t word(int w, int y) const {
        if (w < 0 || w >= words_per_row || y < 0 || y >= height) return 0;
        return words[pixel_place(w, y, words_per_row)];
    }
    bool valid(int x, int y) const { return x >= 0 && (word(x >> 5, y) >> (x & 31)) & 1U; }
    /// The pixels of a word that are valid, or have a valid pixel to their left or right.
    std::uint32_t spread(int w, int y) const {
        const std::uint32_t here = word(w, y);
        return here | here << 1 | here >> 1 | word(w - 1, y) >> 31 | word(w + 1, y) << 31;
    }
};

int valid_neighbours(const SurfaceFrame& frame, const ValidityBits& before, int x, int y,
                     std::uint16_t (&neighbours)[8]) {
    int count = 0;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if ((dx != 0 || dy != 0) && before.valid(x + dx, y + dy))
                neighbours[count++] = frame.codes[frame.index(x + dx, y + dy)];
    return count;
}

/// Marks the pixels of a row that may fly, as bits: those whose code differs from a valid neighbour's by more
/// than the strip's least gate, or, if the curve falls, by more than their own gate. Reads one code beyond
/// both ends. Whole strips from `first` to before `end`.
struct RowSuspicion {
    const std::uint16_t *above, *here, *below;
    const FlyingPixels& filter;
    const bool zero_is_code;
    const int first, end;
    std::uint32_t* suspects;

    template <class Kind>
    [[gnu::always_inline]] void operator()(Kind) const {
        for (int strip = first; strip < end; ++strip)
            suspects[strip] = suspects_of<typename Kind::type>(strip * strip_pixels);
    }

    /// For a curve that does not fall: its gate grows towards one end of the codes. 0, the value of invalid
    /// pixels, does not count unless it is a code.
    template <class Lanes>
    [[gnu::always_inline]] int least_gate(int x) const {
        Lanes least = Lanes{} + std::uint16_t{65535}, greatest{};
        for (int k = 0; k < strip_pixels; k += lane_count<Lanes>) {
            const Lanes codes = load_lanes<Lanes>(here + x + k);
            const Lanes nothing = reinterpret_cast<Lanes>(codes == 0);
            least = lesser<Lanes>(least, zero_is_code ? codes : codes | nothing);
            greatest = greater<Lanes>(greatest, codes);
        }
        std::uint16_t low[lane_count<Lanes>], high[lane_count<Lanes>];
        store_lanes(least, low);
        store_lanes(greatest, high);
        return std::min(filter.gate_at(*std::min_element(low, low + lane_count<Lanes>)),
                        filter.gate_at(*std::max_element(high, high + lane_count<Lanes>)));
    }

    template <class Lanes>
    [[gnu::always_inline]] std::uint32_t suspects_of(int x) const {
        const bool falls = filter.gate.falls;  // for log codes, whose gate may be least between the ends
        Lanes gate{};
        if (!falls) gate += static_cast<std::uint16_t>(least_gate<Lanes>(x));
        std::uint16_t masks[strip_pixels];
        Lanes any{};
        for (int k = 0; k < strip_pixels; k += lane_count<Lanes>) {
            const Lanes code = load_lanes<Lanes>(here + x + k);
            if (falls) gate = greater<Lanes>(curve_at(filter.gate, code), Lanes{} + std::uint16_t{1});
            Lanes least = code, greatest = code;
            for (const std::uint16_t* row : {above, here, below})
                for (int dx = -1; dx <= 1; ++dx) {
                    const Lanes other = load_lanes<Lanes>(row + x + k + dx);
                    const Lanes nothing = reinterpret_cast<Lanes>(other == 0);
                    least = lesser<Lanes>(least, zero_is_code ? other : other | nothing);
                    greatest = greater<Lanes>(greatest, other);
                }
            const Lanes beyond =
                reinterpret_cast<Lanes>(greater<Lanes>(greatest - code, code - least) > gate);
            any |= beyond;
            store_lanes(beyond, masks + k);
        }
        std::uint16_t lanes[lane_count<Lanes>];
        store_lanes(any, lanes);
        if (std::all_of(lanes, lanes + lane_count<Lanes>, [](std::uint16_t lane) { return lane == 0; }))
            return 0;
        std::uint32_t bits = 0;
        for (int k = 0; k < strip_pixels; ++k) bits |= std::uint32_t{masks[k] & 1U} << k;
        return bits;
    }
};

}  // namespace

void HoleFiller::begin(const RawFrame& raw, RowBands& bands) {
    before_filling_.make_all(raw, bands, picture_);
    for (int pass = 0; pass < passes_; ++pass)
        if (!fill_once(bands)) return;  // later passes would fill none, either
}

bool HoleFiller::fill_once(RowBands& bands) {
    before_.assign(picture_.validity.begin(), picture_.validity.end());
    std::atomic<bool> filled_any = false;
    bands.for_each_band(picture_.height, TileGrid::cells, [&](const RowBand& band) {
        if (fill_rows(band)) filled_any.store(true, std::memory_order_relaxed);
    });
    return filled_any.load(std::memory_order_relaxed);
}

// Codes change in place: a pixel filled in this pass is not valid in `before_`, so it is not read yet.
bool HoleFiller::fill_rows(const RowBand& band) {
    const int words = picture_.validity_words_per_row();
    const ValidityBits before{before_, words, picture_.height};
    bool filled_any = false;
    for (int y = band.first; y < band.last; ++y)
        for (int w = 0; w < words; ++w) {
            std::uint32_t holes = ~before.word(w, y) & inside_bits(picture_.width, w);
            if (holes == 0) continue;
            holes &= before.spread(w, y - 1) | before.spread(w, y) | before.spread(w, y + 1);
            std::uint32_t filled = 0;
            for (; holes != 0; holes &= holes - 1) {
                const int bit = std::countr_zero(holes), x = w * strip_pixels + bit;
                std::uint16_t neighbours[8];
                const int count = valid_neighbours(picture_, before, x, y, neighbours);
                if (count < neighbours_to_fill) continue;
                picture_.codes[picture_.index(x, y)] = lower_median(neighbours, count);
                filled |= std::uint32_t{1} << bit;
            }
            picture_.validity_row(y)[w] |= filled;
            filled_any |= filled != 0;
        }
    return filled_any;
}

FlyingPixelFilter::FlyingPixelFilter(std::unique_ptr<LineSource> lines, const FlyingPixels& filter,
                                     const DepthCoding& coding, VectorUnit unit)
    : before_landing_(std::move(lines)), filter_(filter), zero_is_code_(coding.is_valid(0)), unit_(unit) {}

void FlyingPixelFilter::begin(const RawFrame& raw, RowBands& bands) {
    before_landing_.make_all(raw, bands, before_);
    picture_.width = before_.width;
    picture_.height = before_.height;
    picture_.codes.resize(before_.codes.size());
    picture_.validity.resize(before_.validity.size());
    std::copy(before_.validity.begin(), before_.validity.end(), picture_.validity.begin());
    suspects_.resize(static_cast<std::size_t>(bands.threads()));
    for (auto& strips : suspects_) strips.resize(static_cast<std::size_t>(before_.validity_words_per_row()));
    bands.for_each_band(before_.height, TileGrid::cells, [&](const RowBand& band) { land_rows(band); });
}

void FlyingPixelFilter::land_rows(const RowBand& band) {
    std::vector<std::uint32_t>& suspects = suspects_[static_cast<std::size_t>(band.thread)];
    const auto row = [&](int y) { return before_.codes.data() + before_.index(0, y); };
    for (int y = band.first; y < band.last; ++y) {
        std::memcpy(picture_.codes.data() + picture_.index(0, y), row(y),
                    static_cast<std::size_t>(before_.width) * sizeof(std::uint16_t));
        // Rows at the border have no neighbours to test, a row's last codes are no whole strip, and there is
        // no code to read before the picture's first one.
        std::fill(suspects.begin(), suspects.end(), ~std::uint32_t{0});
        if (y > 0 && y < before_.height - 1)
            run_vectors(unit_,
                        RowSuspicion{row(y - 1), row(y), row(y + 1), filter_, zero_is_code_, y == 1 ? 1 : 0,
                                     (before_.width - 1) / strip_pixels, suspects.data()});
        for (std::size_t word = 0; word < suspects.size(); ++word)
            for (std::uint32_t bits = suspects[word] & before_.validity_row(y)[word]; bits != 0;
                 bits &= bits - 1)
                land(static_cast<int>(word) * strip_pixels + std::countr_zero(bits), y);
    }
}

void FlyingPixelFilter::land(int x, int y) {
    const auto at = [&](int dx, int dy) {
        const int tx = x + dx, ty = y + dy;
        if (tx < 0 || tx >= before_.width || ty < 0 || ty >= before_.height || !before_.is_valid(tx, ty))
            return -1;
        return int{before_.codes[before_.index(tx, ty)]};
    };
    const std::size_t here = before_.index(x, y);
    picture_.codes[here] = landed(at, filter_.gate_at(before_.codes[here]));
}

}  // namespace touchable
