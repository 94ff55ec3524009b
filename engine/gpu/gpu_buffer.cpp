#include "engine/gpu/gpu_buffer.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/gpu/memory_type.hpp"

namespace touchable {
namespace {

constexpr std::size_t texel_bytes = 16;  // rgba32ui

Error refusal(const VulkanDevice& gpu, const std::string& name, std::size_t bytes, const std::string& why) {
    return {ErrorKind::gpu, "GPU buffer '" + name + "' of " + std::to_string(bytes) + " bytes: " + why +
                                " on " + gpu.facts.name};
}

Error refusal(VulkanDevice& gpu, const std::string& name, std::size_t bytes, const char* call,
              VkResult result) {
    return {ErrorKind::gpu, "GPU buffer '" + name + "' of " + std::to_string(bytes) +
                                " bytes: " + gpu.failed(call, result).message};
}

std::size_t rounded_up(std::size_t bytes) {
    return (bytes + texel_bytes - 1) / texel_bytes * texel_bytes;
}

std::uint64_t heap_bytes(const VulkanDevice& gpu, std::uint32_t memory_type) {
    return gpu.memory.memoryHeaps[gpu.memory.memoryTypes[memory_type].heapIndex].size;
}

}  // namespace

GpuBuffer::State::~State() {
    for (VkBufferView view : {texels, words})
        if (view) vkDestroyBufferView(vulkan->device, view, nullptr);
    if (buffer) vkDestroyBuffer(vulkan->device, buffer, nullptr);
    if (memory) vkFreeMemory(vulkan->device, memory, nullptr);  // and its mapping
}

/// The buffer without its memory.
Result<std::shared_ptr<GpuBuffer::State>> GpuBuffer::make_state(const GpuDevice& device, std::string name,
                                                                std::size_t bytes) {
    auto state = std::make_shared<State>();
    state->vulkan = device.vulkan();
    state->name = std::move(name);
    state->bytes = bytes;
    VulkanDevice& gpu = *state->vulkan;
    if (bytes == 0) return refusal(gpu, state->name, bytes, "there is no buffer without bytes");
    const std::uint64_t most = gpu.facts.limits.max_allocation;
    if (bytes > most - texel_bytes)
        return refusal(gpu, state->name, bytes, "at most " + std::to_string(most) + " in one piece");
    state->size = rounded_up(bytes);

    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = state->size;
    info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT |
                 VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                 VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                 VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT;
    const VkResult result = vkCreateBuffer(gpu.device, &info, nullptr, &state->buffer);
    if (result != VK_SUCCESS) return refusal(gpu, state->name, bytes, "vkCreateBuffer", result);
    gpu.name_object(VK_OBJECT_TYPE_BUFFER, reinterpret_cast<std::uint64_t>(state->buffer), state->name);
    return state;
}

/// Gives the buffer memory of this type, and views of its texels where those are not larger than a view may
/// be.
Result<void> GpuBuffer::bind(State& state, std::uint32_t memory_type, std::size_t bytes) {
    VulkanDevice& gpu = *state.vulkan;
    if (bytes > heap_bytes(gpu, memory_type))
        return refusal(gpu, state.name, state.bytes,
                       "the memory has only " + std::to_string(heap_bytes(gpu, memory_type)));
    VkMemoryAllocateInfo memory{};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    memory.allocationSize = bytes;
    memory.memoryTypeIndex = memory_type;
    VkResult result = vkAllocateMemory(gpu.device, &memory, nullptr, &state.memory);
    if (result != VK_SUCCESS) return refusal(gpu, state.name, state.bytes, "vkAllocateMemory", result);
    result = vkBindBufferMemory(gpu.device, state.buffer, state.memory, 0);
    if (result != VK_SUCCESS) return refusal(gpu, state.name, state.bytes, "vkBindBufferMemory", result);

    const struct {
        VkBufferView& view;
        VkFormat format;
        std::size_t texel_bytes;
    } views[] = {{state.texels, VK_FORMAT_R32G32B32A32_UINT, texel_bytes},
                 {state.words, VK_FORMAT_R32_UINT, 4}};
    for (const auto& each : views) {
        if (state.size / each.texel_bytes > gpu.facts.limits.max_texel_buffer_elements) continue;
        VkBufferViewCreateInfo view{};
        view.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO;
        view.buffer = state.buffer;
        view.format = each.format;
        view.range = state.size;
        result = vkCreateBufferView(gpu.device, &view, nullptr, &each.view);
        if (result != VK_SUCCESS) return refusal(gpu, state.name, state.bytes, "vkCreateBufferView", result);
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
    TRY(bind(*state, *type, needs.size));

    if (memory != GpuMemory::device) {
        const VkResult result = vkMapMemory(gpu.device, state->memory, 0, VK_WHOLE_SIZE, 0, &state->mapped);
        if (result != VK_SUCCESS) return refusal(gpu, state->name, bytes, "vkMapMemory", result);
    }
    GpuBuffer buffer;
    buffer.state_ = std::move(state);
    return buffer;
}

}  // namespace touchable
