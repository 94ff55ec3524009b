#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

namespace touchable {

/// A finite number for a person to read: `count` digits that count, and all of a large one: 1235,
/// not 1.235e+03. 0 has no sign.
inline std::string short_number(double number, int count = 4) {
    std::array<char, 400> digits{};
    char *const first = digits.data(), *const last = first + digits.size();
    if (number == 0) return "0";
    auto end = std::to_chars(first, last, number, std::chars_format::general, count);
    if (std::abs(number) > 1 && std::find(first, end.ptr, 'e') != end.ptr)
        end = std::to_chars(first, last, number, std::chars_format::fixed, 0);
    return {first, end.ptr};
}

/// A finite number, where the text is one and nothing else.
inline std::optional<double> parsed_number(std::string_view text) {
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [last, failure] = std::from_chars(text.data(), end, value);
    if (failure == std::errc() && last == end && std::isfinite(value)) return value;
    return std::nullopt;
}

}  // namespace touchable
