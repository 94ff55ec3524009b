#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "device/hand.hpp"
#include "device/hand_script.hpp"
#include "device/local_relief.hpp"

namespace touchable {

/// Fingers that follow a script over whatever surface is there: on a circle about the script's pixel, each
/// its own penetration along -Z behind the surface under it. A finger
/// rises over broken ground before it crosses it, and the script waits for it; it hops off rough ground now
/// and then, lest what presses there stay behind.
class ScriptedHand final : public Hand {
public:
    struct Settings {
        int fingers;
        Workspace workspace;
        PixelBox box;      ///< no finger leaves it; one that would glides along its edge
        double spread;     ///< radius of the fingers' circle, device metres
        double speed;      ///< at which the script moves, m/s of device space
        double max_speed;  ///< of a goal, m/s of device space
        double glide;      ///< over rough ground before it hops, device metres
    };

    ScriptedHand(const Settings& settings, std::unique_ptr<HandScript> script, const SurfaceProbe& probe);

    int fingers() const override { return settings_.fingers; }
    void goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) override;

private:
    struct Finger {
        glm::dvec2 offset;            // from the hand's centre, device metres, x right, y up
        double depth;                 // planar, scene units: of the surface under it, or the last there was
        glm::dvec3 goal;              // of the tick before
        std::optional<double> ridge;  // least planar depth about its way since it came on rough ground
        double glided = 0;            // since then, device metres
    };
    /// What a finger keeps to.
    struct Stance {
        double depth;  // planar, scene units
        bool firm;     // whether it may go behind `depth`
    };

    bool hops(const Finger& finger) const;
    void look_at_ground(const SurfaceProbe& probe);
    glm::dvec2 finger_pixel(const Finger& finger) const;
    Stance stance(Finger& finger, const glm::dvec2& pixel, const SurfaceProbe& probe) const;
    glm::dvec3 aim(Finger& finger, double penetration, double height, const SurfaceProbe& probe) const;
    bool move(Finger& finger, const glm::dvec3& target) const;
    double start_depth(const SurfaceProbe& probe, const glm::dvec2& pixel) const;

    Settings settings_;
    LocalReliefSearch local_relief_;
    std::unique_ptr<HandScript> script_;
    Ground ground_{};
    double centre_depth_;  // planar, scene units: where pixels are measured
    std::vector<Finger> fingers_;
    bool waits_ = false;  // the script, for a finger that is not yet where it should be
};

/// Makes the hand `name` ("wander", "stroke", "press" or "poke") from "key=value,..."; nothing if there is no
/// such hand. Refuses unknown keys and values out of range.
std::optional<Result<std::unique_ptr<Hand>>> make_scripted_hand(std::string_view name,
                                                                std::string_view options, int fingers,
                                                                const Workspace& workspace,
                                                                const SurfaceProbe& probe);

}  // namespace touchable
