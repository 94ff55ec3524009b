#include "engine/video/codecs.hpp"

#include <algorithm>
#include <array>

namespace touchable {
namespace {

struct Codec {
    AVCodecID id;
    bool lossy;
};

/// What this program writes, and what cameras, Depthkit and editors export.
constexpr std::array codecs{
    Codec{AV_CODEC_ID_FFV1, false},    Codec{AV_CODEC_ID_PNG, false},   Codec{AV_CODEC_ID_FFVHUFF, false},
    Codec{AV_CODEC_ID_MJPEG, true},    Codec{AV_CODEC_ID_MPEG4, true},  Codec{AV_CODEC_ID_H264, true},
    Codec{AV_CODEC_ID_HEVC, true},     Codec{AV_CODEC_ID_PRORES, true}, Codec{AV_CODEC_ID_VP9, true},
    Codec{AV_CODEC_ID_AV1, true},      Codec{AV_CODEC_ID_HAP, true},    Codec{AV_CODEC_ID_VP8, true},
    Codec{AV_CODEC_ID_RAWVIDEO, false}};

constexpr const char* own_codec = "t3dz";

}  // namespace

bool is_gradient_zstd(const AVCodecParameters& stored) {
    return stored.codec_id == AV_CODEC_ID_NONE && stored.codec_tag == gradient_zstd_tag;
}

std::string codec_name(const AVCodecParameters& stored) {
    return is_gradient_zstd(stored) ? own_codec : avcodec_get_name(stored.codec_id);
}

bool is_read(const AVCodecParameters& stored) {
    return is_gradient_zstd(stored) || std::any_of(codecs.begin(), codecs.end(), [&](const Codec& one) {
               return one.id == stored.codec_id;
           });
}

std::string codecs_that_are_read() {
    std::string names;
    for (const Codec& codec : codecs) names += std::string(avcodec_get_name(codec.id)) + ", ";
    return names + own_codec;
}

std::optional<std::string> lossy_note(PlaneRole role, const std::string& codec) {
    const auto stored = std::find_if(codecs.begin(), codecs.end(),
                                     [&](const Codec& one) { return codec == avcodec_get_name(one.id); });
    if (role == PlaneRole::colour || stored == codecs.end() || !stored->lossy) return std::nullopt;
    return std::string(role_name(role)) + " is stored as " + codec +
           ", which changes values: what is felt is not quite what was recorded (ffv1, png and t3dz keep "
           "every value)";
}

}  // namespace touchable
