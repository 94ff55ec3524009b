#include "player/draw/finger_drawing.hpp"

#include <algorithm>
#include <glm/matrix.hpp>
#include <string>
#include <vector>

#include "engine/base/try.hpp"
#include "shaders/view_ball.frag.spv.h"
#include "shaders/view_ball.vert.spv.h"
#include "shaders/view_frustum.frag.spv.h"
#include "shaders/view_frustum.vert.spv.h"
#include "shaders/view_marks.h"
#include "shaders/view_shadow.frag.spv.h"
#include "shaders/view_shadow.vert.spv.h"
#include "shaders/view_thread.frag.spv.h"
#include "shaders/view_thread.vert.spv.h"

namespace touchable {
namespace {

static_assert(sizeof(MarksPush) == 88 && sizeof(SolidRecord) == 64 && sizeof(ThreadRecord) == 32 &&
              sizeof(ShadowRecord) == 96);

constexpr std::uint32_t frustum_indices = 6 * MARKS_SIDES;

/// Between a frustum's ends, two triangles a side.
Result<GpuBuffer> make_frustum_pattern(const GpuDevice& device) {
    auto buffer = GpuBuffer::create(device, "frustum pattern", frustum_indices * 2, GpuMemory::upload);
    if (!buffer.ok()) return buffer;
    auto to = buffer->mapped<std::uint16_t>().begin();
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
    // Screen to clip space, to the world, to shares of the reach.
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

Result<FingerDrawing> FingerDrawing::create(const std::shared_ptr<GpuDevice>& device) {
    FingerDrawing made(device);
    constexpr VkDescriptorType buffer = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    const struct {
        const char* name;
        GraphicsProgram& program;
        std::span<const std::uint32_t> vertex, fragment;
        std::vector<VkDescriptorType> bindings;
        DrawDepth depth;
        DrawBlend blend;
    } programs[] = {{"shadows",
                     made.shadow_,
                     view_shadow_vert_spv,
                     view_shadow_frag_spv,
                     {buffer, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE},
                     DrawDepth::ignored,
                     DrawBlend::multiplied},
                    {"threads",
                     made.thread_,
                     view_thread_vert_spv,
                     view_thread_frag_spv,
                     {buffer},
                     DrawDepth::nearest,
                     DrawBlend::over},
                    {"balls",
                     made.solid_.ball,
                     view_ball_vert_spv,
                     view_ball_frag_spv,
                     {buffer},
                     DrawDepth::nearest,
                     DrawBlend::over},
                    {"frusta",
                     made.solid_.frustum,
                     view_frustum_vert_spv,
                     view_frustum_frag_spv,
                     {buffer},
                     DrawDepth::nearest,
                     DrawBlend::over},
                    {"bubbles",
                     made.veil_.ball,
                     view_ball_vert_spv,
                     view_ball_frag_spv,
                     {buffer},
                     DrawDepth::in_front,
                     DrawBlend::over},
                    {"rods",
                     made.veil_.frustum,
                     view_frustum_vert_spv,
                     view_frustum_frag_spv,
                     {buffer},
                     DrawDepth::in_front,
                     DrawBlend::over},
                    {"hidden bubbles",
                     made.hidden_veil_.ball,
                     view_ball_vert_spv,
                     view_ball_frag_spv,
                     {buffer},
                     DrawDepth::behind,
                     DrawBlend::over},
                    {"hidden rods",
                     made.hidden_veil_.frustum,
                     view_frustum_vert_spv,
                     view_frustum_frag_spv,
                     {buffer},
                     DrawDepth::behind,
                     DrawBlend::over}};
    for (const auto& each : programs) {
        GraphicsLook look;
        look.vertex = each.vertex;
        look.fragment = each.fragment;
        look.push_bytes = sizeof(MarksPush);
        look.bindings = each.bindings;
        look.colour_format = VK_FORMAT_R8G8B8A8_SRGB;
        look.depth = each.depth;
        look.blend = each.blend;
        TRY_ASSIGN(auto program, GraphicsProgram::create(*device, each.name, look));
        each.program = std::move(program);
    }
    TRY_ASSIGN(auto pattern, make_frustum_pattern(*device));
    made.pattern_ = std::move(pattern);
    return made;
}

/// Balls before frusta, but for veils, where rods are first already.
void FingerDrawing::sort_solids() {
    std::stable_partition(shapes_.solids.begin(), shapes_.solids.end(),
                          [](const Solid& solid) { return solid.is_ball; });
}

/// All records in one buffer: solids, then veils; threads, with a point more that is joined to none; shadows.
Result<GpuBuffer> FingerDrawing::upload(const ViewCamera& camera, Parts& parts) {
    std::size_t bytes = 0;
    const auto add = [&](Part& part, std::size_t count, std::size_t size) {
        constexpr std::size_t alignment = 256;  // of no device more
        part = {(bytes + alignment - 1) / alignment * alignment, std::max<std::size_t>(count, 1) * size};
        bytes = part.offset + part.bytes;
    };
    add(parts.solids, shapes_.solids.size() + shapes_.veils.size(), sizeof(SolidRecord));
    add(parts.threads, shapes_.threads.size() + 1, sizeof(ThreadRecord));
    add(parts.shadows, shapes_.shadows.size(), sizeof(ShadowRecord));
    // Room for what a finger's trail may grow to, so that the next pictures need no more.
    constexpr std::size_t step = 16384;
    auto buffer = uploads_.take("fingers", (bytes + step - 1) / step * step);
    if (!buffer.ok()) return buffer;
    std::byte* to = buffer->mapped<std::byte>().data();
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

void FingerDrawing::draw_shadows(GpuCommands& commands, const GpuBuffer& records, const Part& part,
                                 const GpuImage& colour, const GpuImage& z) const {
    record_transition(commands, z, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                      VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL);
    begin_drawing(commands, {colour, nullptr, true});
    shadow_.bind(commands, MarksPush{}, {{records, part.offset, part.bytes}, z});
    vkCmdDraw(commands.handle(), 6, static_cast<std::uint32_t>(shapes_.shadows.size()), 0, 0);
    end_drawing(commands);
    record_transition(commands, z, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL,
                      VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
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
    const auto bind = [&](const GraphicsProgram& program, bool is_veil, bool is_behind) {
        program.bind(commands, push_of(camera, is_veil, is_behind),
                     {{records, parts.solids.offset, parts.solids.bytes}});
    };
    const auto draw_balls = [&](const SolidPrograms& programs, bool is_veil, bool is_behind,
                                std::size_t first, std::size_t count) {
        if (count == 0) return;
        bind(programs.ball, is_veil, is_behind);
        vkCmdDraw(drawing, 6, static_cast<std::uint32_t>(count), 0, static_cast<std::uint32_t>(first));
    };
    const auto draw_frusta = [&](const SolidPrograms& programs, bool is_veil, bool is_behind,
                                 std::size_t first, std::size_t count) {
        if (count == 0) return;
        bind(programs.frustum, is_veil, is_behind);
        vkCmdDrawIndexed(drawing, frustum_indices, static_cast<std::uint32_t>(count), 0, 0,
                         static_cast<std::uint32_t>(first));
    };
    const auto balls_in = [](const std::vector<Solid>& solids) {
        return static_cast<std::size_t>(
            std::count_if(solids.begin(), solids.end(), [](const Solid& solid) { return solid.is_ball; }));
    };
    const std::size_t solids = shapes_.solids.size(), balls = balls_in(shapes_.solids);
    draw_balls(solid_, false, false, 0, balls);
    draw_frusta(solid_, false, false, balls, solids - balls);
    const std::size_t bubbles = balls_in(shapes_.veils), rods = shapes_.veils.size() - bubbles;
    draw_frusta(hidden_veil_, true, true, solids, rods);
    draw_frusta(veil_, true, false, solids, rods);
    draw_balls(hidden_veil_, true, true, solids + rods, bubbles);
    draw_balls(veil_, true, false, solids + rods, bubbles);
}

Result<void> FingerDrawing::record(GpuCommands& commands, std::span<const FingerMark> fingers,
                                   const MarkSizes& sizes, const ViewCamera& camera, const GpuImage& colour,
                                   const GpuImage& z) {
    if (fingers.empty()) return {};
    shape_fingers(fingers, sizes, camera.eye, shapes_);
    sort_solids();
    Parts parts;
    TRY_ASSIGN(const auto records, upload(camera, parts));
    // Colours as light: it is light that shadows and veils take away and mix.
    record_transition(commands, colour, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                      VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    draw_shadows(commands, records, parts.shadows, colour, z);
    record_transition(commands, colour, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                      VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    begin_drawing(commands, {colour, &z, true});
    draw_solids(commands, camera, records, parts);
    end_drawing(commands);
    return {};
}

}  // namespace touchable
