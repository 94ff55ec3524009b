// SPDX-License-Identifier: Apache-2.0
#include "player/draw/graphics_program.hpp"

#include <algorithm>

#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

// Images, upload buffers and graphics pipelines: Vulkan objects, made once and kept by handles.

namespace touchable {
namespace {

bool is_depth(VkFormat format) {
    return format == VK_FORMAT_D32_SFLOAT;
}

bool has_light(VkFormat format) {
    return format == VK_FORMAT_R8G8B8A8_UNORM;
}

VkImageCreateInfo image_info(VkExtent2D extent, VkFormat format) {
    auto info = vulkan_struct<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
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
    auto info = vulkan_struct<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
    info.image = image;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    info.format = format;
    info.subresourceRange = {aspect, 0, 1, 0, 1};
    VkImageView made = VK_NULL_HANDLE;
    TRY(gpu.checked("vkCreateImageView", vkCreateImageView(gpu.device, &info, nullptr, &made)));
    return made;
}

/// Takes after which an unused buffer is freed.
constexpr std::uint64_t idle_takes = 200;

/// The temporary handle's release synchronises with other threads' releases, so their accesses are complete.
bool is_unused(const GpuBuffer& buffer) {
    return buffer.keep_alive().use_count() <= 2;  // the pool's handle, and the temporary one
}

constexpr VkShaderStageFlags both_stages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

VkPipelineDepthStencilStateCreateInfo depth_state(DrawDepth depth) {
    auto state = vulkan_struct<VkPipelineDepthStencilStateCreateInfo>(
        VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO);
    state.depthTestEnable = depth != DrawDepth::ignored;
    state.depthWriteEnable = depth == DrawDepth::replaced || depth == DrawDepth::nearest;
    state.depthCompareOp = depth == DrawDepth::replaced  ? VK_COMPARE_OP_ALWAYS
                           : depth == DrawDepth::nearest ? VK_COMPARE_OP_GREATER
                           : depth == DrawDepth::behind  ? VK_COMPARE_OP_LESS
                                                         : VK_COMPARE_OP_GREATER_OR_EQUAL;
    return state;
}

VkPipelineColorBlendAttachmentState blend_state(DrawBlend blend) {
    VkPipelineColorBlendAttachmentState state{};
    state.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT |
                           VK_COLOR_COMPONENT_A_BIT;
    if (blend == DrawBlend::replaced) return state;
    const bool over = blend == DrawBlend::over;
    state.blendEnable = VK_TRUE;
    state.srcColorBlendFactor = over ? VK_BLEND_FACTOR_SRC_ALPHA : VK_BLEND_FACTOR_ZERO;
    state.dstColorBlendFactor = over ? VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA : VK_BLEND_FACTOR_SRC_COLOR;
    state.srcAlphaBlendFactor = VK_BLEND_FACTOR_ZERO;  // keeps the picture opaque
    state.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    return state;
}

Result<void> make_graphics_pipeline(VulkanDevice::Pipeline& made, const GraphicsLook& look) {
    VulkanDevice& gpu = *made.vulkan;
    std::array<VulkanDevice::Pipeline::Shader, 2> shaders;
    TRY(shaders[0].load(gpu, VK_SHADER_STAGE_VERTEX_BIT, look.vertex, look.constants));
    TRY(shaders[1].load(gpu, VK_SHADER_STAGE_FRAGMENT_BIT, look.fragment, look.constants));
    const VkPipelineShaderStageCreateInfo stages[] = {shaders[0].info, shaders[1].info};

    auto input = vulkan_struct<VkPipelineVertexInputStateCreateInfo>(
        VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
    auto assembly = vulkan_struct<VkPipelineInputAssemblyStateCreateInfo>(
        VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO);
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    auto viewport = vulkan_struct<VkPipelineViewportStateCreateInfo>(
        VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO);
    viewport.viewportCount = viewport.scissorCount = 1;
    auto raster = vulkan_struct<VkPipelineRasterizationStateCreateInfo>(
        VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO);
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.cullMode = VK_CULL_MODE_NONE;
    raster.lineWidth = 1;
    auto samples = vulkan_struct<VkPipelineMultisampleStateCreateInfo>(
        VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO);
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    const VkPipelineDepthStencilStateCreateInfo depth = depth_state(look.depth);
    const VkPipelineColorBlendAttachmentState blend = blend_state(look.blend);
    auto blending = vulkan_struct<VkPipelineColorBlendStateCreateInfo>(
        VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
    blending.attachmentCount = 1;
    blending.pAttachments = &blend;
    constexpr VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    auto dynamic =
        vulkan_struct<VkPipelineDynamicStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO);
    dynamic.dynamicStateCount = 2;
    dynamic.pDynamicStates = dynamic_states;
    auto rendering =
        vulkan_struct<VkPipelineRenderingCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO);
    rendering.colorAttachmentCount = 1;
    rendering.pColorAttachmentFormats = &look.colour_format;
    if (look.depth != DrawDepth::ignored) rendering.depthAttachmentFormat = GraphicsLook::z_format;

    auto info = vulkan_struct<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO);
    info.pNext = &rendering;
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blending;
    info.pDynamicState = &dynamic;
    info.layout = made.pipeline_layout;
    return gpu.checked(
        "vkCreateGraphicsPipelines",
        vkCreateGraphicsPipelines(gpu.device, gpu.programs, 1, &info, nullptr, &made.pipeline));
}

VkRenderingAttachmentInfo attachment(VkImageView view, VkImageLayout layout, VkAttachmentLoadOp load) {
    // Clear values are zero: black, and z at infinity.
    auto info = vulkan_struct<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
    info.imageView = view;
    info.imageLayout = layout;
    info.loadOp = load;
    info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    return info;
}

void record_change(GpuCommands& commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                   VkImageLayout to) {
    auto barrier = vulkan_struct<VkImageMemoryBarrier2>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2);
    barrier.srcStageMask = barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = {aspect, 0, 1, 0, 1};
    auto info = vulkan_struct<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
    info.imageMemoryBarrierCount = 1;
    info.pImageMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(commands.handle(), &info);
}

/// `pitch`: pixels of a row in the buffer; 0: packed.
VkBufferImageCopy whole_image(const GpuImage& image, int pitch) {
    VkBufferImageCopy region{};
    region.bufferRowLength = static_cast<std::uint32_t>(pitch);
    region.imageSubresource = {image.aspect(), 0, 0, 1};
    region.imageExtent = {image.extent().width, image.extent().height, 1};
    return region;
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
    const VkResult result = vkGetPhysicalDeviceImageFormatProperties(
        gpu.physical, format, info.imageType, info.tiling, info.usage, info.flags, &most);
    if (result != VK_SUCCESS || state->extent.width > most.maxExtent.width ||
        state->extent.height > most.maxExtent.height)
        return gpu_error(gpu.facts.name + " has no picture '" + name + "' of " + size_text(width, height));

    TRY(gpu.checked("vkCreateImage", vkCreateImage(gpu.device, &info, nullptr, &state->image)));
    gpu.name_object(VK_OBJECT_TYPE_IMAGE, reinterpret_cast<std::uint64_t>(state->image), name);
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(gpu.device, state->image, &needs);
    const auto type = choose_memory_type(gpu.memory, needs.memoryTypeBits, GpuMemory::device);
    if (!type) return gpu_error(gpu.facts.name + " has no memory for picture '" + name + "'");
    auto memory = vulkan_struct<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
    memory.allocationSize = needs.size;
    memory.memoryTypeIndex = *type;
    TRY(gpu.checked("vkAllocateMemory", vkAllocateMemory(gpu.device, &memory, nullptr, &state->memory)));
    TRY(gpu.checked("vkBindImageMemory", vkBindImageMemory(gpu.device, state->image, state->memory, 0)));

    TRY_ASSIGN(state->view, make_view(gpu, state->image, format, state->aspect));
    if (has_light(format))
        TRY(assign(state->light_view, make_view(gpu, state->image, VK_FORMAT_R8G8B8A8_SRGB, state->aspect)));
    GpuImage image;
    image.state_ = std::move(state);
    return image;
}

Result<GpuBuffer> UploadPool::lease(const std::string& name, std::size_t bytes) {
    ++takes_;
    const std::size_t most = std::max<std::size_t>(4 * bytes, 4096);
    for (Slot& slot : slots_)
        if (slot.buffer.bytes() >= bytes && slot.buffer.bytes() <= most && is_unused(slot.buffer)) {
            slot.taken = takes_;
            return slot.buffer;
        }
    std::erase_if(slots_, [this](const Slot& slot) {
        return takes_ - slot.taken > idle_takes && is_unused(slot.buffer);
    });
    TRY_ASSIGN(auto made,
               GpuBuffer::create(*device_, name, bytes,
                                 device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::upload));
    slots_.push_back({made, takes_});
    return made;
}

Result<GraphicsProgram> GraphicsProgram::create(const GpuDevice& device, const std::string& name,
                                                const GraphicsLook& look) {
    auto state = std::make_shared<State>();
    state->vulkan = device.vulkan();
    state->bindings = look.bindings;
    TRY(state->make_layouts(look.bindings, look.push_bytes, both_stages));
    TRY(make_graphics_pipeline(*state, look));
    state->vulkan->name_object(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<std::uint64_t>(state->pipeline),
                               name);
    GraphicsProgram program;
    program.state_ = std::move(state);
    return program;
}

void GraphicsProgram::bind_bytes(GpuCommands& commands, std::span<const std::byte> push,
                                 std::initializer_list<DrawBinding> bindings) const {
    constexpr std::size_t most = 4;
    std::array<VkDescriptorBufferInfo, most> buffers{};
    std::array<VkDescriptorImageInfo, most> images{};
    std::array<VkWriteDescriptorSet, most> writes{};
    std::uint32_t count = 0;
    for (const DrawBinding& binding : bindings) {
        VkWriteDescriptorSet& write = writes[count];
        write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        write.dstBinding = count;
        write.descriptorCount = 1;
        write.descriptorType = state_->bindings[count];
        if (binding.image) {
            images[count] = {VK_NULL_HANDLE, binding.image->view(), VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL};
            write.pImageInfo = &images[count];
            commands.keep(binding.image->keep_alive());
        } else {
            buffers[count] = {binding.buffer->handle(), binding.offset, binding.bytes};
            write.pBufferInfo = &buffers[count];
            commands.keep(binding.buffer->keep_alive());
        }
        ++count;
    }
    vkCmdBindPipeline(commands.handle(), VK_PIPELINE_BIND_POINT_GRAPHICS, state_->pipeline);
    state_->vulkan->push_descriptors(commands.handle(), VK_PIPELINE_BIND_POINT_GRAPHICS,
                                     state_->pipeline_layout, 0, count, writes.data());
    if (!push.empty())
        vkCmdPushConstants(commands.handle(), state_->pipeline_layout, both_stages, 0,
                           static_cast<std::uint32_t>(push.size()), push.data());
    commands.keep(state_);
}

void begin_drawing(GpuCommands& commands, const DrawTarget& target) {
    const VkExtent2D extent = target.colour.extent();
    const VkRenderingAttachmentInfo to_colour =
        attachment(target.as_light ? target.colour.light_view() : target.colour.view(),
                   VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, target.load);
    auto rendering = vulkan_struct<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
    rendering.renderArea = {{0, 0}, extent};
    rendering.layerCount = 1;
    rendering.colorAttachmentCount = 1;
    rendering.pColorAttachments = &to_colour;
    VkRenderingAttachmentInfo to_z{};
    if (target.z) {
        to_z = attachment(target.z->view(), VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, target.load);
        rendering.pDepthAttachment = &to_z;
        commands.keep(target.z->keep_alive());
    }
    commands.keep(target.colour.keep_alive());
    vkCmdBeginRendering(commands.handle(), &rendering);
    scale_z(commands, extent, 1);
    const VkRect2D all{{0, 0}, extent};
    vkCmdSetScissor(commands.handle(), 0, 1, &all);
}

void scale_z(GpuCommands& commands, VkExtent2D extent, float by) {
    const VkViewport viewport{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height),
                              0, by};
    vkCmdSetViewport(commands.handle(), 0, 1, &viewport);
}

void end_drawing(GpuCommands& commands) {
    vkCmdEndRendering(commands.handle());
}

void record_transition(GpuCommands& commands, const GpuImage& image, VkImageLayout from, VkImageLayout to) {
    record_change(commands, image.handle(), image.aspect(), from, to);
    commands.keep(image.keep_alive());
}

void record_transition(GpuCommands& commands, VkImage image, VkImageLayout from, VkImageLayout to) {
    record_change(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, from, to);
}

void copy_from_image(GpuCommands& commands, const GpuImage& image, const GpuBuffer& buffer) {
    const VkBufferImageCopy region = whole_image(image, 0);
    vkCmdCopyImageToBuffer(commands.handle(), image.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           buffer.handle(), 1, &region);
    commands.keep(image.keep_alive());
    commands.keep(buffer.keep_alive());
}

void copy_to_image(GpuCommands& commands, const GpuBuffer& pixels, int pitch, const GpuImage& image,
                   VkImageLayout then) {
    record_transition(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    const VkBufferImageCopy region = whole_image(image, pitch);
    vkCmdCopyBufferToImage(commands.handle(), pixels.handle(), image.handle(),
                           VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    commands.keep(pixels.keep_alive());
    record_transition(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, then);
}

void stretch_image(GpuCommands& commands, const GpuImage& from, VkImage to, VkExtent2D extent) {
    const auto corner = [](VkExtent2D of) {
        return VkOffset3D{static_cast<std::int32_t>(of.width), static_cast<std::int32_t>(of.height), 1};
    };
    VkImageBlit region{};
    region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.srcOffsets[1] = corner(from.extent());
    region.dstOffsets[1] = corner(extent);
    const bool same_size = from.extent().width == extent.width && from.extent().height == extent.height;
    vkCmdBlitImage(commands.handle(), from.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region,
                   same_size ? VK_FILTER_NEAREST : VK_FILTER_LINEAR);
}

}  // namespace touchable
