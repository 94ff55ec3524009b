// SPDX-License-Identifier: Apache-2.0
#include "engine/base/words.hpp"

#include <algorithm>
#include <clocale>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

bool is_continuation(char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U;
}

constexpr char32_t no_character = 0x110000;
struct Character {
    std::size_t bytes = 1;
    char32_t code = no_character;
};

/// The character that `text` begins with; a byte and no_character if it is no UTF-8.
Character first_character(std::string_view text) {
    constexpr std::array<char32_t, 5> least{0, 0, 0x80, 0x800, 0x10000};
    const auto lead = static_cast<unsigned char>(text[0]);
    if (lead < 0x80) return {1, lead};
    const std::size_t bytes = lead < 0xC0 ? 0 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : lead < 0xF8 ? 4 : 0;
    char32_t code = lead & (0x7FU >> bytes);
    for (std::size_t k = 1; k < bytes; ++k) {
        if (k >= text.size() || !is_continuation(text[k])) return {};
        code = code << 6U | (static_cast<unsigned char>(text[k]) & 0x3FU);
    }
    const bool is_surrogate = code >= 0xD800 && code < 0xE000;
    if (bytes == 0 || code < least[bytes] || code >= no_character || is_surrogate) return {};
    return {bytes, code};
}

/// Whether a terminal acts on the character, or turns the direction of others by it: control characters,
/// marks, embeddings, overrides and isolates of direction, separators of lines; and bytes that are no UTF-8.
bool is_control(char32_t code) {
    return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x61C || code == 0x200E ||
           code == 0x200F || (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069) ||
           code == no_character;
}

/// A control character as JSON could have it, except \xff for a byte.
std::string escaped(Character control, char byte) {
    if (control.code == '\n') return "\\n";
    if (control.code == '\r') return "\\r";
    if (control.code == '\t') return "\\t";
    if (control.bytes == 1) return formatted("\\x%02x", static_cast<unsigned char>(byte));
    return formatted("\\u%04x", static_cast<unsigned>(control.code));
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

/// Allowed values of a key, in words: "0.001 to 2 m/s".
std::string key_takes(const KeyedValues::Key& key) {
    if (key.kind == KeyedValues::Key::Kind::words) return std::string(key.unit);
    std::string text = key.kind == KeyedValues::Key::Kind::whole ? "a whole number, " : "";
    text += exact_number(key.least) + " to " + exact_number(key.greatest);
    if (!key.unit.empty()) text.append(" ").append(key.unit);
    return text;
}

std::string list_keys(std::span<const KeyedValues::Key> keys) {
    const auto in_words = [](const auto& key) { return std::string(key.name) + " (" + key_takes(key) + ")"; };
    return listed(keys, in_words);
}

Error option_refusal(std::string_view of, const std::string& what) {
    return usage_error(std::string(of).append(": ").append(what));
}

}  // namespace

std::string failure_words(int failure) {
    return std::generic_category().message(failure);
}

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

std::string with_dashes(std::string_view name) {
    std::string typed(name);
    std::ranges::replace(typed, '_', '-');
    return typed;
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

std::string_view cut_part(std::string_view& text, char end) {
    const std::string_view part = text.substr(0, text.find(end));
    text.remove_prefix(std::min(part.size() + 1, text.size()));
    return part;
}

std::optional<double> parsed_real(std::string_view text) {
    // What strtod reads beyond a plain number: blanks and a plus before it, hexadecimal digits.
    const std::string_view digits = text.substr(text.starts_with('-') ? 1 : 0);
    if (digits.empty() || digits.front() <= ' ' || digits.front() == '+' || digits.front() == '-' ||
        digits.find_first_of("xX") != std::string_view::npos)
        return {};
    static const locale_t with_points = newlocale(LC_ALL_MASK, "C", nullptr);
    const std::string ended(text);
    char* end = nullptr;
    const double value = strtod_l(ended.c_str(), &end, with_points);
    if (end != ended.c_str() + ended.size()) return {};
    const bool is_word = digits.front() > '9',
               is_zero = digits.find_first_of("123456789") >= digits.find_first_of("eE");
    const bool is_lost = !is_word && (std::isinf(value) || (value == 0 && !is_zero));
    return is_lost ? std::nullopt : std::optional(value);
}

std::optional<double> parsed_number(std::string_view text) {
    const auto value = parsed_as<double>(text);
    return value && std::isfinite(*value) ? value : std::nullopt;
}

std::string printable(std::string_view foreign, std::size_t most, std::string_view kept) {
    std::string text;
    while (!foreign.empty()) {
        const Character first = first_character(foreign);
        const bool is_shown = !is_control(first.code) || kept.find(foreign[0]) != std::string_view::npos;
        const std::string shown =
            is_shown ? std::string(foreign.substr(0, first.bytes)) : escaped(first, foreign[0]);
        if (shown.size() > most - text.size()) return text + "...";
        text += shown;
        foreign.remove_prefix(first.bytes);
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
    const bool has_control = one_line(file) != file;
    std::string inside = file.starts_with('-') ? "./" : "";
    if (!file.empty() && std::ranges::all_of(file, is_plain) && !has_control) return inside.append(file);
    // Only $'...' can express a control character.
    for (const char c : file) {
        if (has_control && (c == '\\' || c == '\''))
            inside.append({'\\', c});
        else if (c == '\'')
            inside += "'\\''";
        else
            inside += has_control && (c < ' ' || c > '~') ? escaped(first_character({&c, 1}), c)
                                                          : std::string(1, c);
    }
    return (has_control ? "$'" : "'") + inside + '\'';
}

std::string nearest_word(std::string_view typed, std::span<const std::string> words) {
    constexpr std::size_t most_letters = 3, longest = 64;
    std::string nearest;
    const std::size_t count = typed.size() - std::min(typed.find_first_not_of('-'), typed.size());
    std::size_t least = count < 3 ? 1 : std::min(most_letters, (count + 1) / 3) + 1;
    const std::string small = small_letters(std::string(typed.substr(0, longest)));
    for (const std::string& word : words)
        if (const std::size_t letters = letters_between(small, small_letters(word)); letters < least) {
            least = letters;
            nearest = word;
        }
    return nearest;
}

Result<KeyedValues> KeyedValues::parse(std::string_view of, std::string_view text,
                                       std::span<const Key> keys) {
    KeyedValues values;
    values.keys_ = keys;
    const bool has_end = !text.ends_with(',');
    while (!text.empty()) {
        TRY_ASSIGN(auto next, values.entry(of, cut_part(text, ',')));
        values.entries_.push_back(std::move(next));
    }
    if (!has_end) return option_refusal(of, "nothing follows the last comma; expected key=value");
    return values;
}

Result<KeyedValues::Entry> KeyedValues::entry(std::string_view of, std::string_view item) const {
    const std::size_t equals = item.find('=');
    if (equals == std::string_view::npos)
        return option_refusal(
            of, std::string("'").append(item).append("' is not key=value; keys are ") + list_keys(keys_));
    const std::string name(item.substr(0, equals));
    const std::string value(item.substr(equals + 1));
    const Key* const key = named_in(keys_, name, &Key::name);
    if (!key) return option_refusal(of, "unknown key '" + name + "'; keys are " + list_keys(keys_));
    if (given(name)) return option_refusal(of, name + " is given twice; give it once");
    if (key->kind == Key::Kind::words) {
        if (value.empty()) return option_refusal(of, name + " is empty; it takes " + key_takes(*key));
        return Entry{key, 0, value};
    }
    const auto number = parsed_as<double>(value);
    const bool inside = number && *number >= key->least && *number <= key->greatest;  // NaN is outside
    if (!inside || (key->kind == Key::Kind::whole && std::floor(*number) != *number))
        return option_refusal(of,
                              name + "=" + value + " is not allowed; " + name + " takes " + key_takes(*key));
    return Entry{key, *number, {}};
}

double KeyedValues::number(std::string_view name) const {
    const Entry* const entry = find(name);
    return entry ? entry->number : named_in(keys_, name, &Key::name)->standard;
}

}  // namespace touchable
