#include "engine/base/number_words.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace touchable {

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

std::optional<double> parsed_number(std::string_view text) {
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [last, failure] = std::from_chars(text.data(), end, value);
    if (failure == std::errc() && last == end && std::isfinite(value)) return value;
    return std::nullopt;
}

}  // namespace touchable
