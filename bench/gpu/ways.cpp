// SPDX-License-Identifier: Apache-2.0
#include "bench/gpu/gpu_cases.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "bench/gpu/frames_in_turn.hpp"
#include "bench/gpu/live_touch.hpp"
#include "bench/tick_times.hpp"
#include "engine/base/try.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {
namespace {

enum Way { lazy, by_cpu, by_vulkan };
constexpr std::array way_names{"lazy", "cpu", "vulkan"};
constexpr std::array way_rates{30, 60, 120};  // frames a second
constexpr int tick_rate = 30;                 // rate of the frames under timed ticks

struct WaySize {
    int width = 0, height = 0;
    auto operator<=>(const WaySize&) const = default;
};
std::string name_of(const WaySize& size) {
    return std::to_string(size.width) + "x" + std::to_string(size.height);
}

/// Cost of a frame in each way; nothing if the way refuses the filter. `latency_ms`: with one frame in
/// flight.
using WayFrames = std::array<std::optional<FrameCost>, 3>;

struct TickCost {
    double us = 0;      ///< CPU time, mean
    double us_p99 = 0;  ///< wall time
};
using WayTicks = std::array<std::optional<TickCost>, 3>;

/// CPU time per second, ms.
double ms_per_s(const FrameCost& frame, const TickCost& tick, int rate) {
    return rate * frame.cpu_ms + tick.us;
}

/// Ticks of the timing stroke over the newest frame, at 30 frames a second. Frames of a ring are built
/// beforehand, or passed to a lazy builder before the ticks that need them, untimed.
class HeldRun final : public TimedRun {
public:
    /// `lazy`: null if `slots` hold the ring's frames. All arguments must outlive this.
    HeldRun(const Scene& scene, const FrameRing& ring, std::span<SurfaceFrame> slots, SurfaceBuilder* lazy,
            const TouchSolver& solver, const std::vector<glm::dvec3>& goals, int fingers)
        : scene_(scene),
          ring_(ring),
          slots_(slots),
          lazy_(lazy),
          solver_(solver),
          goals_(goals),
          fingers_(static_cast<std::size_t>(fingers)),
          contacts_(fingers_.size()) {}

    int ticks() const override { return static_cast<int>(goals_.size() / fingers_.size()); }
    void restart() override {
        fingers_.assign(fingers_.size(), {});
        taken_ = -1;
    }
    void prepare(int, int end) override {
        // Cannot fail: check_same_forces took the same frames.
        while (lazy_ && taken_ < number_at(end - 1)) static_cast<void>(take(taken_ + 1));
    }
    void tick(int k) override {
        const std::int64_t number = number_at(k);
        const TimedFrame newest{number, number * 1'000'000'000 / tick_rate, &slot(number)};
        const auto goals =
            std::span(goals_).subspan(static_cast<std::size_t>(k) * fingers_.size(), fingers_.size());
        solver_.tick(HeightField(scene_, {newest, newest, 0}), goals, fingers_, contacts_);
    }
    /// Passes a frame to the lazy builder, into its slot.
    Result<void> take(std::int64_t number) {
        TRY(lazy_->build(ring_.frame(number), slot(number)));
        taken_ = number;
        return {};
    }
    std::span<const Contact> contacts() const { return contacts_; }

private:
    static std::int64_t number_at(int tick) { return std::int64_t{tick} * tick_rate / 1000; }
    SurfaceFrame& slot(std::int64_t number) const {
        return slots_[static_cast<std::size_t>(number) % slots_.size()];
    }

    const Scene& scene_;
    const FrameRing& ring_;
    const std::span<SurfaceFrame> slots_;
    SurfaceBuilder* const lazy_;
    const TouchSolver& solver_;
    const std::vector<glm::dvec3>& goals_;
    std::vector<FingerState> fingers_;
    std::vector<Contact> contacts_;
    std::int64_t taken_ = -1;
};

/// An error of kind check if a force of one run differs in a bit from the other's, or nothing is touched.
Result<void> check_same_forces(HeldRun& a, HeldRun& b, const std::string& what) {
    a.restart();
    b.restart();
    int touching = 0;
    for (int k = 0; k < a.ticks(); ++k) {
        for (HeldRun* run : {&a, &b}) {
            run->prepare(k, k + 1);
            run->tick(k);
        }
        for (std::size_t finger = 0; finger < a.contacts().size(); ++finger) {
            if (a.contacts()[finger].force != b.contacts()[finger].force)
                return Error{ErrorKind::check, what + ": a force differs in tick " + std::to_string(k)};
            touching += a.contacts()[finger].touching;
        }
    }
    if (touching > 0) return {};
    return Error{ErrorKind::check, what + ": no finger touches, so there is nothing to time"};
}

/// The builders of one size and filter, one per way, and the ring's frames built by them.
class WayBench {
public:
    static Result<std::unique_ptr<WayBench>> make(const FrameRing& ring, const TimedFilter& filter,
                                                  const std::shared_ptr<SurfaceKernels>& kernels) {
        auto bench = std::unique_ptr<WayBench>(new WayBench(ring, with_filter(ring.scene(), filter)));
        TRY(check_alike(bench->scene_, ring, 3, kernels));
        bench->builders_[by_cpu] = make_cpu_builder(bench->scene_);
        TRY_ASSIGN(bench->builders_[by_vulkan],
                   make_vulkan_builder(bench->scene_, kernels, plan_for(kernels->device()->facts())));
        auto lazy_builder = make_lazy_builder(bench->scene_);
        SurfaceFrame probe;
        if (lazy_builder->build(ring.frame(0), probe)) bench->builders_[lazy] = std::move(lazy_builder);
        return bench;
    }

    SurfaceBuilder* builder(Way way) const { return builders_[way].get(); }
    const Scene& scene() const { return scene_; }

    Result<WayFrames> frames(bool quick) {
        WayFrames costs;
        for (const Way way : {lazy, by_cpu, by_vulkan}) {
            if (!builder(way)) continue;
            const int most = builder(way)->frames_in_flight();
            FramesInTurn one(*builder(way), ring_, 1), several(*builder(way), ring_, most);
            std::vector<FramesInTurn*> racers{&one};
            if (most > 1) racers.push_back(&several);
            TRY(race_in_turn(racers, quick ? 0.1 : 0.3));
            costs[way] = racers.back()->cost();
            costs[way]->latency_ms = one.cost().latency_ms;
        }
        return costs;
    }

    /// Times ticks; each way's forces must equal those on the CPU builder's frames.
    Result<WayTicks> ticks(int fingers, bool quick) {
        TRY(fill());
        TouchSettings settings;
        settings.metres_per_scene_unit = scene_.device_metres_per_unit.value();
        TRY_ASSIGN(const auto solver, TouchSolver::create(scene_, settings));
        const auto goals = goals_over(ring_, fingers, quick ? 600 : 1000);
        const auto run_of = [&](Way way) {
            return HeldRun(scene_, ring_, *slots_[way], way == lazy ? builder(lazy) : nullptr, solver, goals,
                           fingers);
        };
        HeldRun whole = run_of(by_cpu);
        WayTicks costs;
        for (const Way way : {lazy, by_cpu, by_vulkan}) {
            if (!builder(way)) continue;
            HeldRun run = run_of(way);
            if (way != by_cpu) TRY(check_same_forces(run, whole, way_names[way]));
            const TickTimes times = time_hot(run, 3);
            costs[way] = TickCost{times.mean_us, times.quantile_us(0.99)};
        }
        return costs;
    }

private:
    using Slots = std::vector<SurfaceFrame>;
    WayBench(const FrameRing& ring, Scene scene) : ring_(ring), scene_(std::move(scene)) {}

    Result<void> fill() {
        for (const Way way : {lazy, by_cpu, by_vulkan}) {
            if (!builder(way) || slots_[way]) continue;
            slots_[way] = std::make_unique<Slots>(static_cast<std::size_t>(ring_.count()));
            // A new epoch: the temporal filter must not remember the timed frames.
            for (int n = 0; n < ring_.count(); ++n) {
                RawFrame raw = ring_.frame(n);
                raw.epoch = 1;
                TRY(builder(way)->build(raw, (*slots_[way])[static_cast<std::size_t>(n)]));
            }
        }
        return {};
    }

    const FrameRing& ring_;
    const Scene scene_;
    std::array<std::unique_ptr<SurfaceBuilder>, 3> builders_;  // null: the way refuses the filter
    std::array<std::unique_ptr<Slots>, 3> slots_;
};

/// All cells of the comparison, each measured on first use. Holds memory for one size at a time.
class Comparison {
public:
    using TakeKernels = std::function<Result<std::shared_ptr<SurfaceKernels>>()>;
    struct Cell {
        WaySize size{};
        std::size_t filter = 0;
        int fingers = 0;
        auto operator<=>(const Cell&) const = default;
    };

    Comparison(bool quick, TakeKernels kernels) : quick_(quick), kernels_(std::move(kernels)) {}

    std::vector<int> fingers() const {
        return quick_ ? std::vector<int>{1, 10} : std::vector<int>{1, 2, 5, 10};
    }
    std::vector<WaySize> sizes() const {
        if (quick_) return {{320, 240}, {1920, 1080}};
        return {{320, 240}, {720, 480}, {1280, 720}, {1920, 1080}, {3840, 2160}};
    }

    Result<WayFrames> frames(const WaySize& size, std::size_t filter) {
        WayFrames& known = frames_[{size, filter}];
        if (known[by_cpu]) return known;
        TRY(take(size, filter));
        TRY_ASSIGN(known, bench_->frames(quick_));
        return known;
    }
    Result<WayTicks> ticks(const Cell& cell) {
        WayTicks& known = ticks_[cell];
        if (known[by_cpu]) return known;
        TRY(take(cell.size, cell.filter));
        TRY_ASSIGN(known, bench_->ticks(cell.fingers, quick_));
        return known;
    }

    Result<void> measure_frames(const WaySize& size, std::size_t filter, Figures& figures);
    Result<void> measure_fingers(const Cell& cell, Figures& figures);
    Result<void> measure_crossover(const WaySize& size, Figures& figures);

private:
    struct Crossover {
        Cell cell{};
        int rate = 0;
        double ratio = HUGE_VAL;  // of the costs of two ways, the larger over the smaller
    };

    Result<void> take(const WaySize& size, std::size_t filter) {
        if (!ring_ || size_ != size) {
            bench_.reset();
            ring_.reset();  // memory does not suffice for two of the largest
            TRY_ASSIGN(auto ring, ring_of_bumps(size.width, size.height));
            ring_ = std::make_unique<FrameRing>(std::move(ring));
            size_ = size;
        } else if (bench_ && filter_ == filter) {
            return {};
        }
        TRY_ASSIGN(const auto kernels, kernels_());
        TRY_ASSIGN(bench_, WayBench::make(*ring_, timed_filters()[filter], kernels));
        filter_ = filter;
        return {};
    }
    Result<Crossover> nearest_crossover(const WaySize& size);

    const bool quick_;
    const TakeKernels kernels_;
    std::map<std::pair<WaySize, std::size_t>, WayFrames> frames_;
    std::map<Cell, WayTicks> ticks_;
    WaySize size_{};
    std::size_t filter_ = 0;
    std::unique_ptr<FrameRing> ring_;
    std::unique_ptr<WayBench> bench_;
    std::map<WaySize, std::unique_ptr<MovingForce>> moving_;
};

std::string rate_name(int rate) {
    return std::to_string(rate) + "hz";
}

Result<void> Comparison::measure_frames(const WaySize& size, std::size_t filter, Figures& figures) {
    TRY_ASSIGN(const auto costs, frames(size, filter));
    std::unique_ptr<MovingForce>& moving = moving_[size];
    if (!moving) {
        TRY_ASSIGN(auto made, MovingForce::make(size.width, size.height));
        moving = std::make_unique<MovingForce>(std::move(made));
    }
    const TimedFilter& choice = timed_filters()[filter];
    TRY_ASSIGN(const double off_by_filter, moving->off_by_filter(choice));
    figures.push_back({"true_force_n", moving->true_n(), "N"});
    figures.push_back({"filter_error_n", off_by_filter, "N"});
    for (const Way way : {lazy, by_cpu, by_vulkan}) {
        const std::string name = way_names[way];
        if (!costs[way]) continue;
        const FrameCost& cost = *costs[way];
        figures.push_back({name + "_frame_ms", cost.ms, "ms"});
        figures.push_back({name + "_frame_cpu_ms", cost.cpu_ms, "ms"});
        figures.push_back({name + "_latency_ms", cost.latency_ms, "ms"});
        for (const int rate : way_rates) {
            TRY_ASSIGN(const auto off,
                       moving->off(choice, {static_cast<double>(rate), cost.latency_ms, cost.ms}));
            if (!off) continue;
            figures.push_back({name + "_error_n_" + rate_name(rate), off->n, "N"});
            figures.push_back({name + "_error_pct_" + rate_name(rate), off->pct, "%", false});
            figures.push_back({name + "_age_ms_" + rate_name(rate), off->age_ms, "ms", false});
        }
    }
    figures.push_back({"lazy_possible", costs[lazy] ? 1.0 : 0.0, ""});
    return {};
}

Result<void> Comparison::measure_fingers(const Cell& cell, Figures& figures) {
    TRY_ASSIGN(const auto frame, frames(cell.size, cell.filter));
    TRY_ASSIGN(const auto tick, ticks(cell));
    for (const Way way : {lazy, by_cpu, by_vulkan}) {
        const std::string name = way_names[way];
        if (!frame[way] || !tick[way]) continue;
        figures.push_back({name + "_tick_us", tick[way]->us, "us"});
        figures.push_back({name + "_tick_us_p99", tick[way]->us_p99, "us"});
        for (const int rate : way_rates)
            figures.push_back(
                {name + "_ms_per_s_" + rate_name(rate), ms_per_s(*frame[way], *tick[way], rate), "ms"});
    }
    return {};
}

/// Finds the cell and rate at which the costs of the two cheapest ways that keep up differ least.
Result<Comparison::Crossover> Comparison::nearest_crossover(const WaySize& size) {
    Crossover nearest;
    for (std::size_t filter = 0; filter < timed_filters().size(); ++filter)
        for (const int count : fingers()) {
            const Cell cell{size, filter, count};
            TRY_ASSIGN(const auto frame, frames(size, filter));
            TRY_ASSIGN(const auto tick, ticks(cell));
            for (const int rate : way_rates) {
                std::vector<double> costs;
                for (const Way way : {lazy, by_cpu, by_vulkan})
                    if (frame[way] && rate * frame[way]->ms < 1000)
                        costs.push_back(ms_per_s(*frame[way], *tick[way], rate));
                std::ranges::sort(costs);
                if (costs.size() < 2 || costs[1] / costs[0] >= nearest.ratio) continue;
                nearest = {cell, rate, costs[1] / costs[0]};
            }
        }
    return nearest;
}

Result<void> Comparison::measure_crossover(const WaySize& size, Figures& figures) {
    TRY_ASSIGN(const auto nearest, nearest_crossover(size));
    if (nearest.rate == 0) return {};  // at no rate do two ways keep up
    const auto& [cell, rate, ratio] = nearest;
    TRY_ASSIGN(const auto frame, frames(size, cell.filter));
    TRY_ASSIGN(const auto tick, ticks(cell));
    TRY(take(size, cell.filter));
    const double seconds = quick_ ? 1 : 2;
    const auto goals = goals_over(*ring_, cell.fingers, static_cast<int>(1000 * seconds));
    const LiveTouch set_up{bench_->scene(), *ring_, goals, cell.fingers, static_cast<double>(rate), seconds};
    TRY_ASSIGN(const auto alone, touch_live(set_up, nullptr));
    const std::string what = std::string(timed_filters()[cell.filter].name) + "_" +
                             std::to_string(cell.fingers) + "f_" + rate_name(rate) + "_";
    figures.push_back({what + "cost_ratio", ratio, ""});
    for (const Way way : {lazy, by_cpu, by_vulkan}) {
        if (!frame[way] || rate * frame[way]->ms >= 1000) continue;
        TRY_ASSIGN(const auto times, touch_live(set_up, bench_->builder(way)));
        const std::string name = what + way_names[way];
        const double computed = ms_per_s(*frame[way], *tick[way], rate);
        figures.push_back({name + "_computed_ms_per_s", computed, "ms"});
        figures.push_back({name + "_run_ms_per_s", times.cpu_ms_per_s - alone.cpu_ms_per_s, "ms"});
        figures.push_back({name + "_run_frames_per_s", times.frames_per_s, ""});
        figures.push_back({name + "_run_latency_ms", times.latency_ms, "ms"});
        for (const auto& [suffix, share] : {std::pair{"p50", 0.5}, {"p99", 0.99}, {"p999", 0.999}})
            figures.push_back({name + "_run_late_us_" + suffix, times.late_us_at(share), "us"});
    }
    return {};
}

}  // namespace

std::vector<BenchCase> ways_cases(bool quick,
                                  const std::function<Result<std::shared_ptr<SurfaceKernels>>()>& kernels) {
    const auto all = std::make_shared<Comparison>(quick, kernels);
    std::vector<BenchCase> cases;
    for (const WaySize& size : all->sizes()) {
        const std::string name = "ways-" + name_of(size) + "-";
        for (std::size_t filter = 0; filter < timed_filters().size(); ++filter) {
            const std::string filtered = name + std::string(timed_filters()[filter].name);
            cases.push_back({filtered, [all, size, filter](Figures& figures) {
                                 return all->measure_frames(size, filter, figures);
                             }});
            for (const int fingers : all->fingers())
                cases.push_back({filtered + "-" + std::to_string(fingers) + "f",
                                 [all, cell = Comparison::Cell{size, filter, fingers}](Figures& figures) {
                                     return all->measure_fingers(cell, figures);
                                 }});
        }
        cases.push_back(
            {name + "run", [all, size](Figures& figures) { return all->measure_crossover(size, figures); }});
    }
    return cases;
}

}  // namespace touchable
