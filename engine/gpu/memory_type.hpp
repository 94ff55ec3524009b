#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <optional>

#include "engine/gpu/gpu_buffer.hpp"

namespace touchable {

/// The memory type that serves a use best, among those whose bit is set in `allowed`; none where no type
/// serves it.
std::optional<std::uint32_t> choose_memory_type(const VkPhysicalDeviceMemoryProperties& memory,
                                                std::uint32_t allowed, GpuMemory use);

}  // namespace touchable
