// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>

#include "engine/base/files.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "shaders/block.spv.h"

// Compiled kernels, kept from run to run: an NVIDIA driver takes 15 to 580 ms for each, and keeps none itself
// without a folder for it. One file for each device: our head, then the data of the driver's VkPipelineCache.
// A driver refuses the data of another one, but need not survive damaged data.

namespace touchable {
namespace {

constexpr std::size_t most_bytes = std::size_t{64} << 20;

struct Head {
    char magic[16] = {'t', 'o', 'u', 'c', 'h', 'a', 'b', 'l', 'e', ' ', 'p', 'r', 'o', 'g', ' ', '2'};
    std::uint32_t vendor = 0, device = 0, driver_version = 0;
    std::uint32_t kernel = 0;  // hash of the measured kernel, for the program's version
    std::uint8_t cache_uuid[VK_UUID_SIZE] = {};
    std::uint64_t threads = 0;  // of the CPU that was measured, too
    GpuFacts::Measured measured;
    std::uint64_t bytes = 0, hash = 0;  // of what follows the head; of that and `measured`

    bool operator==(const Head& other) const { return std::memcmp(this, &other, sizeof(*this)) == 0; }
};
static_assert(sizeof(Head) == 72 + sizeof(GpuFacts::Measured));

/// Against damage, not against attacks.
std::uint64_t hash_of(std::string_view bytes, std::string_view more = {}) {
    ByteHash hash;
    hash.add(bytes.data(), bytes.size());
    hash.add(more.data(), more.size());
    return hash.value();
}

std::string_view bytes_of(const auto& object) {
    return {reinterpret_cast<const char*>(&object), sizeof(object)};
}

Head head_of(const VulkanDevice& gpu, std::string_view data) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(gpu.physical, &properties);
    Head head;
    head.vendor = properties.vendorID;
    head.device = properties.deviceID;
    head.driver_version = properties.driverVersion;
    head.kernel = static_cast<std::uint32_t>(hash_of(bytes_of(block_spv)));
    std::copy_n(properties.pipelineCacheUUID, VK_UUID_SIZE, head.cache_uuid);
    head.threads = std::thread::hardware_concurrency();
    head.measured = gpu.facts.measured;
    head.bytes = data.size();
    head.hash = hash_of(bytes_of(head.measured), data);
    return head;
}

/// A name for each device and driver, as two drivers do not read each other's data.
std::filesystem::path file_name(const VulkanDevice& gpu) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(gpu.physical, &properties);
    const std::string& driver = gpu.facts.driver;
    char name[48];
    std::snprintf(name, sizeof(name), "gpu-%04x-%04x-%08x.programs", properties.vendorID, properties.deviceID,
                  static_cast<unsigned>(hash_of(driver)));
    return name;
}

}  // namespace

void VulkanDevice::open_programs(const std::filesystem::path& folder) {
    std::string data;
    if (!folder.empty()) {
        programs_file = folder / file_name(*this);
        std::error_code failed;
        const bool is_there = std::filesystem::exists(programs_file, failed);
        auto kept = read_given_file(programs_file, programs_file.string(), "what a driver made of kernels",
                                    most_bytes + sizeof(Head));
        // A file that could not be read, as after a stop, is not replaced.
        if (is_there && !kept && kept.error().kind != ErrorKind::input) programs_file.clear();
        if (kept) data = take_kept(std::move(*kept));
    }
    auto info = vulkan_struct<VkPipelineCacheCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO);
    info.initialDataSize = data.size();
    info.pInitialData = data.data();
    if (vkCreatePipelineCache(device, &info, nullptr, &programs) != VK_SUCCESS) programs = VK_NULL_HANDLE;
}

/// Takes a file's programs, and its measured times if they are of this CPU; empty if it is damaged, or not of
/// this device, this driver and this program's kernels.
std::string VulkanDevice::take_kept(std::string bytes) {
    Head head;
    if (bytes.size() < sizeof(Head)) return {};
    std::memcpy(&head, bytes.data(), sizeof(Head));
    bytes.erase(0, sizeof(Head));
    const GpuFacts::Measured before = std::exchange(facts.measured, head.measured);
    Head right = head_of(*this, bytes);
    const bool is_of_this_cpu = std::exchange(right.threads, head.threads) == head.threads;
    if (head == right) {
        kept_hash = is_of_this_cpu ? head.hash : 0;
        if (is_of_this_cpu) return bytes;
    } else {
        bytes.clear();
    }
    facts.measured = before;
    return bytes;
}

std::optional<VulkanDevice::ProgramsToKeep> VulkanDevice::take_new_programs() {
    if (!programs || programs_file.empty()) return std::nullopt;
    // Of a lost device only measured times are kept: they tell that it was lost there.
    std::string data;
    std::size_t bytes = 0;
    if (!lost && vkGetPipelineCacheData(device, programs, &bytes, nullptr) == VK_SUCCESS &&
        bytes <= most_bytes) {
        data.resize(bytes);
        if (vkGetPipelineCacheData(device, programs, &bytes, data.data()) != VK_SUCCESS) return std::nullopt;
        data.resize(bytes);
    }
    const Head head = head_of(*this, data);
    if (head.hash == kept_hash) return std::nullopt;
    kept_hash = head.hash;
    data.insert(0, reinterpret_cast<const char*>(&head), sizeof(head));
    return ProgramsToKeep{programs_file, std::move(data)};
}

Result<void> VulkanDevice::ProgramsToKeep::keep() const {
    std::error_code failed;
    std::filesystem::create_directories(file.parent_path(), failed);
    NewFile out(file);
    out.need_not_last();
    TRY(out.write(bytes));
    return out.commit();
}

}  // namespace touchable
