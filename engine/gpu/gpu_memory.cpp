// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "engine/base/try.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_recording.hpp"

namespace touchable {

namespace {

constexpr VkMemoryPropertyFlags local = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
constexpr VkMemoryPropertyFlags visible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
constexpr VkMemoryPropertyFlags coherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
constexpr VkMemoryPropertyFlags cached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;

/// How well memory with these properties serves a use; negative: not at all.
int worth(VkMemoryPropertyFlags flags, GpuMemory use) {
    if (flags & ~(local | visible | coherent | cached)) return -1;  // protected, lazy: not ordinary memory
    const auto has = [flags](VkMemoryPropertyFlags wanted) { return (flags & wanted) == wanted; };
    if (use == GpuMemory::device) return 2 * has(local) + !has(visible);
    if (!has(visible | coherent)) return -1;
    // Reading uncached memory is so slow that its place comes second.
    if (use == GpuMemory::shared) return has(cached) ? 2 + has(local) : !has(local);
    if (use == GpuMemory::readback) return 2 * has(cached) + !has(local);
    return !has(local);  // upload: what the CPU may see of device memory can be small
}

constexpr std::size_t texel_bytes = 16;  // rgba32ui

Error refusal(const VulkanDevice& gpu, const std::string& name, std::size_t bytes, const std::string& why) {
    return gpu_error("GPU buffer '" + name + "' of " + std::to_string(bytes) + " bytes: " + why + " on " +
                     gpu.facts.name);
}

Result<void> checked(VulkanDevice& gpu, const std::string& name, std::size_t bytes, const char* call,
                     VkResult result) {
    if (result == VK_SUCCESS) return {};
    return gpu_error("GPU buffer '" + name + "' of " + std::to_string(bytes) +
                     " bytes: " + gpu.failed(call, result).message);
}

std::uint64_t heap_bytes(const VulkanDevice& gpu, std::uint32_t memory_type) {
    return gpu.memory.memoryHeaps[gpu.memory.memoryTypes[memory_type].heapIndex].size;
}

/// Which limit of the device this layout exceeds; empty: none.
std::string beyond(const GpuLayout& layout, const GpuFacts::Limits& limits) {
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
    const auto buffers = std::ranges::count(layout.bindings, GpuBindingKind::storage_buffer);
    if (buffers > std::ptrdiff_t{limits.max_storage_buffers})
        return std::to_string(buffers) + " storage buffers, at most " +
               std::to_string(limits.max_storage_buffers);
    if (layout.push_bytes > limits.max_push_constants)
        return std::to_string(layout.push_bytes) + " bytes of push constants, at most " +
               std::to_string(limits.max_push_constants);
    return {};
}

/// Makes a kernel's layouts and its pipeline.
Result<void> make_pipeline(VulkanDevice::Pipeline& made, const GpuLayout& layout,
                           std::span<const std::uint32_t> spirv, std::span<const std::uint32_t> constants) {
    VulkanDevice& gpu = *made.vulkan;
    std::vector<VkDescriptorType> types;
    for (const GpuBindingKind kind : layout.bindings) types.push_back(descriptor_type(kind));
    TRY(made.make_layouts(types, layout.push_bytes, VK_SHADER_STAGE_COMPUTE_BIT));

    VulkanDevice::Pipeline::Shader shader;
    TRY(shader.load(gpu, VK_SHADER_STAGE_COMPUTE_BIT, spirv, constants));
    auto info = vulkan_struct<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
    info.stage = shader.info;
    info.layout = made.pipeline_layout;
    return gpu.checked("vkCreateComputePipelines",
                       vkCreateComputePipelines(gpu.device, gpu.programs, 1, &info, nullptr, &made.pipeline));
}

}  // namespace

VkDescriptorType descriptor_type(GpuBindingKind kind) {
    return kind == GpuBindingKind::storage_buffer ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER
                                                  : VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
}

std::optional<std::uint32_t> choose_memory_type(const VkPhysicalDeviceMemoryProperties& memory,
                                                std::uint32_t allowed, GpuMemory use) {
    std::optional<std::uint32_t> best;
    int most = -1;
    for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
        const int value = allowed >> i & 1U ? worth(memory.memoryTypes[i].propertyFlags, use) : -1;
        if (value <= most) continue;  // drivers list the faster of two alike first
        most = value;
        best = i;
    }
    return best;
}

GpuBuffer::State::~State() {
    for (VkBufferView view : {texels, words})
        if (view) vkDestroyBufferView(vulkan->device, view, nullptr);
    if (buffer) vkDestroyBuffer(vulkan->device, buffer, nullptr);
    if (memory) vkFreeMemory(vulkan->device, memory, nullptr);  // and its mapping; what is imported stays
}

/// Creates the buffer without its memory.
Result<std::shared_ptr<GpuBuffer::State>> GpuBuffer::make_state(const GpuDevice& device, std::string name,
                                                                std::size_t bytes, bool imported) {
    auto state = std::make_shared<State>();
    state->vulkan = device.vulkan();
    state->name = std::move(name);
    state->bytes = bytes;
    VulkanDevice& gpu = *state->vulkan;
    if (bytes == 0) return refusal(gpu, state->name, bytes, "there is no buffer without bytes");
    const std::uint64_t most = gpu.facts.limits.max_allocation;
    if (bytes > most - texel_bytes)
        return refusal(gpu, state->name, bytes, "at most " + std::to_string(most) + " in one piece");
    state->size = (bytes + texel_bytes - 1) / texel_bytes * texel_bytes;

    auto info = vulkan_struct<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
    info.size = state->size;
    info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT |
                 VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                 VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT |
                 VK_BUFFER_USAGE_INDEX_BUFFER_BIT;
    auto external =
        vulkan_struct<VkExternalMemoryBufferCreateInfo>(VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO);
    external.handleTypes = VK_EXTERNAL_MEMORY_HANDLE_TYPE_HOST_ALLOCATION_BIT_EXT;
    if (imported) {
        info.pNext = &external;
        info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    }
    TRY(checked(gpu, state->name, bytes, "vkCreateBuffer",
                vkCreateBuffer(gpu.device, &info, nullptr, &state->buffer)));
    gpu.name_object(VK_OBJECT_TYPE_BUFFER, reinterpret_cast<std::uint64_t>(state->buffer), state->name);
    return state;
}

/// Gives the buffer memory of this type.
Result<void> GpuBuffer::allocate(State& state, std::uint32_t memory_type, std::size_t bytes) {
    VulkanDevice& gpu = *state.vulkan;
    if (bytes > heap_bytes(gpu, memory_type))
        return refusal(gpu, state.name, state.bytes,
                       "the memory has only " + std::to_string(heap_bytes(gpu, memory_type)));
    auto import = vulkan_struct<VkImportMemoryHostPointerInfoEXT>(
        VK_STRUCTURE_TYPE_IMPORT_MEMORY_HOST_POINTER_INFO_EXT);
    import.handleType = VK_EXTERNAL_MEMORY_HANDLE_TYPE_HOST_ALLOCATION_BIT_EXT;
    import.pHostPointer = state.imported ? state.imported->data() : nullptr;
    auto memory = vulkan_struct<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
    memory.pNext = state.imported ? &import : nullptr;
    memory.allocationSize = bytes;
    memory.memoryTypeIndex = memory_type;
    TRY(checked(gpu, state.name, state.bytes, "vkAllocateMemory",
                vkAllocateMemory(gpu.device, &memory, nullptr, &state.memory)));
    return checked(gpu, state.name, state.bytes, "vkBindBufferMemory",
                   vkBindBufferMemory(gpu.device, state.buffer, state.memory, 0));
}

/// Creates views of its texels, if these are not more than a view may have.
Result<void> GpuBuffer::make_views(State& state) {
    VulkanDevice& gpu = *state.vulkan;
    const struct {
        VkBufferView& view;
        VkFormat format;
        std::size_t texel_bytes;
    } views[] = {{state.texels, VK_FORMAT_R32G32B32A32_UINT, texel_bytes},
                 {state.words, VK_FORMAT_R32_UINT, 4}};
    for (const auto& each : views) {
        if (state.size / each.texel_bytes > gpu.facts.limits.max_texel_buffer_elements) continue;
        auto view = vulkan_struct<VkBufferViewCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO);
        view.buffer = state.buffer;
        view.format = each.format;
        view.range = state.size;
        TRY(checked(gpu, state.name, state.bytes, "vkCreateBufferView",
                    vkCreateBufferView(gpu.device, &view, nullptr, &each.view)));
    }
    return {};
}

Result<GpuBuffer> GpuBuffer::create(const GpuDevice& device, std::string name, std::size_t bytes,
                                    GpuMemory memory) {
    TRY_ASSIGN(auto state, make_state(device, std::move(name), bytes));
    VulkanDevice& gpu = *state->vulkan;
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(gpu.device, state->buffer, &needs);
    const auto type = choose_memory_type(gpu.memory, needs.memoryTypeBits, memory);
    if (!type) return refusal(gpu, state->name, bytes, "no memory the CPU can see");
    TRY(allocate(*state, *type, needs.size));
    TRY(make_views(*state));

    if (memory != GpuMemory::device)
        TRY(checked(gpu, state->name, bytes, "vkMapMemory",
                    vkMapMemory(gpu.device, state->memory, 0, VK_WHOLE_SIZE, 0, &state->mapped)));
    GpuBuffer buffer;
    buffer.state_ = std::move(state);
    return buffer;
}

Result<void> GpuBuffer::reserve(const GpuDevice& device, const char* name, std::size_t bytes,
                                GpuMemory memory) {
    if (state_ && state_->bytes >= bytes) return {};
    return assign(*this, create(device, name, bytes, memory));
}

Result<GpuBuffer> GpuBuffer::import(const GpuDevice& device, std::string name,
                                    std::shared_ptr<const PlaneBlock> block) {
    TRY_ASSIGN(auto state, make_state(device, std::move(name), block->bytes(), true));
    VulkanDevice& gpu = *state->vulkan;
    const std::size_t alignment = gpu.facts.import_alignment;
    if (!gpu.host_memory_types || block->bytes() % alignment != 0 ||
        reinterpret_cast<std::uintptr_t>(block->data()) % alignment != 0)
        return refusal(gpu, state->name, block->bytes(), "it cannot be imported");
    state->imported = std::move(block);
    auto host =
        vulkan_struct<VkMemoryHostPointerPropertiesEXT>(VK_STRUCTURE_TYPE_MEMORY_HOST_POINTER_PROPERTIES_EXT);
    TRY(checked(gpu, state->name, state->bytes, "vkGetMemoryHostPointerPropertiesEXT",
                gpu.host_memory_types(gpu.device, VK_EXTERNAL_MEMORY_HANDLE_TYPE_HOST_ALLOCATION_BIT_EXT,
                                      state->imported->data(), &host)));
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(gpu.device, state->buffer, &needs);
    const auto type =
        choose_memory_type(gpu.memory, needs.memoryTypeBits & host.memoryTypeBits, GpuMemory::upload);
    if (!type || needs.size > state->bytes)
        return refusal(gpu, state->name, state->bytes, "no memory type imports it");
    TRY(allocate(*state, *type, state->bytes));
    GpuBuffer buffer;
    buffer.state_ = std::move(state);
    return buffer;
}

VulkanDevice::Pipeline::~Pipeline() {
    if (pipeline) vkDestroyPipeline(vulkan->device, pipeline, nullptr);
    if (pipeline_layout) vkDestroyPipelineLayout(vulkan->device, pipeline_layout, nullptr);
    if (set_layout) vkDestroyDescriptorSetLayout(vulkan->device, set_layout, nullptr);
}

VulkanDevice::Pipeline::Shader::~Shader() {
    if (info.module) vkDestroyShaderModule(gpu->device, info.module, nullptr);
}

Result<void> VulkanDevice::Pipeline::Shader::load(VulkanDevice& of, VkShaderStageFlagBits stage,
                                                  std::span<const std::uint32_t> spirv,
                                                  std::span<const std::uint32_t> constants) {
    gpu = &of;
    for (std::uint32_t k = 0; k < constants.size(); ++k) entries.push_back({k, 4 * k, 4});
    special = {static_cast<std::uint32_t>(entries.size()), entries.data(), constants.size_bytes(),
               constants.data()};
    info =
        vulkan_struct<VkPipelineShaderStageCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
    info.stage = stage;
    info.pName = "main";
    info.pSpecializationInfo = &special;
    auto code = vulkan_struct<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
    code.codeSize = spirv.size_bytes();
    code.pCode = spirv.data();
    return gpu->checked("vkCreateShaderModule",
                        vkCreateShaderModule(gpu->device, &code, nullptr, &info.module));
}

Result<void> VulkanDevice::Pipeline::make_layouts(std::span<const VkDescriptorType> types,
                                                  std::uint32_t push_bytes, VkShaderStageFlags stages) {
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    for (const VkDescriptorType type : types)
        bindings.push_back({static_cast<std::uint32_t>(bindings.size()), type, 1, stages, nullptr});
    auto set =
        vulkan_struct<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
    set.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR;
    set.bindingCount = static_cast<std::uint32_t>(bindings.size());
    set.pBindings = bindings.data();
    TRY(vulkan->checked("vkCreateDescriptorSetLayout",
                        vkCreateDescriptorSetLayout(vulkan->device, &set, nullptr, &set_layout)));
    const VkPushConstantRange push{stages, 0, push_bytes};
    auto info = vulkan_struct<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
    info.setLayoutCount = 1;
    info.pSetLayouts = &set_layout;
    info.pushConstantRangeCount = push_bytes > 0;
    info.pPushConstantRanges = &push;
    return vulkan->checked("vkCreatePipelineLayout",
                           vkCreatePipelineLayout(vulkan->device, &info, nullptr, &pipeline_layout));
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
    if (auto made = make_pipeline(*state, state->layout, spirv, constants); !made)
        return refusal(ErrorKind::gpu, made.error().message);
    state->vulkan->name_object(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<std::uint64_t>(state->pipeline),
                               name);
    GpuProgram program;
    program.state_ = std::move(state);
    return program;
}

}  // namespace touchable
