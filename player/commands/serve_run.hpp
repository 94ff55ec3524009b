#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/stream/hls_writer.hpp"
#include "engine/stream/stream_url.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

/// What is sent, and where to.
struct ServeOptions {
    ClipChoice clip;  ///< of which filters do not count
    std::vector<StreamUrl> urls;
    bool loop = false;
    int listeners = 0;  ///< that are there before it begins
    std::optional<std::int64_t> longest_ns;
    bool mpegts = false;  ///< over SRT: as stock tools read it
    std::optional<HlsSettings> hls;
    std::optional<std::filesystem::path> json;
    Existing existing = Existing::keep;  ///< of `json`
};

/// Sends until the clip ends, it was sent for long enough, or a person asks to stop, which is no error; then
/// says what was sent, and to whom.
Result<void> run_serve(const ServeOptions& options);

}  // namespace touchable
