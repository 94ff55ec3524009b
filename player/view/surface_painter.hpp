#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "engine/result.hpp"
#include "player/view/picture_planes.hpp"
#include "player/view/view_camera.hpp"
#include "player/view/view_surface.hpp"

namespace touchable {

/// Draws the triangles of a surface that shaders/cut_rule.h keeps, at full resolution, both sides, nearest
/// first. Painters differ in where they do it, not in what: pixels agree but for the roundings of z.
class SurfacePainter {
public:
    virtual ~SurfacePainter() = default;
    virtual std::string_view name() const = 0;
    /// q of every pixel of `field`, which `pair` is behind: `touchable::q_of`, or what agrees with it to
    /// 1e-6.
    virtual Result<std::vector<float>> q_of(const HeightField& field, const FramePair& pair);
    virtual Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) = 0;
};

/// On this thread, without a GPU: the definition that the others are tested against.
std::unique_ptr<SurfacePainter> make_cpu_painter();

/// "cpu", "raster" or "mesh" (gpu_painters.hpp) on the GPU that GpuOptions chooses where nobody says, or
/// "auto": mesh on a GPU, raster where Vulkan computes on the CPU, cpu where there is neither. Refused
/// (ErrorKind::gpu) where what is asked for by name is not to be had.
Result<std::unique_ptr<SurfacePainter>> make_painter(std::string_view name);

}  // namespace touchable
