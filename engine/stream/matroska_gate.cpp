#include "engine/stream/matroska_gate.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <span>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

// Identifiers of EBML and Matroska, with their length markers.
constexpr std::uint64_t ebml_id = 0x1A45DFA3, segment_id = 0x18538067, cluster_id = 0x1F43B675,
                        timecode_id = 0xE7, simple_block_id = 0xA3, block_group_id = 0xA0, block_id = 0xA1,
                        track_id = 0xAE;
/// What a header may have, the most bytes of each, and the most elements directly in it.
struct HeaderPart {
    std::uint64_t id, most_bytes;
    int most_elements;
};
constexpr std::array<HeaderPart, 4> header_parts{HeaderPart{0x1549A966, 4096, 64},       // of the segment
                                                 HeaderPart{0x1654AE6B, 1 << 20, 20},    // tracks
                                                 HeaderPart{0x1254C367, 1 << 18, 1024},  // tags
                                                 HeaderPart{0x1941A469, 16 << 20, 16}};  // attachments
constexpr std::uint64_t most_of_all = 16 << 20, most_of_ebml = 4096, most_of_a_block = 64 << 20,
                        most_beside_a_block = 4096;
constexpr std::array<std::uint8_t, 12> open_segment{0x18, 0x53, 0x80, 0x67, 0x01, 0xFF,
                                                    0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
constexpr std::array<std::uint8_t, 12> open_cluster{0x1F, 0x43, 0xB6, 0x75, 0x01, 0xFF,
                                                    0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
constexpr std::size_t longest_head = 12, longest_cluster_head = longest_head + 1;

/// Its time, after a checksum.
constexpr bool may_begin_a_cluster(std::uint8_t id) {
    return id == timecode_id || id == 0xBF;
}

struct ReadHead {
    std::uint64_t id = 0, size = 0;
    std::size_t length = 0;
    bool is_open = false;
};

/// Of an element; nothing where there is none, or not all of it.
std::optional<ReadHead> read_head(std::span<const std::uint8_t> bytes) {
    if (bytes.empty()) return std::nullopt;
    const auto id_bytes = static_cast<std::size_t>(std::countl_zero(bytes[0])) + 1;
    if (id_bytes > 4 || bytes.size() <= id_bytes) return std::nullopt;
    const auto size_bytes = static_cast<std::size_t>(std::countl_zero(bytes[id_bytes])) + 1;
    if (size_bytes > 8 || bytes.size() < id_bytes + size_bytes) return std::nullopt;
    ReadHead head;
    for (std::size_t k = 0; k < id_bytes; ++k) head.id = head.id << 8U | bytes[k];
    head.size = bytes[id_bytes] & (0xFFU >> size_bytes);
    for (std::size_t k = 1; k < size_bytes; ++k) head.size = head.size << 8U | bytes[id_bytes + k];
    head.is_open = head.size == (std::uint64_t{1} << (7 * size_bytes)) - 1;
    head.length = id_bytes + size_bytes;
    return head;
}

/// What is in an element; false where that is not elements, one behind the other, to its end.
template <class Take>
bool walk(std::span<const std::uint8_t> content, const Take& take) {
    while (!content.empty()) {
        const auto head = read_head(content);
        if (!head || head->is_open || head->size > content.size() - head->length) return false;
        if (!take(*head)) return false;
        content = content.subspan(head->length + static_cast<std::size_t>(head->size));
    }
    return true;
}

/// A block, and little beside it.
bool is_block_group(std::span<const std::uint8_t> content) {
    std::uint64_t blocks = 0, beside = 0;
    const bool is_whole = walk(content, [&](const ReadHead& head) {
        if (head.id == block_id)
            ++blocks;
        else
            beside += head.length + head.size;
        return true;
    });
    return is_whole && blocks == 1 && beside <= most_beside_a_block;
}

}  // namespace

Result<std::size_t> MatroskaGate::read(std::uint8_t* to, std::size_t count) {
    while (given_ == out_.size()) {
        out_.clear();
        given_ = 0;
        TRY_ASSIGN(const auto more, step());
        if (!more) return std::size_t{0};
    }
    const std::size_t some = std::min(count, out_.size() - given_);
    std::memcpy(to, out_.data() + given_, some);
    given_ += some;
    return some;
}

/// Whether so many bytes are there from `at_` on; false at the end.
Result<bool> MatroskaGate::fill(std::size_t bytes) {
    constexpr std::size_t at_once = 1 << 16;
    while (there() < bytes && !has_ended_) {
        if (at_ > longest_cluster_head && at_ >= in_.size() / 2) {
            const std::size_t past = at_ - longest_cluster_head;
            in_.erase(in_.begin(), in_.begin() + static_cast<std::ptrdiff_t>(past));
            at_ -= past;
            cluster_at_ -= std::min(cluster_at_, past);
        }
        const std::size_t before = in_.size();
        in_.resize(before + at_once);
        const auto got = source_->read(in_.data() + before, at_once);
        in_.resize(before + (got ? *got : 0));
        if (!got) return got.error();
        has_ended_ = *got == 0;
    }
    return there() >= bytes;
}

void MatroskaGate::give(std::size_t bytes) {
    const auto from = in_.begin() + static_cast<std::ptrdiff_t>(at_);
    out_.insert(out_.end(), from, from + static_cast<std::ptrdiff_t>(bytes));
    at_ += bytes;
}

/// Where nothing can be made of what is there: one without an identifier.
Result<std::optional<MatroskaGate::Head>> MatroskaGate::head() {
    for (std::size_t wanted = 2;; ++wanted) {
        TRY_ASSIGN(const auto filled, fill(wanted));
        if (!filled) return std::optional<Head>();
        const auto read = read_head(std::span(in_).subspan(at_, std::min(there(), longest_head)));
        if (read) return std::optional(Head{read->id, read->size, read->length, read->is_open});
        if (wanted >= longest_head) return std::optional(Head{});
    }
}

/// False at the end.
Result<bool> MatroskaGate::step() {
    TRY_ASSIGN(const auto read, head());
    if (!read) return false;
    const Head& found = *read;
    if (place_ == Place::before) return pass_beginning(found);
    if (found.id == cluster_id) return begin_cluster(found);
    if (place_ == Place::segment) return pass_header(found);
    return pass_block(found);
}

Result<bool> MatroskaGate::pass_beginning(const Head& head) {
    const bool is_ebml = head.id == ebml_id && head.size <= most_of_ebml;
    const bool is_segment = head.id == segment_id && header_bytes_ > 0;
    if (!is_ebml && !is_segment)
        return input_error("sends no stream that is known: neither Matroska nor MPEG-TS");
    if (is_segment) {
        out_.insert(out_.end(), open_segment.begin(), open_segment.end());
        at_ += head.length;
        place_ = Place::segment;
        return true;
    }
    const std::size_t whole = head.length + static_cast<std::size_t>(head.size);
    const auto filled = fill(whole);
    if (!filled || !*filled) return filled;
    header_bytes_ += whole;
    give(whole);
    return true;
}

/// Each part of the header once.
Result<bool> MatroskaGate::pass_header(const Head& head) {
    header_bytes_ += head.length + head.size;
    if (head.id == 0 || head.is_open || header_bytes_ > most_of_all)
        return input_error("sends a header that is damaged, or larger than 16 MiB");
    const auto part = std::ranges::find(header_parts, head.id, &HeaderPart::id);
    if (part == header_parts.end()) return leave_out(head);
    auto& seen = seen_[static_cast<std::size_t>(part - header_parts.begin())];
    if (seen) return leave_out(head);
    seen = true;
    if (head.size > part->most_bytes) return input_error("sends a header with a part that is too large");
    const std::size_t size = static_cast<std::size_t>(head.size);
    const auto filled = fill(head.length + size);
    if (!filled || !*filled) return filled;
    int elements = 0, tracks = 0;
    const bool is_right = walk(std::span(in_).subspan(at_ + head.length, size), [&](const ReadHead& inner) {
        tracks += inner.id == track_id ? 1 : 0;
        return ++elements <= part->most_elements;
    });
    constexpr int most_tracks_there = 16;
    if (tracks > most_tracks_there) return input_error("sends more than 16 tracks");
    if (!is_right) return input_error("sends a header that is damaged, or has too many parts");
    give(head.length + size);
    return true;
}

Result<bool> MatroskaGate::begin_cluster(const Head& head) {
    place_ = Place::clusters;
    out_.insert(out_.end(), open_cluster.begin(), open_cluster.end());
    at_ += head.length;
    cluster_at_ = at_;
    return true;
}

/// Without keeping it.
Result<bool> MatroskaGate::leave_out(const Head& head) {
    std::uint64_t left = head.length + head.size;
    while (left > 0) {
        const auto filled = fill(1);
        if (!filled || !*filled) return filled;
        const auto some = static_cast<std::size_t>(std::min<std::uint64_t>(left, there()));
        at_ += some;
        left -= some;
    }
    return true;
}

/// A cluster's head, and what it begins with: by chance once in 10^11 bytes.
std::optional<std::size_t> MatroskaGate::cluster_in(std::size_t from, std::size_t end) const {
    const std::uint8_t* const base = in_.data() + at_;
    for (std::size_t at = from; at + 5 < end; ++at) {
        const void* const found = std::memchr(base + at, open_cluster[0], end - at - 5);
        if (!found) return std::nullopt;
        at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - base);
        if (std::memcmp(base + at, open_cluster.data(), 4) != 0) continue;
        const auto head = read_head(std::span(in_).subspan(at_ + at, end - at));
        if (head && at + head->length < end && may_begin_a_cluster(base[at + head->length])) return at;
    }
    return std::nullopt;
}

/// Something is damaged or missing.
Result<bool> MatroskaGate::find_cluster(std::size_t from) {
    while (true) {
        if (const auto found = cluster_in(from, there())) {
            at_ += *found;
            return true;
        }
        const std::size_t done = there() - std::min(there(), longest_cluster_head);
        at_ += std::max(done, std::min(from, there()));
        from = 0;
        const auto filled = fill(there() + 1);
        if (!filled || !*filled) return filled;
    }
}

/// Also where the block before was too long, and has taken a part of the cluster's head.
Result<bool> MatroskaGate::look_back() {
    const std::size_t here = at_;
    at_ = std::max(cluster_at_, at_ - std::min(at_, longest_cluster_head));
    return find_cluster(here == at_ ? 1 : 0);
}

Result<bool> MatroskaGate::pass_block(const Head& head) {
    const bool is_block = head.id == simple_block_id || head.id == block_group_id || head.id == timecode_id;
    const bool is_known = is_block || head.id == 0xA7 || head.id == 0xAB || head.id == 0xBF ||
                          head.id == 0xEC || head.id == 0x5854 || head.id > 0xFFFFFF;
    if (!is_known || head.is_open || head.size > most_of_a_block) return look_back();
    const std::size_t size = static_cast<std::size_t>(head.size), whole = head.length + size;
    for (std::size_t looked = head.length; looked < whole;) {
        const auto filled = fill(std::min(whole, there() + 1));
        if (!filled) return filled;
        const std::size_t end = std::min(whole, there());
        if (cluster_in(looked, end)) return find_cluster(looked);
        looked = std::max(looked, end - std::min(end, longest_cluster_head));
        if (end == whole) break;
        if (!*filled) return false;
    }
    const auto filled = fill(whole);
    if (!filled || !*filled) return filled;
    const auto content = std::span<const std::uint8_t>(in_).subspan(at_ + head.length, size);
    const bool is_right = is_block && (head.id != block_group_id || is_block_group(content)) &&
                          (head.id != timecode_id || size <= 8);
    if (is_right)
        give(whole);
    else
        at_ += whole;
    return true;
}

}  // namespace touchable
