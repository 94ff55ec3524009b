#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "player/window/pointer_fingers.hpp"

namespace touchable {

/// The last values of something that is drawn as a curve.
class Curve {
public:
    static constexpr std::size_t most = 240;  // values
    void add(double value) {
        values_[next_] = static_cast<float>(value);
        next_ = (next_ + 1) % most;
    }
    /// The k-th, oldest first.
    float operator[](std::size_t k) const { return values_[(next_ + k) % most]; }
    float newest() const { return values_[(next_ + most - 1) % most]; }
    float greatest() const;

private:
    std::array<float, most> values_{};
    std::size_t next_ = 0;
};

/// What a picture adds to the curves.
struct CurveValues {
    const std::vector<double>& forces;  ///< newtons, by finger
    double picture_ms = 0, tick_us = 0;
    std::int64_t late_ticks = 0, dropped_frames = 0;  ///< since the session began
};

/// Curves over the last pictures: each finger's force, the time that a picture and a tick take, and ticks and
/// frames that came too late.
class CurvesPanel {
public:
    /// Once a picture, whether it is drawn or not.
    void remember(const CurveValues& values);
    /// Where Dear ImGui's cursor is. `most_newtons`: of the highest force; `scale` as in ScreenSize.
    void draw(double most_newtons, float scale);

private:
    std::array<Curve, PointerFingers::most> forces_;
    Curve picture_ms_, tick_us_, late_ticks_, dropped_frames_;
    std::size_t fingers_ = 0;
    std::int64_t all_late_ = 0, all_dropped_ = 0;
};

}  // namespace touchable
