#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace touchable {

/// Of what pictures have less where they come late. Where the CPU draws (SurfaceDrawing::thins_vertices) the
/// surface's vertices cost the most, and stretching a picture would cost what a smaller one saves.
enum class LessOf { vertices, pixels };

/// In how much detail the surface is drawn, so that pictures come in time: with all of its vertices or no
/// more than the window's pixels tell apart (`coarse`); then with still fewer vertices, or smaller and
/// stretched. It begins coarse, goes down at once and up slowly; what saves too little is taken back, once it
/// has been judged (`judge`).
class PictureGovernor {
public:
    explicit PictureGovernor(LessOf less = LessOf::pixels)
        : levels_(less == LessOf::pixels ? std::span<const Level>(by_pixels) : by_vertices) {}

    /// Of the shown width and height.
    double share() const { return levels_[level_].share; }
    bool coarse() const { return levels_[level_].coarse; }
    /// From vertex to vertex, times what `coarse` asks for.
    int step() const { return levels_[level_].step; }
    /// Of the width in pixels, or in vertices that are told apart: 0 to 1.
    double detail() const { return share() / step(); }

    /// After a picture at `now_s`: of the frames that have been due since the picture before, how many were
    /// shown in time; and what part of a frame's time the drawing took. `coarse_saves`: there are more
    /// vertices than the window tells apart.
    void add(double now_s, std::int64_t due, std::int64_t in_time, double drawing, bool coarse_saves);

private:
    struct Level {
        double share;
        bool coarse;
        int step;
        double dearer;  ///< times the drawing of the next one
    };
    static constexpr std::array<Level, 4> by_pixels{
        {{1, false, 1, 3}, {1, true, 1, 1.78}, {0.75, true, 1, 2.25}, {0.5, true, 1, 1}}};
    static constexpr std::array<Level, 3> by_vertices{{{1, false, 1, 3}, {1, true, 1, 1.5}, {1, true, 2, 1}}};
    static constexpr std::int64_t few = 15;   // frames that are judged together
    static constexpr double tolerated = 0.9;  // of them in time
    static constexpr double cause = 0.5;      // of a frame's time: what takes less makes nothing late
    static constexpr double room = 0.8;       // of a frame's time, for a larger picture
    static constexpr double worth = 0.9;      // of the time before, for a smaller one
    static constexpr int judgements = 3;      // that late pictures save too little, before less is taken back
    static constexpr double least_s = 3, most_s = 60;  // until it is tried

    void go_to(std::size_t level, double now_s);
    void judge(double drawing_each, bool is_late, double now_s);

    std::span<const Level> levels_;
    std::size_t level_ = 1;
    std::int64_t due_ = 0, in_time_ = 0, pictures_ = 0;
    double drawing_ = 0;  // sum over those pictures
    double changed_s_ = 0, wait_s_ = least_s;
    double before_ = 0;  // drawing_ of a picture before it went down from there, until that was judged
    std::size_t from_ = 0;
    int judged_ = 0;           // since it came from there
    double not_before_s_ = 0;  // it goes down
    bool rose_ = false;        // at the last change
};

}  // namespace touchable
