#pragma once

// Tracks of clips: the pictures of one plane, encoded and decoded packet by packet; the first track of any
// video file; and the metadata of our files' tracks.
//
// Writing: TrackEncoder::open with a TrackCoding and the first plane, add_plane_stream (or `describe`) into
// the container, then `encode` for each plane. Reading, in three depths: PacketDecoder turns packets into
// FFmpeg's frames, TrackDecoder into planes of a role, with checksums verified and codings undone, and
// VideoFile gives the frames of a file of any kind, with their times, and seeks.
//
// Matroska describes a clip by tags of the file and of each track (clip_tags), an addition to each block
// (BlockAddition), and the scene and the frames' times attached as text; MP4 by tags and an MPEG-4 scene
// (Mp4Scene). A ClipContainer reads all that from an opened file, for any container. MuxedClipWriter is the
// common part of the containers' writers: a derived class writes the frames.
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
#include "engine/clip/clip_file.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/picture/decoding.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/sound.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

// Matroska tags: T3D_VERSION and T3D_RATE of the file; of each track T3D_ROLE, T3D_LOSSLESS if it keeps every
// value, and T3D_BITS, the bits of samples that are stored as bytes (by FFmpeg's codecs the high ones in the
// upper half of the picture); and names of attachments.
namespace clip_tags {

inline constexpr const char* version_tag = "T3D_VERSION";
inline constexpr const char* rate_tag = "T3D_RATE";
/// Tag of the file: it is a stream, valid up to where it was cut off.
inline constexpr const char* stream_tag = "T3D_STREAM";
inline constexpr const char* role_tag = "T3D_ROLE";
inline constexpr const char* lossless_tag = "T3D_LOSSLESS";
inline constexpr const char* bits_tag = "T3D_BITS";
inline constexpr const char* scene_file = "scene.json";
/// The attachment of a clip of variable rate (frame_times_text).
inline constexpr const char* times_file = "timestamps.txt";
/// The attachment of camera poses (timed_poses_text).
inline constexpr const char* poses_file = "poses.txt";

/// Distance of keyframes in all tracks, frames; from version 2 on.
inline constexpr std::int64_t access_interval = 15;

/// "30000/1001": exact, because Matroska rounds timestamps to milliseconds.
std::string rate_text(const FrameRate& rate);
bool same_rate(const FrameRate& a, const FrameRate& b);
/// The note if a scene file plays frames at another rate than they were recorded at; otherwise nullopt.
std::optional<std::string> rate_note(const FrameRate& played, const FrameRate& recorded);

}  // namespace clip_tags

inline constexpr int clip_format_version = 2;

/// A stream's label of each picture (docs/streaming.md), by which pictures of one moment are known whatever
/// became of their timestamps on the way.
struct PictureLabel {
    std::int64_t frame = 0;     ///< of the stream: counts up, also from one round of a loop to the next
    std::int64_t taken_ns = 0;  ///< by the sender's clock, ns since 1970 (UTC); 0: not known
    bool operator==(const PictureLabel&) const = default;
};

/// Metadata of each stored picture, in its block's BlockAdditions (docs/codecs.md): for how many frames the
/// picture stays, and a checksum, since not every codec has one.
struct BlockAddition {
    std::int64_t frames = 1;  ///< 1 to access_interval
    /// The checksum matches the packet, `frames` and the label, and `frames` is in range.
    bool sound = true;
    std::optional<PictureLabel> label{};  ///< in a stream (docs/streaming.md)
};

/// Adds a BlockAddition to a packet for a Matroska file. An error if memory runs out.
Result<void> add_block_addition(AVPacket& packet, AVCodecID codec, std::int64_t frames,
                                const std::optional<PictureLabel>& label = {});
/// A packet's BlockAddition; nullopt if it has none.
std::optional<BlockAddition> block_addition_of(const AVPacket& packet);

/// The scene as stored in a clip: without the folder or video of its frames.
SceneDescription said_of_clip(const SceneDescription& described);

/// A codec's name: FFmpeg's; "t3dz" or "t3d2" for ours; the FourCC of an unknown one.
std::string codec_name(const AVCodecParameters& stored);
/// The version of our own codec (docs/codecs.md), 1 or 2, in a track; nullopt for another codec.
std::optional<int> rank_zstd_version(const AVCodecParameters& stored);
/// The note if a plane of touch was stored by a lossy codec (its `codec_name`); otherwise nullopt.
std::optional<std::string> lossy_note(PlaneRole role, const std::string& codec);

/// A track's time base, exact at a constant rate: 30000/1001 frames/s have one of 1001/30000 s.
inline AVRational time_base_of(const FrameRate& rate) {
    if (rate.own_times) return {1, 1'000'000};
    return {static_cast<int>(rate.den), static_cast<int>(rate.num)};
}
/// When a frame is shown, in this time base.
inline std::int64_t tick_of(const FrameRate& rate, std::int64_t frame) {
    return rate.own_times ? rate.time_ns(frame) / 1000 : frame;
}

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

// Into Matroska, a file or a stream, before the muxer's header is written; errors if memory runs out.

/// Adds the file's tags: its rate and our format's version.
void add_clip_tags(AVFormatContext& muxer, const FrameRate& rate, int version);
/// Adds a track of pictures, its times in milliseconds; `check` knows the planes.
Result<void> add_plane_stream(AVFormatContext& muxer, const TrackEncoder& encoder, PlaneRole role,
                              TrackCoding coding, const FrameCheck& check, const Scene& scene);
Result<void> attach_text(AVFormatContext& muxer, const char* name, const char* type, const std::string& text);

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

/// Reads a touchable clip's metadata from one kind of container.
class ClipContainer {
public:
    /// Which stream of a file is which plane.
    struct Track {
        PlaneRole role;
        int stream = 0;
        std::optional<int> low_stream{};  ///< has the low bits of its samples; the high eight are in `stream`
        int low_bits = 0;
        bool is_lossless = false;  ///< as the file states for the whole track; a picture's own bytes may, too
    };
    /// Names of the metadata in messages, and the newest format that is read.
    struct Words {
        const char* scene;  ///< "scene.json"
        const char* times;  ///< "timestamps.txt"
        int newest_version;
    };
    /// For a file without a stated length, read to its end: the frames that have all their pictures, and
    /// whether there is part of another.
    struct WholePart {
        std::int64_t frames = 0;
        bool is_cut = false;
        bool is_uneven = false;  ///< tracks end at different frames
    };

    virtual ~ClipContainer() = default;
    /// Opens the file, at its first byte.
    virtual Result<std::unique_ptr<Demuxer>> open() = 0;
    /// The rate at which it was recorded.
    virtual Result<FrameRate> rate(const Demuxer& file) = 0;
    /// The scene that the file states, its rate unstated.
    virtual Result<SceneDescription> scene(const Demuxer& file, const FrameRate& recorded) = 0;
    /// Its camera's poses (timed_poses_text), if the file has them.
    virtual std::optional<std::string> poses(const Demuxer& /*file*/) { return std::nullopt; }
    /// The planes' tracks, depth first. `scene` describes them.
    virtual Result<std::vector<Track>> tracks(const Demuxer& file, const Scene& scene) = 0;
    /// Whether a file just opened has an index of all its pictures.
    virtual bool has_whole_index() const { return false; }
    /// Nullopt if the file states its length.
    virtual Result<std::optional<WholePart>> whole_part(const Demuxer& /*file*/) {
        return std::optional<WholePart>();
    }
    /// Notes for the user from the calls above.
    const std::vector<std::string>& notes() const { return notes_; }
    const Words& words() const { return words_; }

protected:
    ClipContainer(const SourceFile& source, Words words)
        : source_(source), file_(source.string()), words_(words) {}
    Error refuse(const std::string& what, Hints hints = {}) const {
        return input_error(file_ + ": " + what, std::move(hints));
    }
    /// The rate in the file's tags, with the times in `own_times`, if any. An error if it is no clip of ours,
    /// or of a version to come.
    Result<FrameRate> tagged_rate(const Demuxer& file, const std::optional<std::string>& own_times) const;
    /// Parses the scene's text. An error if its rate is not the recorded one; it does not have the frames'
    /// own times.
    Result<SceneDescription> described_by(const std::string& json, const FrameRate& recorded) const;

    SourceFile source_;
    std::string file_;
    Words words_;
    std::vector<std::string> notes_;
};

std::unique_ptr<ClipContainer> matroska_container(const SourceFile& file);

/// A touchable clip's MPEG-4 scene in an MP4 file, and its tracks.
struct Mp4Scene {
    mpeg4::SceneStream stream;
    mpeg4::ClipNodes nodes;
};

/// Nullopt if a file has no such scene.
Result<std::optional<Mp4Scene>> read_mp4_scene(const SourceFile& file);
/// A plane's track number; nullopt if the scene has no such plane. Errors name no file.
Result<std::optional<std::uint32_t>> track_of_plane(const Mp4Scene& scene, PlaneRole role);

/// Writes a clip by FFmpeg's muxers, into any container: checks frames, writes sound along with them, and
/// accepts nothing after a failure.
class MuxedClipWriter : public ClipWriter {
public:
    using Muxer = std::unique_ptr<AVFormatContext, ReleasedBy<avformat_free_context>>;

    /// Opens the writer, once. Refused: a scene that cannot be stored, and sound that the container cannot
    /// hold.
    Result<void> open(const std::optional<SoundPart>& sound);

    Result<void> write(const RawFrame& frame) final { return keep(write_frame(frame)); }
    bool is_full() const final { return room_.is_full(); }
    Result<std::filesystem::path> complete() final;
    Result<void> finish() override;

protected:
    /// `format`: the container, as FFmpeg calls it.
    MuxedClipWriter(const std::filesystem::path& path, const SceneDescription& described,
                    const ClipStorage& storage, Existing existing, const char* format)
        : described_(described), storage_(storage), output_(path, existing), format_(format) {}

    /// Writes a frame that FrameCheck has passed.
    virtual Result<void> add(const RawFrame& frame) = 0;
    /// Writes what was held back, after the last frame.
    virtual Result<void> add_rest() { return {}; }
    /// Adds to a file that FFmpeg has ended.
    virtual Result<void> amend() { return {}; }

    Error refuse(const std::string& what) const {
        return input_error(output_.target().string() + ": " + what);
    }
    /// An error if FFmpeg's status is one, or the file could not be written.
    Result<void> check_status(int status) const;
    /// Adds the stream after those of the pictures, if there is sound.
    Result<void> add_sound_stream();
    Result<void> write_header(AVDictionary* options = nullptr);
    /// Writes sound up to this time into that stream.
    Result<void> write_sound(std::int64_t until_ms);
    /// Writes a packet of a picture, its times in `tick`.
    Result<void> write_picture(AVPacket& packet, std::size_t stream, AVRational tick);
    /// When a frame is shown, to the nearest millisecond.
    std::int64_t time_ms(std::int64_t frame) const;

    const SceneDescription described_;
    const Scene& scene_ = described_.scene;
    const ClipStorage storage_;
    FrameCheck check_;
    NewFile output_;
    ReservedOutput room_;
    Muxer muxer_;

private:
    Result<void> keep(Result<void> result);
    Result<void> write_frame(const RawFrame& frame);
    Result<void> end();
    Result<void> write_packet(AVPacket& packet, int stream, AVRational tick);

    const char* format_;
    std::unique_ptr<StoredSound> sound_;  // null: none
    int sound_stream_ = 0;
    bool over_ = false;  // complete, or failed
    bool complete_ = false;
};

}  // namespace touchable
