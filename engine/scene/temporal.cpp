#include "engine/scene/temporal.hpp"

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
    double constant, quadratic;  // noise in it: constant + quadratic (least + share of span)^2
};

Steps steps_of(const DepthCoding& coding, const DepthNoise& noise, int last) {
    switch (coding.kind) {
        case DepthCodingKind::metric:
            return {0, coding.scale * last, noise.constant, noise.quadratic};
        case DepthCodingKind::inverse: {
            // An error e of depth z is one of e/z^2 of 1/z.
            const double least = 1.0 / coding.far;
            return {least, 1.0 / coding.near - least, noise.quadratic, noise.constant};
        }
        case DepthCodingKind::linear:
        case DepthCodingKind::hue:
            break;
    }
    return {coding.near, coding.far - coding.near, noise.constant, noise.quadratic};
}

/// Half the noise is left by a median of 5x5, two thirds by one of 3x3; the gate is twice what is left.
double gate_per_noise(int median) {
    if (median == 5) return 1;
    return median == 3 ? 4.0 / 3.0 : 2;
}

TemporalGate gate_of(const DepthCoding& coding, const DepthNoise& noise, int median) {
    TemporalGate gate;
    const int last = largest_code(coding);
    gate.last = static_cast<std::uint16_t>(last);
    while (last << (gate.shift + 1) <= 65535) ++gate.shift;
    const bool grows_with_depth = coding.kind != DepthCodingKind::inverse;
    gate.from_last = coding.deeper_is_higher() != grows_with_depth;
    const Steps steps = steps_of(coding, noise, last);
    if (!(steps.span > 0)) {  // planes so close that doubles do not tell their inverses apart
        gate.constant = gate.linear = gate.quadratic = coefficient(most_coefficient);
        return gate;
    }
    const double codes = gate_per_noise(median) * last / steps.span;
    const double unit = 65536.0 / (last << gate.shift);  // of a share, in filled distances
    gate.constant = coefficient(codes * (steps.constant + steps.quadratic * steps.least * steps.least));
    gate.linear = coefficient(codes * 2 * steps.quadratic * steps.least * steps.span * unit);
    gate.quadratic = coefficient(codes * steps.quadratic * steps.span * steps.span * unit * unit);
    return gate;
}

}  // namespace

int TemporalGate::at(std::uint16_t code) const {
    const std::uint32_t n = static_cast<std::uint32_t>(from_last ? last - code : code) << shift;
    const std::uint32_t gate = constant + (linear * n >> 16) + (quadratic * (n * n >> 16) >> 16);
    return static_cast<int>(std::min<std::uint32_t>(gate, temporal_most_gate));
}

std::optional<TemporalFilter> temporal_filter(const Scene& scene) {
    if (!scene.filter.temporal) return std::nullopt;
    const int factor = std::max(terrace_factor(scene.depth), 1);
    const DepthCoding coding = finer(scene.depth, factor);
    return TemporalFilter{factor, gate_of(coding, scene.filter.temporal_noise, scene.filter.median), coding};
}

}  // namespace touchable
