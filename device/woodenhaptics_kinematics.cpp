#include "device/woodenhaptics_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/matrix.hpp>
#include <numbers>

#include "engine/base/trigonometry.hpp"

namespace touchable {
namespace {

constexpr double most_milliamperes = 32767;  // that fit into a report

struct Bends {
    double sin_base, cos_base, sin_upper, cos_upper, sin_fore, cos_fore;
};

Bends bends_of(const glm::dvec3& angles) {
    return {sine(angles[0]),   cosine(angles[0]), sine(angles[1]),
            cosine(angles[1]), sine(angles[2]),   cosine(angles[2])};
}

/// The linkage is described with x to the person, y right, z up.
glm::dvec3 from_linkage(const glm::dvec3& there) {
    return {there.y, there.z, there.x};
}

}  // namespace

glm::dvec3 wooden_angles(const WoodenParameters& build, const std::array<std::int16_t, 3>& counts) {
    glm::dvec3 angles;
    for (std::size_t joint = 0; joint < 3; ++joint) {
        const WoodenJoint& turned = build.joints[joint];
        angles[static_cast<int>(joint)] =
            2 * std::numbers::pi * counts[joint] / turned.counts_per_turn * turned.cable_ratio;
    }
    return angles;
}

glm::dvec3 wooden_place(const WoodenParameters& build, const glm::dvec3& angles) {
    const Bends at = bends_of(angles);
    const auto& [base, upper, fore] = build.links;
    const double out = upper * at.sin_upper + fore * at.sin_fore;
    const double height = base + upper * at.cos_upper - fore * at.cos_fore;
    return from_linkage(glm::dvec3(at.cos_base * out, at.sin_base * out, height) - build.origin);
}

glm::dmat3 wooden_jacobian(const WoodenParameters& build, const glm::dvec3& angles) {
    const Bends at = bends_of(angles);
    const auto& [base, upper, fore] = build.links;
    const double out = upper * at.sin_upper + fore * at.sin_fore;
    const glm::dvec3 by_base(-at.sin_base * out, at.cos_base * out, 0);
    const glm::dvec3 by_upper(at.cos_base * upper * at.cos_upper, at.sin_base * upper * at.cos_upper,
                              -upper * at.sin_upper);
    const glm::dvec3 by_fore(at.cos_base * fore * at.cos_fore, at.sin_base * fore * at.cos_fore,
                             fore * at.sin_fore);
    return {from_linkage(by_base), from_linkage(by_upper), from_linkage(by_fore)};
}

std::array<std::int16_t, 3> wooden_currents(const WoodenParameters& build, const glm::dvec3& angles,
                                            const glm::dvec3& newtons) {
    const glm::dvec3 torques = glm::transpose(wooden_jacobian(build, angles)) * newtons;
    glm::dvec3 milliamperes;
    double share = 1;
    for (std::size_t joint = 0; joint < 3; ++joint) {
        const WoodenJoint& turned = build.joints[joint];
        double& needed = milliamperes[static_cast<int>(joint)];
        needed = 1000 * torques[static_cast<int>(joint)] * turned.cable_ratio / turned.torque_constant;
        const double bears = std::min(1000 * turned.most_amperes, most_milliamperes);
        if (std::abs(needed) > bears) share = std::min(share, bears / std::abs(needed));
    }
    std::array<std::int16_t, 3> currents;
    for (std::size_t joint = 0; joint < 3; ++joint)
        currents[joint] = static_cast<std::int16_t>(milliamperes[static_cast<int>(joint)] * share);
    return currents;
}

}  // namespace touchable
