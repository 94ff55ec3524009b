#include "device/spring_trial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

const glm::dvec3 nudge_along = glm::dvec3(1, 1, 1) / std::sqrt(3.0);  // all axes are tried at once
constexpr double roundings_m = 1e-7;
constexpr double quieter = 0.9;  // of what it was: it is coming to rest

glm::dvec3 no_longer_than(const glm::dvec3& v, double most) {
    const double length = glm::length(v);
    return length > most ? v * (most / length) : v;
}

/// How far places go to and fro along each axis: standard deviation about their mean.
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

/// Greatest distances to each side, one after the other.
class HalfWaves {
public:
    /// `floor`: smaller ones are noise.
    explicit HalfWaves(double floor) : floor_(floor) {}
    /// False once one is twice the first.
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

}  // namespace

SpringTrial::SpringTrial(HapticDevice& device, const TickPace& pace, double most_force)
    : device_(device),
      pace_(pace),
      most_force_(most_force),
      metres_(static_cast<std::size_t>(device.fingers())),
      newtons_(metres_.size(), glm::dvec3(0)) {}

Result<glm::dvec3> SpringTrial::read() {
    if (!device_.read_positions(metres_)) return failure_of(device_);
    if (std::isfinite(metres_[0].x + metres_[0].y + metres_[0].z)) return metres_[0];
    const std::string prompt = device_.prompt();
    return Error{ErrorKind::device, device_.name() + ": lost its position while a spring was tried" +
                                        (prompt.empty() ? "" : "; " + prompt)};
}

Result<void> SpringTrial::push(const glm::dvec3& newtons) {
    newtons_[0] = newtons;
    if (!device_.write_forces(newtons_)) return failure_of(device_);
    if (!pace_.next_tick()) return Error{ErrorKind::interrupted, "stopped while a spring was tried"};
    return {};
}

void SpringTrial::power_off() {
    newtons_[0] = glm::dvec3(0);
    device_.write_forces(newtons_);
}

Result<HandleRest> SpringTrial::wait_for_rest() {
    constexpr int window = 300, most_windows = 40;
    constexpr double still_m = 0.0003, surely_still_m = 1e-6;
    constexpr double no_quieter =
        0.9;  // than the window before: what is left is noise, not a swing that dies
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
        const RestFigures figures = rest_of(places);
        const double before = std::exchange(farthest, figures.farthest_m);
        if (farthest <= surely_still_m ||
            (farthest <= still_m && before > 0 && farthest >= no_quieter * before))
            return HandleRest{mean, figures.deviation_m};
    }
    return Error{ErrorKind::device, device_.name() + ": its handle does not stay still by itself (it went " +
                                        std::to_string(static_cast<int>(std::lround(farthest * 1e6))) +
                                        " um in 0.3 s); lay it where it stays"};
}

Result<SpringTrial::Verdict> SpringTrial::try_spring(double stiffness, const HandleRest& rest) {
    auto verdict = feel(stiffness, rest);
    power_off();
    return verdict;
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

}  // namespace touchable
