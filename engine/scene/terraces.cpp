#include "engine/scene/terraces.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace touchable {
namespace {

// The gate is at most 5/4 factors and 3/4 of the noise: fewer than five factors.
static_assert(5 + 3 * most_terrace_noise < 4 * 5);
static_assert(terrace_range / (largest_code_with_terraces + 5) == 2);
// Eight gates, which the sum of a pass may reach on its way (terrace_rows.cpp), at the largest factor and the
// most noise.
static_assert(8 * ((5 * TerraceFilter::most_level + 3 * most_terrace_noise * 126) / 4) <= 32767);
static_assert(terrace_range / (largest_code_with_terraces + 1 + 5) == 1);

/// Depth from a code to the next one, scene units; of the last code that from the one before it.
double step_of_code(const DepthCoding& coding, std::uint16_t code) {
    if (coding.valid_min >= coding.valid_max) return 0;
    code = std::min(code, static_cast<std::uint16_t>(coding.valid_max - 1));
    return std::fabs(coding.depth(static_cast<std::uint16_t>(code + 1)) - coding.depth(code));
}

/// Of the levels at the nearest and the deepest valid code the distance in codes, whichever is more; 0 where
/// every code is a level.
double most_codes_of_a_level(const Scene& scene) {
    const DepthCoding& coding = scene.depth;
    if (scene.filter.levels == DepthLength{} || coding.valid_min >= coding.valid_max) return 0;
    double most = 0;
    for (const std::uint16_t code : {coding.valid_min, coding.valid_max}) {
        // Of planes that doubles cannot tell apart it is 0.
        const double step = std::max(step_of_code(coding, code), std::numeric_limits<double>::min());
        most = std::max(most, level_distance(scene, coding.depth(code)) / step);
    }
    return most;
}

/// Levels of so many codes at the deepest one make up for rounding codes.
constexpr double least_level_to_round = 8;

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

DepthCoding scaled(const DepthCoding& coding, const CodeScale& scale) {
    if (scale.shift == 0) return finer(coding, scale.factor);
    DepthCoding result = finer(coding, 1);
    result.code_max = scale.of(largest_code(coding));
    result.scale = coding.scale * (1 << scale.shift);
    result.valid_min = scale.of(coding.valid_min);
    result.valid_max = scale.of(coding.valid_max);
    return result;
}

std::optional<CodeScale> terrace_scale(const Scene& scene) {
    const DepthCoding& coding = scene.depth;
    // Of the largest gate, in codes; see terrace_range.
    const double levels = most_codes_of_a_level(scene);
    const int last = largest_code(coding), gate = static_cast<int>(std::min(1.25 * levels, 32767.0));
    int factor = terrace_range / (std::max(last, 255) + (levels > 0 ? std::max(gate + 4, 5) : 5));
    if (coding.kind != DepthCodingKind::metric)
        return factor < 2 ? std::nullopt : std::optional(CodeScale{factor});
    if (factor >= 2) return CodeScale{static_cast<int>(std::bit_floor(static_cast<unsigned>(factor)))};
    for (const int shift : {1, 2})
        if (levels >= least_level_to_round &&
            CodeScale{1, shift}.of(last) + (gate >> shift) + 5 <= terrace_range)
            return CodeScale{1, shift};
    return std::nullopt;
}

double level_distance(const Scene& scene, double depth) {
    const DepthCoding& coding = scene.depth;
    const DepthLength& levels = scene.filter.levels;
    return std::max(step_of_code(coding, coding.code(depth)), levels.at(depth));
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
    return terrace_scale(scene) && kappa_of_scene(scene) >= kappa_of_terraces;
}

std::optional<TerraceFilter> terrace_filter(const Scene& scene) {
    const FilterSettings& settings = scene.filter;
    const bool wanted = settings.terraces == TerraceRemoval::on ||
                        (settings.terraces == TerraceRemoval::automatic && terraces_advised(scene));
    const auto scale = terrace_scale(scene);
    if (!wanted || !scale) return std::nullopt;
    const int noise =
        static_cast<int>(std::floor(settings.terrace_noise * scale->factor / (1 << scale->shift) + 0.5));
    const DepthCoding working = scaled(scene.depth, *scale);
    const CodeCurve levels =
        settings.levels == DepthLength{} ? CodeCurve{} : code_curve(working, settings.levels, 1.0);
    return TerraceFilter{settings.temporal ? CodeScale{} : *scale, scale->factor, levels, noise,
                         finer(working, 2)};
}

}  // namespace touchable
