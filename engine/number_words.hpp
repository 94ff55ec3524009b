#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

namespace touchable {

/// A number for a person to read: four digits that count.
inline std::string short_number(double number) {
    std::array<char, 32> digits{};
    const auto end =
        std::to_chars(digits.data(), digits.data() + digits.size(), number, std::chars_format::general, 4);
    return {digits.data(), end.ptr};
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
