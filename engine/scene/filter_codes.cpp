// SPDX-License-Identifier: Apache-2.0
#include "engine/scene/filter_codes.hpp"

#include <limits>

namespace touchable {

namespace {

/// Three coefficients together fit 16 bits.
constexpr double most_coefficient = 65535 / 3;

/// NaN, from planes at the limits of doubles, becomes the largest coefficient.
std::uint16_t coefficient(double value) {
    return static_cast<std::uint16_t>(std::floor(std::min(most_coefficient, value) + 0.5));
}

/// A length in codes at the share t of the largest distance: constant + linear t + quadratic t^2.
struct Polynomial {
    double constant, linear, quadratic;
};

/// `of` (a + b t)^2.
Polynomial squared(double of, double a, double b) {
    return {of * a * a, of * 2 * a * b, of * b * b};
}

/// No polynomial is exact for log codes; this one is at both planes and in the middle between them.
std::optional<Polynomial> length_in_log_codes(const DepthCoding& coding, const DepthLength& length,
                                              int last) {
    const double way = coding.log_span();
    if (!(way > 0)) return std::nullopt;
    const auto codes_at = [&](double depth) {
        return last * length.at(depth) / ((depth + coding.shift) * way);
    };
    const double least = codes_at(coding.near), middle = codes_at(coding.log_depth(0.5)),
                 most = codes_at(coding.far);
    return Polynomial{least, 4 * middle - 3 * least - most, std::max(0.0, 2 * (least + most) - 4 * middle)};
}

/// Returns nullopt if doubles cannot tell the planes apart.
std::optional<Polynomial> length_in_codes(const DepthCoding& coding, const DepthLength& length, int last) {
    if (coding.kind == DepthCodingKind::log) return length_in_log_codes(coding, length, last);
    if (coding.kind != DepthCodingKind::inverse) {
        const bool is_metric = coding.kind == DepthCodingKind::metric;
        const double least = is_metric ? 0 : coding.near;
        const double span = is_metric ? coding.scale * last : coding.far - coding.near;
        if (!(span > 0)) return std::nullopt;
        const Polynomial grows = squared(length.quadratic, least, span);
        const double codes = last / span;
        return Polynomial{codes * (length.constant + grows.constant), codes * grows.linear,
                          codes * grows.quadratic};
    }
    // An error e of depth z is an error e w^2 of w = 1/(z + shift), and z w = 1 - shift w.
    const double least = 1.0 / (coding.far + coding.shift);
    const double span = 1.0 / (coding.near + coding.shift) - least;
    if (!(span > 0)) return std::nullopt;
    const Polynomial even = squared(length.constant, least, span),
                     grows = squared(length.quadratic, 1 - coding.shift * least, -coding.shift * span);
    const double codes = last / span;
    return Polynomial{codes * (even.constant + grows.constant), codes * (even.linear + grows.linear),
                      codes * (even.quadratic + grows.quadratic)};
}

// The gate is at most 5/4 of the factor and 3/4 of the noise: less than five factors.
static_assert(5 + 3 * most_terrace_noise < 4 * 5);

/// Metric codes with a smaller factor are looked up: near a camera that sees far, multiplied ones would be
/// coarse (docs/measurements.md).
constexpr int least_factor_of_lengths = 8, least_factor = 2;
/// Fewer working codes are not worth a table.
constexpr int fewest_codes = 255;
/// The deepest depth divided by the shift of looked-up codes. Their steps are then at most about a sixth of a
/// pixel's width from a fiftieth of the deepest depth on, and a fifteenth at their finest.
constexpr double deepest_per_shift = 5;

/// Distance between levels in codes, at the nearest or the deepest valid code, whichever is more; 0 if every
/// code is a level.
double most_codes_of_a_level(const Scene& scene) {
    const DepthCoding& coding = scene.depth;
    if (scene.filter.levels == DepthLength{}) return 0;
    double most = 0;
    for (const std::uint16_t code : {coding.valid_min, coding.valid_max}) {
        // The step is 0 if doubles cannot tell the planes apart.
        const double step = std::max(step_of_code(coding, code), std::numeric_limits<double>::min());
        most = std::max(most, level_distance(scene, coding.depth(code)) / step);
    }
    return most;
}

/// The factor of multiplied codes; 0: the stored codes leave no room.
int factor_of(const Scene& scene) {
    const DepthCoding& coding = scene.depth;
    if (coding.kind == DepthCodingKind::log) return 0;  // no curve of levels is exact in its codes
    // The room for the largest gate, in codes; see terrace_range.
    const double levels = most_codes_of_a_level(scene);
    const int last = largest_code(coding), gate = static_cast<int>(std::min(1.25 * levels, 32767.0));
    const int factor = terrace_range / (std::max(last, 255) + (levels > 0 ? std::max(gate + 4, 5) : 5));
    if (coding.kind != DepthCodingKind::metric) return factor < least_factor ? 0 : factor;
    return factor < least_factor_of_lengths ? 0
                                            : static_cast<int>(std::bit_floor(static_cast<unsigned>(factor)));
}

/// The coding of looked-up codes, from the nearest depth on, in the order of the stored codes.
std::optional<DepthCoding> looked_up_coding(const Scene& scene) {
    const DepthCoding& stored = scene.depth;
    DepthCoding coding = stored;
    coding.kind = DepthCodingKind::inverse;
    coding.near_is_high = !stored.deeper_is_higher();
    coding.near = stored.nearest_depth();
    coding.far = stored.deepest_depth();
    coding.scale = 0;
    coding.shift = coding.far / deepest_per_shift;
    coding.invalid_code_count = 0;
    coding.invalid_codes = {};
    // The largest share of all codes that one level takes, at one of the ends.
    const double ends = 1 / (coding.near + coding.shift) - 1 / (coding.far + coding.shift);
    if (!(ends > 0)) return std::nullopt;
    double most = 0;
    // For log codes, the curve is longer at the ends than the steps are.
    const DepthLength steps = stored.kind == DepthCodingKind::log ? code_step(stored) : DepthLength{};
    for (const double depth : {coding.near, coding.far}) {
        const double beyond = depth + coding.shift;
        const double level = std::max(level_distance(scene, depth), steps.at(depth));
        most = std::max(most, level / (beyond * beyond * ends));
    }
    most *= 1 + 0.6 * scene.filter.terrace_noise;
    const double codes = std::floor((terrace_range - 8) / (1 + 1.25 * most));
    if (!(codes >= fewest_codes)) return std::nullopt;
    coding.code_max = static_cast<std::uint16_t>(codes);
    coding.valid_min = 0;
    coding.valid_max = coding.code_max;
    return coding;
}

/// Maps every valid stored code to the nearest working code.
std::vector<std::uint16_t> table_of(const DepthCoding& stored, const DepthCoding& working) {
    std::vector<std::uint16_t> table(65536, 0);
    const double last = working.code_max, from = 1 / (working.far + working.shift);
    const double per_share = last / (1 / (working.near + working.shift) - from);
    for (int code = stored.valid_min; code <= stored.valid_max; ++code) {
        const double depth = stored.depth(static_cast<std::uint16_t>(code));
        const double from_far = std::clamp((1 / (depth + working.shift) - from) * per_share, 0.0, last);
        table[static_cast<std::size_t>(code)] =
            static_cast<std::uint16_t>((working.near_is_high ? from_far : last - from_far) + 0.5);
    }
    return table;
}

// The sum of a pass may reach eight gates on its way (engine/surface/terrace_filter.cpp), at the largest
// factor and the most noise.
static_assert(8 * ((5 * TerraceFilter::most_level + 3 * most_terrace_noise * 126) / 4) <= 32767);

/// `times` the length, in codes of `coding`.
CodeCurve code_curve(const DepthCoding& coding, const DepthLength& length, double times) {
    CodeCurve curve;
    const int last = largest_code(coding);
    curve.last = static_cast<std::uint16_t>(last);
    while (last << (curve.shift + 1) <= 65535) ++curve.shift;
    const bool grows_with_depth = coding.kind != DepthCodingKind::inverse;
    curve.from_last = coding.deeper_is_higher() != grows_with_depth;
    const auto scaled = length_in_codes(coding, length, last);
    if (!scaled) {
        curve.constant = curve.linear = curve.quadratic = coefficient(most_coefficient);
        return curve;
    }
    const double unit = 65536.0 / (last << curve.shift);  // from shares to shifted distances
    curve.falls = scaled->linear < 0;
    curve.constant = coefficient(times * scaled->constant);
    curve.linear = coefficient(times * std::fabs(scaled->linear) * unit);
    curve.quadratic = coefficient(times * scaled->quadratic * unit * unit);
    return curve;
}

/// The filter for looked-up codes, whose steps differ: noise widens both lengths by three fifths of itself,
/// as it widens the gate.
TerraceFilter looked_up_filter(const Scene& scene, const WorkingCodes& working) {
    const DepthLength step = code_step(scene.depth), &levels = scene.filter.levels;
    const double noise = 0.6 * scene.filter.terrace_noise;
    const auto wider = [&](const DepthLength& length) {
        return DepthLength{length.constant + noise * step.constant,
                           length.quadratic + noise * step.quadratic};
    };
    TerraceFilter filter;
    filter.working = working;
    filter.step = 1;
    // The curves may be differences, and a level may be two codes. The largest level has room for two digits.
    filter.fraction = 2;
    filter.steps = code_curve(working.coding, wider(step), 4.0);
    if (!(levels == DepthLength{})) filter.levels = code_curve(working.coding, wider(levels), 4.0);
    return filter;
}

TerraceFilter multiplied_filter(const Scene& scene, const WorkingCodes& working) {
    const FilterSettings& settings = scene.filter;
    TerraceFilter filter;
    filter.working = working;
    filter.step = working.factor;
    filter.noise = static_cast<int>(std::floor(settings.terrace_noise * working.factor + 0.5));
    if (!(settings.levels == DepthLength{})) filter.levels = code_curve(working.coding, settings.levels, 1.0);
    return filter;
}

/// A 5x5 median leaves half of the noise, a 3x3 median two thirds; the gate is twice what is left.
double gate_per_noise(int median) {
    if (median == 5) return 1;
    return median == 3 ? 4.0 / 3.0 : 2;
}

}  // namespace

DepthLength length_along_depth(double share, double shift, double near, double far) {
    // The chord equals the length at both ends, and is too short in between.
    const double quadratic = share / (far + near);
    const DepthLength chord{share * (near + shift) - quadratic * near * near, quadratic};
    double least = 1;
    for (int part = 1; part < 64; ++part) {
        const double depth = near + (far - near) * part / 64;
        least = std::min(least, chord.at(depth) / (share * (depth + shift)));
    }
    return chord.times(2 / (1 + least));
}

int largest_code(const DepthCoding& coding) {
    return coding.kind == DepthCodingKind::metric ? coding.valid_max : coding.code_max;
}

double step_of_code(const DepthCoding& coding, std::uint16_t code) {
    if (coding.valid_min >= coding.valid_max) return 0;
    code = std::min(code, static_cast<std::uint16_t>(coding.valid_max - 1));
    return std::fabs(coding.depth(static_cast<std::uint16_t>(code + 1)) - coding.depth(code));
}

DepthLength code_step(const DepthCoding& coding) {
    if (coding.kind == DepthCodingKind::metric) return {coding.scale, 0};
    if (coding.kind == DepthCodingKind::inverse)
        return {0, (1 / coding.near - 1 / coding.far) / coding.code_max};
    if (coding.kind == DepthCodingKind::log)
        return length_along_depth(coding.log_span() / coding.code_max, coding.shift, coding.near, coding.far);
    return {(coding.far - coding.near) / coding.code_max, 0};
}

// Numerator and denominator of a share grow by the same factor, so their quotient stays the same double; so
// does a metric code's depth, because its factor is a power of two.
DepthCoding finer(const DepthCoding& coding, int factor) {
    const auto fine = [factor](int code) { return static_cast<std::uint16_t>(code * factor); };
    DepthCoding result = coding;
    result.code_max = fine(largest_code(coding));
    result.scale = coding.scale / factor;
    result.valid_min = fine(result.valid_min);
    result.valid_max = fine(result.valid_max);
    result.invalid_codes = {};  // any code between two valid ones may occur
    result.invalid_code_count = 0;
    return result;
}

WorkingCodes unchanged_codes(const DepthCoding& coding) {
    return {1, nullptr, finer(coding, 1)};
}

bool has_working_codes(const Scene& scene) {
    if (scene.depth.valid_min >= scene.depth.valid_max) return false;
    return factor_of(scene) > 0 || looked_up_coding(scene);
}

std::optional<WorkingCodes> working_codes(const Scene& scene) {
    if (scene.depth.valid_min >= scene.depth.valid_max) return std::nullopt;
    if (const int factor = factor_of(scene); factor > 0)
        return WorkingCodes{factor, nullptr, finer(scene.depth, factor)};
    const auto coding = looked_up_coding(scene);
    if (!coding) return std::nullopt;
    return WorkingCodes{1, std::make_shared<const std::vector<std::uint16_t>>(table_of(scene.depth, *coding)),
                        *coding};
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
    return has_working_codes(scene) && kappa_of_scene(scene) >= kappa_of_terraces;
}

std::optional<TerraceFilter> terrace_filter(const Scene& scene) {
    const FilterSettings& settings = scene.filter;
    const bool wanted = settings.terraces == TerraceRemoval::on ||
                        (settings.terraces == TerraceRemoval::automatic && terraces_advised(scene));
    if (!wanted) return std::nullopt;
    const auto working = working_codes(scene);
    if (!working) return std::nullopt;
    TerraceFilter filter =
        working->table ? looked_up_filter(scene, *working) : multiplied_filter(scene, *working);
    filter.reach = settings.terrace_reach;
    filter.coding = finer(working->coding, 2);
    if (settings.temporal) filter.working = unchanged_codes(working->coding);
    return filter;
}

std::optional<FlyingPixels> flying_pixels(const Scene& scene) {
    if (scene.filter.flying_pixels == DepthLength{}) return std::nullopt;
    return FlyingPixels{code_curve(scene.depth, scene.filter.flying_pixels, 1)};
}

std::optional<TemporalFilter> temporal_filter(const Scene& scene) {
    if (!scene.filter.temporal) return std::nullopt;
    // Looked-up codes are fewer; that pays only for terraces, and for log codes, in which no gate is exact.
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
