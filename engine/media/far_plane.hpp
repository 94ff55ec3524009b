#pragma once

#include <cstdint>
#include <string>

#include "engine/frame/plane_view.hpp"
#include "engine/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Finds the far plane of a metric clip that does not give one: the largest valid depth of all frames plus 5
/// %.
class FarPlaneSearch {
public:
    explicit FarPlaneSearch(const DepthCoding& coding) : coding_(coding) {}
    /// An error once somebody asked the program to stop: a clip may take long to search.
    Result<void> add(const PlaneView& depth);
    /// Settles the scene's coding; the note says what was found. An error where no depth was valid.
    Result<std::string> settle(Scene& scene) const;

private:
    DepthCoding coding_;
    int deepest_ = -1;  // code
};

}  // namespace touchable
