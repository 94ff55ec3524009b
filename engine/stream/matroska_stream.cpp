#include "engine/stream/matroska_stream.hpp"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/clip/block_addition.hpp"
#include "engine/clip/clip_muxing.hpp"
#include "engine/clip/clip_tags.hpp"
#include "engine/clip/frame_check.hpp"
#include "engine/clip/matroska_writer.hpp"
#include "engine/clip/track_encoder.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/stream/memory_muxer.hpp"
#include "engine/stream/stream_sound.hpp"

namespace touchable {
namespace {

constexpr AVRational stream_millisecond{1, 1000};

class MatroskaStream final : public StreamMuxer {
public:
    MatroskaStream(const SceneDescription& described, std::optional<StreamSound> sound)
        : described_(described), scene_(described_.scene), sound_(std::move(sound)) {}
    Result<void> open();

    std::span<const std::uint8_t> header() const override { return header_; }
    std::span<const std::uint8_t> padding() const override {
        static constexpr std::array<std::uint8_t, 2> empty_void{0xEC, 0x80};
        return empty_void;
    }
    Result<StreamBlock> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                            bool is_key) override;

private:
    struct Track {
        PlaneRole role;
        TrackCoding coding;
        std::unique_ptr<TrackEncoder> encoder;
    };
    Result<void> check(const RawFrame& frame);
    Result<void> begin(const RawFrame& first);
    Result<void> add_sound_stream();
    Result<void> write_sound(std::int64_t until_ms);
    Result<void> write_picture(std::size_t track, const PlaneView& plane, const PictureLabel& label,
                               std::int64_t time_ms, bool is_key);

    const SceneDescription described_;
    const Scene& scene_;
    FrameCheck check_;
    std::uint64_t epoch_ = 0;    // of the newest frame
    std::vector<Track> tracks_;  // track k is stream k
    std::optional<StreamSound> sound_;
    int sound_stream_ = 0;
    std::vector<std::uint8_t> header_;
    std::unique_ptr<MemoryMuxer> muxer_;
};

Result<void> MatroskaStream::open() {
    TRY_ASSIGN(auto muxer, MemoryMuxer::open("matroska"));
    muxer_ = std::move(muxer);
    return {};
}

/// Frames of a stream count up, whatever their numbers in the clip.
Result<void> MatroskaStream::check(const RawFrame& frame) {
    RawFrame counted = frame;
    counted.number = check_.frames();
    return check_.check(counted, scene_);
}

/// Every picture of two bytes a sample on its own, so that a lost one spoils no other; bytes as quickly as
/// they can be encoded.
TrackCoding coding_in_stream(PlaneRole role, const PlaneView& plane) {
    if (role == PlaneRole::colour) return TrackCoding::h264_visual;
    return plane.bytes_per_sample == 2 ? TrackCoding::rank_zstd : TrackCoding::h264_quick;
}

Result<void> MatroskaStream::begin(const RawFrame& first) {
    for (const PlaneRole role : all_roles) {
        const PlaneView& plane = plane_of(first, role);
        if (plane.empty()) continue;
        const TrackCoding coding = coding_in_stream(role, plane);
        TRY_ASSIGN(auto encoder, TrackEncoder::open(role, coding, plane, scene_));
        if (auto added = add_plane_stream(muxer_->context(), *encoder, role, coding, check_, scene_); !added)
            return added;
        tracks_.push_back({role, coding, std::move(encoder)});
    }
    if (auto added = add_sound_stream(); !added) return added;
    if (auto attached = attach_text(muxer_->context(), clip_tags::scene_file, "application/json",
                                    scene_to_json(said_of_clip(described_)));
        !attached)
        return attached;
    add_clip_tags(muxer_->context(), scene_.rate, clip_format_version);
    av_dict_set(&muxer_->context().metadata, clip_tags::stream_tag, "1", 0);
    if (auto begun = muxer_->begin("live=1"); !begun) return begun;
    header_ = muxer_->take();
    epoch_ = first.epoch;
    return {};
}

Result<void> MatroskaStream::add_sound_stream() {
    if (!sound_) return {};
    sound_stream_ = static_cast<int>(tracks_.size());
    AVStream* const stream = avformat_new_stream(&muxer_->context(), nullptr);
    if (!stream || avcodec_parameters_copy(stream->codecpar, &sound_->codec()) < 0)
        return Error{ErrorKind::internal, "out of memory"};
    stream->codecpar->codec_tag = 0;  // the other container's
    stream->time_base = stream_millisecond;
    return {};
}

Result<void> MatroskaStream::write_sound(std::int64_t until_ms) {
    while (sound_) {
        TRY_ASSIGN(const auto packet, sound_->next(until_ms));
        if (!packet) return {};
        if (auto written = muxer_->write(*packet, sound_stream_, stream_millisecond); !written)
            return written;
    }
    return {};
}

Result<void> MatroskaStream::write_picture(std::size_t track, const PlaneView& plane,
                                           const PictureLabel& label, std::int64_t time_ms, bool is_key) {
    TRY_ASSIGN(auto packet, tracks_[track].encoder->encode(plane, is_key));
    const AVCodecID codec = muxer_->context().streams[track]->codecpar->codec_id;
    if (auto added = add_block_addition(*packet, codec, 1, label); !added) return added;
    packet->pts = packet->dts = time_ms;
    packet->duration = 0;  // the next frame tells
    return muxer_->write(*packet, static_cast<int>(track), stream_millisecond);
}

Result<StreamBlock> MatroskaStream::add(const RawFrame& frame, const PictureLabel& label,
                                        std::int64_t time_ns, bool is_key) {
    TRY(check(frame));
    if (check_.frames() == 1) TRY(begin(frame));
    constexpr std::int64_t ns_per_ms = 1'000'000;
    const std::int64_t time_ms = (time_ns + ns_per_ms / 2) / ns_per_ms;
    if (frame.epoch != epoch_ && sound_) {
        TRY(write_sound(time_ms - 1));
        TRY(sound_->begin_round(time_ms));
    }
    epoch_ = frame.epoch;
    // What is heard with a picture goes before it: FFmpeg holds a packet of sound until the next picture.
    TRY(write_sound(time_ms));
    StreamBlock block{label.frame, is_key, {}};
    // Colour in clusters of its own, behind the others: a listener on a narrow link goes without it.
    for (const bool is_colour : {false, true}) {
        for (std::size_t k = 0; k < tracks_.size(); ++k) {
            if ((tracks_[k].role == PlaneRole::colour) != is_colour) continue;
            TRY(write_picture(k, plane_of(frame, tracks_[k].role), label, time_ms, is_key));
        }
        TRY(muxer_->flush());
        const auto bytes = muxer_->take();
        if (is_colour) block.colour_bytes = bytes.size();
        block.bytes.insert(block.bytes.end(), bytes.begin(), bytes.end());
    }
    return block;
}

}  // namespace

Result<std::unique_ptr<StreamMuxer>> open_matroska_stream(const SceneDescription& described,
                                                          const std::optional<SoundPart>& sound) {
    TRY(check_storable("the stream", described));
    std::optional<StreamSound> opened;
    if (sound) {
        TRY_ASSIGN(auto of_clip, StreamSound::open(*sound));
        opened = std::move(of_clip);
    }
    auto stream = std::make_unique<MatroskaStream>(described, std::move(opened));
    TRY(stream->open());
    return std::unique_ptr<StreamMuxer>(std::move(stream));
}

}  // namespace touchable
