#include "engine/picture/packed_rgb.hpp"

#include <algorithm>
#include <cstring>
#include <vector>

#include "engine/base/vectors.hpp"

// Loops over plain arrays, which become vectors by themselves: a word for each pixel, then its three bytes.

namespace touchable {
namespace {

/// So many pixels at once, whose words stay in the nearest cache.
constexpr int chunk = 512;

/// The lower three bytes of each word.
[[gnu::always_inline]] inline void store_words(const std::uint32_t* words, int count, std::uint8_t* rgb) {
    using Bytes = std::uint8_t __attribute__((vector_size(16)));
    int x = 0;
    // Four pixels are stored with four bytes beyond them, where the next ones come.
    for (; x + 8 <= count; x += 4) {
        Bytes four;
        std::memcpy(&four, words + x, sizeof(four));
        four = __builtin_shufflevector(four, four, 0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 3, 7, 11, 15);
        std::memcpy(rgb + std::ptrdiff_t{3} * x, &four, sizeof(four));
    }
    for (; x < count; ++x)
        for (int c = 0; c < 3; ++c)
            rgb[std::ptrdiff_t{3} * x + c] = static_cast<std::uint8_t>(words[x] >> (8 * c));
}

/// `words_of(from, count, words)`, which is to be always_inline, makes those of `count` pixels.
template <class WordsOf>
void make_row(VectorUnit unit, int width, std::uint8_t* rgb, const WordsOf& words_of) {
    run_vectors(
        unit, [&](auto) __attribute__((always_inline)) {
            std::uint32_t words[chunk];
            for (int x = 0; x < width; x += chunk) {
                const int count = std::min(chunk, width - x);
                words_of(x, count, words);
                store_words(words, count, rgb + std::ptrdiff_t{3} * x);
            }
        });
}

/// Sums as swscale has them: of 32 bits, which colours that nobody sees go beyond, and are black then.
[[gnu::always_inline]] inline std::uint32_t channel_of(int sum) {
    const int value = static_cast<int>(static_cast<std::uint32_t>(sum) << 6) >> 22;
    const int positive = value < 0 ? 0 : value;
    return static_cast<std::uint32_t>(positive > 255 ? 255 : positive);
}

/// u and v of a row of pixels, in quarters.
struct ChromaRow {
    std::vector<std::int16_t> u, v;
    explicit ChromaRow(int width) : u(static_cast<std::size_t>(width)), v(static_cast<std::size_t>(width)) {}
};

/// A pixel's is nearer to one sample than to the other.
[[gnu::always_inline]] inline void widen(const std::uint8_t* __restrict samples, int count,
                                         std::int16_t* __restrict quarters) {
    quarters[0] = static_cast<std::int16_t>(4 * samples[0]);
    for (int x = 0; x + 1 < count; ++x) {
        const int left = samples[x], right = samples[x + 1];
        quarters[2 * x + 1] = static_cast<std::int16_t>(3 * left + right);
        quarters[2 * x + 2] = static_cast<std::int16_t>(left + 3 * right);
    }
    quarters[2 * count - 1] = static_cast<std::int16_t>(4 * samples[count - 1]);
}

/// The mean of two rows of u and v, which may be the same.
[[gnu::always_inline]] inline void make_words(const std::uint8_t* __restrict y, const ChromaRow& above,
                                              const ChromaRow& below, const YuvFactors& factors, int from,
                                              int count, std::uint32_t* __restrict words) {
    constexpr int grey = 8 * 128, half = 1 << 15;
    const YuvFactors by = factors;
    const std::int16_t *u0 = above.u.data() + from, *u1 = below.u.data() + from, *v0 = above.v.data() + from,
                       *v1 = below.v.data() + from;
    for (int x = 0; x < count; ++x) {
        const int u = u0[x] + u1[x] - grey, v = v0[x] + v1[x] - grey;
        const int bright = (y[x] - by.black) * 8 * by.y + half;
        words[x] = channel_of(bright + v * by.red_of_v) |
                   channel_of(bright + u * by.green_of_u + v * by.green_of_v) << 8 |
                   channel_of(bright + u * by.blue_of_u) << 16;
    }
}

}  // namespace

void join_channels(VectorUnit unit, const std::array<const std::uint8_t*, 3>& channels, int width,
                   std::uint8_t* rgb) {
    using Words = std::uint32_t* __restrict;
    const auto words_of = [&channels](int from, int count, Words words) __attribute__((always_inline)) {
        const std::uint8_t *red = channels[0] + from, *green = channels[1] + from, *blue = channels[2] + from;
        for (int x = 0; x < count; ++x)
            words[x] = std::uint32_t{red[x]} | std::uint32_t{green[x]} << 8 | std::uint32_t{blue[x]} << 16;
    };
    make_row(unit, width, rgb, words_of);
}

void take_channels(VectorUnit unit, const std::uint8_t* pixels, const std::array<int, 3>& places, int width,
                   std::uint8_t* rgb) {
    using Words = std::uint32_t* __restrict;
    const int red = 8 * places[0], green = 8 * places[1], blue = 8 * places[2];
    const auto words_of = [=](int from, int count, Words words) __attribute__((always_inline)) {
        const std::uint8_t* at = pixels + std::ptrdiff_t{4} * from;
        for (int x = 0; x < count; ++x, at += 4) {
            const std::uint32_t pixel = std::uint32_t{at[0]} | std::uint32_t{at[1]} << 8 |
                                        std::uint32_t{at[2]} << 16 | std::uint32_t{at[3]} << 24;
            words[x] = (pixel >> red & 255) | (pixel >> green & 255) << 8 | (pixel >> blue & 255) << 16;
        }
    };
    make_row(unit, width, rgb, words_of);
}

YuvFactors yuv_factors(const int* table, bool full) {
    const auto chroma = [full](int factor) {
        const std::int64_t of_range = full ? std::int64_t{factor} * 224 / 255 : factor;
        return static_cast<int>((of_range + 4) >> 3);
    };
    constexpr int one = 1 << 16;
    YuvFactors factors;
    factors.black = full ? 0 : 16;
    factors.y = ((full ? one : static_cast<int>(std::int64_t{one} * 255 / 219)) + 4) >> 3;
    factors.red_of_v = chroma(table[0]);
    factors.blue_of_u = chroma(table[1]);
    factors.green_of_u = chroma(-table[2]);
    factors.green_of_v = chroma(-table[3]);
    return factors;
}

void convert_yuv420(VectorUnit unit, const Yuv420Picture& picture, const YuvFactors& factors,
                    std::uint8_t* rgb, std::ptrdiff_t stride) {
    ChromaRow row(picture.width), row_before(picture.width);
    ChromaRow *now = &row, *before = &row_before;
    const auto row_of = [&picture](std::size_t plane, int y) {
        return picture.planes[plane] + picture.strides[plane] * y;
    };
    for (int y = 0; y < picture.height; ++y) {
        if (y % 2 == 0) {
            std::swap(now, before);
            run_vectors(
                unit, [&](auto) __attribute__((always_inline)) {
                    widen(row_of(1, y / 2), picture.width / 2, now->u.data());
                    widen(row_of(2, y / 2), picture.width / 2, now->v.data());
                });
        }
        const bool is_between = y > 0 && (y % 2 == 0 || y + 1 == picture.height);
        const ChromaRow &above = is_between ? *before : *now, &below = *now;
        const std::uint8_t* const bright = row_of(0, y);
        const auto words_of = [&](int from, int count, std::uint32_t* words) __attribute__((always_inline)) {
            make_words(bright + from, above, below, factors, from, count, words);
        };
        make_row(unit, picture.width, rgb + stride * y, words_of);
    }
}

}  // namespace touchable
