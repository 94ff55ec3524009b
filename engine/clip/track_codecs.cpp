#include "engine/clip/track_codecs.hpp"

#include <string>
#include <utility>

extern "C" {
#include <libavutil/imgutils.h>

#include "engine/base/try.hpp"
}

namespace touchable {
namespace {

Error encoder_error(const std::string& what) {
    return {ErrorKind::internal, "encoder: " + what};
}

/// How a picture is cut for FFV1: n x n slices, which decode side by side, none over 4 megapixels; 0 where
/// FFmpeg's FFV1 has no way to cut it. (It wants at least 2 x 2 slices beyond 352x288, and where a slice
/// would be 1 pixel wide or high it writes slice positions that cannot be read back.)
int ffv1_slices(int width, int height) {
    if (width >= 32 && height >= 32) {
        constexpr int largest = 1 << 22;
        int n = 2;
        while (((width + n - 1) / n) * ((height + n - 1) / n) > largest) ++n;
        return n * n;
    }
    if (width > 352 || height > 288) return width >= 4 && height >= 4 ? 4 : 0;
    return width >= 2 && height >= 2 ? 1 : 0;
}

/// Slices cost bytes, and threads are worth waking for large pictures only.
int h264_slices(int width, int height) {
    return std::int64_t{width} * height < 100'000 ? 1 : 4;
}

/// x264 knows no more.
constexpr int largest_h264_side = 16384;

struct Settings {
    const char* encoder;
    const char* name;  // as people call it
    std::vector<std::pair<const char*, const char*>> options;
};

Settings settings_of(TrackCoding coding, AVPixelFormat format) {
    if (coding == TrackCoding::ffv1)
        return {"ffv1", "FFV1", {{"slicecrc", "1"}, {"coder", "1"}, {"context", "1"}}};
    // A packet comes out for each picture that goes in, and begins anew only where it is told to.
    Settings h264{format == AV_PIX_FMT_RGB24 ? "libx264rgb" : "libx264",
                  "H.264",
                  {{"tune", "zerolatency"}, {"forced-idr", "1"}, {"udu_sei", "1"}}};
    if (is_visual(coding)) {
        const char* const quality = coding == TrackCoding::h264_visual ? "18" : "24";
        // Streams of both qualities have the same parameter sets: VLC keeps those of the first as it goes
        // from one to the other.
        h264.options.insert(h264.options.end(), {{"x264-params", "keyint=infinite:scenecut=0:stitchable=1"},
                                                 {"preset", "superfast"},
                                                 {"crf", quality}});
    } else {
        h264.options.insert(h264.options.end(), {{"x264-params", "keyint=infinite:scenecut=0"}, {"qp", "0"}});
        h264.options.push_back({"preset", coding == TrackCoding::h264_quick ? "ultrafast" : "superfast"});
    }
    return h264;
}

Result<int> slices_of(TrackCoding coding, int width, int height) {
    if (coding != TrackCoding::ffv1) {
        if (width > largest_h264_side || height > largest_h264_side)
            return unstorable_size(width, height, "H.264 takes sides of 16384 at most");
        return h264_slices(width, height);
    }
    const int slices = ffv1_slices(width, height);
    if (slices == 0)
        return unstorable_size(
            width, height,
            "FFV1 needs sides of at least 2 pixels, and of 4 where one is over 352 wide or "
            "288 high");
    return slices;
}

}  // namespace

Error unstorable_size(int width, int height, const std::string& why) {
    return usage_error("pictures of " + std::to_string(width) + "x" + std::to_string(height) +
                       " cannot be stored: " + why);
}

Result<CodecPtr> open_encoder(TrackCoding coding, AVPixelFormat format, int width, int height,
                              const FrameRate& rate) {
    const Settings settings = settings_of(coding, format);
    const AVCodec* codec = avcodec_find_encoder_by_name(settings.encoder);
    if (!codec)
        return encoder_error("this FFmpeg has no " + std::string(settings.name) + " (" + settings.encoder +
                             ")");
    TRY_ASSIGN(const auto slices, slices_of(coding, width, height));
    if (av_image_check_size(static_cast<unsigned>(width), static_cast<unsigned>(height), 0, nullptr) < 0)
        return unstorable_size(width, height, "FFmpeg takes no more than some 16384x16128 pixels");
    CodecPtr context(avcodec_alloc_context3(codec));
    if (!context) return encoder_error("out of memory");
    context->width = width;
    context->height = height;
    context->pix_fmt = format;
    context->time_base = {static_cast<int>(rate.den), static_cast<int>(rate.num)};
    context->framerate = {static_cast<int>(rate.num), static_cast<int>(rate.den)};
    context->slices = slices;
    context->thread_count = 1;
    context->flags |= AV_CODEC_FLAG_BITEXACT | AV_CODEC_FLAG_GLOBAL_HEADER;
    const bool seen = is_visual(coding);  // by any player
    context->color_range = seen ? AVCOL_RANGE_MPEG : AVCOL_RANGE_JPEG;
    if (seen) {
        context->colorspace = AVCOL_SPC_BT709;
        context->color_primaries = AVCOL_PRI_BT709;
        context->color_trc = AVCOL_TRC_BT709;
    }
    if (coding == TrackCoding::ffv1) {
        context->gop_size = 1;
        context->level = 3;
    }
    AVDictionary* options = nullptr;
    for (const auto& [name, value] : settings.options) av_dict_set(&options, name, value, 0);
    const int status = avcodec_open2(context.get(), codec, &options);
    const bool all_taken = av_dict_count(options) == 0;
    av_dict_free(&options);
    if (status < 0 || !all_taken)
        return encoder_error(std::string(settings.name) + ": " +
                             (status < 0 ? ffmpeg_text(status) : "unknown option"));
    return context;
}

}  // namespace touchable
