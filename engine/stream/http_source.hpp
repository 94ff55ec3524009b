#pragma once

#include <memory>
#include <optional>

#include "engine/given_file.hpp"
#include "engine/result.hpp"
#include "engine/stream/stream_bytes.hpp"
#include "engine/stream/stream_url.hpp"

namespace touchable {

/// What is there under an http(s) address: a file whose size its server says, and of which it gives any part;
/// or a stream, and the connection that it comes by.
struct HttpSource {
    std::optional<SourceFile> file{};
    std::shared_ptr<StreamBytes> stream{};
};

/// Asks the server. The file is called after the address. Its parts are read as they are needed; each comes
/// within `patience.frameset`, if need be over a new connection, or is an error.
Result<HttpSource> open_http(const StreamUrl& url, const StreamPatience& patience = {});

}  // namespace touchable
