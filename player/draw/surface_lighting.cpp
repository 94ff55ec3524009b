#include "player/draw/surface_lighting.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "engine/base/try.hpp"
#include "player/draw/drawn_vertex.hpp"
#include "player/draw/surface_light.hpp"
#include "shaders/light.h"
#include "shaders/light.spv.h"

namespace touchable {
namespace {

static_assert(sizeof(LightPush) == 44);

UsualQ usual_q_of(const HeightField& field) {
    const Scene& scene = field.scene();
    return usual_q(field.width(), field.height(), [&](int x, int y) {
        const FieldVertex vertex = drawn_vertex(field, x, y);
        const double depth = planar_depth(scene.camera, scene.depth.semantics, x, y, vertex.depth);
        return vertex.valid ? static_cast<float>(1.0 / depth) : 0.0F;
    });
}

}  // namespace

Result<void> check_colour(const PlaneView& colour, int width, int height) {
    if (!colour.empty() && (colour.width != width || colour.height != height || colour.channels != 3 ||
                            colour.bytes_per_sample != 1))
        return Error{ErrorKind::internal, "the colour of a surface is not RGB of 8 bits and its size"};
    return {};
}

Result<GpuProgram> SurfaceLighting::program_for(bool has_colour, bool is_lit) {
    GpuProgram& program = programs_[{has_colour, is_lit}];
    if (program) return program;
    const std::array<std::uint32_t, 2> constants{has_colour, is_lit};
    constexpr GpuBindingKind texels = GpuBindingKind::uniform_texels;
    auto made = GpuProgram::create(
        *device_, "light", light_spv,
        {sizeof(LightPush), {texels, texels, GpuBindingKind::storage_buffer}, {LIGHT_LANES, 1, 1}},
        constants);
    if (made.ok()) program = *made;
    return made;
}

Result<GpuBuffer> SurfaceLighting::uploaded(const PlaneView& colour, int pitch) {
    const std::size_t row_bytes = 3 * static_cast<std::size_t>(pitch);
    auto buffer = uploads_.take("view colours", row_bytes * static_cast<std::size_t>(colour.height));
    if (!buffer.ok()) return buffer;
    std::uint8_t* to = buffer->mapped<std::uint8_t>().data();
    for (int y = 0; y < colour.height; ++y, to += row_bytes)
        std::memcpy(to, colour.row(y), 3 * static_cast<std::size_t>(colour.width));
    return buffer;
}

Result<void> SurfaceLighting::record(GpuCommands& commands, const HeightField& field,
                                     const GpuLattice& lattice, const PlaneView& colour, Lighting lighting) {
    const bool has_colour = !colour.empty(), is_lit = !has_colour || lighting == Lighting::lit;
    if (auto fits = check_colour(colour, lattice.width, lattice.height); !fits.ok()) return fits;
    GpuBuffer rgb = lattice.q;
    if (has_colour) {
        TRY_ASSIGN(auto made, uploaded(colour, lattice.pitch));
        rgb = std::move(made);
    }
    TRY_ASSIGN(const auto program, program_for(has_colour, is_lit));

    const Scene& scene = field.scene();
    LightPush push{};
    push.fx = static_cast<float>(scene.camera.fx);
    push.fy = static_cast<float>(scene.camera.fy);
    push.cx = static_cast<float>(scene.camera.cx);
    push.cy = static_cast<float>(scene.camera.cy);
    push.unit = static_cast<float>(scene.depth.far);
    if (!has_colour) {
        const UsualQ usual = usual_q_of(field);
        push.far_q = usual.farthest;
        push.per_q_range = 1 / std::max(usual.nearest - usual.farthest, 1e-30F);
    }
    push.width = static_cast<std::uint32_t>(lattice.width);
    push.height = static_cast<std::uint32_t>(lattice.height);
    push.pitch = static_cast<std::uint32_t>(lattice.pitch / 4);
    // Few lanes that march far on a CPU: each begins with five rows more than it lights.
    push.strip = device_->facts().kind == GpuKind::software ? 64 : 16;
    const std::uint32_t lanes = groups_for(push.width, LIGHT_COLUMNS) * groups_for(push.height, push.strip);
    commands.dispatch(program, push, {lattice.q, rgb, lattice.colours}, {groups_for(lanes, LIGHT_LANES)});
    return {};
}

}  // namespace touchable
