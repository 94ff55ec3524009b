#include "engine/stream/matroska_stream.hpp"

#include <string>
#include <utility>
#include <vector>

#include "engine/clip/frame_check.hpp"
#include "engine/ffmpeg/ffmpeg.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/stream/stream_sound.hpp"
#include "engine/video/block_addition.hpp"
#include "engine/video/clip_muxing.hpp"
#include "engine/video/clip_tags.hpp"
#include "engine/video/matroska_writer.hpp"
#include "engine/video/track_encoder.hpp"

namespace touchable {
namespace {

/// What a muxer writes, in memory.
class MuxerMemory {
public:
    MuxerMemory() = default;
    ~MuxerMemory() {
        if (!io_) return;
        av_freep(&io_->buffer);
        avio_context_free(&io_);
    }
    MuxerMemory(const MuxerMemory&) = delete;
    MuxerMemory& operator=(const MuxerMemory&) = delete;

    Result<void> open(AVFormatContext& muxer) {
        constexpr int buffer_bytes = 1 << 16;
        auto* const buffer = static_cast<unsigned char*>(av_malloc(buffer_bytes));
        if (buffer) io_ = avio_alloc_context(buffer, buffer_bytes, 1, this, nullptr, write, nullptr);
        if (!io_) {
            av_free(buffer);
            return Error{ErrorKind::internal, "out of memory"};
        }
        io_->seekable = 0;
        muxer.pb = io_;
        muxer.flags |= AVFMT_FLAG_CUSTOM_IO;
        return {};
    }
    /// All since the last time.
    std::vector<std::uint8_t> take() {
        avio_flush(io_);
        const std::size_t likely = bytes_.size() + bytes_.size() / 8;
        std::vector<std::uint8_t> taken = std::exchange(bytes_, {});
        bytes_.reserve(likely);
        return taken;
    }

private:
    static int write(void* self, std::uint8_t* bytes, int size) {
        auto& it = *static_cast<MuxerMemory*>(self);
        it.bytes_.insert(it.bytes_.end(), bytes, bytes + size);
        return size;
    }

    AVIOContext* io_ = nullptr;
    std::vector<std::uint8_t> bytes_;
};

class MatroskaStream final : public StreamMuxer {
public:
    MatroskaStream(const SceneDescription& described, std::optional<StreamSound> sound)
        : described_(described), scene_(described_.scene), sound_(std::move(sound)) {}
    Result<void> open();

    std::span<const std::uint8_t> header() const override { return header_; }
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
    Result<void> write_packet(AVPacket& packet, std::size_t stream);
    Result<void> check_status(int status) const {
        if (status >= 0) return {};
        return Error{ErrorKind::internal, "the stream cannot be put together: " + ffmpeg_text(status)};
    }

    const SceneDescription described_;
    const Scene& scene_;
    FrameCheck check_;
    std::uint64_t epoch_ = 0;    // of the newest frame
    std::vector<Track> tracks_;  // track k is stream k
    std::optional<StreamSound> sound_;
    std::size_t sound_stream_ = 0;
    std::vector<std::uint8_t> header_;
    MuxerMemory memory_;
    struct MuxerCloser {
        void operator()(AVFormatContext* muxer) const { avformat_free_context(muxer); }
    };
    std::unique_ptr<AVFormatContext, MuxerCloser> muxer_;
};

Result<void> MatroskaStream::open() {
    silence_ffmpeg();
    AVFormatContext* muxer = nullptr;
    const int status = avformat_alloc_output_context2(&muxer, nullptr, "matroska", nullptr);
    if (status < 0) return check_status(status);
    muxer_.reset(muxer);
    muxer_->flags |= AVFMT_FLAG_BITEXACT;  // no random identifiers, no dates: same frames, same bytes
    return memory_.open(*muxer_);
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
        auto encoder = TrackEncoder::open(role, coding, plane, scene_);
        if (!encoder) return encoder.error();
        if (auto added = add_plane_stream(*muxer_, **encoder, role, coding, check_, scene_); !added)
            return added;
        tracks_.push_back({role, coding, std::move(*encoder)});
    }
    if (auto added = add_sound_stream(); !added) return added;
    if (auto attached = attach_text(*muxer_, clip_tags::scene_file, "application/json",
                                    scene_to_json(said_of_clip(described_)));
        !attached)
        return attached;
    add_clip_tags(*muxer_, scene_.rate);
    av_dict_set(&muxer_->metadata, clip_tags::stream_tag, "1", 0);
    AVDictionary* options = nullptr;
    av_dict_set(&options, "live", "1", 0);
    const int status = avformat_write_header(muxer_.get(), &options);
    av_dict_free(&options);
    if (status < 0) return check_status(status);
    header_ = memory_.take();
    epoch_ = first.epoch;
    return {};
}

Result<void> MatroskaStream::add_sound_stream() {
    if (!sound_) return {};
    sound_stream_ = tracks_.size();
    AVStream* const stream = avformat_new_stream(muxer_.get(), nullptr);
    if (!stream || avcodec_parameters_copy(stream->codecpar, &sound_->codec()) < 0)
        return Error{ErrorKind::internal, "out of memory"};
    stream->codecpar->codec_tag = 0;  // the other container's
    stream->time_base = {1, 1000};
    return {};
}

Result<void> MatroskaStream::write_packet(AVPacket& packet, std::size_t stream) {
    packet.stream_index = static_cast<int>(stream);
    return check_status(av_write_frame(muxer_.get(), &packet));
}

Result<void> MatroskaStream::write_sound(std::int64_t until_ms) {
    while (sound_) {
        const auto packet = sound_->next(until_ms);
        if (!packet) return packet.error();
        if (!*packet) return {};
        if (auto written = write_packet(**packet, sound_stream_); !written) return written;
    }
    return {};
}

Result<void> MatroskaStream::write_picture(std::size_t track, const PlaneView& plane,
                                           const PictureLabel& label, std::int64_t time_ms, bool is_key) {
    auto packet = tracks_[track].encoder->encode(plane, is_key);
    if (!packet) return packet.error();
    const AVCodecID codec = muxer_->streams[track]->codecpar->codec_id;
    if (auto added = add_block_addition(**packet, codec, 1, label); !added) return added;
    (*packet)->pts = (*packet)->dts = time_ms;
    (*packet)->duration = 0;  // the next frame tells
    return write_packet(**packet, track);
}

Result<StreamBlock> MatroskaStream::add(const RawFrame& frame, const PictureLabel& label,
                                        std::int64_t time_ns, bool is_key) {
    if (auto fits = check(frame); !fits) return fits.error();
    if (check_.frames() == 1)
        if (auto begun = begin(frame); !begun) return begun.error();
    constexpr std::int64_t ns_per_ms = 1'000'000;
    const std::int64_t time_ms = (time_ns + ns_per_ms / 2) / ns_per_ms;
    if (frame.epoch != epoch_ && sound_) {
        if (auto written = write_sound(time_ms - 1); !written) return written.error();
        if (auto begun = sound_->begin_round(time_ms); !begun) return begun.error();
    }
    epoch_ = frame.epoch;
    // What is heard with a picture goes before it: FFmpeg holds a packet of sound until the next picture.
    if (auto written = write_sound(time_ms); !written) return written.error();
    for (std::size_t k = 0; k < tracks_.size(); ++k)
        if (auto written = write_picture(k, plane_of(frame, tracks_[k].role), label, time_ms, is_key);
            !written)
            return written.error();
    if (auto flushed = check_status(av_write_frame(muxer_.get(), nullptr)); !flushed) return flushed.error();
    return StreamBlock{label.frame, is_key, memory_.take()};
}

}  // namespace

Result<std::unique_ptr<StreamMuxer>> open_matroska_stream(const SceneDescription& described,
                                                          const std::optional<SoundPart>& sound) {
    if (auto storable = check_storable("the stream", described); !storable) return storable.error();
    std::optional<StreamSound> opened;
    if (sound) {
        auto of_clip = StreamSound::open(*sound);
        if (!of_clip) return of_clip.error();
        opened = std::move(*of_clip);
    }
    auto stream = std::make_unique<MatroskaStream>(described, std::move(opened));
    if (auto begun = stream->open(); !begun) return begun.error();
    return std::unique_ptr<StreamMuxer>(std::move(stream));
}

}  // namespace touchable
