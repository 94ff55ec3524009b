#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/wake.hpp"

namespace touchable {

/// Frames of before a run are so far apart.
inline constexpr std::int64_t ns_before_a_run = 1000;

/// What every camera's run has: the numbers and times of its frames, before it and in it; how a wait is told
/// to end; whether the camera is gone, and what a person should know. One thread, but where it says so.
class CameraRun {
public:
    /// `name`: as messages call the camera; `kind`: what they call it, where it is none.
    explicit CameraRun(std::string name, std::string kind = "camera")
        : name_(std::move(name)), kind_(std::move(kind)) {}

    bool has_begun() const { return zero_ns_.has_value(); }
    /// Frames count from here on; once more after a run that has ended.
    void begin(std::chrono::steady_clock::time_point zero);
    /// Before a run: the number of the frame that comes next.
    Result<void> seek(std::int64_t frame);

    struct Place {
        std::int64_t number = 0, time_ns = 0;
    };
    /// Of the frame that came next, by the camera's count and the time of std::chrono::steady_clock at which
    /// it was taken. In a run the count tells what was left out; where it stands still, or has begun anew,
    /// the next number. Nothing: it was taken before the run.
    std::optional<Place> place(std::uint32_t count, std::int64_t at_ns);

    /// From any thread.
    void interrupt();
    /// For poll: readable once it was told to end.
    int descriptor() const { return wake_.descriptor(); }
    /// An error of kind interrupted where a wait is to end: a run is interrupted by who ends it, and what is
    /// before it by a signal.
    std::optional<Error> told_to_end() const;

    void gone(const std::string& why);
    bool is_gone() const { return is_gone_; }
    void remark(std::string words);
    /// From any thread.
    std::vector<std::string> remarks() const;

private:
    const std::string name_, kind_;
    Wake wake_;
    std::atomic<bool> interrupted_{false};
    bool is_gone_ = false;
    std::int64_t next_number_ = 0;
    std::optional<std::uint32_t> last_count_;  // of a frame of the run
    std::optional<std::int64_t> zero_ns_;
    std::int64_t last_time_ns_ = -1;
    mutable std::mutex mutex_;
    std::vector<std::string> remarks_;  // guarded by mutex_
};

}  // namespace touchable
