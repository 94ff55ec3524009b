#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/camera/colour_converter.hpp"
#include "engine/camera/v4l2_stream.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/plane_role.hpp"

namespace touchable {

/// The colour camera beside one of depth: its newest pictures, of which the one nearest in time is shown.
/// One thread.
class ColourBeside {
public:
    /// A stream of a size near the depth's, at a rate near it. An error names the node.
    static Result<std::unique_ptr<ColourBeside>> open(const std::shared_ptr<VideoSystem>& system,
                                                      const std::string& node, const StreamFormat& depth,
                                                      const std::optional<FrameRate>& rate);
    const TrackInfo& track() const { return track_; }
    int descriptor() const { return stream_->descriptor(); }
    /// Takes what is there. An error, once, when no more will come: what happened.
    Result<void> look();
    /// Of the scene's size; nothing before the first picture that can be read.
    std::optional<Plane> nearest(std::int64_t at_ns, const Scene& scene);

private:
    ColourBeside(std::unique_ptr<V4l2Stream> stream, std::string node);

    std::unique_ptr<V4l2Stream> stream_;
    std::string node_;
    TrackInfo track_;
    std::vector<TakenPicture> recent_;  // the newest last
    ColourConverter converter_;
    std::optional<Plane> plane_;  // of the one that was shown last
    std::int64_t plane_at_ns_ = 0;
};

}  // namespace touchable
