#include "engine/import/heif_turns.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace touchable {
namespace {

/// Big-endian numbers from the front; 0 where there are no more bytes, and then `at_end`.
class HeifBytes {
public:
    explicit HeifBytes(std::string_view bytes) : rest_(bytes) {}
    bool at_end() const { return rest_.empty(); }
    std::uint64_t number(std::size_t length) {
        std::uint64_t value = 0;
        for (const char byte : take(length)) value = value << 8 | static_cast<unsigned char>(byte);
        return value;
    }
    std::string_view take(std::size_t length) {
        if (length > rest_.size()) {
            rest_ = {};
            return {};
        }
        const auto taken = rest_.substr(0, length);
        rest_.remove_prefix(length);
        return taken;
    }

private:
    friend struct HeifBox;
    std::string_view rest_;
};

struct HeifBox {
    std::string_view type, content;

    static std::optional<HeifBox> next(HeifBytes& bytes) {
        const std::size_t available = bytes.rest_.size();
        if (available < 8) return std::nullopt;
        std::uint64_t length = bytes.number(4), header = 8;
        HeifBox box;
        box.type = bytes.take(4);
        if (length == 1) {
            length = bytes.number(8);
            header = 16;
        }
        if (length == 0) length = available;  // to the end of what holds it
        if (length < header || length > available) return std::nullopt;
        box.content = bytes.take(static_cast<std::size_t>(length - header));
        return box;
    }
};

/// The first box of a type; empty where there is none.
std::string_view find_box(std::string_view within, std::string_view type) {
    HeifBytes bytes(within);
    while (const auto box = HeifBox::next(bytes))
        if (box->type == type) return box->content;
    return {};
}

std::string_view without_version(std::string_view full_box) {
    return full_box.size() < 4 ? std::string_view() : full_box.substr(4);
}

/// Of a property that turns (irot: a quarter turns to the left) or mirrors (imir); nothing for others.
std::optional<Orientation> turn_of(const HeifBox& property) {
    const int value = property.content.empty() ? 0 : property.content[0] & 3;
    constexpr int exif_of_left_turns[] = {1, 8, 3, 6};
    if (property.type == "irot") return exif_orientation(exif_of_left_turns[value]);
    if (property.type == "imir") return exif_orientation((value & 1) != 0 ? 2 : 4);
    return std::nullopt;
}

}  // namespace

std::map<std::uint32_t, Orientation> read_heif_turns(std::string_view file) {
    const std::string_view properties = find_box(without_version(find_box(file, "meta")), "iprp");
    std::vector<HeifBox> all;
    HeifBytes listed(find_box(properties, "ipco"));
    while (const auto box = HeifBox::next(listed)) all.push_back(*box);
    std::map<std::uint32_t, Orientation> turns;
    HeifBytes links(find_box(properties, "ipma"));
    const auto version = links.number(1), flags = links.number(3), items = links.number(4);
    for (std::uint64_t k = 0; k < items && !links.at_end(); ++k) {
        const auto item = static_cast<std::uint32_t>(links.number(version < 1 ? 2 : 4));
        for (auto left = links.number(1); left > 0; --left) {
            const bool is_long = (flags & 1) != 0;
            const std::uint64_t index = links.number(is_long ? 2 : 1) & (is_long ? 0x7fffU : 0x7fU);
            if (index < 1 || index > all.size()) continue;
            if (const auto turn = turn_of(all[static_cast<std::size_t>(index - 1)]))
                turns[item] = turns[item].then(*turn);
        }
    }
    return turns;
}

}  // namespace touchable
