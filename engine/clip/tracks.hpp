// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tracks of pictures: those of one plane, encoded and decoded packet by packet; and the first track of any
// video file.
//
// Writing: TrackEncoder::open with a TrackCoding and the first plane, then `encode` for each plane;
// part_tracks cuts planes for codecs of one byte a sample. Reading, in three depths: PacketDecoder turns
// packets into FFmpeg's frames, TrackDecoder into planes of a role, with checksums verified and codings
// undone, and VideoFile gives the frames of a file of any kind, with their times, and seeks. What a clip's
// file has beside its tracks' pictures is in containers.hpp.
//
// All codings but h264_visual and h264_reduced are lossless; lossy_note tells if another program's codec was
// not. Errors name track and frame, or the file.
// Threads: one at a time uses an object, different ones may use different objects at once; FFmpeg may decode
// slices of large pictures on its own. Functions keep no state.

#include <deque>
#include <span>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/decoding.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A codec's name: FFmpeg's; "t3dz" or "t3d2" for ours; the FourCC of an unknown one.
std::string codec_name(const AVCodecParameters& stored);
/// The note if a plane of touch was stored by a lossy codec (its `codec_name`); otherwise nullopt.
std::optional<ClipNote> lossy_note(PlaneRole role, const std::string& codec);

/// How a track is encoded. All but the last two keep every sample (docs/codecs.md).
enum class TrackCoding {
    ffv1,               ///< every picture on its own, slow to decode
    h264_quick,         ///< predicted from the picture before; quickest to encode and decode
    h264_thrifty,       ///< the same, smaller
    rank_zstd,          ///< every picture on its own, by a codec of our own: grey of two bytes a sample only,
                        ///< quick whatever the pictures hold (docs/codecs.md)
    rank_zstd_thrifty,  ///< the same, smaller; as quick to decode, but 30 times slower to encode
    h264_visual,        ///< as good as the eye can tell; colour only
    h264_reduced,       ///< the same, of about half the bytes
};

/// Refuses what only x264 can do. `what`: such as "an MP4 file".
Result<void> check_x264(const std::string& what);

/// Encodes one track of a clip, a packet for each picture.
class TrackEncoder {
public:
    /// `first`: a plane like all to come (size, sample size). An error of kind usage if this coding does not
    /// support its size.
    static Result<std::unique_ptr<TrackEncoder>> open(PlaneRole role, TrackCoding coding,
                                                      const PlaneView& first, const Scene& scene);
    virtual ~TrackEncoder() = default;

    /// Sets a container's parameters of the track. An error if memory runs out.
    virtual Result<void> describe(AVCodecParameters& stored) const = 0;
    /// The packet of a plane like the first, without a time. `on_its_own`: decoding can begin with it.
    /// `messages`: only for H.264; unregistered SEI messages (ISO/IEC 14496-10, D.1.7), each a UUID of 16
    /// bytes and its payload.
    virtual Result<PacketPtr> encode(const PlaneView& plane, bool on_its_own,
                                     std::span<const std::string> messages = {}) = 0;
};

/// Two-byte samples go into one-byte codecs as two planes: the high eight bits, and the bits below them.
enum class PlanePart { whole, high, low };

/// A track of a plane for a one-byte codec.
struct PartTrack {
    PlaneRole role;
    PlanePart part;
    int bits;  ///< of the plane's samples; 8 if the part is whole
    std::unique_ptr<TrackEncoder> encoder{};
    std::vector<std::uint8_t> bytes{};  ///< of the newest picture of a part
    /// "depth", "depth_low".
    std::string name() const;
    /// What the track has of a frame: in `bytes`, unless it is the plane itself.
    PlaneView of(const RawFrame& frame);
};
/// The tracks of a frame's planes, without encoders. Colour comes first, which ordinary players show, and low
/// parts last.
std::vector<PartTrack> part_tracks(const RawFrame& first, const Scene& scene);

/// A plane that shows a picture of grey or RGB24 and owns it. `bits`: of a grey sample as stored.
Plane plane_from(FramePtr picture, int bits = 0);

/// Turns the packets of a track into pictures: FFmpeg's decoders, and one of our own, which takes packets and
/// gives pictures as FFmpeg's do, with FFmpeg's error numbers.
class PacketDecoder {
public:
    /// For a stream whose codec is read (TrackDecoder::open checks that). Messages begin with `where`. Larger
    /// pictures than `most_pixels` are not decoded. `tracks` that are decoded in parallel share the cores.
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

    /// `file` names the clip in messages; `tracks`: number of tracks decoded in parallel.
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
    std::string where() const { return name() + ", frame " + std::to_string(received_); }

    /// The next packet; null after the last. Only when `receive` had nothing.
    Result<void> send(const AVPacket* packet);
    /// Known with the first packet.
    bool has_additions() const { return has_additions_.value_or(false); }
    /// Whether the next packet holds the next picture, so that decoding can be skipped.
    bool is_one_packet_each() const {
        return has_additions_.value_or(false) || decoder_->is_one_packet_each();
    }
    /// The picture of this packet, without its plane; an error if the packet is damaged. Later packets cannot
    /// be decoded before `restart`.
    Result<Picture> skip(const AVPacket& packet);
    /// The next packet holds this frame, and decoding can begin there.
    void restart(std::int64_t number);
    /// The next picture; nothing while another packet is needed, or when all are out.
    Result<std::optional<Picture>> receive();
    /// A picture as FFmpeg decodes it, for tracks whose pictures are not planes but contain them.
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
    AVCodecID codec_ = AV_CODEC_ID_NONE;  // FFmpeg's number; none for our own codec
    std::int64_t pixels_ = 0;
    RgbConverter converter_;
    bool says_lossless_ = false;
    bool has_slice_checksums_ = false;   // as FFV1 has them from version 3 on
    int stated_bits_ = 0;                // of samples stored as separate bytes; 0: they are not
    std::optional<bool> has_additions_;  // all packets or none, like the first
    std::deque<std::int64_t> frames_;    // frames of packets sent, not received
    std::string format_;                 // of the pictures, FFmpeg's name
    int coded_height_ = 0;
    std::int64_t received_ = 0;  // frames
    bool drained_ = false;
};

/// The pictures of any video that `Demuxer::open_video` opens, as FFmpeg decodes them: its first track of
/// pictures, or among several the one that is disparity or is named DEPTH or COLOR, according to the role.
class VideoFile {
public:
    struct MeasuredRate {
        FrameRate rate;
        bool is_kept = true;  ///< all frames keep it, to within a tick
    };
    /// The rate of frames at these times, in order, in units of `tick` seconds: the first that all frames
    /// keep to within a tick among those in `said` (0/0: none), usual ones and the mean; otherwise the
    /// frames' own times. If some of these are less than a millisecond apart: the mean, with `is_kept` false.
    static MeasuredRate measured_rate(const std::vector<std::int64_t>& times, AVRational tick,
                                      const std::vector<AVRational>& said);

    /// Reads the file once from end to end, without decoding, for the times of its frames. `role` selects the
    /// track and names it in messages. `track`: its number, if another file gives it.
    static Result<std::unique_ptr<VideoFile>> open(const SourceFile& file, PlaneRole role,
                                                   std::optional<std::uint32_t> track = {});

    const SourceFile& file() const { return file_; }
    /// Whether the track is the disparity of an iPhone's Cinematic video.
    bool is_disparity() const { return is_disparity_; }
    /// Whether the file has pictures that are no disparity.
    bool has_other_pictures() const;
    /// The stream's number in the file.
    int stream() const { return stream_; }

    const FrameRate& rate() const { return rate_.rate; }
    std::int64_t count() const { return static_cast<std::int64_t>(times_.size()); }
    /// When the first frame is shown, seconds of the file's clock.
    double start() const;
    /// Seconds after the first frame.
    double seconds(std::int64_t frame) const;
    /// The frame that is nearest to a time.
    std::int64_t nearest(double seconds) const;
    /// The note on frames not played at their times, the choice among several tracks, or a truncated file.
    const std::optional<std::string>& note() const { return note_; }
    /// With size and format once a picture was read.
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
    /// Makes `next` return this frame, from 0 to `count`.
    Result<void> seek(std::int64_t frame);
    /// The last keyframe at or before this frame.
    std::int64_t access_point(std::int64_t frame) const;

private:
    VideoFile(SourceFile file, PlaneRole role, std::optional<std::uint32_t> track)
        : file_(std::move(file)), role_(role), track_(track) {}
    Result<void> rewind();
    Result<void> read_times();
    /// Number of other tracks of pictures; 0 if this one is certainly the right one.
    int other_tracks() const;
    Result<bool> begin_at(std::int64_t key);
    Result<std::optional<TrackDecoder::Decoded>> decode();

    SourceFile file_;
    PlaneRole role_;
    std::optional<std::uint32_t> track_;
    MeasuredRate rate_;
    std::optional<std::string> note_;
    std::vector<std::int64_t> times_;  // of frames, in the stream's time base
    std::vector<std::int64_t> keys_;   // frames that decoding can begin with

    // Reading position, reset by `rewind`.
    std::unique_ptr<Demuxer> demuxer_;
    int stream_ = 0;
    bool is_lossless_ = false, is_disparity_ = false;
    std::optional<TrackDecoder> decoder_;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    bool is_lost_ = false;     // after an error: the decoder is not at `number_`
    FramePtr held_;            // that frame, if decoded already
};

}  // namespace touchable
