#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "engine/base/result.hpp"

namespace touchable {

/// Whether nobody waits any more for what is done. Asked by the thread that waits.
using WaitIsOver = std::function<bool()>;

/// Bytes of a file, from the first on and before the last.
struct ByteRange {
    std::int64_t begin = 0;
    std::optional<std::int64_t> end;
};

/// All that a web server has at a place (hls_playlist.hpp), or a file. Takes 10 s at most. Refused
/// (ErrorKind::input, behind the place and a colon): more than `most` bytes, less than the server promised,
/// what a server sends elsewhere for. ErrorKind::interrupted once `is_over` says so: "did not come in time".
Result<std::string> fetch_place(const std::string& place, std::size_t most, const WaitIsOver& is_over,
                                const ByteRange& range = {});

}  // namespace touchable
