// SPDX-License-Identifier: Apache-2.0
// The forms of a stream in one container: Matroska, for our own programs, and MPEG-TS, for stock tools.

#include <algorithm>
#include <array>

#include "engine/base/try.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/clip/containers.hpp"
#include "engine/scene/scene.hpp"
#include "engine/stream/labelled_codec.hpp"
#include "engine/stream/memory_muxer.hpp"
#include "engine/stream/sending.hpp"

extern "C" {
#include <libavutil/opt.h>
}

namespace touchable {
namespace {

// --- Matroska

constexpr AVRational stream_millisecond{1, 1000};

/// Planes of two bytes a sample are coded picture by picture, so that a lost one spoils no other; planes of
/// one byte as quickly as possible.
TrackCoding coding_in_stream(PlaneRole role, const PlaneView& plane) {
    if (role == PlaneRole::colour) return TrackCoding::h264_visual;
    return plane.bytes_per_sample == 2 ? TrackCoding::rank_zstd : TrackCoding::h264_quick;
}

class MatroskaStream final : public StreamMuxer {
public:
    MatroskaStream(const SceneDescription& described, std::optional<StreamSound> sound,
                   std::unique_ptr<MemoryMuxer> muxer)
        : described_(described),
          scene_(described_.scene),
          sound_(std::move(sound)),
          muxer_(std::move(muxer)) {}

    std::span<const std::uint8_t> header() const override { return header_; }
    std::span<const std::uint8_t> padding() const override {
        static constexpr std::array<std::uint8_t, 2> empty_void{0xEC, 0x80};
        return empty_void;
    }

    Result<Block> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                      bool is_key) override {
        RawFrame counted = frame;  // frames of a stream count up, whatever their numbers in the clip
        counted.number = check_.frames();
        TRY(check_.check(counted, scene_));
        if (check_.frames() == 1) TRY(begin(frame));
        const std::int64_t time_ms = (time_ns + 500'000) / 1'000'000;
        // Sound goes before its picture: FFmpeg holds a packet of sound until the next picture.
        if (sound_)
            TRY(sound_->give(frame.epoch, time_ns, [this](AVPacket& packet) {
                return muxer_->write(packet, sound_stream_, stream_millisecond);
            }));
        Block block{label.frame, is_key, {}};
        // Colour has its own clusters, behind the others: a listener on a narrow link goes without it.
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

private:
    struct Track {
        PlaneRole role;
        TrackCoding coding;
        std::unique_ptr<TrackEncoder> encoder;
    };

    Result<void> begin(const RawFrame& first) {
        for (const auto& [role, plane] : planes_of(first)) {
            const TrackCoding coding = coding_in_stream(role, plane);
            TRY_ASSIGN(auto encoder, TrackEncoder::open(role, coding, plane, scene_));
            TRY(add_plane_stream(muxer_->context(), *encoder, role, coding, check_, scene_));
            tracks_.push_back({role, coding, std::move(encoder)});
        }
        if (sound_) TRY(assign(sound_stream_, muxer_->add_sound(sound_->codec(), stream_millisecond)));
        TRY(attach_text(muxer_->context(), clip_tags::scene_file, "application/json",
                        scene_to_json(said_of_clip(described_))));
        add_clip_tags(muxer_->context(), scene_.rate, clip_format_version);
        av_dict_set(&muxer_->context().metadata, clip_tags::stream_tag, "1", 0);
        TRY(muxer_->begin("live=1"));
        header_ = muxer_->take();
        return {};
    }

    Result<void> write_picture(std::size_t track, const PlaneView& plane, const PictureLabel& label,
                               std::int64_t time_ms, bool is_key) {
        TRY_ASSIGN(auto packet, tracks_[track].encoder->encode(plane, is_key));
        const AVCodecID codec = muxer_->context().streams[track]->codecpar->codec_id;
        TRY(add_block_addition(*packet, codec, 1, label));
        packet->pts = packet->dts = time_ms;
        packet->duration = 0;  // known from the next frame
        return muxer_->write(*packet, static_cast<int>(track), stream_millisecond);
    }

    const SceneDescription described_;
    const Scene& scene_;
    FrameCheck check_;
    std::vector<Track> tracks_;  // track k is stream k
    std::optional<StreamSound> sound_;
    int sound_stream_ = 0;
    std::vector<std::uint8_t> header_;
    const std::unique_ptr<MemoryMuxer> muxer_;
};

// --- MPEG-TS

constexpr AVRational clock_90_khz{1, 90'000};
constexpr std::int64_t mpegts_ns = 1'000'000'000;
/// Pictures are stamped this much later than their bytes come: stock players need it to have them in time.
constexpr int mpegts_delay_us = 50'000;

class MpegtsMuxer final : public StreamMuxer {
public:
    explicit MpegtsMuxer(const SceneDescription& described) : described_(described) {}
    std::span<const std::uint8_t> header() const override { return {}; }
    std::span<const std::uint8_t> padding() const override {
        static constexpr std::array<std::uint8_t, 188> null_packet{0x47, 0x1F, 0xFF, 0x10};
        return null_packet;
    }

    Result<Block> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                      bool is_key) override {
        if (!encoder_) {
            TRY(open(frame));
            is_key = true;
        }
        TRY_ASSIGN(auto packets, encoder_->encode(frame, label, is_key));
        std::int64_t tick = av_rescale(time_ns, clock_90_khz.den, mpegts_ns);
        if (newest_) tick = std::max(tick, *newest_ + 1);
        newest_ = tick;
        if (is_key) av_opt_set(muxer_->context().priv_data, "mpegts_flags", "+resend_headers", 0);
        for (std::size_t k = 0; k < packets.size(); ++k) {
            AVPacket& packet = *packets[k];
            packet.pts = packet.dts = tick;
            TRY(muxer_->write(packet, static_cast<int>(k), clock_90_khz));
        }
        return Block{label.frame, is_key, muxer_->take()};
    }

private:
    Result<void> open(const RawFrame& first) {
        TRY_ASSIGN(auto encoder, LabelledEncoder::open(first, described_, TrackCoding::h264_quick));
        TRY_ASSIGN(auto muxer, MemoryMuxer::open("mpegts"));
        muxer->context().max_delay = mpegts_delay_us;
        for (std::size_t k = 0; k < encoder.tracks(); ++k) {
            TRY_ASSIGN(AVStream* const stream, muxer->add_stream(clock_90_khz));
            TRY(encoder.describe(k, *stream->codecpar));
        }
        // States each picture's length if possible, so that no receiver waits for the next picture to know
        // its end.
        TRY(muxer->begin("omit_video_pes_length=0"));
        encoder_.emplace(std::move(encoder));
        muxer_ = std::move(muxer);
        return {};
    }

    const SceneDescription described_;
    std::optional<LabelledEncoder> encoder_;
    std::unique_ptr<MemoryMuxer> muxer_;
    std::optional<std::int64_t> newest_;  // tick
};

}  // namespace

Result<std::unique_ptr<StreamMuxer>> open_matroska_stream(const SceneDescription& described,
                                                          const std::optional<SoundPart>& sound) {
    TRY(check_storable("the stream", described));
    std::optional<StreamSound> opened;
    if (sound) TRY(assign(opened, StreamSound::open(*sound)));
    TRY_ASSIGN(auto muxer, MemoryMuxer::open("matroska"));
    return std::make_unique<MatroskaStream>(described, std::move(opened), std::move(muxer));
}

Result<std::unique_ptr<StreamMuxer>> make_mpegts_muxer(const SceneDescription& described) {
    TRY(check_storable("the stream", described));
    return std::make_unique<MpegtsMuxer>(described);
}

Result<std::unique_ptr<MemoryMuxer>> MemoryMuxer::open(const char* format) {
    silence_ffmpeg();
    AVFormatContext* context = nullptr;
    const int status = avformat_alloc_output_context2(&context, nullptr, format, nullptr);
    if (status < 0)
        return Error{ErrorKind::internal, "muxer " + std::string(format) + ": " + ffmpeg_text(status)};
    std::unique_ptr<MemoryMuxer> muxer(new MemoryMuxer(context));
    context->flags |= AVFMT_FLAG_BITEXACT;  // no random identifiers, no dates: same frames, same bytes
    constexpr int buffer_bytes = 1 << 16;
    auto* const buffer = static_cast<unsigned char*>(av_malloc(buffer_bytes));
    if (buffer)
        context->pb = avio_alloc_context(buffer, buffer_bytes, 1, muxer.get(), nullptr, append, nullptr);
    if (context->pb) return muxer;
    av_free(buffer);
    return muxer->check(AVERROR(ENOMEM)).error();
}

int MemoryMuxer::append(void* own, MuxedBytes* bytes, int count) {
    auto& all = static_cast<MemoryMuxer*>(own)->bytes_;
    try {
        all.insert(all.end(), bytes, bytes + count);
    } catch (const std::bad_alloc&) {
        return AVERROR(ENOMEM);
    }
    return count;
}

Result<int> MemoryMuxer::add_sound(const AVCodecParameters& codec, AVRational tick) {
    TRY_ASSIGN(AVStream* const stream, add_stream(tick));
    if (avcodec_parameters_copy(stream->codecpar, &codec) < 0) return memory_error();
    stream->codecpar->codec_tag = 0;  // of the other container
    return stream->index;
}

Result<StreamSound> StreamSound::open(const SoundPart& part) {
    TRY_ASSIGN(auto sound, StoredSound::open(part));
    return StreamSound(part, std::move(sound));
}

Result<void> StreamSound::give_until(std::int64_t until_ms, const Take& take) {
    while (true) {
        TRY_ASSIGN(const auto packet, sound_->next(until_ms - begin_ms_));
        if (!packet) return {};
        packet->pts += begin_ms_;
        packet->dts += begin_ms_;
        TRY(take(*packet));
    }
}

Result<void> StreamSound::give(std::uint64_t epoch, std::int64_t time_ns, const Take& take) {
    const std::int64_t time_ms = (time_ns + 500'000) / 1'000'000;
    if (epoch_ && *epoch_ != epoch) {
        TRY(give_until(time_ms - 1, take));
        TRY_ASSIGN(sound_, StoredSound::open(part_));
        begin_ms_ = time_ms;
    }
    epoch_ = epoch;
    return give_until(time_ms, take);
}

}  // namespace touchable
