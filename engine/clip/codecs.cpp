#include "engine/clip/codecs.hpp"

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

struct OwnCodec {
    std::uint32_t tag;
    const char* name;
    RankZstdDecoder::Version version;
};

constexpr std::array own_codecs{
    OwnCodec{MKTAG('T', '3', 'D', 'Z'), "t3dz", RankZstdDecoder::Version::first},
    OwnCodec{rank_zstd_tag, "t3d2", RankZstdDecoder::Version::second},
};

const OwnCodec* own_codec(const AVCodecParameters& stored) {
    const auto* const found = std::ranges::find(own_codecs, stored.codec_tag, &OwnCodec::tag);
    return stored.codec_id == AV_CODEC_ID_NONE && found != own_codecs.end() ? found : nullptr;
}

}  // namespace

std::optional<RankZstdDecoder::Version> rank_zstd_version(const AVCodecParameters& stored) {
    const OwnCodec* const own = own_codec(stored);
    return own ? std::optional(own->version) : std::nullopt;
}

std::string codec_name(const AVCodecParameters& stored) {
    if (const OwnCodec* const own = own_codec(stored)) return own->name;
    if (stored.codec_id != AV_CODEC_ID_NONE || stored.codec_tag == 0)
        return avcodec_get_name(stored.codec_id);
    char text[AV_FOURCC_MAX_STRING_SIZE];
    return av_fourcc_make_string(text, stored.codec_tag);
}

bool is_read(const AVCodecParameters& stored) {
    return own_codec(stored) || std::any_of(codecs.begin(), codecs.end(),
                                            [&](const Codec& one) { return one.id == stored.codec_id; });
}

std::string codecs_that_are_read() {
    std::string names;
    for (const Codec& codec : codecs) names += std::string(avcodec_get_name(codec.id)) + ", ";
    return names + own_codecs[0].name + ", " + own_codecs[1].name;
}

std::optional<std::string> lossy_note(PlaneRole role, const std::string& codec) {
    const auto stored = std::find_if(codecs.begin(), codecs.end(),
                                     [&](const Codec& one) { return codec == avcodec_get_name(one.id); });
    if (role == PlaneRole::colour || stored == codecs.end() || !stored->lossy) return std::nullopt;
    return std::string(role_name(role)) + " is stored as " + codec +
           ", which changes values: what is felt is not quite what was recorded (ffv1, png and t3d2 keep "
           "every value)";
}

}  // namespace touchable
