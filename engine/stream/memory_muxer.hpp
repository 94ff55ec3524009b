// SPDX-License-Identifier: Apache-2.0
#pragma once

// Puts a stream into containers (stream_muxers.cpp, hls_output.cpp): FFmpeg's muxers, writing to memory, and
// the sound of a clip that is sent in rounds.

#include <cstdint>
#include <functional>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/sound.hpp"

namespace touchable {

/// A container that is written sequentially, and taken piece by piece.
class MemoryMuxer : NonCopyable {
public:
    /// `format`: FFmpeg's name for it.
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
    /// Adds sound with the parameters of another container, and returns the stream's number.
    Result<int> add_sound(const AVCodecParameters& codec, AVRational tick);
    /// `options`: of the muxer, "key=value:key=value".
    Result<void> begin(const std::string& options) {
        AVDictionary* read = nullptr;
        int status = av_dict_parse_string(&read, options.c_str(), "=", ":", 0);
        if (status >= 0) status = avformat_write_header(context_, &read);
        av_dict_free(&read);
        return check(status);
    }
    /// Writes a packet whose times are in `tick`.
    Result<void> write(AVPacket& packet, int stream, AVRational tick) {
        packet.stream_index = stream;
        av_packet_rescale_ts(&packet, tick, context_->streams[stream]->time_base);
        return check(av_write_frame(context_, &packet));
    }
    /// Writes what the muxer has buffered.
    Result<void> flush() { return check(av_write_frame(context_, nullptr)); }
    /// Returns the bytes written since the last call.
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

/// The sound of a file, begun anew with each round of a loop. Used by one thread.
class StreamSound {
public:
    /// Refused (ErrorKind::input) as by StoredSound.
    static Result<StreamSound> open(const SoundPart& part);

    const AVCodecParameters& codec() const { return sound_->codec(); }
    /// Passes `take` all packets up to a frame's time, in milliseconds of the stream. A frame of another
    /// epoch (RawFrame::epoch) begins the sound anew; the rest of the old round is left out.
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
