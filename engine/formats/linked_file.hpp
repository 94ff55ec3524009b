#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"

namespace touchable {

/// A file that another one names by a URL, or holds.
struct LinkedFile {
    std::filesystem::path file;                ///< empty: its bytes are in the other one
    std::shared_ptr<const std::string> bytes;  ///< these
    std::string name;                          ///< for messages
    bool operator==(const LinkedFile&) const = default;
};

/// Whether a URL leads neither into the network nor to any other place that is no file.
bool is_local_link(std::string_view url);

/// What `url` means in the file `holder`: a path relative to its folder, also up and out of it; file:; or
/// data: in base64. Everything else is refused. A name with %XX is taken as it stands where such a file is
/// there, otherwise decoded.
Result<LinkedFile> follow_link(std::string_view url, const std::filesystem::path& holder);

/// Up to 257 MiB.
Result<std::shared_ptr<const std::string>> bytes_of(const LinkedFile& link);

}  // namespace touchable
