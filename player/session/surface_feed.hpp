#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/frame/surface_timeline.hpp"
#include "engine/media/clip.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/session/planes_hash.hpp"

namespace touchable {

/// A clip's frames on their way into the timeline, and in virtual time on the caller's thread: whoever asks
/// for a moment finds the frames around it published.
class SurfaceFeed {
public:
    /// `scene`: the reader's, as this run applies it.
    SurfaceFeed(std::unique_ptr<ClipReader> reader, std::unique_ptr<SurfaceBuilder> builder,
                const Scene& scene);

    /// Reads and builds until a frame later than `time_ns` is published or the clip has ended, then gives the
    /// pair around that time. Times must not go backward. An empty clip is an error.
    Result<FramePair> pair_at(std::int64_t time_ns);

    /// The pair of these frames (the same, or neighbours) at a blend: what a live tick found, whatever its
    /// time.
    Result<FramePair> pair_of(std::int64_t prev, std::int64_t next, double blend);

    // The parts, for a thread each (FeedThreads).
    /// Decodes a frame; nothing after the last.
    Result<std::optional<RawFrame>> read_next();
    /// Builds and publishes it, or, where no filter remembers, the frame before once more where nothing that
    /// can be touched has changed; false while the timeline has no room.
    Result<bool> publish(const RawFrame& raw);
    SurfaceTimeline& timeline() { return timeline_; }

    const ClipReader& reader() const { return *reader_; }
    std::string_view builder_name() const { return builder_->name(); }
    std::int64_t frames() const { return frames_; }  ///< published so far
    /// Of them, those that were the frame before once more.
    std::int64_t unchanged_frames() const { return unchanged_frames_; }
    /// Of all their tiles the share that was not built, 0 to 1: because nothing there has changed since a
    /// frame before, or because nobody touched it (lazy).
    double skipped_share() const { return frames_ > 0 ? skipped_frames_ / static_cast<double>(frames_) : 1; }
    /// Whether any stored pixel of the frames published so far was valid.
    bool any_valid() const { return any_valid_; }
    bool ended() const { return ended_; }
    /// End of the newest frame's time on screen.
    std::int64_t end_ns() const { return rate_.time_ns(frames_); }
    /// Per frame, milliseconds.
    const std::vector<double>& read_ms() const { return read_ms_; }
    const std::vector<double>& build_ms() const { return build_ms_; }
    /// Of the frames published so far.
    std::string planes_hash() const { return hash_.hex(); }

private:
    Result<void> publish_next();
    Result<bool> build(const RawFrame& raw);

    std::unique_ptr<ClipReader> reader_;
    std::unique_ptr<SurfaceBuilder> builder_;
    FrameRate rate_;
    DepthCoding stored_;
    bool settles_;  // a filter that remembers makes another surface of the same frame once more
    SurfaceTimeline timeline_{4};
    PlanesHash hash_;
    std::optional<RawFrame> newest_;  // of those that were built
    std::int64_t frames_ = 0, unchanged_frames_ = 0;
    double skipped_frames_ = 0;  // and parts of frames
    bool any_valid_ = false, ended_ = false;
    std::vector<double> read_ms_, build_ms_;
};

}  // namespace touchable
