#pragma once

#include "haptics_cpu/world_space.hpp"

namespace touchable {

/// The paper's metric (section 3.3): pixels sideways and grey levels in depth, z_p = 255 (far - depth)/(far -
/// near), as if they were one unit. Kept because its error is worth publishing: forces point tens of degrees
/// wrong and create energy. For linear coding and square pixels. Positions are (x, -y, z_p), so that axes are
/// right-handed.
class PixelSpace {
public:
    explicit PixelSpace(const HeightField& field) : field_(field) {}

    /// Where a world point is in this space; nothing for a point that no pixel sees.
    std::optional<glm::dvec3> from_world(const glm::dvec3& point) const;
    glm::dvec3 to_world(const glm::dvec3& point) const;

    const HeightField& field() const { return field_; }
    SpaceVertex vertex(std::int64_t i, std::int64_t j) const {
        return cache_.at(i, j, [=, this] { return compute_vertex(i, j); });
    }
    glm::dvec3 position(const ChartPoint& at) const { return {at.x, -at.y, at.w}; }
    ChartPoint chart(const glm::dvec3& point) const { return {point.x, -point.y, point.z}; }
    bool in_front(const glm::dvec3&) const { return true; }
    ImageStep image_step(const glm::dvec3&, const glm::dvec3& d) const { return {d.x, -d.y, 0.0}; }
    std::optional<SegmentRange> clip(const glm::dvec3&, const glm::dvec3&) const {
        return SegmentRange{0, 1};
    }
    double largest_w(int tile_x, int tile_y) const;

private:
    SpaceVertex compute_vertex(std::int64_t i, std::int64_t j) const;
    double level_of(double depth) const;
    const HeightField& field_;
    mutable VertexCache cache_;
};

}  // namespace touchable
