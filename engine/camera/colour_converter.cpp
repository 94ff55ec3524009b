#include "engine/camera/colour_converter.hpp"

#include <linux/videodev2.h>

#include <memory>
#include <string_view>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/picture_decoder.hpp"

namespace touchable {
namespace {

AVPixelFormat pixels_as_ffmpeg_has_them(std::uint32_t code) {
    switch (code) {
        case V4L2_PIX_FMT_RGB24:
            return AV_PIX_FMT_RGB24;
        case V4L2_PIX_FMT_BGR24:
            return AV_PIX_FMT_BGR24;
        case V4L2_PIX_FMT_YUYV:
            return AV_PIX_FMT_YUYV422;
        case V4L2_PIX_FMT_UYVY:
            return AV_PIX_FMT_UYVY422;
        case V4L2_PIX_FMT_NV12:
            return AV_PIX_FMT_NV12;
        default:
            return AV_PIX_FMT_NONE;
    }
}

/// Around the bytes, which stay the picture's.
Result<FramePtr> frame_around(const TakenPicture& picture, const StreamFormat& format) {
    FramePtr frame(av_frame_alloc());
    if (!frame) return Error{ErrorKind::internal, "out of memory"};
    frame->format = pixels_as_ffmpeg_has_them(format.code);
    frame->width = format.width;
    frame->height = format.height;
    frame->data[0] = picture.bytes->data();
    frame->linesize[0] = static_cast<int>(format.stride);
    if (format.code == V4L2_PIX_FMT_NV12) {
        frame->data[1] = frame->data[0] + format.stride * format.height;
        frame->linesize[1] = frame->linesize[0];
    }
    return frame;
}

Result<FramePtr> decoded(const TakenPicture& picture) {
    const auto* const bytes = reinterpret_cast<const char*>(picture.bytes->data());
    TRY_ASSIGN(auto made, decode_picture({bytes, picture.bytes->size()}, "its picture"));
    return std::move(made.frame);
}

}  // namespace

Result<Plane> ColourConverter::rgb(const TakenPicture& picture, const StreamFormat& format) {
    const bool coded = format.code == V4L2_PIX_FMT_MJPEG || format.code == V4L2_PIX_FMT_JPEG;
    TRY_ASSIGN(const auto frame, coded ? decoded(picture) : frame_around(picture, format));
    TRY_ASSIGN(auto made, converter_.converted(*frame));
    const AVFrame& rgb = *made;
    const PlaneView view{rgb.data[0], rgb.linesize[0], rgb.width, rgb.height, 1, 3};
    return Plane{view, std::shared_ptr<const AVFrame>(std::move(made))};
}

}  // namespace touchable
