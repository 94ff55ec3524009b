#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/surface_probe.hpp"
#include "engine/base/result.hpp"
#include "haptics_cpu/workspace.hpp"

namespace touchable {

/// Where goals come from: one per finger and tick. Deterministic: the same options, probe and ticks give the
/// same bits.
class Hand {
public:
    virtual ~Hand() = default;
    virtual int fingers() const = 0;
    /// Goals of tick `tick` (at `tick` ms), world, scene units. Ticks are asked for in order, from 0.
    virtual void goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) = 0;
    /// How many ticks its motion lasts, for a hand that has an end; afterwards it rests at its last goals.
    virtual std::optional<std::int64_t> ticks() const { return std::nullopt; }
    /// The file that its motion was read from, if any.
    virtual std::optional<std::string> file() const { return std::nullopt; }
    /// What is to be said of the goals it gave so far, for a person.
    virtual std::vector<std::string> remarks() const { return {}; }
};

/// Makes a hand from its description: "wander|stroke|press|poke[:key=value,...]" or
/// "csv:FILE[:key=value,...]" (docs/hands.md lists every key). An unknown name, key or an impossible value is
/// refused with the legal ones; a file that cannot be used is refused with its line and column. `probe` shows
/// frame 0; `fingers` is 1 to 256.
Result<std::unique_ptr<Hand>> make_hand(const std::string& description, int fingers,
                                        const Workspace& workspace, const SurfaceProbe& probe);

}  // namespace touchable
