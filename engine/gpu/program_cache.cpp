#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/files.hpp"
#include "engine/gpu/gpu_device.hpp"

// What a driver makes of kernels, kept from run to run: an NVIDIA driver takes 15 to 580 ms for each, and
// keeps nothing itself where it has no folder to do so. A file for each device, in what the driver gives as
// the data of its VkPipelineCache, behind a head of ours: a driver refuses the data of another one, but need
// not survive damaged data.

namespace touchable {
namespace {

constexpr std::size_t most_bytes = std::size_t{64} << 20;

struct Head {
    char magic[16] = {'t', 'o', 'u', 'c', 'h', 'a', 'b', 'l', 'e', ' ', 'p', 'r', 'o', 'g', ' ', '1'};
    std::uint32_t vendor = 0, device = 0, driver_version = 0, cache_version = 0;
    std::uint8_t cache_uuid[VK_UUID_SIZE] = {};
    std::uint64_t bytes = 0, hash = 0;  // of what comes after it

    bool operator==(const Head& other) const { return std::memcmp(this, &other, sizeof(*this)) == 0; }
};
static_assert(sizeof(Head) == 64);

/// FNV-1a of words of 8 bytes: against damage, not against people.
std::uint64_t hash_of(std::string_view bytes) {
    std::uint64_t hash = 14695981039346656037U;
    for (std::size_t k = 0; k < bytes.size(); k += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, bytes.data() + k, std::min<std::size_t>(8, bytes.size() - k));
        hash = (hash ^ word) * 1099511628211U;
    }
    return hash;
}

Head head_of(const VulkanDevice& gpu, std::string_view data) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(gpu.physical, &properties);
    Head head;
    head.vendor = properties.vendorID;
    head.device = properties.deviceID;
    head.driver_version = properties.driverVersion;
    std::copy_n(properties.pipelineCacheUUID, VK_UUID_SIZE, head.cache_uuid);
    head.bytes = data.size();
    head.hash = hash_of(data);
    return head;
}

/// What was kept for this device and driver; empty where that is nothing, or damaged.
std::string kept_data(const VulkanDevice& gpu, const std::filesystem::path& file) {
    const auto kept = read_given_file(file, file.string(), "what a driver made of kernels", most_bytes);
    if (!kept || kept->size() < sizeof(Head)) return {};
    Head head;
    std::memcpy(&head, kept->data(), sizeof(Head));
    std::string data = kept->substr(sizeof(Head));
    return head == head_of(gpu, data) ? data : std::string();
}

}  // namespace

void VulkanDevice::open_programs(const std::filesystem::path& folder) {
    std::string data;
    if (!folder.empty()) {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(physical, &properties);
        char name[32];
        std::snprintf(name, sizeof(name), "gpu-%04x-%04x.programs", properties.vendorID, properties.deviceID);
        programs_file = folder / name;
        data = kept_data(*this, programs_file);
    }
    kept_hash = hash_of(data);
    VkPipelineCacheCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
    info.initialDataSize = data.size();
    info.pInitialData = data.data();
    if (vkCreatePipelineCache(device, &info, nullptr, &programs) != VK_SUCCESS) programs = VK_NULL_HANDLE;
}

void VulkanDevice::keep_programs() {
    if (!programs || programs_file.empty() || lost) return;
    std::size_t bytes = 0;
    if (vkGetPipelineCacheData(device, programs, &bytes, nullptr) != VK_SUCCESS || bytes > most_bytes) return;
    std::string data(bytes, '\0');
    if (vkGetPipelineCacheData(device, programs, &bytes, data.data()) != VK_SUCCESS) return;
    data.resize(bytes);
    if (hash_of(data) == kept_hash) return;
    const Head head = head_of(*this, data);
    std::error_code failed;
    std::filesystem::create_directories(programs_file.parent_path(), failed);
    NewFile file(programs_file);
    file.need_not_last();
    // Where it cannot be kept it is made again.
    if (file.write(std::string(reinterpret_cast<const char*>(&head), sizeof(head)) + data) && file.commit())
        kept_hash = head.hash;
}

}  // namespace touchable
