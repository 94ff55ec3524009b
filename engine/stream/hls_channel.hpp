#pragma once

#include <memory>

#include "engine/stream/hls_writer.hpp"
#include "engine/stream/stream_muxer.hpp"

namespace touchable {

/// A form of a stream whose framesets go into an HlsWriter's folder: its blocks have no bytes, and decoding
/// begins where the writer's segments do. The writer outlives it, and is finished by whoever has it.
std::unique_ptr<StreamMuxer> make_hls_channel(HlsWriter& writer);

}  // namespace touchable
