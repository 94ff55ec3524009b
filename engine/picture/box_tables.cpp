#include "engine/picture/box_tables.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

extern "C" {
#include <libavutil/intreadwrite.h>

#include "engine/base/try.hpp"
}

namespace touchable {
namespace {

/// Sound whose samples have no sizes counts them one by one, of which a coded byte holds dozens.
constexpr std::uint64_t samples_per_byte = 64;
constexpr int most_nested = 10;
constexpr std::size_t head_bytes = 16;  // of a box, and of what a table begins with

struct Box {
    std::string_view type;
    std::uint64_t content, end;
};

/// Of a table of version, flags, a number of entries, and these.
struct TableKind {
    std::string_view type;
    std::uint64_t entry_bytes;
};
constexpr TableKind table_kinds[] = {{"stsc", 12}, {"stco", 4}, {"co64", 8},
                                     {"stss", 4},  {"stps", 4}, {"keys", 8}};

bool has_boxes(std::string_view type) {
    constexpr std::string_view known[] = {"moov", "trak", "mdia", "minf", "stbl", "edts", "dinf", "udta",
                                          "mvex", "moof", "traf", "gmhd", "tref", "mfra", "wave"};
    return std::find(std::begin(known), std::end(known), type) != std::end(known);
}

class Walk {
public:
    explicit Walk(ByteSource& bytes, std::uint64_t end) : bytes_(bytes), end_(end) {}
    Result<void> boxes(std::uint64_t at, std::uint64_t end, int depth);
    Result<void> check_edits() const;

private:
    Result<bool> hides_a_movie(const Box& box);
    Result<void> box(const Box& box, int depth);
    Result<void> table(const Box& box, const TableKind& kind);
    Result<void> metadata(const Box& box, int depth);
    Result<void> groups(const Box& box);
    Result<void> sizes(const Box& box);
    Result<void> run(const Box& box);
    Result<void> edits(const Box& box);
    Result<void> hold(const Box& box, std::uint64_t entries, std::uint64_t bits, std::uint64_t skipped);
    Result<void> count_unsized(const Box& box, std::uint64_t samples);
    Result<std::array<std::uint8_t, head_bytes>> head_at(std::uint64_t at);

    ByteSource& bytes_;
    std::uint64_t end_;
    std::uint64_t unsized_ = 0, samples_ = 0, edits_ = 0;
};

/// As many as there are; the rest is zero.
Result<std::array<std::uint8_t, head_bytes>> Walk::head_at(std::uint64_t at) {
    std::array<std::uint8_t, head_bytes> head{};
    const auto some = static_cast<std::size_t>(std::min<std::uint64_t>(head_bytes, end_ - at));
    TRY(bytes_.read(at, reinterpret_cast<char*>(head.data()), some));
    return head;
}

Result<void> Walk::boxes(std::uint64_t at, std::uint64_t end, int depth) {
    while (at + 8 <= end) {
        TRY_ASSIGN(const auto head, head_at(at));
        const std::uint64_t stated = AV_RB32(head.data());
        const std::uint64_t before = stated == 1 ? 16 : 8;
        const std::uint64_t size = stated == 0 ? end - at : stated == 1 ? AV_RB64(head.data() + 8) : stated;
        if (size < before) return {};
        const std::string_view type(reinterpret_cast<const char*>(head.data()) + 4, 4);
        const std::uint64_t found_end = at + std::min(size, end - at);
        const Box found{type, std::min(at + before, found_end), found_end};
        if (auto checked = box(found, depth); !checked) return checked;
        at = found.end;
    }
    return {};
}

/// Of a box that may be another one in disguise: FFmpeg takes free space for the movie's box where it begins
/// so.
Result<bool> Walk::hides_a_movie(const Box& box) {
    if ((box.type != "free" && box.type != "hoov") || box.content + 8 > box.end) return false;
    TRY_ASSIGN(const auto head, head_at(box.content));
    const std::string_view first(reinterpret_cast<const char*>(head.data()) + 4, 4);
    return first == "mvhd" || first == "cmov";
}

Result<void> Walk::box(const Box& box, int depth) {
    TRY_ASSIGN(const auto hides, hides_a_movie(box));
    if (hides && depth < most_nested) return boxes(box.content, box.end, depth + 1);
    if (box.type == "cmov")
        return input_error("its tables are compressed (cmov), which nothing has written for twenty years");
    if (has_boxes(box.type) && depth < most_nested) return boxes(box.content, box.end, depth + 1);
    if (box.type == "meta" && depth < most_nested) return metadata(box, depth);
    if (box.type == "stsz" || box.type == "stz2") return sizes(box);
    if (box.type == "trun") return run(box);
    if (box.type == "elst") return edits(box);
    if (box.type == "sbgp" || box.type == "sgpd") return groups(box);
    for (const TableKind& kind : table_kinds)
        if (box.type == kind.type) return table(box, kind);
    return {};
}

Result<void> Walk::hold(const Box& box, std::uint64_t entries, std::uint64_t bits, std::uint64_t skipped) {
    const std::uint64_t there = box.end - std::min(box.content + skipped, box.end);
    if ((entries * bits + 7) / 8 <= there) return {};
    return input_error("its table " + std::string(box.type) + " claims " + std::to_string(entries) +
                       " entries in " + std::to_string(there) + " bytes: it is damaged");
}

Result<void> Walk::count_unsized(const Box& box, std::uint64_t samples) {
    unsized_ += samples;
    if (unsized_ / samples_per_byte <= end_) return {};
    return input_error("its table " + std::string(box.type) + " claims " + std::to_string(samples) +
                       " samples, of which the file has not the bytes: it is damaged");
}

Result<void> Walk::table(const Box& box, const TableKind& kind) {
    TRY_ASSIGN(const auto head, head_at(box.content));
    return hold(box, AV_RB32(head.data() + 4), 8 * kind.entry_bytes, 8);
}

/// QuickTime's are boxes alone; MP4's stand behind a version.
Result<void> Walk::metadata(const Box& box, int depth) {
    TRY_ASSIGN(const auto head, head_at(box.content));
    const bool is_quicktime = AV_RB32(head.data() + 4) == AV_RB32("hdlr");
    return boxes(std::min(box.content + (is_quicktime ? 0 : 4), box.end), box.end, depth + 1);
}

/// Of samples that belong together: which do, or what there is to know of each group, of a byte or more.
Result<void> Walk::groups(const Box& box) {
    TRY_ASSIGN(const auto head, head_at(box.content));
    const std::uint64_t count_at = head[0] == 0 ? 8 : 12;
    return hold(box, AV_RB32(head.data() + count_at), box.type == "sbgp" ? 64 : 8, count_at + 4);
}

/// Of samples: one for all, or each its own.
Result<void> Walk::sizes(const Box& box) {
    TRY_ASSIGN(const auto head, head_at(box.content));
    const std::uint64_t samples = AV_RB32(head.data() + 8);
    samples_ += samples;
    const bool is_compact = box.type == "stz2";
    if (!is_compact && AV_RB32(head.data() + 4) != 0) return count_unsized(box, samples);
    return hold(box, samples, is_compact ? head[7] : 32, 12);
}

/// Of a fragment's samples: its flags say what each has an entry of.
Result<void> Walk::run(const Box& box) {
    TRY_ASSIGN(const auto head, head_at(box.content));
    const std::uint32_t flags = AV_RB32(head.data());
    std::uint64_t bits = 0;
    for (const std::uint32_t flag : {0x100U, 0x200U, 0x400U, 0x800U})
        if ((flags & flag) != 0) bits += 32;
    const std::uint64_t samples = AV_RB32(head.data() + 4);
    samples_ += samples;
    return bits == 0 ? count_unsized(box, samples) : hold(box, samples, bits, 8);
}

/// Which stretches of a track are played: FFmpeg has the samples of each in its index once more.
Result<void> Walk::edits(const Box& box) {
    constexpr std::uint64_t least_bytes = 12;
    edits_ += (box.end - box.content) / least_bytes;
    return {};
}

Result<void> Walk::check_edits() const {
    if (samples_ == 0 || edits_ <= samples_per_byte * end_ / samples_) return {};
    return input_error("its " + std::to_string(edits_) + " edits of " + std::to_string(samples_) +
                       " samples are more than the file has bytes for: it is damaged");
}

}  // namespace

Result<void> check_box_tables(ByteSource& bytes, std::uint64_t end) {
    Walk walk(bytes, end);
    if (auto checked = walk.boxes(0, end, 0); !checked) return checked;
    return walk.check_edits();
}

}  // namespace touchable
