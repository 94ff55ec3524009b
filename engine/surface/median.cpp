#include "engine/surface/median.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "engine/surface/median_network.hpp"
#include "engine/surface/validity_strip.hpp"

namespace touchable {
namespace {

constexpr int lanes = sizeof(Lanes) / sizeof(std::int16_t);

template <class T>
Lanes load_lanes(const T* from) {
    static_assert(sizeof(T) == sizeof(std::int16_t));
    Lanes values;
    std::memcpy(&values, from, sizeof(values));
    return values;
}
void store_lanes(Lanes values, std::int16_t* to) {
    std::memcpy(to, &values, sizeof(values));
}

/// Pixels a line replicates on each side of the picture; at least the radius of the largest window.
constexpr int margin = 2;

/// Every pixel of every window is valid. `rows` start at the first window's left column; read `lanes` beyond
/// the strip.
template <int Side>
void median_of_clean_strip(const std::int16_t* const (&rows)[Side], std::int16_t* out) {
    static_assert(Side - 1 <= lanes);
    std::int16_t ranked[Side][strip_pixels + lanes];
    for (int x = 0; x < strip_pixels + lanes; x += lanes) {
        Lanes column[Side];
        for (int k = 0; k < Side; ++k) column[k] = load_lanes(rows[k] + x);
        sort_column(column);
        for (int k = 0; k < Side; ++k) store_lanes(column[k], ranked[k] + x);
    }
    for (int x = 0; x < strip_pixels; x += lanes) {
        Lanes ranks[Side][Side];
        for (int k = 0; k < Side; ++k)
            for (int dx = 0; dx < Side; ++dx) ranks[k][dx] = load_lanes(ranked[k] + x + dx);
        store_lanes(median_of_sorted_columns(ranks), out + x);
    }
}

/// Invalid pixels count as least and greatest in turn, least first: of n valid and m others, (m + 1)/2 stand
/// below all codes, and the middle one of all is element (n - 1)/2 of the valid ones, the lower median.
template <int Side>
void median_of_masked_strip(const std::int16_t* const (&rows)[Side],
                            const std::uint16_t* const (&invalid)[Side], std::int16_t* out) {
    const Lanes greatest = Lanes{} + std::int16_t{INT16_MAX};
    for (int x = 0; x < strip_pixels; x += lanes) {
        Lanes ranks[Side][Side];
        Lanes below{};  // all ones after an odd number of invalid pixels
        for (int dx = 0; dx < Side; ++dx) {
            Lanes column[Side];
            for (int k = 0; k < Side; ++k) {
                const Lanes mask = load_lanes(invalid[k] + x + dx);
                below ^= mask;
                column[k] = (load_lanes(rows[k] + x + dx) & ~mask) | ((greatest ^ below) & mask);
            }
            sort_column(column);
            for (int k = 0; k < Side; ++k) ranks[k][dx] = column[k];
        }
        store_lanes(median_of_sorted_columns(ranks), out + x);
    }
}

template <class T>
void replicate_border(std::vector<T>& row, int width) {
    const auto first = row.begin() + margin;
    std::fill(row.begin(), first, *first);
    std::fill(first + width, first + width + margin, *(first + width - 1));
}

}  // namespace

void MedianFilter::apply(int side, SurfaceFrame& frame) {
    assert(side == 3 || side == 5);
    if (side == 3) filter<3>(frame);
    if (side == 5) filter<5>(frame);
}

template <int Side>
void MedianFilter::filter(SurfaceFrame& frame) {
    constexpr int radius = Side / 2;
    static_assert(radius <= margin && margin <= lanes);
    lines_.resize(Side);
    int loaded = 0;
    for (int y = 0; y < frame.height; ++y) {
        for (; loaded <= std::min(y + radius, frame.height - 1); ++loaded)
            load(frame, loaded, lines_[static_cast<std::size_t>(loaded % Side)]);
        const Line* window[Side];
        for (int k = 0; k < Side; ++k)
            window[k] =
                &lines_[static_cast<std::size_t>(std::clamp(y + k - radius, 0, frame.height - 1) % Side)];
        filter_row<Side>(window, frame.codes.data() + frame.index(0, y), frame.width);
    }
}

void MedianFilter::load(const SurfaceFrame& frame, int y, Line& line) {
    const int words = frame.validity_words_per_row();
    const auto pixels = static_cast<std::size_t>(margin + words * strip_pixels + lanes);
    line.values.resize(pixels);
    line.invalid.resize(pixels);
    line.holes.resize(static_cast<std::size_t>(words));
    const std::uint32_t* validity = frame.validity.data() + static_cast<std::ptrdiff_t>(y) * words;
    const std::uint16_t* codes = frame.codes.data() + frame.index(0, y);
    std::int16_t* values = line.values.data() + margin;
    for (int x = 0; x < frame.width; ++x) values[x] = static_cast<std::int16_t>(codes[x] ^ 0x8000);
    replicate_border(line.values, frame.width);
    for (int w = 0; w < words; ++w) {
        const std::uint32_t holes = ~validity[w] & inside_bits(frame.width, w);
        line.holes[static_cast<std::size_t>(w)] = holes;
        masks_of_bits(holes, line.invalid.data() + margin + w * strip_pixels);
    }
    replicate_border(line.invalid, frame.width);
}

template <int Side>
void MedianFilter::filter_row(const Line* const (&window)[Side], std::uint16_t* codes, int width) const {
    constexpr int radius = Side / 2;
    const int words = static_cast<int>(window[0]->holes.size());
    for (int w = 0; w < words; ++w) {
        const int x = w * strip_pixels, count = std::min(strip_pixels, width - x);
        std::uint32_t holes = 0;
        const std::int16_t* rows[Side];
        const std::uint16_t* invalid[Side];
        for (int k = 0; k < Side; ++k) {
            const std::uint32_t* line_holes = window[k]->holes.data() + w;
            holes |= line_holes[0];
            if (w > 0) holes |= line_holes[-1] >> (strip_pixels - radius);
            if (w + 1 < words) holes |= line_holes[1] << (strip_pixels - radius);
            rows[k] = window[k]->values.data() + margin + x - radius;
            invalid[k] = window[k]->invalid.data() + margin + x - radius;
        }
        if (window[radius]->holes[static_cast<std::size_t>(w)] == inside_bits(width, w)) continue;
        std::int16_t medians[strip_pixels];
        if (holes == 0) {
            median_of_clean_strip<Side>(rows, medians);
            for (int k = 0; k < count; ++k) codes[x + k] = static_cast<std::uint16_t>(medians[k] ^ 0x8000);
        } else {
            median_of_masked_strip<Side>(rows, invalid, medians);
            const std::uint16_t* centre = invalid[radius] + radius;
            for (int k = 0; k < count; ++k)
                codes[x + k] = static_cast<std::uint16_t>((medians[k] ^ 0x8000) & ~centre[k]);
        }
    }
}

}  // namespace touchable
