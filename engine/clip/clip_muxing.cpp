#include "engine/clip/clip_muxing.hpp"

#include <cstring>

#include "engine/clip/clip_tags.hpp"
#include "engine/clip/matroska_writer.hpp"

namespace touchable {
namespace {

Error no_memory() {
    return {ErrorKind::internal, "out of memory"};
}

}  // namespace

SceneDescription said_of_clip(const SceneDescription& described) {
    SceneDescription said(described.scene);
    said.unstated = described.unstated;
    said.scene.folder.reset();
    said.scene.video.reset();
    said.scene.stored = {};  // as codes
    return said;
}

void add_clip_tags(AVFormatContext& muxer, const FrameRate& rate, int version) {
    av_dict_set_int(&muxer.metadata, clip_tags::version_tag, version, 0);
    av_dict_set(&muxer.metadata, clip_tags::rate_tag, clip_tags::rate_text(rate).c_str(), 0);
}

bool is_shown_by_players(PlaneRole role, const FrameCheck& check) {
    const bool has_colour = check.bytes_per_sample(PlaneRole::colour) > 0;
    return role == (has_colour ? PlaneRole::colour : PlaneRole::depth);
}

Result<void> add_plane_stream(AVFormatContext& muxer, const TrackEncoder& encoder, PlaneRole role,
                              TrackCoding coding, const FrameCheck& check, const Scene& scene) {
    AVStream* const stream = avformat_new_stream(&muxer, nullptr);
    if (!stream) return no_memory();
    if (auto described = encoder.describe(*stream->codecpar); !described) return described;
    stream->time_base = {1, 1000};
    stream->avg_frame_rate = {static_cast<int>(scene.rate.num), static_cast<int>(scene.rate.den)};
    const std::string name(role_name(role));
    av_dict_set(&stream->metadata, clip_tags::role_tag, name.c_str(), 0);
    av_dict_set(&stream->metadata, "title", name.c_str(), 0);
    if (coding != TrackCoding::h264_visual) av_dict_set(&stream->metadata, clip_tags::lossless_tag, "1", 0);
    if (check.bytes_per_sample(role) == 2 && coding != TrackCoding::ffv1)
        av_dict_set_int(&stream->metadata, clip_tags::bits_tag,
                        role == PlaneRole::depth ? scene.depth_bits : 16, 0);
    stream->disposition = is_shown_by_players(role, check) ? AV_DISPOSITION_DEFAULT : 0;
    return {};
}

Result<void> attach_text(AVFormatContext& muxer, const char* name, const char* type,
                         const std::string& text) {
    AVStream* const stream = avformat_new_stream(&muxer, nullptr);
    if (!stream) return no_memory();
    stream->codecpar->codec_type = AVMEDIA_TYPE_ATTACHMENT;
    stream->codecpar->extradata =
        static_cast<std::uint8_t*>(av_mallocz(text.size() + AV_INPUT_BUFFER_PADDING_SIZE));
    if (!stream->codecpar->extradata) return no_memory();
    std::memcpy(stream->codecpar->extradata, text.data(), text.size());
    stream->codecpar->extradata_size = static_cast<int>(text.size());
    av_dict_set(&stream->metadata, "filename", name, 0);
    av_dict_set(&stream->metadata, "mimetype", type, 0);
    return {};
}

}  // namespace touchable
