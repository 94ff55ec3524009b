// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/vulkan_instance.hpp"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <iostream>

#include "engine/base/words.hpp"
#include "engine/gpu/gpu_device.hpp"

namespace touchable {

namespace {

constexpr const char* validation_layer = "VK_LAYER_KHRONOS_validation";

bool asked_by_environment() {
    const char* value = std::getenv("TOUCHABLE_VULKAN_VALIDATION");
    return value && std::strcmp(value, "1") == 0;
}

VKAPI_ATTR VkBool32 VKAPI_CALL take_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                            VkDebugUtilsMessageTypeFlagsEXT,
                                            const VkDebugUtilsMessengerCallbackDataEXT* data,
                                            void* messages) {
    const std::string text = data->pMessage ? data->pMessage : "";
    if (asked_by_environment()) std::cerr << "Vulkan: " << text << std::endl;
    static_cast<GpuMessages*>(messages)->add(text);
    return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messenger_info(GpuMessages* messages) {
    auto info = vulkan_struct<VkDebugUtilsMessengerCreateInfoEXT>(
        VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
    info.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    info.pfnUserCallback = take_message;
    info.pUserData = messages;
    return info;
}

bool layer_is_here() {
    return std::ranges::any_of(
        vulkan_list<VkLayerProperties>(vkEnumerateInstanceLayerProperties),
        [](const VkLayerProperties& layer) { return std::strcmp(layer.layerName, validation_layer) == 0; });
}

bool extension_is_here(const char* name) {
    return std::ranges::any_of(
        vulkan_list<VkExtensionProperties>(vkEnumerateInstanceExtensionProperties, nullptr),
        [name](const VkExtensionProperties& here) { return std::strcmp(here.extensionName, name) == 0; });
}

template <class Function>
Function function_of(VkInstance instance, const char* name) {
    return reinterpret_cast<Function>(vkGetInstanceProcAddr(instance, name));
}

std::string_view name_of(VkResult result) {
    switch (result) {
#define TOUCHABLE_RESULT(name) \
    case name:                 \
        return #name;
        TOUCHABLE_RESULT(VK_SUCCESS)
        TOUCHABLE_RESULT(VK_NOT_READY)
        TOUCHABLE_RESULT(VK_TIMEOUT)
        TOUCHABLE_RESULT(VK_INCOMPLETE)
        TOUCHABLE_RESULT(VK_ERROR_OUT_OF_HOST_MEMORY)
        TOUCHABLE_RESULT(VK_ERROR_OUT_OF_DEVICE_MEMORY)
        TOUCHABLE_RESULT(VK_ERROR_INITIALIZATION_FAILED)
        TOUCHABLE_RESULT(VK_ERROR_DEVICE_LOST)
        TOUCHABLE_RESULT(VK_ERROR_MEMORY_MAP_FAILED)
        TOUCHABLE_RESULT(VK_ERROR_LAYER_NOT_PRESENT)
        TOUCHABLE_RESULT(VK_ERROR_EXTENSION_NOT_PRESENT)
        TOUCHABLE_RESULT(VK_ERROR_FEATURE_NOT_PRESENT)
        TOUCHABLE_RESULT(VK_ERROR_INCOMPATIBLE_DRIVER)
        TOUCHABLE_RESULT(VK_ERROR_TOO_MANY_OBJECTS)
        TOUCHABLE_RESULT(VK_ERROR_FORMAT_NOT_SUPPORTED)
        TOUCHABLE_RESULT(VK_ERROR_FRAGMENTED_POOL)
        TOUCHABLE_RESULT(VK_ERROR_OUT_OF_POOL_MEMORY)
        TOUCHABLE_RESULT(VK_ERROR_INVALID_EXTERNAL_HANDLE)
        TOUCHABLE_RESULT(VK_ERROR_INVALID_SHADER_NV)
#undef TOUCHABLE_RESULT
        default:
            return "an error this program has no name for";
    }
}

Error failure(const char* call, VkResult result) {
    return gpu_error(std::string(call) + ": " + std::string(name_of(result)));
}

bool contains(std::string_view name, std::string_view part) {
    return small_letters(std::string(name)).find(small_letters(std::string(part))) != std::string::npos;
}

bool is_same(std::string_view name, std::string_view other) {
    return name.size() == other.size() && contains(name, other);
}

bool answers_to(const GpuFacts& gpu, std::string_view word) {
    return contains(gpu.name, word) || contains(nickname_of(gpu.name), word) ||
           is_same(name_of(gpu.kind), word) || (gpu.kind == GpuKind::software && is_same("cpu", word));
}

std::string described(std::span<const GpuFacts> gpus) {
    std::string all = "devices here: ";
    for (std::size_t i = 0; i < gpus.size(); ++i) {
        const GpuFacts& gpu = gpus[i];
        if (i > 0) all += "; ";
        all.append(std::to_string(i)).append(" ").append(gpu.name);
        all.append(" (").append(name_of(gpu.kind));
        if (const auto nickname = nickname_of(gpu.name); !nickname.empty()) all.append(", ").append(nickname);
        all.append(")");
        if (!gpu.usable()) all.append(" lacks ").append(listed(gpu.missing));
    }
    return all;
}

Error refusal(std::string why, std::span<const GpuFacts> gpus) {
    return gpu_error(std::move(why) + "; " + described(gpus));
}

Result<std::size_t> only_if_usable(std::span<const GpuFacts> gpus, std::size_t index) {
    const GpuFacts& gpu = gpus[index];
    if (gpu.usable()) return index;
    return refusal("GPU " + std::to_string(index) + " " + gpu.name + " cannot be used", gpus);
}

Result<std::size_t> best(std::span<const GpuFacts> gpus) {
    std::optional<std::size_t> chosen;
    for (std::size_t i = 0; i < gpus.size(); ++i)
        if (gpus[i].usable() && (!chosen || gpus[i].kind < gpus[*chosen].kind)) chosen = i;
    if (chosen) return *chosen;
    return refusal("no usable GPU", gpus);
}

Result<std::size_t> by_name(std::span<const GpuFacts> gpus, std::string_view part) {
    std::vector<std::size_t> named, usable;
    for (std::size_t i = 0; i < gpus.size(); ++i)
        if (answers_to(gpus[i], part)) {
            named.push_back(i);
            if (gpus[i].usable()) usable.push_back(i);
        }
    const std::string quoted = std::string("'").append(part).append("'");
    if (usable.size() == 1) return usable.front();
    if (usable.size() > 1) return refusal("several GPUs are called " + quoted + ", give an index", gpus);
    if (named.empty()) return refusal("no GPU is called " + quoted, gpus);
    return refusal("no GPU called " + quoted + " can be used", gpus);
}

}  // namespace

void GpuMessages::add(std::string message) {
    const std::lock_guard lock(mutex_);
    messages_.push_back(std::move(message));
}

std::vector<std::string> GpuMessages::all() const {
    const std::lock_guard lock(mutex_);
    return messages_;
}

Result<std::unique_ptr<VulkanInstance>> VulkanInstance::create(
    bool validation, const std::vector<std::string>& wanted_extensions) {
    std::unique_ptr<VulkanInstance> made(new VulkanInstance);
    made->validates_ = validation || asked_by_environment();
    if (made->validates_ && !layer_is_here())
        return gpu_error("Vulkan's validation is asked for and " + std::string(validation_layer) +
                         " is not installed (Debian: vulkan-validationlayers)");

    const VkValidationFeatureEnableEXT synchronisation =
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(made->messages_.get());
    auto checks = vulkan_struct<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
    checks.pNext = &messenger;  // also reports on the instance's creation and destruction
    checks.enabledValidationFeatureCount = 1;
    checks.pEnabledValidationFeatures = &synchronisation;

    auto program = vulkan_struct<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
    program.pApplicationName = "touchable";
    program.apiVersion = VK_API_VERSION_1_3;
    auto info = vulkan_struct<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
    info.pApplicationInfo = &program;
    std::vector<const char*> extensions;
    if (made->validates_) {
        info.pNext = &checks;
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &validation_layer;
        extensions = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    }
    // Without it the loader hides drivers on top of another API, such as MoltenVK.
    if (extension_is_here(VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME)) {
        info.flags = VK_INSTANCE_CREATE_ENUMERATE_PORTABILITY_BIT_KHR;
        extensions.push_back(VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME);
    }
    for (const std::string& extension : wanted_extensions) {
        if (!extension_is_here(extension.c_str()))
            return gpu_error("Vulkan here has not " + extension + ", which a window needs");
        extensions.push_back(extension.c_str());
    }
    info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    const VkResult result = vkCreateInstance(&info, nullptr, &made->instance_);
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER) return std::unique_ptr<VulkanInstance>();
    if (result != VK_SUCCESS) return failure("vkCreateInstance", result);

    if (made->validates_) {
        const auto create = function_of<PFN_vkCreateDebugUtilsMessengerEXT>(made->instance_,
                                                                            "vkCreateDebugUtilsMessengerEXT");
        const VkResult watched = create(made->instance_, &messenger, nullptr, &made->messenger_);
        if (watched != VK_SUCCESS) return failure("vkCreateDebugUtilsMessengerEXT", watched);
    }
    return made;
}

VulkanInstance::~VulkanInstance() {
    if (messenger_)
        function_of<PFN_vkDestroyDebugUtilsMessengerEXT>(instance_, "vkDestroyDebugUtilsMessengerEXT")(
            instance_, messenger_, nullptr);
    // A process's first instance stays: it keeps the driver loaded, which leaves its static memory behind
    // when unloaded (lavapipe and the validation layer do), and is slow to load again.
    static std::atomic<VkInstance> first = VK_NULL_HANDLE;
    VkInstance none = VK_NULL_HANDLE;
    if (instance_ && !first.compare_exchange_strong(none, instance_)) vkDestroyInstance(instance_, nullptr);
}

Result<std::vector<VkPhysicalDevice>> VulkanInstance::devices() const {
    std::vector<VkPhysicalDevice> devices;
    std::uint32_t count = 0;
    VkResult result = vkEnumeratePhysicalDevices(instance_, &count, nullptr);
    if (result == VK_SUCCESS) {
        devices.resize(count);
        result = vkEnumeratePhysicalDevices(instance_, &count, devices.data());
    }
    if (result == VK_ERROR_INITIALIZATION_FAILED)
        return std::vector<VkPhysicalDevice>();  // drivers, no device
    if (result != VK_SUCCESS) return failure("vkEnumeratePhysicalDevices", result);
    devices.resize(count);
    return devices;
}

VulkanDevice::~VulkanDevice() {
    if (device) {
        vkDeviceWaitIdle(device);  // on a lost device there is nothing left to wait for
        if (const auto fresh = take_new_programs()) (void)fresh->keep();
        if (programs) vkDestroyPipelineCache(device, programs, nullptr);
        vkDestroyDevice(device, nullptr);
    }
}

Error VulkanDevice::failed(std::string_view call, VkResult result) {
    if (result == VK_ERROR_DEVICE_LOST) lost = true;
    return gpu_error(std::string(call) + ": " + std::string(name_of(result)) + " on " + facts.name);
}

VkInstance VulkanDevice::instance_handle() const {
    return instance->handle();
}

Result<void> VulkanDevice::checked(std::string_view call, VkResult result) {
    if (result == VK_SUCCESS) return {};
    return failed(call, result);
}

void VulkanDevice::name_object(VkObjectType type, std::uint64_t handle, const std::string& name) const {
    if (!set_name) return;
    auto info =
        vulkan_struct<VkDebugUtilsObjectNameInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT);
    info.objectType = type;
    info.objectHandle = handle;
    info.pObjectName = name.c_str();
    set_name(device, &info);  // a failure costs only the name
}

void leave_for_good(std::shared_ptr<const void> what) {
    static std::mutex mutex;
    static auto* const left = new std::vector<std::shared_ptr<const void>>;  // never destroyed
    const std::lock_guard lock(mutex);
    left->push_back(std::move(what));
}

std::string_view name_of(GpuKind kind) {
    constexpr std::string_view names[] = {"discrete", "integrated", "virtual", "software", "other"};
    return names[static_cast<std::size_t>(kind)];
}

std::string_view nickname_of(std::string_view device_name) {
    return contains(device_name, "llvmpipe") ? "lavapipe" : "";
}

Result<std::size_t> choose_gpu(std::span<const GpuFacts> gpus, std::string_view request) {
    if (gpus.empty())
        return Error{ErrorKind::gpu,
                     "Vulkan finds no device here; install a driver (Debian's mesa-vulkan-drivers can do it "
                     "all on the CPU)"};
    if (request.empty())
        return refusal("the GPU asked for has no name, use auto, an index or a part of a name", gpus);
    if (request == "auto") return best(gpus);

    std::size_t index = 0;
    const auto [end, fault] = std::from_chars(request.data(), request.data() + request.size(), index);
    const bool is_index = end == request.data() + request.size();
    if (!is_index) return by_name(gpus, request);
    if (fault == std::errc{} && index < gpus.size()) return only_if_usable(gpus, index);
    return refusal("there is no GPU " + std::string(request), gpus);
}

}  // namespace touchable
