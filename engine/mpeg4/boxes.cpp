#include "engine/mpeg4/boxes.hpp"

#include <algorithm>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"

namespace touchable::mpeg4 {
namespace {

constexpr std::size_t most_boxes = 1 << 16;
/// Of a movie box without its tables, and of a table that stays.
constexpr std::size_t most_head_bytes = std::size_t{16} << 20, longest_table = std::size_t{64} << 10;
constexpr int most_nested = 8;

bool is_box_of_boxes(std::string_view type) {
    constexpr std::string_view known[] = {"trak", "mdia", "minf", "stbl", "udta", "meta"};
    return std::find(std::begin(known), std::end(known), type) != std::end(known);
}

/// The boxes between two places, those too without their tables.
Result<Bytes> heads_between(ByteSource& file, std::uint64_t at, std::uint64_t end, int depth) {
    Bytes heads;
    while (at + 8 <= end) {
        TRY_ASSIGN(const auto box, box_at(file, at, end));
        if (!box) return input_error("a box at byte " + std::to_string(at) + " is longer than what it is in");
        const std::uint64_t size = box->end - box->content;
        at = box->end;
        const bool opens = size > longest_table && depth < most_nested && is_box_of_boxes(box->type);
        if (!opens && size > longest_table) continue;
        const std::uint64_t version_bytes = opens && box->type == "meta" ? 4 : 0;
        TRY_ASSIGN(auto content, bytes_at(file, box->content, opens ? version_bytes : size));
        if (opens) {
            TRY_ASSIGN(const auto inner,
                       heads_between(file, box->content + version_bytes, box->end, depth + 1));
            put_bytes(content, inner);
        }
        put_box(heads, box->type, content);
        if (heads.size() > most_head_bytes)
            return input_error("its movie box has more than 16 MiB beside its tables");
    }
    return heads;
}

}  // namespace

Result<std::vector<Box>> boxes_in(BytesView bytes) {
    std::vector<Box> boxes;
    while (!bytes.empty()) {
        // Where nothing but a few zeros is left, a writer of QuickTime has ended its list with them.
        if (bytes.size() < 8 &&
            std::all_of(bytes.begin(), bytes.end(), [](std::uint8_t b) { return b == 0; }))
            break;
        const std::uint64_t stated = number_at(bytes, 0, 4);
        const std::uint64_t head = stated == 1 ? 16 : 8;
        if (bytes.size() < head)
            return input_error("a box is cut short: " + std::to_string(bytes.size()) + " bytes are left");
        const std::uint64_t size = stated == 0 ? bytes.size() : stated == 1 ? number_at(bytes, 8, 8) : stated;
        std::string type(reinterpret_cast<const char*>(bytes.data()) + 4, 4);
        if (size < head || size > bytes.size())
            return input_error("box " + in_quotes(type) + " has " + std::to_string(size) +
                               " bytes: must be " + std::to_string(head) + " to " +
                               std::to_string(bytes.size()));
        if (boxes.size() == most_boxes) return input_error("more than 65536 boxes in one");
        boxes.push_back({std::move(type), bytes.subspan(head, size - head)});
        bytes = bytes.subspan(size);
    }
    return boxes;
}

const Box* box_named(std::span<const Box> boxes, std::string_view type) {
    const auto found =
        std::find_if(boxes.begin(), boxes.end(), [type](const Box& box) { return box.type == type; });
    return found == boxes.end() ? nullptr : &*found;
}

BytesView content_at(BytesView bytes, std::initializer_list<std::string_view> path) {
    for (const std::string_view type : path) {
        const auto boxes = boxes_in(bytes);
        const Box* const found = boxes ? box_named(*boxes, type) : nullptr;
        if (!found) return {};
        bytes = found->content;
    }
    return bytes;
}

Bytes with_content(BytesView bytes, std::span<const std::string_view> path, BytesView content) {
    Bytes made;
    const auto boxes = boxes_in(bytes);
    for (const Box& box : boxes ? *boxes : std::vector<Box>()) {
        if (box.type != path.front())
            put_box(made, box.type, box.content);
        else if (path.size() == 1)
            put_box(made, box.type, content);
        else
            put_box(made, box.type, with_content(box.content, path.subspan(1), content));
    }
    return made;
}

Result<std::optional<BoxPlace>> box_at(ByteSource& file, std::uint64_t at, std::uint64_t end) {
    const std::uint64_t left = end - at;
    TRY_ASSIGN(const auto head, bytes_at(file, at, std::min<std::uint64_t>(16, left)));
    const std::uint64_t stated = number_at(head, 0, 4), before = stated == 1 ? 16 : 8;
    const std::uint64_t size = stated == 0 ? left : stated == 1 ? number_at(head, 8, 8) : stated;
    if (left < before) return std::optional<BoxPlace>();
    std::string type(reinterpret_cast<const char*>(head.data()) + 4, 4);
    if (size < before)
        return input_error("box " + in_quotes(type) + " at byte " + std::to_string(at) + " has " +
                           std::to_string(size) + " bytes: must be " + std::to_string(before) + " at least");
    if (size > left) return std::optional<BoxPlace>();
    return std::optional(BoxPlace{std::move(type), at, at + before, at + size});
}

Result<std::optional<BoxPlace>> first_box(ByteSource& file, std::string_view type, std::uint64_t at,
                                          std::uint64_t end) {
    while (at < end) {
        auto box = box_at(file, at, end);
        if (!box || !*box || (*box)->type == type) return box;
        at = (*box)->end;
    }
    return std::optional<BoxPlace>();
}

Result<Bytes> bytes_at(ByteSource& file, std::uint64_t at, std::uint64_t count) {
    if (count > file.size() || at > file.size() - count)
        return input_error("is cut short: " + std::to_string(count) + " bytes at " + std::to_string(at) +
                           " are not there");
    Bytes bytes(count);
    TRY(file.read(at, reinterpret_cast<char*>(bytes.data()), bytes.size()));
    return bytes;
}

Result<Bytes> movie_head_of(ByteSource& file) {
    TRY_ASSIGN(const auto movie, first_box(file, "moov", 0, file.size()));
    if (!movie) return Bytes();
    return heads_between(file, movie->content, movie->end, 0);
}

std::uint64_t number_at(BytesView bytes, std::size_t at, int count) {
    std::uint64_t value = 0;
    for (int k = 0; k < count; ++k) {
        const std::size_t byte = at + static_cast<std::size_t>(k);
        value = value << 8 | (byte < bytes.size() ? bytes[byte] : 0);
    }
    return value;
}

void put_number(Bytes& to, std::uint64_t value, int count) {
    for (int k = count - 1; k >= 0; --k) to.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
}

void put_bytes(Bytes& to, BytesView bytes) {
    to.insert(to.end(), bytes.begin(), bytes.end());
}

void put_box(Bytes& to, std::string_view type, BytesView content) {
    put_number(to, 8 + content.size(), 4);
    for (const char letter : type) to.push_back(static_cast<std::uint8_t>(letter));
    put_bytes(to, content);
}

Bytes box_of(std::string_view type, BytesView content) {
    Bytes box;
    put_box(box, type, content);
    return box;
}

}  // namespace touchable::mpeg4
