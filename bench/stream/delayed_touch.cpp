#include "bench/stream/delayed_touch.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "engine/base/same_bits.hpp"

namespace touchable {
namespace {

/// N; a finger with less force counts as without contact.
constexpr double least_force = 0.01;
/// Number of ticks used to match the run to a place in the period, and the largest force error there, N, RMS.
constexpr std::size_t matched_ticks = 700;
constexpr double most_off = 0.02;
/// LiveReader stamps frames that came before the run with its first microseconds.
constexpr std::int64_t first_in_run_ns = 500'000;

double square(const glm::dvec3& vector) {
    return glm::dot(vector, vector);
}

/// RMS over ticks and fingers.
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

Result<void> DelayedTouch::consume(const TouchTick& tick) {
    if (tick.pair.prev.number < 0) return {};
    for (const TimedFrame& frame : {tick.pair.prev, tick.pair.next})
        if (frame.time_ns >= first_in_run_ns && !taken_ns_.contains(frame.number))
            taken_ns_[frame.number] = frame.time_ns - reader_.taken_before(frame.number);
    if (tick.pair.prev.time_ns < first_in_run_ns) ++early_ticks_;
    Tick kept{tick.tick, tick.time_ns, tick.pair, {tick.goals.begin(), tick.goals.end()}, {}};
    for (std::size_t k = 0; k < tick.forces.size(); ++k) kept.forces.push_back(tick.sent(k));
    ticks_.push_back(std::move(kept));
    return {};
}

FramePair DelayedTouch::Sent::newest(std::int64_t time_ns) const {
    const std::int64_t since = time_ns - first_ns,
                       number = since >= 0 ? since / frame_ns : -((frame_ns - 1 - since) / frame_ns);
    const TimedFrame frame{number, first_ns + number * frame_ns, at(first + number)};
    return {frame, frame, 0, 0};
}

/// Frames are sent at even times; lost frames also count.
const SurfaceFrame* DelayedTouch::Sent::taken(std::int64_t taken_ns) const {
    return at(first + std::llround(static_cast<double>(taken_ns - first_ns) / static_cast<double>(frame_ns)));
}

const SurfaceFrame* DelayedTouch::Sent::at(std::int64_t place) const {
    const auto period = static_cast<std::int64_t>(frames.size());
    return frames[static_cast<std::size_t>((place % period + period) % period)];
}

/// A tick's pair with the surfaces that were sent.
FramePair DelayedTouch::felt(const Tick& tick, const Sent& sent) const {
    FramePair pair = tick.pair;
    for (TimedFrame* frame : {&pair.prev, &pair.next}) {
        const auto taken = taken_ns_.find(frame->number);
        frame->frame =
            taken == taken_ns_.end() ? sent.at(sent.early + frame->number) : sent.taken(taken->second);
    }
    return pair;
}

/// Forces of the first `count` ticks, with goals delayed by `goals_late_ms`.
template <class PairOf>
std::vector<DelayedTouch::Vectors> DelayedTouch::solved(const TouchSetup& setup, std::int64_t goals_late_ms,
                                                        const PairOf& pair_of, std::size_t count) const {
    TouchStep step(*setup.solver, setup.options.guard, setup.options.fingers);
    std::vector<Vectors> forces;
    std::size_t moved = 0;  // the tick whose goals have arrived
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

/// The sender started at an unknown place in its period: sets `place` to the one whose forces are nearest to
/// the run's in the first `count` ticks; returns the remaining error, N.
double DelayedTouch::match(const TouchSetup& setup, Sent& sent, std::int64_t Sent::*place,
                           std::size_t count) const {
    double least = std::numeric_limits<double>::infinity();
    std::int64_t found = 0;
    for (std::int64_t tried = 0; tried < static_cast<std::int64_t>(sent.frames.size()); ++tried) {
        sent.*place = tried;
        const auto forces = solved(
            setup, 0, [&](const Tick& tick) { return felt(tick, sent); }, count);
        Rms off;
        for (std::size_t n = 0; n < count; ++n)
            for (std::size_t k = 0; k < forces[n].size(); ++k)
                off.add(square(forces[n][k] - ticks_[n].forces[k]));
        if (off.value() >= least) continue;
        least = off.value();
        found = tried;
    }
    sent.*place = found;
    return least;
}

Result<void> DelayedTouch::add_figures(const TouchSetup& setup, const std::vector<SurfaceFrame>& frames,
                                       int period, const test::NetworkFaults& faults,
                                       Figures& figures) const {
    if (ticks_.empty()) return Error{ErrorKind::check, "nothing was touched"};
    Sent sent;
    for (int n = 0; n < period; ++n)
        sent.frames.push_back(&frames[static_cast<std::size_t>(n) % frames.size()]);
    sent.frame_ns = setup.scene.rate.time_ns(1);
    if (taken_ns_.empty()) return Error{ErrorKind::check, "no frame came in the run"};
    // Frames are sent at even times, each read from a clock: take the median of the first frame's time
    // derived from each.
    std::vector<std::int64_t> firsts;
    const std::int64_t of_first = taken_ns_.begin()->second;
    for (const auto& [number, taken_ns] : taken_ns_) {
        const double frames_later =
            static_cast<double>(taken_ns - of_first) / static_cast<double>(sent.frame_ns);
        firsts.push_back(taken_ns - std::llround(frames_later) * sent.frame_ns);
    }
    const auto middle = firsts.begin() + static_cast<std::ptrdiff_t>(firsts.size() / 2);
    std::nth_element(firsts.begin(), middle, firsts.end());
    sent.first_ns = *middle;
    if (early_ticks_ > 0) (void)match(setup, sent, &Sent::early, early_ticks_);
    const double off_n =
        match(setup, sent, &Sent::first, std::min(early_ticks_ + matched_ticks, ticks_.size()));
    if (off_n > most_off)
        return Error{ErrorKind::check,
                     "the run's forces are not those of what was sent: " + std::to_string(off_n) +
                         " N off; must be at most " + std::to_string(most_off)};

    const auto of_the_moment = [&](const Tick& tick) { return sent.newest(tick.time_ns); };
    const auto late_ms = static_cast<std::int64_t>(std::lround(faults.delay_ms));
    const auto undelayed = solved(setup, 0, of_the_moment, ticks_.size()),
               far_away = solved(setup, late_ms, of_the_moment, ticks_.size());
    Rms whole, off, far_off;
    std::int64_t touching = 0, without = 0;
    std::size_t coming = 0, held = 0;  // indices into far_away: the force due now, and the last received
    SplitMix64 random(faults.seed);
    for (std::size_t n = 0; n < ticks_.size(); ++n) {
        const Tick& tick = ticks_[n];
        while (coming + 1 <= n && ticks_[coming + 1].tick <= tick.tick - late_ms) ++coming;
        // Goal and force are one datagram each; the next ones follow a millisecond later.
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
