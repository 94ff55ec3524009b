#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "engine/base/result.hpp"
#include "player/window/opened_clip.hpp"

namespace touchable {

/// What a person does to the time of the clip in the window. Errors (ErrorKind::usage) are what the clip's
/// clock refuses.
class PlaybackControl {
public:
    static constexpr double slowest = 0.1, fastest = 4;  ///< times the clip's own speed

    /// `clip` outlives it.
    explicit PlaybackControl(OpenedClip& clip) : clip_(&clip) {}

    /// From the end it plays again from the beginning.
    Result<void> play_or_pause();
    Result<void> pause(bool on) { return ask(on ? PlaybackVerb::pause : PlaybackVerb::play); }
    void seek_to(double seconds);
    void seek_by(double seconds);
    /// A frame on, or back where `frames` is below 0; and pause.
    Result<void> step(double frames);
    /// Kept within slowest and fastest.
    Result<void> set_speed(double times);
    Result<void> change_speed(double factor);
    /// As the clip began: by the commands that it was given at first, and playing; `loops`: at least the
    /// whole of it, if it is long enough.
    Result<void> begin_anew(std::span<const PlaybackCommand> first, bool loops);
    /// From the beginning again at the end, or not.
    Result<void> toggle_loop();
    /// Once a turn of the window: goes to where it is to go, one place after the other. So whoever drags the
    /// seek bar sees every place that there is time for, and in the end the last. `moment`: what is seen now.
    Result<void> go_on(const WatchedMoment* moment);

private:
    Result<void> ask(PlaybackVerb verb, std::int64_t first = 0, std::int64_t second = 0) {
        return clip_->session().ask(verb, first, second);
    }

    OpenedClip* clip_;
    std::optional<std::int64_t> wanted_ns_;  // of the clip, to be gone to
};

}  // namespace touchable
