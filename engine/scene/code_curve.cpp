#include "engine/scene/code_curve.hpp"

#include <cmath>

#include "engine/scene/terraces.hpp"

namespace touchable {
namespace {

/// Thus three of them have 16 bits.
constexpr double most_coefficient = 65535 / 3;

/// What is no number, of planes at the end of what doubles can tell, is the most.
std::uint16_t coefficient(double value) {
    return static_cast<std::uint16_t>(std::floor(std::min(most_coefficient, value) + 0.5));
}

/// Of what codes are even steps of: depth, or 1/depth.
struct Steps {
    double least, span;          // at distance 0, and how much more at the largest
    double constant, quadratic;  // the length in it: constant + quadratic (least + share of span)^2
};

Steps steps_of(const DepthCoding& coding, const DepthLength& length, int last) {
    switch (coding.kind) {
        case DepthCodingKind::metric:
            return {0, coding.scale * last, length.constant, length.quadratic};
        case DepthCodingKind::inverse: {
            // An error e of depth z is one of e/z^2 of 1/z.
            const double least = 1.0 / coding.far;
            return {least, 1.0 / coding.near - least, length.quadratic, length.constant};
        }
        case DepthCodingKind::linear:
        case DepthCodingKind::hue:
            break;
    }
    return {coding.near, coding.far - coding.near, length.constant, length.quadratic};
}

}  // namespace

CodeCurve code_curve(const DepthCoding& coding, const DepthLength& length, double times) {
    CodeCurve curve;
    const int last = largest_code(coding);
    curve.last = static_cast<std::uint16_t>(last);
    while (last << (curve.shift + 1) <= 65535) ++curve.shift;
    const bool grows_with_depth = coding.kind != DepthCodingKind::inverse;
    curve.from_last = coding.deeper_is_higher() != grows_with_depth;
    const Steps steps = steps_of(coding, length, last);
    if (!(steps.span > 0)) {  // planes so close that doubles do not tell their inverses apart
        curve.constant = curve.linear = curve.quadratic = coefficient(most_coefficient);
        return curve;
    }
    const double codes = times * last / steps.span;
    const double unit = 65536.0 / (last << curve.shift);  // of a share, in filled distances
    curve.constant = coefficient(codes * (steps.constant + steps.quadratic * steps.least * steps.least));
    curve.linear = coefficient(codes * 2 * steps.quadratic * steps.least * steps.span * unit);
    curve.quadratic = coefficient(codes * steps.quadratic * steps.span * steps.span * unit * unit);
    return curve;
}

}  // namespace touchable
