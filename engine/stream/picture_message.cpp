#include "engine/stream/picture_message.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#include "engine/base/byte_hash.hpp"

namespace touchable {
namespace {

/// No byte is zero, so that nothing in a message is ever escaped.
constexpr std::array<std::uint8_t, 16> message_uuid{0x9b, 0x3e, 0x57, 0xc1, 0x6d, 0x2a, 0x4f, 0x88,
                                                    0xa5, 0x74, 0x1c, 0xe9, 0x33, 0xd6, 0xb2, 0x4d};
constexpr std::array<std::string_view, 3> part_names{"whole", "high", "low"};
constexpr std::string_view hash_key = " xxh64=", scene_key = "touchable_scene=1 xxh64=";
constexpr std::size_t hash_digits = 16, longest_message = std::size_t{1} << 20;

std::uint64_t hash_of(std::string_view text, const PlaneView& samples) {
    ByteHash hash;
    hash.add(text.data(), text.size());
    for (int y = 0; y < samples.height; ++y)
        hash.add(samples.row(y), static_cast<std::size_t>(samples.width * samples.channels));
    return hash.value();
}

std::string hex(std::uint64_t number) {
    std::string digits(hash_digits, '0');
    for (std::size_t k = hash_digits; k-- > 0; number >>= 4) digits[k] = "0123456789abcdef"[number & 15];
    return digits;
}

std::string with_uuid(const std::string& text) {
    return std::string(message_uuid.begin(), message_uuid.end()) + text;
}

/// Takes the words of a message from its front.
class WordReader {
public:
    explicit WordReader(std::string_view text) : rest_(text) {}
    /// The value of this key, which comes next; empty where it does not.
    std::string_view value(std::string_view key) {
        if (!rest_.starts_with(key) || !rest_.substr(key.size()).starts_with('=')) return "";
        rest_.remove_prefix(key.size() + 1);
        const std::size_t end = std::min(rest_.find(' '), rest_.size());
        const std::string_view value = rest_.substr(0, end);
        rest_.remove_prefix(std::min(end + 1, rest_.size()));
        return value;
    }
    bool at_end() const { return rest_.empty(); }

private:
    std::string_view rest_;
};

template <class Number>
bool read_number(std::string_view digits, Number& number) {
    const char* const end = digits.data() + digits.size();
    const auto [last, failure] = std::from_chars(digits.data(), end, number);
    return failure == std::errc() && last == end;
}

std::optional<PlanePart> part_named(std::string_view name) {
    const auto* const found = std::ranges::find(part_names, name);
    if (found == part_names.end()) return std::nullopt;
    return static_cast<PlanePart>(found - part_names.begin());
}

std::string text_of(const PictureMessage& message) {
    return "touchable=1 role=" + std::string(role_name(message.role)) +
           " part=" + std::string(part_names[static_cast<std::size_t>(message.part)]) +
           " bits=" + std::to_string(message.bits) + " frame=" + std::to_string(message.label.frame) +
           " taken_ns=" + std::to_string(message.label.taken_ns);
}

std::optional<PictureMessage> read_message(std::string_view text) {
    WordReader words(text);
    PictureMessage message;
    if (words.value("touchable") != "1") return std::nullopt;
    const auto role = role_named(words.value("role"));
    const auto part = part_named(words.value("part"));
    if (!role || !part || !read_number(words.value("bits"), message.bits) ||
        !read_number(words.value("frame"), message.label.frame) ||
        !read_number(words.value("taken_ns"), message.label.taken_ns) || !words.at_end())
        return std::nullopt;
    message.role = *role;
    message.part = *part;
    const bool can_be = *part == PlanePart::whole
                            ? message.bits == 8
                            : message.bits >= 8 && message.bits <= 16 &&
                                  (*role == PlaneRole::depth || *role == PlaneRole::height);
    if (!can_be || message.label.frame < 0 || message.label.taken_ns < 0) return std::nullopt;
    return message;
}

}  // namespace

std::string sei_of(const PictureMessage& message, const PlaneView& samples) {
    const std::string text = text_of(message);
    const bool is_exact = message.role != PlaneRole::colour;
    return with_uuid(text + std::string(hash_key) + hex(hash_of(text, is_exact ? samples : PlaneView{})));
}

std::string sei_of_scene(std::string_view json) {
    return with_uuid(std::string(scene_key) + hex(hash_of(json, {})) + " " + std::string(json));
}

std::optional<ReadSei> read_sei(std::span<const std::uint8_t> content) {
    if (content.size() > longest_message || content.size() < message_uuid.size() ||
        !std::equal(message_uuid.begin(), message_uuid.end(), content.begin()))
        return std::nullopt;
    const std::string_view text(reinterpret_cast<const char*>(content.data()) + message_uuid.size(),
                                content.size() - message_uuid.size());
    ReadSei read;
    if (text.starts_with(scene_key)) {
        const std::size_t json_at = scene_key.size() + hash_digits + 1;
        if (text.size() < json_at || text[json_at - 1] != ' ') return std::nullopt;
        read.hash = text.substr(scene_key.size(), hash_digits);
        read.scene = text.substr(json_at);
        return hex(hash_of(*read.scene, {})) == read.hash ? std::optional(std::move(read)) : std::nullopt;
    }
    const std::size_t hash_at = text.rfind(hash_key);
    if (hash_at == std::string_view::npos) return std::nullopt;
    read.hashed = text.substr(0, hash_at);
    read.picture = read_message(read.hashed);
    read.hash = text.substr(hash_at + hash_key.size());
    return read.picture ? std::optional(std::move(read)) : std::nullopt;
}

bool is_sound(const ReadSei& sei, const PlaneView& samples) {
    const bool is_exact = sei.picture->role != PlaneRole::colour;
    return hex(hash_of(sei.hashed, is_exact ? samples : PlaneView{})) == sei.hash;
}

}  // namespace touchable
