#include "device/hand.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "device/finger_circle.hpp"
#include "device/hand_options.hpp"
#include "device/hand_script.hpp"
#include "device/local_relief.hpp"
#include "device/recorded_hand.hpp"

namespace touchable {
namespace {

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

constexpr double entry_s = 0.25;          // a hand comes down in this time ...
constexpr double entry_height = 0.05;     // ... from this far above, device metres
constexpr double settling_s = 0.1;        // time constant of the depth that pixels are measured at
constexpr double reach = 0.0006;          // a finger looks this far about itself, device metres
constexpr double clearance = 0.001;       // it crosses broken ground this far above it, device metres
constexpr double greatest_lag = 0.00025;  // the script waits for one that is farther off, device metres
constexpr double nearest_goal = 0.1;  // a goal stays this share of the surface's depth in front of the camera

bool ScriptedHand::hops(const Finger& finger) const {
    return finger.ridge && finger.glided > settings_.glide;
}

ScriptedHand::ScriptedHand(const Settings& settings, std::unique_ptr<HandScript> script,
                           const SurfaceProbe& probe)
    : settings_(settings),
      local_relief_(reach + settings.speed * tick_s, settings.workspace.metres_per_scene_unit, settings.box),
      script_(std::move(script)) {
    centre_depth_ = start_depth(probe, script_->pixel());
    look_at_ground(probe);
    for (int k = 0; k < settings.fingers; ++k) {
        Finger finger{finger_offset(k, settings.fingers, settings.spread), 0, glm::dvec3(0), {}};
        finger.depth = start_depth(probe, finger_pixel(finger));
        finger.goal = aim(finger, script_->penetration(k), entry_height, probe);
        fingers_.push_back(finger);
    }
}

/// The depth at or nearest to `pixel`; where nothing is to be seen, that of the device's centre.
double ScriptedHand::start_depth(const SurfaceProbe& probe, const glm::dvec2& pixel) const {
    const std::optional<SurfacePoint> found = nearest_surface(probe, pixel, settings_.box);
    return found ? found->depth : device_depth(settings_.workspace);
}

void ScriptedHand::goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) {
    assert(goals.size() == fingers_.size());
    const bool moves = tick > 0 && !waits_;
    if (moves) script_->advance(ground_, probe);
    if (!waits_) look_at_ground(probe);
    waits_ = false;
    const double to_come = std::max(0.0, 1 - static_cast<double>(tick) * tick_s / entry_s);
    for (std::size_t k = 0; k < fingers_.size(); ++k) {
        Finger& finger = fingers_[k];
        if (moves) finger.glided += settings_.speed * tick_s;
        const double penetration = script_->penetration(static_cast<int>(k));
        const bool there = move(finger, aim(finger, penetration, entry_height * to_come, probe));
        if (!hops(finger)) {
            waits_ = waits_ || !there;
        } else if (there) {
            finger.ridge.reset();
        }
        goals[k] = finger.goal;
    }
}

/// The depth at which pixels are measured follows the surface gently, or all fingers would jerk sideways
/// whenever the centre crosses a silhouette.
void ScriptedHand::look_at_ground(const SurfaceProbe& probe) {
    const glm::dvec2 pixel = script_->pixel();
    const std::optional<double> seen = probe.depth_under(pixel.x, pixel.y);
    if (seen) centre_depth_ += (*seen - centre_depth_) * (tick_s / settling_s);
    ground_.surface = seen.has_value();
    ground_.metres_per_pixel =
        pixel_size(probe, pixel, centre_depth_, settings_.workspace.metres_per_scene_unit);
}

glm::dvec2 ScriptedHand::finger_pixel(const Finger& finger) const {
    const glm::dvec2 offset = finger.offset / ground_.metres_per_pixel;
    const glm::dvec2 pixel = script_->pixel() + glm::dvec2(offset.x, -offset.y);
    return glm::clamp(pixel, settings_.box.least, settings_.box.greatest);
}

/// A finger on its way minds the ground about it; one that stays over its pixel minds only that.
ScriptedHand::Stance ScriptedHand::stance(Finger& finger, const glm::dvec2& pixel,
                                          const SurfaceProbe& probe) const {
    const std::optional<double> under = probe.depth_under(pixel.x, pixel.y);
    finger.depth = under.value_or(finger.depth);
    if (!script_->moves()) return {finger.depth, under.has_value()};
    const LocalRelief local_relief = local_relief_.about(pixel, finger.depth, probe);
    if (!under || local_relief.kind == LocalRelief::Kind::broken) {
        finger.ridge.reset();
        return {local_relief.highest, false};
    }
    if (local_relief.kind == LocalRelief::Kind::rough && !finger.ridge) {
        finger.ridge = local_relief.highest;
        finger.glided = 0;
    }
    if (finger.ridge) finger.ridge = std::min(*finger.ridge, local_relief.highest);
    return hops(finger) ? Stance{*finger.ridge, false} : Stance{finger.depth, true};
}

/// `penetration` along -Z where the ground is firm. A finger that crosses other ground or has yet to come
/// down by `height` is lifted along its pixel's ray, on which nothing else stands.
glm::dvec3 ScriptedHand::aim(Finger& finger, double penetration, double height,
                             const SurfaceProbe& probe) const {
    const double metres_per_unit = settings_.workspace.metres_per_scene_unit;
    const glm::dvec2 pixel = finger_pixel(finger);
    const auto [depth, firm] = stance(finger, pixel, probe);
    const double lift = height + (firm ? 0 : std::max(-penetration, clearance));
    const double nearest = nearest_goal * depth;
    glm::dvec3 goal = probe.unproject(pixel.x, pixel.y, std::max(depth - lift / metres_per_unit, nearest));
    if (firm) goal.z = std::min(goal.z - penetration / metres_per_unit, -nearest);
    return goal;
}

/// Moves the finger's goal to `target` as far as it gets within one tick; whether that is about there.
bool ScriptedHand::move(Finger& finger, const glm::dvec3& target) const {
    const glm::dvec3 way = target - finger.goal;
    const double length = glm::length(way) * settings_.workspace.metres_per_scene_unit;
    const double longest = settings_.max_speed * tick_s;
    finger.goal = length > longest ? finger.goal + way * (longest / length) : target;
    return length - longest <= greatest_lag;
}

using Kind = HandKey::Kind;
constexpr double millimetre = 0.001;

constexpr HandKey speed{"speed", "m/s", 0.001, 2, 0.1};
constexpr HandKey depth{"depth", "mm", 0, 50, 2};
constexpr HandKey lift{"lift", "mm", 0, 50, 2};
constexpr HandKey seed{"seed", "", 0, 0x1p53, 1, Kind::whole};
constexpr HandKey spread{"spread", "m", 0, 0.2, 0.02};
constexpr HandKey extent{"extent", "of the picture", 0.05, 1, 0.8};
constexpr HandKey max_speed{"max_speed", "m/s", 0.01, 10, 2};
constexpr HandKey glide{"glide", "mm", 0, 1e6, 1};
constexpr HandKey angle{"angle", "degrees", -360, 360, 0};
constexpr HandKey x{"x", "of the picture's width", 0, 1, 0.5};
constexpr HandKey y{"y", "of the picture's height", 0, 1, 0.5};

constexpr std::array wander_keys{speed, depth, seed, spread, extent, max_speed, glide};
constexpr std::array stroke_keys{speed, depth, angle, spread, extent, max_speed, glide};
constexpr std::array press_keys{x, y, depth, lift, HandKey{"period", "s", 0.05, 60, 1}, spread, max_speed};
constexpr std::array poke_keys{speed,  depth,     lift, HandKey{"period", "s", 0.05, 60, 0.25}, seed, spread,
                               extent, max_speed, glide};

std::span<const HandKey> keys_of(std::string_view name) {
    if (name == "wander") return wander_keys;
    if (name == "stroke") return stroke_keys;
    if (name == "press") return press_keys;
    if (name == "poke") return poke_keys;
    return {};
}

std::unique_ptr<HandScript> make_script(std::string_view name, const HandOptions& given, int fingers,
                                        const PixelBox& box, const SurfaceProbe& probe) {
    const auto metres = [&](const HandKey& key) { return given.number(key.name) * millimetre; };
    const auto number = [&](const HandKey& key) { return given.number(key.name); };
    const auto whole = [&](const HandKey& key) { return static_cast<std::uint64_t>(given.number(key.name)); };
    if (name == "wander") {
        return make_wander({number(speed), metres(depth), whole(seed)}, fingers, box, probe);
    }
    if (name == "stroke") {
        return make_stroke({number(speed), metres(depth), number(angle) * pi / 180}, fingers, box);
    }
    const double period = given.number("period");
    if (name == "press") {
        const glm::dvec2 last(probe.width() - 1, probe.height() - 1);
        return make_press({glm::dvec2(number(x), number(y)) * last, metres(depth), metres(lift), period},
                          fingers);
    }
    return make_poke({number(speed), metres(depth), metres(lift), period, whole(seed)}, fingers, box, probe);
}

/// Makes the hand `name` ("wander", "stroke", "press" or "poke") from "key=value,..."; nothing if there is no
/// such hand. Refuses unknown keys and values out of range.
std::optional<Result<std::unique_ptr<Hand>>> make_scripted_hand(std::string_view name,
                                                                std::string_view options, int fingers,
                                                                const Workspace& workspace,
                                                                const SurfaceProbe& probe) {
    const std::span<const HandKey> keys = keys_of(name);
    if (keys.empty()) return std::nullopt;
    const Result<HandOptions> given =
        HandOptions::parse(std::string("hand '").append(name).append("'"), options, keys);
    if (!given) return given.error();
    if (name != "press" && given->number(max_speed.name) < given->number(speed.name)) {
        return usage_error("hand '" + std::string(name) +
                           "': max_speed is below speed; raise it to at least speed");
    }
    const PixelBox box = middle_of(probe, name == "press" ? 1 : given->number(extent.name));
    const ScriptedHand::Settings settings{fingers,
                                          workspace,
                                          box,
                                          given->number(spread.name),
                                          name == "press" ? 0 : given->number(speed.name),
                                          given->number(max_speed.name),
                                          name == "press" ? 0 : given->number(glide.name) * millimetre};
    std::unique_ptr<HandScript> script = make_script(name, *given, fingers, box, probe);
    return std::unique_ptr<Hand>(std::make_unique<ScriptedHand>(settings, std::move(script), probe));
}

}  // namespace

Result<std::unique_ptr<Hand>> make_hand(const std::string& description, int fingers,
                                        const Workspace& workspace, const SurfaceProbe& probe) {
    constexpr int most_fingers = 256;
    if (fingers < 1 || fingers > most_fingers) {
        return usage_error("a hand has 1 to " + std::to_string(most_fingers) + " fingers, not " +
                           std::to_string(fingers));
    }
    const std::size_t colon = description.find(':');
    const std::string name = description.substr(0, colon);
    const std::string rest = colon == std::string::npos ? "" : description.substr(colon + 1);
    if (name == "csv") return make_recorded_hand(rest, fingers, workspace, probe);
    if (auto hand = make_scripted_hand(name, rest, fingers, workspace, probe)) return std::move(*hand);
    return usage_error("unknown hand '" + name +
                       "'; hands are wander, stroke, press, poke, csv:FILE, rec:FILE");
}

}  // namespace touchable
