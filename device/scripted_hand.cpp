#include "device/scripted_hand.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

#include "device/finger_circle.hpp"
#include "device/hand_options.hpp"

namespace touchable {
namespace {

constexpr double entry_s = 0.25;       // a hand comes down in this time ...
constexpr double entry_height = 0.05;  // ... from this far above, device metres
constexpr double settling_s = 0.1;     // time constant of the depth that pixels are measured at
constexpr double nearest_goal = 0.1;  // a goal stays this share of the surface's depth in front of the camera

/// Device metres that one pixel spans at `depth`, across and down.
glm::dvec2 pixel_size(const SurfaceProbe& probe, const glm::dvec2& pixel, double depth,
                      double metres_per_unit) {
    const glm::dvec3 here = probe.unproject(pixel.x, pixel.y, depth);
    const glm::dvec3 right = probe.unproject(pixel.x + 1, pixel.y, depth);
    const glm::dvec3 below = probe.unproject(pixel.x, pixel.y + 1, depth);
    return glm::dvec2(right.x - here.x, here.y - below.y) * metres_per_unit;
}

}  // namespace

ScriptedHand::ScriptedHand(const Settings& settings, std::unique_ptr<HandScript> script,
                           const SurfaceProbe& probe)
    : settings_(settings), script_(std::move(script)) {
    for (int finger = 0; finger < settings.fingers; ++finger) {
        offsets_.push_back(finger_offset(finger, settings.fingers, settings.spread));
    }
    centre_depth_ = start_depth(probe, script_->pixel());
    look_at_ground(probe);
    for (int finger = 0; finger < settings.fingers; ++finger) {
        depths_.push_back(start_depth(probe, finger_pixel(finger)));
    }
    previous_.resize(offsets_.size());
}

/// The depth at or nearest to `pixel`; where nothing is to be seen, that of the device's centre.
double ScriptedHand::start_depth(const SurfaceProbe& probe, const glm::dvec2& pixel) const {
    const std::optional<SurfacePoint> found = nearest_surface(probe, pixel, settings_.box);
    return found ? found->depth : device_depth(settings_.workspace);
}

void ScriptedHand::goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) {
    assert(goals.size() == offsets_.size());
    if (tick > 0) script_->advance(ground_, probe);
    look_at_ground(probe);
    const double longest_step = settings_.max_speed * tick_s / settings_.workspace.metres_per_scene_unit;
    for (int finger = 0; finger < settings_.fingers; ++finger) {
        const auto f = static_cast<std::size_t>(finger);
        goals[f] = aim(finger, tick, probe);
        const glm::dvec3 step = goals[f] - previous_[f];
        const double length = glm::length(step);
        if (tick > 0 && length > longest_step) goals[f] = previous_[f] + step * (longest_step / length);
        previous_[f] = goals[f];
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

glm::dvec2 ScriptedHand::finger_pixel(int finger) const {
    const glm::dvec2 offset = offsets_[static_cast<std::size_t>(finger)] / ground_.metres_per_pixel;
    const glm::dvec2 pixel = script_->pixel() + glm::dvec2(offset.x, -offset.y);
    return glm::clamp(pixel, settings_.box.least, settings_.box.greatest);
}

glm::dvec3 ScriptedHand::aim(int finger, std::int64_t tick, const SurfaceProbe& probe) {
    const glm::dvec2 pixel = finger_pixel(finger);
    double& depth = depths_[static_cast<std::size_t>(finger)];
    depth = probe.depth_under(pixel.x, pixel.y).value_or(depth);
    const double to_come = std::max(0.0, 1 - static_cast<double>(tick) * tick_s / entry_s);
    const double under = script_->penetration(finger) - entry_height * to_come;  // device metres
    glm::dvec3 goal = probe.unproject(pixel.x, pixel.y, depth);
    goal.z = std::min(goal.z - under / settings_.workspace.metres_per_scene_unit, -nearest_goal * depth);
    return goal;
}

namespace {

using Kind = HandKey::Kind;
constexpr double millimetre = 0.001;

constexpr HandKey speed{"speed", "m/s", 0.001, 2, 0.1};
constexpr HandKey depth{"depth", "mm", 0, 50, 2};
constexpr HandKey lift{"lift", "mm", 0, 50, 2};
constexpr HandKey seed{"seed", "", 0, 0x1p53, 1, Kind::whole};
constexpr HandKey spread{"spread", "m", 0, 0.2, 0.02};
constexpr HandKey extent{"extent", "of the picture", 0.05, 1, 0.8};
constexpr HandKey max_speed{"max_speed", "m/s", 0.01, 10, 1};
constexpr HandKey angle{"angle", "degrees", -360, 360, 0};
constexpr HandKey x{"x", "of the picture's width", 0, 1, 0.5};
constexpr HandKey y{"y", "of the picture's height", 0, 1, 0.5};

constexpr std::array wander_keys{speed, depth, seed, spread, extent, max_speed};
constexpr std::array stroke_keys{speed, depth, angle, spread, extent, max_speed};
constexpr std::array press_keys{x, y, depth, lift, HandKey{"period", "s", 0.05, 60, 1}, spread, max_speed};
constexpr std::array poke_keys{speed, depth,  lift,   HandKey{"period", "s", 0.05, 60, 0.25},
                               seed,  spread, extent, max_speed};

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

}  // namespace

std::optional<Result<std::unique_ptr<Hand>>> make_scripted_hand(std::string_view name,
                                                                std::string_view options, int fingers,
                                                                const Workspace& workspace,
                                                                const SurfaceProbe& probe) {
    const std::span<const HandKey> keys = keys_of(name);
    if (keys.empty()) return std::nullopt;
    const Result<HandOptions> given = HandOptions::parse(name, options, keys);
    if (!given) return given.error();
    if (name != "press" && given->number(max_speed.name) < given->number(speed.name)) {
        return usage_error("hand '" + std::string(name) +
                           "': max_speed is below speed; raise it to at least speed");
    }
    const PixelBox box = middle_of(probe, name == "press" ? 1 : given->number(extent.name));
    const ScriptedHand::Settings settings{fingers, workspace, box, given->number(spread.name),
                                          given->number(max_speed.name)};
    std::unique_ptr<HandScript> script = make_script(name, *given, fingers, box, probe);
    return std::unique_ptr<Hand>(std::make_unique<ScriptedHand>(settings, std::move(script), probe));
}

}  // namespace touchable
