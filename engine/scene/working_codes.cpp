#include "engine/scene/working_codes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "engine/scene/terraces.hpp"

namespace touchable {
namespace {

// The gate is at most 5/4 factors and 3/4 of the noise: fewer than five factors.
static_assert(5 + 3 * most_terrace_noise < 4 * 5);

/// Metric codes that are to be multiplied by less are looked up: near a camera that sees far they would be
/// coarse (docs/real-depth.md).
constexpr int least_factor_of_lengths = 8, least_factor = 2;
/// Fewer working codes are not worth a table.
constexpr int fewest_codes = 255;
/// The deepest depth over the shift of looked-up codes. Their steps are then at most about a sixth of a
/// pixel's width from a fiftieth of the deepest depth on, and a fifteenth where they are finest.
constexpr double deepest_per_shift = 5;

/// Of the levels at the nearest and the deepest valid code the distance in codes, whichever is more; 0 where
/// every code is a level.
double most_codes_of_a_level(const Scene& scene) {
    const DepthCoding& coding = scene.depth;
    if (scene.filter.levels == DepthLength{}) return 0;
    double most = 0;
    for (const std::uint16_t code : {coding.valid_min, coding.valid_max}) {
        // Of planes that doubles cannot tell apart it is 0.
        const double step = std::max(step_of_code(coding, code), std::numeric_limits<double>::min());
        most = std::max(most, level_distance(scene, coding.depth(code)) / step);
    }
    return most;
}

/// How many times as many codes there can be; 0: the stored ones leave no room.
int factor_of(const Scene& scene) {
    const DepthCoding& coding = scene.depth;
    if (coding.kind == DepthCodingKind::log) return 0;  // no curve of levels is exact in its codes
    // Of the largest gate, in codes; see terrace_range.
    const double levels = most_codes_of_a_level(scene);
    const int last = largest_code(coding), gate = static_cast<int>(std::min(1.25 * levels, 32767.0));
    const int factor = terrace_range / (std::max(last, 255) + (levels > 0 ? std::max(gate + 4, 5) : 5));
    if (coding.kind != DepthCodingKind::metric) return factor < least_factor ? 0 : factor;
    return factor < least_factor_of_lengths ? 0
                                            : static_cast<int>(std::bit_floor(static_cast<unsigned>(factor)));
}

/// From the nearest depth on, ordered as the stored ones.
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
    // Of all codes, the share of one level at either end, where it is largest.
    const double ends = 1 / (coding.near + coding.shift) - 1 / (coding.far + coding.shift);
    if (!(ends > 0)) return std::nullopt;
    double most = 0;
    // Of log codes, which the curve has longer there than they are.
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

/// For every valid stored code the nearest working one.
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

}  // namespace

int largest_code(const DepthCoding& coding) {
    return coding.kind == DepthCodingKind::metric ? coding.valid_max : coding.code_max;
}

double step_of_code(const DepthCoding& coding, std::uint16_t code) {
    if (coding.valid_min >= coding.valid_max) return 0;
    code = std::min(code, static_cast<std::uint16_t>(coding.valid_max - 1));
    return std::fabs(coding.depth(static_cast<std::uint16_t>(code + 1)) - coding.depth(code));
}

DepthLength code_step(const DepthCoding& coding) {
    switch (coding.kind) {
        case DepthCodingKind::metric:
            return {coding.scale, 0};
        case DepthCodingKind::inverse:
            return {0, (1 / coding.near - 1 / coding.far) / coding.code_max};
        case DepthCodingKind::log:
            return length_along_depth(coding.log_span() / coding.code_max, coding.shift, coding.near,
                                      coding.far);
        case DepthCodingKind::linear:
        case DepthCodingKind::hue:
            break;
    }
    return {(coding.far - coding.near) / coding.code_max, 0};
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

}  // namespace touchable
