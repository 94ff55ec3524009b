// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/gpu_device.hpp"

#include <algorithm>
#include <list>

#include "engine/base/try.hpp"
#include "engine/gpu/gpu_recording.hpp"
#include "engine/gpu/vulkan_instance.hpp"

namespace touchable {

namespace {

struct Feature {
    const char* name;
    VkBool32& (*of)(GpuFeatures&);
};

#define TOUCHABLE_FEATURE(part, name)                                   \
    Feature {                                                           \
#name, [](GpuFeatures & f) -> VkBool32& { return f.part.name; } \
    }

/// Features that kernels declare (tests/gpu/device_test.cpp compares both), and those that the code calls.
/// Every Vulkan 1.3 has the latter, but they must be enabled.
constexpr Feature needed_features[] = {
    TOUCHABLE_FEATURE(core.features, shaderInt64), TOUCHABLE_FEATURE(v12, timelineSemaphore),
    TOUCHABLE_FEATURE(v13, synchronization2),      TOUCHABLE_FEATURE(v13, maintenance4),
    TOUCHABLE_FEATURE(v13, dynamicRendering),
};

constexpr Feature optional_features[] = {
    TOUCHABLE_FEATURE(v12, shaderBufferInt64Atomics),  // the painter raster
};

#undef TOUCHABLE_FEATURE

constexpr const char* needed_extensions[] = {VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME};
constexpr const char* optional_extensions[] = {
    VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME,
    // A device that has it implements a subset of Vulkan on another API, and requires this to be enabled.
    // Nothing that may be missing then is used here.
    "VK_KHR_portability_subset",
};

bool has_extension(const std::vector<std::string>& here, std::string_view name) {
    return std::ranges::find(here, name) != here.end();
}

bool is_on(const Feature& feature, const GpuFeatures& features) {
    return feature.of(const_cast<GpuFeatures&>(features)) == VK_TRUE;  // read only
}

std::string version_text(std::uint32_t version) {
    return std::to_string(VK_API_VERSION_MAJOR(version)) + "." +
           std::to_string(VK_API_VERSION_MINOR(version)) + "." +
           std::to_string(VK_API_VERSION_PATCH(version));
}

GpuKind kind_of(VkPhysicalDeviceType type) {
    if (type == VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU) return GpuKind::discrete;
    if (type == VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU) return GpuKind::integrated;
    if (type == VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU) return GpuKind::virtualised;
    return type == VK_PHYSICAL_DEVICE_TYPE_CPU ? GpuKind::software : GpuKind::other;
}

std::vector<VkQueueFamilyProperties> families_of(VkPhysicalDevice device) {
    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
    return families;
}

bool has_unified_memory(VkPhysicalDevice device) {
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(device, &memory);
    constexpr VkMemoryPropertyFlags unified =
        VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
        VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    return std::any_of(memory.memoryTypes, memory.memoryTypes + memory.memoryTypeCount,
                       [](const VkMemoryType& type) { return (type.propertyFlags & unified) == unified; });
}

struct Properties {
    VkPhysicalDeviceProperties2 core{};
    VkPhysicalDeviceVulkan11Properties v11{};
    VkPhysicalDeviceVulkan12Properties v12{};
    VkPhysicalDeviceVulkan13Properties v13{};
    VkPhysicalDeviceExternalMemoryHostPropertiesEXT host_memory{};
};

void ask(VkPhysicalDevice device, bool imports, Properties& properties) {
    properties.core.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    properties.v11.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES;
    properties.v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES;
    properties.v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES;
    properties.host_memory.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_MEMORY_HOST_PROPERTIES_EXT;
    properties.core.pNext = &properties.v11;
    properties.v11.pNext = &properties.v12;
    properties.v12.pNext = &properties.v13;
    properties.v13.pNext = imports ? &properties.host_memory : nullptr;
    vkGetPhysicalDeviceProperties2(device, &properties.core);
}

GpuFacts::Limits limits_of(const Properties& properties) {
    const VkPhysicalDeviceLimits& from = properties.core.properties.limits;
    GpuFacts::Limits limits;
    limits.max_storage_buffer_range = from.maxStorageBufferRange;
    limits.max_allocation = std::min(properties.v11.maxMemoryAllocationSize, properties.v13.maxBufferSize);
    limits.max_texel_buffer_elements = from.maxTexelBufferElements;
    limits.max_push_constants = from.maxPushConstantsSize;
    limits.max_group_invocations = from.maxComputeWorkGroupInvocations;
    std::copy_n(from.maxComputeWorkGroupSize, 3, limits.max_group_size.begin());
    std::copy_n(from.maxComputeWorkGroupCount, 3, limits.max_group_count.begin());
    limits.max_shared_memory = from.maxComputeSharedMemorySize;
    limits.subgroup_size = properties.v11.subgroupSize;
    limits.max_storage_buffers = from.maxPerStageDescriptorStorageBuffers;
    limits.min_storage_buffer_alignment = static_cast<std::uint32_t>(from.minStorageBufferOffsetAlignment);
    limits.min_texel_buffer_alignment = static_cast<std::uint32_t>(from.minTexelBufferOffsetAlignment);
    return limits;
}

/// The queue family to use: one that computes and draws, else one that computes; negative if there is none.
int queue_family_of(VkPhysicalDevice device) {
    const auto families = families_of(device);
    for (const VkQueueFlags wanted : {VK_QUEUE_COMPUTE_BIT | VK_QUEUE_GRAPHICS_BIT, VK_QUEUE_COMPUTE_BIT + 0})
        for (std::size_t i = 0; i < families.size(); ++i)
            if (families[i].queueCount > 0 && (families[i].queueFlags & wanted) == wanted)
                return static_cast<int>(i);
    return -1;
}

std::vector<std::string> extensions_of(VkPhysicalDevice device) {
    std::vector<std::string> names;
    for (const VkExtensionProperties& extension :
         vulkan_list<VkExtensionProperties>(vkEnumerateDeviceExtensionProperties, device, nullptr))
        names.emplace_back(extension.extensionName);
    return names;
}

GpuFacts facts_of(VkPhysicalDevice device) {
    VkPhysicalDeviceProperties oldest;
    vkGetPhysicalDeviceProperties(device, &oldest);
    GpuFacts facts;
    facts.name = oldest.deviceName;
    facts.api = version_text(oldest.apiVersion);
    facts.kind = kind_of(oldest.deviceType);
    GpuFeatures features;
    GpuOffer offer{oldest.apiVersion, extensions_of(device), false};
    if (oldest.apiVersion < VK_API_VERSION_1_3) {  // must not get chains of newer Vulkan
        facts.missing = missing_from(offer, features);
        return facts;
    }

    const bool imports = has_extension(offer.extensions, VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME);
    Properties properties;
    ask(device, imports, properties);
    vkGetPhysicalDeviceFeatures2(device, &features.core);
    facts.driver = properties.v12.driverName;
    facts.driver_info = properties.v12.driverInfo;
    facts.limits = limits_of(properties);
    facts.unified_memory = has_unified_memory(device);
    facts.int64_atomics = features.v12.shaderBufferInt64Atomics == VK_TRUE;
    facts.float64 = features.core.features.shaderFloat64 == VK_TRUE;
    facts.import_alignment = imports ? properties.host_memory.minImportedHostPointerAlignment : 0;
    if (const int family = queue_family_of(device); family >= 0) {
        const VkQueueFamilyProperties queue = families_of(device)[static_cast<std::size_t>(family)];
        offer.computes = true;
        facts.draws_triangles = (queue.queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0;
        facts.limits.timestamp_bits = queue.timestampValidBits;
        facts.limits.timestamp_period_ns = queue.timestampValidBits > 0 ? oldest.limits.timestampPeriod : 0;
    }
    facts.missing = missing_from(offer, features);
    return facts;
}

std::vector<GpuFacts> all_facts(const std::vector<VkPhysicalDevice>& devices) {
    std::vector<GpuFacts> facts;
    for (const VkPhysicalDevice device : devices) facts.push_back(facts_of(device));
    return facts;
}

template <class Function>
Function function_of(VkDevice device, const char* name) {
    return reinterpret_cast<Function>(vkGetDeviceProcAddr(device, name));
}

Result<void> create_device(VulkanDevice& gpu, bool shows_pictures) {
    GpuFeatures here, wanted;
    vkGetPhysicalDeviceFeatures2(gpu.physical, &here.core);
    enable(wanted, here);
    const std::vector<std::string> extensions_here = extensions_of(gpu.physical);
    std::vector<const char*> extensions = extensions_to_enable(extensions_here);
    if (shows_pictures) {
        if (!has_extension(extensions_here, VK_KHR_SWAPCHAIN_EXTENSION_NAME))
            return gpu_error(gpu.facts.name + " has no " VK_KHR_SWAPCHAIN_EXTENSION_NAME
                                              " and cannot show pictures in a window");
        extensions.push_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);
    }

    const float priority = 1;
    auto queue = vulkan_struct<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
    queue.queueFamilyIndex = gpu.queue_family;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    auto info = vulkan_struct<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
    info.pNext = &wanted.core;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    TRY(gpu.checked("vkCreateDevice", vkCreateDevice(gpu.physical, &info, nullptr, &gpu.device)));

    vkGetDeviceQueue(gpu.device, gpu.queue_family, 0, &gpu.queue);
    vkGetPhysicalDeviceMemoryProperties(gpu.physical, &gpu.memory);
    gpu.push_descriptors =
        function_of<PFN_vkCmdPushDescriptorSetKHR>(gpu.device, "vkCmdPushDescriptorSetKHR");
    if (gpu.facts.import_alignment > 0)
        gpu.host_memory_types = function_of<PFN_vkGetMemoryHostPointerPropertiesEXT>(
            gpu.device, "vkGetMemoryHostPointerPropertiesEXT");
    if (gpu.instance->validates())
        gpu.set_name =
            function_of<PFN_vkSetDebugUtilsObjectNameEXT>(gpu.device, "vkSetDebugUtilsObjectNameEXT");
    return {};
}

Result<VkSemaphore> create_timeline(VulkanDevice& gpu) {
    auto type = vulkan_struct<VkSemaphoreTypeCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO);
    type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    auto info = vulkan_struct<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
    info.pNext = &type;
    VkSemaphore timeline = VK_NULL_HANDLE;
    TRY(gpu.checked("vkCreateSemaphore", vkCreateSemaphore(gpu.device, &info, nullptr, &timeline)));
    return timeline;
}

/// What a hanging device may still use, up to a value of its timeline.
struct Remains {
    std::shared_ptr<VulkanDevice> vulkan;
    VkSemaphore timeline;
    std::uint64_t value;
    std::chrono::nanoseconds patience;
    std::deque<std::unique_ptr<GpuRecording>> in_flight;
};

/// Never destroyed: a device may hang until the process ends.
struct Abandoned {
    std::mutex mutex;
    std::list<Remains> remains;
};
Abandoned& abandoned() {
    static auto* const all = new Abandoned;
    return *all;
}

VkResult wait_on(const VulkanDevice& gpu, VkSemaphore timeline, std::uint64_t value,
                 std::chrono::nanoseconds timeout) {
    auto info = vulkan_struct<VkSemaphoreWaitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO);
    info.semaphoreCount = 1;
    info.pSemaphores = &timeline;
    info.pValues = &value;
    return vkWaitSemaphores(gpu.device, &info, static_cast<std::uint64_t>(timeout.count()));
}

/// Frees what has been finished after all.
void free_finished_remains() {
    const std::lock_guard lock(abandoned().mutex);
    std::erase_if(abandoned().remains, [](const Remains& left) {
        std::uint64_t value = 0;
        const VkResult result = vkGetSemaphoreCounterValue(left.vulkan->device, left.timeline, &value);
        if (result != VK_SUCCESS || value < left.value) return false;
        vkDestroySemaphore(left.vulkan->device, left.timeline, nullptr);
        return true;
    });
}

Error lost_error(const VulkanDevice& gpu) {
    return gpu_error("the GPU " + gpu.facts.name + " was lost while it worked");
}

}  // namespace

GpuFeatures::GpuFeatures() {
    core.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    v11.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES;
    v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    core.pNext = &v11;
    v11.pNext = &v12;
    v12.pNext = &v13;
}

std::vector<std::string> missing_from(const GpuOffer& offer, const GpuFeatures& features) {
    std::vector<std::string> missing;
    if (offer.api_version < VK_API_VERSION_1_3)
        return {"Vulkan 1.3 (it has " + version_text(offer.api_version) + ")"};  // the rest would be guesses
    if (!offer.computes) missing.emplace_back("a queue that computes");
    for (const char* extension : needed_extensions)
        if (!has_extension(offer.extensions, extension)) missing.emplace_back(extension);
    for (const Feature& feature : needed_features)
        if (!is_on(feature, features)) missing.emplace_back(feature.name);
    return missing;
}

void enable(GpuFeatures& wanted, const GpuFeatures& here) {
    for (const Feature& feature : needed_features) feature.of(wanted) = VK_TRUE;
    for (const Feature& feature : optional_features)
        if (is_on(feature, here)) feature.of(wanted) = VK_TRUE;
}

std::vector<const char*> extensions_to_enable(const std::vector<std::string>& here) {
    std::vector<const char*> enabled(std::begin(needed_extensions), std::end(needed_extensions));
    for (const char* extension : optional_extensions)
        if (has_extension(here, extension)) enabled.push_back(extension);
    return enabled;
}

Result<std::vector<GpuFacts>> list_gpus() {
    TRY_ASSIGN(auto instance, VulkanInstance::create(false));
    if (!instance) return std::vector<GpuFacts>();
    TRY_ASSIGN(auto devices, instance->devices());
    return all_facts(devices);
}

Result<std::shared_ptr<GpuDevice>> GpuDevice::open(const GpuOptions& options) {
    free_finished_remains();
    auto vulkan = std::make_shared<VulkanDevice>();
    TRY_ASSIGN(auto instance, VulkanInstance::create(options.validation, options.window_extensions));
    std::vector<VkPhysicalDevice> devices;
    if (instance) TRY(assign(devices, instance->devices()));
    const std::vector<GpuFacts> facts = all_facts(devices);
    TRY_ASSIGN(const auto chosen, choose_gpu(facts, options.request));

    vulkan->instance = std::move(instance);
    vulkan->physical = devices[chosen];
    vulkan->facts = facts[chosen];
    vulkan->queue_family = static_cast<std::uint32_t>(queue_family_of(vulkan->physical));
    TRY(create_device(*vulkan, !options.window_extensions.empty()));
    vulkan->open_programs(options.cache_folder);
    TRY_ASSIGN(const auto timeline, create_timeline(*vulkan));
    return std::shared_ptr<GpuDevice>(new GpuDevice(std::move(vulkan), timeline));
}

GpuDevice::GpuDevice(std::shared_ptr<VulkanDevice> vulkan, VkSemaphore timeline)
    : vulkan_(std::move(vulkan)),
      timeline_(timeline),
      patience_(std::chrono::seconds(vulkan_->facts.kind == GpuKind::software ? 60 : 10)) {}

GpuDevice::~GpuDevice() {
    if (!comes_to_rest()) {
        abandon();
        return;
    }
    {
        const std::lock_guard lock(vulkan_->queue_mutex);
        vkQueueWaitIdle(vulkan_->queue);  // on a lost device there is nothing left to wait for
    }
    in_flight_.clear();
    idle_.clear();
    vkDestroySemaphore(vulkan_->device, timeline_, nullptr);
}

std::shared_ptr<const GpuMessages> GpuDevice::messages() const {
    return vulkan_->instance->messages();
}

bool GpuDevice::comes_to_rest() {
    std::uint64_t newest = 0;
    {
        const std::lock_guard lock(mutex_);
        newest = submitted_;
    }
    const bool rests = wait_on(*vulkan_, timeline_, newest,
                               lost() ? std::chrono::nanoseconds(0) : patience_.load()) != VK_TIMEOUT;
    if (!rests) vulkan_->lost = true;  // later waits fail at once
    return rests;
}

/// A hanging device may never finish, and what it may still read and write must not be freed. So recordings
/// in flight, all they use and the device itself are left in memory.
void GpuDevice::abandon() {
    const std::lock_guard lock(abandoned().mutex);
    abandoned().remains.push_back({vulkan_, timeline_, submitted_, patience_, std::move(in_flight_)});
}

std::uint64_t GpuDevice::completed() const {
    std::uint64_t value = 0;
    if (lost() || vkGetSemaphoreCounterValue(vulkan_->device, timeline_, &value) != VK_SUCCESS)
        return completed_;
    completed_ = value;
    return value;
}

Result<void> GpuDevice::wait(std::uint64_t value, std::chrono::nanoseconds at_most) {
    if (lost()) return lost_error(*vulkan_);
    const std::chrono::nanoseconds patience = std::min(patience_.load(), at_most);
    const VkResult result = wait_on(*vulkan_, timeline_, value, patience);
    if (result == VK_TIMEOUT) {
        vulkan_->lost = true;
        return gpu_error("the GPU " + vulkan_->facts.name + " has not finished after " +
                         std::to_string(patience.count() / 1'000'000) + " ms and is given up");
    }
    TRY(vulkan_->checked("vkWaitSemaphores", result));
    if (lost()) return lost_error(*vulkan_);
    collect();
    return {};
}

Result<std::unique_ptr<GpuRecording>> GpuDevice::take_recording() {
    if (lost()) return lost_error(*vulkan_);
    collect();
    {
        const std::lock_guard lock(mutex_);
        if (!idle_.empty()) {
            auto recording = std::move(idle_.back());
            idle_.pop_back();
            return recording;
        }
    }
    return GpuRecording::create(vulkan_);
}

void GpuDevice::give_back(std::unique_ptr<GpuRecording> recording) {
    recording->release();
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(recording));
}

Result<std::uint64_t> GpuDevice::submit(std::unique_ptr<GpuRecording> recording) {
    if (lost()) return lost_error(*vulkan_);
    const std::lock_guard lock(mutex_);  // values follow the order of the queue
    auto commands = vulkan_struct<VkCommandBufferSubmitInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO);
    commands.commandBuffer = recording->commands;
    auto signal = vulkan_struct<VkSemaphoreSubmitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO);
    signal.semaphore = timeline_;
    signal.value = submitted_ + 1;
    signal.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    auto info = vulkan_struct<VkSubmitInfo2>(VK_STRUCTURE_TYPE_SUBMIT_INFO_2);
    info.commandBufferInfoCount = 1;
    info.pCommandBufferInfos = &commands;
    info.signalSemaphoreInfoCount = 1;
    info.pSignalSemaphoreInfos = &signal;
    VkResult result;
    {
        const std::lock_guard queue_lock(vulkan_->queue_mutex);
        result = vkQueueSubmit2(vulkan_->queue, 1, &info, VK_NULL_HANDLE);
    }
    TRY(vulkan_->checked("vkQueueSubmit2", result));
    recording->value = ++submitted_;
    in_flight_.push_back(std::move(recording));
    return submitted_;
}

void GpuDevice::collect() {
    const std::uint64_t done = completed();
    // Freed after the lock is released: these may be the last handles to something large, for which no other
    // thread should wait.
    std::vector<std::shared_ptr<const void>> let_go;
    const std::lock_guard lock(mutex_);
    while (!in_flight_.empty() && in_flight_.front()->value <= done) {
        auto recording = std::move(in_flight_.front());
        in_flight_.pop_front();
        // Some drivers wait for all work in flight before they return times.
        if (recording->times.use_count() > 1) recording->read_times();
        let_go.insert(let_go.end(), recording->kept.begin(), recording->kept.end());
        recording->release();
        idle_.push_back(std::move(recording));
    }
}

std::vector<GpuDevice::Time> GpuDevice::read(const std::vector<Time>& times) {
    collect();
    const std::lock_guard lock(mutex_);
    return times;
}

void wait_for_given_up_gpus() {
    {
        const std::lock_guard lock(abandoned().mutex);
        for (const Remains& left : abandoned().remains)
            if (left.vulkan->facts.kind == GpuKind::software)
                wait_on(*left.vulkan, left.timeline, left.value, left.patience);
    }
    free_finished_remains();
}

}  // namespace touchable
