#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// One clip for several runs over it, at once or one after the other, such as those of one window by other
/// settings. The clip is opened once. Its newest frames are kept, so that a run that begins where another one
/// is decodes nothing. The clip stays open until this and the last reader are gone. Of a camera it is
/// SharedCamera.
class SharedClip : public std::enable_shared_from_this<SharedClip> {
public:
    using Open = std::function<Result<std::unique_ptr<ClipReader>>()>;
    /// A reader of its own for a run, at the clip's beginning. The first call opens the clip, which must not
    /// be a live source, by `open_clip`; later ones do so only where that failed. One call at a time. Several
    /// readers may read at once, each on a thread.
    Result<std::unique_ptr<ClipReader>> open(const Open& open_clip);
    /// What the first frames can tell (DepthEstimator) is known: they are kept no longer than others.
    void forget_first_frames();

private:
    class Reader;
    Result<std::optional<RawFrame>> frame(std::int64_t number, bool is_from_the_beginning);
    const RawFrame* kept(std::int64_t number, bool is_from_the_beginning) const;
    void keep(const RawFrame& frame);

    std::unique_ptr<ClipReader> clip_;
    std::mutex mutex_;
    // Guarded by it, as is reading from the clip.
    std::optional<std::int64_t> position_;  // the frame that the clip gives next; nothing: not known
    std::deque<RawFrame> newest_;           // of those that were read, the last
    std::size_t newest_bytes_ = 0;
    std::vector<RawFrame> first_;  // from 0 on
    std::size_t first_bytes_ = 0;
    std::atomic<bool> keeps_first_{true};
    std::atomic<int> readers_{0};
};

}  // namespace touchable
