#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/reserved_output.hpp"
#include "engine/picture/sound_track.hpp"

namespace touchable {

/// The sound of a film that is being written, for this room's .cpp files only: two channels at
/// SoundTrack::rate, from the film's first picture on. Calls give FFmpeg's status, negative where they
/// failed.
class FilmSound {
public:
    /// Adds its stream, before the muxer's header is written: AAC, or FLAC where `is_exact`. The muxer writes
    /// to `room`.
    int open(AVFormatContext& muxer, ReservedOutput& room, bool is_exact);
    /// The sample that comes next.
    std::int64_t next() const { return next_; }
    int add(std::span<const StereoSample> samples);
    /// Silence.
    int fill_until(std::int64_t sample);
    /// Before the muxer's trailer.
    int finish();

private:
    int encode(const AVFrame* frame);
    int encode_waiting(int count);

    AVFormatContext* muxer_ = nullptr;
    ReservedOutput* room_ = nullptr;
    AVStream* stream_ = nullptr;
    CodecPtr codec_;
    FramePtr frame_;
    PacketPtr packet_;
    std::vector<StereoSample> waiting_;  // less than a frame of the codec's
    std::int64_t next_ = 0;
};

}  // namespace touchable
