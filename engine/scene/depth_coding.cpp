#include "engine/scene/depth_coding.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/logarithm.hpp"

namespace touchable {
namespace {

/// The code, as a real number, that would stand for `depth`; any number where there is none.
double real_code(const DepthCoding& coding, double depth) {
    if (coding.kind == DepthCodingKind::metric) return depth / coding.scale;
    const double shift = coding.shift, deep = 1.0 / (coding.far + shift);
    const double from_far = coding.kind == DepthCodingKind::inverse
                                ? (1.0 / (depth + shift) - deep) / (1.0 / (coding.near + shift) - deep)
                            : coding.kind == DepthCodingKind::log
                                ? logarithm((coding.far + shift) / (depth + shift)) / coding.log_span()
                                : (coding.far - depth) / (coding.far - coding.near);
    return coding.code_max * (coding.near_is_high ? from_far : 1.0 - from_far);
}

/// Whether codes stand for depths at all. Who makes a Scene derives the range before validate has its say.
bool has_depths(const DepthCoding& coding) {
    if (coding.code_max == 0) return false;
    const auto has_inverse = [](double plane) {
        return plane > 0 && std::isfinite(1.0 / plane) && std::isfinite(plane);
    };
    if (coding.kind == DepthCodingKind::log)
        return has_inverse(coding.near + coding.shift) && has_inverse(coding.far + coding.shift) &&
               coding.near < coding.far;
    return coding.kind != DepthCodingKind::inverse || (has_inverse(coding.near) && has_inverse(coding.far));
}

}  // namespace

double DepthCoding::log_span() const {
    return logarithm((far + shift) / (near + shift));
}

double DepthCoding::log_depth(double share) const {
    return (near + shift) * exponential((1.0 - share) * log_span()) - shift;
}

std::uint16_t DepthCoding::code(double depth) const {
    // The nearest code is one of the two around the real-valued one, or, where those are marked invalid, a
    // few on.
    constexpr int reach = max_invalid_codes + 2;
    const double target = depth > near ? std::min(depth, far) : near;  // a number even where depth is none
    const double estimate = std::floor(real_code(*this, target));
    int around = valid_min;
    if (estimate >= valid_max)
        around = valid_max;
    else if (estimate > valid_min)
        around = static_cast<int>(estimate);
    std::uint16_t best = valid_min;
    double best_distance = HUGE_VAL;
    for (int c = std::max<int>(valid_min, around - reach); c <= std::min<int>(valid_max, around + reach);
         ++c) {
        const auto candidate = static_cast<std::uint16_t>(c);
        const double distance = std::fabs(this->depth(candidate) - target);
        if (is_valid(candidate) && distance < best_distance) {
            best = candidate;
            best_distance = distance;
        }
    }
    return best;
}

void derive_valid_range(DepthCoding& coding) {
    const auto marked = coding.invalid_codes.begin() +
                        std::clamp(coding.invalid_code_count, 0, DepthCoding::max_invalid_codes);
    const auto fits = [&](int code) {
        const double depth = coding.depth(static_cast<std::uint16_t>(code));
        return depth > 0.0 && depth >= coding.near && depth <= coding.far &&
               std::find(coding.invalid_codes.begin(), marked, code) == marked;
    };
    int low = 0, high = has_depths(coding) ? coding.code_max : -1;
    while (low <= high && !fits(low)) ++low;
    while (high >= low && !fits(high)) --high;
    if (low > high) low = 1, high = 0;  // no code at all
    coding.valid_min = static_cast<std::uint16_t>(low);
    coding.valid_max = static_cast<std::uint16_t>(high);
}

}  // namespace touchable
