#include "player/draw/surface_unproject.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "engine/base/try.hpp"
#include "engine/gpu/vulkan_vertices.hpp"
#include "player/draw/drawn_vertex.hpp"
#include "shaders/unproject.h"
#include "shaders/unproject.spv.h"

namespace touchable {
namespace {

static_assert(sizeof(UnprojectPush) == 80);

/// Length = base + step m, or its inverse less the shift, of a coding, and how m comes from the code; see
/// shaders/unproject.h.
void set_coding(const DepthCoding& coding, UnprojectPush& push, UnprojectConstants& constants) {
    double base = 0, step = coding.scale;  // metric
    if (coding.kind == DepthCodingKind::inverse) {
        constants.is_inverse = 1;
        base = 1.0 / (coding.far + coding.shift);
        step = (1.0 / (coding.near + coding.shift) - base) / coding.code_max;
        constants.is_from_top = coding.near_is_high ? 0 : 1;  // it is 1 / length that grows
    } else if (coding.kind == DepthCodingKind::log) {
        constants.is_log = 1;
        base = coding.near;
        step = coding.log_span() / coding.code_max;
        constants.is_from_top = coding.near_is_high ? 1 : 0;
        push.from_shift = static_cast<float>(coding.near + coding.shift);
        // A first part of 8 bits, so that its product with a code is exact.
        int power = 0;
        const double digits = std::frexp(step, &power);
        const double high = std::ldexp(std::floor(digits * 256), power - 8);
        push.step_low = static_cast<float>(step - high);
        step = high;
    } else if (coding.kind != DepthCodingKind::metric) {
        base = coding.near;
        step = (coding.far - coding.near) / coding.code_max;
        constants.is_from_top = coding.near_is_high ? 1 : 0;
    }
    push.code_max = coding.code_max;
    push.shift = static_cast<float>(coding.shift);
    push.base = static_cast<float>(base);
    push.step = static_cast<float>(step);
}

std::size_t whole(int count, int size) {
    return static_cast<std::size_t>((count + size - 1) / size);
}

}  // namespace

UnprojectTerms unproject_terms(const HeightField& field, const FramePair& pair) {
    const double blend = field.blend();
    const Scene& scene = field.scene();
    const SurfaceFrame& prev = *pair.prev.frame;
    const SurfaceFrame& next = blend > 0 ? *pair.next.frame : prev;
    UnprojectTerms terms{};
    auto& [push, constants] = terms;
    push.height = static_cast<std::uint32_t>(prev.height);
    push.pitch = static_cast<std::uint32_t>(whole(prev.width, 8));
    push.words = static_cast<std::uint32_t>(prev.validity_words_per_row());
    set_coding(prev.coding, push, constants);
    push.cx = static_cast<float>(scene.camera.cx);
    push.cy = static_cast<float>(scene.camera.cy);
    push.per_fx = static_cast<float>(1.0 / scene.camera.fx);
    push.per_fy = static_cast<float>(1.0 / scene.camera.fy);
    const auto per_code =
        static_cast<float>(largest_height(scene.height_coding, scene.depth) / scene.height_coding.code_max);
    push.height_per_code = prev.heights.empty() ? 0.0F : per_code;
    push.next_height_per_code = next.heights.empty() ? 0.0F : per_code;
    push.blend = static_cast<float>(blend);
    push.rest = static_cast<float>(1.0 - blend);
    push.reach = blend_reach(field);
    constants.is_pair = blend > 0 ? 1 : 0;
    constants.has_heights = prev.heights.empty() && next.heights.empty() ? 0 : 1;
    constants.is_range = prev.coding.semantics == DepthSemantics::range ? 1 : 0;
    return terms;
}

int SurfaceUnproject::pitch(int width) {
    return UNPROJECT_WORD * static_cast<int>(whole(width, UNPROJECT_WORD));
}

std::size_t SurfaceUnproject::q_bytes(int width, int height) {
    return 4 * static_cast<std::size_t>(pitch(width)) * static_cast<std::size_t>(height);
}

bool SurfaceUnproject::has_codes(const HeightField& field, const FramePair& pair) {
    return !pair.prev.frame->codes.empty() && (field.blend() == 0 || !pair.next.frame->codes.empty());
}

Result<GpuProgram> SurfaceUnproject::program_for(const Constants& constants) {
    GpuProgram& program = programs_[constants];
    if (program) return program;
    constexpr GpuBindingKind buffer = GpuBindingKind::storage_buffer, texels = GpuBindingKind::uniform_texels;
    auto made = GpuProgram::create(*device_, "unproject", unproject_spv,
                                   {sizeof(UnprojectPush),
                                    {texels, buffer, texels, texels, buffer, texels, buffer},
                                    {constants[0], 1, 1}},
                                   constants);
    if (made.ok()) program = *made;
    return made;
}

/// Rows of 16 bits a pixel, each from a whole texel on.
Result<GpuBuffer> SurfaceUnproject::uploaded_rows(const char* name, const std::uint16_t* values, int width,
                                                  int height) {
    const std::size_t pitch = 8 * whole(width, 8), columns = static_cast<std::size_t>(width);
    const auto rows = static_cast<std::size_t>(height);
    auto buffer = uploads_.take(name, 2 * pitch * rows);
    if (!buffer.ok()) return buffer;
    std::uint16_t* to = buffer->mapped<std::uint16_t>().data();
    for (std::size_t y = 0; y < rows; ++y) std::memcpy(to + y * pitch, values + y * columns, 2 * columns);
    return buffer;
}

Result<SurfaceUnproject::Planes> SurfaceUnproject::planes_of(const SurfaceFrame& frame) {
    Planes planes;
    const auto* built = dynamic_cast<const VulkanVertices*>(frame.vertices.get());
    if (built != nullptr && built->is_on(*device_)) {
        planes.codes = built->codes.gpu;
        planes.validity = built->validity.gpu;
    } else {
        TRY_ASSIGN(auto codes, uploaded_rows("view codes", frame.codes.data(), frame.width, frame.height));
        const std::size_t bytes = frame.validity.size() * sizeof(std::uint32_t);
        TRY_ASSIGN(auto validity, uploads_.take("view validity", bytes));
        std::memcpy(validity.mapped<std::uint32_t>().data(), frame.validity.data(), bytes);
        planes.codes = codes;
        planes.validity = validity;
    }
    planes.heights = planes.codes;
    if (frame.heights.empty()) return planes;
    TRY_ASSIGN(auto heights, uploaded_rows("view heights", frame.heights.data(), frame.width, frame.height));
    planes.heights = heights;
    return planes;
}

Result<void> SurfaceUnproject::record(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                                      const GpuBuffer& q) {
    const auto prev_planes = planes_of(*pair.prev.frame);
    if (!prev_planes.ok()) return prev_planes.error();
    TRY_ASSIGN(const auto next_planes, field.blend() > 0 ? planes_of(*pair.next.frame) : prev_planes);

    auto [push, constants] = unproject_terms(field, pair);
    // Few lanes that march whole rows on a CPU, many with a word each elsewhere.
    const bool marches = device_->facts().kind == GpuKind::software;
    constants.group_size = marches ? 8 : 64;
    push.segments = marches ? 1 : push.words;
    push.segment_words = marches ? push.words : 1;

    TRY_ASSIGN(
        const auto program,
        program_for({constants.group_size, constants.is_pair, constants.has_heights, constants.is_range,
                     constants.is_inverse, constants.is_from_top, constants.is_log}));
    commands.dispatch(program, push,
                      {prev_planes->codes, prev_planes->validity, prev_planes->heights, next_planes.codes,
                       next_planes.validity, next_planes.heights, q},
                      {groups_for(push.height * push.segments, constants.group_size)});
    return {};
}

}  // namespace touchable
