// SPDX-License-Identifier: Apache-2.0
// Clips in MP4: a track of H.264 for each plane, and the MPEG-4 scene, or fragments with tags alone.
#include <array>

#include "engine/base/try.hpp"
#include "engine/clip/containers.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {
namespace {

/// Object numbers in the MPEG-4 scene, by PlaneRole.
constexpr std::array<std::uint16_t, all_roles.size()> objects{mpeg4::depth_object, mpeg4::colour_object,
                                                              mpeg4::haptic_object, mpeg4::height_object};

/// Longest fragment, ns, unless a frame is longer.
constexpr std::int64_t fragment_ns = 500'000'000;

class Mp4Writer final : public MuxedClipWriter {
public:
    Mp4Writer(const std::filesystem::path& path, const SceneDescription& described,
              const ClipStorage& storage, Existing existing)
        : MuxedClipWriter(path, described, storage, existing, "mp4") {}

private:
    Result<void> add(const RawFrame& frame) override {
        if (tracks_.empty()) TRY(open_tracks(frame));
        TRY(write_sound(time_ms(frame.number)));
        choose_access_point();
        for (std::size_t k = 0; k < tracks_.size(); ++k) TRY(encode(k, tracks_[k].of(frame)));
        return {};
    }

    /// The scene does not name tracks of low bits, which come last.
    Result<void> open_tracks(const RawFrame& first) {
        TRY(check_x264("an MP4 file"));
        for (PartTrack& track : part_tracks(first, scene_)) TRY(open_track(std::move(track), first));
        if (!storage_.fragmented) TRY(make_scene());
        return begin_file();
    }

    Result<void> open_track(PartTrack track, const RawFrame& first) {
        const bool is_seen = track.role == PlaneRole::colour && !storage_.exact_colour;
        const TrackCoding coding = is_seen                             ? TrackCoding::h264_visual
                                   : storage_.archive == Archive::fast ? TrackCoding::h264_quick
                                                                       : TrackCoding::h264_thrifty;
        TRY_ASSIGN(track.encoder, TrackEncoder::open(track.role, coding, track.of(first), scene_));
        AVStream* const stream = avformat_new_stream(muxer_.get(), nullptr);
        if (!stream) return refuse("out of memory");
        TRY(track.encoder->describe(*stream->codecpar));
        stream->id = static_cast<int>(tracks_.size()) + 1;
        stream->time_base = tick();
        stream->avg_frame_rate = {static_cast<int>(scene_.rate.num), static_cast<int>(scene_.rate.den)};
        av_dict_set(&stream->metadata, "handler_name", track.name().c_str(), 0);
        stream->disposition = tracks_.empty() ? AV_DISPOSITION_DEFAULT : 0;
        TRY(read_along(*track.encoder, coding));
        tracks_.push_back(std::move(track));
        return {};
    }

    Result<void> begin_file() {
        TRY(add_sound_stream());
        TRY(tag_scene());
        if (storage_.fragmented) return begin_fragments();
        AVDictionary* options = nullptr;
        av_dict_set(&options, "movflags", "use_metadata_tags", 0);
        return write_header(options);
    }

    /// A fragmented file begins with the movie box, whose tracks FFmpeg cannot mark: they are marked on their
    /// way into the file. Later boxes hold only offsets within their fragment.
    Result<void> begin_fragments() {
        AVIOContext* const file = muxer_->pb;
        if (avio_open_dyn_buf(&muxer_->pb) < 0) {
            muxer_->pb = file;
            return refuse("out of memory");
        }
        AVDictionary* options = nullptr;
        av_dict_set(&options, "movflags", "frag_keyframe+empty_moov+default_base_moof+use_metadata_tags", 0);
        const auto begun = write_header(options);
        std::uint8_t* memory = nullptr;
        const int size = avio_close_dyn_buf(std::exchange(muxer_->pb, file), &memory);
        const mpeg4::Bytes written(memory, memory + (memory ? size : 0));
        av_free(memory);
        if (!begun) return begun;
        TRY_ASSIGN(const auto boxes, mpeg4::boxes_in(written));
        mpeg4::Bytes head;
        for (const mpeg4::Box& box : boxes) {
            const mpeg4::Bytes as_is(box.content.begin(), box.content.end());
            TRY_ASSIGN(const auto content,
                       box.type == "moov" ? mpeg4::with_auxiliary_tracks(as_is, 1) : Result(as_is));
            mpeg4::put_box(head, box.type, content);
        }
        avio_write(file, head.data(), static_cast<int>(head.size()));
        return check_status(0);
    }

    Result<void> tag_scene() {
        add_clip_tags(*muxer_, scene_.rate, storage_.fragmented ? clip_format_version : mp4_format_version);
        AVDictionary*& tags = muxer_->metadata;
        av_dict_set(&tags, clip_tags::mp4_scene_tag, scene_to_json(said_of_clip(described_)).c_str(), 0);
        if (scene_.rate.own_times)
            av_dict_set(&tags, clip_tags::mp4_times_tag, frame_times_text(scene_.rate).c_str(), 0);
        if (scene_.path)
            av_dict_set(&tags, clip_tags::mp4_poses_tag,
                        timed_poses_text(*scene_.path, scene_.rate, scene_.metres_per_unit).c_str(), 0);
        const int wanted = 3 + (scene_.rate.own_times ? 1 : 0) + (scene_.path ? 1 : 0);
        return av_dict_count(tags) < wanted ? refuse("out of memory") : Result<void>{};
    }

    /// Chooses keyframes; each fragment begins with one.
    void choose_access_point() {
        const std::int64_t frame = check_.frames() - 1;
        const auto lasts = scene_.rate.time_ns(frame + 1) - scene_.rate.time_ns(access_point_);
        if (frame - access_point_ >= clip_tags::access_interval ||
            (storage_.fragmented && lasts > fragment_ns))
            access_point_ = frame;
    }

    Result<void> encode(std::size_t track, const PlaneView& plane) {
        const std::int64_t frame = check_.frames() - 1;
        TRY_ASSIGN(auto packet, tracks_[track].encoder->encode(plane, frame == access_point_));
        if (tracks_[track].role == PlaneRole::colour) TRY(read_again(*packet));
        packet->pts = packet->dts = tick_of(frame);
        packet->duration = tick_of(frame + 1) - tick_of(frame);
        return write_picture(*packet, track, tick());
    }

    /// Each plane's texture is a track.
    Result<void> make_scene() {
        const auto has = [&](PlaneRole role) { return check_.bytes_per_sample(role) > 0; };
        const mpeg4::ClipNodes nodes = mpeg4::nodes_from(
            scene_, {has(PlaneRole::colour), has(PlaneRole::haptic), has(PlaneRole::height)});
        std::map<std::uint16_t, std::uint32_t> tracks;
        for (std::size_t k = 0; k < tracks_.size(); ++k)
            if (tracks_[k].part != PlanePart::low)
                tracks[objects[static_cast<std::size_t>(tracks_[k].role)]] =
                    static_cast<std::uint32_t>(k + 1);
        return set_scene(nodes, std::move(tracks));
    }

    std::vector<PartTrack> tracks_;  // track k is stream k, and has number k + 1
    std::int64_t access_point_ = 0;  // the newest frame that decoding can begin with
};

}  // namespace

std::unique_ptr<MuxedClipWriter> mp4_writer(const std::filesystem::path& path,
                                            const SceneDescription& described, const ClipStorage& storage,
                                            Existing existing) {
    return std::make_unique<Mp4Writer>(path, described, storage, existing);
}

}  // namespace touchable
