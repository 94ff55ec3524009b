#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// `software` is a Vulkan that computes on the CPU, such as Mesa's lavapipe.
enum class GpuKind { discrete, integrated, virtualised, software, other };

/// For people and JSON: "discrete", "integrated", "virtual", "software", "other".
std::string_view name_of(GpuKind kind);

/// The limits a kernel or a buffer of this engine can run into; bytes unless said otherwise.
struct GpuLimits {
    std::uint64_t max_storage_buffer_range = 0;   ///< of one binding
    std::uint64_t max_allocation = 0;             ///< of one buffer
    std::uint32_t max_texel_buffer_elements = 0;  ///< texels of one view
    std::uint32_t max_push_constants = 0;
    std::uint32_t max_group_invocations = 0;  ///< invocations of one workgroup
    std::array<std::uint32_t, 3> max_group_size{};
    std::array<std::uint32_t, 3> max_group_count{};
    std::uint32_t max_shared_memory = 0;  ///< of one workgroup
    std::uint32_t subgroup_size = 0;      ///< invocations
    std::uint32_t min_storage_buffer_alignment = 0;
    std::uint32_t min_texel_buffer_alignment = 0;
    double timestamp_period_ns = 0;    ///< of one tick of a timestamp; 0: the queue has none
    std::uint32_t timestamp_bits = 0;  ///< of a timestamp that count; beyond, it begins anew
};

/// What people call a device that calls itself otherwise: "lavapipe", where it says llvmpipe; else empty.
std::string_view nickname_of(std::string_view device_name);

/// What a Vulkan device says of itself, and what this engine needs and it lacks.
struct GpuFacts {
    std::string name;         ///< "llvmpipe (LLVM 15.0.6, 256 bits)"
    std::string driver;       ///< "llvmpipe"
    std::string driver_info;  ///< "Mesa 22.3.6 (LLVM 15.0.6)"
    std::string api;          ///< "1.3.230"
    GpuKind kind = GpuKind::other;
    GpuLimits limits;
    bool unified_memory = false;   ///< the CPU reads and writes device memory through its caches: no copies
    bool draws_triangles = false;  ///< its queue also does graphics
    bool int64_atomics = false;    ///< 64-bit atomics on storage buffers
    bool float64 = false;          ///< doubles in kernels
    std::uint64_t import_alignment =
        0;  ///< of host memory that it could import, which nobody asks for; 0: it cannot
    std::vector<std::string> missing;  ///< what this engine needs and it lacks, in words; empty: usable

    bool usable() const { return missing.empty(); }
};

/// Which device a request means: "auto" (discrete before integrated, virtual and software; the first of a
/// kind), the index of a device, or, upper or lower case alike, a part of one's name or nickname or its kind
/// ("software", or "cpu"). Refused (ErrorKind::gpu) where there is no such device, where a word means several
/// usable ones, or where it lacks something; the message names every device and what it lacks.
Result<std::size_t> choose_gpu(std::span<const GpuFacts> gpus, std::string_view request);

}  // namespace touchable
