// SPDX-License-Identifier: Apache-2.0
#include "engine/picture/input.hpp"

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/intreadwrite.h>
}

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <string_view>

#include "engine/base/try.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

namespace {

/// Sound samples without sizes are counted singly; a coded byte holds dozens, at most this many.
constexpr std::uint64_t samples_per_byte = 64;
constexpr int most_nested = 10;
constexpr std::size_t head_bytes = 16;  // of a box, or of a table
constexpr std::size_t most_disparities = 16;  // tracks, of which a video has one

struct Box {
    std::string_view type;
    std::uint64_t content, end;
};

/// A table has a version, flags, a number of entries, and the entries.
struct TableKind {
    std::string_view type;
    std::uint64_t entry_bytes;
};
constexpr TableKind table_kinds[] = {{"stsc", 12}, {"stco", 4}, {"co64", 8},
                                     {"stss", 4},  {"stps", 4}, {"keys", 8}};

bool has_boxes(std::string_view type) {
    constexpr std::string_view known[] = {"moov", "trak", "mdia", "minf", "stbl", "edts", "dinf", "udta",
                                          "mvex", "moof", "traf", "gmhd", "tref", "mfra", "wave"};
    return std::ranges::find(known, type) != std::end(known);
}

class Walk {
public:
    explicit Walk(ByteSource& bytes, std::uint64_t end) : bytes_(bytes), end_(end) {}
    Result<void> boxes(std::uint64_t at, std::uint64_t end, int depth) {
        while (at + 8 <= end) {
            TRY_ASSIGN(const auto head, head_at<head_bytes>(bytes_, at, end_));
            const std::uint64_t stated = AV_RB32(head.data());
            const std::uint64_t before = stated == 1 ? 16 : 8;
            const std::uint64_t size = stated == 0   ? end - at
                                       : stated == 1 ? AV_RB64(head.data() + 8)
                                                     : stated;
            if (size < before) return {};
            const std::string_view type(reinterpret_cast<const char*>(head.data()) + 4, 4);
            const std::uint64_t found_end = at + std::min(size, end - at);
            const Box found{type, std::min(at + before, found_end), found_end};
            TRY(box(found, depth));
            at = found.end;
        }
        return {};
    }

    /// After `boxes`: checks what all of them claim together.
    Result<DisparityTracks> end() {
        if (samples_ == 0 || edits_ <= samples_per_byte * end_ / samples_) return std::move(disparities_);
        return input_error("its " + std::to_string(edits_) + " edits of " + std::to_string(samples_) +
                           " samples are more than the file has bytes for: it is damaged");
    }

private:
    /// Whether a box of free space begins like the movie's box: FFmpeg then takes it for that.
    Result<bool> hides_a_movie(const Box& box) {
        if ((box.type != "free" && box.type != "hoov") || box.content + 8 > box.end) return false;
        TRY_ASSIGN(const auto head, head_of(box));
        const std::string_view first(reinterpret_cast<const char*>(head.data()) + 4, 4);
        return first == "mvhd" || first == "cmov";
    }

    Result<void> box(const Box& box, int depth) {
        TRY_ASSIGN(const auto hides, hides_a_movie(box));
        if (hides && depth < most_nested) return boxes(box.content, box.end, depth + 1);
        if (box.type == "cmov")
            return input_error(
                "its tables are compressed (cmov), which nothing has written for twenty years");
        if (has_boxes(box.type) && depth < most_nested) return boxes(box.content, box.end, depth + 1);
        if (box.type == "meta" && depth < most_nested) return metadata(box, depth);
        if (box.type == "stsz" || box.type == "stz2") return sizes(box);
        if (box.type == "trun") return run(box);
        if (box.type == "elst") return edits(box);
        if (box.type == "sbgp" || box.type == "sgpd") return groups(box);
        if (box.type == "tkhd") return track(box);
        if (box.type == "stsd") return sample_entry(box);
        for (const TableKind& kind : table_kinds)
            if (box.type == kind.type) return table(box, kind);
        return {};
    }

    Result<void> table(const Box& box, const TableKind& kind) {
        TRY_ASSIGN(const auto head, head_of(box));
        return hold(box, AV_RB32(head.data() + 4), 8 * kind.entry_bytes, 8);
    }

    Result<void> track(const Box& box) {
        TRY_ASSIGN(const auto head, head_at<24>(bytes_, box.content, end_));
        track_ = static_cast<int>(AV_RB32(head.data() + (head[0] == 1 ? 20 : 12)));  // after its times
        return {};
    }

    Result<void> sample_entry(const Box& box) {
        constexpr std::uint64_t name_at = 12;  // after version, count, and the entry's length
        TRY_ASSIGN(const auto head, head_of(box));
        const std::string_view name(reinterpret_cast<const char*>(head.data()) + name_at, 4);
        if (name != "dish" || box.content + head_bytes > box.end ||
            disparities_.ids.size() == most_disparities)
            return {};
        disparities_.ids.push_back(track_);
        disparities_.names_at.push_back(box.content + name_at);
        return {};
    }

    /// QuickTime's metadata are boxes only; MP4's follow a version.
    Result<void> metadata(const Box& box, int depth) {
        TRY_ASSIGN(const auto head, head_of(box));
        const bool is_quicktime = AV_RB32(head.data() + 4) == AV_RB32("hdlr");
        return boxes(std::min(box.content + (is_quicktime ? 0 : 4), box.end), box.end, depth + 1);
    }

    /// Groups of samples: which samples are in each, or its description, of a byte or more.
    Result<void> groups(const Box& box) {
        TRY_ASSIGN(const auto head, head_of(box));
        const std::uint64_t count_at = head[0] == 0 ? 8 : 12;
        return hold(box, AV_RB32(head.data() + count_at), box.type == "sbgp" ? 64 : 8, count_at + 4);
    }

    /// Sizes of samples: one for all, or one for each.
    Result<void> sizes(const Box& box) {
        TRY_ASSIGN(const auto head, head_of(box));
        const std::uint64_t samples = AV_RB32(head.data() + 8);
        samples_ += samples;
        const bool is_compact = box.type == "stz2";
        if (!is_compact && AV_RB32(head.data() + 4) != 0) return count_unsized(box, samples);
        return hold(box, samples, is_compact ? head[7] : 32, 12);
    }

    /// A fragment's samples: its flags state which entries each has.
    Result<void> run(const Box& box) {
        TRY_ASSIGN(const auto head, head_of(box));
        const std::uint32_t flags = AV_RB32(head.data());
        std::uint64_t bits = 0;
        for (const std::uint32_t flag : {0x100U, 0x200U, 0x400U, 0x800U})
            if ((flags & flag) != 0) bits += 32;
        const std::uint64_t samples = AV_RB32(head.data() + 4);
        samples_ += samples;
        return bits == 0 ? count_unsized(box, samples) : hold(box, samples, bits, 8);
    }

    /// Edits, the stretches of a track that are played: FFmpeg's index repeats the samples of each.
    Result<void> edits(const Box& box) {
        constexpr std::uint64_t least_bytes = 12;
        edits_ += (box.end - box.content) / least_bytes;
        return {};
    }

    Result<void> hold(const Box& box, std::uint64_t entries, std::uint64_t bits, std::uint64_t skipped) {
        const std::uint64_t there = box.end - std::min(box.content + skipped, box.end);
        if ((entries * bits + 7) / 8 <= there) return {};
        return input_error("its table " + std::string(box.type) + " claims " + std::to_string(entries) +
                           " entries in " + std::to_string(there) + " bytes: it is damaged");
    }

    Result<void> count_unsized(const Box& box, std::uint64_t samples) {
        unsized_ += samples;
        if (unsized_ / samples_per_byte <= end_) return {};
        return input_error("its table " + std::string(box.type) + " claims " + std::to_string(samples) +
                           " samples, of which the file has not the bytes: it is damaged");
    }

    Result<std::array<std::uint8_t, head_bytes>> head_of(const Box& box) {
        return head_at<head_bytes>(bytes_, box.content, end_);
    }

    ByteSource& bytes_;
    std::uint64_t end_;
    std::uint64_t unsized_ = 0, samples_ = 0, edits_ = 0;
    DisparityTracks disparities_;
    int track_ = 0;  // number of the newest track
};

// Element identifiers of EBML (RFC 8794) and Matroska, with their length markers.
constexpr std::uint64_t id_ebml = 0x1A45DFA3, id_segment = 0x18538067, id_cluster = 0x1F43B675,
                        id_void = 0xEC;
constexpr std::uint64_t unknown_size = ~std::uint64_t{0};
/// Bytes of all but the pictures, which a demuxer keeps in memory; the index of a day takes less.
constexpr std::uint64_t largest_headers = 64 << 20;

struct Element {
    std::uint64_t id = 0, size = 0;
    std::uint64_t content = 0;  ///< where it begins in the file
    std::uint64_t end() const { return content + size; }
};

/// Reads elements at stated positions. After a failed read it finds none.
class ElementReader {
public:
    explicit ElementReader(ByteSource& bytes) : bytes_(bytes) {}
    std::uint64_t length() const { return bytes_.size(); }
    /// Why reading failed.
    const std::optional<Error>& failure() const { return failure_; }

    /// Identifier and size of the element at `position`; nullopt if there is none.
    std::optional<Element> at(std::uint64_t position) {
        position_ = position;
        const auto id = number(4, true);
        const auto size = id ? number(8, false) : std::nullopt;
        if (!size) return std::nullopt;
        return Element{*id, *size, position_};
    }

    /// False if the element begins with a CRC-32 that the rest of it does not match, or reading fails.
    bool crc_holds(const Element& element) {
        std::array<std::uint8_t, 1 << 16> bytes;
        constexpr std::size_t crc_bytes = 6;  // identifier 0xBF, size 0x84, four bytes
        if (element.size < crc_bytes) return true;
        position_ = element.content;
        if (!read(bytes.data(), crc_bytes)) return false;
        if (bytes[0] != 0xBF || bytes[1] != 0x84) return true;
        const std::uint32_t stated = AV_RL32(bytes.data() + 2);
        std::uint32_t crc = ~std::uint32_t{0};
        for (std::uint64_t left = element.size - crc_bytes; left > 0;) {
            const auto some = static_cast<std::size_t>(std::min<std::uint64_t>(left, bytes.size()));
            if (!read(bytes.data(), some)) return false;
            crc = av_crc(av_crc_get_table(AV_CRC_32_IEEE_LE), crc, bytes.data(), some);
            left -= some;
        }
        return ~crc == stated;
    }

private:
    /// A number whose first byte's leading zeros tell how many bytes follow; all ones without the marker mean
    /// an unknown size.
    std::optional<std::uint64_t> number(int longest, bool keep_marker) {
        std::uint8_t first = 0;
        if (!read(&first, 1)) return std::nullopt;
        const int following = std::countl_zero(first);
        if (following >= longest) return std::nullopt;
        const int marker = 0x80 >> following;
        auto value = static_cast<std::uint64_t>(keep_marker ? first : first & (marker - 1));
        for (int k = 0; k < following; ++k) {
            std::uint8_t next = 0;
            if (!read(&next, 1)) return std::nullopt;
            value = value << 8 | next;
        }
        const std::uint64_t all_ones = (std::uint64_t{1} << (7 * (following + 1))) - 1;
        return !keep_marker && value == all_ones ? unknown_size : value;
    }

    bool read(std::uint8_t* to, std::size_t size) {
        if (failure_ || position_ > length() || size > length() - position_) return false;
        if (auto read = bytes_.read(position_, reinterpret_cast<char*>(to), size); !read)
            failure_ = read.error();
        position_ += size;
        return !failure_;
    }

    ByteSource& bytes_;
    std::uint64_t position_ = 0;
    std::optional<Error> failure_;
};

Result<MatroskaEnd> check_segment(ElementReader& reader, const Element& segment, const std::string& file) {
    constexpr std::uint64_t longest_head = 12;  // of an element: its identifier and its size
    const bool is_stated = segment.size != unknown_size;
    const bool is_short = is_stated && segment.size > reader.length() - segment.content;
    const std::uint64_t end = is_stated && !is_short ? segment.end() : reader.length();
    std::uint64_t position = segment.content, headers = 0;
    bool has_cluster = false;
    const auto cut_here = [&](std::uint64_t at) -> Result<MatroskaEnd> {
        if (!is_stated || has_cluster) return MatroskaEnd{at, is_stated, true};
        return input_error(file + ": is truncated: it ends before its first whole frame");
    };
    while (position < end) {
        const auto damaged = [&file, position] {
            return input_error(file + ": is damaged near byte " + std::to_string(position));
        };
        const auto element = reader.at(position);
        if (!element || element->content > end || element->size > end - element->content) {
            const bool may_be_cut = element ? element->size <= segment.size : end - position < longest_head;
            if (is_stated && !(is_short && may_be_cut)) return damaged();
            return cut_here(position);
        }
        position = element->end();
        has_cluster = has_cluster || element->id == id_cluster;
        if (element->id == id_cluster || element->id == id_void) continue;
        headers += element->size;
        if (headers > largest_headers)
            return input_error(
                file + ": its headers, tags and attachments are larger than 64 MiB together: must be less");
        if (!reader.crc_holds(*element)) return damaged();
    }
    return is_short ? cut_here(end) : MatroskaEnd{end, is_stated};
}

}  // namespace

Result<DisparityTracks> checked_boxes(ByteSource& bytes, std::uint64_t end) {
    Walk walk(bytes, end);
    TRY(walk.boxes(0, end, 0));
    return walk.end();
}

Result<void> check_box_tables(ByteSource& bytes, std::uint64_t end) {
    TRY(checked_boxes(bytes, end));
    return {};
}

Result<MatroskaEnd> check_matroska(ByteSource& bytes, const std::string& file) {
    ElementReader reader(bytes);
    if (reader.length() == 0) return input_error(file + ": is empty");
    const auto header = reader.at(0);
    const auto segment = header && header->id == id_ebml && header->size < reader.length()
                             ? reader.at(header->end())
                             : std::nullopt;
    if (reader.failure()) return error_at(file, *reader.failure());
    if (!header || header->id != id_ebml) return input_error(file + ": is not a Matroska file");
    if (!segment)
        return input_error(file + ": is truncated: it ends at byte " + std::to_string(reader.length()));
    if (segment->id != id_segment)
        return input_error(file + ": is damaged: its header is not followed by a segment");
    const auto end = check_segment(reader, *segment, file);
    if (reader.failure()) return error_at(file, *reader.failure());
    return end;
}

Result<std::optional<std::uint64_t>> end_of_boxes(ByteSource& bytes) {
    const std::uint64_t length = bytes.size();
    std::uint64_t position = 0;
    while (position < length) {
        TRY_ASSIGN(const auto head, head_at<16>(bytes, position, length));
        const bool is_json = head[0] == '{' && head[1] == '"';
        const bool is_nothing =
            std::all_of(head.begin(), head.begin() + 8, [](auto byte) { return byte == 0; });
        if (position > 0 && (is_json || is_nothing)) return std::optional(position);
        const std::uint64_t stated = AV_RB32(head.data());
        const std::uint64_t size = stated == 0   ? length - position  // to the end of the file
                                   : stated == 1 ? AV_RB64(head.data() + 8)
                                                 : stated;
        if (size < 8 || size > length - position) return std::optional<std::uint64_t>();
        position += size;
    }
    return length > 0 ? std::optional(length) : std::nullopt;
}

Result<std::optional<std::uint64_t>> end_of_riff(ByteSource& bytes) {
    const std::uint64_t length = bytes.size();
    std::uint64_t position = 0;
    while (position + 8 < length) {
        TRY_ASSIGN(const auto head, head_at<8>(bytes, position, length));
        const bool is_chunk = AV_RB32(head.data()) == AV_RB32("RIFF");
        if (!is_chunk && position > 0) break;
        const std::uint64_t end = position + 8 + AV_RL32(head.data() + 4);
        if (!is_chunk || end == position + 8 || end > length) return std::optional<std::uint64_t>();
        position = end;
    }
    return position > 0 ? std::optional(position) : std::nullopt;
}

Result<std::uint64_t> end_of_container(ByteSource& bytes, const std::string& file) {
    const std::string begin = first_bytes(bytes, 4);
    if (begin == "\x1a\x45\xdf\xa3") {
        const auto end = check_matroska(bytes, file);
        if (!end && end.error().kind == ErrorKind::interrupted) return end.error();
        return end ? end->at : bytes.size();
    }
    TRY_ASSIGN(const auto end, begin == "RIFF" ? end_of_riff(bytes) : end_of_boxes(bytes));
    return end.value_or(bytes.size());
}

}  // namespace touchable
