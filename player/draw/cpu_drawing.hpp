#pragma once

#include <optional>
#include <span>

#include "engine/picture/image_file.hpp"
#include "player/draw/cpu_lattice.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/surface_lighting.hpp"
#include "player/draw/surface_painter.hpp"

namespace touchable {

/// The twin of SurfaceDrawing by the `cpu` painter: a surface and the fingers on it, picture after picture,
/// in the CPU's memory. One sample a pixel: edges are not smooth. Not for two threads at once.
class CpuDrawing {
public:
    CpuDrawing();

    /// From now on this surface is drawn. `pair` is what `field` was made of; both, and `colour` (RGB of 8
    /// bits, of the field's size, or empty for light and depth alone), are read at once.
    void show(const HeightField& field, const FramePair& pair, const PlaneView& colour, Lighting lighting);

    /// Surface, background and fingers; background and fingers alone before the first `show`. Of the camera's
    /// size, RGB; stays readable until the next call.
    Result<const Image*> draw(const ViewCamera& camera, std::span<const FingerMark> fingers,
                              const MarkSizes& sizes);

private:
    Result<void> paint(const ViewCamera& camera);

    CpuLattices lattices_;
    std::unique_ptr<SurfacePainter> painter_ = make_cpu_painter();
    ViewSurface surface_;
    LightPicture bare_;                  // without fingers
    std::optional<glm::dmat4> painted_;  // clip_from_lattice that it is of
    Image picture_;
};

}  // namespace touchable
