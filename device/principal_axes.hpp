#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>

namespace touchable {

/// The rotation (proper: determinant +1) that lays the direction of greatest variance of `points` along X,
/// the next along Y and that of least variance along Z. Of each of the first two directions the largest
/// component (the first of equals) is positive before the rotation, which fixes the signs. By Jacobi's
/// method, + - * / sqrt alone.
glm::dmat3 principal_rotation(std::span<const glm::dvec3> points);

}  // namespace touchable
