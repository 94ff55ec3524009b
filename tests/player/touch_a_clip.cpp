// SPDX-License-Identifier: Apache-2.0
// A program of one's own that touches a clip: any file that touchable opens, one finger that presses, and the
// hash of its forces. It links the room `player/run` and what opens files: no window, no Vulkan, no options.
#include <cstdio>

#include "engine/formats/open_clip.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/run/touch_session.hpp"

using namespace touchable;

namespace {

class Forces final : public TouchSink {
public:
    Result<void> consume(const TouchTick& tick) override {
        for (const GuardedForce& finger : tick.forces) hash.add(finger.force);
        return {};
    }
    ForceHash hash;
};

Result<std::string> touch(const char* file) {
    auto clip = open_clip(file);
    if (!clip) return clip.error();
    const Scene scene = (*clip)->scene();
    SurfaceFeed feed(std::move(*clip), make_cpu_builder(scene), scene);
    const auto first = feed.pair_at(0);
    if (!first) return first.error();
    const HeightField field(scene, *first);
    const Workspace workspace = clip_workspace(scene, *first->prev.frame);
    auto hand = make_hand("press", 1, workspace, FieldProbe(field));
    if (!hand) return hand.error();
    TouchSessionSettings settings;
    settings.touch.metres_per_scene_unit = workspace.metres_per_scene_unit;
    const auto solver = TouchSolver::create(scene, settings.touch);
    if (!solver) return solver.error();
    Forces forces;
    TouchSink* const sinks[] = {&forces};
    if (auto ran = TouchSession(feed, **hand, *solver, settings).run(sinks); !ran) return ran.error();
    return forces.hash.hex();
}

}  // namespace

int main(int count, char** words) {
    if (count != 2) return std::fputs("touch_a_clip FILE\n", stderr), 2;
    const auto hash = touch(words[1]);
    if (!hash) return std::fprintf(stderr, "%s\n", hash.error().message.c_str()), 1;
    std::printf("%s\n", hash->c_str());
    return 0;
}
