#pragma once

#include <memory>
#include <span>
#include <vector>

#include "player/draw/graphics_program.hpp"
#include "player/draw/surface_dents.hpp"
#include "player/draw/upload_pool.hpp"

namespace touchable {

/// What `draw_dents` draws, by triangle hardware, over the picture of a surface that any painter drew: only
/// pixels that a dent may reach cost anything.
class DentDrawing {
public:
    static Result<DentDrawing> create(const std::shared_ptr<GpuDevice>& device);

    /// Records the dents that fingers make (`shape_dents`; nothing where they make none) into a picture of
    /// the camera's size (VK_FORMAT_R8G8B8A8_UNORM) and its z, which are and stay in
    /// VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL and VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL. z stays as it
    /// is.
    Result<void> record(GpuCommands& commands, std::span<const FingerMark> fingers, const MarkSizes& sizes,
                        const ViewCamera& camera, const GpuImage& colour, const GpuImage& z);

private:
    explicit DentDrawing(const std::shared_ptr<GpuDevice>& device) : device_(device), uploads_(device) {}
    Result<GpuBuffer> upload(const ViewCamera& camera);
    Result<void> copy_flat(GpuCommands& commands, const ViewCamera& camera, const GpuImage& colour);

    std::shared_ptr<GpuDevice> device_;
    UploadPool uploads_;
    GraphicsProgram program_;
    std::vector<SurfaceDent> dents_;
    GpuImage flat_;  // where there are dents: what the picture is without them
};

}  // namespace touchable
