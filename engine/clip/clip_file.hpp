// SPDX-License-Identifier: Apache-2.0
#pragma once

// Clips in files of our own formats, Matroska and MP4, and films of a window: opened and written.
//
//     TRY_ASSIGN(auto writer, create_clip("out.mkv", scene));  // by the name's end: Matroska or MP4
//     for (...) TRY(writer->write(frame));
//     TRY(writer->finish());                                          // only now the file has its name
//
// A file appears whole or not at all: until `finish` it has a hidden name, and a writer that is destroyed
// before leaves nothing behind. What is stored keeps every value of depth, haptic and height; ClipStorage
// says how hard the encoder tries and whether colour is exact. Readers give back what was written, and
// refuse, with the frame's number, what was damaged since. The containers' metadata is in containers.hpp,
// for modules that write similar files.
//
// Threads: one at a time uses a reader or a writer; a reader decodes large pictures on threads of its own.

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
/// Whether a file is such a clip: it has our tags, an MPEG-4 scene of a clip, or tracks named as planes of
/// touch. If no other file describes it, also true if its scene is damaged, or is not a clip's and FFmpeg
/// cannot read the file: the reader then says what is wrong with the scene.
bool is_mp4_clip(const SourceFile& file, bool is_described);

/// The tracks of each plane in an MP4 file, by PlaneRole: its track number and, for samples of more than 8
/// bits, that of the track with their low bits. Empty: no such plane.
using PlaneTracks = std::array<std::vector<std::uint32_t>, all_roles.size()>;

/// Opens tracks of an MP4 file by any program, whose roles and meaning another file gives. If the file has
/// our tags, they give the frames' times.
Result<std::unique_ptr<ClipReader>> open_mp4_tracks(const SourceFile& file, const PlaneTracks& tracks,
                                                    const SceneDescription& described,
                                                    Colour colour = Colour::wanted);

/// What a clip's tracks are optimised for (docs/codecs.md).
enum class Archive {
    fast,   ///< quick to encode and decode
    small,  ///< few bytes, but slow to encode
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
    bool fragmented = false;    ///< readable while being written, and up to where it is cut: MP4 only
    /// Matroska: tracks that already have these frames' pictures. They are copied without encoding if
    /// possible, and only planes of other roles are encoded.
    std::optional<Copied> copied{};
};

/// Refuses a scene that no clip of ours can have, whatever its container. Errors name the file to be written.
Result<void> check_storable(const std::filesystem::path& path, const SceneDescription& described);

/// Whether a clip of this name is to be MP4: .mp4, in any case of letters.
bool is_mp4_name(const std::filesystem::path& path);

/// A touchable clip in MP4, if `path` is a name of it, or in Matroska. A size that no clip can hold makes the
/// first `write` fail with kind usage.
///
/// Matroska: one track per plane tagged with its role, the scene attached as JSON; filters may stay unstated
/// there.
///
/// MP4, as the paper sends it: a track of H.264 for each plane, and an MPEG-4 scene that says what they are.
/// Colour is the track that ordinary players show; the others are marked as auxiliary to it. Depth and height
/// of more than 8 bits have their low bits in separate tracks, which the scene does not name. `storage`: its
/// archive sets the encoder's effort; a fragmented file has tags and track names instead of the scene, and is
/// readable up to the last half second written.
Result<std::unique_ptr<ClipWriter>> create_clip(const std::filesystem::path& path,
                                                const SceneDescription& described,
                                                const ClipStorage& storage = {},
                                                Existing existing = Existing::replace,
                                                const std::optional<SoundPart>& sound = {});

/// Bits of the largest height code; MP4 has those below the high 8 in a separate track.
constexpr int height_bits(const HeightCoding& height) {
    return std::bit_width(height.code_max);
}
/// Suffix of the handler name of a track with another one's low bits: "depth_low". "depth" has the high
/// eight.
inline constexpr const char* low_track_suffix = "_low";

/// A film of what was shown and heard, for ordinary players: H.264 and AAC in MP4, or H.264 and FLAC in
/// Matroska, by the name's end (.mp4, .mkv, in small or capital letters), and two channels at
/// SoundTrack::rate. The file has its name once it is complete. Or PNG files without sound, by a name such as
/// shot-%04d.png: each picture that is added, numbered from 1, in its own size.
class FilmWriter {
public:
    static constexpr int usual_rate = 30, most_rate = 240;  ///< pictures a second

    /// Refused: a name of another kind (ErrorKind::usage), a place where nothing can be written, and, with
    /// `keep`, an existing file (ErrorKind::input).
    static Result<std::unique_ptr<FilmWriter>> create(const std::filesystem::path& file, Existing existing,
                                                      int pictures_per_second = usual_rate);
    virtual ~FilmWriter() = default;

    /// Shows `picture` (RGB, 8 bits) from `place` of the film on (0, 1, ...); until then the one before
    /// stays. The film has the first one's size, rounded down to even numbers; others are fitted into it, on
    /// black. An error (ErrorKind::input) if it cannot be written.
    virtual Result<void> add(const PlaneView& picture, std::int64_t place) = 0;
    /// Adds sound from `sample` of the film on (0: with its first picture); call it after the first picture.
    /// Gaps are silent. Sound that comes after later sound is dropped, and sound that comes some
    /// seconds later than its picture may be. Errors as above.
    virtual Result<void> add_sound(std::int64_t sample, std::span<const StereoSample> samples) = 0;
    /// Ends the film before this place; the last picture stays until then. An error if anything could not be
    /// written; then there is no file, unless the disk became full: the film up to there is kept, as numbered
    /// pictures are.
    virtual Result<void> finish(std::int64_t end) = 0;
};

/// The name of a numbered picture, by a pattern such as shot-%04d.png; nothing: `pattern` is none.
std::optional<std::filesystem::path> numbered_picture(const std::filesystem::path& pattern,
                                                      std::int64_t number);

/// A folder with a hidden name for files that are to appear together; the destructor removes it with all that
/// is left in it.
class HiddenFolder : NonCopyable {
public:
    explicit HiddenFolder(const std::filesystem::path& beside);
    ~HiddenFolder();

    const std::filesystem::path& path() const { return path_; }
    /// Why the folder could not be made, if so.
    const std::error_code& failure() const { return failure_; }
    /// Writes a file of this name. An error names it in `home`.
    Result<void> write(const std::filesystem::path& home, const std::string& name,
                       const std::string& bytes) const;
    /// Flushes its files to the disk. An error names `place`, what they become.
    Result<void> sync(const std::filesystem::path& place) const;
    void remove() const;
    /// Moves these files into `home`, in this order, the one that opens the others last. With `keep` all or
    /// none.
    Result<void> move_to(const std::filesystem::path& home, const std::vector<std::string>& names,
                         Existing existing) const;

private:
    std::filesystem::path path_;
    std::error_code failure_;
    Descriptor opened_;
};

}  // namespace touchable
