#include "player/options/typed_numbers.hpp"

#include <cmath>
#include <cstdio>

namespace touchable {
namespace {

std::string in_digits(double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", number);
    return text;
}

/// One comma, with digits on both sides.
bool has_decimal_comma(std::string_view text) {
    const auto is_digit = [&](std::size_t k) { return k < text.size() && text[k] >= '0' && text[k] <= '9'; };
    const std::size_t comma = text.find(',');
    return comma != std::string_view::npos && comma > 0 && is_digit(comma - 1) && is_digit(comma + 1) &&
           text.find(',', comma + 1) == std::string_view::npos;
}

}  // namespace

Result<double> read_number(const std::string& option, std::string_view text, double least, double most) {
    double value = 0;
    const std::string_view unsigned_text = text.starts_with('+') ? text.substr(1) : text;
    const auto [end, failure] =
        std::from_chars(unsigned_text.data(), unsigned_text.data() + unsigned_text.size(), value);
    if (failure == std::errc() && end == text.data() + text.size() && std::isfinite(value) &&
        value >= least && value <= most)
        return value;
    std::string message = (option.empty() ? "'" : option + " '").append(text);
    message += "' will not do; right would be a number";
    const bool has_least = least != std::numeric_limits<double>::lowest(),
               has_most = most != std::numeric_limits<double>::max();
    if (has_least && has_most)
        message += ", " + in_digits(least) + " to " + in_digits(most);
    else if (has_least)
        message += ", " + in_digits(least) + " or more";
    if (has_decimal_comma(text)) message += ", with a decimal point in place of the comma";
    return usage_error(std::move(message));
}

Result<PixelSize> read_pixel_size(const std::string& option, std::string_view text, int least, int most) {
    const std::size_t cross = text.find('x');
    if (cross != std::string_view::npos) {
        const auto width = read_whole_number(option, text.substr(0, cross), least, most);
        const auto height = read_whole_number(option, text.substr(cross + 1), least, most);
        if (width.ok() && height.ok()) return PixelSize{*width, *height};
    }
    return usage_error(option + " '" + std::string(text) +
                       "' is no size; right would be WIDTHxHEIGHT in pixels, each " + std::to_string(least) +
                       " to " + std::to_string(most) + ", such as 720x480");
}

}  // namespace touchable
