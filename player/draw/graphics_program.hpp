#pragma once

// Graphics pipelines: a GraphicsProgram is made of a GraphicsLook (shaders, what is bound, what becomes of z
// and colour) and draws between begin_drawing and end_drawing into a DrawTarget. A program is a handle that
// any thread may use; commands belong to one thread at a time.

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

/// What drawing does with z, of which the greatest is the nearest. All but `ignored` need an image of z.
enum class DrawDepth {
    ignored,
    replaced,  ///< by what the fragment shader says
    nearest,   ///< drawn where nothing is nearer, and written
    in_front,  ///< drawn where nothing is nearer, not written
    behind,    ///< drawn where something is nearer, not written
};

/// What becomes of a pixel's colour.
enum class DrawBlend { replaced, over /* by its alpha */, multiplied };

/// What a graphics pipeline is made of. Triangles of either side, without vertex buffers; colour of
/// `colour_format`, z of GpuImage's only format of it. Storage buffers and sampled images of set 0, push
/// constants and specialisation constants 0, 1, ... are those of both stages.
struct GraphicsLook {
    static constexpr VkFormat z_format = VK_FORMAT_D32_SFLOAT;

    std::span<const std::uint32_t> vertex, fragment;  ///< SPIR-V
    std::uint32_t push_bytes = 0;
    std::vector<VkDescriptorType> bindings;
    std::vector<std::uint32_t> constants;
    VkFormat colour_format = VK_FORMAT_R8G8B8A8_UNORM;
    DrawDepth depth = DrawDepth::nearest;
    DrawBlend blend = DrawBlend::replaced;
};

/// A whole buffer, or an image that is read (its layout: VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL).
struct DrawBinding {
    DrawBinding(const GpuBuffer& whole) : buffer(&whole) {}
    DrawBinding(const GpuBuffer& part_of, std::size_t offset_bytes, std::size_t size_bytes)
        : buffer(&part_of), offset(offset_bytes), bytes(size_bytes) {}
    DrawBinding(const GpuImage& sampled) : image(&sampled) {}

    const GpuBuffer* buffer = nullptr;  ///< outlives the call it is handed to, as the image does
    std::size_t offset = 0, bytes = VK_WHOLE_SIZE;
    const GpuImage* image = nullptr;
};

/// A graphics pipeline. A handle, as GpuProgram is.
class GraphicsProgram {
public:
    GraphicsProgram() = default;
    /// Fails (ErrorKind::gpu) where the driver refuses.
    static Result<GraphicsProgram> create(const GpuDevice& device, const std::string& name,
                                          const GraphicsLook& look);

    explicit operator bool() const { return state_ != nullptr; }

    /// Binds it for the draws that follow, of which `commands` then keep everything alive.
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
    struct State {
        ~State();

        std::shared_ptr<VulkanDevice> vulkan;
        std::vector<VkDescriptorType> bindings;
        VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
        VkPipelineLayout layout = VK_NULL_HANDLE;
        VkPipeline pipeline = VK_NULL_HANDLE;
    };
    static Result<void> make_layout(State& state, std::uint32_t push_bytes);
    void bind_bytes(GpuCommands& commands, std::span<const std::byte> push,
                    std::initializer_list<DrawBinding> bindings) const;

    std::shared_ptr<const State> state_;
};

/// Where drawing goes.
struct DrawTarget {
    const GpuImage& colour;
    const GpuImage* z = nullptr;
    bool as_light = false;  ///< through the colour's `light_view`
    /// What is there is kept, cleared to zeroes, or of no matter because all of it is replaced.
    VkAttachmentLoadOp load = VK_ATTACHMENT_LOAD_OP_LOAD;
};

/// Between these, programs draw in dynamic rendering. Layouts: VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, and
/// VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL for z.
void begin_drawing(GpuCommands& commands, const DrawTarget& target);
void end_drawing(GpuCommands& commands);

}  // namespace touchable
