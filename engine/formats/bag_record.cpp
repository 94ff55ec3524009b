#include "engine/formats/bag_record.hpp"

#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr std::uint32_t longest_header = 1 << 20;  // topics are as long as people make them

Error at_byte(std::uint64_t at, const std::string& what) {
    return input_error("is damaged: the record at byte " + std::to_string(at) + " " + what);
}

}  // namespace

std::optional<BagFields> BagFields::of(std::string bytes) {
    for (std::size_t at = 0; at < bytes.size();) {
        std::uint32_t length = 0;
        if (bytes.size() - at < sizeof length) return {};
        std::memcpy(&length, bytes.data() + at, sizeof length);
        at += sizeof length;
        if (length > bytes.size() - at) return {};
        if (bytes.find('=', at) >= at + length) return {};
        at += length;
    }
    BagFields fields;
    fields.bytes_ = std::move(bytes);
    return fields;
}

std::optional<std::string_view> BagFields::text(std::string_view name) const {
    const std::string_view all = bytes_;
    for (std::size_t at = 0; at < all.size();) {
        std::uint32_t length = 0;
        std::memcpy(&length, all.data() + at, sizeof length);
        const std::string_view field = all.substr(at + sizeof length, length);
        if (field.size() > name.size() && field[name.size()] == '=' && field.starts_with(name))
            return field.substr(name.size() + 1);
        at += sizeof length + length;
    }
    return {};
}

Result<BagRecord> read_bag_record(ByteSource& bytes, std::uint64_t at, std::uint64_t end) {
    const auto length_at = [&](std::uint64_t from) -> Result<std::uint32_t> {
        std::uint32_t length = 0;
        if (from > end || end - from < sizeof length) return at_byte(at, "is cut");
        TRY(bytes.read(from, reinterpret_cast<char*>(&length), sizeof length));
        return length;
    };
    TRY_ASSIGN(const auto header, length_at(at));
    std::uint64_t next = at + sizeof header;
    if (header > end - next || header > longest_header) return at_byte(at, "has a wrong length");
    std::string text(header, '\0');
    TRY(bytes.read(next, text.data(), text.size()));
    next += header;
    auto fields = BagFields::of(std::move(text));
    if (!fields) return at_byte(at, "has fields of wrong lengths");
    TRY_ASSIGN(const auto size, length_at(next));
    next += sizeof size;
    if (size > end - next) return at_byte(at, "is cut");
    return BagRecord{std::move(*fields), next, size};
}

}  // namespace touchable
