#include "engine/scene/terraces.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace touchable {
namespace {

// The gate is at most 5/4 factors and 3/4 of the noise: fewer than five factors.
static_assert(5 + 3 * most_terrace_noise < 4 * 5);
static_assert(terrace_range / (largest_code_with_terraces + 5) == 2);
static_assert(terrace_range / (largest_code_with_terraces + 1 + 5) == 1);

/// Depth from a code to the next one, scene units; of the last code that from the one before it.
double step_of_code(const DepthCoding& coding, std::uint16_t code) {
    if (coding.valid_min >= coding.valid_max) return 0;
    code = std::min(code, static_cast<std::uint16_t>(coding.valid_max - 1));
    return std::fabs(coding.depth(static_cast<std::uint16_t>(code + 1)) - coding.depth(code));
}

}  // namespace

int largest_code(const DepthCoding& coding) {
    return coding.kind == DepthCodingKind::metric ? coding.valid_max : coding.code_max;
}

// Numerator and denominator of a share of the way grow alike, so their quotient stays the same double; so
// does a metric code's depth, because there the factor is a power of two.
DepthCoding finer(const DepthCoding& coding, int factor) {
    const auto fine = [factor](int code) { return static_cast<std::uint16_t>(code * factor); };
    DepthCoding result = coding;
    result.code_max = fine(largest_code(coding));
    result.scale = coding.scale / factor;
    result.valid_min = fine(result.valid_min);
    result.valid_max = fine(result.valid_max);
    result.invalid_codes = {};  // between two valid codes there may be any
    result.invalid_code_count = 0;
    return result;
}

int terrace_factor(const Scene& scene) {
    const DepthCoding& coding = scene.depth;
    // Room for the largest gate, of the deepest or the nearest level; see terrace_range.
    int reserve = 5;
    if (scene.filter.levels != DepthLength{} && coding.valid_min <= coding.valid_max)
        for (const std::uint16_t code : {coding.valid_min, coding.valid_max}) {
            const double codes = level_distance(scene, coding.depth(code)) / step_of_code(coding, code);
            reserve = std::max(reserve, static_cast<int>(std::min(1.25 * codes, 32767.0)) + 4);
        }
    int factor = terrace_range / (std::max(largest_code(coding), 255) + reserve);
    if (coding.kind == DepthCodingKind::metric)
        factor = static_cast<int>(std::bit_floor(static_cast<unsigned>(factor)));
    return factor < 2 ? 0 : factor;
}

double level_distance(const Scene& scene, double depth) {
    const DepthCoding& coding = scene.depth;
    const DepthLength& levels = scene.filter.levels;
    return std::max(step_of_code(coding, coding.code(depth)),
                    levels.constant + levels.quadratic * depth * depth);
}

double kappa_of_depth(const Scene& scene, double depth) {
    if (scene.depth.valid_min >= scene.depth.valid_max) return 0;
    return level_distance(scene, depth) / (depth / scene.camera.fx);
}

double kappa_of_scene(const Scene& scene) {
    const DepthCoding& coding = scene.depth;
    return kappa_of_depth(scene, 0.5 * (coding.depth(coding.valid_min) + coding.depth(coding.valid_max)));
}

bool terraces_advised(const Scene& scene) {
    return terrace_factor(scene) > 0 && kappa_of_scene(scene) >= kappa_of_terraces;
}

std::optional<TerraceFilter> terrace_filter(const Scene& scene) {
    const FilterSettings& settings = scene.filter;
    const bool wanted = settings.terraces == TerraceRemoval::on ||
                        (settings.terraces == TerraceRemoval::automatic && terraces_advised(scene));
    const int factor = terrace_factor(scene);
    if (!wanted || factor == 0) return std::nullopt;
    const int noise = static_cast<int>(std::floor(settings.terrace_noise * factor + 0.5));
    const DepthCoding working = finer(scene.depth, factor);
    const CodeCurve levels =
        settings.levels == DepthLength{} ? CodeCurve{} : code_curve(working, settings.levels, 1.0);
    return TerraceFilter{settings.temporal ? 1 : factor, factor, levels, noise,
                         finer(scene.depth, 2 * factor)};
}

}  // namespace touchable
