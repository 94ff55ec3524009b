#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "engine/base/given_file.hpp"
#include "engine/base/result.hpp"
#include "engine/stream/stream_bytes.hpp"
#include "engine/stream/stream_url.hpp"

namespace touchable {

/// What is there under an http(s) address: a file whose size its server says, and of which it gives any part;
/// or a stream, and the connection that it comes by.
struct HttpSource {
    std::optional<SourceFile> file{};
    /// Of a file: called when its clip is open, or is not. From then on each part has a time of its own.
    /// Returns what has kept bytes from coming so far; their reader may not have told.
    std::function<std::optional<Error>()> end_opening{};
    std::shared_ptr<StreamBytes> stream{};
};

/// Asks the server. The file is called after the address. Its parts are read as they are needed, those until
/// `end_opening` within `patience.opening` together, each later one within `patience.frameset`, if need be
/// over a new connection. Once a part did not come, nothing more is read: every later read fails at once.
Result<HttpSource> open_http(const StreamUrl& url, const StreamPatience& patience = {});

}  // namespace touchable
