#include "engine/formats/heif_properties.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>

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

/// Bits of an H.265 unit, without the bytes that keep start codes out of it; 0 after the last.
class UnitBits {
public:
    explicit UnitBits(std::string_view unit) {
        for (const char byte : unit) {
            const bool is_inserted = byte == 3 && bytes_.size() >= 2 && zeros_ >= 2;
            zeros_ = byte == 0 ? zeros_ + 1 : 0;
            if (!is_inserted) bytes_ += byte;
        }
    }
    void skip(std::size_t count) { at_ += count; }
    std::uint32_t number(int count) {
        std::uint32_t value = 0;
        for (; count > 0; --count, ++at_) {
            const unsigned byte = at_ / 8 < bytes_.size() ? static_cast<unsigned char>(bytes_[at_ / 8]) : 0U;
            value = value << 1 | (byte >> (7 - at_ % 8) & 1U);
        }
        return value;
    }
    /// Exp-Golomb.
    std::uint32_t exp_golomb() {
        int zeros = 0;
        while (zeros < 32 && number(1) == 0) ++zeros;
        return zeros > 31 ? ~0U : (1U << zeros) - 1 + number(zeros);
    }

private:
    std::string bytes_;
    int zeros_ = 0;
    std::size_t at_ = 0;
};

/// Of a sequence parameter set (H.265, 7.3.2.2).
CodedSize size_of_sequence(std::string_view unit) {
    constexpr std::size_t unit_header = 16, profile = 88, level = 8;  // bits
    UnitBits bits(unit);
    bits.skip(unit_header + 4);
    const std::uint32_t layers = bits.number(3);  // above the first
    bits.skip(1 + profile + level);
    std::size_t of_layers = 0;
    for (std::uint32_t k = 0; k < layers; ++k) {
        if (bits.number(1) != 0) of_layers += profile;
        if (bits.number(1) != 0) of_layers += level;
    }
    if (layers > 0) bits.skip(2 * (std::size_t{8} - layers));
    bits.skip(of_layers);
    bits.exp_golomb();                         // its number
    if (bits.exp_golomb() == 3) bits.skip(1);  // 4:4:4, whose planes may be apart
    CodedSize size;
    size.width = bits.exp_golomb();
    size.height = bits.exp_golomb();
    return size;
}

}  // namespace

/// By their names, not by the boxes around them: libheif reads boxes whose lengths are wrong as well.
std::vector<CodedSize> read_heif_coded_sizes(std::string_view file) {
    constexpr std::string_view name = "hvcC", version = "\x01";
    constexpr std::size_t most_boxes = 4096, most_bytes = 4096, fixed_bytes = 22;
    constexpr std::uint64_t sequence_unit = 33;
    std::vector<CodedSize> sizes;
    std::size_t boxes = 0;
    for (auto at = file.find(name); at < file.size() && boxes < most_boxes; at = file.find(name, at + 1)) {
        const std::string_view content = file.substr(at + name.size(), most_bytes);
        if (!content.starts_with(version)) continue;
        ++boxes;
        HeifBytes bytes(content);
        bytes.take(fixed_bytes);
        for (auto kinds = bytes.number(1); kinds > 0 && !bytes.at_end(); --kinds) {
            const std::uint64_t kind = bytes.number(1) & 63U;
            for (auto units = bytes.number(2); units > 0 && !bytes.at_end(); --units) {
                const std::string_view unit = bytes.take(static_cast<std::size_t>(bytes.number(2)));
                if (kind == sequence_unit) sizes.push_back(size_of_sequence(unit));
            }
        }
    }
    return sizes;
}

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

/// By their names, in what holds them by its length: the data of pictures may have such names by chance.
/// Where a length is none, to the end.
HeifParts read_heif_parts(std::string_view file) {
    constexpr std::size_t name_bytes = 4, most_parts = 1 << 15;
    HeifParts parts;
    std::size_t end_of_kinds = 0, end_of_references = 0, id_bytes = 2, found = 0;
    const auto end_of = [&](std::size_t at) {
        const std::size_t begin = at - name_bytes, left = file.size() - begin;
        const auto length = HeifBytes(file.substr(begin, name_bytes)).number(name_bytes);
        return begin + (length > 2 * name_bytes && length <= left ? static_cast<std::size_t>(length) : left);
    };
    for (std::size_t at = name_bytes; at + name_bytes <= file.size() && found < most_parts; ++at) {
        const std::string_view name = file.substr(at, name_bytes);
        if (name == "iinf") {
            end_of_kinds = std::max(end_of_kinds, end_of(at));
        } else if (name == "iden" || name == "iovl") {
            parts.has_layers = parts.has_layers || at < end_of_kinds;
        } else if (name == "iref") {
            end_of_references = std::max(end_of_references, end_of(at));
            id_bytes = at + name_bytes < file.size() && file[at + name_bytes] != 0 ? 4 : 2;
        } else if (name == "dimg" && at < end_of_references) {
            HeifBytes bytes(file.substr(at + name_bytes));
            auto& made_of = parts.tiles[static_cast<std::uint32_t>(bytes.number(id_bytes))];
            ++found;
            for (auto count = bytes.number(2); count > 0 && !bytes.at_end() && found < most_parts;
                 --count, ++found)
                made_of.push_back(static_cast<std::uint32_t>(bytes.number(id_bytes)));
        }
    }
    return parts;
}

}  // namespace touchable
