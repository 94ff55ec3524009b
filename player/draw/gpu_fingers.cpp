// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/matrix.hpp>
#include <span>
#include <vector>

#include "engine/base/try.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/light_picture.hpp"
#include "shaders/dents.h"
#include "shaders/view_ball.frag.spv.h"
#include "shaders/view_ball.vert.spv.h"
#include "shaders/view_dent.frag.spv.h"
#include "shaders/view_dent.vert.spv.h"
#include "shaders/view_frustum.frag.spv.h"
#include "shaders/view_frustum.vert.spv.h"
#include "shaders/view_marks.h"
#include "shaders/view_shadow.frag.spv.h"
#include "shaders/view_shadow.vert.spv.h"
#include "shaders/view_thread.frag.spv.h"
#include "shaders/view_thread.vert.spv.h"

// GPU drawing over the picture of a surface: dents (DentDrawing) and fingers (FingerDrawing). Records of both
// lie in buffers that are rewritten for each picture.

namespace touchable {
namespace {

static_assert(sizeof(DentHeader) == 144 && sizeof(DentRecord) == 64);
static_assert(sizeof(MarksPush) == 88 && sizeof(SolidRecord) == 64 && sizeof(ThreadRecord) == 32 &&
              sizeof(ShadowRecord) == 96);

DentRecord record_of(const SurfaceDent& dent, const ViewCamera& camera) {
    return {glm::vec4(dent.centre, 1 / dent.reach), glm::vec4(dent.normal, 0), glm::vec4(dent.moved, 0),
            clip_bounds(bounds_of_ball(camera, dent.centre, dent.reach), camera)};
}

VkExtent3D extent_of(const PixelBounds& bounds) {
    return {static_cast<std::uint32_t>(bounds.x1 - bounds.x0),
            static_cast<std::uint32_t>(bounds.y1 - bounds.y0), 1};
}

/// Draws with z readable by shaders.
template <class Draw>
void draw_reading_z(GpuCommands& commands, const DrawTarget& target, const GpuImage& z, const Draw& draw) {
    constexpr VkImageLayout tested = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
    record_transition(commands, z, tested, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL);
    begin_drawing(commands, target);
    draw();
    end_drawing(commands);
    record_transition(commands, z, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL, tested);
}

constexpr std::uint32_t frustum_indices = 6 * MARKS_SIDES;

/// The triangles between a frustum's ends, two a side.
Result<GpuBuffer> make_frustum_pattern(const GpuDevice& device) {
    TRY_ASSIGN(auto buffer,
               GpuBuffer::create(device, "frustum pattern", frustum_indices * 2, GpuMemory::upload));
    auto to = buffer.mapped<std::uint16_t>().begin();
    for (std::uint32_t a = 0; a < MARKS_SIDES; ++a) {
        const std::uint32_t b = a + 1, c = b + MARKS_RING_CORNERS, d = c - 1;
        for (const std::uint32_t vertex : {a, b, c, a, c, d}) *to++ = static_cast<std::uint16_t>(vertex);
    }
    return buffer;
}

SolidRecord record_of(const Solid& solid) {
    return {glm::vec4(solid.foot, solid.from.radius), glm::vec4(solid.along, solid.to.radius),
            glm::vec4(solid.from.height, solid.to.height, solid.from.normal_along, solid.from.normal_away),
            glm::vec4(solid.material.light, solid.material.opacity)};
}

ShadowRecord record_of(const BallShadow& shadow, const ViewCamera& camera) {
    // From screen to clip space, to the world, to shares of the reach.
    glm::dmat4 share_from_world(1.0);
    for (int axis = 0; axis < 3; ++axis) share_from_world[axis][axis] = 1 / shadow.reach;
    share_from_world[3] = glm::dvec4(-shadow.centre / shadow.reach, 1);
    ShadowRecord record{};
    record.share_from_pixel =
        glm::mat4(share_from_world * glm::inverse(camera.clip_from_world) * clip_from_pixel(camera));
    record.darkness.x = shadow.darkness;
    record.bounds = clip_bounds(bounds_of_ball(camera, shadow.centre, shadow.reach), camera);
    return record;
}

MarksPush push_of(const ViewCamera& camera, bool is_veil, bool is_behind) {
    return {glm::mat4(camera.clip_from_world), glm::vec4(camera.eye, camera.focal), is_behind, is_veil};
}

}  // namespace

Result<DentDrawing> DentDrawing::create(const std::shared_ptr<GpuDevice>& device) {
    DentDrawing made(device);
    const GraphicsLook look{.vertex = view_dent_vert_spv,
                            .fragment = view_dent_frag_spv,
                            .bindings = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
                                         VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE},
                            .depth = DrawDepth::ignored};
    TRY_ASSIGN(made.program_, GraphicsProgram::create(*device, "dents", look));
    return made;
}

Result<GpuBuffer> DentDrawing::upload(const ViewCamera& camera) {
    TRY_ASSIGN(auto buffer, uploads_.lease("dents", sizeof(DentHeader) + dents_.size() * sizeof(DentRecord)));
    const glm::dmat4 from_pixel = clip_from_pixel(camera);
    std::byte* const to = buffer.mapped<std::byte>().data();
    *reinterpret_cast<DentHeader*>(to) = {glm::mat4(glm::inverse(camera.clip_from_world) * from_pixel),
                                          glm::mat4(glm::inverse(from_pixel) * camera.clip_from_world),
                                          static_cast<std::uint32_t>(dents_.size()),
                                          {}};
    auto* record = reinterpret_cast<DentRecord*>(to + sizeof(DentHeader));
    for (const SurfaceDent& dent : dents_) *record++ = record_of(dent, camera);
    return buffer;
}

/// Copies the source pixels of each dent: at most the dent's displacement away from its pixels.
Result<void> DentDrawing::copy_flat(GpuCommands& commands, const ViewCamera& camera, const GpuImage& colour) {
    if (!flat_ || !flat_.is_of_size(camera.width, camera.height))
        TRY(assign(flat_, GpuImage::create(*device_, "picture without dents", camera.width, camera.height,
                                           VK_FORMAT_R8G8B8A8_UNORM)));
    std::vector<VkImageCopy> regions;
    for (const SurfaceDent& dent : dents_) {
        const double reach = dent.reach + most_dented / dent_reach * dent.reach;
        const auto bounds = bounds_in_sight(camera, dent.centre, reach);
        if (!bounds) continue;
        VkImageCopy region{};
        region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        region.srcOffset = region.dstOffset = {bounds->x0, bounds->y0, 0};
        region.extent = extent_of(*bounds);
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
    TRY(copy_flat(commands, camera, colour));
    draw_reading_z(commands, {colour}, z, [&] {
        program_.bind(commands, {records, z, flat_});
        vkCmdDraw(commands.handle(), 6, static_cast<std::uint32_t>(dents_.size()), 0, 0);
    });
    return {};
}

Result<FingerDrawing> FingerDrawing::create(const std::shared_ptr<GpuDevice>& device) {
    FingerDrawing made(device);
    struct Stages {
        std::span<const std::uint32_t> vertex, fragment;
    };
    const Stages shadow{view_shadow_vert_spv, view_shadow_frag_spv},
        thread{view_thread_vert_spv, view_thread_frag_spv}, ball{view_ball_vert_spv, view_ball_frag_spv},
        frustum{view_frustum_vert_spv, view_frustum_frag_spv};
    const struct {
        const char* name;
        GraphicsProgram& program;
        const Stages& stages;
        DrawDepth depth;
    } programs[] = {{"shadows", made.shadow_, shadow, DrawDepth::ignored},
                    {"threads", made.thread_, thread, DrawDepth::nearest},
                    {"balls", made.solid_.ball, ball, DrawDepth::nearest},
                    {"frusta", made.solid_.frustum, frustum, DrawDepth::nearest},
                    {"bubbles", made.veil_.ball, ball, DrawDepth::in_front},
                    {"rods", made.veil_.frustum, frustum, DrawDepth::in_front},
                    {"hidden bubbles", made.hidden_veil_.ball, ball, DrawDepth::behind},
                    {"hidden rods", made.hidden_veil_.frustum, frustum, DrawDepth::behind}};
    for (const auto& [name, program, stages, depth] : programs) {
        const bool is_shadow = &stages == &shadow;
        GraphicsLook look{.vertex = stages.vertex,
                          .fragment = stages.fragment,
                          .push_bytes = sizeof(MarksPush),
                          .bindings = {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                          .colour_format = VK_FORMAT_R8G8B8A8_SRGB,
                          .depth = depth,
                          .blend = is_shadow ? DrawBlend::multiplied : DrawBlend::over};
        if (is_shadow) look.bindings.push_back(VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE);
        TRY_ASSIGN(program, GraphicsProgram::create(*device, name, look));
    }
    TRY_ASSIGN(made.pattern_, make_frustum_pattern(*device));
    return made;
}

/// All records in one buffer: solids, then veils; threads, with a final unjoined point; shadows.
Result<GpuBuffer> FingerDrawing::upload(const ViewCamera& camera, Parts& parts) {
    std::size_t bytes = 0;
    const auto add = [&](Part& part, std::size_t count, std::size_t size) {
        constexpr std::size_t alignment = 256;  // no device needs more
        part = {(bytes + alignment - 1) / alignment * alignment, std::max<std::size_t>(count, 1) * size};
        bytes = part.offset + part.bytes;
    };
    add(parts.solids, shapes_.solids.size() + shapes_.veils.size(), sizeof(SolidRecord));
    add(parts.threads, shapes_.threads.size() + 1, sizeof(ThreadRecord));
    add(parts.shadows, shapes_.shadows.size(), sizeof(ShadowRecord));
    // Rounded up, as trails grow, so that the next pictures reuse the buffer.
    constexpr std::size_t step = 16384;
    TRY_ASSIGN(auto buffer, uploads_.lease("fingers", (bytes + step - 1) / step * step));
    std::byte* to = buffer.mapped<std::byte>().data();
    auto* solid = reinterpret_cast<SolidRecord*>(to + parts.solids.offset);
    for (const auto* solids : {&shapes_.solids, &shapes_.veils})
        for (const Solid& each : *solids) *solid++ = record_of(each);
    auto* point = reinterpret_cast<ThreadRecord*>(to + parts.threads.offset);
    for (const ThreadPoint& each : shapes_.threads)
        *point++ = {glm::vec4(each.at, each.radius), glm::vec4(each.light, each.is_joined ? 1 : 0)};
    *point = {};
    auto* shadow = reinterpret_cast<ShadowRecord*>(to + parts.shadows.offset);
    for (const BallShadow& each : shapes_.shadows) *shadow++ = record_of(each, camera);
    return buffer;
}

void FingerDrawing::draw_solids(GpuCommands& commands, const ViewCamera& camera, const GpuBuffer& records,
                                const Parts& parts) const {
    const VkCommandBuffer drawing = commands.handle();
    if (shapes_.threads.size() > 1) {
        thread_.bind(commands, push_of(camera, false, false),
                     {{records, parts.threads.offset, parts.threads.bytes}});
        vkCmdDraw(drawing, 6, static_cast<std::uint32_t>(shapes_.threads.size() - 1), 0, 0);
    }
    vkCmdBindIndexBuffer(drawing, pattern_.handle(), 0, VK_INDEX_TYPE_UINT16);
    commands.keep(pattern_.keep_alive());
    const auto draw = [&](const GraphicsProgram& program, bool is_veil, bool is_behind, std::size_t first,
                          std::size_t count, bool are_balls) {
        if (count == 0) return;
        program.bind(commands, push_of(camera, is_veil, is_behind),
                     {{records, parts.solids.offset, parts.solids.bytes}});
        const auto at = static_cast<std::uint32_t>(first), many = static_cast<std::uint32_t>(count);
        if (are_balls)
            vkCmdDraw(drawing, 6, many, 0, at);
        else
            vkCmdDrawIndexed(drawing, frustum_indices, many, 0, 0, at);
    };
    const auto balls_in = [](const std::vector<Solid>& solids) {
        return static_cast<std::size_t>(
            std::ranges::count_if(solids, [](const Solid& solid) { return solid.is_ball; }));
    };
    const std::size_t solids = shapes_.solids.size(), balls = balls_in(shapes_.solids);
    draw(solid_.ball, false, false, 0, balls, true);
    draw(solid_.frustum, false, false, balls, solids - balls, false);
    const std::size_t bubbles = balls_in(shapes_.veils), rods = shapes_.veils.size() - bubbles;
    draw(hidden_veil_.frustum, true, true, solids, rods, false);
    draw(veil_.frustum, true, false, solids, rods, false);
    draw(hidden_veil_.ball, true, true, solids + rods, bubbles, true);
    draw(veil_.ball, true, false, solids + rods, bubbles, true);
}

Result<void> FingerDrawing::record(GpuCommands& commands, std::span<const FingerMark> fingers,
                                   const MarkSizes& sizes, const ViewCamera& camera, const GpuImage& colour,
                                   const GpuImage& z) {
    if (fingers.empty()) return {};
    shape_fingers(fingers, sizes, camera.eye, shapes_);
    // Sorts balls before frusta; veils already have rods first.
    std::stable_partition(shapes_.solids.begin(), shapes_.solids.end(),
                          [](const Solid& solid) { return solid.is_ball; });
    Parts parts;
    TRY_ASSIGN(const auto records, upload(camera, parts));
    // Draws in linear light, in which shadows and veils multiply and mix.
    record_transition(commands, colour, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                      VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    draw_reading_z(commands, {colour, nullptr, true}, z, [&] {
        shadow_.bind(commands, MarksPush{}, {{records, parts.shadows.offset, parts.shadows.bytes}, z});
        vkCmdDraw(commands.handle(), 6, static_cast<std::uint32_t>(shapes_.shadows.size()), 0, 0);
    });
    record_transition(commands, colour, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                      VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    begin_drawing(commands, {colour, &z, true});
    draw_solids(commands, camera, records, parts);
    end_drawing(commands);
    return {};
}

}  // namespace touchable
