// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/device_measure.hpp"

#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

// ---- Figures

double seconds_between(std::int64_t from_ns, std::int64_t to_ns) {
    return static_cast<double>(to_ns - from_ns) * 1e-9;
}

/// Nearest-rank percentile of sorted values.
double percentile(const std::vector<double>& values, double percent) {
    const auto rank = static_cast<std::size_t>(std::ceil(percent / 100 * static_cast<double>(values.size())));
    return values[std::max<std::size_t>(rank, 1) - 1];
}

// ---- Watching

/// Memory reserved before the first reading, so that no reading waits for it.
struct Readings {
    explicit Readings(std::size_t ticks) {
        ages.reserve(ticks);
        asked_ns.reserve(ticks);
        places.reserve(ticks);
    }
    std::vector<double> ages;
    std::vector<std::int64_t> asked_ns;
    std::vector<glm::dvec3> places;
    std::int64_t without_place = 0, longest_call_ns = 0;
};

Result<void> read_once(HapticDevice& device, const TickPace& pace, std::vector<glm::dvec3>& metres,
                       const std::vector<glm::dvec3>& zeros, std::int64_t& received_ns, Readings& readings) {
    const std::int64_t now = pace.now_ns();
    if (!device.read_positions(metres)) return failure_of(device);
    const double age = device.age_s();
    if (std::isfinite(age)) readings.ages.push_back(age);
    const bool has_place = std::isfinite(metres[0].x + metres[0].y + metres[0].z);
    if (!has_place) ++readings.without_place;
    // A report that is read twice counts once; its computed times differ by the duration of the calls.
    const std::int64_t received = has_place ? now - static_cast<std::int64_t>(age * 1e9) : received_ns;
    if (has_place && (readings.places.empty() || std::abs(received - received_ns) > 100'000))
        readings.places.push_back(metres[0]);
    received_ns = received;
    readings.asked_ns.push_back(pace.now_ns());
    if (!device.write_forces(zeros)) return failure_of(device);
    readings.longest_call_ns = std::max(readings.longest_call_ns, pace.now_ns() - now);
    return {};
}

// ---- A spring

const glm::dvec3 nudge_along = glm::dvec3(1, 1, 1) / std::sqrt(3.0);  // all axes are tried at once
constexpr double roundings_m = 1e-7;
constexpr double quieter = 0.9;  // ratio of swings; below it the handle comes to rest

glm::dvec3 no_longer_than(const glm::dvec3& v, double most) {
    const double length = glm::length(v);
    return length > most ? v * (most / length) : v;
}

/// Swing of positions along each axis: standard deviation about their mean.
class Swing {
public:
    void add(const glm::dvec3& off) {
        sum_ += off;
        squares_ += off * off;
        ++count_;
    }
    double along(int axis) const {
        const double mean = sum_[axis] / count_;
        return std::sqrt(std::max(0.0, squares_[axis] / count_ - mean * mean));
    }

private:
    glm::dvec3 sum_{0.0}, squares_{0.0};
    int count_ = 0;
};

/// Peaks of a swing, on alternating sides.
class HalfWaves {
public:
    /// `floor`: smaller peaks are noise.
    explicit HalfWaves(double floor) : floor_(floor) {}
    /// False once a peak is more than twice the first.
    bool add(double off) {
        if (off * side_ < 0 && peak_ > floor_) {
            if (first_ == 0) first_ = peak_;
            peak_ = 0;
        }
        if (std::abs(off) > floor_) side_ = off;
        peak_ = std::max(peak_, std::abs(off));
        return first_ == 0 || peak_ <= 2 * first_;
    }

private:
    double floor_, side_ = 0, peak_ = 0, first_ = 0;
};

constexpr double softest = 100, rung = 1.4142135623730951;
constexpr double most_newtons = 1.5;

}  // namespace

// ---- Figures

WatchFigures::Percentiles percentiles_of(std::vector<double> values) {
    if (values.empty()) return {};
    std::ranges::sort(values);
    return {static_cast<std::int64_t>(values.size()), percentile(values, 50), percentile(values, 99),
            values.back()};
}

std::vector<double> intervals_between(std::span<const std::int64_t> times_ns) {
    std::vector<double> intervals;
    for (std::size_t k = 1; k < times_ns.size(); ++k)
        intervals.push_back(seconds_between(times_ns[k - 1], times_ns[k]));
    return intervals;
}

std::vector<double> until_the_next(std::span<const std::int64_t> times_ns,
                                   std::span<const std::int64_t> others_ns) {
    std::vector<double> waits;
    auto other = others_ns.begin();
    for (std::size_t k = 0; k < times_ns.size(); ++k) {
        other = std::lower_bound(other, others_ns.end(), times_ns[k]);
        if (other == others_ns.end()) break;
        if (k + 1 < times_ns.size() && *other >= times_ns[k + 1]) continue;
        waits.push_back(seconds_between(times_ns[k], *other));
    }
    return waits;
}

WatchFigures::Rest rest_of(std::span<const glm::dvec3> metres) {
    WatchFigures::Rest figures;
    figures.places = static_cast<std::int64_t>(metres.size());
    if (metres.empty()) return figures;
    const double count = static_cast<double>(metres.size());
    glm::dvec3 mean(0), square(0);
    for (const glm::dvec3& place : metres) mean += place / count;
    for (std::size_t k = 0; k < metres.size(); ++k) {
        const glm::dvec3 off = metres[k] - mean;
        square += off * off / count;
        figures.farthest_m = std::max(figures.farthest_m, glm::length(off));
        for (int axis = 0; k > 0 && axis < 3; ++axis) {
            const double step = std::abs(metres[k][axis] - metres[k - 1][axis]);
            double& smallest = figures.step_m[axis];
            if (step > 0 && (smallest == 0 || step < smallest)) smallest = step;
        }
    }
    figures.deviation_m = {std::sqrt(square.x), std::sqrt(square.y), std::sqrt(square.z)};
    return figures;
}

std::vector<std::int64_t> DriveTimes::Ring::within(std::int64_t from_ns, std::int64_t to_ns) const {
    std::vector<std::int64_t> found;
    const std::size_t count = count_.load(std::memory_order_acquire);
    for (std::size_t k = count > times_.size() ? count - times_.size() : 0; k < count; ++k) {
        const std::int64_t time = times_[k % times_.size()].load(std::memory_order_relaxed);
        if (time >= from_ns && time < to_ns) found.push_back(time);
    }
    return found;
}

// ---- Watching

Error failure_of(const HapticDevice& device) {
    const auto health = device.health();
    return health ? device_error(device.name() + ": does not answer any more") : health.error();
}

Result<WatchFigures> watch_device(HapticDevice& device, const DriveTimes& times, const TickPace& pace,
                                  int ticks) {
    Readings readings(static_cast<std::size_t>(ticks));
    std::vector<glm::dvec3> metres(static_cast<std::size_t>(device.fingers()));
    const std::vector<glm::dvec3> zeros(metres.size(), glm::dvec3(0));
    const std::int64_t begin = pace.now_ns();
    std::int64_t received_ns = 0;
    for (int tick = 0; tick < ticks; ++tick) {
        TRY(read_once(device, pace, metres, zeros, received_ns, readings));
        if (!pace.next_tick()) return interrupted_error();
    }
    const std::int64_t end = pace.now_ns();
    const auto received = times.received.within(begin, end), sent = times.sent.within(begin, end);
    WatchFigures figures;
    figures.seconds = static_cast<double>(end - begin) * 1e-9;
    figures.readings = ticks;
    figures.without_place = readings.without_place;
    figures.longest_call_s = static_cast<double>(readings.longest_call_ns) * 1e-9;
    const auto intervals = intervals_between(received);
    if (!intervals.empty())
        figures.reports_per_s = static_cast<double>(intervals.size()) /
                                (static_cast<double>(received.back() - received.front()) * 1e-9);
    figures.interval_s = percentiles_of(intervals);
    figures.age_s = percentiles_of(std::move(readings.ages));
    figures.going_out_s = percentiles_of(until_the_next(readings.asked_ns, sent));
    figures.until_received_s = percentiles_of(until_the_next(sent, received));
    figures.rest = rest_of(readings.places);
    return figures;
}

// ---- A spring

Result<HandleRest> SpringTrial::wait_for_rest() {
    constexpr int window = 300, most_windows = 40;
    constexpr double still_m = 0.0003, surely_still_m = 1e-6;
    constexpr double no_quieter =
        0.9;  // ratio to the window before; from it on, noise remains rather than a dying swing
    std::vector<glm::dvec3> places;
    places.reserve(window);
    double farthest = 0;
    for (int k = 0; k < most_windows; ++k) {
        places.clear();
        glm::dvec3 mean(0);
        for (int tick = 0; tick < window; ++tick) {
            TRY_ASSIGN(const auto place, read());
            places.push_back(place);
            mean += place / double{window};
            TRY(push(glm::dvec3(0)));
        }
        const WatchFigures::Rest figures = rest_of(places);
        const double before = std::exchange(farthest, figures.farthest_m);
        if (farthest <= surely_still_m ||
            (farthest <= still_m && before > 0 && farthest >= no_quieter * before))
            return HandleRest{mean, figures.deviation_m};
    }
    return device_error(device_.name() + ": its handle does not stay still by itself (it went " +
                        std::to_string(static_cast<int>(std::lround(farthest * 1e6))) +
                        " um in 0.3 s); lay it where it stays");
}

Result<SpringTrial::Verdict> SpringTrial::feel(double stiffness, const HandleRest& rest) {
    const glm::dvec3 floor = 2.0 * rest.noise_m + roundings_m;
    const double nudge = most_force_ / 3;
    std::array<Swing, 4> quarters;
    HalfWaves waves(3 * glm::length(floor));
    Verdict verdict;
    for (int tick = 0; tick < ticks; ++tick) {
        TRY_ASSIGN(const auto place, read());
        const glm::dvec3 off = place - rest.metres;
        verdict.moved = verdict.moved || glm::length(off) > 2 * glm::length(floor);
        if (glm::length(off) > farthest_m) return Verdict{false, "it went 3 mm away", true};
        if (!waves.add(glm::dot(off, nudge_along))) return Verdict{false, "its swings doubled", true};
        quarters[static_cast<std::size_t>(4 * tick / ticks)].add(off);
        const glm::dvec3 spring = -stiffness * off;
        const glm::dvec3 force = tick < nudge_ticks ? spring + nudge * nudge_along : spring;
        TRY(push(no_longer_than(force, most_force_)));
    }
    for (int axis = 0; axis < 3; ++axis) {
        const double before = quarters[1].along(axis), after = quarters[3].along(axis);
        if (after > floor[axis] && after >= quieter * before)
            return Verdict{false, "it did not come to rest", true};
    }
    verdict.quiet = true;
    return verdict;
}

Result<StiffnessFinding> find_stiffness(HapticDevice& device, const TickPace& pace,
                                        const std::function<void(double)>& tries) {
    if (device.capabilities().axes_driven == 0)
        return usage_error(device.name() + " exerts no force, so it has no largest stiffness");
    const DeviceLimits limits = device.limits();
    StiffnessFinding finding;
    finding.most_force = std::min(most_newtons, limits.max_force / 2);
    finding.moved = false;
    SpringTrial trial(device, pace, finding.most_force);
    for (double stiffness = std::min(softest, limits.max_stiffness);; stiffness *= rung) {
        stiffness = std::min(stiffness, limits.max_stiffness);
        if (tries) tries(stiffness);
        TRY_ASSIGN(const auto rest, trial.wait_for_rest());
        TRY_ASSIGN(auto verdict, trial.try_spring(stiffness, rest));
        finding.moved = finding.moved || verdict.moved;
        if (!verdict.quiet) {
            finding.shaking = stiffness;
            finding.why = verdict.why;
            return finding;
        }
        finding.quiet = stiffness;
        if (stiffness >= limits.max_stiffness) return finding;
    }
}

}  // namespace touchable
