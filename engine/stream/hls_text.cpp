#include "engine/stream/hls_text.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>

#include "engine/base/number_words.hpp"

namespace touchable {
namespace {

std::string playlist_head() {
    return "#EXTM3U\n#EXT-X-VERSION:7\n" + std::string(hls_mark) + "\n#EXT-X-INDEPENDENT-SEGMENTS\n";
}

/// "2026-11-23T17:21:13.250Z".
std::string date_text(std::int64_t ns) {
    using std::chrono::days, std::chrono::milliseconds;
    const auto ms = std::chrono::floor<milliseconds>(std::chrono::nanoseconds(ns));
    const auto whole_days = std::chrono::floor<days>(ms);
    const std::chrono::year_month_day date{std::chrono::sys_days(whole_days)};
    const std::chrono::hh_mm_ss time(ms - whole_days);
    return formatted("%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                     static_cast<int>(time.hours().count()), static_cast<int>(time.minutes().count()),
                     static_cast<int>(time.seconds().count()), static_cast<int>(time.subseconds().count()));
}

std::string seconds_text(std::int64_t ns) {
    const std::int64_t us = (ns + 500) / 1000;
    return formatted("%lld.%06lld", static_cast<long long>(us / 1'000'000),
                     static_cast<long long>(us % 1'000'000));
}

std::string planes_text(std::string_view id, std::string_view playlist) {
    return "#EXT-X-SESSION-DATA:DATA-ID=\"" + std::string(id) + "\",VALUE=\"" + std::string(playlist) +
           "\"\n";
}

std::string variant_text(const HlsShown& shown) {
    return "#EXT-X-STREAM-INF:BANDWIDTH=" + std::to_string(shown.most_bits_s) + ",CODECS=\"" + shown.codecs +
           "\",RESOLUTION=" + std::to_string(shown.width) + "x" + std::to_string(shown.height) +
           formatted(",FRAME-RATE=%.3f\n", shown.frames_s) + shown.playlist + "\n";
}

}  // namespace

std::string text_of(const HlsMedia& media) {
    std::string text = playlist_head();
    text += "#EXT-X-TARGETDURATION:" + std::to_string(media.target_s) + "\n";
    text += "#EXT-X-MEDIA-SEQUENCE:" + std::to_string(media.first) + "\n";
    if (media.is_whole) text += "#EXT-X-PLAYLIST-TYPE:VOD\n";
    text += "#EXT-X-MAP:URI=\"" + media.header + "\"\n";
    for (const HlsSegment& segment : media.segments) {
        if (segment.is_after_a_break) text += "#EXT-X-DISCONTINUITY\n";
        if (segment.taken_ns > 0) text += "#EXT-X-PROGRAM-DATE-TIME:" + date_text(segment.taken_ns) + "\n";
        text += "#EXTINF:" + seconds_text(segment.duration_ns) + ",\n" + segment.name + "\n";
    }
    if (media.has_ended) text += "#EXT-X-ENDLIST\n";
    return text;
}

std::string master_text(const HlsShown& shown, const std::optional<HlsShown>& low) {
    std::string text = playlist_head() + planes_text(hls_planes_id, hls_touch_name);
    if (low) text += planes_text(hls_low_planes_id, hls_low_touch_name);
    text += variant_text(shown);  // the one that players begin with comes first
    return low ? text + variant_text(*low) : text;
}

std::optional<std::string> avc_codec_name(std::span<const std::uint8_t> header) {
    constexpr int sequence_parameters = 7;
    for (std::size_t at = 0; at + 6 < header.size(); ++at)
        if (header[at] == 0 && header[at + 1] == 0 && header[at + 2] == 1 &&
            (header[at + 3] & 31) == sequence_parameters)
            return formatted("avc1.%02x%02x%02x", static_cast<unsigned>(header[at + 4]),
                             static_cast<unsigned>(header[at + 5]), static_cast<unsigned>(header[at + 6]));
    return std::nullopt;
}

std::int64_t next_segment_of(std::string_view media) {
    constexpr std::string_view first_key = "\n#EXT-X-MEDIA-SEQUENCE:", segment_key = "\n#EXTINF:";
    const std::size_t at = media.find(first_key);
    std::int64_t number = 0;
    if (at == std::string_view::npos) return 0;
    const char* const begin = media.data() + at + first_key.size();
    std::from_chars(begin, media.data() + media.size(), number);
    constexpr std::int64_t most = std::int64_t{1} << 53;
    if (number < 0 || number > most) return 0;
    for (std::size_t next = 0; (next = media.find(segment_key, next)) != std::string_view::npos; ++next)
        ++number;
    return number;
}

}  // namespace touchable
