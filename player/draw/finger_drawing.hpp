#pragma once

#include <memory>
#include <span>

#include "player/draw/finger_marks.hpp"
#include "player/draw/graphics_program.hpp"
#include "player/draw/upload_pool.hpp"

namespace touchable {

/// What `draw_fingers` draws, by triangle hardware (shaders/view_marks.h): the same shapes in the same light.
/// Threads are ribbons, and edges are smooth.
class FingerDrawing {
public:
    static Result<FingerDrawing> create(const std::shared_ptr<GpuDevice>& device);

    /// Records the drawing over a picture of the camera's size and its z, which are and stay in
    /// VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL and VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL. z is then of
    /// the fingers too.
    Result<void> record(GpuCommands& commands, std::span<const FingerMark> fingers, const MarkSizes& sizes,
                        const ViewCamera& camera, const GpuImage& colour, const GpuImage& z);

private:
    explicit FingerDrawing(const std::shared_ptr<GpuDevice>& device) : uploads_(device) {}

    struct Part {
        std::size_t offset = 0, bytes = 0;
    };
    struct Parts {
        Part solids, threads, shadows;
    };
    Result<GpuBuffer> upload(const ViewCamera& camera, Parts& parts);
    void sort_solids();
    void draw_shadows(GpuCommands& commands, const GpuBuffer& records, const Part& part,
                      const GpuImage& colour, const GpuImage& z) const;
    void draw_solids(GpuCommands& commands, const ViewCamera& camera, const GpuBuffer& records,
                     const Parts& parts) const;

    UploadPool uploads_;
    struct SolidPrograms {
        GraphicsProgram ball, frustum;
    };
    GraphicsProgram shadow_, thread_;
    SolidPrograms solid_, veil_, hidden_veil_;
    GpuBuffer pattern_;  // indices of a frustum's triangles
    FingerShapes shapes_;
};

}  // namespace touchable
