#include "player/draw/decimation.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <glm/matrix.hpp>
#include <utility>

#include "engine/base/vectors.hpp"
#include "shaders/cut_rule.h"

namespace touchable {
namespace {

constexpr double most_apart = 1.5;  // pixels

/// Of every second one, so many that the last lies at the last vertex, or beyond it: it is that one then.
int half_of(int vertices) {
    return vertices / 2 + 1;
}

/// Rows of a band, which a loop of vectors goes through.
template <class Values>
void halve_values(const Values& from, int from_width, int from_height, int width, VectorUnit unit,
                  const RowBand& band, Values& to) {
    const auto all = [&](auto) __attribute__((always_inline)) {
        std::uint16_t* __restrict values = to.data() + static_cast<std::ptrdiff_t>(band.first) * width;
        for (int y = band.first; y < band.last; ++y, values += width) {
            const std::uint16_t* __restrict row =
                from.data() + static_cast<std::ptrdiff_t>(std::min(2 * y, from_height - 1)) * from_width;
            for (int x = 0; x + 1 < width; ++x) values[x] = row[2 * x];
            values[width - 1] = row[from_width - 1];
        }
    };
    run_vectors(unit, all);
}

/// Bits 0, 2, 4, ... side by side.
std::uint32_t even_bits(std::uint64_t bits) {
    bits &= 0x5555555555555555U;
    bits = (bits | bits >> 1) & 0x3333333333333333U;
    bits = (bits | bits >> 2) & 0x0f0f0f0f0f0f0f0fU;
    bits = (bits | bits >> 4) & 0x00ff00ff00ff00ffU;
    bits = (bits | bits >> 8) & 0x0000ffff0000ffffU;
    return static_cast<std::uint32_t>(bits | bits >> 16);
}

/// As many bytes as values of 16 bits.
template <class Lanes>
struct Bytes {
    typedef std::uint8_t Type __attribute__((vector_size(sizeof(Lanes) / 2)));
};
template <class Lanes>
[[gnu::always_inline]] inline Lanes load_bytes(const std::uint8_t* from) {
    typename Bytes<Lanes>::Type bytes;
    std::memcpy(&bytes, from, sizeof(bytes));
    return __builtin_convertvector(bytes, Lanes);
}
template <class Lanes>
[[gnu::always_inline]] inline void store_bytes(const Lanes& values, std::uint8_t* to) {
    const auto bytes = __builtin_convertvector(values, typename Bytes<Lanes>::Type);
    std::memcpy(to, &bytes, sizeof(bytes));
}

void halve_validity(const SurfaceFrame& from, const RowBand& band, SurfaceFrame& to) {
    const int words = to.validity_words_per_row(), from_words = from.validity_words_per_row();
    for (int y = band.first; y < band.last; ++y) {
        const int row = std::min(2 * y, from.height - 1);
        const std::uint32_t* bits = from.validity_row(row);
        std::uint32_t* const half = to.validity_row(y);
        for (int word = 0; word < words; ++word) {
            const std::uint64_t low = 2 * word < from_words ? bits[2 * word] : 0U,
                                high = 2 * word + 1 < from_words ? bits[2 * word + 1] : 0U;
            half[word] = even_bits(low | high << 32);
        }
        const int last = to.width - 1;
        half[last >> 5] &= ~(1U << (last & 31));
        half[last >> 5] |= std::uint32_t{from.is_valid(from.width - 1, row)} << (last & 31);
    }
}

}  // namespace

int Decimation::step_for(double pixels_per_vertex) {
    constexpr int most = 8;
    int step = 1;
    while (step < most && pixels_per_vertex * 2 * step <= most_apart) step *= 2;
    return step;
}

Decimation::Decimation(int threads, VectorUnit vectors)
    : unit_(vectors), bands_(threads), scratch_(static_cast<std::size_t>(threads)) {}

void Decimation::halve_frame(const SurfaceFrame& from, SurfaceFrame& to) {
    to.width = half_of(from.width);
    to.height = half_of(from.height);
    to.coding = from.coding;
    const std::size_t vertices = static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height);
    const bool has_heights = !from.heights.empty();
    to.codes.resize(vertices);
    to.heights.resize(has_heights ? vertices : 0);
    to.validity.resize(static_cast<std::size_t>(to.validity_words_per_row()) *
                       static_cast<std::size_t>(to.height));
    bands_.for_each_band(to.height, 1, [&](const RowBand& band) {
        halve_values(from.codes, from.width, from.height, to.width, unit_, band, to.codes);
        if (has_heights)
            halve_values(from.heights, from.width, from.height, to.width, unit_, band, to.heights);
        halve_validity(from, band, to);
    });
    if (!to.vertices) to.vertices = std::make_unique<FilteredVertices>(to);
}

const SurfaceFrame* Decimation::decimated_frame(const SurfaceFrame& frame, int step, Halves& halves) {
    const SurfaceFrame* made = &frame;
    for (int halvings = 0; 1 << halvings < step; ++halvings) {
        SurfaceFrame& half = halves[static_cast<std::size_t>(halvings % 2)];
        halve_frame(*made, half);
        made = &half;
    }
    return made;
}

/// Weights 1 2 1 across and down around every second pixel: no shift, and little that would shimmer.
void Decimation::halve_colour(const PlaneView& from, std::vector<std::uint8_t>& to) {
    const int width = half_of(from.width), height = half_of(from.height);
    to.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    bands_.for_each_band(height, 1, [&](const RowBand& band) {
        Scratch& scratch = scratch_[static_cast<std::size_t>(band.thread)];
        for (int y = band.first; y < band.last; ++y)
            halve_colour_row(from, y, scratch, to.data() + 3 * static_cast<std::ptrdiff_t>(width) * y);
    });
}

void Decimation::halve_colour_row(const PlaneView& from, int y, Scratch& scratch, std::uint8_t* out) const {
    const int row_bytes = 3 * from.width, width = half_of(from.width);
    const auto row = [&](int at) { return from.row(std::clamp(at, 0, from.height - 1)); };
    const std::uint8_t *upper = row(2 * y - 1), *middle = row(2 * y), *lower = row(2 * y + 1);
    // A pixel before the first, and two after the last.
    scratch.sums.resize(static_cast<std::size_t>(row_bytes) + 9);
    scratch.means.resize(static_cast<std::size_t>(row_bytes) + 6);
    std::uint16_t* const sums = scratch.sums.data() + 3;
    std::uint8_t* const means = scratch.means.data();
    const auto all = [&](auto kind) __attribute__((always_inline)) {
        using Lanes = typename decltype(kind)::Lanes;
        constexpr int n = lane_count<Lanes>;
        int k = 0;
        for (; k + n <= row_bytes; k += n)
            store_lanes<Lanes>(load_bytes<Lanes>(upper + k) + 2 * load_bytes<Lanes>(middle + k) +
                                   load_bytes<Lanes>(lower + k),
                               sums + k);
        for (; k < row_bytes; ++k) sums[k] = static_cast<std::uint16_t>(upper[k] + 2 * middle[k] + lower[k]);
        for (int channel = 0; channel < 3; ++channel) {
            sums[channel - 3] = sums[channel];
            sums[row_bytes + channel] = sums[row_bytes + 3 + channel] = sums[row_bytes - 3 + channel];
        }
        for (k = 0; k + n <= row_bytes + 3; k += n)
            store_bytes<Lanes>((load_lanes<Lanes>(sums + k - 3) + 2 * load_lanes<Lanes>(sums + k) +
                                load_lanes<Lanes>(sums + k + 3) + 8) >>
                                   4,
                               means + k);
        for (; k < row_bytes + 3; ++k)
            means[k] = static_cast<std::uint8_t>((sums[k - 3] + 2 * sums[k] + sums[k + 3] + 8) >> 4);
    };
    run_vectors(unit_, all);
    // Four bytes for three: the fourth is the next pixel's.
    for (int x = 0; x + 1 < width; ++x) std::memcpy(out + 3 * x, means + 6 * x, 4);
    std::memcpy(out + 3 * (width - 1), means + 6 * (width - 1), 3);
}

void Decimation::make(const HeightField& field, const FramePair& pair, const PlaneView& colour, int step) {
    pair_ = pair;
    pair_.prev.frame = decimated_frame(*pair.prev.frame, step, prev_);
    pair_.next.frame = pair.next.frame == pair.prev.frame ? pair_.prev.frame
                                                          : decimated_frame(*pair.next.frame, step, next_);
    scene_ = field.scene();
    scene_.width = pair_.prev.frame->width;
    scene_.height = pair_.prev.frame->height;
    for (double* const each : {&scene_.camera.fx, &scene_.camera.fy, &scene_.camera.cx, &scene_.camera.cy})
        *each /= step;
    field_.emplace(scene_, pair_);
    colour_ = colour;
    if (colour.empty()) return;
    for (int halves = 0; 1 << halves < step; ++halves) {
        std::vector<std::uint8_t>& half = halves_[halves % 2];
        halve_colour(colour_, half);
        const int width = half_of(colour_.width);
        colour_ = {half.data(), std::ptrdiff_t{3} * width, width, half_of(colour_.height), 1, 3};
    }
}

float cut_ratio(int step) {
    float ratio = CUT_RULE_RATIO;
    for (; step > 1; step /= 2) ratio *= ratio;
    return ratio;
}

ViewCamera decimated(ViewCamera camera, int step) {
    camera.clip_from_lattice[0] *= step;
    camera.clip_from_lattice[1] *= step;
    return camera;
}

}  // namespace touchable
