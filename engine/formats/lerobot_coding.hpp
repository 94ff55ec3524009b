#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// LeRobot's codes of depth (lerobot 0.6, datasets/depth_utils.py), lengths in metres: 4095 even steps of
/// ln(depth + shift). Code 0 is where nothing was seen: LeRobot reads it as its nearest depth.
DepthCoding lerobot_coding(double near = 0.01, double far = 10, double shift = 3.5);

/// The same with even steps of depth (`video.use_log` false).
DepthCoding lerobot_linear_coding(double near, double far);

/// Metres that all of its depth is nearer than.
inline constexpr double lerobot_horizon = 1e6;

/// A clip's depth as LeRobot has it.
class LeRobotCodes {
public:
    explicit LeRobotCodes(const Scene& scene);
    /// The clip as it is then: in metres, depth alone.
    const Scene& scene() const { return scene_; }
    /// Whether the clip's codes are such codes already, and stay.
    bool are_kept() const { return are_kept_; }
    /// How far the codes about 1 m are apart, metres.
    double step_at_a_metre() const;
    /// Its depth, along the optical axis whatever it was. What is nearer or deeper than the planes is at
    /// them, but never code 0.
    RawFrame of(const RawFrame& frame) const;

private:
    Scene from_, scene_;
    bool are_kept_ = false;
    std::vector<std::uint16_t> table_;  // of every stored code
};

}  // namespace touchable
