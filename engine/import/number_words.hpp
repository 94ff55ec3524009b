#pragma once

#include <array>
#include <charconv>
#include <string>

namespace touchable {

/// A number for a person to read: four digits that count.
inline std::string short_number(double number) {
    std::array<char, 32> digits{};
    const auto end =
        std::to_chars(digits.data(), digits.data() + digits.size(), number, std::chars_format::general, 4);
    return {digits.data(), end.ptr};
}

}  // namespace touchable
