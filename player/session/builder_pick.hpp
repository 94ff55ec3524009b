#pragma once

#include <functional>
#include <string>

#include "engine/scene/scene.hpp"

namespace touchable {

/// What decides which builder costs least: the forces are the same with any.
struct TouchLoad {
    Scene scene;        ///< as the run applies it
    bool moves = true;  ///< the clip has more than one frame
    int fingers = 1;
    bool live = false;  ///< ticks are due every millisecond of the wall clock
};

/// CPU time of whole frames by the CPU builder, but for hole filling, which depends on the holes, and of what
/// the lazy builder adds to ticks, all threads: ms for each second of the clip (docs/gpu-vs-cpu.md, where the
/// constants come from).
double whole_frames_ms_per_second(const TouchLoad& load);
double lazy_ms_per_second(const TouchLoad& load);

struct BuilderPick {
    std::string name;  ///< "cpu", "lazy" or "vulkan"
    std::string why;   ///< for a person, one line
};

/// What `--builder auto` is. `has_gpu`, which opens a device, is asked only where whole frames cost so much
/// that this pays: whether there is a GPU, and not a software Vulkan.
BuilderPick pick_builder(const TouchLoad& load, const std::function<bool()>& has_gpu);

}  // namespace touchable
