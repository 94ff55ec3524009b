#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/picture/sound_track.hpp"
#include "engine/scene/plane_view.hpp"

namespace touchable {

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

}  // namespace touchable
