#include "player/draw/dent_drawing.hpp"

#include <algorithm>
#include <glm/matrix.hpp>

#include "engine/base/try.hpp"
#include "shaders/dents.h"
#include "shaders/view_dent.frag.spv.h"
#include "shaders/view_dent.vert.spv.h"

namespace touchable {
namespace {

static_assert(sizeof(DentHeader) == 144 && sizeof(DentRecord) == 64);

DentRecord record_of(const SurfaceDent& dent, const ViewCamera& camera) {
    return {glm::vec4(dent.centre, 1 / dent.reach), glm::vec4(dent.normal, 0), glm::vec4(dent.moved, 0),
            clip_bounds(bounds_of_ball(camera, dent.centre, dent.reach), camera)};
}

}  // namespace

Result<DentDrawing> DentDrawing::create(const std::shared_ptr<GpuDevice>& device) {
    DentDrawing made(device);
    GraphicsLook look;
    look.vertex = view_dent_vert_spv;
    look.fragment = view_dent_frag_spv;
    look.bindings = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
                     VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE};
    look.depth = DrawDepth::ignored;
    TRY_ASSIGN(auto program, GraphicsProgram::create(*device, "dents", look));
    made.program_ = std::move(program);
    return made;
}

Result<GpuBuffer> DentDrawing::upload(const ViewCamera& camera) {
    auto buffer = uploads_.take("dents", sizeof(DentHeader) + dents_.size() * sizeof(DentRecord));
    if (!buffer.ok()) return buffer;
    const glm::dmat4 from_pixel = clip_from_pixel(camera);
    std::byte* const to = buffer->mapped<std::byte>().data();
    *reinterpret_cast<DentHeader*>(to) = {glm::mat4(glm::inverse(camera.clip_from_world) * from_pixel),
                                          glm::mat4(glm::inverse(from_pixel) * camera.clip_from_world),
                                          static_cast<std::uint32_t>(dents_.size()),
                                          {}};
    auto* record = reinterpret_cast<DentRecord*>(to + sizeof(DentHeader));
    for (const SurfaceDent& dent : dents_) *record++ = record_of(dent, camera);
    return buffer;
}

/// Of each dent what its pixels may show: they are no farther from what they show than it is dented.
Result<void> DentDrawing::copy_flat(GpuCommands& commands, const ViewCamera& camera, const GpuImage& colour) {
    if (!flat_ || flat_.extent().width != colour.extent().width ||
        flat_.extent().height != colour.extent().height) {
        TRY_ASSIGN(auto made, GpuImage::create(*device_, "picture without dents", camera.width, camera.height,
                                               VK_FORMAT_R8G8B8A8_UNORM));
        flat_ = std::move(made);
    }
    std::vector<VkImageCopy> regions;
    for (const SurfaceDent& dent : dents_) {
        const double room = dent.reach + most_dented / dent_reach * dent.reach;
        const auto bounds = bounds_of_ball(camera, dent.centre, room);
        if (!bounds) continue;
        const auto [x0, y0, x1, y1] = *bounds;
        if (x1 <= x0 || y1 <= y0) continue;
        VkImageCopy region{};
        region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        region.srcOffset = region.dstOffset = {x0, y0, 0};
        region.extent = {static_cast<std::uint32_t>(x1 - x0), static_cast<std::uint32_t>(y1 - y0), 1};
        regions.push_back(region);
    }
    constexpr VkImageLayout drawn = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    record_transition(commands, colour, drawn, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    record_transition(commands, flat_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    if (!regions.empty())
        vkCmdCopyImage(commands.handle(), colour.handle(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                       flat_.handle(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                       static_cast<std::uint32_t>(regions.size()), regions.data());
    record_transition(commands, colour, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, drawn);
    record_transition(commands, flat_, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                      VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL);
    return {};
}

Result<void> DentDrawing::record(GpuCommands& commands, std::span<const FingerMark> fingers,
                                 const MarkSizes& sizes, const ViewCamera& camera, const GpuImage& colour,
                                 const GpuImage& z) {
    shape_dents(fingers, sizes, dents_);
    if (dents_.empty()) return {};
    TRY_ASSIGN(const auto records, upload(camera));
    if (auto copied = copy_flat(commands, camera, colour); !copied.ok()) return copied;
    record_transition(commands, z, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                      VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL);
    begin_drawing(commands, {colour});
    program_.bind(commands, {records, z, flat_});
    vkCmdDraw(commands.handle(), 6, static_cast<std::uint32_t>(dents_.size()), 0, 0);
    end_drawing(commands);
    record_transition(commands, z, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL,
                      VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    return {};
}

}  // namespace touchable
