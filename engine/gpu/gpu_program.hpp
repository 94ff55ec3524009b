#pragma once

#include <vulkan/vulkan.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/gpu/gpu_device.hpp"
#include "engine/result.hpp"

namespace touchable {

enum class GpuBindingKind {
    storage_buffer,
    uniform_texels,  ///< usamplerBuffer / utextureBuffer, rgba32ui
    storage_texels,  ///< uimageBuffer, rgba32ui
};

/// How C++ believes to talk to a kernel: what its shaders/name.h says.
struct GpuLayout {
    std::uint32_t push_bytes = 0;          ///< sizeof the push constants; 0: none
    std::vector<GpuBindingKind> bindings;  ///< of set 0, binding numbers 0, 1, 2...
    std::array<std::uint32_t, 3> group_size{1, 1, 1};
};

/// A compute pipeline. A handle, as GpuBuffer is.
class GpuProgram {
public:
    GpuProgram() = default;

    /// `constants` are the values of specialisation constants 0, 1, 2... (floats and ints as their bits, bool
    /// 0 or 1). Refused (ErrorKind::internal) where the SPIR-V and `layout` differ: binding, kind, size of
    /// the push constants, group size; the message names the kernel and what both say. ErrorKind::gpu where
    /// the driver refuses.
    static Result<GpuProgram> create(const GpuDevice& device, std::string name,
                                     std::span<const std::uint32_t> spirv, GpuLayout layout,
                                     std::span<const std::uint32_t> constants = {});

    explicit operator bool() const { return state_ != nullptr; }
    const std::string& name() const { return state_->name; }
    const GpuLayout& layout() const { return state_->layout; }
    VkPipeline pipeline() const { return state_->pipeline; }
    VkPipelineLayout pipeline_layout() const { return state_->pipeline_layout; }
    std::shared_ptr<const void> keep_alive() const { return state_; }

private:
    struct State {
        ~State();

        std::shared_ptr<VulkanDevice> vulkan;
        std::string name;
        GpuLayout layout;
        VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
        VkPipelineLayout pipeline_layout = VK_NULL_HANDLE;
        VkPipeline pipeline = VK_NULL_HANDLE;
    };
    std::shared_ptr<const State> state_;
};

}  // namespace touchable
