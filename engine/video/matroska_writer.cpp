#include <algorithm>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "engine/clip/clip_reader.hpp"
#include "engine/clip/frame_check.hpp"
#include "engine/ffmpeg/ffmpeg.hpp"
#include "engine/ffmpeg/reserved_output.hpp"
#include "engine/new_file.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/sound/stored_sound.hpp"
#include "engine/video/block_addition.hpp"
#include "engine/video/clip_tags.hpp"
#include "engine/video/frame_times_text.hpp"
#include "engine/video/matroska_writer.hpp"
#include "engine/video/track_writer.hpp"

namespace touchable {
namespace {

constexpr std::int64_t ns_per_ms = 1'000'000;

struct MuxerCloser {
    void operator()(AVFormatContext* muxer) const { avformat_free_context(muxer); }
};

class MatroskaWriter final : public ClipWriter {
public:
    MatroskaWriter(const std::filesystem::path& path, const SceneDescription& described,
                   const ClipStorage& storage, Existing existing, std::unique_ptr<StoredSound> sound)
        : scene_(described.scene),
          unstated_(described.unstated),
          storage_(storage),
          output_(path, existing),
          sound_(std::move(sound)) {}
    Result<void> open();
    Result<void> write(const RawFrame& frame) override { return keep(write_frame(frame)); }
    PlaneView stored_colour() const override {
        for (const TrackWriter& track : tracks_)
            if (track.role() == PlaneRole::colour) return track.as_read();
        return {};
    }
    Result<std::filesystem::path> complete() override {
        if (auto ended = keep(end()); !ended) return ended.error();
        return output_.path();
    }
    bool is_full() const override { return room_.is_full(); }
    Result<void> finish() override {
        if (!complete_)
            if (auto ended = keep(end()); !ended) return ended;
        return output_.commit();
    }

private:
    Error refuse(const std::string& what) const {
        return input_error(output_.target().string() + ": " + what);
    }
    Result<void> keep(Result<void> result);
    Result<void> check_status(int status) const;
    Result<void> write_frame(const RawFrame& frame);
    Result<void> end();
    Result<void> open_tracks(const RawFrame& first);
    Result<void> begin_file();
    Result<void> add_track(const TrackWriter& track);
    Result<void> write_complete();
    Result<void> write_picture(std::size_t track);
    Result<void> add_sound();
    Result<void> write_sound(std::int64_t until_ms);
    Result<void> attach(const char* name, const char* type, const std::string& text);
    Result<void> attach_scene();
    std::int64_t time_ms(std::int64_t frame) const {
        return (scene_.rate.time_ns(frame) + ns_per_ms / 2) / ns_per_ms;
    }

    Scene scene_;
    Unstated unstated_;
    ClipStorage storage_;
    NewFile output_;
    std::unique_ptr<StoredSound> sound_;  // null: none
    ReservedOutput room_;
    std::unique_ptr<AVFormatContext, MuxerCloser> muxer_;
    std::vector<TrackWriter> tracks_;  // track k is stream k
    FrameCheck check_;
    bool begun_ = false;  // the file, once it is known how all tracks are coded
    bool over_ = false;   // complete, or failed
    bool complete_ = false;
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
    status = room_.open(output_.path(), *muxer_);
    return status < 0 ? refuse("cannot be written: " + ffmpeg_text(status)) : Result<void>{};
}

Result<void> MatroskaWriter::attach_scene() {
    SceneDescription described(scene_);
    described.unstated = unstated_;
    Scene& scene = described.scene;
    scene.folder.reset();  // the frames are here now
    scene.video.reset();
    scene.stored = {};  // as codes
    if (auto attached = attach(clip_tags::scene_file, "application/json", scene_to_json(described));
        !attached)
        return attached;
    return scene.rate.own_times ? attach(clip_tags::times_file, "text/plain", frame_times_text(scene.rate))
                                : Result<void>{};
}

Result<void> MatroskaWriter::attach(const char* name, const char* type, const std::string& text) {
    AVStream* stream = avformat_new_stream(muxer_.get(), nullptr);
    if (!stream) return refuse("out of memory");
    stream->codecpar->codec_type = AVMEDIA_TYPE_ATTACHMENT;
    stream->codecpar->extradata =
        static_cast<std::uint8_t*>(av_mallocz(text.size() + AV_INPUT_BUFFER_PADDING_SIZE));
    if (!stream->codecpar->extradata) return refuse("out of memory");
    std::memcpy(stream->codecpar->extradata, text.data(), text.size());
    stream->codecpar->extradata_size = static_cast<int>(text.size());
    av_dict_set(&stream->metadata, "filename", name, 0);
    av_dict_set(&stream->metadata, "mimetype", type, 0);
    return {};
}

Result<void> MatroskaWriter::open_tracks(const RawFrame& first) {
    for (const PlaneRole role : all_roles) {
        const PlaneView& plane = plane_of(first, role);
        if (plane.empty()) continue;
        auto track = TrackWriter::open(role, plane, scene_, storage_);
        if (!track) return track.error();
        tracks_.push_back(std::move(*track));
    }
    return {};
}

Result<void> MatroskaWriter::add_track(const TrackWriter& track) {
    AVStream* stream = avformat_new_stream(muxer_.get(), nullptr);
    if (!stream) return refuse("out of memory");
    if (auto described = track.encoder().describe(*stream->codecpar); !described) return described;
    stream->time_base = {1, 1000};
    stream->avg_frame_rate = {static_cast<int>(scene_.rate.num), static_cast<int>(scene_.rate.den)};
    const PlaneRole role = track.role();
    const std::string name(role_name(role));
    av_dict_set(&stream->metadata, clip_tags::role_tag, name.c_str(), 0);
    av_dict_set(&stream->metadata, "title", name.c_str(), 0);
    if (track.coding() != TrackCoding::h264_visual)
        av_dict_set(&stream->metadata, clip_tags::lossless_tag, "1", 0);
    if (check_.bytes_per_sample(role) == 2 && track.coding() != TrackCoding::ffv1)
        av_dict_set_int(&stream->metadata, clip_tags::bits_tag,
                        role == PlaneRole::depth ? scene_.depth_bits : 16, 0);
    // Ordinary players show the track that is there to be seen.
    const bool has_colour = check_.bytes_per_sample(PlaneRole::colour) > 0;
    const PlaneRole shown = has_colour ? PlaneRole::colour : PlaneRole::depth;
    stream->disposition = role == shown ? AV_DISPOSITION_DEFAULT : 0;
    return {};
}

Result<void> MatroskaWriter::begin_file() {
    for (const TrackWriter& track : tracks_)
        if (auto added = add_track(track); !added) return added;
    if (auto added = add_sound(); !added) return added;
    if (auto attached = attach_scene(); !attached) return attached;
    av_dict_set_int(&muxer_->metadata, clip_tags::version_tag, clip_format_version, 0);
    av_dict_set(&muxer_->metadata, clip_tags::rate_tag, clip_tags::rate_text(scene_.rate).c_str(), 0);
    begun_ = true;
    return check_status(avformat_write_header(muxer_.get(), nullptr));
}

/// The stream after those of the pictures.
Result<void> MatroskaWriter::add_sound() {
    if (!sound_) return {};
    AVStream* stream = avformat_new_stream(muxer_.get(), nullptr);
    if (!stream || avcodec_parameters_copy(stream->codecpar, &sound_->codec()) < 0)
        return refuse("out of memory");
    stream->codecpar->codec_tag = 0;  // the other container's
    stream->time_base = {1, 1000};
    return {};
}

/// What is heard up to then.
Result<void> MatroskaWriter::write_sound(std::int64_t until_ms) {
    if (!sound_) return {};
    const auto stream = static_cast<int>(tracks_.size());
    while (true) {
        const auto packet = sound_->next(until_ms);
        if (!packet) return packet.error();
        if (!*packet) return {};
        (*packet)->stream_index = stream;
        av_packet_rescale_ts(packet->get(), {1, 1000}, muxer_->streams[stream]->time_base);
        if (auto written = check_status(av_write_frame(muxer_.get(), packet->get())); !written)
            return written;
    }
}

Result<void> MatroskaWriter::write_picture(std::size_t track) {
    const StoredPicture picture = tracks_[track].take_oldest();
    AVPacket* packet = picture.packet.get();
    const AVCodecID codec = muxer_->streams[track]->codecpar->codec_id;
    if (auto added = add_block_addition(*packet, codec, picture.frames); !added) return added;
    packet->stream_index = static_cast<int>(track);
    packet->pts = packet->dts = time_ms(picture.frame);
    if (auto written = write_sound(packet->pts); !written) return written;
    packet->duration = time_ms(picture.frame + picture.frames) - time_ms(picture.frame);
    av_packet_rescale_ts(packet, {1, 1000}, muxer_->streams[track]->time_base);
    auto written = check_status(av_write_frame(muxer_.get(), packet));
    room_.end_picture();
    return written;
}

/// Pictures in the order of their frames, and of a frame in the order of the tracks; up to one of which it is
/// not known yet how long it stays.
Result<void> MatroskaWriter::write_complete() {
    const auto decided = [](const TrackWriter& track) { return track.decided(); };
    if (!std::all_of(tracks_.begin(), tracks_.end(), decided)) return {};
    if (!begun_)
        if (auto begun = begin_file(); !begun) return begun;
    while (true) {
        std::size_t next = tracks_.size();
        for (std::size_t k = 0; k < tracks_.size(); ++k) {
            const StoredPicture* picture = tracks_[k].oldest();
            if (picture && (next == tracks_.size() || picture->frame < tracks_[next].oldest()->frame))
                next = k;
        }
        if (next == tracks_.size() || !tracks_[next].oldest_is_complete()) return {};
        if (auto written = write_picture(next); !written) return written;
    }
}

Result<void> MatroskaWriter::write_frame(const RawFrame& frame) {
    if (over_)
        return Error{ErrorKind::internal, "a frame is given to a clip that is finished, or has failed"};
    if (auto fits = check_.check(frame, scene_); !fits) return fits;
    if (tracks_.empty())
        if (auto opened = open_tracks(frame); !opened) return opened;
    for (TrackWriter& track : tracks_)
        if (auto added = track.add(plane_of(frame, track.role())); !added) return added;
    return write_complete();
}

Result<void> MatroskaWriter::end() {
    if (over_) return Error{ErrorKind::internal, "the clip is finished already, or has failed"};
    if (check_.frames() == 0) return refuse("not written: no frame was given");
    for (TrackWriter& track : tracks_) track.end();
    if (auto written = write_complete(); !written) return written;
    if (auto written = write_sound(time_ms(check_.frames())); !written) return written;
    if (auto written = check_status(av_write_trailer(muxer_.get())); !written) return written;
    const int status = room_.close();
    if (status < 0) return refuse("cannot be written: " + ffmpeg_text(status));
    over_ = complete_ = true;
    return {};
}

}  // namespace

Result<void> check_storable(const std::filesystem::path& path, const SceneDescription& described) {
    const FrameRate& rate = described.scene.rate;
    if (auto valid = validate(described); !valid)
        return input_error(path.string() + ": " + valid.error().message);
    if (described.unstated.far)
        return input_error(path.string() + ": not written: the scene's depth.far is not known yet");
    if (!clip_tags::is_too_fast(rate)) return {};
    return input_error(path.string() + ": not written: the scene's rate is " + clip_tags::rate_text(rate) +
                       " frames/s; a clip has at most " + std::to_string(clip_tags::fastest_rate));
}

Result<std::unique_ptr<ClipWriter>> create_clip(const std::filesystem::path& path,
                                                const SceneDescription& described, const ClipStorage& storage,
                                                Existing existing, const std::optional<SoundPart>& sound) {
    silence_ffmpeg();
    if (auto storable = check_storable(path, described); !storable) return storable.error();
    std::unique_ptr<StoredSound> heard;
    if (sound) {
        auto opened = StoredSound::open(*sound);
        if (!opened) return opened.error();
        heard = std::move(*opened);
    }
    auto writer = std::make_unique<MatroskaWriter>(path, described, storage, existing, std::move(heard));
    if (auto opened = writer->open(); !opened) return opened.error();
    return std::unique_ptr<ClipWriter>(std::move(writer));
}

}  // namespace touchable
