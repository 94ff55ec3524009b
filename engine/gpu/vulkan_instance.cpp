#include "engine/gpu/vulkan_instance.hpp"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <utility>

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
    VkDebugUtilsMessengerCreateInfoEXT info{};
    info.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
    info.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    info.pfnUserCallback = take_message;
    info.pUserData = messages;
    return info;
}

bool layer_is_here() {
    std::uint32_t count = 0;
    std::vector<VkLayerProperties> layers;
    if (vkEnumerateInstanceLayerProperties(&count, nullptr) == VK_SUCCESS) layers.resize(count);
    if (vkEnumerateInstanceLayerProperties(&count, layers.data()) != VK_SUCCESS) return false;
    return std::any_of(layers.begin(), layers.end(), [](const VkLayerProperties& layer) {
        return std::strcmp(layer.layerName, validation_layer) == 0;
    });
}

bool extension_is_here(const char* name) {
    std::uint32_t count = 0;
    std::vector<VkExtensionProperties> extensions;
    if (vkEnumerateInstanceExtensionProperties(nullptr, &count, nullptr) == VK_SUCCESS)
        extensions.resize(count);
    if (vkEnumerateInstanceExtensionProperties(nullptr, &count, extensions.data()) != VK_SUCCESS)
        return false;
    return std::any_of(extensions.begin(), extensions.end(), [name](const VkExtensionProperties& here) {
        return std::strcmp(here.extensionName, name) == 0;
    });
}

template <class Function>
Function function_of(VkInstance instance, const char* name) {
    return reinterpret_cast<Function>(vkGetInstanceProcAddr(instance, name));
}

Error failure(const char* call, VkResult result) {
    return {ErrorKind::gpu, std::string(call) + ": " + std::string(name_of(result))};
}

}  // namespace

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
        return Error{ErrorKind::gpu, "Vulkan's validation is asked for and " + std::string(validation_layer) +
                                         " is not installed (Debian: vulkan-validationlayers)"};

    const VkValidationFeatureEnableEXT synchronisation =
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(made->messages_.get());
    VkValidationFeaturesEXT checks{};
    checks.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
    checks.pNext = &messenger;  // also speaks of the instance's own beginning and end
    checks.enabledValidationFeatureCount = 1;
    checks.pEnabledValidationFeatures = &synchronisation;

    VkApplicationInfo program{};
    program.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    program.pApplicationName = "touchable";
    program.apiVersion = VK_API_VERSION_1_3;
    VkInstanceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    info.pApplicationInfo = &program;
    std::vector<const char*> extensions;
    if (made->validates_) {
        info.pNext = &checks;
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &validation_layer;
        extensions = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    }
    // Without it the loader hides drivers on top of something else, such as MoltenVK.
    if (extension_is_here(VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME)) {
        info.flags = VK_INSTANCE_CREATE_ENUMERATE_PORTABILITY_BIT_KHR;
        extensions.push_back(VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME);
    }
    for (const std::string& extension : wanted_extensions) {
        if (!extension_is_here(extension.c_str()))
            return Error{ErrorKind::gpu, "Vulkan here has not " + extension + ", which a window needs"};
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
    // The first of a process stays: it keeps the driver loaded, which when unloaded leaves its static memory
    // behind (lavapipe and the validation layer do), and which is slow to load again.
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

}  // namespace touchable
