#include "engine/formats/lerobot_writer.hpp"

#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/clip/muxed_clip_writer.hpp"

namespace touchable {
namespace {

using OrderedJson = nlohmann::ordered_json;

class LeRobotWriter final : public MuxedClipWriter {
public:
    LeRobotWriter(const std::filesystem::path& path, const SceneDescription& described,
                  const ClipStorage& storage, Existing existing)
        : MuxedClipWriter(path, described, storage, existing, "mp4"),
          info_(lerobot_info_file(path), existing) {}
    Result<void> finish() override {
        if (auto written = info_.write(description()); !written) return written;
        if (auto named = MuxedClipWriter::finish(); !named) return named;
        return info_.commit();
    }

private:
    Result<void> add(const RawFrame& frame) override;
    Result<void> add_rest() override { return send(nullptr); }
    Result<void> begin();
    Result<void> send(const AVFrame* picture);
    std::string description() const;
    Error failed(const std::string& why) const {
        return {ErrorKind::internal, output_.target().string() + ": the encoder of HEVC: " + why};
    }
    /// Exact where frames come evenly.
    AVRational tick() const {
        if (scene_.rate.own_times) return {1, 1'000'000};
        return {static_cast<int>(scene_.rate.den), static_cast<int>(scene_.rate.num)};
    }
    std::int64_t tick_of(std::int64_t frame) const {
        return scene_.rate.own_times ? scene_.rate.time_ns(frame) / 1000 : frame;
    }

    NewFile info_;
    CodecPtr encoder_;
};

Result<void> LeRobotWriter::begin() {
    const AVCodec* const codec = avcodec_find_encoder_by_name("libx265");
    if (!codec) return failed("this FFmpeg has none (libx265)");
    // x265 is built for 8, 10 and 12 bits, each or not.
    if (!encodes(*codec, AV_PIX_FMT_GRAY12))
        return failed("this machine's libx265 was built without 12 bits (gray12le)");
    encoder_.reset(avcodec_alloc_context3(codec));
    AVStream* const stream = avformat_new_stream(muxer_.get(), nullptr);
    if (!encoder_ || !stream) return failed("out of memory");
    encoder_->width = scene_.width;
    encoder_->height = scene_.height;
    encoder_->pix_fmt = AV_PIX_FMT_GRAY12;
    encoder_->color_range = AVCOL_RANGE_JPEG;
    encoder_->time_base = tick();
    encoder_->framerate = {static_cast<int>(scene_.rate.num), static_cast<int>(scene_.rate.den)};
    encoder_->flags |= AV_CODEC_FLAG_BITEXACT | AV_CODEC_FLAG_GLOBAL_HEADER;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "x265-params", "lossless=1:bframes=0:keyint=30:log-level=none", 0);
    const int status = avcodec_open2(encoder_.get(), codec, &options);
    av_dict_free(&options);
    if (status < 0)
        return usage_error("pictures of " + std::to_string(scene_.width) + "x" +
                           std::to_string(scene_.height) + " cannot be HEVC: " + ffmpeg_text(status));
    if (avcodec_parameters_from_context(stream->codecpar, encoder_.get()) < 0) return failed("out of memory");
    stream->codecpar->codec_tag = MKTAG('h', 'v', 'c', '1');
    stream->id = 1;
    stream->time_base = tick();
    stream->avg_frame_rate = encoder_->framerate;
    return write_header();
}

Result<void> LeRobotWriter::send(const AVFrame* picture) {
    int status = avcodec_send_frame(encoder_.get(), picture);
    while (status >= 0) {
        const PacketPtr packet(av_packet_alloc());
        if (!packet) return failed("out of memory");
        status = avcodec_receive_packet(encoder_.get(), packet.get());
        if (status == AVERROR(EAGAIN) || status == AVERROR_EOF) return {};
        if (status < 0) break;
        if (auto written = write_picture(*packet, 0, tick()); !written) return written;
    }
    return failed(ffmpeg_text(status));
}

Result<void> LeRobotWriter::add(const RawFrame& frame) {
    if (!encoder_)
        if (auto begun = begin(); !begun) return begun;
    const FramePtr picture(av_frame_alloc());
    if (!picture) return failed("out of memory");
    picture->width = scene_.width;
    picture->height = scene_.height;
    picture->format = AV_PIX_FMT_GRAY12;
    picture->color_range = AVCOL_RANGE_JPEG;
    if (av_frame_get_buffer(picture.get(), 0) < 0) return failed("out of memory");
    for (int y = 0; y < scene_.height; ++y)
        std::memcpy(picture->data[0] + std::ptrdiff_t{picture->linesize[0]} * y, frame.depth.row(y),
                    2 * static_cast<std::size_t>(scene_.width));
    picture->pts = tick_of(frame.number);
    return send(picture.get());
}

/// In metres, as LeRobot's own.
std::string LeRobotWriter::description() const {
    const DepthCoding& depth = scene_.depth;
    const double metres = scene_.metres_per_unit;
    const bool is_log = depth.kind == DepthCodingKind::log;
    OrderedJson info;
    info["video.height"] = scene_.height;
    info["video.width"] = scene_.width;
    info["video.codec"] = "hevc";
    info["video.pix_fmt"] = "gray12le";
    info["is_depth_map"] = true;
    info["video.fps"] = scene_.rate.per_second();
    info["video.channels"] = 1;
    info["has_audio"] = false;
    info["video.depth_min"] = depth.near * metres;
    info["video.depth_max"] = depth.far * metres;
    info["video.shift"] = is_log ? depth.shift * metres : 3.5;
    info["video.use_log"] = is_log;
    const Camera& camera = scene_.camera;
    info["camera"] = {{"fx", camera.fx}, {"fy", camera.fy},       {"cx", camera.cx},
                      {"cy", camera.cy}, {"width", scene_.width}, {"height", scene_.height}};
    OrderedJson all;
    all["features"][lerobot_feature] = {{"dtype", "video"},
                                        {"shape", {scene_.height, scene_.width, 1}},
                                        {"names", {"height", "width", "channels"}},
                                        {"info", info}};
    return all.dump(2) + "\n";
}

}  // namespace

std::filesystem::path lerobot_info_file(const std::filesystem::path& video) {
    return std::filesystem::path(video).replace_extension(".info.json");
}

Result<std::unique_ptr<ClipWriter>> create_lerobot_video(const std::filesystem::path& path,
                                                         const Scene& scene, Existing existing) {
    return open_clip_writer<LeRobotWriter>(path, scene, {}, existing, {});
}

}  // namespace touchable
