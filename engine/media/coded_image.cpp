#include "engine/media/coded_image.hpp"

#include <cstring>
#include <optional>
#include <utility>

#include "engine/media/decoded_picture.hpp"
#include "engine/media/ffmpeg.hpp"
#include "engine/media/picture_decoder.hpp"

namespace touchable {
namespace {

Image packed_grey(const PlaneView& plane) {
    const auto row_bytes = static_cast<std::size_t>(plane.width * plane.bytes_per_sample);
    Image image{plane.width, plane.height, plane.bytes_per_sample, 1, {}};
    image.samples.resize(row_bytes * static_cast<std::size_t>(plane.height));
    for (int y = 0; y < plane.height; ++y)
        std::memcpy(image.samples.data() + row_bytes * static_cast<std::size_t>(y), plane.row(y), row_bytes);
    return image;
}

/// The grey of formats that `grey_samples` does not see: 16 bits as PNG has them (high byte first), grey with
/// alpha, and grey stored as colour of 16 bits. Nothing for other formats, and for colour.
std::optional<Image> grey_of_png(const AVFrame& frame) {
    const bool colour = frame.format == AV_PIX_FMT_RGB48BE || frame.format == AV_PIX_FMT_RGBA64BE;
    const bool deep = frame.format == AV_PIX_FMT_GRAY16BE || frame.format == AV_PIX_FMT_YA16BE || colour;
    if (!deep && frame.format != AV_PIX_FMT_YA8) return std::nullopt;
    const int bytes = deep ? 2 : 1,
              step = bytes * av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format))->nb_components;
    Image image{frame.width, frame.height, bytes, 1, {}};
    image.samples.resize(static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height) *
                         static_cast<std::size_t>(bytes));
    std::uint8_t* to = image.samples.data();
    for (int y = 0; y < frame.height; ++y) {
        const std::uint8_t* from = frame.data[0] + static_cast<std::ptrdiff_t>(frame.linesize[0]) * y;
        for (int x = 0; x < frame.width; ++x, from += step, to += bytes) {
            if (colour && std::memcmp(from, from + 2, 4) != 0) return std::nullopt;
            const auto sample = static_cast<std::uint16_t>(deep ? from[0] << 8 | from[1] : from[0]);
            if (deep)
                std::memcpy(to, &sample, 2);
            else
                *to = from[0];
        }
    }
    return image;
}

/// Grey of 1 bit, eight pixels a byte, the first one highest.
std::optional<Image> black_and_white(const AVFrame& frame) {
    if (frame.format != AV_PIX_FMT_MONOBLACK) return std::nullopt;
    Image image{frame.width, frame.height, 1, 1, {}};
    for (int y = 0; y < frame.height; ++y) {
        const std::uint8_t* row = frame.data[0] + static_cast<std::ptrdiff_t>(frame.linesize[0]) * y;
        for (int x = 0; x < frame.width; ++x)
            image.samples.push_back((row[x / 8] >> (7 - x % 8) & 1) != 0 ? 255 : 0);
    }
    return image;
}

Result<Image> image_from(const std::string& where, const AVFrame& frame) {
    if (auto mask = black_and_white(frame)) return std::move(*mask);
    if (auto grey = grey_of_png(frame)) return std::move(*grey);
    if (const auto plane = grey_samples(frame)) return packed_grey(*plane);
    const AVPixFmtDescriptor& format = *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
    if (format.comp[0].depth == 8) {
        auto rgb = rgb_converted(frame);
        return rgb ? std::move(rgb) : input_error(where + ": " + rgb.error().message);
    }
    return input_error(where + ": has pixel format " + format_name(frame) +
                       "; grey of 8 or 16 bits and colour of 8 bits are read");
}

/// Grey of 1, 2 and 4 bits comes spread over 8.
void gather(Image& image, int bits) {
    const int step = 255 / ((1 << bits) - 1);
    for (std::uint8_t& sample : image.samples) sample = static_cast<std::uint8_t>(sample / step);
}

}  // namespace

Result<StoredImage> decode_coded_image(std::string_view bytes, const std::string& where) {
    const auto picture = decode_picture(bytes, where);
    if (!picture) return picture.error();
    auto image = image_from(where, *picture->frame);
    if (!image) return image.error();
    if (picture->bits < 8) gather(*image, picture->bits);
    StoredImage stored;
    stored.image = std::move(*image);
    stored.codec = avcodec_get_name(picture->codec);
    stored.pixel_format = format_name(*picture->frame);
    stored.bits = picture->bits;
    stored.interlaced = picture->interlaced;
    return stored;
}

}  // namespace touchable
