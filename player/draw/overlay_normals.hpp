#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "engine/scene/camera.hpp"
#include "player/draw/view_surface.hpp"

namespace touchable {

/// The usual colour of a unit normal: X to the right red, Y up green, Z towards the clip's camera blue.
PackedColour normal_colour(const glm::dvec3& normal);

/// Colours of the surface's normals at the vertices of a lattice, by rows: of the plane through the four
/// neighbours in (x, y, q), where flat stays flat; a neighbour beyond a gap (shaders/cut_rule.h) does not
/// count.
class NormalRows {
public:
    /// `q`: width x height, row-major, referred to.
    NormalRows(const Camera& camera, int width, int height, const float* q);
    /// RGB of row y; where q is 0, any.
    void paint(int y, std::uint8_t* rgb);

private:
    Camera camera_;
    int width_, height_;
    const float* q_;
    std::vector<float> u_;                  // of the columns' rays
    std::vector<float> along_x_, along_y_;  // of a row: what q gains per pixel
};

}  // namespace touchable
