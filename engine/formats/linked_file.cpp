#include "engine/formats/linked_file.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <system_error>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/picture/base64.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {
namespace {

/// "http" of "http://host/a.png"; a drive's letter is one as well.
std::string scheme_of(std::string_view url) {
    const std::size_t colon = url.find(':');
    if (colon == std::string_view::npos ||
        url.substr(0, colon).find_first_of("/\\?#") != std::string_view::npos)
        return "";
    std::string scheme(url.substr(0, colon));
    std::transform(scheme.begin(), scheme.end(), scheme.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return scheme;
}

/// "my map.png" of "my%20map.png".
std::string without_percents(std::string_view url) {
    std::string text;
    for (std::size_t k = 0; k < url.size(); ++k) {
        unsigned char byte = 0;
        const char* const digits = url.data() + k + 1;
        const bool is_coded = url[k] == '%' && k + 2 < url.size() &&
                              std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2;
        text += is_coded ? static_cast<char>(byte) : url[k];
        if (is_coded) k += 2;
    }
    return text;
}

Result<LinkedFile> data_of(std::string_view url, const std::filesystem::path& holder) {
    const std::size_t comma = url.find(',');
    const bool is_base64 = comma != std::string_view::npos && url.substr(0, comma).ends_with(";base64");
    auto bytes = is_base64 ? decode_base64(url.substr(comma + 1), Base64Padding::optional) : std::nullopt;
    if (!bytes)
        return input_error(holder.string() + ": " + in_quotes(url.substr(0, 40)) +
                           " is damaged: must be data:TYPE;base64, and base64");
    return LinkedFile{{}, std::make_shared<const std::string>(std::move(*bytes)), holder.string()};
}

}  // namespace

bool is_local_link(std::string_view url) {
    const std::string scheme = scheme_of(url);
    return !url.empty() && !url.starts_with("//") && (scheme.empty() || scheme == "file" || scheme == "data");
}

Result<LinkedFile> follow_link(std::string_view url, const std::filesystem::path& holder) {
    const std::string scheme = scheme_of(url);
    if (scheme == "data") return data_of(url, holder);
    if (!is_local_link(url))
        return input_error(holder.string() + ": names " + in_quotes(url) +
                           ": must be a file here, its name relative to that file");
    if (scheme == "file") url.remove_prefix(url.find(':') + 1);
    if (scheme == "file" && url.starts_with("//")) url.remove_prefix(2);
    const auto place = [&](std::string_view name) { return holder.parent_path() / std::string(name); };
    std::error_code ignored;
    const std::string plain = without_percents(url);
    constexpr std::size_t longest = 1000;
    if (plain.size() > longest ||
        std::any_of(plain.begin(), plain.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
        return input_error(holder.string() + ": names " + in_quotes(url) +
                           ": must be the name of a file, at most 1000 letters and no control characters");
    const auto file = std::filesystem::exists(place(url), ignored) ? place(url) : place(plain);
    return LinkedFile{file, nullptr, file.string()};
}

Result<std::shared_ptr<const std::string>> bytes_of(const LinkedFile& link) {
    if (link.bytes) return link.bytes;
    TRY_ASSIGN(auto bytes, read_picture_bytes(link.file));
    return std::make_shared<const std::string>(std::move(bytes));
}

}  // namespace touchable
