// Against swscale's plain C, which the conversion was before, and against pixels moved one by one.
#include "engine/picture/decoding.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace touchable::test {
namespace {

struct Look {
    int width = 64, height = 32;
    AVPixelFormat format = AV_PIX_FMT_YUV420P;
    AVColorRange range = AVCOL_RANGE_UNSPECIFIED;
    AVColorSpace space = AVCOL_SPC_UNSPECIFIED;
};

/// Every byte by chance, as likely an end of its range as anything else.
FramePtr noise(const Look& look, unsigned seed) {
    FramePtr frame(av_frame_alloc());
    frame->width = look.width;
    frame->height = look.height;
    frame->format = look.format;
    frame->color_range = look.range;
    frame->colorspace = look.space;
    EXPECT_GE(av_frame_get_buffer(frame.get(), 0), 0);
    std::mt19937 random(seed);
    for (const AVBufferRef* buffer : frame->buf)
        if (buffer)
            for (std::size_t k = 0; k < buffer->size; ++k)
                buffer->data[k] =
                    static_cast<std::uint8_t>(random() % 2 == 0 ? random() % 256 : 255 * (random() % 2));
    return frame;
}

using Bytes = std::vector<std::uint8_t>;

Bytes pixels_of(const AVFrame& rgb) {
    Bytes bytes;
    for (int y = 0; y < rgb.height; ++y) {
        const std::uint8_t* row = rgb.data[0] + std::ptrdiff_t{rgb.linesize[0]} * y;
        bytes.insert(bytes.end(), row, row + std::ptrdiff_t{3} * rgb.width);
    }
    return bytes;
}

bool is_full(const Look& look) {
    return look.range == AVCOL_RANGE_UNSPECIFIED ? look.format == AV_PIX_FMT_YUVJ420P
                                                 : look.range == AVCOL_RANGE_JPEG;
}

Bytes by_swscale(const AVFrame& frame, const Look& look) {
    const ScalerPtr scaler(sws_getContext(
        frame.width, frame.height, look.format, frame.width, frame.height, AV_PIX_FMT_RGB24,
        SWS_BILINEAR | SWS_ACCURATE_RND | SWS_BITEXACT | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP, nullptr,
        nullptr, nullptr));
    sws_setColorspaceDetails(scaler.get(), sws_getCoefficients(look.space), is_full(look),
                             sws_getCoefficients(SWS_CS_DEFAULT), 1, 0, 1 << 16, 1 << 16);
    const Look rgb_look{look.width, look.height, AV_PIX_FMT_RGB24};
    const FramePtr rgb = noise(rgb_look, 1);
    EXPECT_EQ(sws_scale(scaler.get(), frame.data, frame.linesize, 0, frame.height, rgb->data, rgb->linesize),
              frame.height);
    return pixels_of(*rgb);
}

Bytes by_vectors(VectorUnit unit, const AVFrame& frame, const Look& look) {
    const std::ptrdiff_t stride = std::ptrdiff_t{3} * frame.width;
    constexpr std::uint8_t untouched = 77;
    Bytes rgb(static_cast<std::size_t>(stride) * static_cast<std::size_t>(frame.height) + 1, untouched);
    const auto factors = RgbConverter::yuv_factors(sws_getCoefficients(look.space), is_full(look));
    RgbConverter::convert_yuv420(unit, frame, factors, rgb.data(), stride);
    EXPECT_EQ(rgb.back(), untouched) << "a byte beyond the picture was written";
    rgb.pop_back();
    return rgb;
}

std::string text_of(const Look& look) {
    return std::to_string(look.width) + "x" + std::to_string(look.height) + " " +
           av_get_pix_fmt_name(look.format) + ", range " + std::to_string(look.range) + ", space " +
           std::to_string(look.space);
}

std::vector<Look> yuv_looks() {
    silence_ffmpeg();
    std::vector<Look> looks;
    for (const auto& [width, height] :
         {std::pair{10, 10}, {12, 46}, {66, 34}, {510, 10}, {514, 12}, {1034, 18}})
        for (const AVPixelFormat format : {AV_PIX_FMT_YUV420P, AV_PIX_FMT_YUVJ420P})
            for (const AVColorRange range : {AVCOL_RANGE_UNSPECIFIED, AVCOL_RANGE_MPEG, AVCOL_RANGE_JPEG})
                for (const AVColorSpace space : {AVCOL_SPC_BT709, AVCOL_SPC_UNSPECIFIED, AVCOL_SPC_FCC,
                                                 AVCOL_SPC_SMPTE240M, AVCOL_SPC_BT2020_NCL})
                    looks.push_back({width, height, format, range, space});
    return looks;
}

TEST(PackedRgb, OfYuv420AreToTheBitWhatSwscaleMakes) {
    unsigned seed = 0;
    for (const Look& look : yuv_looks()) {
        const FramePtr frame = noise(look, ++seed);
        const Bytes expected = by_swscale(*frame, look);
        for (const VectorUnit unit : usable_vector_units())
            ASSERT_EQ(by_vectors(unit, *frame, look), expected)
                << text_of(look) << ", unit " << static_cast<int>(unit);
    }
}

TEST(RgbConverter, GivesTheBitsOfSwscaleForEverySizeAndKeepsNothingOfFramesBefore) {
    RgbConverter converter;
    unsigned seed = 0;
    for (const auto& [width, height] :
         {std::pair{2, 2}, {8, 8}, {8, 64}, {64, 8}, {9, 11}, {33, 32}, {32, 33}, {10, 10}, {64, 48}})
        for (const AVColorRange range : {AVCOL_RANGE_MPEG, AVCOL_RANGE_JPEG})
            for (const AVPixelFormat format : {AV_PIX_FMT_YUV420P, AV_PIX_FMT_YUV444P, AV_PIX_FMT_NV12}) {
                const Look look{width, height, format, range, AVCOL_SPC_BT709};
                const FramePtr frame = noise(look, ++seed);
                const auto rgb = converter.converted(*frame);
                ASSERT_TRUE(rgb) << rgb.error().message;
                ASSERT_EQ(pixels_of(**rgb), by_swscale(*frame, look)) << text_of(look);
            }
}

TEST(RgbConverter, IsAsBeforeAfterAFrameThatCannotBeConverted) {
    RgbConverter converter;
    const FramePtr frame = noise({}, 1);
    const auto before = converter.converted(*frame);
    ASSERT_TRUE(before);
    // Nobody fills one of these; what matters is its format.
    const FramePtr other(av_frame_alloc());
    other->width = frame->width;
    other->height = frame->height;
    other->format = AV_PIX_FMT_VAAPI;
    EXPECT_FALSE(converter.converted(*other));
    const auto after = converter.converted(*frame);
    ASSERT_TRUE(after);
    EXPECT_EQ(pixels_of(**after), pixels_of(**before));
}

TEST(RgbConverter, MovesBytesOfEveryOrderOfChannels) {
    unsigned seed = 0;
    for (const AVPixelFormat format : {AV_PIX_FMT_GBRP, AV_PIX_FMT_GBRAP, AV_PIX_FMT_RGB24, AV_PIX_FMT_BGR24,
                                       AV_PIX_FMT_BGR0, AV_PIX_FMT_RGB0, AV_PIX_FMT_0RGB, AV_PIX_FMT_0BGR,
                                       AV_PIX_FMT_RGBA, AV_PIX_FMT_ARGB, AV_PIX_FMT_PAL8})
        for (const int width : {1, 7, 8, 9, 511, 513}) {
            const FramePtr frame = noise({width, 5, format}, ++seed);
            const bool is_palette = format == AV_PIX_FMT_PAL8;
            Bytes expected;
            for (int y = 0; y < frame->height; ++y)
                for (int x = 0; x < width; ++x)
                    for (int c = 0; c < 3; ++c) {
                        const auto& samples = av_pix_fmt_desc_get(format)->comp[is_palette ? 0 : c];
                        const std::uint8_t sample =
                            frame->data[samples.plane][frame->linesize[samples.plane] * y + samples.step * x +
                                                       samples.offset];
                        if (!is_palette) {
                            expected.push_back(sample);
                            continue;
                        }
                        std::uint32_t entry;
                        std::memcpy(&entry, frame->data[1] + std::ptrdiff_t{4} * sample, 4);
                        expected.push_back(static_cast<std::uint8_t>(entry >> (16 - 8 * c)));
                    }
            RgbConverter converter;
            const auto rgb = converter.converted(*frame);
            ASSERT_TRUE(rgb) << rgb.error().message;
            ASSERT_EQ(pixels_of(**rgb), expected) << text_of({width, 5, format});
            ASSERT_EQ(rgb_exact(*frame).samples, expected) << text_of({width, 5, format});
        }
}

TEST(PackedRgb, OfEveryUnitAreTheSame) {
    const FramePtr frame = noise({521, 2, AV_PIX_FMT_BGR0}, 3);
    const std::uint8_t* const row = frame->data[0];
    const int width = frame->width;
    for (const VectorUnit unit : usable_vector_units()) {
        Bytes taken(static_cast<std::size_t>(3 * width)), joined = taken, expected_taken, expected_joined;
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c) {
                expected_taken.push_back(row[4 * x + 2 - c]);
                expected_joined.push_back(row[c * width + x]);
            }
        take_channels(unit, row, {2, 1, 0}, width, taken.data());
        join_channels(unit, {row, row + width, row + std::ptrdiff_t{2} * width}, width, joined.data());
        EXPECT_EQ(taken, expected_taken) << "unit " << static_cast<int>(unit);
        EXPECT_EQ(joined, expected_joined) << "unit " << static_cast<int>(unit);
    }
}

}  // namespace
}  // namespace touchable::test
