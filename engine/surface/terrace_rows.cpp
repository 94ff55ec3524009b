#include "engine/surface/terrace_rows.hpp"

#include <cstring>

#include "engine/base/vectors.hpp"
#include "engine/surface/curve_lanes.hpp"
#include "engine/surface/validity_strip.hpp"

namespace touchable {
namespace {

/// As many values with a sign.
template <class Bits>
struct WithSign {
    using Lanes [[gnu::vector_size(sizeof(Bits))]] = std::int16_t;
};

// 16 bits are enough, though second differences may leave them (terrace_range).

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

/// Without a sign sums may wrap around.
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

/// 0 where a tap does not count; `at`: masks.
template <class Lanes>
[[gnu::always_inline]] inline void leave_out_holes(const Place& at, int step, SecondDifferences<Lanes>& d) {
    d.across &= ~(load_lanes<Lanes>(at.mid - step) | load_lanes<Lanes>(at.mid + step));
    d.down &= ~(load_lanes<Lanes>(at.up) | load_lanes<Lanes>(at.down));
    d.falling &= ~(load_lanes<Lanes>(at.up - step) | load_lanes<Lanes>(at.down + step));
    d.rising &= ~(load_lanes<Lanes>(at.up + step) | load_lanes<Lanes>(at.down - step));
}

/// `away`: words from that of a centre to those of its taps.
[[gnu::always_inline]] inline bool any_hole_near(const std::uint32_t* word, int away) {
    return (word[-away] | word[0] | word[away]) != 0;
}

/// TerraceFilter::gate_at and most_at of a row.
struct RowGates {
    const TerraceFilter& filter;
    const std::int16_t* codes;
    int words;
    std::int16_t *gates, *most;

    template <class Kind>
    [[gnu::always_inline]] void operator()(Kind) const {
        using Bits = typename Kind::Lanes;
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
        using Bits = typename Kind::Lanes;
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

}  // namespace

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

}  // namespace touchable
