#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "capi/handle_table.hpp"
#include "engine/clip/clip.hpp"

namespace touchable::capi {

/// Behind a touch_clip.
struct ClipObject {
    explicit ClipObject(std::unique_ptr<ClipReader> opened);

    const SceneDescription described;
    const std::vector<TrackInfo> tracks;
    const std::vector<std::string> notes;  ///< with the members that say otherwise
    const std::optional<std::int64_t> frames;
    const std::vector<std::filesystem::path> inputs;
    std::stop_source stop;

    std::atomic_flag reading = ATOMIC_FLAG_INIT;  ///< guards what follows
    std::unique_ptr<ClipReader> reader;           ///< null: it could not be read on
    std::int64_t next_frame = 0;                  ///< of the reader
    std::shared_ptr<RawFrame> unclaimed;          ///< was read, and there was no room for it; null: none

    bool has(const char* role) const;
};

HandleTable<ClipObject>& clips();

/// Whether a clip that is open is read from this file, or from a file in this folder, whatever its name.
bool is_read_by_an_open_clip(const std::filesystem::path& path);

}  // namespace touchable::capi
