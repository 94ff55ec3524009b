#include "device/principal_axes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace touchable {
namespace {

glm::dmat3 scatter(std::span<const glm::dvec3> points) {
    glm::dvec3 mean(0);
    for (const glm::dvec3& p : points) mean += p;
    mean /= static_cast<double>(points.size());
    glm::dmat3 sum(0.0);
    for (const glm::dvec3& p : points) sum += glm::outerProduct(p - mean, p - mean);
    return sum;
}

/// One Jacobi rotation: makes m[p][q] zero; the columns of `vectors` turn with it.
void rotate_away(glm::dmat3& m, glm::dmat3& vectors, int p, int q) {
    if (m[p][q] == 0) return;
    const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
    const double t = (theta < 0 ? -1.0 : 1.0) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
    const double c = 1 / std::sqrt(t * t + 1);
    const double s = t * c;
    glm::dmat3 turn(1.0);
    turn[p][p] = turn[q][q] = c;
    turn[q][p] = s;
    turn[p][q] = -s;
    m = glm::transpose(turn) * m * turn;
    m[p][q] = m[q][p] = 0;
    vectors = vectors * turn;
}

glm::dvec3 with_fixed_sign(const glm::dvec3& axis) {
    int largest = 0;
    for (int i = 1; i < 3; ++i) {
        if (std::fabs(axis[i]) > std::fabs(axis[largest])) largest = i;
    }
    return axis[largest] < 0 ? -axis : axis;
}

}  // namespace

glm::dmat3 principal_rotation(std::span<const glm::dvec3> points) {
    glm::dmat3 m = scatter(points);
    glm::dmat3 vectors(1.0);
    constexpr int sweeps = 16;  // quadratic convergence: six or seven sweeps reach the last bit
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        rotate_away(m, vectors, 0, 1);
        rotate_away(m, vectors, 0, 2);
        rotate_away(m, vectors, 1, 2);
    }
    std::array<int, 3> order{0, 1, 2};
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return m[a][a] > m[b][b]; });
    const glm::dvec3 x = with_fixed_sign(glm::normalize(vectors[order[0]]));
    const glm::dvec3 y = with_fixed_sign(glm::normalize(vectors[order[1]]));
    return glm::transpose(glm::dmat3(x, y, glm::cross(x, y)));
}

}  // namespace touchable
