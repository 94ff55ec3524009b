#include "engine/gpu/vulkan_device.hpp"

#include <utility>
#include <vector>

namespace touchable {

VulkanDevice::~VulkanDevice() {
    if (device) {
        vkDeviceWaitIdle(device);  // on a lost device there is nothing left to wait for
        vkDestroyDevice(device, nullptr);
    }
}

Error VulkanDevice::failed(std::string_view call, VkResult result) {
    if (result == VK_ERROR_DEVICE_LOST) lost = true;
    return {ErrorKind::gpu, std::string(call) + ": " + std::string(name_of(result)) + " on " + facts.name};
}

void VulkanDevice::name_object(VkObjectType type, std::uint64_t handle, const std::string& name) const {
    if (!set_name) return;
    VkDebugUtilsObjectNameInfoEXT info{};
    info.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT;
    info.objectType = type;
    info.objectHandle = handle;
    info.pObjectName = name.c_str();
    set_name(device, &info);  // a name that could not be given costs nothing but the name
}

void leave_for_good(std::shared_ptr<const void> what) {
    static std::mutex mutex;
    static auto* const left = new std::vector<std::shared_ptr<const void>>;  // never destroyed
    const std::lock_guard lock(mutex);
    left->push_back(std::move(what));
}

}  // namespace touchable
