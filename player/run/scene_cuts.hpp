#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "engine/scene/depth_coding.hpp"
#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// Finds a clip's cuts by its depth, as frames come by: a cut is a frame in which most of the picture has
/// another depth than in the frame before. For the eye alone; touch has its own measure of sudden changes.
class SceneCuts {
public:
    /// Some 800 pixels of a frame are looked at; the frame before is the last one that was, where it is one
    /// or two earlier and of the same epoch.
    void look(const RawFrame& frame, const DepthCoding& coding);
    /// Their numbers, of a clip of any length no more than 4096.
    const std::set<std::int64_t>& found() const { return found_; }

private:
    std::uint64_t epoch_ = 0;
    std::int64_t number_ = -1;
    std::vector<int> codes_, before_;  // -1: invalid
    std::set<std::int64_t> found_;
};

}  // namespace touchable
