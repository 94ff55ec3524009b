// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdio>
#include <sstream>
#include <variant>

#include "engine/surface/surface_builder.hpp"
#include "tests/content/exact_touch.hpp"
#include "tests/stress/golden_runs.hpp"
#include "tests/stress/suites.hpp"

namespace touchable::stress {
namespace {

// Where a change is meant to change forces, the failing test prints the new hashes; take them over only once
// GCC and Clang, -O0 and -O3 agree on them.
constexpr std::array<GoldenRun, 20> all_runs{{
    {"bumps", "817d61be00e3dfe8", "bumps", "stroke", 16, 1, TouchMetric::world, 0.6},
    {"bumps-8-bits-5-fingers", "72bff72d4ef0258a", "bumps", "stroke", 8, 5, TouchMetric::world, 0.6},
    {"bumps-pixels", "916303851c49d2b3", "bumps", "stroke", 16, 1, TouchMetric::pixel},
    {"rough", "841c5a046fc79f94", "rough", "stroke"},
    {"rough-5-fingers", "177aed15b51d93ab", "rough", "stroke", 10, 5, TouchMetric::world, 0.3},
    {"moving", "32e25f9d7d27a40a", "moving", "stroke", 16, 1, TouchMetric::world, 0.6},
    {"moving-held", "375e9a60f8acb4ba", "moving", "stroke", 16, 1, TouchMetric::world, 0, false, 0,
     FrameInterpolation::hold},
    {"globe", "35b49a4e455e9b67", "globe", "stroke"},
    {"globe-planet", "3dfebb33a4c8e124", "globe", "stroke", 16, 5, TouchMetric::world, 0, true},
    {"globe-pixels", "c577a9b47a62943a", "globe", "stroke", 16, 1, TouchMetric::pixel},
    {"noise", "9ca9810cf8ba486a", "noise", "walk"},
    {"noise-median", "a8259be27f89693f", "noise", "walk", 8, 5, TouchMetric::world, 0.4, false, 5},
    {"noise-pixels", "12f55b0931410f5d", "noise", "walk", 8, 1, TouchMetric::pixel, 0.4},
    {"cliffs", "dd448f15289ebdc4", "cliffs", "walk"},
    {"grain", "48a80ee5740979dd", "grain", "walk", 8, 1, TouchMetric::world, 0.6},
    {"plane", "8fb72ff71b7703ae", "plane", "skim", 16, 5, TouchMetric::world, 0.5},
    {"step", "d06095e85b28066e", "step", "skim", 8, 1, TouchMetric::world, 0.5},
    {"spheres", "8eac3b076f9de557", "spheres", "skim", 16, 1, TouchMetric::world, 0.2},
    {"bumps-soft-holes", "3e5d0909955dffc3", "bumps", "stroke", 8, 5, TouchMetric::world, 0.6, false, 0,
     FrameInterpolation::linear, 0.1},
    {"moving-soft-holes", "c1df7d36b47c26d8", "moving", "stroke", 8, 1, TouchMetric::world, 0.3, false, 0,
     FrameInterpolation::linear, 0.05},
}};

constexpr int width = 96, height = 64, frames_made = 4;

SceneOptions options_of(const GoldenRun& golden) {
    SceneOptions options;
    options.width = width;
    options.height = height;
    options.bits = golden.bits;
    options.properties = golden.properties;
    return options;
}

class SceneRun final : public StressRun {
public:
    SceneRun(const GoldenRun& golden, std::unique_ptr<AnalyticScene> content, GoldenBuilder builder)
        : StressRun(scene_of(golden, *content)),
          content_(std::move(content)),
          fingers_(static_cast<std::size_t>(golden.fingers)),
          frames_(golden.scene == "moving" || golden.properties ? frames_made : 1) {
        touch_.metric = golden.metric;
        const auto made =
            builder == GoldenBuilder::cpu ? make_cpu_builder(scene_) : make_lazy_builder(scene_);
        for (std::size_t n = 0; n < frames_.size(); ++n)
            made_ = made->build(content_->frame(static_cast<std::int64_t>(n)), frames_[n]) && made_;
        if (golden.hand == "walk") {
            hand_.emplace<RandomWalk>(scene_, 11);
        } else if (golden.hand == "skim") {
            hand_.emplace<Skim>(scene_, 11, Skim::Pace{0.3, 0.03, 300});
        } else if (golden.scene == "globe") {
            hand_.emplace<GlobeStroke>(CameraPreset::b, width, height);
        } else {
            const Relief relief = golden.scene == "rough"    ? Relief::rough
                                  : golden.scene == "moving" ? Relief::moving
                                                             : Relief::bumps;
            hand_.emplace<ReliefStroke>(relief, width, height, 0.2);
        }
    }

    std::size_t fingers() const override { return fingers_; }
    void next(std::int64_t tick, FramePair& pair, std::span<glm::dvec3> goals) override {
        const FrameRate& rate = scene_.rate;
        const std::int64_t time = tick * tick_ns;
        while (rate.time_ns(frame_ + 1) <= time) ++frame_;
        pair.prev = frame_at(frame_);
        pair.next = frame_at(frame_ + 1);
        pair.blend = static_cast<double>(time - pair.prev.time_ns) /
                     static_cast<double>(pair.next.time_ns - pair.prev.time_ns);
        const glm::dvec3 goal = next_goal(tick, *pair.prev.frame);
        for (std::size_t k = 0; k < goals.size(); ++k) {
            const auto aside = static_cast<double>(k);
            goals[k] = goal + glm::dvec3(2.5 * aside, -1.5 * aside, -0.125 * aside);
        }
    }
    /// A builder that refused would leave nothing to touch.
    std::string broken_promise(std::int64_t, std::span<const Contact>,
                               std::span<const GuardedForce>) override {
        return made_ ? "" : "a frame was refused by its builder";
    }

private:
    static Scene scene_of(const GoldenRun& golden, const AnalyticScene& content) {
        Scene scene = content.scene();
        if (!golden.properties) scene.default_properties = {600, golden.friction, golden.friction * 2 / 3};
        scene.filter.median = golden.median;
        scene.interpolation = golden.interpolation;
        if (golden.hole_stiffness > 0) {
            // Holes along a contour line, which moves where the scene does.
            scene.hole_stiffness = golden.hole_stiffness;
            scene.depth.invalid_codes[0] = static_cast<std::uint16_t>(scene.depth.code_max / 2);
            scene.depth.invalid_code_count = 1;
            derive_valid_range(scene.depth);
        }
        return scene;
    }
    TimedFrame frame_at(std::int64_t number) const {
        return {number, scene_.rate.time_ns(number),
                &frames_[static_cast<std::size_t>(number) % frames_.size()]};
    }
    glm::dvec3 next_goal(std::int64_t tick, const SurfaceFrame& frame) {
        if (auto* walk = std::get_if<RandomWalk>(&hand_)) return walk->next();
        if (auto* skim = std::get_if<Skim>(&hand_)) return skim->next(frame);
        if (auto* stroke = std::get_if<ReliefStroke>(&hand_)) return stroke->next().goal;
        return std::get<GlobeStroke>(hand_).at(static_cast<int>(tick)).goal;
    }

    std::unique_ptr<AnalyticScene> content_;
    std::size_t fingers_;
    std::vector<SurfaceFrame> frames_;
    std::variant<std::monostate, RandomWalk, Skim, ReliefStroke, GlobeStroke> hand_;
    std::int64_t frame_ = 0;
    bool made_ = true;
};

}  // namespace

std::unique_ptr<StressRun> GoldenRun::make(GoldenBuilder builder) const {
    auto content = make_scene(scene, options_of(*this));
    if (!content) return nullptr;
    return std::make_unique<SceneRun>(*this, std::move(content).value(), builder);
}

std::span<const GoldenRun> golden_runs() {
    return all_runs;
}

const GoldenRun* find_golden_run(std::string_view name) {
    const auto found = std::find_if(all_runs.begin(), all_runs.end(),
                                    [&](const GoldenRun& run) { return run.name == name; });
    return found == all_runs.end() ? nullptr : &*found;
}

}  // namespace touchable::stress
namespace touchable::stress {
namespace {

class Line {
public:
    Line& add(std::int64_t value) { return text(std::to_string(value)); }
    Line& add(double value) {
        std::array<char, 32> digits;
        std::snprintf(digits.data(), digits.size(), "%.17g", value);
        return text(digits.data());
    }
    Line& add(const glm::dvec3& v) { return add(v.x).add(v.y).add(v.z); }
    const std::string& str() const { return line_; }

private:
    Line& text(const std::string& cell) {
        line_ += (line_.empty() ? "" : ",") + cell;
        return *this;
    }
    std::string line_;
};

std::string line_of(const TouchTick& tick, const FingerState& finger, std::size_t k) {
    const Contact& contact = tick.contacts[k];
    const Proxy& proxy = finger.proxy;
    Line line;
    line.add(tick.tick).add(static_cast<std::int64_t>(k));
    line.add(tick.pair.prev.number).add(tick.pair.next.number).add(tick.blend);
    line.add(contact.goal).add(static_cast<std::int64_t>(contact.goal_held));
    line.add(static_cast<std::int64_t>(proxy.feature)).add(proxy.i).add(proxy.j).add(proxy.a).add(proxy.b);
    line.add(static_cast<std::int64_t>(proxy.sliding)).add(contact.proxy);
    line.add(std::int64_t{contact.counts.events}).add(static_cast<std::int64_t>(contact.counts.capped));
    line.add(contact.properties.stiffness);
    line.add(contact.properties.static_friction).add(contact.properties.dynamic_friction);
    line.add(contact.force).add(tick.forces[k].force).add(std::int64_t{tick.forces[k].reasons});
    return line.str();
}

std::vector<std::string> cells_of(const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    return cells;
}

std::string header() {
    std::string line;
    for (const std::string& field : state_fields()) line += (line.empty() ? "" : ",") + field;
    return line;
}

/// Where two lines of the same place part.
std::string parting(const std::string& now, const std::string& recorded) {
    const auto cells = cells_of(now), others = cells_of(recorded);
    const std::string where = "tick " + cells[0] + ", finger " + cells[1];
    for (std::size_t k = 0; k < cells.size(); ++k)
        if (k >= others.size() || cells[k] != others[k])
            return where + ", field " + state_fields()[k] + ": " + cells[k] + ", recorded " +
                   (k < others.size() ? others[k] : "nothing");
    return where + ": the recorded line goes on";
}

}  // namespace

const std::vector<std::string>& state_fields() {
    static const std::vector<std::string> fields{"tick",
                                                 "finger",
                                                 "frame_prev",
                                                 "frame_next",
                                                 "blend",
                                                 "goal_x",
                                                 "goal_y",
                                                 "goal_z",
                                                 "goal_held",
                                                 "feature",
                                                 "i",
                                                 "j",
                                                 "a",
                                                 "b",
                                                 "sliding",
                                                 "proxy_x",
                                                 "proxy_y",
                                                 "proxy_z",
                                                 "events",
                                                 "capped",
                                                 "stiffness",
                                                 "mu_static",
                                                 "mu_dynamic",
                                                 "solver_force_x",
                                                 "solver_force_y",
                                                 "solver_force_z",
                                                 "force_x",
                                                 "force_y",
                                                 "force_z",
                                                 "guard"};
    return fields;
}

StateWriter::StateWriter(std::ostream& out) : out_(out) {
    out_ << header() << '\n';
}

void StateWriter::take(const TouchTick& tick, std::span<const FingerState> fingers) {
    for (std::size_t k = 0; k < fingers.size(); ++k) out_ << line_of(tick, fingers[k], k) << '\n';
}

StateComparison::StateComparison(std::istream& recorded) : recorded_(recorded) {
    std::string first;
    std::getline(recorded_, first);
    if (first != header()) difference_ = "the recorded states have other fields";
}

void StateComparison::take(const TouchTick& tick, std::span<const FingerState> fingers) {
    for (std::size_t k = 0; k < fingers.size() && !difference_; ++k) {
        const std::string now = line_of(tick, fingers[k], k);
        std::string then;
        if (!std::getline(recorded_, then))
            difference_ = "tick " + std::to_string(tick.tick) + ", finger " + std::to_string(k) +
                          ": the recorded run has ended";
        else if (now != then)
            difference_ = parting(now, then);
    }
}

std::optional<std::string> StateComparison::difference() {
    std::string more;
    if (!difference_ && std::getline(recorded_, more)) difference_ = "the recorded run goes on: " + more;
    return difference_;
}

}  // namespace touchable::stress
