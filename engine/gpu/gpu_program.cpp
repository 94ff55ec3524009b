#include "engine/gpu/gpu_program.hpp"

#include <utility>

namespace touchable {
namespace {

VkDescriptorType type_of(GpuBindingKind kind) {
    switch (kind) {
        case GpuBindingKind::storage_buffer:
            return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        case GpuBindingKind::uniform_texels:
            return VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
        case GpuBindingKind::storage_texels:
            break;
    }
    return VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER;
}

/// What the device can not do of this layout; empty where it can.
std::string beyond(const GpuLayout& layout, const GpuLimits& limits) {
    std::uint64_t invocations = 1;
    for (std::size_t i = 0; i < 3; ++i) {
        invocations *= layout.group_size[i];
        if (layout.group_size[i] > limits.max_group_size[i])
            return "workgroups of " + std::to_string(layout.group_size[i]) + " in one direction, at most " +
                   std::to_string(limits.max_group_size[i]);
    }
    if (invocations > limits.max_group_invocations)
        return "workgroups of " + std::to_string(invocations) + " invocations, at most " +
               std::to_string(limits.max_group_invocations);
    if (layout.push_bytes > limits.max_push_constants)
        return std::to_string(layout.push_bytes) + " bytes of push constants, at most " +
               std::to_string(limits.max_push_constants);
    return {};
}

Result<VkDescriptorSetLayout> make_set_layout(VulkanDevice& gpu, const GpuLayout& layout) {
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    for (const GpuBindingKind kind : layout.bindings) {
        VkDescriptorSetLayoutBinding binding{};
        binding.binding = static_cast<std::uint32_t>(bindings.size());
        binding.descriptorType = type_of(kind);
        binding.descriptorCount = 1;
        binding.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT;
        bindings.push_back(binding);
    }
    VkDescriptorSetLayoutCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    info.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR;
    info.bindingCount = static_cast<std::uint32_t>(bindings.size());
    info.pBindings = bindings.data();
    VkDescriptorSetLayout made = VK_NULL_HANDLE;
    const VkResult result = vkCreateDescriptorSetLayout(gpu.device, &info, nullptr, &made);
    if (result != VK_SUCCESS) return gpu.failed("vkCreateDescriptorSetLayout", result);
    return made;
}

Result<VkPipelineLayout> make_pipeline_layout(VulkanDevice& gpu, VkDescriptorSetLayout set,
                                              std::uint32_t push_bytes) {
    const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, push_bytes};
    VkPipelineLayoutCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    info.setLayoutCount = 1;
    info.pSetLayouts = &set;
    info.pushConstantRangeCount = push_bytes > 0;
    info.pPushConstantRanges = &range;
    VkPipelineLayout made = VK_NULL_HANDLE;
    const VkResult result = vkCreatePipelineLayout(gpu.device, &info, nullptr, &made);
    if (result != VK_SUCCESS) return gpu.failed("vkCreatePipelineLayout", result);
    return made;
}

Result<VkPipeline> make_pipeline(VulkanDevice& gpu, VkPipelineLayout layout,
                                 std::span<const std::uint32_t> spirv,
                                 std::span<const std::uint32_t> constants) {
    VkShaderModuleCreateInfo code{};
    code.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    code.codeSize = spirv.size_bytes();
    code.pCode = spirv.data();
    VkShaderModule shader = VK_NULL_HANDLE;
    VkResult result = vkCreateShaderModule(gpu.device, &code, nullptr, &shader);
    if (result != VK_SUCCESS) return gpu.failed("vkCreateShaderModule", result);

    std::vector<VkSpecializationMapEntry> entries;
    for (std::uint32_t i = 0; i < constants.size(); ++i) entries.push_back({i, i * 4, 4});
    const VkSpecializationInfo special{static_cast<std::uint32_t>(entries.size()), entries.data(),
                                       constants.size_bytes(), constants.data()};
    VkComputePipelineCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = shader;
    info.stage.pName = "main";
    info.stage.pSpecializationInfo = &special;
    info.layout = layout;
    VkPipeline pipeline = VK_NULL_HANDLE;
    result = vkCreateComputePipelines(gpu.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline);
    vkDestroyShaderModule(gpu.device, shader, nullptr);
    if (result != VK_SUCCESS) return gpu.failed("vkCreateComputePipelines", result);
    return pipeline;
}

}  // namespace

GpuProgram::State::~State() {
    if (pipeline) vkDestroyPipeline(vulkan->device, pipeline, nullptr);
    if (pipeline_layout) vkDestroyPipelineLayout(vulkan->device, pipeline_layout, nullptr);
    if (set_layout) vkDestroyDescriptorSetLayout(vulkan->device, set_layout, nullptr);
}

Result<GpuProgram> GpuProgram::create(const GpuDevice& device, std::string name,
                                      std::span<const std::uint32_t> spirv, GpuLayout layout,
                                      std::span<const std::uint32_t> constants) {
    const auto refusal = [&name](ErrorKind kind, const std::string& why) {
        return Error{kind, "kernel " + name + ": " + why};
    };
    if (layout_fault != nullptr)
        if (const std::string fault = layout_fault(spirv, layout, constants); !fault.empty())
            return refusal(ErrorKind::internal, fault);
    if (const std::string fault = beyond(layout, device.facts().limits); !fault.empty())
        return refusal(ErrorKind::gpu, fault + " on " + device.facts().name);

    auto state = std::make_shared<State>();
    state->vulkan = device.vulkan();
    state->name = name;
    state->layout = std::move(layout);
    VulkanDevice& gpu = *state->vulkan;
    const auto set = make_set_layout(gpu, state->layout);
    if (!set.ok()) return refusal(ErrorKind::gpu, set.error().message);
    state->set_layout = *set;
    const auto pipeline_layout = make_pipeline_layout(gpu, *set, state->layout.push_bytes);
    if (!pipeline_layout.ok()) return refusal(ErrorKind::gpu, pipeline_layout.error().message);
    state->pipeline_layout = *pipeline_layout;
    const auto pipeline = make_pipeline(gpu, *pipeline_layout, spirv, constants);
    if (!pipeline.ok()) return refusal(ErrorKind::gpu, pipeline.error().message);
    state->pipeline = *pipeline;
    gpu.name_object(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<std::uint64_t>(*pipeline), name);
    GpuProgram program;
    program.state_ = std::move(state);
    return program;
}

}  // namespace touchable
