// SPDX-License-Identifier: Apache-2.0
#pragma once

// Graphics pipelines: a GraphicsProgram is made from a GraphicsLook (shaders, bindings, use of z and colour)
// and draws between begin_drawing and end_drawing into a DrawTarget. A program is a handle that any thread
// may use; commands belong to one thread at a time.

#include <vulkan/vulkan.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "engine/gpu/gpu_commands.hpp"
#include "player/draw/gpu_image.hpp"

namespace touchable {

/// Depth test and write; greater z is nearer. All but `ignored` need an image of z.
enum class DrawDepth {
    ignored,
    replaced,  ///< with the fragment shader's z
    nearest,   ///< drawn if nothing is nearer; z is written
    in_front,  ///< drawn if nothing is nearer; z is not written
    behind,    ///< drawn if something is nearer; z is not written
};

/// How a pixel's colour is blended.
enum class DrawBlend { replaced, over /* by its alpha */, multiplied };

/// A graphics pipeline's description. Draws both sides of triangles, without vertex buffers; colour in
/// `colour_format`, z in GpuImage's only z format. Both stages share set 0's storage buffers and sampled
/// images, the push constants and specialisation constants 0, 1, ...
struct GraphicsLook {
    static constexpr VkFormat z_format = VK_FORMAT_D32_SFLOAT;

    std::span<const std::uint32_t> vertex, fragment;  ///< SPIR-V
    std::uint32_t push_bytes = 0;
    std::vector<VkDescriptorType> bindings = {};
    std::vector<std::uint32_t> constants = {};
    VkFormat colour_format = VK_FORMAT_R8G8B8A8_UNORM;
    DrawDepth depth = DrawDepth::nearest;
    DrawBlend blend = DrawBlend::replaced;
};

/// A whole buffer, a part of one, or an image for reading (layout VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL).
struct DrawBinding {
    DrawBinding(const GpuBuffer& whole) : buffer(&whole) {}
    DrawBinding(const GpuBuffer& part_of, std::size_t offset_bytes, std::size_t size_bytes)
        : buffer(&part_of), offset(offset_bytes), bytes(size_bytes) {}
    DrawBinding(const GpuImage& sampled) : image(&sampled) {}

    const GpuBuffer* buffer = nullptr;  ///< buffer and image must outlive the call that gets them
    std::size_t offset = 0, bytes = VK_WHOLE_SIZE;
    const GpuImage* image = nullptr;
};

/// A graphics pipeline; a handle like GpuProgram.
class GraphicsProgram {
public:
    GraphicsProgram() = default;
    /// Fails (ErrorKind::gpu) if the driver refuses.
    static Result<GraphicsProgram> create(const GpuDevice& device, const std::string& name,
                                          const GraphicsLook& look);

    explicit operator bool() const { return state_ != nullptr; }

    /// Binds it for the draws that follow; `commands` keep all resources alive.
    template <class Push>
    void bind(GpuCommands& commands, const Push& push, std::initializer_list<DrawBinding> bindings) const {
        static_assert(std::is_trivially_copyable_v<Push>);
        bind_bytes(commands, std::as_bytes(std::span(&push, 1)), bindings);
    }
    /// For a program without push constants.
    void bind(GpuCommands& commands, std::initializer_list<DrawBinding> bindings) const {
        bind_bytes(commands, {}, bindings);
    }

private:
    struct State : VulkanDevice::Pipeline {
        std::vector<VkDescriptorType> bindings;
    };
    void bind_bytes(GpuCommands& commands, std::span<const std::byte> push,
                    std::initializer_list<DrawBinding> bindings) const;

    std::shared_ptr<const State> state_;
};

/// The images drawn into.
struct DrawTarget {
    const GpuImage& colour;
    const GpuImage* z = nullptr;
    bool as_light = false;  ///< through the colour's `light_view`
    /// Whether the previous content is kept, cleared to zeroes, or undefined because all of it is replaced.
    VkAttachmentLoadOp load = VK_ATTACHMENT_LOAD_OP_LOAD;
};

/// Begin and end dynamic rendering, in which programs draw. Layouts:
/// VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, and VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL for z.
void begin_drawing(GpuCommands& commands, const DrawTarget& target);
void end_drawing(GpuCommands& commands);
/// Scales z of the draws that follow, until the next begin_drawing. `extent`: of the images.
void scale_z(GpuCommands& commands, VkExtent2D extent, float by);

}  // namespace touchable
