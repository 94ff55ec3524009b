#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// What one finger did in one tick, of a forces file (docs/forces.md).
struct ForceSample {
    glm::dvec3 goal{0.0};   ///< world, scene units
    glm::dvec3 force{0.0};  ///< N, guarded
    bool contact = false;
};

/// A forces file: `fingers` samples of each tick, ticks from 0 on.
struct ForceTable {
    int fingers = 0;
    std::vector<ForceSample> samples;

    std::size_t ticks() const { return samples.size() / static_cast<std::size_t>(fingers); }
    const ForceSample& at(std::size_t tick, int finger) const {
        return samples[tick * static_cast<std::size_t>(fingers) + static_cast<std::size_t>(finger)];
    }
};

/// Reads what `touch --forces` wrote. Refuses (ErrorKind::input, with file and line) a table without its
/// columns, and rows that are not every finger of every tick in order.
Result<ForceTable> read_force_table(const std::string& file);

}  // namespace touchable
