// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/base/vectors.hpp"
#include "engine/picture/decoding.hpp"

namespace touchable {

namespace {

using YuvFactors = RgbConverter::YuvFactors;

// Loops over plain arrays, which the compiler vectorises: a word for each pixel, then its three bytes.

/// Pixels converted at once, whose words stay in the nearest cache.
constexpr int chunk = 512;

/// Stores the lower three bytes of each word.
[[gnu::always_inline]] inline void store_words(const std::uint32_t* words, int count, std::uint8_t* rgb) {
    using Bytes = std::uint8_t __attribute__((vector_size(16)));
    int x = 0;
    // Four pixels are stored with four more bytes, which the next ones overwrite.
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

/// Clamps a sum as swscale does: in 32 bits, which invisible colours exceed; these become black.
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

/// Interpolates chroma for pixels, each nearer to one sample than to the other.
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

/// Takes the mean of two rows of u and v, which may be the same.
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

bool is_yuv420(const AVFrame& frame) {
    return (frame.format == AV_PIX_FMT_YUV420P || frame.format == AV_PIX_FMT_YUVJ420P) &&
           frame.width % 2 == 0 && frame.height % 2 == 0 && frame.width >= 10 && frame.height >= 10;
}

/// What a conversion depends on, beside samples.
std::array<int, 5> kind_of(const AVFrame& frame) {
    return {frame.width, frame.height, frame.format, frame.color_range, frame.colorspace};
}

/// Whether black and white are 0 and 255, as a range tag or the format says.
bool is_full_range(const AVFrame& frame) {
    return frame.color_range == AVCOL_RANGE_UNSPECIFIED ? frame.format == AV_PIX_FMT_YUVJ420P
                                                        : frame.color_range == AVCOL_RANGE_JPEG;
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

RgbConverter::YuvFactors RgbConverter::yuv_factors(const int* table, bool full) {
    const auto chroma = [full](int factor) {
        const std::int64_t of_range = full ? std::int64_t{factor} * 224 / 255 : factor;
        return static_cast<int>((of_range + 4) >> 3);
    };
    constexpr int one = 1 << 16;
    return {.black = full ? 0 : 16,
            .y = ((full ? one : static_cast<int>(std::int64_t{one} * 255 / 219)) + 4) >> 3,
            .red_of_v = chroma(table[0]),
            .green_of_u = chroma(-table[2]),
            .green_of_v = chroma(-table[3]),
            .blue_of_u = chroma(table[1])};
}

void RgbConverter::convert_yuv420(VectorUnit unit, const AVFrame& frame, const YuvFactors& factors,
                                  std::uint8_t* rgb, std::ptrdiff_t stride) {
    const int width = frame.width, height = frame.height;
    ChromaRow row(width), row_before(width);
    ChromaRow *now = &row, *before = &row_before;
    const auto row_of = [&frame](int plane, int y) {
        return frame.data[plane] + std::ptrdiff_t{frame.linesize[plane]} * y;
    };
    for (int y = 0; y < height; ++y) {
        if (y % 2 == 0) {
            std::swap(now, before);
            run_vectors(
                unit, [&](auto) __attribute__((always_inline)) {
                    widen(row_of(1, y / 2), width / 2, now->u.data());
                    widen(row_of(2, y / 2), width / 2, now->v.data());
                });
        }
        const bool is_between = y > 0 && (y % 2 == 0 || y + 1 == height);
        const ChromaRow &above = is_between ? *before : *now, &below = *now;
        const std::uint8_t* const bright = row_of(0, y);
        const auto words_of = [&](int from, int count, std::uint32_t* words) __attribute__((always_inline)) {
            make_words(bright + from, above, below, factors, from, count, words);
        };
        make_row(unit, width, rgb + stride * y, words_of);
    }
}

bool RgbConverter::set_up_for(const AVFrame& frame) {
    kind_ = {};  // nothing is set up if this fails
    scaler_.reset();
    factors_.reset();
    if (is_yuv420(frame))
        factors_ = yuv_factors(sws_getCoefficients(frame.colorspace), is_full_range(frame));
    else if (!is_rgb8(frame) && !set_up_scaler(frame))
        return false;
    kind_ = kind_of(frame);
    return true;
}

bool RgbConverter::set_up_scaler(const AVFrame& frame) {
    const auto format = static_cast<AVPixelFormat>(frame.format);
    if (!sws_isSupportedInput(format)) return false;
    scaler_.reset(sws_getContext(
        frame.width, frame.height, format, frame.width, frame.height, AV_PIX_FMT_RGB24,
        SWS_BILINEAR | SWS_ACCURATE_RND | SWS_BITEXACT | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP, nullptr,
        nullptr, nullptr));
    if (!scaler_) return false;
    int *inverse = nullptr, *forward = nullptr;
    int source_full = 0, target_full = 0, brightness = 0, contrast = 0, saturation = 0;
    if (sws_getColorspaceDetails(scaler_.get(), &inverse, &source_full, &forward, &target_full, &brightness,
                                 &contrast, &saturation) >= 0) {
        if (frame.color_range != AVCOL_RANGE_UNSPECIFIED)
            source_full = frame.color_range == AVCOL_RANGE_JPEG ? 1 : 0;
        sws_setColorspaceDetails(scaler_.get(), sws_getCoefficients(frame.colorspace), source_full, forward,
                                 1, brightness, contrast, saturation);
    }
    return true;
}

Result<FramePtr> RgbConverter::converted(const AVFrame& frame) {
    FramePtr rgb = plane_picture(AV_PIX_FMT_RGB24, frame.width, frame.height);
    if (!rgb) return memory_error();
    TRY(convert(frame, *rgb));
    return rgb;
}

Result<void> RgbConverter::convert(const AVFrame& frame, AVFrame& rgb) {
    const Error unsupported =
        input_error("pixel format " + format_name(frame) + " cannot be turned into RGB");
    if (kind_of(frame) != kind_ && !set_up_for(frame)) return unsupported;
    if (factors_) {
        convert_yuv420(usable_vector_units().front(), frame, *factors_, rgb.data[0], rgb.linesize[0]);
    } else if (!scaler_) {
        for (int y = 0; y < frame.height; ++y)
            move_rgb_row(frame, y, rgb.data[0] + std::ptrdiff_t{rgb.linesize[0]} * y);
    } else if (sws_scale(scaler_.get(), frame.data, frame.linesize, 0, frame.height, rgb.data,
                         rgb.linesize) != frame.height) {
        return unsupported;
    }
    return {};
}

}  // namespace touchable
