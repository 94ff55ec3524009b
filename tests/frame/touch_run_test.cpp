// SPDX-License-Identifier: Apache-2.0
// A moment of a run, saved and taken up again in another: by another builder, with the same forces to the
// bit.
#include "engine/run/touch_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "engine/content/scenes.hpp"

namespace touchable::test {
namespace {

using Builder = std::function<std::unique_ptr<SurfaceBuilder>(const Scene&)>;
using Bytes = std::vector<std::uint8_t>;

constexpr std::int64_t frames = 45, ticks = 1800, second = 300;
constexpr int fingers = 2;

/// Two fingers that circle in and out of a made clip, in virtual time.
class Circling {
public:
    Circling(const std::string& content, const std::function<void(Scene&)>& change, const Builder& builder,
             std::vector<PlaybackCommand> commands = {}, double max_force = 5)
        : content_(
              make_scene(content, {.width = 96, .height = 72, .properties = content == "globe"}).value()),
          scene_(changed(content_->scene(), change)),
          surface(scene_, builder(scene_)),
          run(surface, std::make_shared<PlaybackLog>(std::move(commands)), solver(), guard(max_force),
              fingers) {}

    void feed() {
        const MediaMoment moment = run.moment();
        FramePair pair;
        while (!surface.has(moment)) {
            surface.timeline().pair_at(moment, pair);
            const auto number = surface.wanted(moment, frames);
            if (!number) return;
            ASSERT_TRUE(surface.give(surface.taken(content_->frame(*number))));
        }
    }
    std::vector<glm::dvec3> tick(std::int64_t tick) {
        run.meet(tick);
        feed();
        run.meet(tick);
        const double turn = 0.004 * static_cast<double>(tick);
        for (int k = 0; k < fingers; ++k)
            run.goals()[static_cast<std::size_t>(k)] =
                middle() * (1 + 0.03 * std::sin(7 * turn + k)) +
                0.1 * middle().z * glm::dvec3(std::sin(turn), std::cos(turn + k), 0);
        std::vector<glm::dvec3> forces;
        for (const GuardedForce& force : run.solve().forces) forces.push_back(force.force);
        return forces;
    }

private:
    static Scene changed(Scene scene, const std::function<void(Scene&)>& change) {
        if (change) change(scene);
        return scene;
    }
    static GuardSettings guard(double max_force) {
        GuardSettings guard;
        guard.max_force = max_force;
        return guard;
    }
    TouchSolver solver() const {
        return TouchSolver::create(scene_, {.metres_per_scene_unit = 0.2 / scene_.depth.far}).value();
    }
    glm::dvec3 middle() const { return {0, 0, -content_->depth(48, 36, 0)}; }

    std::unique_ptr<AnalyticScene> content_;
    Scene scene_;

public:
    SurfaceQueue surface;
    TouchRun run;
};

struct Case {
    const char* content;
    void (*change)(Scene&);
    std::vector<PlaybackCommand> commands;
};
const Case kCases[] = {{"globe", [](Scene& scene) { scene.filter.median = 3; }, {}},
                       {"moving",
                        [](Scene& scene) { scene.interpolation = FrameInterpolation::hold; },
                        {{100, PlaybackVerb::loop, 200'000'000, 700'000'000},
                         {900, PlaybackVerb::seek, 1'000'000'000, 0},
                         {1200, PlaybackVerb::rate, 500, 0},
                         {1500, PlaybackVerb::unloop, 0, 0}}},
                       {"noise",
                        [](Scene& scene) {
                            scene.filter.temporal = true;
                            scene.filter.temporal_noise.constant = 4 * scene.depth.level();
                        },
                        {{700, PlaybackVerb::seek, 900'000'000, 0}}}};

std::unique_ptr<SurfaceBuilder> by_cpu(const Scene& scene) {
    return make_cpu_builder(scene);
}

TEST(TouchRun, GoesOnFromSavedMomentByAnotherBuilder) {
    std::mt19937 random(5);
    for (const Case& c : kCases) {
        Circling whole(c.content, c.change, by_cpu, c.commands);
        std::vector<std::vector<glm::dvec3>> forces;
        std::vector<Bytes> saved;
        double most = 0;
        for (std::int64_t tick = 0; tick < ticks; ++tick) {
            forces.push_back(whole.tick(tick));
            saved.push_back(tick % 25 == 0 || tick % second == second - 1 ? whole.run.save() : Bytes());
            for (const glm::dvec3& force : forces.back()) most = std::max(most, std::abs(force.z));
        }
        EXPECT_GT(most, 0.5) << c.content << ": nothing was touched";
        for (int moment = 0; moment < 6; ++moment) {
            const std::int64_t at = 25 * static_cast<std::int64_t>(random() % ((ticks - second) / 25));
            const bool remembers = c.content == std::string("noise");
            Circling later(c.content, c.change, remembers ? make_reference_builder : make_lazy_builder);
            ASSERT_TRUE(later.run.load(saved[static_cast<std::size_t>(at)]));
            later.feed();
            const auto resumed = later.run.resume();
            ASSERT_TRUE(resumed) << c.content << " at " << at << ": " << resumed.error().message;
            EXPECT_EQ(later.run.save(), saved[static_cast<std::size_t>(at)]);
            for (std::int64_t tick = at + 1; tick <= at + second; ++tick) {
                ASSERT_EQ(later.tick(tick), forces[static_cast<std::size_t>(tick)])
                    << c.content << ' ' << at << ' ' << tick;
                const Bytes& same = saved[static_cast<std::size_t>(tick)];
                if (!same.empty()) {
                    ASSERT_EQ(later.run.save(), same);
                }
            }
        }
    }
}

TEST(TouchRun, RefusesWhatItCannotGoOnFrom) {
    const auto made = [](const char* content, double max_force,
                         const std::function<void(Scene&)>& change = {}) {
        return std::make_unique<Circling>(content, change, by_cpu, std::vector<PlaybackCommand>(), max_force);
    };
    const auto one = made("moving", 5);
    for (std::int64_t tick = 0; tick < 200; ++tick) one->tick(tick);
    const Bytes saved = one->run.save();
    const auto with = [&saved](std::size_t at, std::uint8_t value) {
        Bytes bytes = saved;
        bytes[at] = value;
        return bytes;
    };
    const auto softer = [](Scene& scene) { scene.default_properties.stiffness *= 0.5; };
    const struct {
        std::unique_ptr<Circling> into;
        Bytes bytes;
        const char* line;
    } refusals[] = {
        {made("moving", 5), {}, "no saved moment"},
        {made("moving", 5), with(0, 0), "no saved moment"},
        {made("moving", 5), with(8, 99), "of version 99"},
        {made("moving", 5), with(16, 99), "of rules of force 99"},
        {made("moving", 5), with(400, static_cast<std::uint8_t>(saved[400] ^ 1)), "damaged"},
        {made("moving", 5), Bytes(saved.begin(), saved.end() - 8), "damaged"},
        {made("moving", 6), saved, "another scene, other settings"},
        {made("moving", 5, softer), saved, "another scene, other settings"},
        {made("rough", 5), saved, "another scene, other settings"},
    };
    for (const auto& [into, bytes, line] : refusals) {
        const auto loaded = into->run.load(bytes);
        ASSERT_FALSE(loaded) << line;
        EXPECT_NE(loaded.error().message.find(line), std::string::npos) << loaded.error().message;
        EXPECT_EQ(into->tick(0), made("moving", 5)->tick(0)) << "a refusal changed something";
    }
    const auto early = made("moving", 5);
    early->tick(0);
    ASSERT_TRUE(early->run.load(saved));
    const auto resumed = early->run.resume();
    ASSERT_FALSE(resumed);
    EXPECT_NE(resumed.error().message.find("saved on frames 5 and 6"), std::string::npos)
        << resumed.error().message;
}

}  // namespace
}  // namespace touchable::test
