#include "engine/scene/code_curve.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/scene/working_codes.hpp"

namespace touchable {
namespace {

/// Thus three of them have 16 bits.
constexpr double most_coefficient = 65535 / 3;

/// What is no number, of planes at the end of what doubles can tell, is the most.
std::uint16_t coefficient(double value) {
    return static_cast<std::uint16_t>(std::floor(std::min(most_coefficient, value) + 0.5));
}

/// A length in codes, t being the share of the largest distance: constant + linear t + quadratic t^2.
struct Polynomial {
    double constant, linear, quadratic;
};

/// `of` (a + b t)^2.
Polynomial squared(double of, double a, double b) {
    return {of * a * a, of * 2 * a * b, of * b * b};
}

/// Of log codes no polynomial is exact: this one is at both planes and in the middle between them.
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

/// Nothing where planes are so close that doubles do not tell them apart.
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
    // An error e of depth z is one of e w^2 of w = 1/(z + shift), and z w = 1 - shift w.
    const double least = 1.0 / (coding.far + coding.shift);
    const double span = 1.0 / (coding.near + coding.shift) - least;
    if (!(span > 0)) return std::nullopt;
    const Polynomial even = squared(length.constant, least, span),
                     grows = squared(length.quadratic, 1 - coding.shift * least, -coding.shift * span);
    const double codes = last / span;
    return Polynomial{codes * (even.constant + grows.constant), codes * (even.linear + grows.linear),
                      codes * (even.quadratic + grows.quadratic)};
}

}  // namespace

DepthLength length_along_depth(double share, double shift, double near, double far) {
    // As long as it at both ends, and too short in between.
    const double quadratic = share / (far + near);
    const DepthLength chord{share * (near + shift) - quadratic * near * near, quadratic};
    double least = 1;
    for (int part = 1; part < 64; ++part) {
        const double depth = near + (far - near) * part / 64;
        least = std::min(least, chord.at(depth) / (share * (depth + shift)));
    }
    return chord.times(2 / (1 + least));
}

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
    const double unit = 65536.0 / (last << curve.shift);  // of a share, in filled distances
    curve.falls = scaled->linear < 0;
    curve.constant = coefficient(times * scaled->constant);
    curve.linear = coefficient(times * std::fabs(scaled->linear) * unit);
    curve.quadratic = coefficient(times * scaled->quadratic * unit * unit);
    return curve;
}

}  // namespace touchable
