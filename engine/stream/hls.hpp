// SPDX-License-Identifier: Apache-2.0
#pragma once

// HTTP Live Streaming (RFC 8216): playlists, both those that this program writes and those of other senders
// (hls_playlist.cpp), and a stream that is read from a web server or a folder (hls_input.cpp). Folders are
// written by HlsWriter (hls_output.cpp).

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
/// Name of the touch planes in the master playlist; its value is the URI of their media playlist.
inline constexpr std::string_view hls_planes_id = "com.touchable.planes";
/// The same for the low level: every second frameset, in segments of the same numbers and bounds.
inline constexpr std::string_view hls_low_planes_id = "com.touchable.planes.low";
inline constexpr int hls_low_step = 2;
/// A line in each playlist that this program writes, by which it recognises them.
inline constexpr std::string_view hls_mark = "## written by touchable";

/// A segment of a playlist.
struct HlsSegment {
    std::string name;
    std::int64_t duration_ns = 0;
    std::int64_t taken_ns = 0;      ///< time of its first frame, ns since 1970 (UTC); 0: unknown
    bool is_after_a_break = false;  ///< it does not continue the segment before it
};

/// A media playlist.
struct HlsMedia {
    std::int64_t target_s = 1;  ///< longest segment, to the nearest second
    std::int64_t first = 0;     ///< number of the first segment
    std::string header;         ///< name of the initialisation file
    std::deque<HlsSegment> segments{};
    bool is_whole = false;  ///< has every segment of the stream
    bool has_ended = false;
};
std::string text_of(const HlsMedia& media);

/// A variant of a master playlist, which ordinary players show.
struct HlsShown {
    std::string playlist{hls_colour_name};
    std::int64_t most_bits_s = 0;  ///< largest of any segment
    std::string codecs;            ///< "avc1.64001f"
    int width = 0, height = 0;
    double frames_s = 30;
};
/// `low`: the low level's variant, if there is one.
std::string master_text(const HlsShown& shown, const std::optional<HlsShown>& low = {});

/// Codec name, such as "avc1.64001f", of H.264 with start codes; nothing: no sequence parameters.
std::optional<std::string> avc_codec_name(std::span<const std::uint8_t> header);

/// Number after the last segment of a media playlist that this program wrote; 0 for other texts.
std::int64_t next_segment_of(std::string_view media);

// --- Playlists that are read

/// Bytes; longer playlists are refused.
inline constexpr std::size_t largest_hls_playlist = std::size_t{1} << 20;

bool is_hls_playlist(std::string_view first_bytes);

/// Resolves a URI in the playlist at `base`: "http://...", "https://...", or "file:" and an absolute path.
/// Error messages (ErrorKind::input) of all functions here follow the place and a colon. Refused: another
/// scheme or host than the playlist's (a file: anything not beside or below it), and invalid URIs.
Result<std::string> resolved_place(std::string_view base, std::string_view named);

/// Media playlists of a stream.
struct HlsPlaces {
    std::string touch{};                    ///< of the touch planes
    std::string colour{};                   ///< empty: none, or it is in `touch`
    std::string low_touch{}, low_colour{};  ///< the low level's; empty: none
};
/// The media playlists to which the playlist at `place` leads: those that a master playlist names, or the
/// media playlist itself. Refused: a master without touch planes, or one that names itself.
Result<HlsPlaces> places_in_playlist(std::string_view text, const std::string& place);

/// Facts that a media playlist states.
struct HlsMediaFacts {
    std::int64_t next_segment = 0;  ///< number after the last segment
    std::string header;             ///< place of its initialisation; empty: its segments need none
    bool has_ended = false;
};
/// Refuses what FFmpeg's reader would follow although it does not belong into a media playlist: another
/// playlist, keys, places as above, several initialisations, no segment at all.
Result<HlsMediaFacts> check_hls_media(std::string_view text, const std::string& place);

/// A segment that a media playlist lists.
struct HlsListedSegment {
    std::int64_t number = 0;
    std::int64_t duration_ns = 0;  ///< 0: missing or out of range
};
/// The first segment at the place `segment`, in a checked media playlist, whose number is at least `least`;
/// nothing: none.
std::optional<HlsListedSegment> segment_in(std::string_view text, const std::string& place,
                                           const std::string& segment, std::int64_t least);
/// The playlist without the segments before number `first`; nothing if none is left.
std::optional<std::string> playlist_from(std::string_view text, std::int64_t first);

// --- Reading

/// A fetched segment of a stream.
struct FetchedSegment {
    bool is_touch = true;          ///< of the touch planes; else of colour
    bool is_low = false;           ///< of the low level
    std::int64_t bytes = 0;        ///< 0: it could not be fetched
    std::int64_t fetch_ns = 0;     ///< duration of the fetch
    std::int64_t duration_ns = 0;  ///< duration in the stream
};

/// Chooses which of a stream's two levels its link carries, full or low, by how fast segments come, as
/// players of HLS do. The link's rate is the lesser of a quick and a slow running mean. Down if fetching a
/// segment, with its colour, took longer than it lasts, or the rate is below the full level's need; up again
/// after four consecutive segments left at least twice that rate.
class LevelChoice {
public:
    void add(const FetchedSegment& fetched);
    /// To be called when colour is no longer fetched.
    void leave_out_colour() { bytes_[1] = seconds_[1] = needs_[0][1] = needs_[1][1] = 0; }
    bool is_low() const { return is_low_; }
    /// Bytes a second: the link's rate, 0 before the first fetch, and the measured need of a level.
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
    int good_ = 0;  // consecutive good segments
};

/// Packets of a stream by HTTP Live Streaming: of the touch planes, and of colour. FFmpeg reads the playlists
/// and segments, but only what was fetched from the stream's own host and checked (check_hls_media), each
/// file whole or not at all: a segment that is missing, cut or too large is left out. If a playlist cannot be
/// fetched, or is an older one, the last playlist is kept for a while. Used by one thread.
class HlsInput {
public:
    /// `place`: of a master or a media playlist, "http://...", "https://..." or a file's path. Errors name
    /// it. Unavailable colour is left out with a remark. Waits, like `next`, until stop_requested
    /// (ErrorKind::interrupted). `now_ns`: clock for the choice of the level that the link carries
    /// (LevelChoice), if the stream has two; null: the full level only.
    static Result<std::unique_ptr<HlsInput>> open(const std::string& place,
                                                  std::function<std::int64_t()> now_ns = {});
    virtual ~HlsInput() = default;

    struct Packet {
        bool is_touch = true;              ///< of the rendition with the touch planes; else colour's
        bool is_low = false;               ///< of the low level, which has its own streams
        const AVStream* stream = nullptr;  ///< its index counts within the rendition
        PacketPtr packet;
    };
    /// The next packet by time over both renditions; nothing after the last. Waits for a live stream. After
    /// an error, the stream has to be opened anew.
    virtual Result<std::optional<Packet>> next() = 0;

    /// Whether more comes than the playlist had at `open`.
    virtual bool is_live() const = 0;
    /// Number of segments left out so far.
    virtual std::int64_t segments_lost() const = 0;
    /// The levels that were read, if there is a choice.
    virtual std::optional<StreamFigures::Levels> levels() const = 0;
    /// Remarks for a person.
    virtual const std::vector<std::string>& remarks() const = 0;
};

}  // namespace touchable
