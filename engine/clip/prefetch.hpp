#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// A clip of which these frames, its first ones, were read already: `next` gives them before it reads on, so
/// that looking ahead costs no second decoding.
std::unique_ptr<ClipReader> with_prefetched_frames(std::unique_ptr<ClipReader> clip,
                                                   std::vector<RawFrame> frames);

/// Looks ahead in a clip that is at its beginning, and keeps its first frames for whoever plays it.
class Prefetch {
public:
    explicit Prefetch(std::unique_ptr<ClipReader> clip) : clip_(std::move(clip)) {}

    /// The next of the first frames.
    Result<std::optional<RawFrame>> next();
    /// A later one, which is not kept. After it no `next`.
    Result<std::optional<RawFrame>> at(std::int64_t frame);
    const ClipReader& clip() const { return *clip_; }
    /// The clip, at its beginning again. Once.
    Result<std::unique_ptr<ClipReader>> finish();

private:
    static constexpr std::size_t most_bytes = std::size_t{512} << 20;  // 25 frames of 1920x1080, all planes

    std::unique_ptr<ClipReader> clip_;
    std::vector<RawFrame> frames_;  // empty where they took too much memory
    std::size_t bytes_ = 0;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    bool has_moved_ = false, is_damaged_ = false;
};

}  // namespace touchable
