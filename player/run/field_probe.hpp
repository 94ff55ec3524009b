#pragma once

#include "device/surface_probe.hpp"
#include "haptics_cpu/height_field.hpp"

namespace touchable {

/// Shows a hand the same surface the solver sees.
class FieldProbe final : public SurfaceProbe {
public:
    explicit FieldProbe(const HeightField& field) : field_(field) {}

    int width() const override { return field_.width(); }
    int height() const override { return field_.height(); }
    std::optional<double> depth_under(double x, double y) const override;
    glm::dvec3 unproject(double x, double y, double planar_depth) const override;
    glm::dvec3 project(const glm::dvec3& point) const override;

private:
    const HeightField& field_;
};

}  // namespace touchable
