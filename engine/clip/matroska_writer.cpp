#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/clip/block_addition.hpp"
#include "engine/clip/clip_muxing.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/clip_tags.hpp"
#include "engine/clip/frame_times_text.hpp"
#include "engine/clip/muxed_clip_writer.hpp"
#include "engine/clip/track_copy.hpp"
#include "engine/clip/track_writer.hpp"
#include "engine/scene/scene_file.hpp"

namespace touchable {
namespace {

class MatroskaWriter final : public MuxedClipWriter {
public:
    MatroskaWriter(const std::filesystem::path& path, const SceneDescription& described,
                   const ClipStorage& storage, Existing existing)
        : MuxedClipWriter(path, described, storage, existing, "matroska") {}
    PlaneView stored_colour() const override {
        for (const TrackWriter& track : tracks_)
            if (track.role() == PlaneRole::colour) return track.as_read();
        return {};
    }

private:
    Result<void> add(const RawFrame& frame) override;
    Result<void> add_rest() override;
    Result<void> open_tracks(const RawFrame& first);
    Result<void> begin_file();
    Result<void> add_copied_track(const AVStream& from, PlaneRole role);
    Result<void> copy_until(std::int64_t frame);
    Result<void> write_complete();
    Result<void> write_stored(std::size_t track);
    Result<void> write_picture_of(std::size_t stream, const StoredPicture& picture);
    Result<void> attach_scene();

    std::vector<TrackWriter> tracks_;   // track k is stream k
    std::unique_ptr<TrackCopy> copy_;   // its tracks are the streams after those; null: none
    std::vector<StoredPicture> ahead_;  // of each of them the picture that is written next
    bool begun_ = false;                // the file, once it is known how all tracks are coded
};

Result<void> MatroskaWriter::attach_scene() {
    if (auto attached =
            attach_text(*muxer_, clip_tags::scene_file, "application/json", scene_to_json(to_be_said()));
        !attached)
        return attached;
    if (scene_.path)
        if (auto attached = attach_text(*muxer_, clip_tags::poses_file, "text/plain",
                                        timed_poses_text(*scene_.path, scene_.rate, scene_.metres_per_unit));
            !attached)
            return attached;
    if (!scene_.rate.own_times) return {};
    return attach_text(*muxer_, clip_tags::times_file, "text/plain", frame_times_text(scene_.rate));
}

Result<void> MatroskaWriter::open_tracks(const RawFrame& first) {
    if (storage_.copied) {
        TRY_ASSIGN(auto copy, TrackCopy::open(storage_.copied->file, storage_.copied->roles));
        copy_ = std::move(copy);
    }
    for (const PlaneRole role : all_roles) {
        const PlaneView& plane = plane_of(first, role);
        if (plane.empty() || (copy_ && copy_->has(role))) continue;
        TRY_ASSIGN(auto track, TrackWriter::open(role, plane, scene_, storage_));
        tracks_.push_back(std::move(track));
    }
    return {};
}

Result<void> MatroskaWriter::add_copied_track(const AVStream& from, PlaneRole role) {
    AVStream* stream = avformat_new_stream(muxer_.get(), nullptr);
    if (!stream || avcodec_parameters_copy(stream->codecpar, from.codecpar) < 0)
        return refuse("out of memory");
    stream->time_base = {1, 1000};
    stream->avg_frame_rate = from.avg_frame_rate;
    for (const char* tag : {clip_tags::role_tag, "title", clip_tags::lossless_tag, clip_tags::bits_tag})
        if (const AVDictionaryEntry* const entry = av_dict_get(from.metadata, tag, nullptr, 0))
            av_dict_set(&stream->metadata, tag, entry->value, 0);
    stream->disposition = is_shown_by_players(role, check_) ? AV_DISPOSITION_DEFAULT : 0;
    return {};
}

Result<void> MatroskaWriter::begin_file() {
    for (const TrackWriter& track : tracks_)
        if (auto added =
                add_plane_stream(*muxer_, track.encoder(), track.role(), track.coding(), check_, scene_);
            !added)
            return added;
    for (std::size_t k = 0; copy_ && k < copy_->count(); ++k)
        if (auto added = add_copied_track(copy_->stream(k), copy_->role(k)); !added) return added;
    if (auto added = add_sound_stream(); !added) return added;
    if (auto attached = attach_scene(); !attached) return attached;
    add_tags(clip_format_version);
    begun_ = true;
    return write_header();
}

Result<void> MatroskaWriter::write_stored(std::size_t track) {
    const StoredPicture picture = tracks_[track].take_oldest();
    if (auto copied = copy_until(picture.frame); !copied) return copied;
    const AVCodecID codec = muxer_->streams[track]->codecpar->codec_id;
    if (auto added = add_block_addition(*picture.packet, codec, picture.frames); !added) return added;
    return write_picture_of(track, picture);
}

/// A picture that has its addition.
Result<void> MatroskaWriter::write_picture_of(std::size_t stream, const StoredPicture& picture) {
    AVPacket* packet = picture.packet.get();
    packet->pts = packet->dts = time_ms(picture.frame);
    if (auto written = write_sound(packet->pts); !written) return written;
    packet->duration = time_ms(picture.frame + picture.frames) - time_ms(picture.frame);
    return write_picture(*packet, stream, {1, 1000});
}

/// Copied pictures that are shown before this frame, in their order.
Result<void> MatroskaWriter::copy_until(std::int64_t frame) {
    if (!copy_) return {};
    for (std::size_t k = ahead_.size(); k < copy_->count(); ++k) {
        TRY_ASSIGN(auto first, copy_->next(k));
        ahead_.push_back(std::move(first));
    }
    while (true) {
        std::size_t next = ahead_.size();
        for (std::size_t k = 0; k < ahead_.size(); ++k)
            if (ahead_[k].packet && ahead_[k].frame < frame &&
                (next == ahead_.size() || ahead_[k].frame < ahead_[next].frame))
                next = k;
        if (next == ahead_.size()) return {};
        if (auto written = write_picture_of(tracks_.size() + next, ahead_[next]); !written) return written;
        TRY_ASSIGN(auto after, copy_->next(next));
        ahead_[next] = std::move(after);
    }
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
        if (auto written = write_stored(next); !written) return written;
    }
}

Result<void> MatroskaWriter::add(const RawFrame& frame) {
    if (tracks_.empty())
        if (auto opened = open_tracks(frame); !opened) return opened;
    for (TrackWriter& track : tracks_)
        if (auto added = track.add(plane_of(frame, track.role())); !added) return added;
    return write_complete();
}

Result<void> MatroskaWriter::add_rest() {
    for (TrackWriter& track : tracks_) track.end();
    if (auto written = write_complete(); !written) return written;
    if (auto copied = copy_until(check_.frames()); !copied) return copied;
    for (std::size_t k = 0; copy_ && k < copy_->count(); ++k)
        if (copy_->frames(k) < check_.frames())
            return input_error(storage_.copied->file.string() + ": its " +
                               std::string(role_name(copy_->role(k))) + " ends at frame " +
                               std::to_string(copy_->frames(k)) + ", before the others");
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
    if (storage.fragmented)
        return usage_error(path.string() +
                           ": only MP4 is written in fragments: must be a name that ends in .mp4");
    return open_clip_writer<MatroskaWriter>(path, described, storage, existing, sound);
}

}  // namespace touchable
