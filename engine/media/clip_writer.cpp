#include <array>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "engine/media/clip.hpp"
#include "engine/media/clip_tags.hpp"
#include "engine/media/ffmpeg.hpp"
#include "engine/media/track_encoder.hpp"
#include "engine/new_file.hpp"
#include "engine/scene/scene_file.hpp"

namespace touchable {
namespace {

constexpr std::int64_t ns_per_ms = 1'000'000;

/// What stays the same from frame to frame; all zero for a plane that is not there.
struct Shape {
    int width = 0, height = 0, bytes_per_sample = 0, channels = 0;
    bool operator==(const Shape&) const = default;
};

Shape shape_of(const PlaneView& plane) {
    if (plane.empty()) return {};
    return {plane.width, plane.height, plane.bytes_per_sample, plane.channels};
}

struct MuxerCloser {
    void operator()(AVFormatContext* muxer) const {
        avio_closep(&muxer->pb);
        avformat_free_context(muxer);
    }
};

class MatroskaWriter final : public ClipWriter {
public:
    MatroskaWriter(const std::filesystem::path& path, Scene scene, Existing existing)
        : scene_(std::move(scene)), output_(path, existing) {}
    Result<void> open();
    Result<void> write(const RawFrame& frame) override { return keep(write_frame(frame)); }
    Result<void> finish() override { return keep(complete()); }

private:
    Error refuse(const std::string& what) const {
        return input_error(output_.target().string() + ": " + what);
    }
    Result<void> keep(Result<void> result);
    Result<void> check_status(int status) const;
    Result<void> write_frame(const RawFrame& frame);
    Result<void> complete();
    Result<void> begin(const RawFrame& first);
    Result<void> add_track(PlaneRole role, const RawFrame& first);
    Result<void> attach_scene();
    Result<void> check_frame(const RawFrame& frame) const;
    std::int64_t time_ms(std::int64_t frame) const {
        return (scene_.rate.time_ns(frame) + ns_per_ms / 2) / ns_per_ms;
    }

    Scene scene_;
    NewFile output_;
    std::unique_ptr<AVFormatContext, MuxerCloser> muxer_;
    std::vector<TrackEncoder> tracks_;  // track k is stream k
    std::array<Shape, all_roles.size()> shapes_;
    std::int64_t frames_ = 0;
    bool over_ = false;  // finished, or failed
};

/// What went wrong once is not written over.
Result<void> MatroskaWriter::keep(Result<void> result) {
    over_ = over_ || !result.ok();
    return result;
}

Result<void> MatroskaWriter::check_status(int status) const {
    if (status >= 0 && muxer_->pb->error < 0) status = muxer_->pb->error;
    if (status >= 0) return {};
    return refuse("cannot be written: " + ffmpeg_text(status));
}

Result<void> MatroskaWriter::open() {
    if (auto usable = output_.check(); !usable) return usable;
    AVFormatContext* muxer = nullptr;
    int status = avformat_alloc_output_context2(&muxer, nullptr, "matroska", nullptr);
    if (status < 0) return Error{ErrorKind::internal, "Matroska muxer: " + ffmpeg_text(status)};
    muxer_.reset(muxer);
    muxer_->flags |= AVFMT_FLAG_BITEXACT;  // no random identifiers, no dates: same frames, same bytes
    status = avio_open(&muxer_->pb, file_url(output_.path()).c_str(), AVIO_FLAG_WRITE);
    return status < 0 ? refuse("cannot be written: " + ffmpeg_text(status)) : Result<void>{};
}

Result<void> MatroskaWriter::check_frame(const RawFrame& frame) const {
    const std::string number = std::to_string(frame.number);
    const auto misuse = [&](const std::string& what) {
        return Error{ErrorKind::internal, "frame " + number + " given to the clip writer: " + what};
    };
    if (over_) return misuse("the clip is finished, or has failed");
    if (frame.number != frames_) return misuse("number " + std::to_string(frames_) + " was due");
    if (frame.depth.empty()) return misuse("it has no depth");
    for (const PlaneRole role : all_roles) {
        const PlaneView& plane = plane_of(frame, role);
        const std::string name(role_name(role));
        const Shape shape = shape_of(plane);
        if (frames_ > 0 && shape != shapes_[static_cast<std::size_t>(role)])
            return misuse(name + " is of another size or kind than in frame 0");
        if (plane.empty()) continue;
        if (plane.width != scene_.width || plane.height != scene_.height)
            return misuse(name + " is not of the scene's size");
        if (role == PlaneRole::colour && plane.channels != 3) return misuse("colour is not RGB");
        if (auto fits = check_plane(role, plane, scene_, "frame " + number + ", " + name); !fits) return fits;
    }
    return {};
}

Result<void> MatroskaWriter::attach_scene() {
    Scene scene = scene_;
    scene.folder.reset();  // the frames are here now
    const std::string json = scene_to_json(scene);
    AVStream* stream = avformat_new_stream(muxer_.get(), nullptr);
    if (!stream) return refuse("out of memory");
    stream->codecpar->codec_type = AVMEDIA_TYPE_ATTACHMENT;
    stream->codecpar->extradata =
        static_cast<std::uint8_t*>(av_mallocz(json.size() + AV_INPUT_BUFFER_PADDING_SIZE));
    if (!stream->codecpar->extradata) return refuse("out of memory");
    std::memcpy(stream->codecpar->extradata, json.data(), json.size());
    stream->codecpar->extradata_size = static_cast<int>(json.size());
    av_dict_set(&stream->metadata, "filename", clip_tags::scene_file, 0);
    av_dict_set(&stream->metadata, "mimetype", "application/json", 0);
    return {};
}

Result<void> MatroskaWriter::add_track(PlaneRole role, const RawFrame& first) {
    auto track = TrackEncoder::open(role, plane_of(first, role), scene_);
    if (!track) return track.error();
    AVStream* stream = avformat_new_stream(muxer_.get(), nullptr);
    if (!stream || avcodec_parameters_from_context(stream->codecpar, &track->codec()) < 0)
        return refuse("out of memory");
    stream->time_base = {1, 1000};
    stream->avg_frame_rate = {static_cast<int>(scene_.rate.num), static_cast<int>(scene_.rate.den)};
    const std::string name(role_name(role));
    av_dict_set(&stream->metadata, clip_tags::role_tag, name.c_str(), 0);
    av_dict_set(&stream->metadata, "title", name.c_str(), 0);
    // Ordinary players show the track that is there to be seen.
    const PlaneRole shown = first.colour.empty() ? PlaneRole::depth : PlaneRole::colour;
    stream->disposition = role == shown ? AV_DISPOSITION_DEFAULT : 0;
    tracks_.push_back(std::move(*track));
    return {};
}

Result<void> MatroskaWriter::begin(const RawFrame& first) {
    for (const PlaneRole role : all_roles) {
        shapes_[static_cast<std::size_t>(role)] = shape_of(plane_of(first, role));
        if (plane_of(first, role).empty()) continue;
        if (auto added = add_track(role, first); !added) return added;
    }
    if (auto attached = attach_scene(); !attached) return attached;
    av_dict_set_int(&muxer_->metadata, clip_tags::version_tag, clip_format_version, 0);
    av_dict_set(&muxer_->metadata, clip_tags::rate_tag, clip_tags::rate_text(scene_.rate).c_str(), 0);
    return check_status(avformat_write_header(muxer_.get(), nullptr));
}

Result<void> MatroskaWriter::write_frame(const RawFrame& frame) {
    if (auto fits = check_frame(frame); !fits) return fits;
    if (frames_ == 0)
        if (auto begun = begin(frame); !begun) return begun;
    for (std::size_t k = 0; k < tracks_.size(); ++k) {
        auto packet = tracks_[k].encode(plane_of(frame, tracks_[k].role()));
        if (!packet) return packet.error();
        (*packet)->stream_index = static_cast<int>(k);
        (*packet)->pts = (*packet)->dts = time_ms(frames_);
        (*packet)->duration = time_ms(frames_ + 1) - time_ms(frames_);
        av_packet_rescale_ts(packet->get(), {1, 1000}, muxer_->streams[k]->time_base);
        if (auto written = check_status(av_write_frame(muxer_.get(), packet->get())); !written)
            return written;
    }
    ++frames_;
    return {};
}

Result<void> MatroskaWriter::complete() {
    if (over_) return Error{ErrorKind::internal, "the clip is finished already, or has failed"};
    if (frames_ == 0) return refuse("not written: no frame was given");
    if (auto written = check_status(av_write_trailer(muxer_.get())); !written) return written;
    const int status = avio_closep(&muxer_->pb);
    if (status < 0) return refuse("cannot be written: " + ffmpeg_text(status));
    over_ = true;
    return output_.commit();
}

}  // namespace

Result<std::unique_ptr<ClipWriter>> create_clip(const std::filesystem::path& path, const Scene& scene,
                                                Existing existing) {
    silence_ffmpeg();
    if (auto valid = validate(scene); !valid)
        return input_error(path.string() + ": " + valid.error().message);
    if (scene.far_from_frames)
        return input_error(path.string() + ": not written: the scene's depth.far is not known yet");
    if (clip_tags::is_too_fast(scene.rate))
        return input_error(path.string() + ": not written: the scene's rate is " +
                           clip_tags::rate_text(scene.rate) + " frames/s; a clip has at most " +
                           std::to_string(clip_tags::fastest_rate));
    auto writer = std::make_unique<MatroskaWriter>(path, scene, existing);
    if (auto opened = writer->open(); !opened) return opened.error();
    return std::unique_ptr<ClipWriter>(std::move(writer));
}

}  // namespace touchable
