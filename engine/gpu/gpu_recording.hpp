// SPDX-License-Identifier: Apache-2.0
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

    /// Begins anew, after all earlier submissions and seeing what they wrote. Not while in flight.
    Result<void> begin(GpuTiming timing);
    void stamp();        ///< adds a timestamp, if the queue has any and marks are timed
    Result<void> end();  ///< the CPU sees its writes once it has completed
    void read_times();   ///< fills `times`; once completed
    void release();      ///< releases what it used

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

/// Ticks from one timestamp to a later one. Only the low `bits` are valid, and the counter may have wrapped
/// in between.
std::uint64_t ticks_between(std::uint64_t from, std::uint64_t to, std::uint32_t bits);

VkDescriptorType descriptor_type(GpuBindingKind kind);

/// Records a barrier over all memory.
void record_barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from, VkAccessFlags2 written,
                    VkPipelineStageFlags2 to, VkAccessFlags2 used);

}  // namespace touchable
