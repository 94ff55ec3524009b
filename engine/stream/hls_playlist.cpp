// SPDX-License-Identifier: Apache-2.0
// Playlists of HTTP Live Streaming: those that this program writes, and those of any sender, which are read
// and checked.

#include <algorithm>
#include <chrono>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/stream/hls.hpp"
#include "engine/stream/sending.hpp"

namespace touchable {
namespace {

// --- Helpers of writing

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
           "\",RESOLUTION=" + size_text(shown.width, shown.height) +
           formatted(",FRAME-RATE=%.3f\n", shown.frames_s) + shown.playlist + "\n";
}

// --- Helpers of reading

constexpr std::string_view file_scheme = "file:";

/// "http://host:80" and "/path/", "file:" and "/folder/".
struct PlaceParts {
    std::string origin, path;  // path without query
};

/// A scheme and its colon; empty if there is none.
std::string_view scheme_in(std::string_view uri) {
    const std::size_t colon = uri.find_first_of(":/?#");
    if (colon == std::string_view::npos || colon == 0 || uri[colon] != ':') return "";
    return uri.substr(0, colon + 1);
}

PlaceParts parts_of(std::string_view place) {
    std::string_view rest = place.substr(0, place.find_first_of("?#"));
    if (place.starts_with(file_scheme))
        return {std::string(file_scheme), std::string(place.substr(file_scheme.size()))};
    const std::size_t host = rest.find("://");
    const std::size_t path = host == std::string_view::npos ? host : rest.find('/', host + 3);
    if (path == std::string_view::npos) return {small_letters(std::string(rest)), "/"};
    return {small_letters(std::string(rest.substr(0, path))), std::string(rest.substr(path))};
}

/// The path without "." and "..".
std::string plain_path(std::string_view path) {
    std::vector<std::string_view> steps;
    bool is_folder = false;  // a path that ends in dots is one (RFC 3986, 5.2.4)
    while (!path.empty()) {
        const std::size_t end = std::min(path.find('/', 1), path.size());
        const std::string_view step = path.substr(0, end);
        path.remove_prefix(end);
        if (step == "/.." && !steps.empty()) steps.pop_back();
        is_folder = step == "/.." || step == "/.";
        if (!is_folder) steps.push_back(step);
    }
    std::string plain;
    for (const std::string_view step : steps) plain += step;
    return is_folder ? plain + '/' : plain;
}

bool has_step_up(std::string_view path) {
    return ("/" + std::string(path) + "/").find("/../") != std::string::npos;
}

Error foreign_place(std::string_view named) {
    return input_error("it names " + in_quotes(named) +
                       ", which is elsewhere: a playlist may name only what its own host has");
}

Result<std::string> absolute_place(std::string_view base, std::string_view named) {
    const PlaceParts other = parts_of(named);
    const bool is_web = other.origin.starts_with("http://") || other.origin.starts_with("https://");
    if (!is_web || other.origin != parts_of(base).origin) return foreign_place(named);
    const std::size_t query = std::min(named.find('?'), named.size());
    return other.origin + plain_path(other.path) + std::string(named.substr(query));
}

/// Takes the next line that is not empty off a playlist, without its end.
std::optional<std::string_view> next_line(std::string_view& playlist) {
    while (!playlist.empty()) {
        const std::string_view line = cut_line(playlist);
        if (const auto end = line.find_last_not_of(" \t\r"); end != std::string_view::npos)
            return line.substr(0, end + 1);
    }
    return std::nullopt;
}

/// The text behind a tag's name; nothing if the line has another tag.
std::optional<std::string_view> after_tag(std::string_view line, std::string_view tag) {
    if (!line.starts_with(tag)) return std::nullopt;
    line.remove_prefix(tag.size());
    if (line.empty()) return line;
    return line.front() == ':' ? std::optional(line.substr(1)) : std::nullopt;
}

/// The value of a key in a list KEY=VALUE,KEY="VALUE"; nothing if it is missing.
std::optional<std::string_view> attribute(std::string_view list, std::string_view key) {
    while (!list.empty()) {
        const std::size_t equals = list.find('=');
        if (equals == std::string_view::npos) return std::nullopt;
        const std::string_view name = list.substr(0, equals);
        list.remove_prefix(equals + 1);
        const bool quoted = list.starts_with('"');
        if (quoted) list.remove_prefix(1);
        const std::size_t end = std::min(list.find(quoted ? '"' : ','), list.size());
        const std::string_view value = list.substr(0, end);
        list.remove_prefix(end);
        list.remove_prefix(std::min(list.size(), std::min(list.find(','), list.size()) + 1));
        if (name == key) return value;
    }
    return std::nullopt;
}

Result<void> check_size(std::string_view text) {
    if (text.size() > largest_hls_playlist)
        return input_error("is longer than 1 MiB: no playlist of a stream is");
    if (!is_hls_playlist(text)) return input_error("is no playlist of HLS: it does not begin with #EXTM3U");
    if (text.find('\0') != std::string_view::npos) return input_error("is no playlist of HLS: it has zeros");
    return {};
}

bool is_master_line(std::string_view line) {
    return after_tag(line, "#EXT-X-STREAM-INF") || after_tag(line, "#EXT-X-I-FRAME-STREAM-INF") ||
           after_tag(line, "#EXT-X-MEDIA") || after_tag(line, "#EXT-X-SESSION-DATA");
}

/// The media playlists that a master playlist names, unresolved.
struct NamedPlaylists {
    bool is_master = false;
    std::optional<std::string_view> touch, colour, low_touch, low_colour;
};

NamedPlaylists named_in(std::string_view text) {
    NamedPlaylists named;
    bool is_variant = false;
    while (const auto line = next_line(text)) {
        named.is_master = named.is_master || is_master_line(*line);
        if (after_tag(*line, "#EXT-X-STREAM-INF")) is_variant = true;
        if (const auto data = after_tag(*line, "#EXT-X-SESSION-DATA")) {
            const auto id = attribute(*data, "DATA-ID");
            if (id == hls_planes_id) named.touch = attribute(*data, "VALUE");
            if (id == hls_low_planes_id) named.low_touch = attribute(*data, "VALUE");
        }
        if (line->starts_with('#')) continue;
        if (is_variant && named.colour && !named.low_colour) named.low_colour = *line;
        if (is_variant && !named.colour) named.colour = *line;
        is_variant = false;
    }
    return named;
}

/// Parses the number of a media playlist's first segment.
std::optional<std::int64_t> segment_number(std::string_view text) {
    constexpr std::int64_t most = std::int64_t{1} << 53;
    const auto number = parsed_as<std::int64_t>(text);
    return number && *number >= 0 && *number <= most ? number : std::nullopt;
}

/// Number of the first segment of a checked media playlist.
std::int64_t first_number_in(std::string_view text) {
    std::int64_t first = 0;
    while (const auto line = next_line(text))
        if (const auto number = after_tag(*line, "#EXT-X-MEDIA-SEQUENCE"))
            first = segment_number(*number).value_or(0);
    return first;
}

/// Duration of a segment in "1.000000,title", ns; 0 if it is out of range.
std::int64_t duration_ns(std::string_view text) {
    constexpr double longest_s = 3600;
    double seconds = 0;
    std::from_chars(text.data(), text.data() + text.size(), seconds);
    return seconds > 0 && seconds <= longest_s ? static_cast<std::int64_t>(seconds * 1e9) : 0;
}

/// Whether a tag applies to the next segment only.
bool is_of_one_segment(std::string_view tag) {
    return after_tag(tag, "#EXTINF") || after_tag(tag, "#EXT-X-BYTERANGE") || tag == "#EXT-X-DISCONTINUITY" ||
           after_tag(tag, "#EXT-X-PROGRAM-DATE-TIME");
}

/// Checks a tag that names a place or a feature that is not read.
Result<void> check_media_tag(std::string_view line, const std::string& place, HlsMediaFacts& facts) {
    if (is_master_line(line)) return input_error("leads to further playlists, where segments should be");
    if (const auto key = after_tag(line, "#EXT-X-KEY"); key && attribute(*key, "METHOD") != "NONE")
        return input_error("is encrypted, which is not read");
    const auto map = after_tag(line, "#EXT-X-MAP");
    if (!map) return {};
    const auto named = attribute(*map, "URI");
    if (!named) return input_error("has an initialisation without a URI");
    TRY_ASSIGN(auto header, resolved_place(place, *named));
    if (!facts.header.empty() && facts.header != header)
        return input_error("changes its initialisation on the way, which is not read");
    facts.header = std::move(header);
    return {};
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
    text += variant_text(shown);  // players begin with the first variant
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
    std::int64_t number = first_number_in(media);
    while (const auto line = next_line(media)) number += after_tag(*line, "#EXTINF") ? 1 : 0;
    return number;
}

bool is_hls_playlist(std::string_view first_bytes) {
    constexpr std::string_view begin = "#EXTM3U";
    return first_bytes.starts_with(begin) &&
           (first_bytes.size() == begin.size() || first_bytes[begin.size()] == '\n' ||
            first_bytes[begin.size()] == '\r');
}

Result<std::string> resolved_place(std::string_view base, std::string_view named) {
    constexpr std::size_t longest = 4096;
    const auto is_odd = [](char letter) {
        return static_cast<unsigned char>(letter) <= ' ' || letter == 127;
    };
    const bool is_file = base.starts_with(file_scheme);
    if (named.empty() || named.size() > longest || (!is_file && std::ranges::any_of(named, is_odd)) ||
        named.find('\\') != std::string_view::npos)
        return input_error("it names " + in_quotes(named) + ", which is no URI");
    if (!scheme_in(named).empty()) return absolute_place(base, named);
    const PlaceParts own = parts_of(base);
    if (named.starts_with("//")) {
        if (is_file) return foreign_place(named);
        return absolute_place(base, own.origin.substr(0, own.origin.find(':') + 1) + std::string(named));
    }
    const std::string folder = own.path.substr(0, own.path.rfind('/') + 1);
    if (is_file) {
        if (named.starts_with('/') || has_step_up(named)) return foreign_place(named);
        return std::string(file_scheme) + folder + std::string(named);
    }
    const std::size_t query = std::min(named.find('?'), named.size());
    const std::string_view path = named.substr(0, query);
    const std::string whole = path.empty()            ? own.path
                              : path.starts_with('/') ? std::string(path)
                                                      : folder + std::string(path);
    return own.origin + plain_path(whole) + std::string(named.substr(query));
}

Result<HlsPlaces> places_in_playlist(std::string_view text, const std::string& place) {
    TRY(check_size(text));
    const NamedPlaylists named = named_in(text);
    const std::string own = parts_of(place).path;
    const bool is_ours = text.find(hls_mark) != std::string_view::npos;
    for (const std::string_view colour : {hls_colour_name, hls_low_colour_name})
        if (is_ours && own.ends_with("/" + std::string(colour)))
            return input_error("has colour alone, which is not felt; open " + std::string(hls_master_name) +
                               " beside it");
    if (!named.is_master) return HlsPlaces{.touch = place};
    HlsPlaces places;
    if (!named.touch)
        return input_error("has no planes that can be felt: its master playlist names none as " +
                           std::string(hls_planes_id));
    const auto take = [&](std::optional<std::string_view> of, std::string& to) -> Result<void> {
        if (!of) return {};
        TRY_ASSIGN(auto resolved, resolved_place(place, *of));
        if (resolved == place) return input_error("is a playlist of itself");
        to = std::move(resolved);
        return {};
    };
    TRY(take(named.touch, places.touch));
    TRY(take(named.colour, places.colour));
    if (places.colour == places.touch) places.colour.clear();
    if (!named.low_touch) return places;
    TRY(take(named.low_touch, places.low_touch));
    if (places.low_touch == places.touch) places.low_touch.clear();
    if (places.colour.empty() || places.low_touch.empty()) return places;
    TRY(take(named.low_colour, places.low_colour));
    if (places.low_colour == places.colour || places.low_colour == places.low_touch)
        places.low_colour.clear();
    return places;
}

Result<HlsMediaFacts> check_hls_media(std::string_view text, const std::string& place) {
    TRY(check_size(text));
    HlsMediaFacts facts;
    std::int64_t segments = 0, first = 0;
    while (const auto line = next_line(text)) {
        if (line->starts_with('#')) {
            TRY(check_media_tag(*line, place, facts));
            facts.has_ended = facts.has_ended || *line == "#EXT-X-ENDLIST";
            const auto number = after_tag(*line, "#EXT-X-MEDIA-SEQUENCE");
            if (!number) continue;
            const auto counted = segment_number(*number);
            if (!counted) return input_error("counts its segments from " + in_quotes(*number));
            first = *counted;
            continue;
        }
        TRY_ASSIGN(const auto segment, resolved_place(place, *line));
        if (segment == place) return input_error("is a playlist of itself");
        ++segments;
    }
    if (segments == 0) return input_error("has no segment yet");
    facts.next_segment = first + segments;
    return facts;
}

std::optional<HlsListedSegment> segment_in(std::string_view text, const std::string& place,
                                           const std::string& segment, std::int64_t least) {
    HlsListedSegment listed{first_number_in(text), 0};
    while (const auto line = next_line(text)) {
        if (const auto length = after_tag(*line, "#EXTINF")) listed.duration_ns = duration_ns(*length);
        if (line->starts_with('#')) continue;
        const auto named = resolved_place(place, *line);
        if (listed.number >= least && named && *named == segment) return listed;
        listed = {listed.number + 1, 0};
    }
    return std::nullopt;
}

std::optional<std::string> playlist_from(std::string_view text, std::int64_t first) {
    std::string rest = "#EXTM3U\n#EXT-X-MEDIA-SEQUENCE:" + std::to_string(first) + "\n", of_next;
    std::int64_t number = first_number_in(text);
    bool has_segment = false;
    while (const auto line = next_line(text)) {
        if (after_tag(*line, "#EXT-X-MEDIA-SEQUENCE") || *line == "#EXTM3U") continue;
        const bool is_segment = !line->starts_with('#');
        std::string& to = is_segment || is_of_one_segment(*line) ? of_next : rest;
        to += *line;
        to += '\n';
        if (!is_segment) continue;
        if (number++ >= first) {
            has_segment = true;
            rest += of_next;
        }
        of_next.clear();
    }
    return has_segment ? std::optional(std::move(rest)) : std::nullopt;
}

}  // namespace touchable
