#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>

#include "engine/base/result.hpp"
#include "engine/camera/plugged_camera.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// One camera for several runs, one after the other: while one goes on the next is made ready with frames
/// that the camera gave to the first, for a camera has but one stream. The camera stays open until the last
/// reader is gone.
class SharedCamera : public std::enable_shared_from_this<SharedCamera> {
public:
    /// The first opens the camera as `open_plugged_camera` does. Until its run begins, every later one has
    /// the newest frame of the run that goes on; its own may begin once that has ended.
    Result<std::unique_ptr<ClipReader>> open(const PluggedChoice& choice,
                                             const std::optional<SourceDescription>& known = {},
                                             const std::optional<std::filesystem::path>& scene_file = {});

private:
    class Reader;
    Result<std::optional<RawFrame>> read();
    Result<RawFrame> newest();

    std::unique_ptr<ClipReader> camera_;
    std::mutex mutex_;
    std::condition_variable came_;
    std::optional<RawFrame> newest_;  // guarded by mutex_
    std::int64_t next_number_ = 0;    // of the camera; of the thread that reads
};

}  // namespace touchable
