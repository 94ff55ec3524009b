#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_device.hpp"

namespace touchable {

/// A command buffer with its own pool, so that any thread may record, its timestamps, and what it uses.
struct GpuRecording : NonCopyable {
    static constexpr std::uint32_t max_marks = 31;

    static Result<std::unique_ptr<GpuRecording>> create(std::shared_ptr<VulkanDevice> vulkan);
    ~GpuRecording();

    /// Begins anew, after all that was submitted before and seeing what it wrote. Not while in flight.
    Result<void> begin(GpuTiming timing);
    void stamp();        ///< one more timestamp; nothing where the queue has none, or none is wanted
    Result<void> end();  ///< what it writes is seen by the CPU once it has completed
    void read_times();   ///< fills `times`; once completed
    void release();      ///< lets go of what it used

    std::shared_ptr<VulkanDevice> vulkan;
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkQueryPool stamps = VK_NULL_HANDLE;
    std::uint32_t stamp_count = 0;
    bool is_timed = false;
    std::uint64_t value = 0;          ///< on the timeline; 0 before it is submitted
    std::vector<std::string> labels;  ///< of the marks: stamps 1, 2...
    std::vector<std::shared_ptr<const void>> kept;
    std::shared_ptr<std::vector<GpuDevice::Time>> times;
};

/// Ticks from one timestamp to a later one, of which only the low `bits` count: what stands above is whatever
/// the queue left there, and a count that was full has begun anew in between.
std::uint64_t ticks_between(std::uint64_t from, std::uint64_t to, std::uint32_t bits);

VkDescriptorType descriptor_type(GpuBindingKind kind);

/// A barrier over all memory.
void record_barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from, VkAccessFlags2 written,
                    VkPipelineStageFlags2 to, VkAccessFlags2 used);

}  // namespace touchable
