// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "bench/paper/scratch_run.hpp"
#include "bench/paper/sweep_run.hpp"
#include "bench/suite.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

/// Frames of the chest, each with its own noise: not a divisor of a segment of 10 s or of a second, so that
/// the loop and the measurement have no common period.
constexpr int chest_frames = 293;

/// As few frames of large pictures as memory holds.
constexpr int large_turned_frames = 4;

/// The paper's, where pixels are touched.
constexpr PaperFilter its_filter{3, false, false, true};

/// Caches the clip made last; cases with the same clip are adjacent.
class ClipShelf {
public:
    Result<std::shared_ptr<const PaperClip>> globe(int width, int height, int turned_frames) {
        const std::string name = "globe " + std::to_string(width);
        if (name_ == name) return clip_;
        clip_ = nullptr;  // there may be no memory for both
        TRY_ASSIGN(auto made, make_globe_clip(width, height, turned_frames));
        return keep(name, made);
    }
    std::shared_ptr<const PaperClip> chest(double noise_levels, int frames) {
        const std::string name = "chest " + std::to_string(noise_levels) + " " + std::to_string(frames);
        return name_ == name ? clip_ : keep(name, make_chest_clip(noise_levels, frames));
    }

private:
    std::shared_ptr<const PaperClip> keep(const std::string& name, std::shared_ptr<const PaperClip> clip) {
        name_ = name;
        return clip_ = std::move(clip);
    }

    std::string name_;
    std::shared_ptr<const PaperClip> clip_;
};

TouchCase setup_of(const char* scene, int width, int height, TouchMetric metric, const PaperFilter& filter) {
    TouchCase c;
    c.scene = scene;
    c.width = width;
    c.height = height;
    c.bits = 8;
    c.metric = metric;
    c.median = filter.median;
    c.terraces = filter.terraces;
    c.lazy = filter.lazy;
    return c;
}

/// Collects the cases.
class PaperSuite {
public:
    explicit PaperSuite(bool quick) : quick_(quick) {}

    std::vector<BenchCase> cases() {
        for (const bool still : {false, true}) add_scratches(1, still, scratch_hands[0]);
        if (!quick_) {
            for (const double noise : {0.5, 2.0})
                for (const bool still : {false, true}) add_scratches(noise, still, scratch_hands[0]);
            for (const ScratchHand& hand : std::span(scratch_hands).subspan(1)) add_scratches(1, false, hand);
        }
        add_sweeps("globe", {0, true}, TouchMetric::world);
        add_sweeps("globe", its_filter, TouchMetric::pixel);
        for (const auto& [width, height] : {std::pair{720, 480}, {1280, 720}, {1920, 1080}, {3840, 2160}})
            for (const int fingers : {1, 2, 5, 10})
                if (width > 720 || fingers > 1)
                    for (const bool ours : {true, false}) add_large_sweep(width, height, fingers, ours);
        add_sweeps("chest", {5, true}, TouchMetric::world);
        add_sweeps("chest", its_filter, TouchMetric::pixel);
        return std::move(cases_);
    }

private:
    void add_scratches(double noise, bool still, const ScratchHand& hand) {
        for (const TouchMetric metric : {TouchMetric::pixel, TouchMetric::world})
            for (const PaperFilter& filter : {PaperFilter{0}, PaperFilter{3}, PaperFilter{5},
                                              PaperFilter{5, true}, PaperFilter{5, true, true}})
                if (!(still && filter.temporal)) add_scratch(noise, still, hand, metric, filter);
    }

    void add_scratch(double noise, bool still, const ScratchHand& hand, TouchMetric metric,
                     const PaperFilter& filter) {
        ScratchRun run{setup_of("chest", 320, 240, metric, filter), filter, hand};
        run.setup.run = formatted("scratch-n%g", noise) + std::string(hand.name);
        if (filter.temporal) run.setup.run += "-temporal";
        if (still) run.setup.run += "-still";
        add(name_of(run.setup), [shelf = shelf_, run, noise, still](Figures& figures) {
            return measure_scratch(shelf->chest(noise, still ? 1 : chest_frames), run, figures);
        });
    }

    void add_sweeps(const std::string& scene, const PaperFilter& filter, TouchMetric metric) {
        const bool globe = scene == "globe";
        for (const ScriptedPath& path : fast_hands) {
            SweepRun run{setup_of(scene.c_str(), globe ? 720 : 320, globe ? 480 : 240, metric, filter),
                         filter, path};
            if (quick_) {
                run.seconds = 10;
                run.repeats = 3;
            }
            add_sweep(run, 30);
        }
    }

    /// Table I of larger pictures and more fingers: the circling hand.
    void add_large_sweep(int width, int height, int fingers, bool ours) {
        const PaperFilter filter = ours ? PaperFilter{0, true} : its_filter;
        SweepRun run{setup_of("globe", width, height, ours ? TouchMetric::world : TouchMetric::pixel, filter),
                     filter, fast_hands[1], quick_ ? 2 : 10, 3};
        run.setup.fingers = fingers;
        add_sweep(run, width == 720 ? 30 : large_turned_frames);
    }

    void add_sweep(SweepRun run, int turned_frames) {
        run.setup.run = run.path.name;
        add(name_of(run.setup), [shelf = shelf_, run, turned_frames](Figures& figures) -> Result<void> {
            const TouchCase& c = run.setup;
            if (c.width <= 720 && c.metric == TouchMetric::pixel)
                figures.push_back({"papers_tick_us",
                                   c.fingers * (c.scene == "globe" ? papers_globe_us : papers_chest_us),
                                   "us"});
            if (c.scene != "globe") return measure_sweep(shelf->chest(1, chest_frames), run, figures);
            TRY_ASSIGN(auto clip, shelf->globe(c.width, c.height, turned_frames));
            return measure_sweep(clip, run, figures);
        });
    }

    template <class Measure>
    void add(const std::string& name, Measure measure) {
        cases_.push_back({name, [name, measure](Figures& figures) -> Result<void> {
                              auto measured = measure(figures);
                              if (measured) return measured;
                              return Error{measured.error().kind, name + ": " + measured.error().message};
                          }});
    }

    bool quick_;
    std::shared_ptr<ClipShelf> shelf_ = std::make_shared<ClipShelf>();
    std::vector<BenchCase> cases_;
};

}  // namespace

std::vector<BenchCase> paper_cases(bool quick) {
    return PaperSuite(quick).cases();
}

}  // namespace touchable
