#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/clip/reader_around.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A clip with haptic pictures of these ranges in place of its own, which a class derived from this paints.
class HapticTrackReader : public ReaderAround {
public:
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    const std::vector<std::string>& notes() const override { return notes_; }

protected:
    /// `ranges` are valid (validate).
    HapticTrackReader(std::unique_ptr<ClipReader> clip, const HapticRanges& ranges);

private:
    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
};

}  // namespace touchable
