#pragma once

#include <array>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>

namespace touchable {

/// Numbers and words as printf writes them.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...);

/// The fewest digits that are read as the same number; `format` as std::to_chars takes it, or none.
template <class Number, class... Format>
std::string exact_number(Number number, Format... format) {
    std::array<char, 64> digits{};
    return {digits.data(),
            std::to_chars(digits.data(), digits.data() + digits.size(), number, format...).ptr};
}

/// At most six decimals, without zeros at their end.
std::string trimmed_number(double number);

/// The decimal number that somebody wrote who has this float: 0.001, not 0.0010000000475.
double decimal_of(float value);

/// A finite number for a person to read: `count` digits that count, and all of a large one: 1235,
/// not 1.235e+03. 0 has no sign.
std::string short_number(double number, int count = 4);

/// A finite number, where the text is one and nothing else.
std::optional<double> parsed_number(std::string_view text);

}  // namespace touchable
