#pragma once

// Used to put a stream into containers (stream_muxers.cpp, hls_output.cpp): FFmpeg's
// muxers, whose bytes are taken from memory, and the sound of a clip that is sent round by round.

#include <cstdint>
#include <functional>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/sound.hpp"

namespace touchable {

/// A container that is written forwards, and taken piece by piece.
class MemoryMuxer : NonCopyable {
public:
    /// `format`: as FFmpeg calls it.
    static Result<std::unique_ptr<MemoryMuxer>> open(const char* format);
    ~MemoryMuxer() {
        if (AVIOContext* io = context_->pb) {
            av_freep(&io->buffer);
            avio_context_free(&io);
        }
        avformat_free_context(context_);
    }

    AVFormatContext& context() { return *context_; }
    /// Adds a stream, before `begin`. `tick`: the unit of its times; the muxer may choose another.
    Result<AVStream*> add_stream(AVRational tick) {
        AVStream* const stream = avformat_new_stream(context_, nullptr);
        if (!stream) return memory_error();
        stream->time_base = tick;
        return stream;
    }
    /// Adds sound as another container has it, and returns the stream's number.
    Result<int> add_sound(const AVCodecParameters& codec, AVRational tick);
    /// `options`: of the muxer, "key=value:key=value".
    Result<void> begin(const std::string& options) {
        AVDictionary* read = nullptr;
        int status = av_dict_parse_string(&read, options.c_str(), "=", ":", 0);
        if (status >= 0) status = avformat_write_header(context_, &read);
        av_dict_free(&read);
        return check(status);
    }
    /// A packet whose times are in `tick`.
    Result<void> write(AVPacket& packet, int stream, AVRational tick) {
        packet.stream_index = stream;
        av_packet_rescale_ts(&packet, tick, context_->streams[stream]->time_base);
        return check(av_write_frame(context_, &packet));
    }
    /// Writes what the muxer holds back.
    Result<void> flush() { return check(av_write_frame(context_, nullptr)); }
    /// The bytes of all that was written since the last time.
    std::vector<std::uint8_t> take() {
        avio_flush(context_->pb);
        return std::exchange(bytes_, {});
    }

private:
    explicit MemoryMuxer(AVFormatContext* context) : context_(context) {}
    static int append(void* own, MuxedBytes* bytes, int count);
    Result<void> check(int status) const {
        if (status >= 0 && context_->pb && context_->pb->error < 0) status = context_->pb->error;
        if (status >= 0) return {};
        const std::string format = context_->oformat->name;
        return Error{ErrorKind::internal, "muxer " + format + ": " + ffmpeg_text(status)};
    }

    AVFormatContext* context_;
    std::vector<std::uint8_t> bytes_;
};

/// The sound of a file, heard from its beginning again and again, as rounds of a loop begin. One thread.
class StreamSound {
public:
    /// Refused (ErrorKind::input) as by StoredSound.
    static Result<StreamSound> open(const SoundPart& part);

    const AVCodecParameters& codec() const { return sound_->codec(); }
    /// Gives `take` all packets that are heard up to a frame, times in milliseconds of the stream. With a
    /// frame of another epoch (RawFrame::epoch) the sound begins anew; what was not heard by then is left
    /// out.
    using Take = std::function<Result<void>(AVPacket&)>;
    Result<void> give(std::uint64_t epoch, std::int64_t time_ns, const Take& take);

private:
    StreamSound(const SoundPart& part, std::unique_ptr<StoredSound> sound)
        : part_(part), sound_(std::move(sound)) {}
    Result<void> give_until(std::int64_t until_ms, const Take& take);

    SoundPart part_;
    std::unique_ptr<StoredSound> sound_;
    std::int64_t begin_ms_ = 0;
    std::optional<std::uint64_t> epoch_;  // of the newest frame
};

}  // namespace touchable
