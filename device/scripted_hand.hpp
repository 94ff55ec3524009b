#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "device/hand.hpp"
#include "device/hand_script.hpp"

namespace touchable {

/// Fingers that follow a script over whatever surface is there: on a circle about the script's pixel, each
/// its own penetration along -Z behind the surface under it.
class ScriptedHand final : public Hand {
public:
    struct Settings {
        int fingers;
        Workspace workspace;
        PixelBox box;      ///< no finger leaves it; one that would glides along its edge
        double spread;     ///< radius of the fingers' circle, device metres
        double max_speed;  ///< of a goal, m/s of device space
    };

    ScriptedHand(const Settings& settings, std::unique_ptr<HandScript> script, const SurfaceProbe& probe);

    int fingers() const override { return settings_.fingers; }
    void goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) override;

private:
    void look_at_ground(const SurfaceProbe& probe);
    glm::dvec2 finger_pixel(int finger) const;
    glm::dvec3 aim(int finger, std::int64_t tick, const SurfaceProbe& probe);
    double start_depth(const SurfaceProbe& probe, const glm::dvec2& pixel) const;

    Settings settings_;
    std::unique_ptr<HandScript> script_;
    std::vector<glm::dvec2> offsets_;  // of the fingers, device metres, x right, y up
    Ground ground_{};
    double centre_depth_;               // planar, scene units: where pixels are measured
    std::vector<double> depths_;        // planar, scene units: under each finger, or the last there was
    std::vector<glm::dvec3> previous_;  // goals of the tick before
};

/// Makes the hand `name` ("wander", "stroke", "press" or "poke") from "key=value,..."; nothing if there is no
/// such hand. Refuses unknown keys and values out of range.
std::optional<Result<std::unique_ptr<Hand>>> make_scripted_hand(std::string_view name,
                                                                std::string_view options, int fingers,
                                                                const Workspace& workspace,
                                                                const SurfaceProbe& probe);

}  // namespace touchable
