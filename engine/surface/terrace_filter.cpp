// SPDX-License-Identifier: Apache-2.0
// Terrace removal in passes, on whole rows and on patches.
#include "engine/surface/terrace_filter.hpp"

namespace touchable {
namespace {

/// As many signed values.
template <class Bits>
struct WithSign {
    using Lanes [[gnu::vector_size(sizeof(Bits))]] = std::int16_t;
};

// 16 bits are enough, though second differences may exceed them (terrace_range).

template <class Lanes>
[[gnu::always_inline]] inline Lanes clamped(const Lanes& value, const Lanes& most) {
    const Lanes below = value < most ? value : most;
    return below > -most ? below : -most;
}

template <class Lanes>
struct SecondDifferences {
    Lanes across, down, falling, rising;
};

/// 16 times what a pass adds to a code. Tents are 2 clamped(d, gate) - clamped(d, 2 gate), summed before they
/// are multiplied.
template <class Lanes>
[[gnu::always_inline]] inline Lanes levelling(const SecondDifferences<Lanes>& d, const Lanes& gate) {
    const Lanes wide = gate + gate;
    const Lanes straight = clamped(d.across, gate) + clamped(d.down, gate);
    const Lanes straight_wide = clamped(d.across, wide) + clamped(d.down, wide);
    const Lanes diagonal = clamped(d.falling, gate) + clamped(d.rising, gate);
    const Lanes diagonal_wide = clamped(d.falling, wide) + clamped(d.rising, wide);
    const Lanes half = straight + straight + diagonal - straight_wide;
    return half + half - diagonal_wide;
}

/// The same place in three rows.
struct Place {
    const std::int16_t *up, *mid, *down;
};

/// Unsigned, so that sums may wrap around.
template <class Bits, class Lanes>
[[gnu::always_inline]] inline Lanes pair_difference(const std::int16_t* a, const std::int16_t* b,
                                                    const Bits& twice) {
    return reinterpret_cast<Lanes>(load_lanes<Bits>(a) + load_lanes<Bits>(b) - twice);
}

template <class Bits, class Lanes>
[[gnu::always_inline]] inline void find_differences(const Place& at, int step, SecondDifferences<Lanes>& d) {
    const Bits centre = load_lanes<Bits>(at.mid), twice = centre + centre;
    d.across = pair_difference<Bits, Lanes>(at.mid - step, at.mid + step, twice);
    d.down = pair_difference<Bits, Lanes>(at.up, at.down, twice);
    d.falling = pair_difference<Bits, Lanes>(at.up - step, at.down + step, twice);
    d.rising = pair_difference<Bits, Lanes>(at.up + step, at.down - step, twice);
}

/// Sets the differences with a tap that does not count to 0; `at`: masks.
template <class Lanes>
[[gnu::always_inline]] inline void leave_out_holes(const Place& at, int step, SecondDifferences<Lanes>& d) {
    d.across &= ~(load_lanes<Lanes>(at.mid - step) | load_lanes<Lanes>(at.mid + step));
    d.down &= ~(load_lanes<Lanes>(at.up) | load_lanes<Lanes>(at.down));
    d.falling &= ~(load_lanes<Lanes>(at.up - step) | load_lanes<Lanes>(at.down + step));
    d.rising &= ~(load_lanes<Lanes>(at.up + step) | load_lanes<Lanes>(at.down - step));
}

/// `away`: words from a centre's to those of its taps.
[[gnu::always_inline]] inline bool any_hole_near(const std::uint32_t* word, int away) {
    return (word[-away] | word[0] | word[away]) != 0;
}

/// TerraceFilter::gate_at and most_at for a row.
struct RowGates {
    const TerraceFilter& filter;
    const std::int16_t* codes;
    int words;
    std::int16_t *gates, *most;

    template <class Kind>
    [[gnu::always_inline]] void operator()(Kind) const {
        using Bits = typename Kind::type;
        const Bits step = Bits{} + static_cast<std::uint16_t>(filter.step);
        const Bits largest = Bits{} + std::uint16_t{TerraceFilter::most_level};
        const Bits noise = Bits{} + static_cast<std::uint16_t>(3 * filter.noise);
        for (int x = 0; x < words * strip_pixels; x += lane_count<Bits>) {
            const Bits code = load_lanes<Bits>(codes + x);
            Bits level = curve_at(filter.levels, code);
            if (!filter.steps.is_zero()) level = greater<Bits>(level, curve_at(filter.steps, code));
            level = lesser<Bits>(greater<Bits>(level >> filter.fraction, step), largest);
            const Bits four = (level << 2) + noise, gate = (four + level) >> 2, limit = four >> 2;
            std::memcpy(gates + x, &gate, sizeof(gate));
            std::memcpy(most + x, &limit, sizeof(limit));
        }
    }
};

/// `has_levels`: gates differ from pixel to pixel.
template <bool has_levels>
struct RowLevelling {
    const TerraceRow &above, &here, &below;
    int words;
    const TerracePass& pass;
    std::int16_t* out;

    template <class Kind>
    [[gnu::always_inline]] void operator()(Kind) const {
        using Bits = typename Kind::type;
        using Lanes = typename WithSign<Bits>::Lanes;
        static_assert(strip_pixels % lane_count<Bits> == 0);
        const TerraceFilter& filter = pass.filter;
        const Lanes even_gate = Lanes{} + static_cast<std::int16_t>(filter.gate_at(0, pass.step));
        const int away = words_beyond(pass.step);
        for (int word = 0; word < words; ++word) {
            const bool has_holes = any_hole_near(above.holes + word, away) ||
                                   any_hole_near(here.holes + word, away) ||
                                   any_hole_near(below.holes + word, away);
            for (int x = word * strip_pixels; x < (word + 1) * strip_pixels; x += lane_count<Bits>) {
                SecondDifferences<Lanes> d;
                find_differences<Bits>({above.codes + x, here.codes + x, below.codes + x}, pass.step, d);
                if (has_holes)
                    leave_out_holes<Lanes>({above.masks + x, here.masks + x, below.masks + x}, pass.step, d);
                const Bits centre = load_lanes<Bits>(here.codes + x);
                Lanes gate = even_gate;
                if constexpr (has_levels) gate = load_lanes<Lanes>(here.gates + x);
                const Lanes sum = levelling(d, gate);
                const Bits after = pass.is_last ? centre + centre + reinterpret_cast<Bits>((sum + 4) >> 3)
                                                : centre + reinterpret_cast<Bits>((sum + 8) >> 4);
                std::memcpy(out + x, &after, sizeof(after));
            }
        }
    }
};

/// Stores the finer codes of a strip, limited to near their values before the passes, and 0 for invalid ones.
/// All in 16 bits, which CPUs do fast: passes cannot move a code by more than fits them.
void store_strip(const TerraceFilter& filter, const std::int16_t* finer, const std::uint16_t* before,
                 const std::int16_t* limits, std::uint32_t validity, std::uint16_t* codes, int count) {
    std::uint16_t was[strip_pixels];
    filter.working.row(before, count, was);
    std::int16_t most[strip_pixels];
    if (filter.is_even())
        std::fill_n(most, strip_pixels, static_cast<std::int16_t>(2 * filter.most_at(0)));
    else
        for (int k = 0; k < strip_pixels; ++k) most[k] = static_cast<std::int16_t>(2 * limits[k]);
    for (int k = 0; k < count; ++k) {
        const auto twice = static_cast<std::uint16_t>(2 * was[k]);
        const auto moved = static_cast<std::int16_t>(static_cast<std::uint16_t>(finer[k]) - twice);
        codes[k] = static_cast<std::uint16_t>(
            twice + std::clamp(moved, static_cast<std::int16_t>(-most[k]), most[k]));
    }
    if (validity == ~std::uint32_t{0}) return;
    std::uint16_t masks[strip_pixels];
    masks_of_bits(validity, masks);
    for (int k = 0; k < count; ++k) codes[k] = static_cast<std::uint16_t>(codes[k] & masks[k]);
}

/// TerraceFilter::gate_at and most_at for `words` times 32 working codes.
void find_gates(VectorUnit unit, const TerraceFilter& filter, const std::int16_t* codes, int words,
                std::int16_t* gates, std::int16_t* most) {
    run_vectors(unit, RowGates{filter, codes, words, gates, most});
}

void level_row(VectorUnit unit, const TerraceRow& above, const TerraceRow& here, const TerraceRow& below,
               int words, const TerracePass& pass, std::int16_t* out) {
    if (pass.filter.is_even())
        run_vectors(unit, RowLevelling<false>{above, here, below, words, pass, out});
    else
        run_vectors(unit, RowLevelling<true>{above, here, below, words, pass, out});
}

}  // namespace

void TerraceRemover::begin(const RawFrame& raw, RowBands& bands) {
    before_->make_all(raw, bands, with_terraces_);
    resize(raw.depth.width, bands.threads());
}

void TerraceRemover::resize(int width, int threads) {
    const int words = (width + strip_pixels - 1) / strip_pixels;
    if (words == words_ && work_.size() == static_cast<std::size_t>(threads)) return;
    words_ = words;
    pitch_ = words_ * strip_pixels + 2 * margin_;
    work_.resize(static_cast<std::size_t>(threads));
    for (Work& work : work_) {
        for (int pass = 0; pass <= filter_.passes(); ++pass) {
            Ring& ring = work.rings[pass];
            ring.count = pass < filter_.passes() ? 2 * filter_.tap_of(pass) + 1 : 1;
            ring.codes.resize(static_cast<std::size_t>(pitch_ * ring.count));
        }
        work.masks.assign(static_cast<std::size_t>(pitch_ * (known_rows_ + 1)), -1);
        for (auto* rows : {&work.gates, &work.most})
            rows->resize(filter_.is_even() ? 0
                                           : static_cast<std::size_t>(words_ * strip_pixels * known_rows_));
        work.holes.assign(static_cast<std::size_t>(hole_words() * (known_rows_ + 1)), ~std::uint32_t{0});
    }
}

void TerraceRemover::make(const RowBand& band, SurfaceFrame& out) {
    Work& work = work_[static_cast<std::size_t>(band.thread)];
    const int height = out.height;
    const int passes = filter_.passes();
    for (int loaded = std::max(band.first - filter_.reach, 0); loaded < band.last + filter_.reach; ++loaded) {
        if (loaded < height) load(loaded, work);
        // Each pass lags the one before by its step, and is needed as far beyond the band as the later ones
        // reach.
        int y = loaded, reach = filter_.reach;
        for (int pass = 0; pass < passes; ++pass) {
            const int step = filter_.tap_of(pass);
            y -= step;
            reach -= step;
            if (y < std::max(band.first - reach, 0) || y >= std::min(band.last + reach, height)) continue;
            level_row(unit_, row(work, pass, y - step), row(work, pass, y), row(work, pass, y + step), words_,
                      {step, filter_, pass + 1 == passes}, codes(work, pass + 1, y));
        }
        if (y >= band.first && y < band.last) store(y, work, out);
    }
}

void TerraceRemover::load(int y, Work& work) const {
    const SurfaceFrame& from = with_terraces_;
    const std::uint16_t* stored = from.codes.data() + from.index(0, y);
    std::int16_t* to = codes(work, 0, y);
    filter_.working.row(stored, from.width, to);
    if (!filter_.is_even())
        find_gates(unit_, filter_, to, words_, work.gates.data() + gates_at(y),
                   work.most.data() + gates_at(y));
    const std::uint32_t* validity = from.validity_row(y);
    const int slot = y % known_rows_;
    std::int16_t* masks = work.masks.data() + pitch_ * slot + margin_;
    std::uint32_t* holes = work.holes.data() + hole_words() * slot + words_beyond(margin_);
    for (int word = 0; word < words_; ++word) {
        holes[word] = ~validity[word];
        std::uint16_t bits[strip_pixels] = {};
        if (holes[word] != 0) masks_of_bits(holes[word], bits);
        std::memcpy(masks + word * strip_pixels, bits, sizeof(bits));
    }
}

void TerraceRemover::store(int y, Work& work, SurfaceFrame& out) const {
    const SurfaceFrame& from = with_terraces_;
    const std::uint32_t* validity = from.validity_row(y);
    std::copy(validity, validity + words_, out.validity_row(y));
    for (int word = 0; word < words_; ++word) {
        const int x = word * strip_pixels;
        const std::int16_t* limits = filter_.is_even() ? nullptr : work.most.data() + gates_at(y) + x;
        store_strip(filter_, codes(work, filter_.passes(), y) + x, from.codes.data() + from.index(x, y),
                    limits, validity[word], out.codes.data() + out.index(x, y),
                    std::min(strip_pixels, from.width - x));
    }
}

TerraceRow TerraceRemover::row(const Work& work, int pass, int y) const {
    const bool inside = y >= 0 && y < with_terraces_.height;
    const Ring& ring = work.rings[pass];
    const int slot = inside ? y % ring.count : 0, known = inside ? y % known_rows_ : known_rows_;
    const auto& gates = TerraceFilter::is_wide(filter_.tap_of(pass)) ? work.most : work.gates;
    return {ring.codes.data() + pitch_ * slot + margin_, work.masks.data() + pitch_ * known + margin_,
            work.holes.data() + hole_words() * known + words_beyond(margin_),
            inside && !filter_.is_even() ? gates.data() + gates_at(y) : nullptr};
}

std::ptrdiff_t TerraceRemover::gates_at(int y) const {
    return std::ptrdiff_t{words_} * strip_pixels * (y % known_rows_);
}

std::int16_t* TerraceRemover::codes(Work& work, int pass, int y) const {
    Ring& ring = work.rings[pass];
    return ring.codes.data() + pitch_ * (y % ring.count) + margin_;
}

template <int reach>
TerracePatch<reach>::TerracePatch(int width, int height, int bx, int by)
    : left_(std::max(bx * block - reach, 0)),
      right_(std::min(bx * block + block - 1 + reach, width - 1)),
      top_(std::max(by * block - reach, 0)),
      bottom_(std::min(by * block + block - 1 + reach, height - 1)) {
    std::memset(masks_, 0xFF, sizeof(masks_));
    std::memset(holes_, 0xFF, sizeof(holes_));
}

template <int reach>
void TerracePatch<reach>::set(int x, int y, std::uint16_t code, const TerraceFilter& filter) {
    const int column = x - left_, line = y - top_;
    before_[line][margin + column] = static_cast<std::int16_t>(filter.working.of(code));
    masks_[line][margin + column] = 0;
    holes_[line][beyond + column / strip_pixels] &= ~(std::uint32_t{1} << (column % strip_pixels));
}

/// Pixels beyond the patch count as outside. That is wrong if the picture goes on, and each pass carries the
/// error inward by its step: in total by the reach, which just does not get to the block.
template <int reach>
void TerracePatch<reach>::level(const TerraceFilter& filter) {
    const VectorUnit unit = usable_vector_units().front();
    std::memcpy(codes_, before_, sizeof(codes_));
    for (int line = 0; line <= bottom_ - top_; ++line)
        find_gates(unit, filter, before_[line] + margin, words, gates_[line], most_[line]);
    for (int pass = 0; pass < filter.passes(); ++pass) {
        const int step = filter.tap_of(pass);
        const bool is_last = pass + 1 == filter.passes();
        for (int y = top_; y <= bottom_; ++y)
            level_row(unit, row(codes_, step, y - step), row(codes_, step, y), row(codes_, step, y + step),
                      words, {step, filter, is_last}, next_[y - top_] + margin);
        std::memcpy(codes_, next_, sizeof(codes_));
    }
}

template <int reach>
std::uint16_t TerracePatch<reach>::code(int x, int y) const {
    const int line = y - top_, column = margin + x - left_;
    const std::uint16_t was = static_cast<std::uint16_t>(before_[line][column]);
    const int most = most_[line][x - left_], after = static_cast<std::uint16_t>(codes_[line][column]);
    return static_cast<std::uint16_t>(std::clamp(after, 2 * (was - most), 2 * (was + most)));
}

template <int reach>
TerraceRow TerracePatch<reach>::row(const std::int16_t (&codes)[side][pitch], int tap, int y) const {
    const bool inside = y >= top_ && y <= bottom_;
    const int line = inside ? y - top_ : 0, known = inside ? line : side;
    return {codes[line] + margin, masks_[known] + margin, holes_[known] + beyond,
            TerraceFilter::is_wide(tap) ? most_[line] : gates_[line]};
}

template class TerracePatch<16>;
template class TerracePatch<32>;
template class TerracePatch<64>;
template class TerracePatch<128>;

}  // namespace touchable
