#pragma once

#include <deque>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "haptics_cpu/height_field.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/session/watched_session.hpp"

namespace touchable {

/// The fingers of a moment as a picture shows them, with the ways they went since they last touched.
class FingerTrails {
public:
    /// Once a picture. Fingers from `count` on are not shown, nor one whose place nobody knows, nor one that
    /// touches nothing and is nearer to the clip's camera than this share of the way to the surface.
    std::vector<FingerMark> marks(const WatchedTick& tick, int count, const HeightField& field,
                                  double nearest_share = 0.5);

private:
    struct Place {
        std::int64_t tick;
        glm::dvec2 pixel;  // of the clip, which a surface that moves carries along
    };
    std::vector<std::deque<Place>> trails_;
};

}  // namespace touchable
