// SPDX-License-Identifier: Apache-2.0
#include <vulkan/vulkan.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "engine/base/try.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "player/draw/cpu_painting.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/view/drawn_surface.hpp"
#include "shaders/cut_tiles.spv.h"
#include "shaders/edges.h"
#include "shaders/edges.spv.h"
#include "shaders/erode.spv.h"
#include "shaders/light.h"
#include "shaders/light.spv.h"
#include "shaders/list_tiles.spv.h"
#include "shaders/tile_lists.h"
#include "shaders/unproject.h"
#include "shaders/unproject.spv.h"

// Lattices in GPU memory. Kernels compute q of a pair of frames (unproject), what a view draws of it (erode),
// positions of vertices at edges (edges), the tiles to draw (cut_tiles, list_tiles), and lit colours (light).
// Without codes, the CPU computes q and it is uploaded.

namespace touchable {
namespace {

static_assert(sizeof(UnprojectPush) == 72 && sizeof(LightPush) == 44);
static_assert(CUT_TILES_CELLS == TileGrid::cells);
static_assert(offsetof(TileListsHeader, mixed_vertices) - offsetof(TileListsHeader, whole_indices) ==
                  sizeof(VkDrawIndexedIndirectCommand) &&
              sizeof(TileListsHeader) - offsetof(TileListsHeader, mixed_vertices) ==
                  sizeof(VkDrawIndirectCommand));

constexpr GpuBindingKind storage_kind = GpuBindingKind::storage_buffer,
                         texel_kind = GpuBindingKind::uniform_texels;

/// The memory of kernels' outputs and inputs.
GpuMemory kernel_memory(const GpuDevice& device) {
    return device.facts().unified_memory ? GpuMemory::shared : GpuMemory::device;
}

/// Sets a coding's length = base + step m, or its inverse minus the shift, and how m follows from the code;
/// see shaders/unproject.h.
void set_coding(const DepthCoding& coding, UnprojectPush& push, UnprojectConstants& constants) {
    double base = 0, step = coding.scale;  // metric
    if (coding.kind == DepthCodingKind::inverse) {
        constants.is_inverse = 1;
        base = 1.0 / (coding.far + coding.shift);
        step = (1.0 / (coding.near + coding.shift) - base) / coding.code_max;
        constants.is_from_top = coding.near_is_high ? 0 : 1;  // 1 / length is what grows
    } else if (coding.kind == DepthCodingKind::log) {
        constants.is_log = 1;
        base = coding.near;
        step = coding.log_span() / coding.code_max;
        constants.is_from_top = coding.near_is_high ? 1 : 0;
        push.from_shift = static_cast<float>(coding.near + coding.shift);
        // `high` has 8 bits, so that its product with a code is exact.
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

/// The number of parts of `size` that hold `count`.
std::size_t parts_of(int count, int size) {
    return static_cast<std::size_t>((count + size - 1) / size);
}

void set_size(int width, int height, float focal_length, GpuLattice& lattice) {
    lattice.width = width;
    lattice.height = height;
    lattice.pitch = SurfaceUnproject::pitch(width);
    lattice.focal_length = focal_length;
}

/// Copies rows of 4 bytes a vertex into rows of `pitch` vertices.
template <class T>
void put_rows(const std::vector<T>& values, const GpuLattice& lattice, const GpuBuffer& buffer) {
    static_assert(sizeof(T) == 4);
    packed_plane(reinterpret_cast<const std::uint8_t*>(values.data()), lattice.width, lattice.height, 4, 1)
        .copy_rows(buffer.mapped<std::uint8_t>().data(), 4 * static_cast<std::size_t>(lattice.pitch));
}

/// Whether both views have the same samples, without reading them.
bool is_same_content(const PlaneView& a, const PlaneView& b) {
    return a.content != 0 && a.content == b.content && a.data == b.data && a.stride == b.stride &&
           same_form(a, b);
}

/// Writes q of a field without codes, in rows of the lattice's pitch, into a mapped buffer of that size.
void put_q(const HeightField& field, const GpuLattice& lattice, const GpuBuffer& to) {
    // There are no vertices beyond the width.
    std::memset(to.mapped<std::byte>().data(), 0, SurfaceUnproject::q_bytes(lattice.width, lattice.height));
    put_rows(q_of(field), lattice, to);
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
    push.pitch = static_cast<std::uint32_t>(parts_of(prev.width, 8));
    push.words = static_cast<std::uint32_t>(prev.validity_words_per_row());
    set_coding(prev.coding, push, constants);
    push.cx = static_cast<float>(scene.camera.cx);
    push.cy = static_cast<float>(scene.camera.cy);
    push.per_fx = static_cast<float>(1.0 / scene.camera.fx);
    push.per_fy = static_cast<float>(1.0 / scene.camera.fy);
    const auto per_code = static_cast<float>(height_per_code(scene));
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
    return UNPROJECT_WORD * static_cast<int>(parts_of(width, UNPROJECT_WORD));
}

std::size_t SurfaceUnproject::q_bytes(int width, int height) {
    return 4 * static_cast<std::size_t>(pitch(width)) * static_cast<std::size_t>(height);
}

bool SurfaceUnproject::has_codes(const HeightField& field, const FramePair& pair) {
    return !pair.prev.frame->codes.empty() && (field.blend() == 0 || !pair.next.frame->codes.empty());
}

Result<GpuBuffer> PlaneUploads::upload(GpuCommands& commands, const PlaneView& plane, std::size_t pitch) {
    auto found = std::ranges::find_if(kept_, [&](const Kept& kept) {
        return is_same_content(kept.plane, plane) && kept.pitch == pitch && kept.made.is_there_for(commands);
    });
    const bool is_there = found != kept_.end();
    if (!is_there) --found;  // evict the least recently used plane
    std::rotate(kept_.begin(), found, found + 1);
    Kept& kept = kept_.front();
    if (!is_there) {
        kept.made.reset();
        kept.plane = plane;
        kept.pitch = pitch;
        TRY(fill(commands, kept));
    }
    return kept.buffer;
}

/// The CPU writes into memory that no commands read. A GPU with its own memory copies from there, so that the
/// plane crosses the bus once, however many pictures read it.
Result<void> PlaneUploads::fill(GpuCommands& commands, Kept& kept) {
    const PlaneView& plane = kept.plane;
    const std::size_t bytes = kept.pitch * static_cast<std::size_t>(plane.height);
    const bool is_copied = !device_->facts().unified_memory;
    if (!is_copied) kept.buffer = {};
    TRY_ASSIGN(const auto written, uploads_.lease(name_, bytes));
    plane.copy_rows(written.mapped<std::uint8_t>().data(), kept.pitch);
    if (!is_copied) {
        kept.buffer = written;
        kept.made.by_cpu();
        return {};
    }
    if (!kept.buffer || kept.buffer.bytes() != bytes)
        TRY(assign(kept.buffer, GpuBuffer::create(*device_, name_, bytes, GpuMemory::device)));
    commands.barrier(GpuStage::compute, GpuStage::transfer);
    commands.copy(written, 0, kept.buffer, 0, bytes);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    kept.made.by(commands);
    return {};
}

Result<GpuProgram> SurfaceUnproject::program_for(const UnprojectConstants& constants) {
    const auto values = std::bit_cast<Constants>(constants);
    GpuProgram& program = programs_[values];
    if (program) return program;
    TRY_ASSIGN(program, GpuProgram::create(*device_, "unproject", unproject_spv,
                                           {sizeof(UnprojectPush),
                                            {texel_kind, storage_kind, texel_kind, texel_kind, storage_kind,
                                             texel_kind, storage_kind},
                                            {UNPROJECT_LANES, 1, 1}},
                                           values));
    return program;
}

Result<SurfaceUnproject::Planes> SurfaceUnproject::planes_of(GpuCommands& commands,
                                                             const SurfaceFrame& frame) {
    const auto upload = [&](PlaneUploads& uploads, PlaneView plane, std::size_t pitch) {
        plane.content = frame.content;
        return uploads.upload(commands, plane, pitch);
    };
    // Each row of codes and of heights begins with a whole texel.
    const std::size_t pitch = 16 * parts_of(frame.width, 8);
    Planes planes;
    const auto* built = dynamic_cast<const VulkanVertices*>(frame.vertices.get());
    if (built != nullptr && built->planes.is_on(*device_)) {
        planes.codes = built->planes.codes.gpu;
        planes.validity = built->planes.validity.gpu;
    } else {
        const int words_bytes = 4 * frame.validity_words_per_row();
        const PlaneView bits{reinterpret_cast<const std::uint8_t*>(frame.validity.data()), words_bytes,
                             words_bytes, frame.height};
        TRY_ASSIGN(planes.codes,
                   upload(codes_, plane_of_codes(frame.codes.data(), frame.width, frame.height), pitch));
        TRY_ASSIGN(planes.validity, upload(validity_, bits, static_cast<std::size_t>(words_bytes)));
    }
    planes.heights = planes.codes;
    if (frame.heights.empty()) return planes;
    TRY_ASSIGN(planes.heights,
               upload(heights_, plane_of_codes(frame.heights.data(), frame.width, frame.height), pitch));
    return planes;
}

Result<void> SurfaceUnproject::record(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                                      const GpuBuffer& q) {
    TRY_ASSIGN(const auto prev, planes_of(commands, *pair.prev.frame));
    Planes next = prev;
    if (field.blend() > 0) TRY(assign(next, planes_of(commands, *pair.next.frame)));

    auto [push, constants] = unproject_terms(field, pair);
    TRY_ASSIGN(const auto program, program_for(constants));
    if (makes_pairs_ && field.scene().interpolation == FrameInterpolation::linear) {
        constants.is_pair ^= 1U;
        TRY(program_for(constants));
    }
    commands.dispatch(program, push,
                      {prev.codes, prev.validity, prev.heights, next.codes, next.validity, next.heights, q},
                      {groups_for(push.height * push.words, UNPROJECT_LANES)});
    return {};
}

Result<void> GpuLattices::check_size(const char* name, std::size_t bytes) const {
    if (bytes <= device_->facts().limits.max_storage_buffer_range) return {};
    return gpu_error(std::string(name) + ": " + std::to_string(bytes) +
                     " bytes are more than a kernel may read on " + device_->facts().name);
}

Result<void> GpuLattices::reserve(GpuBuffer& buffer, const char* name, std::size_t bytes, GpuMemory memory) {
    TRY(check_size(name, bytes));
    return buffer.reserve(*device_, name, bytes, memory);
}

Result<void> GpuLattices::reserve_colours(GpuLattice& lattice) {
    return reserve(lattice.colours, "lattice colours",
                   SurfaceUnproject::q_bytes(lattice.width, lattice.height),  // colours have the same size
                   kernel_memory(*device_));
}

Result<void> GpuLattices::record_q(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                                   const GpuLattice& lattice) {
    if (SurfaceUnproject::has_codes(field, pair)) return unproject_.record(commands, field, pair, lattice.q);
    const std::size_t bytes = SurfaceUnproject::q_bytes(lattice.width, lattice.height);
    TRY_ASSIGN(const auto uploaded, uploads_.lease("lattice q", bytes));
    put_q(field, lattice, uploaded);
    commands.barrier(GpuStage::compute, GpuStage::transfer);
    commands.copy(uploaded, 0, lattice.q, 0, bytes);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    return {};
}

Result<void> GpuLattices::record(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                                 GpuLattice& lattice) {
    set_size(field.width(), field.height(), static_cast<float>(field.scene().camera.fx), lattice);
    const std::size_t bytes = SurfaceUnproject::q_bytes(lattice.width, lattice.height);
    TRY(reserve(lattice.q, "lattice q", bytes, kernel_memory(*device_)));
    TRY(record_q(commands, field, pair, lattice));
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.mark("unproject");
    return {};
}

std::size_t GpuLattices::tile_list_bytes(int width, int height) {
    return sizeof(TileListsHeader) + 4 * TileGrid::of(width, height).count();
}

Result<void> GpuLattices::make_programs() {
    unproject_.make_programs_in_pairs();
    return make_view_programs();
}

Result<void> GpuLattices::make_view_programs() {
    if (list_tiles_) return {};
    const auto make = [&](GpuProgram& program, const char* name, std::span<const std::uint32_t> code,
                          const GpuLayout& layout) {
        return assign(program, GpuProgram::create(*device_, name, code, layout));
    };
    const GpuLayout edges{sizeof(EdgesPush), {texel_kind, storage_kind}, {EDGES_LANES, 1, 1}};
    TRY(make(erode_, "erode", erode_spv, edges));
    TRY(make(edges_, "edges", edges_spv, edges));
    TRY(make(cut_tiles_, "cut_tiles", cut_tiles_spv,
             {sizeof(CutTilesPush), {texel_kind, storage_kind}, {CUT_TILES_LANES, 1, 1}}));
    return make(list_tiles_, "list_tiles", list_tiles_spv,
                {sizeof(CutTilesPush), {storage_kind, storage_kind}, {LIST_TILES_LANES, 1, 1}});
}

Result<void> GpuLattices::record_tiles(GpuCommands& commands, GpuLattice& lattice) {
    const int width = lattice.width, height = lattice.height;
    const TileGrid grid = TileGrid::of(width, height);
    TRY(reserve(lattice.tiles, "lattice tiles", tile_list_bytes(width, height), kernel_memory(*device_)));
    TRY(reserve(lattice.classes, "tile classes", 4 * grid.count(), GpuMemory::device));
    CutTilesPush push{};
    push.width = static_cast<std::uint32_t>(width);
    push.height = static_cast<std::uint32_t>(height);
    push.pitch = static_cast<std::uint32_t>(lattice.pitch / 4);
    push.tiles_x = static_cast<std::uint32_t>(grid.tiles_x);
    push.tiles = static_cast<std::uint32_t>(grid.count());
    commands.dispatch(cut_tiles_, push, {lattice.drawn_q, lattice.classes},
                      {groups_for(push.tiles, CUT_TILES_LANES)});
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.dispatch(list_tiles_, push, {lattice.classes, lattice.tiles}, {1});
    commands.barrier(GpuStage::compute, GpuStage::indirect);
    return {};
}

Result<void> GpuLattices::record_view(GpuCommands& commands, bool is_turned, GpuLattice& lattice) {
    TRY(make_view_programs());
    const std::size_t bytes = SurfaceUnproject::q_bytes(lattice.width, lattice.height);
    TRY(reserve(lattice.drawn_q, "drawn q", bytes, kernel_memory(*device_)));
    if (is_turned) TRY(reserve(lattice.edges, "lattice edges", 2 * bytes, kernel_memory(*device_)));
    const EdgeLattice at =
        edge_lattice(nullptr, lattice.width, lattice.height, lattice.pitch, 1, lattice.focal_length);
    const EdgesPush push{static_cast<std::uint32_t>(at.width),
                         static_cast<std::uint32_t>(at.height),
                         static_cast<std::uint32_t>(at.pitch),
                         at.ratio,
                         at.steepest,
                         is_turned ? 1U : 0U,
                         lattice.fills_gaps ? 1U : 0U};
    const GpuCommands::Groups groups{groups_for(push.pitch, EDGES_LANES), push.height};
    for (const GpuStage before : {GpuStage::graphics, GpuStage::indirect, GpuStage::compute})
        commands.barrier(before, GpuStage::compute);
    commands.dispatch(erode_, push, {GpuBinding::words(lattice.q), lattice.drawn_q}, groups);
    commands.barrier(GpuStage::compute, GpuStage::compute);
    if (is_turned)
        commands.dispatch(edges_, push, {GpuBinding::words(lattice.drawn_q), lattice.edges}, groups);
    TRY(record_tiles(commands, lattice));
    uploaded_.drawn_q = lattice.drawn_q;
    uploaded_.tiles = lattice.tiles;
    uploaded_.classes = lattice.classes;
    uploaded_.edges = lattice.edges;
    commands.mark("view");
    return {};
}

Result<GpuLattice> GpuLattices::lattice_of(const ViewSurface& surface) {
    GpuLattice lattice = uploaded_;
    set_size(surface.width, surface.height, surface.focal_length, lattice);
    lattice.fills_gaps = surface.fills_gaps;
    const GpuMemory memory = device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::upload;
    const std::size_t bytes = SurfaceUnproject::q_bytes(surface.width, surface.height);  // colours have the
                                                                                         // same size
    TRY(reserve(lattice.colours, "lattice colours", bytes, memory));
    put_rows(surface.colours, lattice, lattice.colours);
    TRY(reserve(lattice.q, "lattice q", bytes, memory));
    put_rows(surface.q, lattice, lattice.q);
    uploaded_ = lattice;
    return lattice;
}

Result<void> check_colour(const PlaneView& colour, int width, int height) {
    if (!colour.empty() && (colour.width != width || colour.height != height || colour.channels != 3 ||
                            colour.bytes_per_sample != 1))
        return internal_error("the colour of a surface is not RGB of 8 bits and its size");
    return {};
}

Result<GpuProgram> SurfaceLighting::program_for(bool has_colour, bool is_lit) {
    GpuProgram& program = programs_[{has_colour, is_lit}];
    if (program) return program;
    const std::array<std::uint32_t, 2> constants{has_colour, is_lit};
    TRY_ASSIGN(program, GpuProgram::create(
                            *device_, "light", light_spv,
                            {sizeof(LightPush), {texel_kind, texel_kind, storage_kind}, {LIGHT_LANES, 1, 1}},
                            constants));
    return program;
}

Result<void> SurfaceLighting::make_program() {
    TRY(program_for(true, true));
    return {};
}

Result<void> SurfaceLighting::record(GpuCommands& commands, const HeightField& field,
                                     const GpuLattice& lattice, const PlaneView& colour, Lighting lighting) {
    const bool has_colour = !colour.empty(), is_lit = !has_colour || light_strength(lighting) > 0;
    TRY(check_colour(colour, lattice.width, lattice.height));
    GpuBuffer rgb = lattice.q;
    if (has_colour)
        TRY(assign(rgb, rgb_.upload(commands, colour, 3 * static_cast<std::size_t>(lattice.pitch))));
    TRY_ASSIGN(const auto program, program_for(has_colour, is_lit));

    const Scene& scene = field.scene();
    LightPush push{};
    push.fx = static_cast<float>(scene.camera.fx);
    push.fy = static_cast<float>(scene.camera.fy);
    push.cx = static_cast<float>(scene.camera.cx);
    push.cy = static_cast<float>(scene.camera.cy);
    push.unit = static_cast<float>(scene.depth.far);
    if (!has_colour) {
        const UsualQ usual =
            usual_q(field.width(), field.height(), [&](int x, int y) { return drawn_q(field, x, y); });
        push.far_q = usual.farthest;
        push.per_q_range = 1 / std::max(usual.nearest - usual.farthest, 1e-30F);
    }
    push.strength = light_strength(lighting);
    push.width = static_cast<std::uint32_t>(lattice.width);
    push.height = static_cast<std::uint32_t>(lattice.height);
    push.pitch = static_cast<std::uint32_t>(lattice.pitch / 4);
    const std::uint32_t lanes = groups_for(push.width, LIGHT_COLUMNS) * groups_for(push.height, LIGHT_STRIP);
    commands.dispatch(program, push, {lattice.q, rgb, lattice.colours}, {groups_for(lanes, LIGHT_LANES)});
    return {};
}

}  // namespace touchable
