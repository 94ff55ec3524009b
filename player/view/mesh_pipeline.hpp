#pragma once

#include <vulkan/vulkan.h>

#include <memory>

#include "engine/gpu/gpu_commands.hpp"
#include "player/view/gpu_image.hpp"
#include "player/view/gpu_lattice.hpp"
#include "player/view/view_camera.hpp"

namespace touchable {

/// The shaders view_mesh.vert and view_mesh.frag: tiles of triangles by instances, for the triangle hardware.
class MeshPipeline {
public:
    static constexpr VkFormat colour_format = VK_FORMAT_R8G8B8A8_UNORM;
    static constexpr VkFormat z_format = VK_FORMAT_D32_SFLOAT;

    /// Fails (ErrorKind::gpu) on a device whose queue does not draw.
    static Result<MeshPipeline> create(const GpuDevice& device);

    /// Records the drawing of a lattice into images of the camera's size and the formats above, which are
    /// cleared first and left ready to be copied from.
    void record(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera,
                const GpuImage& colour, const GpuImage& z) const;

private:
    struct State {
        ~State();

        std::shared_ptr<VulkanDevice> vulkan;
        VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
        VkPipelineLayout layout = VK_NULL_HANDLE;
        VkPipeline whole = VK_NULL_HANDLE, mixed = VK_NULL_HANDLE;
        GpuBuffer pattern;  // indices of a whole tile's triangles
    };
    static Result<void> make_layout(State& state);
    static Result<void> make_pattern(const GpuDevice& device, State& state);
    void draw(VkCommandBuffer commands, const GpuLattice& lattice, const ViewCamera& camera) const;

    std::shared_ptr<const State> state_;
};

}  // namespace touchable
