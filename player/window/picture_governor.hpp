#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace touchable {

/// How large the surface is drawn, where pictures would come late otherwise: as large as it is shown, or
/// smaller and stretched. It goes down at once and comes back slowly; but at once where being smaller saves
/// little, since stretching costs time too.
class PictureGovernor {
public:
    /// Of the shown width and height.
    double share() const { return shares[level_]; }

    /// After a picture at `now_s`: of the frames that have been due since the picture before, how many were
    /// shown in time; and what part of a frame's time the drawing took.
    void add(double now_s, std::int64_t due, std::int64_t in_time, double drawing);

private:
    static constexpr std::array<double, 3> shares{1, 0.75, 0.5};
    static constexpr std::int64_t few = 15;   // frames that are judged together
    static constexpr double tolerated = 0.8;  // of them in time
    static constexpr double cause = 0.5;      // of a frame's time: what takes less makes nothing late
    static constexpr double room = 0.8;       // of a frame's time, for a larger picture
    static constexpr double worth = 0.9;      // of the time before, for a smaller one
    static constexpr double least_s = 3, most_s = 60;  // until it is tried

    void go_to(std::size_t level, double now_s);

    std::size_t level_ = 0;
    std::int64_t due_ = 0, in_time_ = 0, pictures_ = 0;
    double drawing_ = 0;  // sum over those pictures
    double changed_s_ = 0, wait_s_ = least_s;
    double before_ = 0;        // drawing_ of a picture before it went down, until that was judged
    double not_before_s_ = 0;  // it goes down
    bool rose_ = false;        // at the last change
};

}  // namespace touchable
