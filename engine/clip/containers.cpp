// SPDX-License-Identifier: Apache-2.0
// Metadata of our clips, whatever the container: tags, additions to blocks, frames' times, attached texts.
#include "engine/clip/containers.hpp"

#include <cmath>
#include <cstring>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/intreadwrite.h>
}

namespace touchable {
namespace {

// An addition: identifier (8 bytes, FFmpeg's), frames (4), CRC-32 (4); in a stream also the frame's number
// (8) and when it was taken (8). All with the high byte first.
constexpr std::size_t frames_at = 8, crc_at = 12, addition_size = 16, label_at = 16, labelled_size = 32;
constexpr std::uint64_t addition_id = 1;

std::uint32_t crc_of(std::uint32_t crc, const std::uint8_t* bytes, std::size_t size) {
    return av_crc(av_crc_get_table(AV_CRC_32_IEEE), crc, bytes, size);
}

constexpr std::uint32_t crc_of_nothing = ~std::uint32_t{0};

/// The next 00 00 01 from `at` on, or the end.
std::size_t start_code(std::span<const std::uint8_t> bytes, std::size_t at) {
    for (; at + 3 <= bytes.size(); ++at)
        if (bytes[at] == 0 && bytes[at + 1] == 0 && bytes[at + 2] == 1) return at;
    return bytes.size();
}

/// CRC of H.264 units as Matroska stores them: with a length in place of the encoder's start code (ISO/IEC
/// 14496-15; a start code of four bytes has one more zero).
std::uint32_t crc_of_units(std::uint32_t crc, std::span<const std::uint8_t> bytes) {
    std::size_t begin = start_code(bytes, 0);
    while (begin < bytes.size()) {
        begin += 3;
        const std::size_t next = start_code(bytes, begin);
        const std::size_t end = next < bytes.size() && bytes[next - 1] == 0 ? next - 1 : next;
        std::uint8_t length[4];
        AV_WB32(length, static_cast<std::uint32_t>(end - begin));
        crc = crc_of(crc, length, sizeof length);
        crc = crc_of(crc, bytes.data() + begin, end - begin);
        begin = next;
    }
    return crc;
}

std::uint32_t crc_of_addition(std::span<const std::uint8_t> addition) {
    const std::uint32_t crc = crc_of(crc_of_nothing, addition.data() + frames_at, 4);
    return crc_of(crc, addition.data() + label_at, addition.size() - label_at);
}

constexpr std::int64_t ns_a_ms = 1'000'000;

std::string_view take_time_line(std::string_view& text) {
    std::string_view line = cut_line(text);
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

std::optional<std::int64_t> ns_of(std::string_view line) {
    constexpr double latest_ms = 4e12;
    const auto ms = parsed_as<double>(line);
    if (!ms || !(std::fabs(*ms) <= latest_ms)) return {};
    return std::llround(*ms * ns_a_ms);
}

}  // namespace

namespace clip_tags {

std::optional<std::int64_t> parse_version(std::string_view text) {
    const auto version = parsed_as<std::int64_t>(text);
    return version && *version >= 1 ? version : std::nullopt;
}

std::optional<int> parse_bits(std::string_view text) {
    const auto bits = parsed_as<std::int64_t>(text);
    if (!bits || *bits < 9 || *bits > 16) return std::nullopt;
    return static_cast<int>(*bits);
}

std::string rate_text(const FrameRate& rate) {
    return std::to_string(rate.num) + "/" + std::to_string(rate.den);
}

std::optional<FrameRate> parse_rate(std::string_view text) {
    const auto slash = text.find('/');
    if (slash == std::string_view::npos) return std::nullopt;
    const auto num = parsed_as<std::int64_t>(text.substr(0, slash)),
               den = parsed_as<std::int64_t>(text.substr(slash + 1));
    constexpr std::int64_t most = 1'000'000'000;  // as scenes allow
    if (!num || !den || *num < 1 || *den < 1 || *num > most || *den > most) return std::nullopt;
    return FrameRate{*num, *den};
}

bool same_rate(const FrameRate& a, const FrameRate& b) {
    return a.num * b.den == b.num * a.den;
}

std::optional<std::string> rate_note(const FrameRate& played, const FrameRate& recorded) {
    const bool keeps_times = !recorded.own_times || played.own_times;
    if (same_rate(played, recorded) && keeps_times) return std::nullopt;
    return "played at " + rate_text(played) + " frames/s, as the scene file has it; recorded at " +
           (recorded.own_times ? "times of their own, on average " : "") + rate_text(recorded);
}

bool is_too_fast(const FrameRate& rate) {
    return rate.num > rate.den * fastest_rate;
}

}  // namespace clip_tags

Result<void> add_block_addition(AVPacket& packet, AVCodecID codec, std::int64_t frames,
                                const std::optional<PictureLabel>& label) {
    const std::size_t size = label ? labelled_size : addition_size;
    std::uint8_t* data = av_packet_new_side_data(&packet, AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, size);
    if (!data) return memory_error();
    AV_WB64(data, addition_id);
    AV_WB32(data + frames_at, static_cast<std::uint32_t>(frames));
    if (label) {
        AV_WB64(data + label_at, static_cast<std::uint64_t>(label->frame));
        AV_WB64(data + label_at + 8, static_cast<std::uint64_t>(label->taken_ns));
    }
    const std::uint32_t crc = crc_of_addition(std::span(data, size));
    const std::span<const std::uint8_t> bytes(packet.data, static_cast<std::size_t>(packet.size));
    AV_WB32(data + crc_at,
            codec == AV_CODEC_ID_H264 ? crc_of_units(crc, bytes) : crc_of(crc, bytes.data(), bytes.size()));
    return {};
}

std::optional<BlockAddition> block_addition_of(const AVPacket& packet) {
    std::size_t size = 0;
    const std::uint8_t* data = av_packet_get_side_data(&packet, AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL, &size);
    if (!data) return std::nullopt;
    if ((size != addition_size && size != labelled_size) || AV_RB64(data) != addition_id)
        return BlockAddition{1, false};
    const std::int64_t frames = AV_RB32(data + frames_at);
    std::uint32_t crc = crc_of_addition(std::span(data, size));
    crc = crc_of(crc, packet.data, static_cast<std::size_t>(packet.size));
    BlockAddition addition{
        frames, frames > 0 && frames <= clip_tags::access_interval && AV_RB32(data + crc_at) == crc};
    if (size == labelled_size)
        addition.label = PictureLabel{static_cast<std::int64_t>(AV_RB64(data + label_at)),
                                      static_cast<std::int64_t>(AV_RB64(data + label_at + 8))};
    return addition;
}

std::string frame_times_text(const FrameRate& rate) {
    std::string text = "# timestamp format v2\n";
    for (const std::int64_t ns : *rate.own_times)
        text += formatted("%lld.%06lld\n", static_cast<long long>(ns / ns_a_ms),
                          static_cast<long long>(ns % ns_a_ms));
    return text;
}

Result<FrameRate> parse_frame_times(std::string_view text, const std::string& name) {
    const std::string_view head = take_time_line(text);
    if (head != "# timestamp format v2" && head != "# timecode format v2")
        return input_error(name + ": begins with " + in_quotes(head) +
                           ": must be a line \"# timestamp format v2\", then a line per frame, milliseconds");
    std::vector<std::int64_t> times_ns;
    for (int number = 2; !text.empty(); ++number) {
        const std::string_view line = take_time_line(text);
        if (line.empty() || line.starts_with('#')) continue;
        const auto time_ns = ns_of(line);
        if (!time_ns)
            return input_error(name + ", line " + std::to_string(number) + ": is " + in_quotes(line) +
                               ": must be the time of a frame, milliseconds");
        if (!times_ns.empty() && *time_ns < times_ns.back() + shortest_frame_ns)
            return input_error(name + ", line " + std::to_string(number) + ": is " + in_quotes(line) +
                               ": must be 1 ms or more after the frame before");
        times_ns.push_back(*time_ns);
    }
    if (times_ns.size() < 2)
        return input_error(name + ": has the times of " + std::to_string(times_ns.size()) +
                           " frames: must be of two or more");
    if (auto rate = rate_of_own_times(std::move(times_ns))) return std::move(*rate);
    return input_error(name + ": must be of less than 126 years");
}

SceneDescription said_of_clip(const SceneDescription& described) {
    SceneDescription said(described.scene);
    said.unstated = described.unstated;
    said.scene.folder.reset();
    said.scene.video.reset();
    said.scene.stored = {};  // the clip stores codes
    return said;
}

void add_clip_tags(AVFormatContext& muxer, const FrameRate& rate, int version) {
    av_dict_set_int(&muxer.metadata, clip_tags::version_tag, version, 0);
    av_dict_set(&muxer.metadata, clip_tags::rate_tag, clip_tags::rate_text(rate).c_str(), 0);
}

bool is_shown_by_players(PlaneRole role, const FrameCheck& check) {
    const bool has_colour = check.bytes_per_sample(PlaneRole::colour) > 0;
    return role == (has_colour ? PlaneRole::colour : PlaneRole::depth);
}

Result<void> add_plane_stream(AVFormatContext& muxer, const TrackEncoder& encoder, PlaneRole role,
                              TrackCoding coding, const FrameCheck& check, const Scene& scene) {
    AVStream* const stream = avformat_new_stream(&muxer, nullptr);
    if (!stream) return memory_error();
    TRY(encoder.describe(*stream->codecpar));
    stream->time_base = {1, 1000};
    stream->avg_frame_rate = {static_cast<int>(scene.rate.num), static_cast<int>(scene.rate.den)};
    const std::string name(role_name(role));
    av_dict_set(&stream->metadata, clip_tags::role_tag, name.c_str(), 0);
    av_dict_set(&stream->metadata, "title", name.c_str(), 0);
    if (coding != TrackCoding::h264_visual) av_dict_set(&stream->metadata, clip_tags::lossless_tag, "1", 0);
    if (check.bytes_per_sample(role) == 2)
        av_dict_set_int(&stream->metadata, clip_tags::bits_tag,
                        role == PlaneRole::depth ? scene.depth_bits : 16, 0);
    stream->disposition = is_shown_by_players(role, check) ? AV_DISPOSITION_DEFAULT : 0;
    return {};
}

Result<void> attach_text(AVFormatContext& muxer, const char* name, const char* type,
                         const std::string& text) {
    AVStream* const stream = avformat_new_stream(&muxer, nullptr);
    if (!stream) return memory_error();
    stream->codecpar->codec_type = AVMEDIA_TYPE_ATTACHMENT;
    stream->codecpar->extradata =
        static_cast<std::uint8_t*>(av_mallocz(text.size() + AV_INPUT_BUFFER_PADDING_SIZE));
    if (!stream->codecpar->extradata) return memory_error();
    std::memcpy(stream->codecpar->extradata, text.data(), text.size());
    stream->codecpar->extradata_size = static_cast<int>(text.size());
    av_dict_set(&stream->metadata, "filename", name, 0);
    av_dict_set(&stream->metadata, "mimetype", type, 0);
    return {};
}

Result<FrameRate> ClipContainer::tagged_rate(const Demuxer& file,
                                             const std::optional<std::string>& own_times) const {
    const auto version = file.tag(clip_tags::version_tag);
    if (!version) return refuse("is not a touchable clip: it has no tag T3D_VERSION");
    const auto number = clip_tags::parse_version(*version);
    if (!number)
        return refuse("its tag T3D_VERSION is " + in_quotes(*version) + ": must be a whole number from 1");
    if (*number > words_.newest_version)
        return refuse("is of clip format " + printable(*version) + "; this program reads up to " +
                      std::to_string(words_.newest_version) + ": use a newer one");
    const auto stated = file.tag(clip_tags::rate_tag);
    auto rate = stated ? clip_tags::parse_rate(*stated) : std::nullopt;
    if (!rate || clip_tags::is_too_fast(*rate))
        return refuse("its tag T3D_RATE is " + (stated ? in_quotes(*stated) : "missing") +
                      ": must be a frame rate such as 30000/1001, at most " +
                      std::to_string(clip_tags::fastest_rate) + "/1");
    if (!own_times) return *rate;
    TRY_ASSIGN(auto times, parse_frame_times(*own_times, file_ + ": " + words_.times));
    rate->own_times = std::move(times.own_times);
    return *rate;
}

Result<SceneDescription> ClipContainer::described_by(const std::string& json,
                                                     const FrameRate& recorded) const {
    auto described = parse_scene(json, file_ + ": " + words_.scene);
    if (!described) return described;
    const FrameRate& rate = described->scene.rate;
    if (!described->unstated.rate && !clip_tags::same_rate(rate, recorded))
        return refuse("its tag T3D_RATE is " + clip_tags::rate_text(recorded) + ", but its " + words_.scene +
                      " says " + clip_tags::rate_text(rate));
    described->unstated.rate = true;
    return described;
}

}  // namespace touchable
