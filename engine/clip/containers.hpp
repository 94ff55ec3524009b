// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a clip's file has beside its tracks' pictures (docs/codecs.md), read from any container and written
// into any.
//
// Matroska describes a clip by tags of the file and of each track (clip_tags), an addition to each block
// (BlockAddition), and the scene and the frames' times attached as text; MP4 by tags and an MPEG-4 scene
// (Mp4Scene). A ClipContainer reads all that from an opened file, for any container. MuxedClipWriter is the
// common part of the containers' writers: a derived class writes the frames.
//
// Errors name the file.
// Threads: one at a time uses an object, different ones may use different objects at once. Functions keep no
// state.

#include "engine/clip/clip_file.hpp"
#include "engine/clip/tracks.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/picture/sound.hpp"

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

// Tags of our MP4 files, beside those of the file above.
inline constexpr const char* mp4_scene_tag = "T3D_SCENE";  ///< the scene file's text
inline constexpr const char* mp4_poses_tag = "T3D_POSES";  ///< timed_poses_text (engine/scene/scene.hpp)
inline constexpr const char* mp4_times_tag = "T3D_TIMES";  ///< frame_times_text, of a variable rate

/// Distance of keyframes in all tracks, frames; from version 2 on.
inline constexpr std::int64_t access_interval = 15;
/// Timestamps in milliseconds tell frames apart up to this many frames per second.
inline constexpr int fastest_rate = 1000;

/// Parses a version tag; nullopt unless it is a whole number from 1.
std::optional<std::int64_t> parse_version(std::string_view text);
/// Parses the tag of the bits of a sample stored in two bytes; nullopt unless 9 to 16.
std::optional<int> parse_bits(std::string_view text);
std::optional<FrameRate> parse_rate(std::string_view text);

/// "30000/1001": exact, because Matroska rounds timestamps to milliseconds.
std::string rate_text(const FrameRate& rate);
bool same_rate(const FrameRate& a, const FrameRate& b);
bool is_too_fast(const FrameRate& rate);
/// The note if a scene file plays frames at another rate than they were recorded at; otherwise nullopt.
std::optional<std::string> rate_note(const FrameRate& played, const FrameRate& recorded);

}  // namespace clip_tags

inline constexpr int clip_format_version = 2;
/// From version 3 on, the scene has `hapticSurface` in Depth; from 4 on, its root is an OrderedGroup.
/// Fragments, which have no scene, are still of version 2.
inline constexpr int mp4_format_version = 4;

/// Frame times of a variable rate, in the "timestamp format v2" of mkvtoolnix: a line that says so, and one
/// line per frame in order, milliseconds with six decimals (exact to the nanosecond up to 46 days).
std::string frame_times_text(const FrameRate& rate);
/// Parses that text; `name`: how messages call it. The first time counts as 0.
Result<FrameRate> parse_frame_times(std::string_view text, const std::string& name);

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

// Into Matroska, a file or a stream, before the muxer's header is written; errors if memory runs out.

/// Adds the file's tags: its rate and our format's version.
void add_clip_tags(AVFormatContext& muxer, const FrameRate& rate, int version);
/// Adds a track of pictures, its times in milliseconds; `check` knows the planes.
Result<void> add_plane_stream(AVFormatContext& muxer, const TrackEncoder& encoder, PlaneRole role,
                              TrackCoding coding, const FrameCheck& check, const Scene& scene);
/// Whether a track is the one that ordinary players are to show.
bool is_shown_by_players(PlaneRole role, const FrameCheck& check);
Result<void> attach_text(AVFormatContext& muxer, const char* name, const char* type, const std::string& text);

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
/// `told`: the tracks of each plane, instead of the file's own statement.
std::unique_ptr<ClipContainer> mp4_container(const SourceFile& file,
                                             const std::optional<PlaneTracks>& told = {});
/// The error of a file without a frame, behind its name.
inline std::string why_without_frames(bool is_cut) {
    return is_cut ? "is truncated: it ends before its first whole frame" : "has no frames";
}

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
    PlaneView stored_colour() const final { return colour_.view; }
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
    /// Gives the MP4 file this scene; `objects`: the track of each object that it names.
    Result<void> set_scene(const mpeg4::ClipNodes& nodes, std::map<std::uint16_t, std::uint32_t> objects);
    /// Writes a packet of a picture, its times in `tick`.
    Result<void> write_picture(AVPacket& packet, std::size_t stream, AVRational tick);
    /// When a frame is shown, to the nearest millisecond.
    std::int64_t time_ms(std::int64_t frame) const;
    /// MP4's unit of time, exact at a constant rate: 30000/1001 frames/s have one of 1001/30000 s.
    AVRational tick() const;
    /// When a frame is shown, in this unit.
    std::int64_t tick_of(std::int64_t frame) const;
    /// Makes `stored_colour` give what readers will get of this track, if it is lossy and the storage asks.
    Result<void> read_along(const TrackEncoder& colour, TrackCoding coding);
    /// That track's next packet.
    Result<void> read_again(const AVPacket& colour);

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
    Result<void> add_scene();
    Result<void> write_packet(AVPacket& packet, int stream, AVRational tick);

    const char* format_;
    std::optional<mpeg4::SceneStream> mpeg4_scene_;
    std::unique_ptr<StoredSound> sound_;  // null: none
    int sound_stream_ = 0;
    std::optional<TrackDecoder> along_;  // of colour as stored; nullopt: not requested
    Plane colour_;                       // its last picture
    bool over_ = false;                  // complete, or failed
    bool complete_ = false;
};
/// Those of create_clip, still to be opened.
std::unique_ptr<MuxedClipWriter> matroska_writer(const std::filesystem::path& path,
                                                 const SceneDescription& described,
                                                 const ClipStorage& storage, Existing existing);
std::unique_ptr<MuxedClipWriter> mp4_writer(const std::filesystem::path& path,
                                            const SceneDescription& described, const ClipStorage& storage,
                                            Existing existing);

}  // namespace touchable
