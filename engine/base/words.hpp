// SPDX-License-Identifier: Apache-2.0
#pragma once

// Words for messages and reports, and numbers in them.
//
// formatted is printf into a string. exact_number writes the fewest digits that are read as the same number,
// for files; short_number and trimmed_number are for people; decimal_of is the decimal number that a float
// came from; counted puts a number before a noun, size_text an x between two; parsed_number and parsed_as
// read a text that is a number and nothing else. small_letters and trimmed prepare a text for comparison,
// cut_part and cut_line take it apart. printable, in_quotes and shell_word make text from outside safe to
// show: on one line, without control characters, and, except shell_word, cut if it is too long. nearest_word
// finds the word that a mistyped one may have meant; listed joins several names, and named_in finds what has
// one. KeyedValues reads the key=value pairs of a description.
//
// Threads: any; pure functions, independent of the locale. One thread uses a KeyedValues.

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// The element of that name; null: none. `name_of`: its member, or a function.
template <class Range, class Name, class Of>
auto* named_in(Range& range, const Name& name, Of name_of) {
    const auto found = std::ranges::find(range, name, name_of);
    return found == std::ranges::end(range) ? nullptr : &*found;
}

/// What a call of the system says by this errno.
std::string failure_words(int failure);

/// Numbers and words as printf writes them.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...);

/// Returns the fewest digits that are read as the same number; `format` is passed to std::to_chars, if given.
std::string exact_number(auto number, auto... format) {
    std::array<char, 64> digits{};
    return {digits.data(),
            std::to_chars(digits.data(), digits.data() + digits.size(), number, format...).ptr};
}

/// At most six decimals, without trailing zeros.
std::string trimmed_number(double number);

/// The shortest decimal number that is stored as this float: 0.001, not 0.0010000000475.
double decimal_of(float value);

/// A finite number for a person to read: `count` significant digits, but all digits of a large number:
/// 1235000, not 1.235e+06. 0 has no sign.
std::string short_number(double number, int count = 4);

/// A setting's name as it is typed: fill-holes for fill_holes.
std::string with_dashes(std::string_view name);

/// A to Z become a to z.
std::string small_letters(std::string text);
/// Removes these letters from both ends.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t\r");

/// Takes the part before the first `end` off a text, and that letter; all of it if there is none.
std::string_view cut_part(std::string_view& text, char end);
/// Takes the first line off a text; returns it without its end.
inline std::string_view cut_line(std::string_view& text) {
    return cut_part(text, '\n');
}

/// "1 tick", "2 ticks"; "1 page is", "2 pages are".
inline std::string counted(std::int64_t count, const std::string& one, const std::string& several = "") {
    return std::to_string(count) + ' ' + (count == 1 ? one : several.empty() ? one + 's' : several);
}

/// A picture's size: "640x480".
std::string size_text(auto width, auto height) {
    return std::to_string(width) + 'x' + std::to_string(height);
}

inline bool is_digit(char c) {
    return c >= '0' && c <= '9';
}
/// Whether a text is digits and nothing else, at least one.
inline bool is_digits(std::string_view text) {
    return !text.empty() && std::ranges::all_of(text, is_digit);
}

/// As parsed_as<double>, which is this: C++ libraries for WebAssembly have no from_chars of reals.
std::optional<double> parsed_real(std::string_view text);
/// The number of this type that the whole text is, also inf and nan; nullopt: it is none, or out of range.
template <class Number>
std::optional<Number> parsed_as(std::string_view text, auto... base) {
    if constexpr (std::is_same_v<Number, double>) {
        return parsed_real(text);
    } else {
        Number value{};
        const char* const end = text.data() + text.size();
        const auto [last, failure] = std::from_chars(text.data(), end, value, base...);
        return failure == std::errc() && last == end ? std::optional(value) : std::nullopt;
    }
}
/// The finite number that the whole text is; nullopt: it is none.
std::optional<double> parsed_number(std::string_view text);

/// Text from outside as a message quotes it: on one line; control characters, those that turn the direction
/// of text, and bytes that are no UTF-8 escaped (\n, \x1b, \u202e), except those in `kept`; cut after `most`
/// bytes, then marked with "...".
std::string printable(std::string_view foreign, std::size_t most = 80, std::string_view kept = {});
/// The same, never cut.
inline std::string one_line(std::string_view foreign) {
    return printable(foreign, std::string_view::npos);
}
/// The same between double quotes.
std::string in_quotes(std::string_view foreign);
/// A file's name for a command in a message: a shell reads it as one whole word, and the command does not
/// take it for an option.
std::string shell_word(std::string_view file);

/// Joins what `name` returns for each element, in order: "wood, metal, glass".
template <class All, class Name = std::identity>
std::string listed(const All& all, Name name = {}, std::string_view between = ", ") {
    std::string list;
    for (const auto& each : all)
        list.append(list.empty() ? std::string_view() : between).append(std::invoke(name, each));
    return list;
}

/// The word that a person who typed `typed` may have meant: the fewest letters inserted, left out or changed
/// (Levenshtein's distance; case is no difference), at most three and a third of those typed. Empty: none.
std::string nearest_word(std::string_view typed, std::span<const std::string> words);

/// The key=value pairs of a description, as of a hand, a device or a camera, checked against the keys that it
/// understands.
class KeyedValues {
public:
    /// One key that is understood. Numbers have a range and a default; words (names of columns) do not.
    struct Key {
        enum class Kind { number, whole, words };
        std::string_view name;
        std::string_view unit;
        double least = 0;
        double greatest = 0;
        double standard = 0;
        Kind kind = Kind::number;
    };

    /// `text` is "key=value,key=value" or empty; `keys` must outlive the options. Refuses (ErrorKind::usage)
    /// an unknown key, a key given twice, a value that is no number or out of range; names the legal ones and
    /// their owner `of`, such as "hand 'wander'".
    static Result<KeyedValues> parse(std::string_view of, std::string_view text, std::span<const Key> keys);

    /// Splits "NAME[:key=value,...]" at its first ':'.
    static std::pair<std::string_view, std::string_view> name_and_pairs(std::string_view description) {
        const std::string_view name = cut_part(description, ':');
        return {name, description};
    }
    /// Splits "FILE[:key=value,...]"; FILE may contain ':': the pairs begin after the last ':' that has a '='
    /// behind it.
    static std::pair<std::string_view, std::string_view> file_and_pairs(std::string_view description) {
        const std::size_t equals = description.rfind('=');
        const std::size_t colon = equals == description.npos ? equals : description.rfind(':', equals);
        if (colon == description.npos) return {description, {}};
        return {description.substr(0, colon), description.substr(colon + 1)};
    }

    bool given(std::string_view name) const { return find(name) != nullptr; }
    double number(std::string_view name) const;  ///< as given, or the key's default
    /// As given, or empty.
    std::string words(std::string_view name) const {
        const Entry* entry = find(name);
        return entry ? entry->words : std::string();
    }

private:
    struct Entry {
        const Key* key;
        double number;
        std::string words;
    };
    Result<Entry> entry(std::string_view of, std::string_view item) const;
    const Entry* find(std::string_view name) const {
        return named_in(entries_, name, [](const Entry& entry) { return entry.key->name; });
    }

    std::span<const Key> keys_;
    std::vector<Entry> entries_;
};

}  // namespace touchable
