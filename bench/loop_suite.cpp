// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "bench/loop/stability.hpp"
#include "bench/suite.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

struct Pixel {
    double across, down;  // as shares of the picture
};
// Away from the picture's middle, from its axes and from the lattice's symmetries.
constexpr Pixel places[] = {{0.53, 0.47}, {0.37, 0.58}, {0.61, 0.66}};

/// <case of touch>-b<damping>, then -d<ticks of delay>, -f<friction, N>, -q<quantum, um> if they apply.
std::string name_of(const LoopCase& c) {
    std::string name = name_of(c.touch) + formatted("-b%g", c.handle.damping);
    if (c.delay_ticks > 0) name += "-d" + std::to_string(c.delay_ticks);
    if (c.handle.friction > 0) name += formatted("-f%g", c.handle.friction);
    if (c.handle.quantum > 0) name += formatted("-q%g", c.handle.quantum * 1e6);
    return name;
}

Result<void> measure(const TouchSurface& surface, const LoopCase& c, std::size_t pressed, Figures& figures) {
    double least = highest_stiffness, largest = 0;
    for (std::size_t k = 0; k < pressed; ++k) {
        const int x = static_cast<int>(places[k].across * c.touch.width);
        const int y = static_cast<int>(places[k].down * c.touch.height);
        TRY_ASSIGN(const auto boundary, stability_boundary(surface, c, pressed_place(surface, x, y)));
        least = std::min(least, boundary);
        largest = std::max(largest, boundary);
    }
    const auto add = [&](const char* metric, double newtons_per_metre) {
        figures.push_back({metric, newtons_per_metre / 1000, "N/mm"});
    };
    add("boundary_n_per_mm", least);
    add("boundary_n_per_mm_max", largest);
    add("colgate_schenkel_n_per_mm", colgate_schenkel_bound(c.handle));
    add("gil_n_per_mm", gil_bound(c.handle, c.delay_ticks));
    add("abbott_okamura_n_per_mm", abbott_okamura_bound(c.handle));
    const double theory = std::min(gil_bound(c.handle, c.delay_ticks), abbott_okamura_bound(c.handle));
    figures.push_back({"boundary_over_theory", least / theory, ""});
    return {};
}

/// Collects the cases; cases with the same surface are adjacent.
class LoopSuite {
public:
    explicit LoopSuite(bool quick) : quick_(quick) {}

    std::vector<BenchCase> cases() {
        for (const std::string_view scene : scene_names()) {
            LoopCase c;
            c.touch.scene = scene;
            if (scene == "noise" || scene == "cliffs" || scene == "grain")
                c.touch.width = c.touch.height = 128;
            else if (scene == "moving" || quick_)
                c.touch.width = 320, c.touch.height = 240;
            for (const TouchMetric metric : {TouchMetric::world, TouchMetric::pixel}) {
                c.touch.metric = metric;
                add_damping_and_delay(c);
                if (scene == "plane" || scene == "globe" || scene == "bumps") add_friction_and_quantum(c);
            }
        }
        return std::move(cases_);
    }

private:
    void add_damping_and_delay(LoopCase c) {
        const std::vector<double> all{0.5, 1, 2, 5, 10}, some{1, 5};
        for (const double damping : quick_ ? some : all) {
            c.handle.damping = damping;
            for (const int delay : {0, 1, 2}) {
                c.delay_ticks = delay;
                add(c);
            }
        }
    }
    /// 60 um: resolution of a Falcon's encoders at its tip.
    void add_friction_and_quantum(LoopCase c) {
        c.handle.quantum = 60e-6;
        const std::vector<double> all{0.05, 0.1, 0.2, 0.4, 0.8}, some{0.1, 0.4};
        for (const double damping : {1.0, 5.0})
            for (const double friction : quick_ ? some : all) {
                c.handle.damping = damping;
                c.handle.friction = friction;
                add(c);
            }
    }
    void add(const LoopCase& c) {
        const std::size_t pressed = quick_ ? 1 : std::size(places);
        cases_.push_back(
            {name_of(c), [shelf = shelf_, c, pressed](Figures& figures) -> Result<void> {
                 TRY_ASSIGN(const auto surface, shelf->take(c.touch));
                 auto measured = measure(*surface, c, pressed, figures);
                 if (measured) return measured;
                 return Error{measured.error().kind, name_of(c) + ": " + measured.error().message};
             }});
    }

    bool quick_;
    std::shared_ptr<SurfaceShelf> shelf_ = std::make_shared<SurfaceShelf>();
    std::vector<BenchCase> cases_;
};

}  // namespace

std::vector<BenchCase> loop_cases(bool quick) {
    return LoopSuite(quick).cases();
}

}  // namespace touchable
