// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <string>
#include <utility>

#include "bench/real/real_cases.hpp"
#include "bench/suite.hpp"
#include "bench/touch/following_run.hpp"
#include "bench/touch/frame_change_run.hpp"
#include "bench/touch/globe_run.hpp"
#include "bench/touch/proven_run.hpp"
#include "bench/touch/steadiness_run.hpp"
#include "bench/touch/timing_run.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

struct Size {
    int width, height;
};
constexpr Size qvga{320, 240}, sd{720, 480}, hd{1280, 720}, full_hd{1920, 1080}, ultra_hd{3840, 2160};

/// Collects the cases; cases with the same surface are adjacent.
class TouchSuite {
public:
    explicit TouchSuite(bool quick) : quick_(quick) {}

    std::vector<BenchCase> cases() {
        for (const Size size : {qvga, sd, hd, full_hd}) add_bumps(size);
        add_timing(setup("bumps", ultra_hd));
        for (const Size size : {qvga, sd, hd, full_hd}) add_rough(size);
        for (const Size size : {qvga, sd, hd, full_hd})
            if (!quick_ || size.width == qvga.width) add_moving(size);
        for (const Size size : {sd, full_hd}) add_globe(setup("globe", size));
        if (!quick_)
            for (const CameraPreset preset : {CameraPreset::a, CameraPreset::a_prime}) {
                TouchCase c = setup("globe", sd);
                c.preset = preset;
                add_globe(c);
            }
        add_steadiness();
        std::ranges::move(real_cases(quick_), std::back_inserter(cases_));
        return std::move(cases_);
    }

private:
    static TouchCase setup(std::string scene, Size size) {
        TouchCase c;
        c.scene = std::move(scene);
        c.width = size.width;
        c.height = size.height;
        return c;
    }

    /// A case whose surface is made, or taken from the shelf, when it is measured.
    template <class Run, class Measure>
    void add(const Run& run, Measure measure) {
        cases_.push_back(
            {name_of(run.setup), [shelf = shelf_, run, measure](Figures& figures) -> Result<void> {
                 TRY_ASSIGN(const auto surface, shelf->take(run.setup));
                 auto measured = measure(*surface, run, figures);
                 if (measured) return measured;
                 return Error{measured.error().kind, name_of(run.setup) + ": " + measured.error().message};
             }});
    }

    void add_steadiness() {
        const auto hold = FrameInterpolation::hold;
        for (const SteadinessRun& run : {SteadinessRun{"off"},
                                         {"temporal", true},
                                         {"temporal-wide", true, 1.5},
                                         {"temporal-ungated", true, 1e9},
                                         {"off-hold", false, 1, hold},
                                         {"temporal-hold", true, 1, hold}})
            cases_.push_back({"noisy-320x240-16-48f-world-" + run.name,
                              [run](Figures& figures) { return measure_steadiness(run, figures); }});
    }

    void add_bumps(Size size) {
        TouchCase c = setup("bumps", size);
        add_timing(c);
        if (size.width == full_hd.width) {
            for (const int fingers : {5, 10}) {
                c.fingers = fingers;
                add_timing(c);
            }
            c.fingers = 1;
            c.metric = TouchMetric::pixel;
            add_timing(c);
        }
        if (!quick_ || size.width == qvga.width || size.width == full_hd.width)
            add_following(setup("bumps", size));
    }

    void add_timing(const TouchCase& c) {
        TimingRun run{c};
        if (quick_) run.repeats = 15;
        if (c.width == ultra_hd.width) run.repeats = 40;  // as most of it is in no cache
        const bool world = c.metric == TouchMetric::world;
        if (c.width == full_hd.width && c.fingers == 1 && world) run.paced_ticks = quick_ ? 3000 : 30000;
        add(run, measure_timing);
    }

    void add_following(TouchCase c) {
        for (const auto& [speed, word] : speeds) {
            c.run = std::string("follow-") + word;
            add(FollowingRun{c, speed, quick_ ? 10000 : 30000}, measure_following);
        }
    }

    void add_rough(Size size) {
        TouchCase c = setup("rough", size);
        if (size.width == sd.width || size.width == full_hd.width) add_timing(c);
        for (const auto& [speed, word] : speeds) {
            c.run = std::string("proven-") + word;
            add(ProvenRun{c, speed, quick_ ? 5000 : 30000}, measure_proof);
        }
    }

    void add_moving(Size size) {
        TouchCase c = setup("moving", size);
        add_following(c);
        c.run = "frames";
        add(FrameChangeRun{c, quick_ ? 10000 : 30000}, measure_frame_changes);
        c.hold = true;
        add_following(c);
    }

    void add_globe(TouchCase c) {
        for (const int bits : {TouchCase::exact, 16, 10, 8}) {
            c.bits = bits;
            add_metrics(c);
            if (bits == 16) add_proof(c);
        }
        add_without_terraces(c);
        for (const int median : {3, 5}) {
            c.median = median;
            add_metrics(c);
        }
        c.lazy = true;
        for (const int median : {0, 3, 5}) {
            c.median = median;
            add_metrics(c);
        }
    }

    void add_without_terraces(TouchCase c) {
        c.terraces = true;
        for (const int bits : {10, 8}) {
            c.bits = bits;
            add_metric(c);
        }
        c.lazy = true;
        add_metric(c);
    }

    void add_proof(TouchCase c) {
        c.run = "proven";
        add(ProvenRun{c}, measure_proof);
    }

    void add_metrics(TouchCase c) {
        for (const TouchMetric metric : {TouchMetric::world, TouchMetric::pixel, TouchMetric::scaled}) {
            c.metric = metric;
            add_metric(c);
        }
    }

    void add_metric(const TouchCase& c) {
        GlobeRun run{c};
        if (quick_) {
            run.repeats = 3;
            run.loop_step_mm = 0.004;
        }
        // The lazy builder gives the same bits and forces as the other builder, so only its time is measured.
        run.flanks = c.lazy ? 0 : quick_ ? 4 : 8;
        add(run, measure_globe);
    }

    static constexpr std::array speeds{std::pair{0.05, "0.05"}, std::pair{0.1, "0.1"},
                                       std::pair{0.3, "0.3"}};  // m/s

    bool quick_;
    std::shared_ptr<SurfaceShelf> shelf_ = std::make_shared<SurfaceShelf>();
    std::vector<BenchCase> cases_;
};

}  // namespace

std::vector<BenchCase> touch_cases(bool quick) {
    return TouchSuite(quick).cases();
}

}  // namespace touchable
