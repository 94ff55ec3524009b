// SPDX-License-Identifier: Apache-2.0
#pragma once

// FFmpeg's decoded pictures as samples: exact if a format is grey or RGB, otherwise converted.
//
// decode_picture decodes a PNG or JPEG by FFmpeg. grey_samples and luma_samples show a frame's own samples;
// rgb_exact moves bytes of packed, planar and palette RGB; RgbConverter converts any other colour to packed
// RGB of 8 bits, three bytes a pixel: by the CPU's vectors for YUV 4:2:0 (the same bits as swscale's plain C)
// and by swscale otherwise. joined_bytes puts two planes of bytes together to one of 16 bits.
//
// join_channels, take_channels and RgbConverter::convert_yuv420 are the loops of these conversions for one
// vector unit, which tests compare; the functions above choose the unit.
//
// Include it in .cpp files and in private headers: it brings FFmpeg's own.
// Threads: one uses an RgbConverter, any the functions.

#include <array>
#include <memory>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/base/vectors.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// FFmpeg's description of the format.
inline const AVPixFmtDescriptor& pixel_format_of(const AVFrame& frame) {
    return *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
}
/// FFmpeg's name of the format, "gray10le" for one.
std::string format_name(const AVFrame& frame);

/// Bits of a sample of its first component, which may be fewer than its bytes have.
int sample_bits(const AVFrame& frame);

/// True if red, green and blue are stored as 8-bit samples: packed, planar or as a palette.
bool is_rgb8(const AVFrame& frame);

/// The frame's own samples of 8 to 16 bits, host order, of a format that is only grey; nullopt for other
/// formats. Never uses swscale, which squeezes grey into 16..235 if a range tag is missing.
std::optional<PlaneView> grey_samples(const AVFrame& frame);
/// The same, or the luma of a YUV format, which is how some decoders return what was stored as grey.
std::optional<PlaneView> luma_samples(const AVFrame& frame);

/// Joins a grey picture of high bytes and one, as large, of `low_bits` low bits to grey of two bytes. Null:
/// out of memory.
FramePtr joined_bytes(const PlaneView& high, const PlaneView& low, int low_bits = 8);

/// Writes a row of 8-bit RGB by moving bytes; the frame is_rgb8. Alpha is dropped.
void move_rgb_row(const AVFrame& frame, int y, std::uint8_t* rgb);
/// The same for all rows.
Image rgb_exact(const AVFrame& frame);
/// Converts a row of separate red, green and blue, as H.264 has them.
void join_channels(VectorUnit unit, const std::array<const std::uint8_t*, 3>& channels, int width,
                   std::uint8_t* rgb);
/// Converts a row of four bytes a pixel; `places`: which of them are red, green and blue, from 0.
void take_channels(VectorUnit unit, const std::uint8_t* pixels, const std::array<int, 3>& places, int width,
                   std::uint8_t* rgb);

/// Converts any colour format to 8-bit RGB: moves bytes of RGB formats, otherwise rounds. Keeps its setup for
/// frames of one kind.
class RgbConverter {
public:
    /// Returns an RGB24 frame in plane memory.
    Result<FramePtr> converted(const AVFrame& frame);
    /// The same into an RGB24 frame of this size, whose rows may be written up to 64 bytes past their end.
    Result<void> convert(const AVFrame& frame, AVFrame& rgb);

    /// Weights of 8-bit YUV in red, green and blue, in 8192ths.
    struct YuvFactors {
        int black = 0;  ///< the y of black
        int y = 0, red_of_v = 0, green_of_u = 0, green_of_v = 0, blue_of_u = 0;
    };
    /// From swscale's table of a colour space: 65536ths of v in red, of u in blue, of u and v taken from
    /// green, for y from 16 to 235. `full`: y goes from 0 to 255.
    static YuvFactors yuv_factors(const int* table, bool full);
    /// Converts YUV 4:2:0 of 8 bits to RGB, with the same bits as swscale's plain C for RGB24 with bilinear,
    /// accurate, bit-exact and full chroma, since relief in recordings depends on them. u and v are
    /// interpolated from left to right, but vertically only in every second row. Width and height are even
    /// and at least 10: swscale enlarges pictures of other sizes by other filters.
    static void convert_yuv420(VectorUnit unit, const AVFrame& frame, const YuvFactors& factors,
                               std::uint8_t* rgb, std::ptrdiff_t stride);

private:
    bool set_up_for(const AVFrame& frame);
    bool set_up_scaler(const AVFrame& frame);

    ScalerPtr scaler_;                   // null: bytes are only moved, or factors_ is set
    std::optional<YuvFactors> factors_;  // of convert_yuv420
    std::array<int, 5> kind_{};          // of frames that all is set up for: size, format, range, space
};

/// PNG or JPEG by its first bytes. Refused if it is truncated, damaged, or has data for only a part.
Result<FramePtr> decode_picture(std::string_view bytes, const std::string& where);

}  // namespace touchable
