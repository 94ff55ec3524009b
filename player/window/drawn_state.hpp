#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "player/session/watched_session.hpp"

namespace touchable {

/// What a picture was of: where nothing of it is different it need not be drawn again.
class DrawnState {
public:
    /// Whether the moment is at another frame than the last picture; whatever its blend with the next.
    bool is_other_frame(const WatchedMoment& moment) const;
    /// Whether frames, blend, colour or a finger are others. `count`: fingers that are shown; `small`: by how
    /// much they may move unseen, scene units.
    bool differs(const WatchedMoment& moment, int count, double small) const;
    void remember(const WatchedMoment& moment, int count);

private:
    struct Finger {
        glm::dvec3 goal{0.0}, proxy{0.0}, force{0.0};
    };
    std::uint64_t epoch_ = 0;
    std::int64_t prev_ = -1, next_ = -1;
    double blend_ = 0;
    const void* colour_ = nullptr;
    std::vector<Finger> fingers_;
};

}  // namespace touchable
