#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/clip/track_decoder.hpp"
#include "engine/picture/demuxer.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The rate of frames at these times, in order, in units of `tick` seconds. Of those that others say (0/0:
/// nothing) and those that are usual, the first that all frames keep to within a tick, or the mean of all;
/// otherwise their own times. Where some of these are less than a millisecond apart, the mean, to which
/// frames do not keep.
struct MeasuredRate {
    FrameRate rate;
    bool is_kept = true;
};
MeasuredRate rate_of_times(const std::vector<std::int64_t>& times, AVRational tick,
                           const std::vector<AVRational>& said);

/// The pictures of a video of any kind that `Demuxer::open_video` opens: its first track of pictures, or of
/// several the one that is disparity, or is named DEPTH or COLOR, as the role is, each as FFmpeg decodes it.
class VideoFile {
public:
    /// Reads the file once from end to end, without decoding, for the times of its frames. `role` is how
    /// messages call the track. `track`: its number in the file, where somebody says it.
    static Result<std::unique_ptr<VideoFile>> open(const SourceFile& file, PlaneRole role,
                                                   std::optional<std::uint32_t> track = {});

    const SourceFile& file() const { return file_; }
    /// Of an iPhone's Cinematic video, whose depth is this one's track.
    bool is_disparity() const { return is_disparity_; }
    /// Whether the file has pictures that are no disparity.
    bool has_other_pictures() const;

    const FrameRate& rate() const { return rate_.rate; }
    std::int64_t count() const { return static_cast<std::int64_t>(times_.size()); }
    /// When the first frame is shown, seconds of the file's clock.
    double start() const;
    /// Seconds after the first frame.
    double seconds(std::int64_t frame) const;
    /// The frame that is nearest to a time.
    std::int64_t nearest(double seconds) const;
    /// What a person should know of frames that are not played at their times.
    const std::optional<std::string>& note() const { return note_; }
    /// Once a picture was read, with its size and format.
    TrackInfo info() const {
        TrackInfo info = decoder_->info();
        info.lossless = is_lossless_;
        return info;
    }
    /// "video.webm: track depth, frame 7".
    std::string where(std::int64_t frame) const {
        return decoder_->name() + ", frame " + std::to_string(frame);
    }

    /// The next picture; null after the last.
    Result<FramePtr> next();
    /// `next` gives this frame next, from 0 to `count`.
    Result<void> seek(std::int64_t frame);
    /// The last frame up to this one that decoding can begin with.
    std::int64_t access_point(std::int64_t frame) const;

private:
    VideoFile(SourceFile file, PlaneRole role, std::optional<std::uint32_t> track)
        : file_(std::move(file)), role_(role), track_(track) {}
    Result<void> rewind();
    Result<void> read_times();
    Result<bool> begin_at(std::int64_t key);
    Result<std::optional<TrackDecoder::Decoded>> decode();

    SourceFile file_;
    PlaneRole role_;
    std::optional<std::uint32_t> track_;
    MeasuredRate rate_;
    std::optional<std::string> note_;
    std::vector<std::int64_t> times_;  // of frames, in the stream's time base
    std::vector<std::int64_t> keys_;   // frames that decoding can begin with

    // Where the reading is; `rewind` makes it anew.
    std::unique_ptr<Demuxer> demuxer_;
    int stream_ = 0;
    bool is_lossless_ = false, is_disparity_ = false;
    std::optional<TrackDecoder> decoder_;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    bool is_lost_ = false;     // after an error the decoder is not where `number_` says
    FramePtr held_;            // that frame, where it is decoded already
};

}  // namespace touchable
