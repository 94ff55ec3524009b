// SPDX-License-Identifier: Apache-2.0
// Medians of 3x3 and 5x5 pixels by networks, vectorised.
#include "engine/surface/median.hpp"

namespace touchable {
namespace {

/// Pixels whose columns are sorted at once: few enough to stay in the fastest cache until windows are made of
/// them, and enough that the CPU has completed the stores: a load across two pending stores waits.
constexpr int block_pixels = 32 * strip_pixels;

/// Loads a vector of each row, from this place on.
template <class Lanes, std::size_t Rows, std::size_t Length>
[[gnu::always_inline]] inline void load_each(const std::uint16_t (&rows)[Rows][Length], int at,
                                             Lanes (&to)[Rows]) {
    for (std::size_t k = 0; k < Rows; ++k) to[k] = load_lanes<Lanes>(rows[k] + at);
}

/// For windows of valid pixels only. `pixels`: whole strips, at most a block; `rows` start at the first
/// window's left column and are read a strip beyond.
template <class Lanes>
[[gnu::always_inline]] inline void median_of_clean_pixels(const std::uint16_t* const (&rows)[3], int pixels,
                                                          std::uint16_t* out) {
    constexpr int lanes = lane_count<Lanes>;
    alignas(64) std::uint16_t ranked[3][block_pixels + lanes];
    for (int x = 0; x < pixels + lanes; x += lanes) {
        Lanes column[3];
        for (int k = 0; k < 3; ++k) column[k] = load_lanes<Lanes>(rows[k] + x);
        sort3(column);
        for (int k = 0; k < 3; ++k) store_lanes(column[k], ranked[k] + x);
    }
    for (int x = 0; x < pixels; x += lanes) {
        Lanes columns[3][3];
        for (int dx = 0; dx < 3; ++dx) load_each(ranked, x + dx, columns[dx]);
        store_lanes(median_of_columns(columns), out + x);
    }
}

/// A vector holds every second column, so that both windows of a pair of pixels can share the four merged
/// columns: 2 m + 1 to 2 m + 4.
template <class Lanes>
[[gnu::always_inline]] inline void median_of_clean_pixels(const std::uint16_t* const (&rows)[5], int pixels,
                                                          std::uint16_t* out) {
    constexpr int lanes = lane_count<Lanes>, most = block_pixels / 2 + 2 * lanes;
    static_assert(lanes <= strip_pixels && lanes >= 3);
    alignas(64) std::uint16_t even[5][most], odd[5][most], merged[10][most];
    for (int m = 0; 2 * m < pixels + lanes; m += lanes) {
        const int x = 2 * m, next = std::min(x + lanes, pixels);  // columns beyond are not needed
        Lanes left[5], right[5];
        for (int k = 0; k < 5; ++k)
            split_lanes(load_lanes<Lanes>(rows[k] + x), load_lanes<Lanes>(rows[k] + next), left[k], right[k]);
        sort5(left);
        sort5(right);
        for (int k = 0; k < 5; ++k) {
            store_lanes(left[k], even[k] + m);
            store_lanes(right[k], odd[k] + m);
        }
    }
    for (int m = 0; 2 * m <= pixels; m += lanes) {
        Lanes first[5], second[5], pair[10];
        load_each(odd, m, first);
        load_each(even, m + 1, second);
        pair5(first, second, pair);
        for (int k = 0; k < 10; ++k) store_lanes(pair[k], merged[k] + m);
    }
    for (int m = 0; 2 * m < pixels; m += lanes) {
        Lanes first[10], second[10], quad[6], before[5], after[5], left, right;
        load_each(merged, m, first);
        load_each(merged, m + 1, second);
        quad5(first, second, quad);
        load_each(even, m, before);
        load_each(odd, m + 2, after);
        join_lanes(median25(quad, before), median25(quad, after), left, right);
        store_lanes(left, out + 2 * m);
        if (2 * m + lanes < pixels) store_lanes(right, out + 2 * m + lanes);
    }
}

/// For one strip. Invalid pixels count as least and greatest in turn, least first: with n valid and m invalid
/// pixels, (m + 1)/2 stand below all codes, and the middle one of all is element (n - 1)/2 of the valid ones,
/// the lower median.
template <class Lanes, int Side>
[[gnu::always_inline]] inline void median_of_masked_strip(const std::uint16_t* const (&rows)[Side],
                                                          const std::uint16_t* const (&invalid)[Side],
                                                          std::uint16_t* out) {
    constexpr int lanes = lane_count<Lanes>, radius = Side / 2;
    for (int x = 0; x < strip_pixels; x += lanes) {
        Lanes columns[Side][Side];
        Lanes below{};  // all ones after an odd number of invalid pixels
        for (int dx = 0; dx < Side; ++dx) {
            Lanes(&column)[Side] = columns[dx];
            for (int k = 0; k < Side; ++k) {
                const Lanes mask = load_lanes<Lanes>(invalid[k] + x + dx);
                below ^= mask;
                column[k] = load_lanes<Lanes>(rows[k] + x + dx) | (mask & ~below);
            }
            sort_column(column);
        }
        const Lanes centre_invalid = load_lanes<Lanes>(invalid[radius] + radius + x);
        store_lanes<Lanes>(median_of_columns(columns) & ~centre_invalid, out + x);
    }
}

/// Number of strips from `w` on, at most a block, whose windows have no invalid pixel.
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
    alignas(64) std::uint16_t beyond[block_pixels];  // for output beyond the row
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

/// The lower median of the valid codes in each window of Side x Side, for a row of `width` codes; 0 if the
/// centre is invalid. `lines`: the windows' rows from the upper one on, with reach Side / 2. Side: 3 or 5.
template <int Side>
void median_of_row(VectorUnit unit, const CodeLine* const (&lines)[Side], std::uint16_t* codes, int width) {
    run_vectors(
        unit, [&](auto kind) __attribute__((always_inline)) {
            median_row<typename decltype(kind)::type>(lines, codes, width);
        });
}

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
