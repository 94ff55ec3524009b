#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>

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
    std::uint64_t threads = 0;  // of the CPU that was measured beside
    GpuFacts::Measured measured;
    std::uint64_t bytes = 0, hash = 0;  // of what comes after it; of that and `measured`

    bool operator==(const Head& other) const { return std::memcmp(this, &other, sizeof(*this)) == 0; }
};
static_assert(sizeof(Head) == 72 + sizeof(GpuFacts::Measured));

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

Head head_of(const VulkanDevice& gpu, const GpuFacts::Measured& measured, std::string_view data) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(gpu.physical, &properties);
    Head head;
    head.vendor = properties.vendorID;
    head.device = properties.deviceID;
    head.driver_version = properties.driverVersion;
    std::copy_n(properties.pipelineCacheUUID, VK_UUID_SIZE, head.cache_uuid);
    head.threads = std::thread::hardware_concurrency();
    head.measured = measured;
    head.bytes = data.size();
    head.hash =
        hash_of(std::string(reinterpret_cast<const char*>(&measured), sizeof(measured)) + std::string(data));
    return head;
}

/// What was kept for this device and driver; nothing where there is no such thing, or it is damaged.
struct Kept {
    Head head;
    std::string data;
};
std::optional<Kept> read_kept(const VulkanDevice& gpu, const std::filesystem::path& file) {
    const auto bytes = read_given_file(file, file.string(), "what a driver made of kernels", most_bytes);
    if (!bytes || bytes->size() < sizeof(Head)) return std::nullopt;
    Kept kept;
    std::memcpy(&kept.head, bytes->data(), sizeof(Head));
    kept.data = bytes->substr(sizeof(Head));
    if (!(kept.head == head_of(gpu, kept.head.measured, kept.data))) return std::nullopt;
    return kept;
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
        if (auto kept = read_kept(*this, programs_file)) {
            facts.measured = kept->head.measured;
            kept_hash = kept->head.hash;
            data = std::move(kept->data);
        }
    }
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
    const Head head = head_of(*this, facts.measured, data);
    if (head.hash == kept_hash) return;
    std::error_code failed;
    std::filesystem::create_directories(programs_file.parent_path(), failed);
    NewFile file(programs_file);
    file.need_not_last();
    // Where it cannot be kept it is made again.
    if (file.write(std::string(reinterpret_cast<const char*>(&head), sizeof(head)) + data) && file.commit())
        kept_hash = head.hash;
}

}  // namespace touchable
