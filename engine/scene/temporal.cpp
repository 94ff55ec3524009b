#include "engine/scene/temporal.hpp"

#include <algorithm>

#include "engine/scene/terraces.hpp"

namespace touchable {
namespace {

/// Half the noise is left by a median of 5x5, two thirds by one of 3x3; the gate is twice what is left.
double gate_per_noise(int median) {
    if (median == 5) return 1;
    return median == 3 ? 4.0 / 3.0 : 2;
}

}  // namespace

std::optional<TemporalFilter> temporal_filter(const Scene& scene) {
    if (!scene.filter.temporal) return std::nullopt;
    // Looked-up codes are fewer, which is worth it for terraces, and for log codes, of which no gate is
    // exact.
    auto working = working_codes(scene);
    const bool is_log = scene.depth.kind == DepthCodingKind::log;
    if (!working || (working->table && !is_log && !terrace_filter(scene)))
        working = unchanged_codes(scene.depth);
    const DepthCoding& coding = working->coding;
    const CodeCurve gate =
        code_curve(coding, scene.filter.temporal_noise, gate_per_noise(scene.filter.median));
    return TemporalFilter{*working, gate, coding};
}

}  // namespace touchable
