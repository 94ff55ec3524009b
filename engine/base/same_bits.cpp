// SPDX-License-Identifier: Apache-2.0
#define XXH_INLINE_ALL
#define XXH_NO_XXH3  // XXH64 alone; XXH3 of some versions takes WebAssembly for NEON

#include "engine/base/same_bits.hpp"

#include <xxhash.h>
#include <cmath>
#include <limits>

#include "engine/base/words.hpp"

namespace touchable {
namespace {

constexpr double half_pi = 0x1.921fb54442d18p+0, half_pi_low = 0x1.1a62633145c07p-54;

/// The sum of coefficients[k] x^k.
template <std::size_t n>
double polynomial(const double (&coefficients)[n], double x) {
    double sum = coefficients[n - 1];
    for (std::size_t k = n - 1; k-- > 0;) sum = sum * x + coefficients[k];
    return sum;
}

/// A value as an unevaluated sum, |low| at most half an ulp of high.
struct TwoDoubles {
    double high, low;
};

/// a - b without loss.
TwoDoubles difference(double a, double b) {
    const double high = a - b;
    const double b_used = a - high, a_used = high + b_used;
    return {high, (a - a_used) - (b - b_used)};
}

/// x = quarter_turns pi/2 + rest with |rest| <= pi/4 (a hair more at the seams).
struct Reduced {
    int quarter_turns;  ///< modulo 4
    TwoDoubles rest;
};

/// Cody and Waite's reduction. pi/2 is cut into parts of 33 bits, so that up to 2^20 quarter turns each
/// product but the last is exact; four parts leave a rest with 50 good bits even for the double nearest to a
/// multiple of pi/2, where the first 100 bits cancel.
Reduced reduce(double x) {
    constexpr double part1 = 0x1.921fb544p+0, part2 = 0x1.0b4611a6p-34, part3 = 0x1.3198a2ep-69,
                     part4 = 0x1.b839a252049c1p-104;
    constexpr double exact_up_to = 0x1p20;
    if (std::fabs(x) > exact_up_to) x = std::fmod(x, 4.0 * half_pi);  // fewer good digits, still an angle
    const double turns = std::floor(x * (2.0 / pi) + 0.5);
    if (turns == 0.0) return {0, {x, 0.0}};
    const TwoDoubles first = difference(x - turns * part1, turns * part2);
    const TwoDoubles second = difference(first.high, turns * part3);
    const double tail = first.low + second.low - turns * part4;
    const double high = second.high + tail;
    const double quadrant = turns - 4.0 * std::floor(turns * 0.25);
    return {static_cast<int>(quadrant), {high, (second.high - high) + tail}};
}

/// Taylor series; its relative error is below 2^-60 for |x| <= pi/4.
double sine_near_zero(TwoDoubles x) {
    constexpr double series[] = {-1.0 / 6,
                                 1.0 / 120,
                                 -1.0 / 5040,
                                 1.0 / 362880,
                                 -1.0 / 39916800.0,
                                 1.0 / 6227020800.0,
                                 -1.0 / 1307674368000.0,
                                 1.0 / 355687428096000.0};
    const double square = x.high * x.high;
    return x.high + (x.high * square * polynomial(series, square) + x.low * (1.0 - 0.5 * square));
}

double cosine_near_zero(TwoDoubles x) {
    constexpr double series[] = {
        1.0 / 24,          -1.0 / 720,           1.0 / 40320,           -1.0 / 3628800,
        1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0};
    const double square = x.high * x.high, half = 0.5 * square;
    const double leading = 1.0 - half;
    const double lost = (1.0 - leading) - half;
    return leading + (lost + (square * square * polynomial(series, square) - x.high * x.low));
}

/// Angles of slope 0, 1/8, .. 1.
constexpr TwoDoubles angle_of_eighths[] = {
    {0.0, 0.0},
    {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
    {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
    {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
    {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
    {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
    {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
    {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
    {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55},
};

/// Arctangent of a slope in [0, 1]: the angle of the eighth below it, plus the series of what remains (<
/// 1/8). high + low, not normalised.
TwoDoubles angle_of_slope(double slope) {
    constexpr double series[] = {-1.0 / 3,  1.0 / 5,  -1.0 / 7,  1.0 / 9,
                                 -1.0 / 11, 1.0 / 13, -1.0 / 15, 1.0 / 17};
    const double eighths = std::floor(slope * 8.0), base = eighths * 0.125;
    const double rest = (slope - base) / (1.0 + slope * base);  // the difference is exact (Sterbenz)
    const double square = rest * rest;
    const TwoDoubles angle = angle_of_eighths[static_cast<std::size_t>(eighths)];
    const double correction = rest * square * polynomial(series, square) + angle.low;
    if (eighths == 0.0) return {rest, correction};
    return {angle.high, rest + correction};
}

/// Angle of the point (x, y), both at least 0, not both 0; in [0, pi/2].
double angle_in_first_quadrant(double y, double x) {
    if (x == y) return half_pi * 0.5;  // also if both are infinite
    if (y < x) {
        const TwoDoubles angle = angle_of_slope(y / x);
        return angle.high + angle.low;
    }
    const TwoDoubles angle = angle_of_slope(x / y);
    return half_pi - (angle.high + (angle.low - half_pi_low));
}

/// ln 2 in two parts; the first has 21 zero bits at its end, so that its product with a whole number below
/// 2^21 is exact.
constexpr double ln2_high = 0x1.62e42feep-1, ln2_low = 0x1.a39ef35793c76p-33;
constexpr double per_ln2 = 0x1.71547652b82fep+0;

}  // namespace

double sine(double x) {
    if (!std::isfinite(x)) return x - x;
    const Reduced r = reduce(x);
    const double value = r.quarter_turns % 2 == 0 ? sine_near_zero(r.rest) : cosine_near_zero(r.rest);
    return r.quarter_turns < 2 ? value : -value;
}

double cosine(double x) {
    if (!std::isfinite(x)) return x - x;
    const Reduced r = reduce(x);
    const double value = r.quarter_turns % 2 == 0 ? cosine_near_zero(r.rest) : sine_near_zero(r.rest);
    return r.quarter_turns == 0 || r.quarter_turns == 3 ? value : -value;
}

double arctangent(double x) {
    return arctangent2(x, 1.0);
}

double arctangent2(double y, double x) {
    if (std::isnan(x) || std::isnan(y)) return x + y;
    if (x == 0.0 && y == 0.0) return 0.0;
    const double acute = angle_in_first_quadrant(std::fabs(y), std::fabs(x));
    const double angle = x < 0.0 ? 2.0 * half_pi - (acute - 2.0 * half_pi_low) : acute;
    return y < 0.0 ? -angle : angle;
}

double arcsine(double x) {
    // (arcsin(s)/s - 1)/s^2 as a polynomial in s^2 on [0, 1/4]: interpolated at Chebyshev nodes, 2^-57 of
    // arcsin.
    constexpr double series[] = {
        0x1.5555555555556p-3, 0x1.3333333332ecap-4, 0x1.6db6db6e31f13p-5, 0x1.f1c71c1db0623p-6,
        0x1.6e8bb1c8209a2p-6, 0x1.1c4d35cf95421p-6, 0x1.c9cf07674736ap-7, 0x1.782651caa6547p-7,
        0x1.52420b04b37bep-7, 0x1.65a9c4dfcf8b2p-8, 0x1.1d189408314eep-6, -0x1.e6aaa8a0a04ccp-7,
        0x1.d72b2bc8155f8p-6,
    };
    const double magnitude = std::fabs(x);
    if (magnitude >= 1.0) return x < 0.0 ? -half_pi : half_pi;
    if (magnitude <= 0.5) {
        const double square = x * x;
        return x + x * square * polynomial(series, square);
    }
    // arcsin(m) = pi/2 - 2 arcsin(s), summed around pi/4, where 2s lies.
    const double square = (1.0 - magnitude) * 0.5, s = std::sqrt(square);
    const double correction = 2.0 * s * square * polynomial(series, square) - half_pi_low;
    const double angle = 0.5 * half_pi + ((0.5 * half_pi - 2.0 * s) - correction);
    return x < 0.0 ? -angle : angle;
}

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
    return std::ldexp(1 + (rest + (rest * rest * polynomial(terms, rest) + lost)), static_cast<int>(powers));
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
    const double beyond = square * polynomial(terms, square);
    return powers * ln2_high - ((half - (s * (half + beyond) + powers * ln2_low)) - f);
}

struct ByteHash::State {
    XXH64_state_t xxh;
};

ByteHash::ByteHash() : state_(std::make_unique<State>()) {
    XXH64_reset(&state_->xxh, 0);
}
ByteHash::~ByteHash() = default;

void ByteHash::add(const void* bytes, std::size_t size) {
    XXH64_update(&state_->xxh, bytes, size);
}

void ByteHash::each_state(StateBytes& bytes) {
    XXH64_state_t& xxh = state_->xxh;
    bytes(xxh.total_len, xxh.memsize);
    for (auto& lane : xxh.v) bytes(lane);
    for (auto& waiting : xxh.mem64) bytes(waiting);
    bytes.expect(xxh.memsize < sizeof xxh.mem64);
    if (!bytes.is_sound()) XXH64_reset(&xxh, 0);
}

std::uint64_t ByteHash::value() const {
    return XXH64_digest(&state_->xxh);
}

std::string ByteHash::hex() const {
    return formatted("%016llx", static_cast<unsigned long long>(value()));
}

std::uint64_t StateBytes::word(std::uint64_t bits) {
    if (!reads_) {
        for (int shift = 0; shift < 64; shift += 8)
            written_.push_back(static_cast<std::uint8_t>(bits >> shift));
        return bits;
    }
    expect(from_.size() >= 8);
    if (!sound_) return 0;
    bits = 0;
    for (int shift = 0; shift < 64; shift += 8)
        bits |= std::uint64_t{from_[static_cast<std::size_t>(shift / 8)]} << shift;
    from_ = from_.subspan(8);
    return bits;
}

}  // namespace touchable
