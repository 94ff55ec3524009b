#include "bench/media/packed_picture.hpp"

#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <unordered_map>

namespace touchable {
namespace {

std::uint8_t* line_of(const AVFrame& picture, int y, int plane = 0) {
    return picture.data[plane] + std::ptrdiff_t{picture.linesize[plane]} * y;
}

bool is_yuv(AVPixelFormat format) {
    return format == AV_PIX_FMT_YUV444P || format == AV_PIX_FMT_YUV420P;
}

void swap_bytes(const std::uint8_t* from, int width, std::uint8_t* to) {
    for (int x = 0; x < width; ++x) {
        to[2 * x] = from[2 * x + 1];
        to[2 * x + 1] = from[2 * x];
    }
}

void split(const std::uint8_t* from, int width, std::uint8_t* high, std::uint8_t* low) {
    for (int x = 0; x < width; ++x) {
        low[x] = from[2 * x];
        high[x] = from[2 * x + 1];
    }
}

void join(const std::uint8_t* high, const std::uint8_t* low, int width, std::uint8_t* to) {
    for (int x = 0; x < width; ++x) {
        to[2 * x] = low[x];
        to[2 * x + 1] = high[x];
    }
}

/// Bytes per pixel, and the offsets of red, green and blue.
struct RgbOrder {
    int step, red, green, blue;
};

void reorder(const std::uint8_t* from, RgbOrder in, int width, std::uint8_t* to, RgbOrder out) {
    for (int x = 0; x < width; ++x, from += in.step, to += out.step) {
        to[out.red] = from[in.red];
        to[out.green] = from[in.green];
        to[out.blue] = from[in.blue];
        if (out.step == 4) to[3] = 0;
    }
}

void interleave(const AVFrame& gbr, int y, std::uint8_t* to) {
    const std::uint8_t *green = line_of(gbr, y, 0), *blue = line_of(gbr, y, 1), *red = line_of(gbr, y, 2);
    for (int x = 0; x < gbr.width; ++x, to += 3) {
        to[0] = red[x];
        to[1] = green[x];
        to[2] = blue[x];
    }
}

Error no_scaler() {
    return {ErrorKind::internal, "FFmpeg makes no converter of colours"};
}

Result<void> convert(const std::uint8_t* const* from, const int* from_stride, AVPixelFormat from_format,
                     std::uint8_t* const* to, const int* to_stride, AVPixelFormat to_format, int width,
                     int height, ScalerPtr& scaler) {
    if (!scaler)
        scaler.reset(sws_getContext(width, height, from_format, width, height, to_format,
                                    SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP,
                                    nullptr, nullptr, nullptr));
    if (!scaler || sws_scale(scaler.get(), from, from_stride, 0, height, to, to_stride) != height)
        return no_scaler();
    return {};
}

/// Stores the plane as indices into its colours, in order of appearance.
Result<void> index(const PlaneView& plane, AVFrame& picture) {
    std::unordered_map<std::uint32_t, std::uint8_t> colours;
    std::array<std::uint32_t, 256> palette{};
    for (int y = 0; y < plane.height; ++y)
        for (int x = 0; x < plane.width; ++x) {
            const std::uint8_t* pixel = plane.row(y) + 3 * std::ptrdiff_t{x};
            const std::uint32_t colour = 0xFF000000U | static_cast<std::uint32_t>(pixel[0]) << 16U |
                                         static_cast<std::uint32_t>(pixel[1]) << 8U | pixel[2];
            auto known = colours.find(colour);
            if (known == colours.end()) {
                if (colours.size() == palette.size()) return usage_error("a plane has more than 256 colours");
                palette[colours.size()] = colour;
                known = colours.emplace(colour, static_cast<std::uint8_t>(colours.size())).first;
            }
            line_of(picture, y)[x] = known->second;
        }
    std::memcpy(picture.data[1], palette.data(), sizeof palette);
    return {};
}

void look_up(const AVFrame& picture, int y, std::uint8_t* to) {
    for (int x = 0; x < picture.width; ++x, to += 3) {
        std::uint32_t colour;
        std::memcpy(&colour, picture.data[1] + 4 * std::ptrdiff_t{line_of(picture, y)[x]}, 4);
        to[0] = static_cast<std::uint8_t>(colour >> 16U);
        to[1] = static_cast<std::uint8_t>(colour >> 8U);
        to[2] = static_cast<std::uint8_t>(colour);
    }
}

constexpr RgbOrder rgb24{3, 0, 1, 2}, bgr24{3, 2, 1, 0}, bgr0{4, 2, 1, 0};

}  // namespace

Result<void> pack(const PlaneView& plane, const PicturePacking& packing, ScalerPtr& scaler,
                  AVFrame& picture) {
    static_assert(std::endian::native == std::endian::little,
                  "samples are taken apart as they lie in memory");
    if (is_yuv(packing.format)) {
        const int stride = static_cast<int>(plane.stride);
        return convert(&plane.data, &stride, AV_PIX_FMT_RGB24, picture.data, picture.linesize, packing.format,
                       plane.width, plane.height, scaler);
    }
    if (packing.format == AV_PIX_FMT_PAL8) return index(plane, picture);
    for (int y = 0; y < plane.height; ++y) {
        const std::uint8_t* from = plane.row(y);
        std::uint8_t* to = line_of(picture, y);
        if (packing.halves)
            split(from, plane.width, to, line_of(picture, plane.height + y));
        else if (packing.format == AV_PIX_FMT_GRAY16BE)
            swap_bytes(from, plane.width, to);
        else if (packing.format == AV_PIX_FMT_BGR0)
            reorder(from, rgb24, plane.width, to, bgr0);
        else
            std::memcpy(to, from,
                        static_cast<std::size_t>(plane.width * plane.channels * plane.bytes_per_sample));
    }
    return {};
}

/// A plane in the unpacker's memory.
PlaneView Unpacker::own() {
    PlaneView plane = form_;
    plane.stride = std::ptrdiff_t{form_.width} * form_.channels * form_.bytes_per_sample;
    samples_.resize(static_cast<std::size_t>(plane.stride) * static_cast<std::size_t>(form_.height));
    plane.data = samples_.data();
    return plane;
}

Result<PlaneView> Unpacker::plane(const AVFrame& picture) {
    const int height = packing_.halves ? 2 * form_.height : form_.height;
    if (picture.width != form_.width || picture.height != height)
        return Error{ErrorKind::check, "a picture came back in another size"};
    const auto format = static_cast<AVPixelFormat>(picture.format);
    // Grey and plain RGB are used in place. FFmpeg decodes grey H.264 to YUV with meaningless chroma.
    const bool as_it_is = form_.channels == 3 ? format == AV_PIX_FMT_RGB24
                                              : !packing_.halves && packing_.format != AV_PIX_FMT_GRAY16BE;
    if (as_it_is) {
        PlaneView plane = form_;
        plane.data = picture.data[0];
        plane.stride = picture.linesize[0];
        return plane;
    }
    const PlaneView plane = own();
    if (is_yuv(packing_.format)) {
        std::uint8_t* const to = samples_.data();
        const int stride = static_cast<int>(plane.stride);
        if (auto done = convert(picture.data, picture.linesize, format, &to, &stride, AV_PIX_FMT_RGB24,
                                form_.width, form_.height, scaler_);
            !done)
            return done.error();
        return plane;
    }
    for (int y = 0; y < form_.height; ++y) {
        std::uint8_t* to = samples_.data() + plane.stride * y;
        if (packing_.halves)
            join(line_of(picture, y), line_of(picture, form_.height + y), form_.width, to);
        else if (packing_.format == AV_PIX_FMT_GRAY16BE)
            swap_bytes(line_of(picture, y), form_.width, to);
        else if (format == AV_PIX_FMT_GBRP)
            interleave(picture, y, to);
        else if (format == AV_PIX_FMT_PAL8)
            look_up(picture, y, to);
        else if (format == AV_PIX_FMT_BGR0 || format == AV_PIX_FMT_BGRA)
            reorder(line_of(picture, y), bgr0, form_.width, to, rgb24);
        else if (format == AV_PIX_FMT_BGR24)
            reorder(line_of(picture, y), bgr24, form_.width, to, rgb24);
        else
            return Error{ErrorKind::internal,
                         std::string("a picture came back as ") + av_get_pix_fmt_name(format)};
    }
    return plane;
}

}  // namespace touchable
