#include "engine/mpeg4/boxes.hpp"

#include <algorithm>

#include "engine/printable.hpp"

namespace touchable::mpeg4 {

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
