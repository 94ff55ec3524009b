#pragma once

#include <memory>

#include "engine/gpu/gpu_device.hpp"
#include "player/draw/surface_painter.hpp"

namespace touchable {

/// By compute (shaders/raster.comp): several times cheaper than triangles where the GPU is a CPU. Fails
/// (ErrorKind::gpu) on a device without 64-bit atomics.
Result<std::unique_ptr<SurfacePainter>> make_raster_painter(std::shared_ptr<GpuDevice> device);

/// By the triangle hardware (shaders/mesh.vert). Fails (ErrorKind::gpu) on a device whose queue does not
/// draw.
Result<std::unique_ptr<SurfacePainter>> make_mesh_painter(std::shared_ptr<GpuDevice> device);

}  // namespace touchable
