#include "engine/picture/coded_image.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/base/unless_stopped.hpp"
#include "engine/picture/decoded_picture.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/picture_decoder.hpp"
#include "engine/picture/rgb_converter.hpp"

namespace touchable {
namespace {

/// Rows that are copied at once; then their memory goes back, so that a picture is held once and not twice.
constexpr int rows_at_once = 64;

/// A picture whose rows `append(samples, first, count)` adds at the end, false where they are of another
/// kind.
template <class Append>
Result<std::optional<Image>> gathered(const std::string& where, AVFrame& frame, int bytes, int channels,
                                      Append&& append) {
    Image image{frame.width, frame.height, bytes, channels, {}};
    image.samples.reserve(static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height) *
                          static_cast<std::size_t>(bytes * channels));
    for (int first = 0; first < frame.height; first += rows_at_once) {
        if (stop_requested())
            return Error{ErrorKind::interrupted, "interrupted while " + where + " was read"};
        const int count = std::min(rows_at_once, frame.height - first);
        if (!append(image.samples, first, count)) return std::optional<Image>{};
        drop_rows(frame, first, count);
    }
    return std::optional(std::move(image));
}

using Samples = std::vector<std::uint8_t>;

auto packed_grey(const PlaneView& plane) {
    return [plane](Samples& to, int first, int count) {
        const auto row_bytes = static_cast<std::ptrdiff_t>(plane.width) * plane.bytes_per_sample;
        for (int y = first; y < first + count; ++y)
            to.insert(to.end(), plane.row(y), plane.row(y) + row_bytes);
        return true;
    };
}

/// The grey of formats that `grey_samples` does not see: 16 bits as PNG has them (high byte first), grey with
/// alpha, and grey stored as colour of 16 bits, which no colour is.
struct GreyOfPng {
    const AVFrame& frame;
    bool is_colour() const {
        return frame.format == AV_PIX_FMT_RGB48BE || frame.format == AV_PIX_FMT_RGBA64BE;
    }
    bool is_deep() const {
        return frame.format == AV_PIX_FMT_GRAY16BE || frame.format == AV_PIX_FMT_YA16BE || is_colour();
    }
    bool is_it() const { return is_deep() || frame.format == AV_PIX_FMT_YA8; }
    bool operator()(Samples& to, int first, int count) const {
        const bool deep = is_deep(), colour = is_colour();
        const int step =
            (deep ? 2 : 1) * av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format))->nb_components;
        for (int y = first; y < first + count; ++y) {
            const std::uint8_t* from = frame.data[0] + static_cast<std::ptrdiff_t>(frame.linesize[0]) * y;
            for (int x = 0; x < frame.width; ++x, from += step) {
                if (colour && std::memcmp(from, from + 2, 4) != 0) return false;
                const auto sample = static_cast<std::uint16_t>(deep ? from[0] << 8 | from[1] : from[0]);
                const auto bytes = std::bit_cast<std::array<std::uint8_t, 2>>(sample);
                if (deep)
                    to.insert(to.end(), bytes.begin(), bytes.end());
                else
                    to.push_back(from[0]);
            }
        }
        return true;
    }
};

/// Grey of 1 bit, eight pixels a byte, the first one highest.
auto black_and_white(const AVFrame& frame) {
    return [&frame](Samples& to, int first, int count) {
        for (int y = first; y < first + count; ++y) {
            const std::uint8_t* row = frame.data[0] + static_cast<std::ptrdiff_t>(frame.linesize[0]) * y;
            for (int x = 0; x < frame.width; ++x)
                to.push_back((row[x / 8] >> (7 - x % 8) & 1) != 0 ? 255 : 0);
        }
        return true;
    };
}

auto rgb_of(const AVFrame& frame) {
    return [&frame](Samples& to, int first, int count) {
        const Image rows = rgb_rows(frame, first, count);
        to.insert(to.end(), rows.samples.begin(), rows.samples.end());
        return true;
    };
}

/// Nothing of kinds that are not read.
Result<std::optional<Image>> image_of_any(const std::string& where, FramePtr frame) {
    if (frame->format == AV_PIX_FMT_MONOBLACK) return gathered(where, *frame, 1, 1, black_and_white(*frame));
    if (const GreyOfPng grey{*frame}; grey.is_it())
        return gathered(where, *frame, grey.is_deep() ? 2 : 1, 1, grey);
    if (const auto plane = grey_samples(*frame))
        return gathered(where, *frame, plane->bytes_per_sample, 1, packed_grey(*plane));
    if (av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame->format))->comp[0].depth != 8)
        return std::optional<Image>{};
    if (!is_rgb8(*frame)) {
        auto rgb = unless_stopped([frame = std::move(frame)] { return RgbConverter().converted(*frame); });
        if (!rgb) return Error{ErrorKind::interrupted, "interrupted while " + where + " was read"};
        if (!*rgb) return input_error(where + ": " + rgb->error().message);
        frame = std::move(**rgb);
    }
    return gathered(where, *frame, 1, 3, rgb_of(*frame));
}

Result<Image> image_from(const std::string& where, FramePtr frame) {
    const std::string format = format_name(*frame);
    TRY_ASSIGN(auto image, image_of_any(where, std::move(frame)));
    if (image) return std::move(*image);
    return input_error(where + ": has pixel format " + format +
                       "; grey of 8 or 16 bits and colour of 8 bits are read");
}

/// Grey of 1, 2 and 4 bits comes spread over 8.
void gather(Image& image, int bits) {
    const int step = 255 / ((1 << bits) - 1);
    until_stopped(image.samples.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k)
            image.samples[k] = static_cast<std::uint8_t>(image.samples[k] / step);
    });
}

}  // namespace

Result<StoredImage> decode_coded_image(std::string_view bytes, const std::string& where) {
    TRY_ASSIGN(auto picture, decode_picture(bytes, where));
    const std::string format = format_name(*picture.frame);
    TRY_ASSIGN(auto image, image_from(where, std::move(picture.frame)));
    if (picture.bits < 8) gather(image, picture.bits);
    if (stop_requested()) return Error{ErrorKind::interrupted, "interrupted while " + where + " was read"};
    StoredImage stored;
    stored.image = std::move(image);
    stored.codec = avcodec_get_name(picture.codec);
    stored.pixel_format = format;
    stored.bits = picture.bits;
    stored.interlaced = picture.interlaced;
    return stored;
}

Result<Image> decode_indices(std::string_view bytes, const std::string& where) {
    TRY_ASSIGN(auto picture, decode_picture(bytes, where));
    const AVFrame& frame = *picture.frame;
    if (picture.codec == AV_CODEC_ID_PNG && frame.format == AV_PIX_FMT_PAL8) {
        auto indices =
            gathered(where, *picture.frame, 1, 1,
                     packed_grey({frame.data[0], frame.linesize[0], frame.width, frame.height, 1, 1}));
        if (!indices) return indices.error();  // TRY_ASSIGN's move of an optional picture makes GCC 12 warn
        return std::move(**indices);
    }
    TRY_ASSIGN(auto stored, decode_coded_image(bytes, where));
    const Image& image = stored.image;
    if (stored.codec != "png" || image.channels != 1 || image.bytes_per_sample != 1)
        return input_error(where + ": must be a PNG of indices, with a palette or grey of up to 8 bits");
    return std::move(stored.image);
}

}  // namespace touchable
