#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// The frames of a clip that tell what is to be known of all of them: the first ones, and as many more that
/// are spread over the rest. However long a clip is, to know it takes no longer.
inline constexpr std::int64_t first_frames = 16, spread_frames = 16;
/// Their numbers, ascending, in a clip of `count` frames of which each can be read on its own.
std::vector<std::int64_t> telling_frames(std::int64_t count);

/// The far plane of a metric clip that does not give one: 5 % beyond the depth that at most one valid pixel
/// in 10 000 exceeds. (A camera's stray pixels say nothing of its scene, and a far plane out there would make
/// codes coarser for all others.) What lies beyond it is invalid.
class FarPlaneEstimator {
public:
    explicit FarPlaneEstimator(const DepthCoding& coding) : coding_(coding), pixels_(65536) {}
    void add(const PlaneView& depth);
    /// Gives this scene that far plane; the note says what was found. An error where no depth was valid.
    Result<std::string> settle(Scene& scene) const;

private:
    DepthCoding coding_;
    std::vector<std::int64_t> pixels_;  // by code, of valid ones
    int frames_ = 0;
};

/// A clip at its beginning. Where its description leaves the far plane open (Unstated::far), so that it is
/// the deepest code's so far, it is settled, and a note says it; otherwise the clip is unchanged. Where it
/// cannot seek, its first frames tell all. A later frame that is damaged tells nothing; who plays it learns
/// of that then. Errors name `file`.
Result<std::unique_ptr<ClipReader>> with_far_plane(std::unique_ptr<ClipReader> clip, bool far_is_open,
                                                   const std::filesystem::path& file);

}  // namespace touchable
