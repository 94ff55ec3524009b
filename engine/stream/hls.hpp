#pragma once

// HTTP Live Streaming (RFC 8216): playlists as a folder of ours has them and as other senders write them
// (hls_playlist.cpp), and a stream that is read from a web server or a folder (hls_input.cpp). Folders are
// written in hls_output.cpp, behind HlsWriter.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

// --- Playlists that are written

inline constexpr std::string_view hls_colour_name = "colour.m3u8", hls_touch_name = "touch.m3u8";
inline constexpr std::string_view hls_low_colour_name = "colour-low.m3u8",
                                  hls_low_touch_name = "touch-low.m3u8";
/// The master playlist's name for the planes that are felt; its value is the URI of their media playlist.
inline constexpr std::string_view hls_planes_id = "com.touchable.planes";
/// Its name for the planes of the low level: every second frameset, in segments of the same numbers and
/// bounds.
inline constexpr std::string_view hls_low_planes_id = "com.touchable.planes.low";
inline constexpr int hls_low_step = 2;
/// A line in each playlist of ours, by which it is recognised.
inline constexpr std::string_view hls_mark = "## written by touchable";

/// A segment of a playlist.
struct HlsSegment {
    std::string name;
    std::int64_t duration_ns = 0;
    std::int64_t taken_ns = 0;      ///< its first frame, ns since 1970 (UTC); 0: not known
    bool is_after_a_break = false;  ///< what came before it does not lead to it
};

/// A media playlist.
struct HlsMedia {
    std::int64_t target_s = 1;  ///< no segment is longer, to the nearest second
    std::int64_t first = 0;     ///< number of the first segment
    std::string header;         ///< name of the file with the initialisation
    std::deque<HlsSegment> segments{};
    bool is_whole = false;  ///< from the first segment to the last
    bool has_ended = false;
};
std::string text_of(const HlsMedia& media);

/// A variant of a master playlist, which ordinary players show.
struct HlsShown {
    std::string playlist{hls_colour_name};
    std::int64_t most_bits_s = 0;  ///< of any segment
    std::string codecs;            ///< "avc1.64001f"
    int width = 0, height = 0;
    double frames_s = 30;
};
/// `low`: the variant of the low level, where there is one.
std::string master_text(const HlsShown& shown, const std::optional<HlsShown>& low = {});

/// "avc1.64001f" of a stream of H.264 with start codes; nothing where it has no sequence parameters.
std::optional<std::string> avc_codec_name(std::span<const std::uint8_t> header);

/// The number that the segment after the last one of a media playlist of ours has; 0 where the text is none.
std::int64_t next_segment_of(std::string_view media);

// --- Playlists that are read

/// Longer ones are refused.
inline constexpr std::size_t largest_hls_playlist = std::size_t{1} << 20;

bool is_hls_playlist(std::string_view first_bytes);

/// The place that a playlist at `base` names: "http://...", "https://...", or "file:" and an absolute path.
/// Errors (ErrorKind::input), of all functions here, go behind the place and a colon. Refused: another scheme
/// or host than its own (of a file, what is not beside or below it), and what is no URI.
Result<std::string> resolved_place(std::string_view base, std::string_view named);

/// Media playlists of a stream.
struct HlsPlaces {
    std::string touch{};                    ///< of the planes that are felt
    std::string colour{};                   ///< empty: there is none, or it is in `touch`
    std::string low_touch{}, low_colour{};  ///< the same of the low level; empty: there is none
};
/// The media playlists that the playlist at `place` leads to: those that a master playlist names, or the
/// media playlist itself. Refused: a master without planes of touch, one that names itself.
Result<HlsPlaces> places_in_playlist(std::string_view text, const std::string& place);

/// Facts that a media playlist states.
struct HlsMediaFacts {
    std::int64_t next_segment = 0;  ///< number of the one that will follow the last
    std::string header;             ///< place of its initialisation; empty: its segments need none
    bool has_ended = false;
};
/// Refused: what FFmpeg's reader would go after although it is no media playlist of ours to read: another
/// playlist, keys, places as above, several initialisations, no segment at all.
Result<HlsMediaFacts> check_hls_media(std::string_view text, const std::string& place);

/// A segment that a media playlist lists.
struct HlsListedSegment {
    std::int64_t number = 0;
    std::int64_t duration_ns = 0;  ///< 0: it says none that can be
};
/// The first segment at the place `segment`, in a media playlist that was checked, whose number is `least` or
/// more; nothing where there is none.
std::optional<HlsListedSegment> segment_in(std::string_view text, const std::string& place,
                                           const std::string& segment, std::int64_t least);
/// The playlist without the segments before number `first`; nothing where it has none from there on.
std::optional<std::string> playlist_from(std::string_view text, std::int64_t first);

// --- Reading

/// A segment of a stream, as it was fetched.
struct FetchedSegment {
    bool is_touch = true;          ///< of the planes that are felt; else of colour
    bool is_low = false;           ///< of the low level
    std::int64_t bytes = 0;        ///< 0: it could not be had
    std::int64_t fetch_ns = 0;     ///< that it took
    std::int64_t duration_ns = 0;  ///< of the stream
};

/// Which of a stream's two levels its link carries, full or low, judged as players of HLS do by how fast
/// segments come. The link's rate is the lesser of a quick and a slow running mean. Down when fetching a
/// segment, with its colour, took longer than it lasts, or the rate is below what the full level needs; up
/// again once four segments in a row left at least twice that rate.
class LevelChoice {
public:
    void add(const FetchedSegment& fetched);
    /// Colour is fetched no more.
    void leave_out_colour() { bytes_[1] = seconds_[1] = needs_[0][1] = needs_[1][1] = 0; }
    bool is_low() const { return is_low_; }
    /// Bytes a second: of the link, 0 where nothing was fetched yet, and what a level was seen to need.
    double rate() const { return std::min(quick_, slow_); }
    double need(bool of_low) const {
        const OfRenditions& needs = needs_[of_low ? 1 : 0];
        return needs[0] + needs[1];
    }

private:
    using OfRenditions = std::array<double, 2>;  // touch, colour
    OfRenditions bytes_{}, seconds_{};           // of the newest segments
    std::array<OfRenditions, 2> needs_{};        // of the full and of the low level
    bool has_rate_ = false, is_low_ = false;
    double quick_ = 0, slow_ = 0;
    int good_ = 0;  // segments in a row
};

/// Packets of a stream that is played by HTTP Live Streaming: of the planes that are felt, and of colour.
/// FFmpeg reads the playlists and what their segments hold; it is given nothing but what was fetched from the
/// stream's own host and judged (check_hls_media), each file whole or not at all: a segment that is missing,
/// cut or too large is left out. A playlist that cannot be fetched for a while, or is an older one, is held.
/// One thread.
class HlsInput {
public:
    /// `place`: of a master or a media playlist, "http://...", "https://..." or a file's path. Errors name
    /// it. Colour that cannot be had is left out, which a remark says. Waits until the thread is asked to
    /// stop (stop_requested; ErrorKind::interrupted), as `next` does. `now_ns`: the clock by which the level
    /// is chosen that the link carries (LevelChoice), where the stream has two; null: the full level alone.
    static Result<std::unique_ptr<HlsInput>> open(const std::string& place,
                                                  std::function<std::int64_t()> now_ns = {});
    virtual ~HlsInput() = default;

    struct Packet {
        bool is_touch = true;              ///< of the rendition with the planes that are felt; else colour's
        bool is_low = false;               ///< of the low level, whose streams are others
        const AVStream* stream = nullptr;  ///< its index counts within the rendition
        PacketPtr packet;
    };
    /// The next one, by time over both renditions; nothing after the last. A live stream is waited for. Once
    /// there was an error, the stream can only be opened anew.
    virtual Result<std::optional<Packet>> next() = 0;

    /// Whether more comes than was there when it was opened.
    virtual bool is_live() const = 0;
    /// Segments that were left out so far.
    virtual std::int64_t segments_lost() const = 0;
    /// Which level was read, where there is a choice.
    virtual std::optional<StreamFigures::Levels> levels() const = 0;
    /// Remarks for a person.
    virtual const std::vector<std::string>& remarks() const = 0;
};

}  // namespace touchable
