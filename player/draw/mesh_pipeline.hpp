#pragma once

#include <vulkan/vulkan.h>

#include "engine/gpu/gpu_commands.hpp"
#include "player/draw/gpu_image.hpp"
#include "player/draw/gpu_lattice.hpp"
#include "player/draw/graphics_program.hpp"
#include "player/draw/view_camera.hpp"

namespace touchable {

/// The shaders view_mesh.vert and view_mesh.frag: tiles of triangles by instances, for the triangle hardware.
class MeshPipeline {
public:
    static constexpr VkFormat colour_format = VK_FORMAT_R8G8B8A8_UNORM;
    static constexpr VkFormat z_format = GraphicsLook::z_format;

    /// Fails (ErrorKind::gpu) on a device whose queue does not draw.
    static Result<MeshPipeline> create(const GpuDevice& device);

    /// Records the drawing of a lattice between begin_drawing and end_drawing, into images of the camera's
    /// size and the formats above.
    void draw(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera) const;

    /// The same into images of their own, which are cleared first and left ready to be copied from.
    void record(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera,
                const GpuImage& colour, const GpuImage& z) const;

private:
    GraphicsProgram whole_, mixed_;
    GpuBuffer pattern_;  // indices of a whole tile's triangles
};

}  // namespace touchable
