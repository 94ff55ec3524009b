#include "engine/base/logarithm.hpp"

#include <cmath>
#include <cstddef>
#include <limits>

namespace touchable {
namespace {

/// ln 2 in two parts; the first has 21 zero bits at its end, so that its product with a whole number below
/// 2^21 is exact.
constexpr double ln2_high = 0x1.62e42feep-1, ln2_low = 0x1.a39ef35793c76p-33;
constexpr double per_ln2 = 0x1.71547652b82fep+0;

/// The sum of terms[k] x^k.
template <std::size_t n>
double series_sum(const double (&terms)[n], double x) {
    double sum = terms[n - 1];
    for (std::size_t k = n - 1; k-- > 0;) sum = sum * x + terms[k];
    return sum;
}

}  // namespace

double exponential(double x) {
    if (std::isnan(x)) return x;
    if (x > 710) return std::numeric_limits<double>::infinity();
    if (x < -746) return 0;
    // x = powers ln 2 + rest + lost, |rest| <= ln(2)/2: Taylor's series leaves less than 2^-58.
    constexpr double terms[] = {1.0 / 2,         1.0 / 6,          1.0 / 24,          1.0 / 120,
                                1.0 / 720,       1.0 / 5040,       1.0 / 40320,       1.0 / 362880,
                                1.0 / 3628800.0, 1.0 / 39916800.0, 1.0 / 479001600.0, 1.0 / 6227020800.0};
    const double powers = std::floor(x * per_ln2 + 0.5);
    const double high = x - powers * ln2_high, low = powers * ln2_low;
    const double rest = high - low, lost = (high - rest) - low;
    return std::ldexp(1 + (rest + (rest * rest * series_sum(terms, rest) + lost)), static_cast<int>(powers));
}

double logarithm(double x) {
    if (std::isnan(x) || x < 0) return std::numeric_limits<double>::quiet_NaN();
    if (x == 0) return -std::numeric_limits<double>::infinity();
    if (std::isinf(x)) return x;
    // x = 2^powers (1 + f), 1 + f from sqrt(1/2) to sqrt(2); ln(1 + f) is 2 artanh(s), whose series in s
    // begins with 2 s = f - s f.
    constexpr double terms[] = {2.0 / 3,  2.0 / 5,  2.0 / 7,  2.0 / 9,  2.0 / 11,
                                2.0 / 13, 2.0 / 15, 2.0 / 17, 2.0 / 19, 2.0 / 21};
    int powers = 0;
    double fraction = std::frexp(x, &powers);
    if (fraction < 0x1.6a09e667f3bcdp-1) {
        fraction *= 2;
        --powers;
    }
    const double f = fraction - 1, s = f / (2 + f), square = s * s, half = 0.5 * f * f;
    const double beyond = square * series_sum(terms, square);
    return powers * ln2_high - ((half - (s * (half + beyond) + powers * ln2_low)) - f);
}

}  // namespace touchable
