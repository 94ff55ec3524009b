#include "engine/gpu/gpu_recording.hpp"

#include "engine/base/try.hpp"

namespace touchable {

void record_barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from, VkAccessFlags2 written,
                    VkPipelineStageFlags2 to, VkAccessFlags2 used) {
    auto barrier = vulkan_struct<VkMemoryBarrier2>(VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
    barrier.srcStageMask = from;
    barrier.srcAccessMask = written;
    barrier.dstStageMask = to;
    barrier.dstAccessMask = used;
    auto info = vulkan_struct<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
    info.memoryBarrierCount = 1;
    info.pMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(commands, &info);
}

std::uint64_t ticks_between(std::uint64_t from, std::uint64_t to, std::uint32_t bits) {
    const std::uint64_t passed = to - from;
    return bits < 64 ? passed & ((std::uint64_t{1} << bits) - 1) : passed;
}

Result<std::unique_ptr<GpuRecording>> GpuRecording::create(std::shared_ptr<VulkanDevice> vulkan) {
    auto made = std::make_unique<GpuRecording>();
    made->vulkan = std::move(vulkan);
    VulkanDevice& gpu = *made->vulkan;

    auto pool = vulkan_struct<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    pool.queueFamilyIndex = gpu.queue_family;
    TRY(gpu.checked("vkCreateCommandPool", vkCreateCommandPool(gpu.device, &pool, nullptr, &made->pool)));

    auto buffer = vulkan_struct<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    buffer.commandPool = made->pool;
    buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    buffer.commandBufferCount = 1;
    TRY(gpu.checked("vkAllocateCommandBuffers",
                    vkAllocateCommandBuffers(gpu.device, &buffer, &made->commands)));

    if (gpu.facts.limits.timestamp_period_ns > 0) {
        auto stamps = vulkan_struct<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
        stamps.queryType = VK_QUERY_TYPE_TIMESTAMP;
        stamps.queryCount = max_marks + 1;
        TRY(gpu.checked("vkCreateQueryPool", vkCreateQueryPool(gpu.device, &stamps, nullptr, &made->stamps)));
    }
    return made;
}

GpuRecording::~GpuRecording() {
    if (stamps) vkDestroyQueryPool(vulkan->device, stamps, nullptr);
    if (pool) vkDestroyCommandPool(vulkan->device, pool, nullptr);  // and its command buffer
}

Result<void> GpuRecording::begin(GpuTiming timing) {
    release();
    is_timed = stamps && timing == GpuTiming::by_marks;
    times = std::make_shared<std::vector<GpuDevice::Time>>();
    TRY(vulkan->checked("vkResetCommandPool", vkResetCommandPool(vulkan->device, pool, 0)));
    auto info = vulkan_struct<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    TRY(vulkan->checked("vkBeginCommandBuffer", vkBeginCommandBuffer(commands, &info)));
    record_barrier(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
                   VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                   VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT);
    if (is_timed) vkCmdResetQueryPool(commands, stamps, 0, max_marks + 1);
    stamp();
    return {};
}

void GpuRecording::stamp() {
    if (is_timed) vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, stamps, stamp_count++);
}

Result<void> GpuRecording::end() {
    record_barrier(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
                   VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT | VK_ACCESS_2_HOST_WRITE_BIT);
    return vulkan->checked("vkEndCommandBuffer", vkEndCommandBuffer(commands));
}

void GpuRecording::read_times() {
    if (labels.empty() || !is_timed) return;
    std::array<std::uint64_t, max_marks + 1> ticks{};
    const VkResult result =
        vkGetQueryPoolResults(vulkan->device, stamps, 0, stamp_count, stamp_count * sizeof(ticks[0]),
                              ticks.data(), sizeof(ticks[0]), VK_QUERY_RESULT_64_BIT);
    if (result != VK_SUCCESS) return;  // work without times is still work
    const GpuFacts::Limits& limits = vulkan->facts.limits;
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const auto passed = static_cast<double>(ticks_between(ticks[i], ticks[i + 1], limits.timestamp_bits));
        times->push_back({labels[i], passed * limits.timestamp_period_ns * 1e-6});
    }
}

void GpuRecording::release() {
    kept.clear();
    labels.clear();
    stamp_count = 0;
    value = 0;
    times.reset();
}

}  // namespace touchable
