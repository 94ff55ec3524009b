#pragma once

// Tracks of clips: the pictures of one plane, encoded and decoded packet by packet; the first track of any
// video file; and how our files say what their tracks are.
//
// Writing: TrackEncoder::open with a TrackCoding and the first plane, add_plane_stream (or `describe`) into
// the container, then `encode` for each plane. Reading, in three depths: PacketDecoder turns packets into
// FFmpeg's frames, TrackDecoder into planes of a role, with checksums verified and codings undone, and
// VideoFile gives the frames of a file of any kind, with their times, and goes to any of them.
//
// Matroska says what a clip is by tags of the file and of each track (clip_tags), an addition to each block
// (BlockAddition), and the scene and the frames' times attached as text; MP4 by tags and an MPEG-4 scene
// (Mp4Scene). A ClipContainer reads all that of an opened file, whatever the container. MuxedClipWriter is
// the part of a writer that is the same in all containers: a derived class says what becomes of a frame.
//
// All codings are lossless for depth, haptic and height but h264_visual and h264_reduced; lossy_note has the
// words where another program's codec was not. Errors name track and frame, those of files the file. Objects
// are used by one thread at a time, different ones by different threads at once; FFmpeg may decode slices of
// large pictures on threads of its own. Functions keep no state.

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

// Matroska tags: T3D_VERSION and T3D_RATE of the file; of each track T3D_ROLE, T3D_LOSSLESS where it keeps
// every value, and T3D_BITS where samples of so many bits are stored as bytes (by FFmpeg's codecs the high
// ones in the upper half of the picture); and the name under which the scene is attached.
namespace clip_tags {

inline constexpr const char* version_tag = "T3D_VERSION";
inline constexpr const char* rate_tag = "T3D_RATE";
/// Of the file: it is a stream, which ends where it was cut off.
inline constexpr const char* stream_tag = "T3D_STREAM";
inline constexpr const char* role_tag = "T3D_ROLE";
inline constexpr const char* lossless_tag = "T3D_LOSSLESS";
inline constexpr const char* bits_tag = "T3D_BITS";
inline constexpr const char* scene_file = "scene.json";
/// The attachment of a clip of variable rate (frame_times_text).
inline constexpr const char* times_file = "timestamps.txt";
/// Where the camera stood (timed_poses_text).
inline constexpr const char* poses_file = "poses.txt";

/// From version 2 on, all tracks store a picture that decoding can begin with every so many frames.
inline constexpr std::int64_t access_interval = 15;

/// "30000/1001": exact, because Matroska rounds timestamps to milliseconds.
std::string rate_text(const FrameRate& rate);
bool same_rate(const FrameRate& a, const FrameRate& b);
/// What a person should know where a scene file has frames played at another rate than they were recorded at.
std::optional<std::string> rate_note(const FrameRate& played, const FrameRate& recorded);

}  // namespace clip_tags

inline constexpr int clip_format_version = 2;

/// What a stream says beside each picture (docs/streaming.md), so that pictures of one moment are known
/// whatever became of their times on the way.
struct PictureLabel {
    std::int64_t frame = 0;     ///< of the stream: counts up, also from one round of a loop to the next
    std::int64_t taken_ns = 0;  ///< by the sender's clock, ns since 1970 (UTC); 0: not known
    bool operator==(const PictureLabel&) const = default;
};

/// What a clip says of each stored picture, in its block's BlockAdditions (docs/codecs.md): for how many
/// frames the picture stays, and a checksum, since not every codec has one of its own.
struct BlockAddition {
    std::int64_t frames = 1;  ///< from 1 to the distance of access points
    /// The checksum is that of the packet, of `frames`, which are so many, and of the label.
    bool sound = true;
    std::optional<PictureLabel> label{};  ///< in a stream (docs/streaming.md)
};

/// Adds it to a packet on its way into a Matroska file. An error where memory runs out.
Result<void> add_block_addition(AVPacket& packet, AVCodecID codec, std::int64_t frames,
                                const std::optional<PictureLabel>& label = {});
/// That of a packet; nothing where it has none.
std::optional<BlockAddition> block_addition_of(const AVPacket& packet);

/// The scene as a clip says it: its frames are here now.
SceneDescription said_of_clip(const SceneDescription& described);

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

// Into Matroska, a file or a stream, before the muxer's header is written; errors where memory runs out.

/// Of the whole: its rate, and that it is a clip of ours, of this version.
void add_clip_tags(AVFormatContext& muxer, const FrameRate& rate, int version);
/// A track of pictures, its times in milliseconds; `check` knows the planes.
Result<void> add_plane_stream(AVFormatContext& muxer, const TrackEncoder& encoder, PlaneRole role,
                              TrackCoding coding, const FrameCheck& check, const Scene& scene);
Result<void> attach_text(AVFormatContext& muxer, const char* name, const char* type, const std::string& text);

/// A plane that shows a picture of grey or RGB24 and owns it. `bits`: of a grey sample as stored.
Plane plane_from(FramePtr picture, int bits = 0);

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
    std::string where() const { return name() + ", frame " + std::to_string(received_); }

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

/// The pictures of a video of any kind that `Demuxer::open_video` opens: its first track of pictures, or of
/// several the one that is disparity, or is named DEPTH or COLOR, as the role is, each as FFmpeg decodes it.
class VideoFile {
public:
    struct MeasuredRate {
        FrameRate rate;
        bool is_kept = true;  ///< by all frames, to within a tick
    };
    /// The rate of frames at these times, in order, in units of `tick` seconds. Of those that `said` has
    /// (0/0: nothing) and those that are usual, the first that all frames keep to within a tick, or the mean
    /// of all; otherwise their own times. Where some of these are less than a millisecond apart, the mean, to
    /// which frames do not keep.
    static MeasuredRate measured_rate(const std::vector<std::int64_t>& times, AVRational tick,
                                      const std::vector<AVRational>& said);

    /// Reads the file once from end to end, without decoding, for the times of its frames. `role` is how
    /// messages call the track. `track`: its number in the file, where another file says it.
    static Result<std::unique_ptr<VideoFile>> open(const SourceFile& file, PlaneRole role,
                                                   std::optional<std::uint32_t> track = {});

    const SourceFile& file() const { return file_; }
    /// Of an iPhone's Cinematic video, whose depth is this one's track.
    bool is_disparity() const { return is_disparity_; }
    /// Whether the file has pictures that are no disparity.
    bool has_other_pictures() const;
    /// Which of the file's streams it is.
    int stream() const { return stream_; }

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
    /// How many tracks of pictures the file has beside this one, where nothing says that this is the right
    /// one.
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

    // Where the reading is; `rewind` makes it anew.
    std::unique_ptr<Demuxer> demuxer_;
    int stream_ = 0;
    bool is_lossless_ = false, is_disparity_ = false;
    std::optional<TrackDecoder> decoder_;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    bool is_lost_ = false;     // after an error the decoder is not where `number_` says
    FramePtr held_;            // that frame, where it is decoded already
};

/// How a kind of container holds a touchable clip.
class ClipContainer {
public:
    /// Which stream of a file is which plane.
    struct Track {
        PlaneRole role;
        int stream = 0;
        std::optional<int> low_stream{};  ///< has the low bits of its samples; the high eight are in `stream`
        int low_bits = 0;
        bool is_lossless = false;  ///< so the file says of the whole track; of a picture its own bytes may
    };
    /// What messages call that which describes a clip, and the newest format that is read.
    struct Words {
        const char* scene;  ///< "scene.json"
        const char* times;  ///< "timestamps.txt"
        int newest_version;
    };
    /// Of a file that is read up to where it ends, wherever that is: the frames that have all their pictures,
    /// and whether there is a part of more.
    struct WholePart {
        std::int64_t frames = 0;
        bool is_cut = false;
        bool is_uneven = false;  ///< tracks end at different frames
    };

    virtual ~ClipContainer() = default;
    /// The file, from its first byte.
    virtual Result<std::unique_ptr<Demuxer>> open() = 0;
    /// The rate at which it was recorded.
    virtual Result<FrameRate> rate(const Demuxer& file) = 0;
    /// What it says of itself, its rate left open.
    virtual Result<SceneDescription> scene(const Demuxer& file, const FrameRate& recorded) = 0;
    /// Where its camera stood (timed_poses_text), if the file says it.
    virtual std::optional<std::string> poses(const Demuxer& /*file*/) { return std::nullopt; }
    /// Depth is the first. `scene`: that describes them.
    virtual Result<std::vector<Track>> tracks(const Demuxer& file, const Scene& scene) = 0;
    /// Whether a file just opened knows all its pictures.
    virtual bool has_whole_index() const { return false; }
    /// Nothing where the file promises how long it is.
    virtual Result<std::optional<WholePart>> whole_part(const Demuxer& /*file*/) {
        return std::optional<WholePart>();
    }
    /// What a person should know of all that, once it was asked for.
    const std::vector<std::string>& notes() const { return notes_; }
    const Words& words() const { return words_; }

protected:
    ClipContainer(const SourceFile& source, Words words)
        : source_(source), file_(source.string()), words_(words) {}
    Error refuse(const std::string& what, Hints hints = {}) const {
        return input_error(file_ + ": " + what, std::move(hints));
    }
    /// By the file's tags and, of frames at times of their own, this text. An error where it is no clip of
    /// ours, or of a version to come.
    Result<FrameRate> tagged_rate(const Demuxer& file, const std::optional<std::string>& own_times) const;
    /// As this text describes it. An error where its rate is not the recorded one; that of the frames' own
    /// times it does not say.
    Result<SceneDescription> described_by(const std::string& json, const FrameRate& recorded) const;

    SourceFile source_;
    std::string file_;
    Words words_;
    std::vector<std::string> notes_;
};

std::unique_ptr<ClipContainer> matroska_container(const SourceFile& file);

/// What an MP4 file's MPEG-4 scene says of a touchable clip, and which tracks that is.
struct Mp4Scene {
    mpeg4::SceneStream stream;
    mpeg4::ClipNodes nodes;
};

/// Nothing where a file has no such scene.
Result<std::optional<Mp4Scene>> read_mp4_scene(const SourceFile& file);
/// The number of the track that a plane is; nothing where the scene has no such plane. Errors name no file.
Result<std::optional<std::uint32_t>> track_of_plane(const Mp4Scene& scene, PlaneRole role);

/// A clip that FFmpeg puts into a file, whatever its container: frames are checked, sound goes along with
/// them, and what failed once is not written over.
class MuxedClipWriter : public ClipWriter {
public:
    struct MuxerCloser {
        void operator()(AVFormatContext* muxer) const { avformat_free_context(muxer); }
    };
    using Muxer = std::unique_ptr<AVFormatContext, MuxerCloser>;

    /// A writer of a derived class, opened. Refused are a scene that cannot be stored, and sound that the
    /// container cannot hold.
    template <class Writer>
    static Result<std::unique_ptr<ClipWriter>> create(const std::filesystem::path& path,
                                                      const SceneDescription& described,
                                                      const ClipStorage& storage, Existing existing,
                                                      const std::optional<SoundPart>& sound) {
        if (auto storable = check_storable(path, described); !storable) return storable.error();
        auto writer = std::make_unique<Writer>(path, described, storage, existing);
        if (auto opened = writer->open(sound); !opened) return opened.error();
        return writer;
    }

    Result<void> write(const RawFrame& frame) final { return keep(write_frame(frame)); }
    bool is_full() const final { return room_.is_full(); }
    Result<std::filesystem::path> complete() final;
    Result<void> finish() override;

protected:
    /// `format`: the container, as FFmpeg calls it.
    MuxedClipWriter(const std::filesystem::path& path, const SceneDescription& described,
                    const ClipStorage& storage, Existing existing, const char* format)
        : scene_(described.scene),
          unstated_(described.unstated),
          storage_(storage),
          output_(path, existing),
          format_(format) {}

    /// What the container does with a frame that FrameCheck has passed.
    virtual Result<void> add(const RawFrame& frame) = 0;
    /// What it held back, after the last frame.
    virtual Result<void> add_rest() { return {}; }
    /// What it adds to a file that FFmpeg has ended.
    virtual Result<void> amend() { return {}; }

    Error refuse(const std::string& what) const {
        return input_error(output_.target().string() + ": " + what);
    }
    /// An error where FFmpeg's status is one, or the file could not be written.
    Result<void> check_status(int status) const;
    /// The scene as the clip says it (said_of_clip).
    SceneDescription to_be_said() const;
    /// The stream after those of the pictures, where there is sound.
    Result<void> add_sound_stream();
    Result<void> write_header(AVDictionary* options = nullptr);
    /// What is heard up to then, into that stream.
    Result<void> write_sound(std::int64_t until_ms);
    /// A packet of a picture, its times in `tick`.
    Result<void> write_picture(AVPacket& packet, std::size_t stream, AVRational tick);
    /// When a frame is shown, to the nearest millisecond.
    std::int64_t time_ms(std::int64_t frame) const;

    const Scene scene_;
    const SceneDescription::Unstated unstated_;
    const ClipStorage storage_;
    FrameCheck check_;
    NewFile output_;
    ReservedOutput room_;
    Muxer muxer_;

private:
    Result<void> open(const std::optional<SoundPart>& sound);
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
