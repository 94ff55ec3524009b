#pragma once

#include <cstdint>

#include "engine/base/vectors.hpp"
#include "engine/scene/code_curve.hpp"

namespace touchable {

/// As many values of 32 bits.
template <class Narrow>
struct Wide {
    using Lanes [[gnu::vector_size(2 * sizeof(Narrow))]] = std::uint32_t;
};

/// The upper half of a product.
template <class Lanes>
[[gnu::always_inline]] inline Lanes high_product(const Lanes& a, const Lanes& b) {
    return __builtin_convertvector((__builtin_convertvector(a, typename Wide<Lanes>::Lanes) *
                                    __builtin_convertvector(b, typename Wide<Lanes>::Lanes)) >>
                                       16,
                                   Lanes);
}

/// CodeCurve::at of every lane.
template <class Lanes>
[[gnu::always_inline]] inline Lanes curve_at(const CodeCurve& curve, const Lanes& codes) {
    const Lanes constant = Lanes{} + curve.constant;
    if ((curve.linear | curve.quadratic) == 0) return constant;
    const Lanes n = (curve.from_last ? curve.last - codes : codes) << curve.shift;
    // Wide products are slow, and most curves lack one.
    Lanes sum = constant;
    if (curve.quadratic > 0) sum += high_product<Lanes>(high_product<Lanes>(n, n), Lanes{} + curve.quadratic);
    if (curve.linear > 0) {
        const Lanes sloped = high_product<Lanes>(n, Lanes{} + curve.linear);
        sum = curve.falls ? sum - lesser<Lanes>(sum, sloped) : sum + sloped;
    }
    return lesser<Lanes>(sum, Lanes{} + std::uint16_t{code_curve_most});
}

}  // namespace touchable
