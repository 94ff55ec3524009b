#include "engine/content/cube_grid.hpp"

#include <cmath>
#include <glm/geometric.hpp>

namespace touchable {
namespace {

/// The tangent of an evened one, 0 to 1, by Newton; `evened` rises everywhere there.
double tangent_of(double even) {
    using namespace cube_grid;
    double tangent = even;
    for (int round = 0; round < 30; ++round) {
        const double square = tangent * tangent;
        tangent -= (evened(tangent) - even) / (even_1 + square * (3 * even_3 + square * 5 * even_5));
    }
    return tangent;
}

}  // namespace

CubeGrid::CubeGrid(int cells)
    : cells_(cells),
      row_(static_cast<std::size_t>(cells) + 1),
      tangent_(static_cast<std::size_t>(cells) + 1) {
    const int half = cells / 2;
    for (int k = 0; k <= half; ++k) {
        const double tangent = k == half ? 1.0 : tangent_of(static_cast<double>(k) / half);
        tangent_[static_cast<std::size_t>(half + k)] = tangent;
        tangent_[static_cast<std::size_t>(half - k)] = -tangent;
    }
}

glm::dvec3 CubeGrid::direction(int face, int i, int j) const {
    const int axis = face / 2;
    glm::dvec3 at;
    at[axis] = face % 2 == 0 ? 1 : -1;
    at[(axis + 1) % 3] = tangent_[static_cast<std::size_t>(i)];
    at[(axis + 2) % 3] = tangent_[static_cast<std::size_t>(j)];
    return at / std::sqrt(glm::dot(at, at));
}

}  // namespace touchable
