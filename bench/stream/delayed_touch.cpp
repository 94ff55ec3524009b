#include "bench/stream/delayed_touch.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "engine/content/random.hpp"

namespace touchable {
namespace {

/// N: a finger with less touches nothing.
constexpr double least_force = 0.01;
/// Ticks by which the run is matched to a place in the period, and how far forces may be off there: N, RMS.
constexpr std::size_t matched_ticks = 700;
constexpr double most_off = 0.02;

double square(const glm::dvec3& vector) {
    return glm::dot(vector, vector);
}

/// Root of the mean over ticks and fingers.
class Rms {
public:
    void add(double square) {
        sum_ += square;
        ++count_;
    }
    double value() const { return count_ > 0 ? std::sqrt(sum_ / static_cast<double>(count_)) : 0; }

private:
    double sum_ = 0;
    std::int64_t count_ = 0;
};

}  // namespace

Result<void> DelayedTouch::take(const TouchTick& tick) {
    const TimedFrame& felt = tick.pair.prev;
    if (felt.number < 0) return {};
    if (numbers_.empty() || felt.number > numbers_.back()) {
        numbers_.push_back(felt.number);
        taken_ns_.push_back(felt.time_ns - reader_.taken_before(felt.number));
    }
    Tick kept{tick.tick, tick.time_ns, felt.number, felt.time_ns, {tick.goals.begin(), tick.goals.end()}, {}};
    for (std::size_t k = 0; k < tick.forces.size(); ++k) kept.forces.push_back(tick.sent(k));
    ticks_.push_back(std::move(kept));
    return {};
}

/// Frames are sent at even times: the median of what they say of it.
std::int64_t DelayedTouch::taken_frame_0(std::int64_t frame_ns) const {
    std::vector<std::int64_t> zeros;
    for (std::size_t n = 0; n < numbers_.size(); ++n) zeros.push_back(taken_ns_[n] - numbers_[n] * frame_ns);
    const auto middle = zeros.begin() + static_cast<std::ptrdiff_t>(zeros.size() / 2);
    std::nth_element(zeros.begin(), middle, zeros.end());
    return *middle;
}

std::int64_t DelayedTouch::Sent::newest(std::int64_t time_ns) const {
    const std::int64_t since = time_ns - zero_ns;
    return since >= 0 ? since / frame_ns : -((frame_ns - 1 - since) / frame_ns);
}

FramePair DelayedTouch::Sent::pair(std::int64_t number, std::int64_t time_ns) const {
    const auto period = static_cast<std::int64_t>(frames.size());
    const std::int64_t at = ((number + first) % period + period) % period;
    const TimedFrame frame{number, time_ns, frames[static_cast<std::size_t>(at)]};
    return {frame, frame, 0, 0};
}

/// Forces of the first `count` ticks, with the goals of so long before.
template <class PairOf>
std::vector<DelayedTouch::Vectors> DelayedTouch::solved(const TouchSetup& setup, std::int64_t goals_late_ms,
                                                        const PairOf& pair_of, std::size_t count) const {
    TouchStep step(*setup.solver, setup.settings.guard, setup.settings.fingers);
    std::vector<Vectors> forces;
    std::size_t moved = 0;  // the tick whose goals are there
    for (std::size_t n = 0; n < count; ++n) {
        const Tick& tick = ticks_[n];
        while (moved + 1 <= n && ticks_[moved + 1].tick <= tick.tick - goals_late_ms) ++moved;
        std::copy(ticks_[moved].goals.begin(), ticks_[moved].goals.end(), step.goals().begin());
        const TouchTick done = step.run(tick.tick, tick.time_ns, setup.scene, pair_of(tick));
        Vectors& all = forces.emplace_back();
        for (const GuardedForce& force : done.forces) all.push_back(force.force);
    }
    return forces;
}

/// The run's frames are those of a sender that was somewhere in its period: where the same frames give the
/// same forces.
Result<std::int64_t> DelayedTouch::first_of_period(const TouchSetup& setup, Sent sent) const {
    const std::size_t count = std::min(matched_ticks, ticks_.size());
    double least = std::numeric_limits<double>::infinity();
    std::int64_t found = 0;
    for (std::int64_t first = 0; first < static_cast<std::int64_t>(sent.frames.size()); ++first) {
        sent.first = first;
        const auto forces = solved(
            setup, 0, [&](const Tick& tick) { return sent.pair(tick.frame, tick.frame_ns); }, count);
        Rms off;
        for (std::size_t n = 0; n < count; ++n)
            for (std::size_t k = 0; k < forces[n].size(); ++k)
                off.add(square(forces[n][k] - ticks_[n].forces[k]));
        if (off.value() >= least) continue;
        least = off.value();
        found = first;
    }
    if (least > most_off)
        return Error{ErrorKind::check, "the run's forces are not those of what was sent: " +
                                           std::to_string(least) + " N off, at most " +
                                           std::to_string(most_off) + " would be right"};
    return found;
}

Result<void> DelayedTouch::add_figures(const TouchSetup& setup, const std::vector<SurfaceFrame>& frames,
                                       int period, const test::NetworkFaults& faults,
                                       Figures& figures) const {
    if (ticks_.empty()) return Error{ErrorKind::check, "nothing was touched"};
    Sent sent;
    for (int n = 0; n < period; ++n)
        sent.frames.push_back(&frames[static_cast<std::size_t>(n) % frames.size()]);
    sent.frame_ns = setup.scene.rate.time_ns(1);
    sent.zero_ns = taken_frame_0(sent.frame_ns);
    const auto first = first_of_period(setup, sent);
    if (!first.ok()) return first.error();
    sent.first = *first;

    const auto of_the_moment = [&](const Tick& tick) { return sent.pair(sent.newest(tick.time_ns)); };
    const auto late_ms = static_cast<std::int64_t>(std::lround(faults.delay_ms));
    const auto undelayed = solved(setup, 0, of_the_moment, ticks_.size()),
               far_away = solved(setup, late_ms, of_the_moment, ticks_.size());
    Rms whole, off, far_off;
    std::int64_t touching = 0, without = 0;
    std::size_t coming = 0, held = 0;  // of far_away: the force that would come now, and the last that came
    SplitMix64 random(faults.seed);
    for (std::size_t n = 0; n < ticks_.size(); ++n) {
        const Tick& tick = ticks_[n];
        while (coming + 1 <= n && ticks_[coming + 1].tick <= tick.tick - late_ms) ++coming;
        // A goal and a force are a datagram each, and the next comes a millisecond later.
        if (random.unit() >= faults.loss && random.unit() >= faults.loss) held = coming;
        if (tick.tick < 2 * late_ms) continue;
        for (std::size_t k = 0; k < tick.forces.size(); ++k) {
            const glm::dvec3 right = undelayed[n][k];
            whole.add(square(right));
            off.add(square(tick.forces[k] - right));
            far_off.add(square(far_away[held][k] - right));
            if (square(right) < least_force * least_force) continue;
            ++touching;
            without += square(tick.forces[k]) < least_force * least_force;
        }
    }
    figures.push_back({"undelayed_n", whole.value(), "N"});
    figures.push_back({"off_n", off.value(), "N"});
    figures.push_back({"far_off_n", far_off.value(), "N"});
    figures.push_back({"without_touch_pct",
                       touching > 0 ? 100 * static_cast<double>(without) / static_cast<double>(touching) : 0,
                       "%"});
    return {};
}

}  // namespace touchable
