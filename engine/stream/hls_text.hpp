#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace touchable {

// Playlists of HTTP Live Streaming (RFC 8216), as a folder of ours has them (hls_writer.hpp).

inline constexpr std::string_view hls_master_name = "master.m3u8";
inline constexpr std::string_view hls_colour_name = "colour.m3u8", hls_touch_name = "touch.m3u8";
inline constexpr std::string_view hls_low_colour_name = "colour-low.m3u8",
                                  hls_low_touch_name = "touch-low.m3u8";
/// What a master playlist calls the planes that are felt; its value is the URI of their media playlist.
inline constexpr std::string_view hls_planes_id = "com.touchable.planes";
/// The same of the low level: every second frameset, in segments of the same numbers and boundaries.
inline constexpr std::string_view hls_low_planes_id = "com.touchable.planes.low";
inline constexpr int hls_low_step = 2;
/// A line that each playlist of ours has, and by which it is known as ours.
inline constexpr std::string_view hls_mark = "## written by touchable";

/// One of a playlist's segments.
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

/// What a master playlist says of a variant that ordinary players show.
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

/// The number that the segment after the last one of a media playlist has; 0 where the text is none.
std::int64_t next_segment_of(std::string_view media);

}  // namespace touchable
