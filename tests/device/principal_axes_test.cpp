#include "device/hand_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <random>
#include <vector>

namespace touchable {
namespace {

using Points = std::vector<glm::dvec3>;

/// A cloud with the given sizes along three perpendicular directions.
Points cloud(const glm::dmat3& directions, const glm::dvec3& sizes, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    Points points;
    for (int i = 0; i < 2000; ++i) {
        points.push_back(directions * (sizes * glm::dvec3(normal(random), normal(random), normal(random))) +
                         glm::dvec3(3, -2, 0.5));
    }
    return points;
}

glm::dmat3 some_rotation(unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const glm::dvec3 x = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    const glm::dvec3 z =
        glm::normalize(glm::cross(x, glm::dvec3(normal(random), normal(random), normal(random))));
    return glm::dmat3(x, glm::cross(z, x), z);
}

glm::dmat3 covariance(const Points& points) {
    glm::dvec3 mean(0);
    for (const glm::dvec3& p : points) mean += p / static_cast<double>(points.size());
    glm::dmat3 sum(0.0);
    for (const glm::dvec3& p : points) sum += glm::outerProduct(p - mean, p - mean);
    return sum / static_cast<double>(points.size());
}

void expect_proper(const glm::dmat3& r) {
    const glm::dmat3 product = r * glm::transpose(r);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(product[i][j], i == j ? 1 : 0, 1e-14);
    }
    EXPECT_NEAR(glm::determinant(r), 1, 1e-14);
}

TEST(PrincipalRotation, IsProperAndOrdersTheVariances) {
    for (unsigned seed = 0; seed < 50; ++seed) {
        Points points = cloud(some_rotation(seed), {0.2, 0.1, 0.01}, seed);
        const glm::dmat3 rotation = principal_rotation(points);
        expect_proper(rotation);
        for (glm::dvec3& p : points) p = rotation * p;
        const glm::dmat3 c = covariance(points);
        EXPECT_GT(c[0][0], c[1][1]);
        EXPECT_GT(c[1][1], c[2][2]);
        for (const double rest : {c[0][1], c[0][2], c[1][2]}) EXPECT_NEAR(rest, 0, 1e-14);
    }
}

TEST(PrincipalRotation, LargestComponentOfTheFirstTwoAxesIsPositive) {
    for (unsigned seed = 0; seed < 50; ++seed) {
        const glm::dmat3 rotation = principal_rotation(cloud(some_rotation(seed), {0.2, 0.1, 0.01}, seed));
        for (int axis = 0; axis < 2; ++axis) {
            const glm::dvec3 direction = glm::transpose(rotation)[axis];
            const double least = std::min({direction.x, direction.y, direction.z});
            const double greatest = std::max({direction.x, direction.y, direction.z});
            EXPECT_GT(greatest, -least) << "seed " << seed;
        }
    }
}

TEST(PrincipalRotation, AxesThatAreThereAlreadyStay) {
    const Points points{{2, 0, 0}, {-2, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 0.5}, {0, 0, -0.5}};
    EXPECT_EQ(principal_rotation(points), glm::dmat3(1.0));
}

TEST(PrincipalRotation, FlatLinearAndSinglePointsGiveProperRotations) {
    expect_proper(principal_rotation(Points{{1, 2, 3}}));
    expect_proper(principal_rotation(Points{{0, 0, 0}, {1, 2, 3}}));
    expect_proper(principal_rotation(Points{{0, 0, 0}, {1, 2, 3}, {3, 2, 1}}));
    expect_proper(principal_rotation(Points{{1e-160, 0, 0}, {0, 1e-160, 0}, {0, 0, 1e9}}));
}

}  // namespace
}  // namespace touchable
