#include "engine/picture/decoded_picture.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

namespace touchable {
namespace {

constexpr bool host_is_big_endian = std::endian::native == std::endian::big;

const AVPixFmtDescriptor& descriptor(const AVFrame& frame) {
    return *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
}

Image rgb_of_size(int width, int height) {
    Image image{width, height, 1, 3, {}};
    image.samples.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
    return image;
}

/// swscale may write whole vectors past a row's end, so rows have room for that.
constexpr int vector_bytes = 64;
int rgb_stride(int width) {
    return (3 * width + vector_bytes - 1) / vector_bytes * vector_bytes;
}

std::uint8_t* row_of(Image& image, int y) {
    return image.samples.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) * 3;
}

Image rgb_of_palette(const AVFrame& frame, int first, int count) {
    Image image = rgb_of_size(frame.width, count);
    for (int y = 0; y < count; ++y) {
        const std::uint8_t* from =
            frame.data[0] + static_cast<std::ptrdiff_t>(frame.linesize[0]) * (first + y);
        std::uint8_t* to = row_of(image, y);
        for (int x = 0; x < frame.width; ++x, to += 3) {
            std::uint32_t entry;  // 0xAARRGGBB in host order
            std::memcpy(&entry, frame.data[1] + 4 * std::size_t{from[x]}, 4);
            for (int c = 0; c < 3; ++c) to[c] = static_cast<std::uint8_t>(entry >> (16 - 8 * c));
        }
    }
    return image;
}

/// As H.264 has it; apart from the general way because it is quicker.
Image rgb_of_planes(const AVFrame& frame, int first, int count) {
    Image image = rgb_of_size(frame.width, count);
    for (int y = 0; y < count; ++y) {
        const std::uint8_t* planes[3];
        for (int c = 0; c < 3; ++c)
            planes[c] = frame.data[c] + static_cast<std::ptrdiff_t>(frame.linesize[c]) * (first + y);
        std::uint8_t* to = row_of(image, y);
        for (int x = 0; x < frame.width; ++x, to += 3) {
            to[0] = planes[2][x];
            to[1] = planes[0][x];
            to[2] = planes[1][x];
        }
    }
    return image;
}

std::optional<PlaneView> first_plane(const AVFrame& frame) {
    const AVPixFmtDescriptor& format = descriptor(frame);
    const AVComponentDescriptor& samples = format.comp[0];
    const int bytes = samples.depth > 8 ? 2 : 1;
    constexpr std::uint64_t other = AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BITSTREAM |
                                    AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_FLOAT | AV_PIX_FMT_FLAG_BAYER;
    const bool big_endian = (format.flags & AV_PIX_FMT_FLAG_BE) != 0;
    if ((format.flags & other) != 0 || (bytes == 2 && big_endian != host_is_big_endian)) return std::nullopt;
    if (samples.plane != 0 || samples.offset != 0 || samples.step != bytes || samples.shift != 0 ||
        samples.depth < 8 || samples.depth > 16)
        return std::nullopt;
    return PlaneView{frame.data[0], frame.linesize[0], frame.width, frame.height, bytes, 1};
}

}  // namespace

std::string format_name(const AVFrame& frame) {
    const char* name = av_get_pix_fmt_name(static_cast<AVPixelFormat>(frame.format));
    return name ? name : "unknown";
}

int sample_bits(const AVFrame& frame) {
    return descriptor(frame).comp[0].depth;
}

bool is_rgb8(const AVFrame& frame) {
    const AVPixFmtDescriptor& format = descriptor(frame);
    if (frame.format == AV_PIX_FMT_PAL8) return true;
    if ((format.flags & AV_PIX_FMT_FLAG_RGB) == 0 || format.nb_components < 3) return false;
    if ((format.flags & (AV_PIX_FMT_FLAG_BITSTREAM | AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_BAYER |
                         AV_PIX_FMT_FLAG_FLOAT)) != 0)
        return false;
    for (int c = 0; c < 3; ++c)
        if (format.comp[c].depth != 8 || format.comp[c].shift != 0) return false;
    return true;
}

std::optional<PlaneView> grey_samples(const AVFrame& frame) {
    return descriptor(frame).nb_components == 1 ? first_plane(frame) : std::nullopt;
}

std::optional<PlaneView> luma_samples(const AVFrame& frame) {
    return first_plane(frame);
}

Image joined_bytes(const PlaneView& high, const PlaneView& low, int low_bits) {
    const std::size_t row_bytes = static_cast<std::size_t>(high.width) * 2;
    Image image{high.width, high.height, 2, 1, {}};
    image.samples.resize(row_bytes * static_cast<std::size_t>(high.height));
    for (int y = 0; y < high.height; ++y) {
        const std::uint8_t *above = high.row(y), *below = low.row(y);
        std::uint8_t* to = image.samples.data() + row_bytes * static_cast<std::size_t>(y);
        for (int x = 0; x < high.width; ++x) {
            const auto sample = static_cast<std::uint16_t>(above[x] << low_bits | below[x]);
            std::memcpy(to + 2 * x, &sample, 2);
        }
    }
    return image;
}

Image rgb_exact(const AVFrame& frame) {
    return rgb_rows(frame, 0, frame.height);
}

Image rgb_rows(const AVFrame& frame, int first, int count) {
    if (frame.format == AV_PIX_FMT_PAL8) return rgb_of_palette(frame, first, count);
    if (frame.format == AV_PIX_FMT_GBRP) return rgb_of_planes(frame, first, count);
    const AVPixFmtDescriptor& format = descriptor(frame);
    Image image = rgb_of_size(frame.width, count);
    for (int c = 0; c < 3; ++c) {
        const AVComponentDescriptor& samples = format.comp[c];
        const std::ptrdiff_t stride = frame.linesize[samples.plane], step = samples.step;
        for (int y = 0; y < count; ++y) {
            const std::uint8_t* from = frame.data[samples.plane] + stride * (first + y) + samples.offset;
            std::uint8_t* to = row_of(image, y) + c;
            for (int x = 0; x < frame.width; ++x) to[3 * x] = from[step * x];
        }
    }
    return image;
}

void drop_rows(AVFrame& frame, int first, int count) {
    static const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    const AVPixFmtDescriptor& format = descriptor(frame);
    const bool has_palette = (format.flags & AV_PIX_FMT_FLAG_PAL) != 0;
    if (format.log2_chroma_h != 0) return;  // rows of other planes are not these
    for (int plane = 0; plane < (has_palette ? 1 : AV_NUM_DATA_POINTERS) && frame.data[plane]; ++plane) {
        const auto stride = static_cast<std::uintptr_t>(std::max(frame.linesize[plane], 0));
        const auto begin = std::bit_cast<std::uintptr_t>(frame.data[plane]) +
                           stride * static_cast<std::uintptr_t>(first),
                   end = begin + stride * static_cast<std::uintptr_t>(count);
        const auto first_page = (begin + page - 1) / page * page, last_page = end / page * page;
        if (first_page < last_page)
            madvise(std::bit_cast<void*>(first_page), last_page - first_page, MADV_DONTNEED);
    }
}

bool RgbConverter::set_up_for(const AVFrame& frame) {
    if (scaler_ && frame.width == width_ && frame.height == height_ && frame.format == format_ &&
        frame.color_range == range_ && frame.colorspace == space_)
        return true;
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
    pool_.reset(av_buffer_pool_init(static_cast<std::size_t>(rgb_stride(frame.width)) *
                                            static_cast<std::size_t>(frame.height) +
                                        vector_bytes,
                                    nullptr),
                [](AVBufferPool* pool) { av_buffer_pool_uninit(&pool); });
    width_ = frame.width;
    height_ = frame.height;
    format_ = frame.format;
    range_ = frame.color_range;
    space_ = frame.colorspace;
    return true;
}

/// Null: out of memory.
FramePtr RgbConverter::new_rgb() const {
    FramePtr rgb(av_frame_alloc());
    if (!rgb || !pool_) return nullptr;
    rgb->format = AV_PIX_FMT_RGB24;
    rgb->width = width_;
    rgb->height = height_;
    rgb->linesize[0] = rgb_stride(width_);
    rgb->buf[0] = av_buffer_pool_get(pool_.get());
    if (rgb->buf[0] == nullptr) return nullptr;
    rgb->data[0] = rgb->buf[0]->data;
    rgb->extended_data = rgb->data;
    return rgb;
}

Result<FramePtr> RgbConverter::converted(const AVFrame& frame) {
    const Error unsupported =
        input_error("pixel format " + format_name(frame) + " cannot be turned into RGB");
    if (!set_up_for(frame)) return unsupported;
    FramePtr rgb = new_rgb();
    if (!rgb) return Error{ErrorKind::internal, "out of memory"};
    if (sws_scale(scaler_.get(), frame.data, frame.linesize, 0, frame.height, rgb->data, rgb->linesize) !=
        frame.height)
        return unsupported;
    return rgb;
}

Result<Image> rgb_converted(const AVFrame& frame) {
    if (is_rgb8(frame)) return rgb_exact(frame);
    const auto rgb = RgbConverter().converted(frame);
    if (!rgb) return rgb.error();
    return rgb_exact(**rgb);
}

}  // namespace touchable
