#pragma once

// How our clips say what they are, for modules that read or write others of the kind: streams, LeRobot's MP4,
// glTF.
//
// Matroska: tags of the file and of each track (clip_tags), an addition to each block (BlockAddition), the
// scene and the frames' times attached as text. A ClipContainer reads all that of an opened file, whatever
// the container; add_clip_tags, add_plane_stream and attach_text write it into a muxer of FFmpeg's, before
// its header. MP4: tags and an MPEG-4 scene (Mp4Scene). MuxedClipWriter is the part of a writer that is the
// same in all containers: a class derived from it says what becomes of a frame.
//
// Errors name the file, but where it is said. Objects are used by one thread at a time; functions keep no
// state.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/clip/tracks.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/sound.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

namespace clip_tags {

// Matroska tags: T3D_VERSION and T3D_RATE of the file; of each track T3D_ROLE, T3D_LOSSLESS where it keeps
// every value, and T3D_BITS where samples of so many bits are stored as bytes (by FFmpeg's codecs the high
// ones in the upper half of the picture); and the name under which the scene is attached.
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

/// A version as its tag has it; nothing unless it is a whole number from 1.
std::optional<std::int64_t> parse_version(std::string_view text);

/// Bits of a sample that is stored in two bytes, as their tag has them; nothing unless 9 to 16.
std::optional<int> parse_bits(std::string_view text);

/// "30000/1001": exact, because Matroska rounds timestamps to milliseconds.
std::string rate_text(const FrameRate& rate);
std::optional<FrameRate> parse_rate(std::string_view text);
bool same_rate(const FrameRate& a, const FrameRate& b);
/// What a person should know where a scene file has frames played at another rate than they were recorded at.
std::optional<std::string> rate_note(const FrameRate& played, const FrameRate& recorded);

/// Timestamps in milliseconds tell frames apart up to this many frames per second.
inline constexpr int fastest_rate = 1000;
bool is_too_fast(const FrameRate& rate);

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

// Into Matroska, a file or a stream, before the muxer's header is written; errors where memory runs out.

/// Of the whole: its rate, and that it is a clip of ours, of this version.
void add_clip_tags(AVFormatContext& muxer, const FrameRate& rate, int version);
/// A track of pictures, its times in milliseconds; `check` knows the planes.
Result<void> add_plane_stream(AVFormatContext& muxer, const TrackEncoder& encoder, PlaneRole role,
                              TrackCoding coding, const FrameCheck& check, const Scene& scene);
Result<void> attach_text(AVFormatContext& muxer, const char* name, const char* type, const std::string& text);

/// Which stream of a file is which plane.
struct ClipTrack {
    PlaneRole role;
    int stream = 0;
    std::optional<int> low_stream{};  ///< has the low bits of its samples; the high eight are in `stream`
    int low_bits = 0;
    bool is_lossless = false;  ///< so the file says of the whole track; of a picture its own bytes may
};

/// How a kind of container holds a touchable clip.
class ClipContainer {
public:
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
    virtual Result<std::vector<ClipTrack>> tracks(const Demuxer& file, const Scene& scene) = 0;
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
    ClipContainer(const SourceFile& source, Words words);
    Error refuse(const std::string& what, Hints hints = {}) const;
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
    /// Before the first frame. Refused is sound that the container cannot hold.
    Result<void> open(const std::optional<SoundPart>& sound);

    Result<void> write(const RawFrame& frame) final { return keep(write_frame(frame)); }
    bool is_full() const final { return room_.is_full(); }
    Result<std::filesystem::path> complete() final;
    Result<void> finish() override;

protected:
    /// `format`: the container, as FFmpeg calls it.
    MuxedClipWriter(const std::filesystem::path& path, const SceneDescription& described,
                    const ClipStorage& storage, Existing existing, const char* format);

    /// What the container does with a frame that FrameCheck has passed.
    virtual Result<void> add(const RawFrame& frame) = 0;
    /// What it held back, after the last frame.
    virtual Result<void> add_rest() { return {}; }
    /// What it adds to a file that FFmpeg has ended.
    virtual Result<void> amend() { return {}; }

    Error refuse(const std::string& what) const;
    /// An error where FFmpeg's status is one, or the file could not be written.
    Result<void> check_status(int status) const;
    /// The scene as the clip says it: its frames are here now.
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
    const Unstated unstated_;
    const ClipStorage storage_;
    FrameCheck check_;
    NewFile output_;
    ReservedOutput room_;
    struct MuxerCloser {
        void operator()(AVFormatContext* muxer) const { avformat_free_context(muxer); }
    };
    std::unique_ptr<AVFormatContext, MuxerCloser> muxer_;

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

/// Opens a writer, of any container, of a scene that can be stored.
template <class Writer>
Result<std::unique_ptr<ClipWriter>> open_clip_writer(const std::filesystem::path& path,
                                                     const SceneDescription& described,
                                                     const ClipStorage& storage, Existing existing,
                                                     const std::optional<SoundPart>& sound) {
    if (auto storable = check_storable(path, described); !storable) return storable.error();
    auto writer = std::make_unique<Writer>(path, described, storage, existing);
    if (auto opened = writer->open(sound); !opened) return opened.error();
    return std::unique_ptr<ClipWriter>(std::move(writer));
}

}  // namespace touchable
