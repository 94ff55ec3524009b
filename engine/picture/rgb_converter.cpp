#include "engine/picture/rgb_converter.hpp"

#include <cstddef>
#include <cstdint>

#include "engine/base/try.hpp"
#include "engine/picture/decoded_picture.hpp"

namespace touchable {
namespace {

/// swscale may write whole vectors past a row's end, so rows have room for that.
constexpr int vector_bytes = 64;
int rgb_stride(int width) {
    return (3 * width + vector_bytes - 1) / vector_bytes * vector_bytes;
}

bool is_yuv420(const AVFrame& frame) {
    return (frame.format == AV_PIX_FMT_YUV420P || frame.format == AV_PIX_FMT_YUVJ420P) &&
           is_converted(frame.width, frame.height);
}

/// Whether black and white are 0 and 255, as a range tag or the format says.
bool is_full_range(const AVFrame& frame) {
    return frame.color_range == AVCOL_RANGE_UNSPECIFIED ? frame.format == AV_PIX_FMT_YUVJ420P
                                                        : frame.color_range == AVCOL_RANGE_JPEG;
}

void convert(const AVFrame& frame, const YuvFactors& factors, AVFrame& rgb) {
    Yuv420Picture picture{.width = frame.width, .height = frame.height};
    for (std::size_t n = 0; n < 3; ++n) {
        picture.planes[n] = frame.data[n];
        picture.strides[n] = frame.linesize[n];
    }
    convert_yuv420(usable_vector_units().front(), picture, factors, rgb.data[0], rgb.linesize[0]);
}

}  // namespace

bool RgbConverter::is_set_up_for(const AVFrame& frame) const {
    return pool_ && frame.width == width_ && frame.height == height_ && frame.format == format_ &&
           frame.color_range == range_ && frame.colorspace == space_;
}

bool RgbConverter::set_up_for(const AVFrame& frame) {
    pool_.reset();  // nothing is set up where this fails
    scaler_.reset();
    factors_.reset();
    if (is_yuv420(frame))
        factors_ = yuv_factors(sws_getCoefficients(frame.colorspace), is_full_range(frame));
    else if (!is_rgb8(frame) && !set_up_scaler(frame))
        return false;
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
    if (!is_set_up_for(frame) && !set_up_for(frame)) return unsupported;
    FramePtr rgb = new_rgb();
    if (!rgb) return Error{ErrorKind::internal, "out of memory"};
    if (factors_) {
        convert(frame, *factors_, *rgb);
    } else if (!scaler_) {
        for (int y = 0; y < frame.height; ++y)
            move_rgb_row(frame, y, rgb->data[0] + std::ptrdiff_t{rgb->linesize[0]} * y);
    } else if (sws_scale(scaler_.get(), frame.data, frame.linesize, 0, frame.height, rgb->data,
                         rgb->linesize) != frame.height) {
        return unsupported;
    }
    return rgb;
}

Result<Image> rgb_converted(const AVFrame& frame) {
    if (is_rgb8(frame)) return rgb_exact(frame);
    TRY_ASSIGN(const auto rgb, RgbConverter().converted(frame));
    return rgb_exact(*rgb);
}

}  // namespace touchable
