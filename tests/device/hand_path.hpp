// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "device/hand.hpp"
#include "tests/device/fake_driver.hpp"

// Paths of a hand over a made-up surface.
namespace touchable {

using Path = std::vector<glm::dvec3>;

inline const Workspace workspace = default_workspace(640, 500, 800);

/// Goals tick by tick, fingers inner.
inline Path run(const std::string& description, const SurfaceProbe& probe, int fingers = 1,
                int ticks = 4000) {
    Result<std::unique_ptr<Hand>> hand = make_hand(description, fingers, workspace, probe);
    if (!hand) {
        ADD_FAILURE() << hand.error().message;
        return {};
    }
    Path path(static_cast<std::size_t>(ticks * fingers));
    for (int tick = 0; tick < ticks; ++tick) {
        const auto first = static_cast<std::size_t>(tick * fingers);
        (*hand)->goals_at(tick, probe, std::span(path).subspan(first, static_cast<std::size_t>(fingers)));
    }
    return path;
}

inline bool is_under(const glm::dvec3& goal, const SurfaceProbe& probe) {
    const glm::dvec3 seen = probe.project(goal);
    const std::optional<double> surface = probe.depth_under(seen.x, seen.y);
    return surface && seen.z > *surface;
}

/// Share of goals under the surface.
inline double share_under(const Path& path, const SurfaceProbe& probe) {
    std::size_t under = 0;
    for (const glm::dvec3& goal : path) under += is_under(goal, probe) ? 1 : 0;
    return static_cast<double>(under) / static_cast<double>(path.size());
}

}  // namespace touchable
