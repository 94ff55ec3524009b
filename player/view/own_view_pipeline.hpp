#pragma once

#include <memory>

#include "engine/gpu/gpu_commands.hpp"
#include "player/view/gpu_lattice.hpp"
#include "player/view/graphics_program.hpp"
#include "player/view/upload_pool.hpp"
#include "player/view/view_camera.hpp"

namespace touchable {

/// The shader view_own.frag: all triangles at once, for cameras to which every vertex is where it is whatever
/// its depth. There the same picture as SurfaceRaster's, at a fraction of the time.
class OwnViewPipeline {
public:
    /// Fails (ErrorKind::gpu) where the driver refuses.
    static Result<OwnViewPipeline> create(std::shared_ptr<GpuDevice> device);

    /// Whether it draws what this camera sees: the clip's own one, unless a cell is larger than
    /// RASTER_LARGE_CELL on the screen.
    static bool draws(const ViewCamera& camera);

    /// Records the drawing of surface and background between begin_drawing and end_drawing, into images of
    /// the camera's size, all of whose pixels and z are written.
    Result<void> draw(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera);

private:
    explicit OwnViewPipeline(std::shared_ptr<GpuDevice> device) : uploads_(std::move(device)) {}

    GraphicsProgram program_;
    UploadPool uploads_;
};

}  // namespace touchable
