#pragma once

// Tracks: the pictures of one plane, encoded and decoded packet by packet, and the first track of any video
// file.
//
// Writing: TrackEncoder::open with a TrackCoding and the first plane, `describe` into the container, then
// `encode` for each plane. Reading, in three depths: PacketDecoder turns packets into FFmpeg's frames,
// TrackDecoder into planes of a role, with checksums verified and codings undone, and VideoFile gives the
// frames of a file of any kind, with their times, and goes to any of them.
//
// All are lossless for depth, haptic and height as long as TrackCoding is neither h264_visual nor
// h264_reduced; lossy_note has the words where another program's codec was not. Errors name track and frame.
// Objects are used by one thread at a time, different ones by different threads at once; FFmpeg may decode
// slices of large pictures on threads of its own.

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/decoding.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

/// FFmpeg's name of a codec; of ours "t3dz" or "t3d2"; the FourCC of one that neither knows.
std::string codec_name(const AVCodecParameters& stored);
/// The version of the codec that is our own (docs/codecs.md), 1 or 2, in a track; nothing where the codec is
/// another.
std::optional<int> rank_zstd_version(const AVCodecParameters& stored);
/// What a person should know where a plane of touch was stored by a codec (its `codec_name`) that changes
/// values.
std::optional<std::string> lossy_note(PlaneRole role, const std::string& codec);

/// How a track is encoded. All but the last two keep every sample (docs/codecs.md).
enum class TrackCoding {
    ffv1,          ///< every picture on its own: smallest where they are noisy, slow
    h264_quick,    ///< predicted from the picture before; quickest to encode and decode
    h264_thrifty,  ///< the same, smaller
    rank_zstd,     ///< every picture on its own, by a codec of our own: grey of two bytes a sample only,
                   ///< quick whatever the pictures hold (docs/codecs.md)
    h264_visual,   ///< as good as the eye can tell; colour only
    h264_reduced,  ///< the same, of about half the bytes
};

/// Encodes one track of a clip, a packet for each picture.
class TrackEncoder {
public:
    /// `first`: a plane as all will be (size, sample size). An error of kind usage where this coding has no
    /// pictures of its size.
    static Result<std::unique_ptr<TrackEncoder>> open(PlaneRole role, TrackCoding coding,
                                                      const PlaneView& first, const Scene& scene);
    virtual ~TrackEncoder() = default;

    /// Says in a container how the track is encoded. An error where memory runs out.
    virtual Result<void> describe(AVCodecParameters& stored) const = 0;
    /// The packet of a plane like the first; without a time. Where `on_its_own`, decoding can begin with it.
    /// `messages`: what H.264 says in it beside the picture, each an unregistered SEI message (ISO/IEC
    /// 14496-10, D.1.7): a UUID of 16 bytes, and what follows it. No other coding has room for them.
    virtual Result<PacketPtr> encode(const PlaneView& plane, bool on_its_own,
                                     std::span<const std::string> messages = {}) = 0;
};

/// Samples of two bytes go into codecs of one as two planes: the high eight bits, and those below them.
enum class PlanePart { whole, high, low };

/// Eight bits of each sample, in `memory` where they are not the plane itself; `low_bits`: of a sample of two
/// bytes, those that are in the low part.
PlaneView part_of(const PlaneView& plane, PlanePart part, int low_bits, std::vector<std::uint8_t>& memory);

/// Turns the packets of a track into pictures: FFmpeg's decoders, and one of our own, which takes packets and
/// gives pictures as FFmpeg's do, with FFmpeg's error numbers.
class PacketDecoder {
public:
    /// For a stream whose codec is read (TrackDecoder::open checks that). Messages begin with `where`. Of
    /// larger pictures nothing is decoded. Where several `tracks` are decoded side by side, each has its
    /// share of the cores.
    static Result<std::unique_ptr<PacketDecoder>> open(const AVStream& stream, const std::string& where,
                                                       std::int64_t most_pixels = largest_picture,
                                                       std::size_t tracks = 1);
    static constexpr std::int64_t largest_picture = std::int64_t{16384} * 16384;  ///< pixels
    virtual ~PacketDecoder() = default;

    /// The next packet; null after the last.
    virtual int send(const AVPacket* packet) = 0;
    /// The next picture. EAGAIN while another packet is needed, EOF when all are out.
    virtual int receive(AVFrame& picture) = 0;
    /// Forgets all packets.
    virtual void flush() = 0;
    /// Whether each packet is a picture, which comes out before the next goes in.
    virtual bool is_one_packet_each() const = 0;
};

/// Decodes one track of a clip: packets in, planes out in the order of presentation.
class TrackDecoder {
public:
    struct Picture {
        std::int64_t number = 0;     ///< of the first frame that shows it, from 0
        std::int64_t frames = 1;     ///< that show it
        std::int64_t timestamp = 0;  ///< in the stream's time base
        Plane plane;  ///< as stored; colour and haptic as 8-bit RGB or as grey; none if left out
    };

    /// `file` names the clip in messages; so many `tracks` are decoded side by side.
    static Result<TrackDecoder> open(const AVStream& stream, PlaneRole role, const std::string& file,
                                     std::size_t tracks = 1);

    /// Codec, and once the first picture is out, its size and format.
    const TrackInfo& info() const { return info_; }
    PlaneRole role() const { return role_; }
    std::int64_t pixels() const { return pixels_; }
    /// No packet is needed any more.
    bool drained() const { return drained_; }
    /// "clip.mkv: track depth".
    std::string name() const { return file_ + ": track " + info_.role; }
    /// "clip.mkv: track depth, frame 7", for the picture that comes next.
    std::string where() const;

    /// The next packet; null after the last. Only when `receive` had nothing.
    Result<void> send(const AVPacket* packet);
    /// Known with the first packet.
    bool has_additions() const { return has_additions_.value_or(false); }
    /// Whether the next picture is what the next packet holds, so that it can be left out.
    bool is_one_packet_each() const;
    /// The picture of this packet, which must be sound, without its plane. None after it is decoded, but
    /// where `restart` says so.
    Result<Picture> skip(const AVPacket& packet);
    /// The next packet holds this frame, and decoding can begin there.
    void restart(std::int64_t number);
    /// The next picture; nothing while another packet is needed, or when all are out.
    Result<std::optional<Picture>> receive();
    /// The same as FFmpeg decodes it, of a track whose pictures are not planes but hold them.
    struct Decoded {
        std::int64_t timestamp = 0;  ///< in the stream's time base
        FramePtr frame;
    };
    Result<std::optional<Decoded>> receive_frame();

private:
    TrackDecoder() = default;
    Result<void> read_tags(const AVStream& stream);
    Result<std::int64_t> frames_of(const AVPacket& packet);
    Result<FramePtr> decoded();
    std::int64_t passed();
    Result<void> check_format(const AVFrame& frame);
    Result<Plane> plane(FramePtr frame);
    Result<Plane> rgb(const AVFrame& frame);
    Result<Plane> joined(const AVFrame& frame) const;
    bool is_split() const { return stated_bits_ > 0 && codec_ != AV_CODEC_ID_NONE; }

    PlaneRole role_ = PlaneRole::depth;
    std::string file_;
    TrackInfo info_;
    std::unique_ptr<PacketDecoder> decoder_;
    AVCodecID codec_ = AV_CODEC_ID_NONE;  // FFmpeg's number; none for the codec that is our own
    std::int64_t pixels_ = 0;
    RgbConverter converter_;
    bool says_lossless_ = false;
    bool has_slice_checksums_ = false;   // as FFV1 has them from version 3 on
    int stated_bits_ = 0;                // of samples stored as two bytes apart; 0: they are not
    std::optional<bool> has_additions_;  // all packets or none, as the first has them
    std::deque<std::int64_t> frames_;    // that the pictures of packets sent, not received, stay
    std::string format_;                 // of the pictures, FFmpeg's name
    int coded_height_ = 0;
    std::int64_t received_ = 0;  // frames
    bool drained_ = false;
};

/// The rate of frames at these times, in order, in units of `tick` seconds. Of those that `said` has (0/0:
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
    /// messages call the track. `track`: its number in the file, where another file says it.
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
