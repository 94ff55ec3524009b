// SPDX-License-Identifier: Apache-2.0
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "haptics_cpu/touch_step.hpp"
#include "tests/reference/solver.hpp"
#include "tests/stress/watch.hpp"

namespace touchable::stress {
namespace {

double percent(std::int64_t part, std::int64_t whole) {
    return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

}  // namespace

void Coverage::add(const Coverage& o) {
    for (const auto sum :
         {&Coverage::ticks, &Coverage::finger_ticks, &Coverage::contact, &Coverage::with_heights,
          &Coverage::with_friction, &Coverage::sliding, &Coverage::at_invalid, &Coverage::in_holes,
          &Coverage::landings, &Coverage::departures, &Coverage::frame_changes, &Coverage::between_frames,
          &Coverage::held_goals, &Coverage::refusals, &Coverage::capped, &Coverage::certified,
          &Coverage::compared, &Coverage::other_basins})
        this->*sum += o.*sum;
    most_events = std::max(most_events, o.most_events);
    for (const auto worst :
         {&Coverage::worst_behind, &Coverage::worst_excess, &Coverage::worst_way, &Coverage::worst_ratio,
          &Coverage::worst_angle, &Coverage::energy_created, &Coverage::energy_bound})
        this->*worst = std::max(this->*worst, o.*worst);
}

double Coverage::contact_share() const {
    return percent(contact, finger_ticks) / 100;
}

std::string Coverage::missing(const Needs& needs) const {
    if (contact_share() < needs.contact) {
        std::array<char, 96> text;
        std::snprintf(text.data(), text.size(), "contact in %.1f %% of ticks only, %.0f %% are needed",
                      100 * contact_share(), 100 * needs.contact);
        return text.data();
    }
    if (needs.frame_changes && frame_changes == 0) return "no frame changed";
    if (needs.refusals && refusals == 0) return "nothing impossible was refused";
    if (needs.held_goals && held_goals == 0) return "every goal was a number";
    if (certified == 0 && contact > capped) return "no tick was certified";
    return {};
}

std::string Coverage::in_words() const {
    std::array<char, 512> text;
    std::snprintf(
        text.data(), text.size(),
        "contact %.1f %%, landings %lld, departures %lld; of contact: heights %.0f %%, friction %.0f %% "
        "(sliding %.0f %%), at invalid pixels %.1f %%, hole stiffness %.1f %%; frame changes %lld, between "
        "frames %.0f %%, "
        "held goals %lld, refusals %lld; most events %lld, capped %lld; "
        "certified %lld (way left %.1e, behind %.1e), "
        "compared %lld (other basins %lld, distance x %.9f, angle %.1e deg); "
        "energy created %.3g of at most %.3g mJ",
        100 * contact_share(), static_cast<long long>(landings), static_cast<long long>(departures),
        percent(with_heights, contact), percent(with_friction, contact), percent(sliding, contact),
        percent(at_invalid, certified), percent(in_holes, certified), static_cast<long long>(frame_changes),
        percent(between_frames, ticks), static_cast<long long>(held_goals), static_cast<long long>(refusals),
        static_cast<long long>(most_events), static_cast<long long>(capped),
        static_cast<long long>(certified), worst_way, worst_behind, static_cast<long long>(compared),
        static_cast<long long>(other_basins), worst_ratio, worst_angle, 1000 * energy_created,
        1000 * energy_bound);
    return text.data();
}

}  // namespace touchable::stress
namespace touchable::stress {
namespace {

using reference::Surface;

constexpr std::size_t kept_violations = 20;
// Room for the roundings of doubles: the worst of tens of millions of ticks were 1e-11, 1e-12 and 3e-9, but
// for fields that come as close to the camera as a rounding (rounding_at).
constexpr double behind_tolerance = 1e-9, excess_tolerance = 1e-9, way_tolerance = 1e-7;
constexpr double ratio_tolerance = 1.0001, angle_tolerance = 1e-7;

double length(const glm::dvec3& v) {
    return std::sqrt(glm::dot(v, v));
}

/// How far a force is from those that `own` allows: no longer than it, and with no component against it.
double forbidden(const glm::dvec3& force, const glm::dvec3& own) {
    const double squared = glm::dot(own, own);
    if (squared == 0) return length(force);
    const glm::dvec3 with = force - own * (std::min(0.0, glm::dot(force, own)) / squared);
    return length(force - with * std::min(1.0, std::sqrt(squared) / std::max(length(with), 1e-12)));
}

/// The force of a surface that jumped, at this stiffness at most.
glm::dvec3 jumped_to(const Contact& contact, double most) {
    const double there = contact.carried_stiffness.value_or(contact.properties.stiffness);
    return contact.jumped_force * (there > 0 ? std::min(1.0, most / there) : 1.0);
}

/// The law of steps (docs/solver.md, Sudden change), of one finger.
struct Steps {
    glm::dvec3 sent{0.0}, own{0.0}, goal{0.0};  // of the tick before; own: the solver's
    double share = 1;                           // of its own force that the hand got
    double ramp = 0, last_ramp = 0;             // the guard's
    double missed = 0;                          // N of changes without a goal
    double stiffness = 0, risen = 1;            // N/m in effect; its share of the map's
    bool near_hole = false, rises = false;      // stiffness is a hole's in part; it rose, limited or not
    std::uint32_t reasons = 0;
    int missing = 0;  // ticks without a goal

    /// By how much the force that is sent may change in this tick, newtons: by what the hand's motion (twice:
    /// a proxy that slides or turns moves as well) and the hand's share of all other changes explain, the
    /// fade, and what the solver's force does not allow any more. Takes over the tick.
    double most(const Contact& contact, const GuardedForce& out, const GuardSettings& device, double scale) {
        const double steepest = 1.5 / JumpCancellation::fade_ticks, map = contact.properties.stiffness,
                     x = scale * length(contact.proxy - contact.goal),
                     stored = ramp > 0 && x > 0 ? out.energy.stored / ramp : 0;
        // The stiffness in effect, by the energy that the spring stores; without a goal as before.
        double k = std::min(map, device.max_stiffness);
        if (stored > 0)
            k = std::min(k, DeviceSpring{device.max_stiffness, device.max_force}.stiffness(stored, x * x));
        else if (contact.goal_held)
            k *= risen;
        risen = map > 0 ? k / map : 1;
        const bool is_rising = (out.reasons & guard_rise) != 0;  // k is rounded
        const glm::dvec3 force = risen * contact.force,
                         from =
                             contact.jumped ? jumped_to(contact, is_rising ? k : device.max_stiffness) : own;
        const double whole = std::min(length(from), device.max_force);
        share = std::min(1.0, whole > 0 ? length(sent) / whole : share + steepest);
        missed += share * length(force - from);
        // Near a hole all forces fall with the stiffness.
        if (std::exchange(near_hole, contact.hole_share > 0) || near_hole)
            missed += length(sent) * (k < stiffness ? 1 - k / stiffness : 0.0);
        missing = contact.goal_held ? missing + 1 : 0;
        if (missing == 0) last_ramp = ramp;
        double most = steepest * device.max_force;
        if ((out.reasons | reasons) & (guard_ramp | guard_fault))
            most += device.max_force / std::min(device.ramp_in_ticks, device.ramp_out_ticks);
        const bool is_limited = ((out.reasons | reasons) & guard_rise) != 0;
        rises = is_limited || k > stiffness * (1 + 1e-9);
        if (is_limited) most += std::min(device.rise.per_tick, 1e6) * x;
        if (missing == 0) {
            most += 2 * k * scale * length(contact.goal - goal) + forbidden(sent, ramp * force) +
                    std::exchange(missed, 0.0);
            ramp = std::min(1.0, ramp + 1.0 / device.ramp_in_ticks);
        } else {
            ramp = last_ramp * std::max(0.0, 1.0 - 1.0 * missing / device.ramp_out_ticks);
        }
        stiffness = k;
        sent = out.force;
        own = force;
        goal = contact.goal;
        reasons = out.reasons;
        return most;
    }
};

/// One run under watch.
class Watch {
public:
    Watch(StressRun& run, const WatchSettings& settings) : run_(run), settings_(settings) {}

    Watched watch(TickSink* sink) {
        const auto solver = TouchSolver::create(run_.scene(), run_.touch());
        if (!solver) {
            violate(0, 0, "no solver: " + solver.error().message);
            return std::move(out_);
        }
        TouchStep step(*solver, run_.guard(), static_cast<int>(run_.fingers()));
        energy_.resize(run_.fingers());
        steps_.resize(run_.fingers());
        std::vector<FingerState> before(run_.fingers());
        FramePair pair;
        std::int64_t last_number = -1;
        for (std::int64_t tick = 0; tick < settings_.ticks; ++tick) {
            run_.next(tick, pair, step.goals());
            std::copy(step.states().begin(), step.states().end(), before.begin());
            const TouchTick done = step.run(tick, tick * tick_ns, run_.scene(), pair);
            covered().ticks += 1;
            covered().frame_changes += tick > 0 && pair.prev.number != last_number;
            covered().between_frames += done.blend > 0;
            last_number = pair.prev.number;
            const Surface surface(run_.scene(), pair);
            for (std::size_t k = 0; k < before.size(); ++k)
                look(surface, done, before[k], step.states()[k], k);
            if (std::string broken = run_.broken_promise(tick, done.contacts, done.forces); !broken.empty())
                violate(tick, 0, "promise: " + broken);
            if (sink) sink->take(done, step.states());
        }
        covered().refusals = run_.refusals();
        out_.force_hash = hash_.hex();
        return std::move(out_);
    }

private:
    Coverage& covered() { return out_.coverage; }

    void violate(std::int64_t tick, std::size_t finger, const std::string& what) {
        ++out_.violation_count;
        if (out_.violations.size() < kept_violations)
            out_.violations.push_back("tick " + std::to_string(tick) + ", finger " + std::to_string(finger) +
                                      ": " + what);
    }
    /// Written so that NaN is a violation.
    void expect_at_most(double value, double most, const TouchTick& done, std::size_t k, const char* what) {
        if (value <= most) return;
        char text[160];
        std::snprintf(text, sizeof text, "%s is %.17g, at most %.3g", what, value, most);
        violate(done.tick, k, text);
    }

    void look(const Surface& surface, const TouchTick& done, const FingerState& before,
              const FingerState& after, std::size_t k) {
        const Contact& contact = done.contacts[k];
        hash_.add(done.forces[k].force);
        count(contact, before, after);
        check_force(done, k);
        check_energy(done, k);
        if (!after.started) return;
        const auto behind = static_cast<double>(reference::depth_behind(surface, contact.proxy));
        covered().worst_behind = std::max(covered().worst_behind, behind);
        if (!(behind <= behind_tolerance)) {
            const auto rounding = static_cast<double>(reference::rounding_at(surface, contact.proxy));
            expect_at_most(behind, behind_tolerance - rounding / contact.proxy.z, done, k,
                           "S1: relative depth behind the surface");
        }
        if (contact.counts.capped) return;
        if (contact.touching && settings_.certify_every > 0 && done.tick % settings_.certify_every == 0)
            certify(surface, done, after.proxy, k);
        // The reference knows no other way than the ray.
        if (settings_.compare_every > 0 && done.tick % settings_.compare_every == 0 && before.started &&
            !contact.off_its_ray)
            compare(surface, done, before.proxy, after.proxy, k);
    }

    void count(const Contact& contact, const FingerState& before, const FingerState& after) {
        Coverage& c = covered();
        ++c.finger_ticks;
        c.contact += contact.touching;
        c.landings += contact.touching && !before.proxy.on_surface();
        c.departures += !contact.touching && before.proxy.on_surface();
        c.with_heights += contact.touching && run_.scene().height_coding.max_height > 0;
        c.with_friction += contact.touching && contact.properties.static_friction > 0;
        c.sliding += after.proxy.sliding;
        c.held_goals += contact.goal_held;
        c.capped += contact.counts.capped;
        c.most_events = std::max<std::int64_t>(c.most_events, contact.counts.events);
    }

    void check_force(const TouchTick& done, std::size_t k) {
        const Contact& contact = done.contacts[k];
        const double force = length(done.forces[k].force), most = run_.guard().max_force;
        expect_at_most(force, most * (1 + 1e-12), done, k, "S4: the guarded force");
        if (!std::isfinite(length(contact.proxy)) || !std::isfinite(length(contact.force)))
            violate(done.tick, k, "S3: proxy or force is not finite");
        if (!contact.touching && length(contact.force) != 0)
            violate(done.tick, k, "S4: a force without contact");
        expect_at_most(contact.counts.events, run_.touch().event_limit, done, k, "S5: the number of events");
        const double step = length(done.forces[k].force - steps_[k].sent);
        const double allowed =
            steps_[k].most(contact, done.forces[k], run_.guard(), run_.touch().metres_per_scene_unit);
        expect_at_most(step, allowed + 1e-9 * (1 + length(contact.force)), done, k, "S9: the step of force");
    }

    /// Energy created in a tick; a stiffness that differs from place to place may create some and take it
    /// back.
    void check_energy(const TouchTick& done, std::size_t k) {
        const EnergyFigures now = done.forces[k].energy, last = std::exchange(energy_[k], now);
        // Roundings of sums of joules, and of the proxy's coordinates times its force.
        const Contact& contact = done.contacts[k];
        const double rounding =
            1e-12 * (1e-6 + std::fabs(now.work) + std::fabs(now.surface) + now.stored) + 4e-15 * now.bound +
            1e-15 * length(contact.proxy) * done.metres_per_scene_unit * length(contact.force);
        covered().energy_created = std::max(covered().energy_created, now.created);
        covered().energy_bound = std::max(covered().energy_bound, now.bound);
        if (run_.guard().rise.paid)
            expect_at_most(now.created, now.bound + rounding, done, k, "S7: joules from nowhere");
        else if (done.pair.prev.frame->haptic.empty() && done.pair.next.frame->haptic.empty() &&
                 !run_.scene().hole_stiffness && !steps_[k].rises)
            expect_at_most(now.balance() - last.balance(), now.bound - last.bound + rounding, done, k,
                           "S7: joules from nowhere in a tick");
    }

    void certify(const Surface& surface, const TouchTick& done, const Proxy& proxy, std::size_t k) {
        const Contact& contact = done.contacts[k];
        Coverage& c = covered();
        ++c.certified;
        c.in_holes += contact.hole_share > 0;
        check_stiffness(surface, done, proxy, k);
        for (const auto& part : reference::place_of(surface, proxy).parts)
            if (part.weight > 0 && !surface.vertex(part.corner).valid) {
                ++c.at_invalid;
                break;
            }
        const double unit = 1 + length(contact.proxy - contact.goal);
        // Only where a tolerance is not kept is it asked what doubles can tell there.
        const auto expect_kept = [&](double value, double tolerance, const char* what) {
            if (value <= tolerance) return;
            const auto rounding = static_cast<double>(reference::rounding_at(surface, contact.proxy)) / unit;
            expect_at_most(value, tolerance + rounding, done, k, what);
        };
        const auto way = static_cast<double>(reference::way_left(surface, proxy, contact.goal)) / unit;
        c.worst_way = std::max(c.worst_way, way);
        expect_kept(way, way_tolerance, "S2: the way left to go");
        if (contact.properties.static_friction > 0) return;
        const auto excess =
            static_cast<double>(reference::excess_over_minimum(surface, proxy, contact.goal)) / unit;
        c.worst_excess = std::max(c.worst_excess, excess);
        expect_kept(excess, excess_tolerance, "S2: the distance over the minimum");
    }

    void check_stiffness(const Surface& surface, const TouchTick& done, const Proxy& proxy, std::size_t k) {
        const reference::Place place = reference::place_of(surface, proxy);
        const auto meant = static_cast<double>(reference::properties_at(surface, place).stiffness);
        expect_at_most(std::fabs(done.contacts[k].properties.stiffness - meant), 1e-9 * (1 + meant), done, k,
                       "S8: the error of stiffness");
    }

    void compare(const Surface& surface, const TouchTick& done, const Proxy& before, const Proxy& after,
                 std::size_t k) {
        const reference::Comparison result = reference::compare(surface, before, after, done.contacts[k]);
        if (result.capped) return;
        expect_at_most(static_cast<double>(result.farther), 1e-12, done, k, "growth of |P - G| in the tick");
        Coverage& c = covered();
        ++c.compared;
        const auto ratio = static_cast<double>(result.distance_ratio);
        const auto angle = static_cast<double>(result.angle_degrees);
        // With friction the place of rest depends on the way there, and that on ties.
        const bool other_way = done.contacts[k].properties.static_friction > 0 && !(angle <= angle_tolerance);
        if (!result.same_basin || other_way) {
            ++c.other_basins;
            return;
        }
        c.worst_ratio = std::max(c.worst_ratio, ratio);
        c.worst_angle = std::max(c.worst_angle, angle);
        expect_at_most(ratio, ratio_tolerance, done, k, "|P - G| over the reference's");
        expect_at_most(angle, angle_tolerance, done, k, "degrees from the reference's force");
    }

    StressRun& run_;
    const WatchSettings& settings_;
    Watched out_;
    ForceHash hash_;
    std::vector<EnergyFigures> energy_;  // of each finger, up to the tick before
    std::vector<Steps> steps_;           // of each finger
};

}  // namespace

Watched watch(StressRun& run, const WatchSettings& settings, TickSink* sink) {
    return Watch(run, settings).watch(sink);
}

}  // namespace touchable::stress
