#include "engine/base/printable.hpp"

#include <array>

namespace touchable {
namespace {

bool is_continuation(char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U;
}

/// Control characters below space, delete, and those of U+0080 to U+009F, of which UTF-8 makes two bytes.
bool is_control(std::string_view text) {
    const auto byte = static_cast<unsigned char>(text[0]);
    if (byte < 0x20 || byte == 0x7F) return true;
    return byte == 0xC2 && text.size() > 1 && static_cast<unsigned char>(text[1]) < 0xA0;
}

std::string escaped(char control) {
    if (control == '\n') return "\\n";
    if (control == '\r') return "\\r";
    if (control == '\t') return "\\t";
    constexpr std::array digits{'0', '1', '2', '3', '4', '5', '6', '7',
                                '8', '9', 'a', 'b', 'c', 'd', 'e', 'f'};
    const auto byte = static_cast<unsigned char>(control);
    return {'\\', 'x', digits[byte >> 4U], digits[byte & 15U]};
}

}  // namespace

std::string printable(std::string_view foreign, std::size_t most) {
    std::string text;
    while (!foreign.empty()) {
        std::size_t length = 1;  // of the character, which is never cut
        while (length < 4 && length < foreign.size() && is_continuation(foreign[length])) ++length;
        std::string character(foreign.substr(0, length));
        if (is_control(foreign)) {
            length = foreign[0] == '\xC2' ? 2 : 1;
            character = escaped(foreign[0]) + (length == 2 ? escaped(foreign[1]) : "");
        }
        if (text.size() + character.size() > most) return text + "...";
        text += character;
        foreign.remove_prefix(length);
    }
    return text;
}

std::string in_quotes(std::string_view foreign) {
    return std::string("\"").append(printable(foreign)).append("\"");
}

std::string shell_word(std::string_view file) {
    constexpr std::string_view plain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./:@%+,=";
    const auto is_plain = [&](char c) {
        return plain.find(c) != std::string_view::npos || static_cast<unsigned char>(c) >= 0x80;
    };
    bool is_odd = file.empty(), has_control = false;
    std::string inside = file.starts_with('-') ? "./" : "";
    for (std::size_t n = 0; n < file.size(); ++n) {
        is_odd |= !is_plain(file[n]);
        has_control |= is_control(file.substr(n));
    }
    if (!is_odd && !has_control) return inside.append(file);
    // $'...' alone can say a control character.
    for (const char c : file) {
        if (has_control && (c == '\\' || c == '\''))
            inside.append({'\\', c});
        else if (c == '\'')
            inside += "'\\''";
        else
            inside += has_control && (is_control({&c, 1}) || static_cast<unsigned char>(c) >= 0x80)
                          ? escaped(c)
                          : std::string(1, c);
    }
    return (has_control ? "$'" : "'") + inside + '\'';
}

}  // namespace touchable
