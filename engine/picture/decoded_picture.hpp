#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image_file.hpp"
#include "engine/scene/plane_view.hpp"

namespace touchable {

/// FFmpeg's name of the format, "gray10le" for one.
std::string format_name(const AVFrame& frame);

/// Bits of a sample of its first component, which may be fewer than its bytes have.
int sample_bits(const AVFrame& frame);

/// True where red, green and blue are stored as 8-bit samples: packed, planar or as a palette.
bool is_rgb8(const AVFrame& frame);

/// The frame's own samples of 8 to 16 bits, host order, of a format that is only grey; nothing for other
/// formats. Never through swscale, which squeezes grey into 16..235 where a range tag is missing.
std::optional<PlaneView> grey_samples(const AVFrame& frame);
/// The same, or the luma of a YUV format, which is how some decoders return what was stored as grey.
std::optional<PlaneView> luma_samples(const AVFrame& frame);

/// Samples of two bytes, from a grey picture of their high bytes and one, as large, of their `low_bits` low
/// bits.
Image joined_bytes(const PlaneView& high, const PlaneView& low, int low_bits = 8);

/// A row of 8-bit RGB by moving bytes; the frame is_rgb8. Alpha is dropped.
void move_rgb_row(const AVFrame& frame, int y, std::uint8_t* rgb);
/// The same of all rows.
Image rgb_exact(const AVFrame& frame);
/// The same of `count` rows from `first` on.
Image rgb_rows(const AVFrame& frame, int first, int count);

/// Gives these rows' memory back to the system, as far as it is whole pages: nobody may read them again. Of
/// a frame that nobody else has.
void drop_rows(AVFrame& frame, int first, int count);

}  // namespace touchable
