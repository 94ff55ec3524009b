// SPDX-License-Identifier: Apache-2.0
#include "device/hand.hpp"

#include <glm/geometric.hpp>
#include <numeric>

#include "device/hand_parts.hpp"
#include "device/point_motion.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

// ---- Scripts

constexpr double tick_s = 0.001;  // seconds from one tick to the next
/// A goal is the mean of a finger's last wishes, so that it moves as a hand does: wishes that keep a speed v
/// give goals with an acceleration of 2 v / 51 ms at most. Odd: the mean of a wave is in step with it.
constexpr int mean_ticks = 51;

/// The ground under the hand's centre at the previous tick.
struct Ground {
    glm::dvec2 metres_per_pixel;  ///< device metres that one pixel spans there, across and down
    bool surface;                 ///< whether there is a surface under that pixel
};

/// A scripted motion: a path of the hand's centre over the picture, and how deep each finger reaches.
class HandScript {
public:
    virtual ~HandScript() = default;
    /// Position of the hand's centre, pixels.
    virtual glm::dvec2 pixel() const = 0;
    /// Moves on by one tick.
    virtual void advance(const Ground& ground, const SurfaceProbe& probe) = 0;
    /// Whether the centre moves; if not, it stays over its pixel.
    virtual bool moves() const = 0;
    /// Device metres under the surface; negative: above it.
    virtual double penetration(int finger) const = 0;
};

double finger_phase(int finger, int fingers) {
    return 2 * pi * finger / fingers;
}

/// What the mean of `mean_ticks` leaves of a wave's amplitude.
double left_of_wave(double hertz) {
    const double half_turn = pi * hertz * tick_s;
    return sine(mean_ticks * half_turn) / (mean_ticks * sine(half_turn));
}

/// A wave twice as long as the mean is the shortest that a hand follows: a shorter period becomes this one.
constexpr double shortest_period = 0.1;  // seconds

/// The pixel step of `metres` of device space in direction (x right, y up).
glm::dvec2 pixel_step(const glm::dvec2& direction, double metres, const Ground& ground) {
    return glm::dvec2(direction.x, -direction.y) * metres / ground.metres_per_pixel;
}

/// A hand that glides along. Its penetration breathes about the mean, each finger in its own phase, so that
/// the force keeps changing and stays above zero.
class GlidingScript : public HandScript {
public:
    glm::dvec2 pixel() const final { return pixel_; }
    bool moves() const final { return true; }
    double penetration(int finger) const final {
        return depth_ * (1 + swing_ * sine(2 * pi * hertz * seconds_ + finger_phase(finger, fingers_)));
    }

protected:
    GlidingScript(double speed, double depth, int fingers, const HandArea& box)
        : speed_(speed),
          box_(box),
          pixel_(0.5 * (box.least + box.greatest)),
          depth_(depth),
          fingers_(fingers) {}
    void pass_tick() { seconds_ = static_cast<double>(++tick_) * tick_s; }

    const double speed_;  // m/s
    const HandArea box_;
    glm::dvec2 pixel_;
    double seconds_ = 0;

private:
    static constexpr double hertz = 0.9;

    const double depth_;  // mean, device metres
    const double swing_ = 3.0 / 7.0 / left_of_wave(hertz);
    const int fingers_;
    std::int64_t tick_ = 0;
};

/// Follows a heading that turns smoothly, from the surface nearest to the picture's centre, reflected at the
/// box. After straying too far over pixels without a surface, it turns back to its last one with a surface.
class Wander final : public GlidingScript {
public:
    Wander(double speed, double depth, std::uint64_t seed, int fingers, const HandArea& box,
           const SurfaceProbe& probe)
        : GlidingScript(speed, depth, fingers, box) {
        if (const auto start = nearest_surface(probe, pixel_, box)) pixel_ = start->pixel;
        home_ = pixel_;
        SplitMix64 random(seed);
        heading_ = 2 * pi * random.unit();
        turn_phase_ = 2 * pi * random.unit();
    }

    void advance(const Ground& ground, const SurfaceProbe&) override {
        keep_near_the_surface(ground);
        const double turn = 0.9 * sine(2 * pi * 0.37 * seconds_ + turn_phase_) + 0.4;  // rad/s
        heading_ += turn * tick_s;
        pixel_ += pixel_step({cosine(heading_), sine(heading_)}, speed_ * tick_s, ground);
        if (reflect(pixel_.x, box_.least.x, box_.greatest.x)) heading_ = pi - heading_;
        if (reflect(pixel_.y, box_.least.y, box_.greatest.y)) heading_ = -heading_;
        pass_tick();
    }

private:
    static constexpr double shortest_leash = 0.01;  // device metres

    /// A clip may lack a surface over nearly half of its picture, in a few large holes, in which a hand would
    /// feel nothing for seconds. The leash grows with every turn, so that the hand finds a surface that has
    /// moved away.
    void keep_near_the_surface(const Ground& ground) {
        if (ground.surface) {
            home_ = pixel_;
            leash_ = shortest_leash;
            strayed_ = 0;
            return;
        }
        strayed_ += speed_ * tick_s;
        if (strayed_ < leash_) return;
        const glm::dvec2 way = (home_ - pixel_) * ground.metres_per_pixel;
        heading_ = arctangent2(-way.y, way.x);
        leash_ = 2 * leash_;
        strayed_ = 0;
    }

    static bool reflect(double& x, double least, double greatest) {
        if (x >= least && x <= greatest) return false;
        const double mirrored = x < least ? least + (least - x) : greatest - (x - greatest);
        x = std::clamp(mirrored, least, greatest);
        return true;
    }

    glm::dvec2 home_{0, 0};  // the last pixel with a surface
    double heading_ = 0;     // radians counter-clockwise from the right
    double turn_phase_ = 0;
    double leash_ = shortest_leash;
    double strayed_ = 0;  // device metres since home, or since the last turn
};

/// Goes back and forth in a straight line through the box's centre, turning at the box.
class Stroke final : public GlidingScript {
public:
    /// `angle`: radians counter-clockwise from the picture's right.
    Stroke(double speed, double depth, double angle, int fingers, const HandArea& box)
        : GlidingScript(speed, depth, fingers, box), direction_(cosine(angle), sine(angle)) {}

    void advance(const Ground& ground, const SurfaceProbe&) override {
        glm::dvec2 step = pixel_step(direction_, speed_ * tick_s, ground);
        if (!box_.contains(pixel_ + step)) {
            direction_ = -direction_;
            step = -step;
        }
        if (box_.contains(pixel_ + step)) pixel_ += step;
        pass_tick();
    }

private:
    glm::dvec2 direction_;
};

struct PressSettings {
    glm::dvec2 pixel;
    double depth;   ///< greatest, device metres
    double lift;    ///< greatest height above the surface, device metres
    double period;  ///< seconds
};
/// Stays over one pixel, swinging between `lift` above and `depth` under the surface.
class Press final : public HandScript {
public:
    Press(const PressSettings& settings, int fingers) : settings_(settings), fingers_(fingers) {}

    glm::dvec2 pixel() const override { return settings_.pixel; }
    bool moves() const override { return false; }

    void advance(const Ground&, const SurfaceProbe&) override { ++tick_; }

    double penetration(int finger) const override {
        const double seconds = static_cast<double>(tick_) * tick_s;
        const double wave = cosine(2 * pi * seconds / settings_.period + finger_phase(finger, fingers_));
        return 0.5 * (settings_.depth - settings_.lift) - swing_ * wave;
    }

private:
    const PressSettings settings_;
    const double swing_ = 0.5 * (settings_.depth + settings_.lift) / left_of_wave(1 / settings_.period);
    int fingers_;
    std::int64_t tick_ = 0;
};

struct PokeSettings {
    double speed;   ///< between pokes, m/s
    double depth;   ///< greatest, device metres
    double lift;    ///< height above the surface between pokes, device metres
    double period;  ///< seconds; one poke in and out
    std::uint64_t seed;
};
/// Pokes at random pixels of the box that have a surface, the fingers shortly after one another, and travels
/// straight from one to the next above the surface. It rests before and after a poke until the goals have
/// come after, so that no finger slides inside.
class Poke final : public HandScript {
public:
    Poke(const PokeSettings& settings, int fingers, const HandArea& box, const SurfaceProbe& probe)
        : settings_(settings), fingers_(fingers), box_(box), random_(settings.seed) {
        pixel_ = next_target(probe);
        target_ = pixel_;
    }

    glm::dvec2 pixel() const override { return pixel_; }
    bool moves() const override { return pixel_ != target_ || there_ <= mean_ticks; }

    void advance(const Ground& ground, const SurfaceProbe& probe) override {
        if (pixel_ != target_) {
            travel(ground);
        } else if (++there_ > 2 * mean_ticks + poke_ticks()) {
            target_ = next_target(probe);
            there_ = 0;
        }
    }

    double penetration(int finger) const override {
        const double begun = static_cast<double>(there_ - mean_ticks) * tick_s - delay(finger);
        const double share = std::clamp(begun / settings_.period, 0.0, 1.0);
        return stroke_ * (1 - cosine(2 * pi * share)) - settings_.lift;
    }

private:
    /// Fingers poke within half a period of one another.
    double delay(int finger) const { return 0.5 * settings_.period * finger / fingers_; }

    std::int64_t poke_ticks() const {
        return static_cast<std::int64_t>(std::ceil((settings_.period + delay(fingers_ - 1)) / tick_s));
    }

    void travel(const Ground& ground) {
        const glm::dvec2 way = (target_ - pixel_) * ground.metres_per_pixel;
        const double left = glm::length(way);
        const double step = settings_.speed * tick_s;
        pixel_ = left <= step ? target_ : pixel_ + (target_ - pixel_) * (step / left);
    }

    /// A random pixel with a surface under it; any pixel after 64 without one.
    glm::dvec2 next_target(const SurfaceProbe& probe) {
        glm::dvec2 pixel{};
        for (int attempt = 0; attempt < 64; ++attempt) {
            const double across = random_.unit();
            const double down = random_.unit();
            pixel = box_.least + (box_.greatest - box_.least) * glm::dvec2(across, down);
            if (probe.depth_under(pixel.x, pixel.y)) break;
        }
        return pixel;
    }

    const PokeSettings settings_;
    // Half of the way in, device metres.
    const double stroke_ = (settings_.depth + settings_.lift) / (1 + left_of_wave(1 / settings_.period));
    int fingers_;
    HandArea box_;
    SplitMix64 random_;
    glm::dvec2 pixel_{0, 0};
    glm::dvec2 target_{0, 0};
    std::int64_t there_ = 0;  // ticks at the target; 0 while travelling
};

// ---- Fingers that follow a script

/// Fingers that follow a script over any surface: on a circle about the script's pixel, each with its own
/// penetration along -Z behind the surface under it. A finger rises over broken ground before it crosses it,
/// and the script waits for it; on rough ground it hops now and then, so that its proxy does not stay behind.
///
/// Each finger has a wish, which goes there at `max_speed` at most and may stop dead; its goal is the mean of
/// the wish's last `mean_ticks`. A mean cuts corners: so a wish rests at the corners of a wall.
class ScriptedHand final : public Hand {
public:
    struct Settings {
        int fingers;
        Workspace workspace;
        HandArea box;      ///< limits of all fingers; a finger glides along its edge
        double spread;     ///< radius of the fingers' circle, device metres
        double speed;      ///< speed of the script, m/s of device space
        double max_speed;  ///< limit for a goal, m/s of device space
        double glide;      ///< distance over rough ground before a hop, device metres
    };

    ScriptedHand(const Settings& settings, std::unique_ptr<HandScript> script, const SurfaceProbe& probe)
        : settings_(settings), look_(reach + settings.speed * tick_s), script_(std::move(script)) {
        // From a stop, a mean of n ticks has gone v t^2 / (2 n) in t ticks: `look_` in the rest of the n.
        const double step = settings.speed * tick_s + 1e-9;
        pause_ = std::max(0, mean_ticks - static_cast<int>(std::sqrt(2 * mean_ticks * look_ / step)));
        const auto start = nearest_surface(probe, script_->pixel(), settings.box);
        centre_depth_ = start ? start->depth : device_depth(settings.workspace);
        look_at_ground(probe);
        for (int k = 0; k < settings.fingers; ++k) {
            Finger finger{.offset = finger_offset(k, settings.fingers, settings.spread)};
            // A search of the whole box finds no more for a finger than it did for the centre.
            finger.depth = start ? start_depth(probe, finger_pixel(finger), settings.box, settings.workspace)
                                 : centre_depth_;
            finger.wish = aim(finger, script_->penetration(k), entry_height, probe);
            finger.wishes.fill(finger.wish);
            fingers_.push_back(finger);
        }
    }

    int fingers() const override { return settings_.fingers; }
    bool hops(std::size_t finger) const override { return fingers_[finger].hopping > 0; }
    void goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) override {
        assert(goals.size() == fingers_.size());
        const bool moves = tick > 0 && !waits_;
        if (moves) script_->advance(ground_, probe);
        if (!waits_) look_at_ground(probe);
        waits_ = false;
        oldest_ = (oldest_ + 1) % mean_ticks;
        const double to_come = std::max(0.0, 1 - static_cast<double>(tick) * tick_s / entry_s);
        for (std::size_t k = 0; k < fingers_.size(); ++k) {
            Finger& finger = fingers_[k];
            if (moves) finger.glided += settings_.speed * tick_s;
            const double penetration = script_->penetration(static_cast<int>(k));
            const bool there = move(finger, aim(finger, penetration, entry_height * to_come, probe));
            waits_ = rest(finger, there) || waits_;
            finger.hopping = finger.lift == Lift::none ? std::max(finger.hopping - 1, 0) : mean_ticks;
            finger.wishes[oldest_] = finger.wish;
            const auto& wishes = finger.wishes;
            goals[k] = std::accumulate(wishes.begin(), wishes.end(), glm::dvec3(0.0)) / double{mean_ticks};
        }
    }

private:
    static constexpr double entry_s = 0.199;      // a wish comes down in this time, its goal in 0.25 s ...
    static constexpr double entry_height = 0.05;  // ... from this far above, device metres
    static constexpr double settling_s = 0.1;     // time constant of the depth at which pixels are measured
    static constexpr double reach = 0.0006;       // how far around itself a finger looks, device metres
    static constexpr double clearance = 0.001;    // height of a finger over broken ground, device metres
    static constexpr double sinking = 0.02;       // m/s, of a finger over broken ground that falls away
    // A wish stays up over rough ground for so many ticks, and so a goal for 40.
    static constexpr int hop_ticks = mean_ticks + 40;
    // The script waits for a finger that is farther from its target, device metres.
    static constexpr double greatest_lag = 0.00025;
    // A goal stays this share of the surface's depth in front of the camera.
    static constexpr double nearest_goal = 0.1;

    /// `landing`: over firm ground again, but still lifted.
    enum class Lift { none, over_rough, over_broken, landing };
    struct Finger {
        glm::dvec2 offset{0.0};  // from the hand's centre, device metres, x right, y up
        double depth = 0;        // planar, scene units: of the surface under it, or the last known
        glm::dvec3 wish{0.0};    // at the previous tick
        std::array<glm::dvec3, mean_ticks> wishes{};  // the last ones
        Lift lift = Lift::none;
        // Least planar depth near its path since it was lifted or reached rough ground.
        std::optional<double> ridge{};
        double glided = 0;  // since then, device metres
        int resting = 0;    // ticks to come, in which the wish stays at its height
        int hopping = 0;    // ticks to come, in which the goal still has a part of the lift
    };
    /// Reference depth of a finger.
    struct Stance {
        double depth;  // planar, scene units
        bool firm;     // whether it may go behind `depth`
    };

    /// The depth at which pixels are measured follows the surface slowly, or all fingers would jerk sideways
    /// whenever the centre crosses a silhouette.
    void look_at_ground(const SurfaceProbe& probe) {
        const glm::dvec2 pixel = script_->pixel();
        const std::optional<double> seen = probe.depth_under(pixel.x, pixel.y);
        if (seen) centre_depth_ += (*seen - centre_depth_) * (tick_s / settling_s);
        ground_.surface = seen.has_value();
        ground_.metres_per_pixel =
            pixel_size(probe, pixel, centre_depth_, settings_.workspace.metres_per_scene_unit);
    }

    glm::dvec2 finger_pixel(const Finger& finger) const {
        const glm::dvec2 offset = finger.offset / ground_.metres_per_pixel;
        const glm::dvec2 pixel = script_->pixel() + glm::dvec2(offset.x, -offset.y);
        return glm::clamp(pixel, settings_.box.least, settings_.box.greatest);
    }

    /// A moving finger considers the ground around it; one that stays over its pixel considers only that.
    Stance stance(Finger& finger, const glm::dvec2& pixel, const SurfaceProbe& probe) const {
        const std::optional<double> under = probe.depth_under(pixel.x, pixel.y);
        finger.depth = under.value_or(finger.depth);
        if (!script_->moves()) {
            put_down(finger);
            return {finger.depth, under.has_value()};
        }
        const LocalRelief relief = local_relief(probe, pixel, finger.depth, look_,
                                                settings_.workspace.metres_per_scene_unit, settings_.box);
        if (!under || relief.kind == LocalRelief::Kind::broken) {
            const double sunk = sinking * tick_s / settings_.workspace.metres_per_scene_unit;
            finger.ridge = std::min(finger.ridge.value_or(relief.highest) + sunk, relief.highest);
            finger.lift = Lift::over_broken;
        } else if (finger.lift == Lift::over_broken) {
            finger.lift = Lift::landing;
            finger.resting = pause_;
        } else if (finger.lift != Lift::none && finger.resting == 0) {
            put_down(finger);
        } else {
            glide(finger, relief);
        }
        return finger.lift == Lift::none ? Stance{finger.depth, true} : Stance{*finger.ridge, false};
    }

    static void put_down(Finger& finger) {
        finger.lift = Lift::none;
        finger.ridge.reset();
    }

    void glide(Finger& finger, const LocalRelief& relief) const {
        if (relief.kind == LocalRelief::Kind::rough && !finger.ridge) {
            finger.ridge = relief.highest;
            finger.glided = 0;
        }
        if (!finger.ridge) return;
        finger.ridge = std::min(*finger.ridge, relief.highest);
        if (finger.lift != Lift::none || finger.glided <= settings_.glide) return;
        finger.lift = Lift::over_rough;
        finger.resting = hop_ticks;
    }

    /// Counts the ticks that a lifted finger stays at its height; returns whether the script waits for the
    /// finger. Over broken ground it waits until the goal has risen before the wall, and again until the goal
    /// has left the wall, before it comes down.
    bool rest(Finger& finger, bool there) const {
        if (finger.lift == Lift::none) return !there;
        if (there) finger.resting = std::max(0, finger.resting - 1);
        if (finger.lift == Lift::over_rough) return false;
        if (!there) finger.resting = pause_;
        return !there || finger.resting > 0;
    }

    /// `penetration` along -Z over firm ground. Over other ground, or with `height` still to come down, the
    /// goal is lifted along its pixel's ray, on which there is nothing else.
    glm::dvec3 aim(Finger& finger, double penetration, double height, const SurfaceProbe& probe) const {
        const double metres_per_unit = settings_.workspace.metres_per_scene_unit;
        const glm::dvec2 pixel = finger_pixel(finger);
        const auto [depth, firm] = stance(finger, pixel, probe);
        const double lift = height + (firm ? 0 : std::max(-penetration, clearance));
        const double nearest = nearest_goal * depth;
        glm::dvec3 goal =
            probe.unproject(pixel.x, pixel.y, std::max(depth - lift / metres_per_unit, nearest));
        if (firm) goal.z = std::min(goal.z - penetration / metres_per_unit, -nearest);
        return goal;
    }

    /// Moves the finger's wish to `target`, by less than a tick's distance; returns whether it is nearly
    /// there.
    bool move(Finger& finger, const glm::dvec3& target) const {
        const glm::dvec3 way = target - finger.wish;
        const double length = glm::length(way) * settings_.workspace.metres_per_scene_unit;
        const double longest = settings_.max_speed * tick_s * (1 - 1e-6);  // below it, rounded or not
        finger.wish = length > longest ? finger.wish + way * (longest / length) : target;
        return length - longest <= greatest_lag;
    }

    Settings settings_;
    double look_;  // how far it looks for relief, device metres
    std::unique_ptr<HandScript> script_;
    Ground ground_{};
    int pause_;            // ticks that a wish rests at a wall's corner, so that its goal does not cut it
    double centre_depth_;  // planar, scene units: depth at which pixels are measured
    std::vector<Finger> fingers_;
    std::size_t oldest_ = 0;  // of the wishes
    bool waits_ = false;      // the script waits for a finger that lags behind its target
};

using Key = KeyedValues::Key;
constexpr double millimetre = 0.001;

namespace hand_keys {
constexpr Key speed{"speed", "m/s", 0.001, 2, 0.1};
constexpr Key depth{"depth", "mm", 0, 50, 2};
constexpr Key lift{"lift", "mm", 0, 50, 2};
constexpr Key seed{"seed", "", 0, 0x1p53, 1, Key::Kind::whole};
constexpr Key spread{"spread", "m", 0, 0.2, 0.02};
constexpr Key extent{"extent", "of the picture", 0.05, 1, 0.8};
constexpr Key max_speed{"max_speed", "m/s", 0.01, 10, 0.5};
constexpr Key glide{"glide", "mm", 0, 1e6, 5};
constexpr Key angle{"angle", "degrees", -360, 360, 0};
constexpr Key x{"x", "of the picture's width", 0, 1, 0.5};
constexpr Key y{"y", "of the picture's height", 0, 1, 0.5};

constexpr std::array wander{speed, depth, seed, spread, extent, max_speed, glide};
constexpr std::array stroke{speed, depth, angle, spread, extent, max_speed, glide};
constexpr std::array press{x, y, depth, lift, Key{"period", "s", 0.05, 60, 1}, spread, max_speed};
constexpr std::array poke{speed,  depth,     lift, Key{"period", "s", 0.05, 60, 0.25}, seed, spread,
                          extent, max_speed, glide};
}  // namespace hand_keys

constexpr struct Script {
    std::string_view name;
    std::span<const Key> keys;
} scripts[] = {{"wander", hand_keys::wander},
               {"stroke", hand_keys::stroke},
               {"press", hand_keys::press},
               {"poke", hand_keys::poke}};

std::unique_ptr<HandScript> make_script(std::string_view name, const KeyedValues& given, int fingers,
                                        const HandArea& box, const SurfaceProbe& probe) {
    using namespace hand_keys;
    const auto metres = [&](const Key& key) { return given.number(key.name) * millimetre; };
    const auto number = [&](const Key& key) { return given.number(key.name); };
    const auto whole = [&](const Key& key) { return static_cast<std::uint64_t>(given.number(key.name)); };
    if (name == "wander")
        return std::make_unique<Wander>(number(speed), metres(depth), whole(seed), fingers, box, probe);
    if (name == "stroke")
        return std::make_unique<Stroke>(number(speed), metres(depth), number(angle) * pi / 180, fingers, box);
    const double period = std::max(given.number("period"), shortest_period);
    if (name == "press") {
        const glm::dvec2 last(probe.width() - 1, probe.height() - 1);
        return std::make_unique<Press>(
            PressSettings{glm::dvec2(number(x), number(y)) * last, metres(depth), metres(lift), period},
            fingers);
    }
    return std::make_unique<Poke>(
        PokeSettings{number(speed), metres(depth), metres(lift), period, whole(seed)}, fingers, box, probe);
}

/// Makes a hand of that name with these keys. Refuses unknown keys and values out of range.
Result<std::unique_ptr<Hand>> make_scripted_hand(const std::string& name, std::span<const Key> keys,
                                                 std::string_view options, int fingers,
                                                 const Workspace& workspace, const SurfaceProbe& probe) {
    using namespace hand_keys;
    TRY_ASSIGN(const auto given, KeyedValues::parse("hand '" + name + "'", options, keys));
    const bool presses = name == "press";
    if (!presses && given.number(max_speed.name) < given.number(speed.name))
        return usage_error("hand '" + name + "': max_speed=" + exact_number(given.number(max_speed.name)) +
                           " is below speed; give max_speed=" + exact_number(given.number(speed.name)) +
                           " or more");
    const HandArea box = middle_of(probe, presses ? 1 : given.number(extent.name));
    const ScriptedHand::Settings settings{fingers,
                                          workspace,
                                          box,
                                          given.number(spread.name),
                                          presses ? 0 : given.number(speed.name),
                                          given.number(max_speed.name),
                                          presses ? 0 : given.number(glide.name) * millimetre};
    return std::make_unique<ScriptedHand>(settings, make_script(name, given, fingers, box, probe), probe);
}

}  // namespace

std::vector<std::string> hand_words() {
    std::vector<std::string> words;
    for (const auto& script : scripts) words.emplace_back(script.name);
    words.insert(words.end(), {"csv:FILE", "rec:FILE"});
    return words;
}

Result<std::unique_ptr<Hand>> make_hand(const std::string& description, int fingers,
                                        const Workspace& workspace, const SurfaceProbe& probe) {
    constexpr int most_fingers = 256;
    if (fingers < 1 || fingers > most_fingers)
        return usage_error("a hand has 1 to " + std::to_string(most_fingers) + " fingers, not " +
                           std::to_string(fingers));
    const auto [name, rest] = KeyedValues::name_and_pairs(description);
    const Script* const script = named_in(scripts, name, &Script::name);
    if (name != "csv" && script == nullptr)
        return usage_error("unknown hand '" + printable(name) + "'; must be one of " + listed(hand_words()));
    auto hand = script ? make_scripted_hand(std::string(name), script->keys, rest, fingers, workspace, probe)
                       : make_recorded_hand(rest, fingers, workspace, probe);
    if (hand && stop_requested()) return interrupted_error();  // its beginning was cut short
    return hand;
}

}  // namespace touchable
