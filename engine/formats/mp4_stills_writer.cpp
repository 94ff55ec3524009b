#include "engine/formats/mp4_stills_writer.hpp"

#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/clip/frame_check.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/mpeg4/scene_stream.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/png_bytes.hpp"

namespace touchable {
namespace {

struct Still {
    PlaneRole role;
    std::uint16_t object = 0;
    std::string png;
};

/// Ordinary players show the first track.
constexpr std::pair<PlaneRole, std::uint16_t> still_order[] = {{PlaneRole::colour, mpeg4::colour_object},
                                                               {PlaneRole::depth, mpeg4::depth_object},
                                                               {PlaneRole::haptic, mpeg4::haptic_object},
                                                               {PlaneRole::height, mpeg4::height_object}};

struct StillMuxerCloser {
    void operator()(AVFormatContext* muxer) const {
        std::uint8_t* bytes = nullptr;
        if (muxer->pb) avio_close_dyn_buf(muxer->pb, &bytes);
        av_free(bytes);
        avformat_free_context(muxer);
    }
};
using StillMuxer = std::unique_ptr<AVFormatContext, StillMuxerCloser>;

class Mp4StillsWriter final : public ClipWriter {
public:
    Mp4StillsWriter(const std::filesystem::path& path, const SceneDescription& described, Existing existing)
        : described_(described), output_(path, existing) {}
    Result<void> open() const { return output_.check(); }
    Result<void> write(const RawFrame& frame) override;
    Result<std::filesystem::path> complete() override;
    Result<void> finish() override;

private:
    Error refuse(const std::string& what) const {
        return input_error(output_.target().string() + ": " + what);
    }
    Result<void> add_track(AVFormatContext& muxer, const Still& still) const;
    Result<void> add_picture(AVFormatContext& muxer, std::size_t track) const;
    Result<mpeg4::Bytes> tracks() const;
    Result<mpeg4::SceneStream> scene_stream() const;

    SceneDescription described_;
    NewFile output_;
    FrameCheck check_;
    std::vector<Still> stills_;  // still k is track k + 1
    bool complete_ = false;
};

Result<void> Mp4StillsWriter::write(const RawFrame& frame) {
    if (!stills_.empty()) return Error{ErrorKind::internal, output_.target().string() + ": is of one frame"};
    if (auto fits = check_.check(frame, described_.scene); !fits) return fits;
    for (const auto& [role, object] : still_order) {
        const PlaneView& plane = plane_of(frame, role);
        if (plane.empty()) continue;
        TRY_ASSIGN(auto png, png_bytes(plane, PngEffort::quick, png_colours(role)));
        stills_.push_back({role, object, std::move(png)});
    }
    return {};
}

Result<void> Mp4StillsWriter::add_track(AVFormatContext& muxer, const Still& still) const {
    AVStream* const stream = avformat_new_stream(&muxer, nullptr);
    if (!stream) return refuse("out of memory");
    AVCodecParameters& stored = *stream->codecpar;
    stored.codec_type = AVMEDIA_TYPE_VIDEO;
    stored.codec_id = AV_CODEC_ID_PNG;
    stored.width = described_.scene.width;
    stored.height = described_.scene.height;
    stream->id = static_cast<int>(muxer.nb_streams);
    stream->time_base = {1, 1000};
    av_dict_set(&stream->metadata, "handler_name", std::string(role_name(still.role)).c_str(), 0);
    return {};
}

/// For a second, as a still picture has no time.
Result<void> Mp4StillsWriter::add_picture(AVFormatContext& muxer, std::size_t track) const {
    const std::string& png = stills_[track].png;
    const PacketPtr packet(av_packet_alloc());
    if (!packet || av_new_packet(packet.get(), static_cast<int>(png.size())) < 0)
        return refuse("out of memory");
    std::memcpy(packet->data, png.data(), png.size());
    packet->stream_index = static_cast<int>(track);
    packet->pts = packet->dts = 0;
    packet->duration = av_rescale_q(1, {1, 1}, muxer.streams[track]->time_base);
    packet->flags |= AV_PKT_FLAG_KEY;
    const int status = av_write_frame(&muxer, packet.get());
    return status < 0 ? refuse("cannot be written: " + ffmpeg_text(status)) : Result<void>{};
}

/// The file before it has its scene.
Result<mpeg4::Bytes> Mp4StillsWriter::tracks() const {
    AVFormatContext* made = nullptr;
    int status = avformat_alloc_output_context2(&made, nullptr, "mp4", nullptr);
    const StillMuxer muxer(made);
    if (status >= 0) status = avio_open_dyn_buf(&made->pb);
    if (status < 0) return Error{ErrorKind::internal, "MP4 muxer: " + ffmpeg_text(status)};
    muxer->flags |= AVFMT_FLAG_BITEXACT;
    for (const Still& still : stills_) TRY(add_track(*muxer, still));
    status = avformat_write_header(muxer.get(), nullptr);
    for (std::size_t track = 0; status >= 0 && track < stills_.size(); ++track)
        TRY(add_picture(*muxer, track));
    if (status >= 0) status = av_write_trailer(muxer.get());
    if (status < 0) return refuse("cannot be written: " + ffmpeg_text(status));
    std::uint8_t* bytes = nullptr;
    const int size = avio_close_dyn_buf(std::exchange(muxer->pb, nullptr), &bytes);
    mpeg4::Bytes all(bytes, bytes + size);
    av_free(bytes);
    return all;
}

Result<mpeg4::SceneStream> Mp4StillsWriter::scene_stream() const {
    SceneDescription pictures = described_;
    pictures.scene.stored = {};  // as codes
    pictures.scene.folder.emplace();
    for (const Still& still : stills_) pattern_of(*pictures.scene.folder, still.role) = role_name(still.role);
    mpeg4::ClipNodes nodes = mpeg4::nodes_of_pictures(pictures);
    mpeg4::SceneStream stream;
    for (std::size_t track = 0; track < stills_.size(); ++track) {
        const Still& still = stills_[track];
        stream.objects[still.object] = static_cast<std::uint32_t>(track + 1);
        const mpeg4::PlaneTexture texture{{.object = still.object}, false};
        switch (still.role) {
            case PlaneRole::depth:
                nodes.depth = texture;
                break;
            case PlaneRole::colour:
                nodes.colour = texture;
                break;
            case PlaneRole::haptic:
                nodes.haptic = texture;
                break;
            case PlaneRole::height:
                nodes.height = texture;
                break;
        }
    }
    const mpeg4::SceneTree tree = mpeg4::scene_of(nodes, pictures.scene.width, pictures.scene.height);
    stream.config = mpeg4::config_for(tree, pictures.scene.width, pictures.scene.height);
    auto scene = mpeg4::encode_scene(tree, stream.config);
    if (!scene) return refuse("MPEG-4 has no such scene: " + scene.error().message);
    stream.scene = std::move(*scene);
    return stream;
}

Result<std::filesystem::path> Mp4StillsWriter::complete() {
    if (stills_.empty()) return refuse("not written: no frame was given");
    TRY_ASSIGN(auto file, tracks());
    TRY_ASSIGN(const auto stream, scene_stream());
    TRY_ASSIGN(const auto boxes, mpeg4::boxes_in(file));
    if (boxes.empty() || boxes.back().type != "moov")
        return Error{ErrorKind::internal, "the movie box is not the MP4 file's last"};
    const mpeg4::BytesView movie = boxes.back().content;
    constexpr std::size_t head_bytes = 8;
    const std::size_t at = file.size() - movie.size() - head_bytes;
    const auto end = mpeg4::with_scene_stream(movie, stream, 1, at);
    if (!end) return end.error();
    std::string text(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(at));
    text.append(end->begin(), end->end());
    TRY(output_.write(text));
    complete_ = true;
    return output_.path();
}

Result<void> Mp4StillsWriter::finish() {
    if (!complete_) TRY(complete());
    return output_.commit();
}

}  // namespace

Result<std::unique_ptr<ClipWriter>> create_mp4_stills(const std::filesystem::path& path,
                                                      const SceneDescription& described, Existing existing) {
    silence_ffmpeg();
    if (auto valid = validate(described); !valid)
        return input_error(path.string() + ": " + valid.error().message);
    auto writer = std::make_unique<Mp4StillsWriter>(path, described, existing);
    TRY(writer->open());
    return std::unique_ptr<ClipWriter>(std::move(writer));
}

}  // namespace touchable
