#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "player/draw/picture_planes.hpp"
#include "player/draw/view_camera.hpp"
#include "player/draw/view_surface.hpp"

namespace touchable {

/// Draws the triangles of a surface that shaders/cut_rule.h keeps, at full resolution, both sides, nearest
/// first. Painters differ in where they do it, not in what: pixels agree but for the roundings of z.
class SurfacePainter {
public:
    virtual ~SurfacePainter() = default;
    virtual std::string_view name() const = 0;
    /// The GPU that draws; empty: none does.
    virtual std::string gpu_name() const { return {}; }
    /// `make_view_surface` of `field`, which `pair` is behind, made where this painter draws: q agree to
    /// 1e-6.
    virtual Result<ViewSurface> surface_of(const HeightField& field, const FramePair& pair,
                                           const PlaneView& colour) = 0;
    virtual Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) = 0;
};

/// By the CPU's vectors and threads, without a GPU. Does not read a surface's tiles.
std::unique_ptr<SurfacePainter> make_cpu_painter();

/// "cpu", "raster" or "mesh" (gpu_painters.hpp) on the GPU that `open_gpu` gives, which cpu does not ask for,
/// or "auto": mesh on a GPU, raster where Vulkan computes on the CPU, cpu where there is neither. Refused
/// (ErrorKind::gpu) where what is asked for by name is not to be had.
Result<std::unique_ptr<SurfacePainter>> make_painter(
    std::string_view name, const std::function<Result<std::shared_ptr<GpuDevice>>()>& open_gpu);

}  // namespace touchable
