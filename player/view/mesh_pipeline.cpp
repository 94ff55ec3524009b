#include "player/view/mesh_pipeline.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "engine/frame/surface_frame.hpp"
#include "player/view/view_rows.hpp"
#include "shaders/tile_lists.h"
#include "shaders/view_mesh.frag.spv.h"
#include "shaders/view_mesh.h"
#include "shaders/view_mesh.vert.spv.h"

namespace touchable {
namespace {

static_assert(MESH_TILE == TileGrid::cells);
static_assert(sizeof(MeshPush) == 80);
static_assert(TILE_LISTS_CORNERS == MESH_TILE_CELLS * 6);

Result<VkShaderModule> make_module(VulkanDevice& gpu, std::span<const std::uint32_t> words) {
    VkShaderModuleCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    info.codeSize = words.size_bytes();
    info.pCode = words.data();
    VkShaderModule made = VK_NULL_HANDLE;
    const VkResult result = vkCreateShaderModule(gpu.device, &info, nullptr, &made);
    if (result != VK_SUCCESS) return gpu.failed("vkCreateShaderModule", result);
    return made;
}

/// Both sides of triangles, the nearest (greatest z) wins; viewport and scissor are set while recording.
Result<VkPipeline> make_pipeline(VulkanDevice& gpu, VkPipelineLayout layout, VkShaderModule vertex,
                                 VkShaderModule fragment, bool mixed) {
    const VkBool32 is_mixed = mixed;
    const VkSpecializationMapEntry entry{0, 0, sizeof is_mixed};
    const VkSpecializationInfo special{1, &entry, sizeof is_mixed, &is_mixed};
    std::array<VkPipelineShaderStageCreateInfo, 2> stages{};
    for (auto& stage : stages) {
        stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
        stage.pName = "main";
    }
    stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
    stages[0].module = vertex;
    stages[0].pSpecializationInfo = &special;
    stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
    stages[1].module = fragment;

    VkPipelineVertexInputStateCreateInfo input{};
    input.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO;
    VkPipelineInputAssemblyStateCreateInfo assembly{};
    assembly.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO;
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPipelineViewportStateCreateInfo viewport{};
    viewport.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO;
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{};
    raster.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO;
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.cullMode = VK_CULL_MODE_NONE;
    raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{};
    samples.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO;
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineDepthStencilStateCreateInfo depth{};
    depth.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO;
    depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
    depth.depthCompareOp = VK_COMPARE_OP_GREATER;
    VkPipelineColorBlendAttachmentState blend{};
    blend.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT |
                           VK_COLOR_COMPONENT_A_BIT;
    VkPipelineColorBlendStateCreateInfo blending{};
    blending.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO;
    blending.attachmentCount = 1;
    blending.pAttachments = &blend;
    constexpr VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic{};
    dynamic.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO;
    dynamic.dynamicStateCount = 2;
    dynamic.pDynamicStates = dynamic_states;
    const VkFormat colour_format = MeshPipeline::colour_format;
    VkPipelineRenderingCreateInfo rendering{};
    rendering.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO;
    rendering.colorAttachmentCount = 1;
    rendering.pColorAttachmentFormats = &colour_format;
    rendering.depthAttachmentFormat = MeshPipeline::z_format;

    VkGraphicsPipelineCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO;
    info.pNext = &rendering;
    info.stageCount = 2;
    info.pStages = stages.data();
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blending;
    info.pDynamicState = &dynamic;
    info.layout = layout;
    VkPipeline made = VK_NULL_HANDLE;
    const VkResult result = vkCreateGraphicsPipelines(gpu.device, VK_NULL_HANDLE, 1, &info, nullptr, &made);
    if (result != VK_SUCCESS) return gpu.failed("vkCreateGraphicsPipelines", result);
    return made;
}

VkImageMemoryBarrier2 transition(const GpuImage& image, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier2 barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2;
    barrier.srcStageMask = barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image.handle();
    barrier.subresourceRange = {image.aspect(), 0, 1, 0, 1};
    return barrier;
}

void record_transitions(VkCommandBuffer commands, std::array<VkImageMemoryBarrier2, 2> barriers) {
    VkDependencyInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO;
    info.imageMemoryBarrierCount = 2;
    info.pImageMemoryBarriers = barriers.data();
    vkCmdPipelineBarrier2(commands, &info);
}

VkRenderingAttachmentInfo cleared(const GpuImage& image, VkImageLayout layout) {
    VkRenderingAttachmentInfo info{};  // clears to zeroes: no colour, and for z as far as can be
    info.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO;
    info.imageView = image.view();
    info.imageLayout = layout;
    info.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    return info;
}

}  // namespace

MeshPipeline::State::~State() {
    for (VkPipeline pipeline : {whole, mixed})
        if (pipeline) vkDestroyPipeline(vulkan->device, pipeline, nullptr);
    if (layout) vkDestroyPipelineLayout(vulkan->device, layout, nullptr);
    if (set_layout) vkDestroyDescriptorSetLayout(vulkan->device, set_layout, nullptr);
}

Result<void> MeshPipeline::make_layout(State& state) {
    VulkanDevice& gpu = *state.vulkan;
    std::array<VkDescriptorSetLayoutBinding, 3> bindings{};
    for (std::uint32_t k = 0; k < bindings.size(); ++k)
        bindings[k] = {k, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_VERTEX_BIT, nullptr};
    VkDescriptorSetLayoutCreateInfo set{};
    set.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    set.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR;
    set.bindingCount = static_cast<std::uint32_t>(bindings.size());
    set.pBindings = bindings.data();
    VkResult result = vkCreateDescriptorSetLayout(gpu.device, &set, nullptr, &state.set_layout);
    if (result != VK_SUCCESS) return gpu.failed("vkCreateDescriptorSetLayout", result);
    const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(MeshPush)};
    VkPipelineLayoutCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    info.setLayoutCount = 1;
    info.pSetLayouts = &state.set_layout;
    info.pushConstantRangeCount = 1;
    info.pPushConstantRanges = &push;
    result = vkCreatePipelineLayout(gpu.device, &info, nullptr, &state.layout);
    if (result != VK_SUCCESS) return gpu.failed("vkCreatePipelineLayout", result);
    return {};
}

Result<void> MeshPipeline::make_pattern(const GpuDevice& device, State& state) {
    std::vector<std::uint16_t> indices;
    for (std::uint32_t y = 0; y < MESH_TILE; ++y)
        for (std::uint32_t x = 0; x < MESH_TILE; ++x) {
            const std::uint32_t a = y * MESH_TILE_SIDE + x, b = a + 1, c = b + MESH_TILE_SIDE, d = c - 1;
            for (const std::uint32_t vertex : {a, b, c, a, c, d})
                indices.push_back(static_cast<std::uint16_t>(vertex));
        }
    auto buffer = GpuBuffer::create(device, "tile pattern", indices.size() * 2, GpuMemory::upload);
    if (!buffer.ok()) return buffer.error();
    std::copy(indices.begin(), indices.end(), buffer->mapped<std::uint16_t>().begin());
    state.pattern = std::move(*buffer);
    return {};
}

Result<MeshPipeline> MeshPipeline::create(const GpuDevice& device) {
    if (!device.facts().draws_triangles)
        return Error{
            ErrorKind::gpu,
            device.facts().name + " draws no triangles, which --painter mesh needs; raster and cpu do not"};
    auto state = std::make_shared<State>();
    state->vulkan = device.vulkan();
    VulkanDevice& gpu = *state->vulkan;
    if (auto made = make_layout(*state); !made.ok()) return made.error();
    if (auto made = make_pattern(device, *state); !made.ok()) return made.error();
    const auto vertex = make_module(gpu, view_mesh_vert_spv);
    if (!vertex.ok()) return vertex.error();
    const auto fragment = make_module(gpu, view_mesh_frag_spv);
    Result<void> made;
    if (fragment.ok()) {
        for (const bool mixed : {false, true}) {
            const auto pipeline = make_pipeline(gpu, state->layout, *vertex, *fragment, mixed);
            if (pipeline.ok())
                (mixed ? state->mixed : state->whole) = *pipeline;
            else
                made = pipeline.error();
        }
        vkDestroyShaderModule(gpu.device, *fragment, nullptr);
    } else {
        made = fragment.error();
    }
    vkDestroyShaderModule(gpu.device, *vertex, nullptr);
    if (!made.ok()) return made.error();
    MeshPipeline pipeline;
    pipeline.state_ = std::move(state);
    return pipeline;
}

void MeshPipeline::draw(VkCommandBuffer commands, const GpuLattice& lattice, const ViewCamera& camera) const {
    const VkViewport viewport{0, 0, static_cast<float>(camera.width), static_cast<float>(camera.height),
                              0, 1};
    const VkRect2D all{{0, 0},
                       {static_cast<std::uint32_t>(camera.width), static_cast<std::uint32_t>(camera.height)}};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &all);

    const GpuBuffer* buffers[] = {&lattice.q, &lattice.colours, &lattice.tiles};
    std::array<VkDescriptorBufferInfo, 3> ranges{};
    std::array<VkWriteDescriptorSet, 3> writes{};
    for (std::uint32_t k = 0; k < ranges.size(); ++k) {
        ranges[k] = {buffers[k]->handle(), 0, VK_WHOLE_SIZE};
        writes[k].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        writes[k].dstBinding = k;
        writes[k].descriptorCount = 1;
        writes[k].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        writes[k].pBufferInfo = &ranges[k];
    }
    state_->vulkan->push_descriptors(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, state_->layout, 0,
                                     static_cast<std::uint32_t>(writes.size()), writes.data());
    const MeshPush push{rows_of(camera), static_cast<std::uint32_t>(lattice.width),
                        static_cast<std::uint32_t>(lattice.height), static_cast<std::uint32_t>(lattice.pitch),
                        static_cast<std::uint32_t>(TileGrid::of(lattice.width, lattice.height).tiles_x)};
    vkCmdPushConstants(commands, state_->layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof push, &push);

    vkCmdBindIndexBuffer(commands, state_->pattern.handle(), 0, VK_INDEX_TYPE_UINT16);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, state_->whole);
    vkCmdDrawIndexedIndirect(commands, lattice.tiles.handle(), offsetof(TileListsHeader, whole_indices), 1,
                             0);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, state_->mixed);
    vkCmdDrawIndirect(commands, lattice.tiles.handle(), offsetof(TileListsHeader, mixed_vertices), 1, 0);
}

void MeshPipeline::record(GpuCommands& gpu_commands, const GpuLattice& lattice, const ViewCamera& camera,
                          const GpuImage& colour, const GpuImage& z) const {
    const VkCommandBuffer commands = gpu_commands.handle();
    constexpr VkImageLayout fresh = VK_IMAGE_LAYOUT_UNDEFINED;
    constexpr VkImageLayout attached = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
    constexpr VkImageLayout source = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    record_transitions(commands, {transition(colour, fresh, attached), transition(z, fresh, attached)});
    const VkRenderingAttachmentInfo to_colour = cleared(colour, attached), to_z = cleared(z, attached);
    VkRenderingInfo rendering{};
    rendering.sType = VK_STRUCTURE_TYPE_RENDERING_INFO;
    rendering.renderArea = {{0, 0}, colour.extent()};
    rendering.layerCount = 1;
    rendering.colorAttachmentCount = 1;
    rendering.pColorAttachments = &to_colour;
    rendering.pDepthAttachment = &to_z;
    vkCmdBeginRendering(commands, &rendering);
    draw(commands, lattice, camera);
    vkCmdEndRendering(commands);
    record_transitions(commands, {transition(colour, attached, source), transition(z, attached, source)});
    for (const auto& used : {lattice.q.keep_alive(), lattice.colours.keep_alive(), lattice.tiles.keep_alive(),
                             colour.keep_alive(), z.keep_alive(), std::shared_ptr<const void>(state_)})
        gpu_commands.keep(used);
}

}  // namespace touchable
