#include "bench/media/av_codec.hpp"
#include "bench/media/byte_codecs.hpp"

namespace touchable {
namespace {

/// Clips of both archives have an access point every half second.
constexpr int frames_to_access = 15;
constexpr int side_by_side = 4;  // slices

CodecChoice by_ffmpeg(std::string name, AvSettings settings, bool lossless = true) {
    return {std::move(name), lossless, [settings = std::move(settings)](const PlaneView& first) {
                return open_av_codec(settings, first);
            }};
}

CodecChoice by_bytes(std::string name, std::unique_ptr<PlaneCodec> (*make)(const PlaneView&)) {
    return {std::move(name), true,
            [make](const PlaneView& first) -> Result<std::unique_ptr<PlaneCodec>> { return make(first); }};
}

AvSettings ffv1(AVPixelFormat format, const char* coder) {
    return {"ffv1", {format}, side_by_side, 1, {{"slicecrc", "1"}, {"coder", coder}, {"context", "1"}}};
}

AvSettings x264(const char* encoder, PicturePacking packing, const char* preset, const char* quality,
                const char* value) {
    return {encoder,
            packing,
            side_by_side,
            frames_to_access,
            {{"preset", preset}, {quality, value}, {"tune", "zerolatency"}}};
}

void add_h264(std::vector<CodecChoice>& choices, const PlaneView& first) {
    const PicturePacking grey{AV_PIX_FMT_GRAY8, first.bytes_per_sample == 2};
    const bool rgb = first.channels == 3;
    for (const char* preset : {"ultrafast", "superfast"})
        choices.push_back(by_ffmpeg(std::string("h264-") + preset,
                                    x264(rgb ? "libx264rgb" : "libx264",
                                         rgb ? PicturePacking{AV_PIX_FMT_BGR0} : grey, preset, "qp", "0")));
}

void add_lossy_h264(std::vector<CodecChoice>& choices) {
    for (const auto& [chroma, format] : {std::pair{"444", AV_PIX_FMT_YUV444P}, {"420", AV_PIX_FMT_YUV420P}})
        for (const char* preset : {"veryfast", "superfast"})
            choices.push_back(by_ffmpeg(std::string("h264-crf18-") + chroma + "-" + preset,
                                        x264("libx264", {format}, preset, "crf", "18"), false));
}

}  // namespace

std::vector<CodecChoice> codec_choices(PlaneRole role, const PlaneView& first) {
    const bool rgb = first.channels == 3, deep = first.bytes_per_sample == 2;
    const AVPixelFormat grey = deep ? AV_PIX_FMT_GRAY16LE : AV_PIX_FMT_GRAY8;
    std::vector<CodecChoice> choices;
    choices.push_back(by_ffmpeg("ffv1-range", ffv1(rgb ? AV_PIX_FMT_BGR0 : grey, "1")));
    // Golomb-Rice codes are for 8-bit samples: for more bits FFmpeg always uses the range coder.
    if (!deep) choices.push_back(by_ffmpeg("ffv1-rice", ffv1(rgb ? AV_PIX_FMT_BGR0 : grey, "0")));
    choices.push_back(by_ffmpeg("ffvhuff", {"ffvhuff", {rgb ? AV_PIX_FMT_RGB24 : grey}}));
    const AVPixelFormat in_png = rgb ? AV_PIX_FMT_RGB24 : deep ? AV_PIX_FMT_GRAY16BE : grey;
    choices.push_back(by_ffmpeg("png", {"png", {in_png}}));
    choices.push_back(by_ffmpeg("png-up", {"png", {in_png}, 1, 1, {{"pred", "up"}}}));
    if (!rgb)
        choices.push_back(by_ffmpeg(
            "magicyuv", {"magicyuv", {AV_PIX_FMT_GRAY8, deep}, side_by_side, 1, {{"pred", "gradient"}}}));
    add_h264(choices, first);
    if (role == PlaneRole::colour) add_lossy_h264(choices);
    choices.push_back(by_bytes("zstd", make_plain_zstd_codec));
    choices.push_back(by_bytes("zstd-left", make_zstd_codec));
    choices.push_back(by_bytes("zstd-gradient", make_zstd_gradient_codec));
    if (deep) choices.push_back(by_bytes("t3d2", make_rank_zstd_codec));
    if (!rgb) choices.push_back(by_bytes("rvl", make_rvl_codec));
    choices.push_back(by_bytes("raw", make_raw_codec));
    return choices;
}

}  // namespace touchable
