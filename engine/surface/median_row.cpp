#include "engine/surface/median_row.hpp"

#include <algorithm>
#include <cstring>

#include "engine/surface/median_network.hpp"
#include "engine/surface/vectors.hpp"

namespace touchable {
namespace {

/// Pixels whose columns are sorted at once: few enough that they are still in the fastest cache when windows
/// are made of them.
constexpr int block_pixels = 8 * strip_pixels;

/// Every pixel of every window is valid. `pixels`: whole strips, at most a block; `rows` start at the first
/// window's left column and are read a strip beyond.
template <class Lanes, int Side>
[[gnu::always_inline]] inline void median_of_clean_pixels(const std::uint16_t* const (&rows)[Side],
                                                          int pixels, std::uint16_t* out) {
    constexpr int lanes = lane_count<Lanes>;
    static_assert(Side - 1 <= lanes && lanes <= strip_pixels);
    alignas(64) std::uint16_t ranked[Side][block_pixels + lanes];
    for (int x = 0; x < pixels + lanes; x += lanes) {
        Lanes column[Side];
        for (int k = 0; k < Side; ++k) column[k] = load_lanes<Lanes>(rows[k] + x);
        sort_column(column);
        for (int k = 0; k < Side; ++k) store_lanes(column[k], ranked[k] + x);
    }
    for (int x = 0; x < pixels; x += lanes) {
        Lanes ranks[Side][Side];
        for (int k = 0; k < Side; ++k)
            for (int dx = 0; dx < Side; ++dx) ranks[k][dx] = load_lanes<Lanes>(ranked[k] + x + dx);
        store_lanes(median_of_sorted_columns(ranks), out + x);
    }
}

/// Of a strip. Invalid pixels count as least and greatest in turn, least first: of n valid and m others,
/// (m + 1)/2 stand below all codes, and the middle one of all is element (n - 1)/2 of the valid ones, the
/// lower median.
template <class Lanes, int Side>
[[gnu::always_inline]] inline void median_of_masked_strip(const std::uint16_t* const (&rows)[Side],
                                                          const std::uint16_t* const (&invalid)[Side],
                                                          std::uint16_t* out) {
    constexpr int lanes = lane_count<Lanes>, radius = Side / 2;
    for (int x = 0; x < strip_pixels; x += lanes) {
        Lanes ranks[Side][Side];
        Lanes below{};  // all ones after an odd number of invalid pixels
        for (int dx = 0; dx < Side; ++dx) {
            Lanes column[Side];
            for (int k = 0; k < Side; ++k) {
                const Lanes mask = load_lanes<Lanes>(invalid[k] + x + dx);
                below ^= mask;
                column[k] = load_lanes<Lanes>(rows[k] + x + dx) | (mask & ~below);
            }
            sort_column(column);
            for (int k = 0; k < Side; ++k) ranks[k][dx] = column[k];
        }
        const Lanes centre_invalid = load_lanes<Lanes>(invalid[radius] + radius + x);
        store_lanes<Lanes>(median_of_sorted_columns(ranks) & ~centre_invalid, out + x);
    }
}

/// Strips from `w` on, at most a block, whose windows have no invalid pixel.
template <int Side>
int clean_strips(const CodeLine* const (&lines)[Side], int w) {
    const int end = std::min(w + block_pixels / strip_pixels, lines[0]->strips());
    int n = w;
    for (; n < end; ++n) {
        std::uint32_t holes = 0;
        for (const CodeLine* line : lines) holes |= line->holes_near()[n];
        if (holes != 0) break;
    }
    return n - w;
}

template <class Lanes, int Side>
[[gnu::always_inline]] inline void median_row(const CodeLine* const (&lines)[Side], std::uint16_t* codes,
                                              int width) {
    alignas(64) std::uint16_t beyond[block_pixels];  // for what reaches beyond the row
    for (int w = 0, strips; w < lines[0]->strips(); w += strips) {
        const int x = w * strip_pixels;
        const std::uint16_t *rows[Side], *invalid[Side];
        for (int k = 0; k < Side; ++k) {
            rows[k] = lines[k]->codes() + x;
            invalid[k] = lines[k]->invalid() + x;
        }
        strips = clean_strips(lines, w);
        const bool clean = strips > 0;
        strips = std::max(strips, 1);
        const int pixels = strips * strip_pixels;
        std::uint16_t* out = x + pixels <= width ? codes + x : beyond;
        if (clean)
            median_of_clean_pixels<Lanes>(rows, pixels, out);
        else
            median_of_masked_strip<Lanes>(rows, invalid, out);
        if (out == beyond)
            std::memcpy(codes + x, beyond, static_cast<std::size_t>(width - x) * sizeof(std::uint16_t));
    }
}

}  // namespace

template <int Side>
void median_of_row(VectorUnit unit, const CodeLine* const (&lines)[Side], std::uint16_t* codes, int width) {
    run_vectors(
        unit, [&](auto kind) __attribute__((always_inline)) {
            median_row<typename decltype(kind)::Lanes>(lines, codes, width);
        });
}

template void median_of_row(VectorUnit, const CodeLine* const (&)[3], std::uint16_t*, int);
template void median_of_row(VectorUnit, const CodeLine* const (&)[5], std::uint16_t*, int);

}  // namespace touchable
