#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/picture_label.hpp"
#include "engine/picture/stored_sound.hpp"
#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

struct HlsSettings {
    std::filesystem::path folder;
    std::int64_t segment_ns = 1'000'000'000;  ///< from 0.5 s to 10 s
    /// Live: so much of the stream is in the playlists, which follow each segment. 0: all of it, and the
    /// playlists come with the end.
    std::int64_t window_ns = 0;
    bool has_low = false;  ///< a second level of about half the bytes, for narrow links
};

/// What was written, and what each viewer fetches of it.
struct HlsFigures {
    std::int64_t segments = 0, duration_ns = 0;              ///< of the segments that are complete
    std::int64_t colour_bytes = 0, touch_bytes = 0;          ///< of them
    std::int64_t low_colour_bytes = 0, low_touch_bytes = 0;  ///< in place of those, where the link is narrow
    std::int64_t playlist_bytes =
        0;  ///< of both media playlists, as they are now; live fetched once a segment
};

/// A stream as a folder of files that any web server delivers to any number of viewers (HTTP Live Streaming,
/// RFC 8216): two renditions in fragmented MP4, colour (with sound) and the planes that are felt, cut at the
/// same frames, and a master playlist in which ordinary players find the colour alone. The low level has both
/// once more: colour of half the bit rate, and the planes of every second frameset of a segment. Each picture
/// says what it is (LabelledEncoder). Each file appears whole; segments go some time after the last playlist
/// that names them. One thread.
class HlsWriter {
public:
    virtual ~HlsWriter() = default;
    /// Refused: a folder with files of others (HlsFolder), a scene that no clip can have, a length that is
    /// out of range (ErrorKind::usage). Sound that is not AAC is left out, which a note says.
    static Result<std::unique_ptr<HlsWriter>> open(const HlsSettings& settings,
                                                   const SceneDescription& described,
                                                   const std::optional<SoundPart>& sound = {});

    /// The next frame of the stream, shown `time_ns` after its beginning; planes as the first one had them.
    virtual Result<void> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns) = 0;
    /// The last segment, and that nothing comes after it.
    virtual Result<void> finish() = 0;
    /// What a person should know, once the first frame was added.
    virtual const std::vector<std::string>& notes() const = 0;
    virtual const HlsFigures& figures() const = 0;
};

}  // namespace touchable
