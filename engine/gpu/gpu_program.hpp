#pragma once

#include <vulkan/vulkan.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_device.hpp"

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

/// The difference between what a kernel's SPIR-V says and what C++ believes, in words; empty where there is
/// none. Only tests define it (tests/gpu/spirv_layout.hpp), and so hold each kernel that they create against
/// its SPIR-V: the program has no reason to, as both are of one build.
[[gnu::weak]] std::string layout_fault(std::span<const std::uint32_t> spirv, const GpuLayout& layout,
                                       std::span<const std::uint32_t> constants);

/// A compute pipeline. A handle, as GpuBuffer is.
class GpuProgram {
public:
    GpuProgram() = default;

    /// `constants` are the values of specialisation constants 0, 1, 2... (floats and ints as their bits, bool
    /// 0 or 1). Refused with ErrorKind::gpu where the device or its driver cannot, and in tests with
    /// ErrorKind::internal where there is a `layout_fault`; the message names the kernel.
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
