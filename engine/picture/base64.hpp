#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace touchable {

enum class Base64Padding { required, optional };

/// RFC 4648, with white space between characters. Nothing where it is anything else.
std::optional<std::string> decode_base64(std::string_view text,
                                         Base64Padding padding = Base64Padding::required);

}  // namespace touchable
