#include "engine/base/words.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numeric>
#include <utility>
#include <vector>

namespace touchable {
namespace {

bool is_continuation(char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U;
}

/// Control characters: those below space, delete, and U+0080 to U+009F, which are two bytes in UTF-8.
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

std::size_t letters_between(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t corner = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t changed = corner + (a[i] == b[j] ? 0 : 1);
            corner = row[j + 1];
            row[j + 1] = std::min({changed, corner + 1, row[j] + 1});
        }
    }
    return row.back();
}

}  // namespace

std::string formatted(const char* format, ...) {
    std::va_list values, again;
    va_start(values, format);
    va_copy(again, values);
    std::string text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, format, values)), '\0');
    std::vsnprintf(text.data(), text.size() + 1, format, again);
    va_end(again);
    va_end(values);
    return text;
}

std::string trimmed_number(double number) {
    std::string text = std::to_string(number);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
    return text;
}

double decimal_of(float value) {
    return parsed_number(exact_number(value)).value_or(value);
}

std::string short_number(double number, int count) {
    if (number == 0) return "0";
    std::string text = exact_number(number, std::chars_format::general, count);
    return std::abs(number) > 1 && text.find('e') != std::string::npos ? formatted("%.0f", number) : text;
}

std::string small_letters(std::string text) {
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

std::string_view trimmed(std::string_view text, std::string_view blanks) {
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(blanks) + 1 - first);
}

std::optional<double> parsed_number(std::string_view text) {
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [last, failure] = std::from_chars(text.data(), end, value);
    if (failure == std::errc() && last == end && std::isfinite(value)) return value;
    return std::nullopt;
}

std::string printable(std::string_view foreign, std::size_t most) {
    std::string text;
    while (!foreign.empty()) {
        std::size_t length = 1;  // bytes of the character, which is never cut
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
    // Only $'...' can express a control character.
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

std::string nearest_word(std::string_view typed, std::span<const std::string> words) {
    constexpr std::size_t most_letters = 3, longest = 64;
    std::string nearest;
    std::size_t least = std::min(most_letters, typed.size() / 2) + 1;
    for (const std::string& word : words)
        if (const std::size_t letters = letters_between(typed.substr(0, longest), word); letters < least) {
            least = letters;
            nearest = word;
        }
    return nearest;
}

}  // namespace touchable
