#include "engine/surface/fitted_length.hpp"

namespace touchable {

DepthLength fitted_length(const std::vector<LengthAtDepth>& all) {
    double ones = 0, squares = 0, fourths = 0, lengths = 0, products = 0;
    for (const LengthAtDepth& one : all) {
        const double weight = one.weight / (one.length * one.length), z2 = one.depth * one.depth;
        ones += weight;
        squares += weight * z2;
        fourths += weight * z2 * z2;
        lengths += weight * one.length;
        products += weight * z2 * one.length;
    }
    if (all.empty()) return {};
    const double determinant = ones * fourths - squares * squares;
    if (determinant > 1e-9 * ones * fourths) {
        const double constant = (lengths * fourths - products * squares) / determinant;
        const double quadratic = (ones * products - squares * lengths) / determinant;
        if (constant >= 0 && quadratic >= 0) return {constant, quadratic};
        if (constant < 0) return {0, products / fourths};
    }
    return {lengths / ones, 0};
}

}  // namespace touchable
