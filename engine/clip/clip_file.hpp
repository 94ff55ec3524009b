#pragma once

// Clips in files of our own formats, Matroska and MP4, and films of a window: opened and written.
//
//     TRY_ASSIGN(auto writer, create_named_clip("out.mkv", scene));  // by the name's end: Matroska or MP4
//     for (...) TRY(writer->write(frame));
//     TRY(writer->finish());                                          // only now the file has its name
//
// A file appears whole or not at all: until `finish` it has a hidden name, and a writer that is destroyed
// before leaves nothing behind. What is stored keeps every value of depth, haptic and height; ClipStorage
// says how hard the encoder tries and whether colour is exact. Readers give back what was written, and
// refuse, with the frame's number, what was damaged since. How the containers say what they hold is in
// tracks.hpp, for modules that make others of the kind.
//
// Each reader and writer is used by one thread at a time; a reader decodes large pictures on threads of its
// own.

#include <array>
#include <bit>
#include <span>
#include <system_error>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/sound.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A touchable clip in Matroska; `described` replaces the scene attached to it.
Result<std::unique_ptr<ClipReader>> open_matroska_clip(const SourceFile& file,
                                                       const std::optional<SceneDescription>& described,
                                                       Colour colour = Colour::wanted);

/// The same in MP4, or any MP4 file whose MPEG-4 scene is a touchable clip (docs/codecs.md).
Result<std::unique_ptr<ClipReader>> open_mp4_clip(const SourceFile& file,
                                                  const std::optional<SceneDescription>& described,
                                                  Colour colour = Colour::wanted);
/// Whether a file is one of these: it has tags of ours, an MPEG-4 scene of a clip, or tracks that are named
/// as planes of touch. One whose scene is damaged may be, or is no clip where FFmpeg cannot read the file,
/// unless another file describes it: its reader says what is wrong with the scene.
bool is_mp4_clip(const SourceFile& file, bool is_described);

/// The tracks of each plane in an MP4 file, by PlaneRole: the number of its track, and of samples of more
/// than 8 bits that of the track with their low bits. Empty: there is no such plane.
using PlaneTracks = std::array<std::vector<std::uint32_t>, all_roles.size()>;

/// Tracks of an MP4 file of which another file says what they are and mean. Any program may have written it;
/// one with tags of ours says the frames' times.
Result<std::unique_ptr<ClipReader>> open_mp4_tracks(const SourceFile& file, const PlaneTracks& tracks,
                                                    const SceneDescription& described,
                                                    Colour colour = Colour::wanted);

/// What a clip's tracks are to be good at (docs/codecs.md).
enum class Archive {
    fast,   ///< quick to decode
    small,  ///< few bytes: for each plane the coding that takes fewer
};

/// How a clip's pictures are stored. Depth, haptic and height always keep every value.
struct ClipStorage {
    /// Tracks of another clip, and the file that has them.
    struct Copied {
        std::filesystem::path file;
        std::vector<PlaneRole> roles;
    };

    Archive archive = Archive::fast;
    bool exact_colour = false;  ///< otherwise colour is as good as the eye can tell
    bool gives_colour = false;  ///< ClipWriter::stored_colour is used; costs decoding it
    bool fragmented = false;    ///< readable while it is written, and up to where it was cut: MP4 only
    /// Matroska: tracks that have the pictures of these frames already. They are copied as they are stored,
    /// where that can be done, and only planes of other roles are encoded.
    std::optional<Copied> copied{};
};

/// Refuses a scene that no clip of ours can have, whatever its container. Errors name the file to be written.
Result<void> check_storable(const std::filesystem::path& path, const SceneDescription& described);

/// A touchable clip: Matroska, one track per plane tagged with its role, the scene attached as JSON; filters
/// may be left open there. A size that no clip can hold is an error of kind usage of the first `write`.
Result<std::unique_ptr<ClipWriter>> create_clip(const std::filesystem::path& path,
                                                const SceneDescription& described,
                                                const ClipStorage& storage = {},
                                                Existing existing = Existing::replace,
                                                const std::optional<SoundPart>& sound = {});

/// A touchable clip as the paper sends it: MP4 with a track of H.264 for each plane, and an MPEG-4 scene that
/// says what they are. Colour is the track that ordinary players show; the others are marked as auxiliary to
/// it. Depth and height of more than 8 bits have their low bits in tracks of their own, which the scene does
/// not name. `storage`: its archive says how hard the encoder tries; in fragments the file has no scene but
/// tags and names of tracks, and is readable up to the last half second that was written. Otherwise as
/// create_clip.
Result<std::unique_ptr<ClipWriter>> create_mp4_clip(const std::filesystem::path& path,
                                                    const SceneDescription& described,
                                                    const ClipStorage& storage = {},
                                                    Existing existing = Existing::replace,
                                                    const std::optional<SoundPart>& sound = {});

/// Whether a clip of this name is to be MP4: .mp4, in any case of letters.
bool is_mp4_name(const std::filesystem::path& path);
/// create_mp4_clip or create_clip, by its name.
Result<std::unique_ptr<ClipWriter>> create_named_clip(const std::filesystem::path& path,
                                                      const SceneDescription& described,
                                                      const ClipStorage& storage = {},
                                                      Existing existing = Existing::replace,
                                                      const std::optional<SoundPart>& sound = {});

/// Bits of the largest height code; the low ones beyond 8 are in a track of their own in MP4.
constexpr int height_bits(const HeightCoding& height) {
    return std::bit_width(height.code_max);
}
/// The name of a track (its handler's) that has the low bits of another one: "depth_low". The high eight are
/// in that one.
inline constexpr const char* low_track_suffix = "_low";

/// A film of what was shown and heard, for ordinary players: H.264 and AAC in MP4, or H.264 and FLAC in
/// Matroska, by the name's end (.mp4, .mkv, in small or capital letters); a picture every thirtieth of a
/// second, and two channels at SoundTrack::rate. The file has its name once it is complete.
class FilmWriter {
public:
    static constexpr int pictures_per_second = 30;

    /// Refused: a name of another kind (ErrorKind::usage), a place where nothing can be written, and, with
    /// `keep`, a file that is there (ErrorKind::input).
    static Result<std::unique_ptr<FilmWriter>> create(const std::filesystem::path& file, Existing existing);
    virtual ~FilmWriter() = default;

    /// RGB, 8 bits: what is seen from place `place` of the film on (0, 1, ...: thirtieths of a second), and
    /// until then what was before. The film has the first one's size, rounded down to even numbers; others
    /// are fitted into it, on black. An error (ErrorKind::input) where it cannot be written.
    virtual Result<void> add(const PlaneView& picture, std::int64_t place) = 0;
    /// What is heard from `sample` of the film on (0 is heard with its first picture), after the first
    /// picture; silence where nothing is. What comes when later sound is there already is left out, and so
    /// may be what comes two seconds later than its picture. Errors as above.
    virtual Result<void> add_sound(std::int64_t sample, std::span<const StereoSample> samples) = 0;
    /// The last picture stays until before this place. An error where anything could not be written; then
    /// there is no file. But where its disk became full, it is kept up to there.
    virtual Result<void> finish(std::int64_t end) = 0;
};

/// A folder with a hidden name for files that are to appear together; it goes again with all that is left in
/// it.
class HiddenFolder : NonCopyable {
public:
    explicit HiddenFolder(const std::filesystem::path& beside);
    ~HiddenFolder();

    const std::filesystem::path& path() const { return path_; }
    /// Why it could not be made, if so.
    const std::error_code& failure() const { return failure_; }
    /// All in it safe on the disk, as far as its file system can.
    void sync() const;
    void remove() const;
    /// Gives its files of these names the same names in `home`, in this order, the one that opens the others
    /// last. With `keep` all of them or none.
    Result<void> move_to(const std::filesystem::path& home, const std::vector<std::string>& names,
                         Existing existing) const;

private:
    std::filesystem::path path_;
    std::error_code failure_;
    int opened_ = -1;
};

}  // namespace touchable
