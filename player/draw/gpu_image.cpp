#include "player/draw/gpu_image.hpp"

#include "engine/base/try.hpp"
#include "engine/gpu/memory_type.hpp"

namespace touchable {
namespace {

bool is_depth(VkFormat format) {
    return format == VK_FORMAT_D32_SFLOAT;
}

bool has_light(VkFormat format) {
    return format == VK_FORMAT_R8G8B8A8_UNORM;
}

VkImageCreateInfo image_info(VkExtent2D extent, VkFormat format) {
    VkImageCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {extent.width, extent.height, 1};
    info.mipLevels = 1;
    info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                 VK_IMAGE_USAGE_SAMPLED_BIT |
                 (is_depth(format) ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT
                                   : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
    if (has_light(format)) info.flags = VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT;
    return info;
}

Result<VkImageView> make_view(VulkanDevice& gpu, VkImage image, VkFormat format, VkImageAspectFlags aspect) {
    VkImageViewCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    info.image = image;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    info.format = format;
    info.subresourceRange = {aspect, 0, 1, 0, 1};
    VkImageView made = VK_NULL_HANDLE;
    const VkResult result = vkCreateImageView(gpu.device, &info, nullptr, &made);
    if (result != VK_SUCCESS) return gpu.failed("vkCreateImageView", result);
    return made;
}

}  // namespace

GpuImage::State::~State() {
    for (VkImageView each : {view, light_view})
        if (each) vkDestroyImageView(vulkan->device, each, nullptr);
    if (image) vkDestroyImage(vulkan->device, image, nullptr);
    if (memory) vkFreeMemory(vulkan->device, memory, nullptr);
}

Result<GpuImage> GpuImage::create(const GpuDevice& device, const std::string& name, int width, int height,
                                  VkFormat format) {
    auto state = std::make_shared<State>();
    state->vulkan = device.vulkan();
    state->extent = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
    state->aspect = is_depth(format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    VulkanDevice& gpu = *state->vulkan;
    const VkImageCreateInfo info = image_info(state->extent, format);
    VkImageFormatProperties most{};
    VkResult result = vkGetPhysicalDeviceImageFormatProperties(gpu.physical, format, info.imageType,
                                                               info.tiling, info.usage, info.flags, &most);
    if (result != VK_SUCCESS || state->extent.width > most.maxExtent.width ||
        state->extent.height > most.maxExtent.height)
        return Error{ErrorKind::gpu, gpu.facts.name + " has no picture '" + name + "' of " +
                                         std::to_string(width) + "x" + std::to_string(height)};

    result = vkCreateImage(gpu.device, &info, nullptr, &state->image);
    if (result != VK_SUCCESS) return gpu.failed("vkCreateImage", result);
    gpu.name_object(VK_OBJECT_TYPE_IMAGE, reinterpret_cast<std::uint64_t>(state->image), name);
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(gpu.device, state->image, &needs);
    const auto type = choose_memory_type(gpu.memory, needs.memoryTypeBits, GpuMemory::device);
    if (!type) return Error{ErrorKind::gpu, gpu.facts.name + " has no memory for picture '" + name + "'"};
    VkMemoryAllocateInfo memory{};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    memory.allocationSize = needs.size;
    memory.memoryTypeIndex = *type;
    result = vkAllocateMemory(gpu.device, &memory, nullptr, &state->memory);
    if (result != VK_SUCCESS) return gpu.failed("vkAllocateMemory", result);
    result = vkBindImageMemory(gpu.device, state->image, state->memory, 0);
    if (result != VK_SUCCESS) return gpu.failed("vkBindImageMemory", result);

    TRY_ASSIGN(const auto view, make_view(gpu, state->image, format, state->aspect));
    state->view = view;
    if (has_light(format)) {
        TRY_ASSIGN(const auto light, make_view(gpu, state->image, VK_FORMAT_R8G8B8A8_SRGB, state->aspect));
        state->light_view = light;
    }
    GpuImage image;
    image.state_ = std::move(state);
    return image;
}

}  // namespace touchable
