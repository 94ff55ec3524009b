#include "engine/picture/base64.hpp"

extern "C" {
#include <libavutil/base64.h>
}

#include <cstdint>

namespace touchable {

std::optional<std::string> decode_base64(std::string_view text, Base64Padding padding) {
    std::string digits(text);
    std::erase_if(digits, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; });
    const std::size_t written = digits.size();
    digits.resize(digits.find_last_not_of('=') + 1);
    const std::size_t padded = written - digits.size();
    const bool fits = padded == 0 && padding == Base64Padding::optional ? written % 4 != 1
                                                                        : written % 4 == 0 && padded <= 2;
    if (!fits) return std::nullopt;
    // FFmpeg takes a "=" or a 0 for the end wherever it stands: the bytes before it are fewer.
    std::string bytes(digits.size() * 3 / 4, '\0');
    const auto size = static_cast<int>(bytes.size());
    if (av_base64_decode(reinterpret_cast<std::uint8_t*>(bytes.data()), digits.c_str(), size) != size)
        return std::nullopt;
    return bytes;
}

}  // namespace touchable
