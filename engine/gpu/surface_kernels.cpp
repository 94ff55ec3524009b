#include "engine/gpu/surface_kernels.hpp"

#include <algorithm>
#include <bit>

#include "engine/scene/flying_pixels.hpp"
#include "engine/scene/stored_code.hpp"
#include "engine/scene/working_codes.hpp"
#include "shaders/decode.spv.h"
#include "shaders/fill_holes.spv.h"
#include "shaders/flying_pixels.spv.h"
#include "shaders/hue_codes.spv.h"
#include "shaders/median3.spv.h"
#include "shaders/median5.spv.h"
#include "shaders/temporal.spv.h"
#include "shaders/terraces.spv.h"
#include "shaders/tile_bounds.spv.h"

namespace touchable {
namespace {

static_assert(no_hue_code == no_hue);
static_assert(no_finer_code > 2 * terrace_range);
static_assert(most_ramp_steps == widest_ramp && most_ramp_steps == flying_reach);

constexpr GpuBindingKind buffer = GpuBindingKind::storage_buffer, texels = GpuBindingKind::uniform_texels;

struct KernelSource {
    const char* name;
    std::span<const std::uint32_t> spirv;
};

KernelSource source_of(StripKernel kernel) {
    switch (kernel) {
        case StripKernel::decode:
            return {"decode", decode_spv};
        case StripKernel::median3:
            return {"median3", median3_spv};
        case StripKernel::median5:
            return {"median5", median5_spv};
        case StripKernel::fill_holes:
            break;
    }
    return {"fill_holes", fill_holes_spv};
}

}  // namespace

SurfacePlan plan_for(const GpuFacts& facts) {
    SurfacePlan plan;
    if (facts.kind != GpuKind::software) plan = {64, 4, true};
    plan.copies = !facts.unified_memory;
    return plan;
}

ValidCodes valid_codes_of(const DepthCoding& coding) {
    const int low = coding.valid_min, high = coding.valid_max;
    ValidCodes codes{no_such_code, 0, {no_such_code, no_such_code, no_such_code, no_such_code}};
    if (low > high) return codes;
    codes.valid_min = static_cast<std::uint32_t>(low);
    codes.valid_span = static_cast<std::uint32_t>(high - low);
    static_assert(DepthCoding::max_invalid_codes == std::size(decltype(codes.excluded){}));
    for (int k = 0, count = 0; k < coding.invalid_code_count; ++k) {
        const int code = coding.invalid_codes[static_cast<std::size_t>(k)];
        if (code > low && code < high) codes.excluded[count++] = static_cast<std::uint32_t>(code);
    }
    return codes;
}

/// A program, when it is first asked for.
Result<GpuProgram> SurfaceKernels::made(GpuProgram& kept, const char* name,
                                        std::span<const std::uint32_t> spirv, GpuLayout layout,
                                        std::span<const std::uint32_t> constants) {
    if (kept) return kept;
    auto program = GpuProgram::create(*device_, name, spirv, std::move(layout), constants);
    if (program.ok()) kept = *program;
    return program;
}

Result<GpuProgram> SurfaceKernels::strip(StripKernel kernel, const StripConstants& c) {
    const auto constants = std::bit_cast<Constants>(c);
    GpuLayout layout{sizeof(StripPush), {texels, buffer}, {c.group_size, 1, 1}};
    layout.bindings.insert(layout.bindings.end(), kernel == StripKernel::fill_holes ? 1 : 4, buffer);
    const KernelSource source = source_of(kernel);
    return made(strips_[{kernel, constants}], source.name, source.spirv, std::move(layout), constants);
}

Result<GpuProgram> SurfaceKernels::terraces(std::uint32_t group_size, int step, bool is_last,
                                            bool has_levels) {
    const std::array<std::uint32_t, 4> constants{group_size, static_cast<std::uint32_t>(step),
                                                 is_last ? 1U : 0U, has_levels ? 1U : 0U};
    return made(terraces_[constants], "terraces", terraces_spv,
                {sizeof(TerracesPush), {texels, texels, buffer}, {group_size, 1, 1}}, constants);
}

Result<GpuProgram> SurfaceKernels::flying_pixels(std::uint32_t sample_bytes) {
    const std::array<std::uint32_t, 1> constants{sample_bytes};
    return made(flying_pixels_[sample_bytes - 1], "flying_pixels", flying_pixels_spv,
                {sizeof(FlyingPixelsPush), {texels, buffer}, {flying_pixels_group, 1, 1}}, constants);
}

Result<GpuProgram> SurfaceKernels::temporal() {
    return made(temporal_, "temporal", temporal_spv,
                {sizeof(TemporalPush), {texels, texels, buffer, buffer}, {temporal_group, 1, 1}});
}

Result<GpuProgram> SurfaceKernels::tile_bounds() {
    return made(
        tile_bounds_, "tile_bounds", tile_bounds_spv,
        {sizeof(TileBoundsPush), {texels, texels, buffer, buffer, buffer}, {tile_bounds_group, 1, 1}});
}

Result<GpuProgram> SurfaceKernels::hue_codes() {
    return made(hue_codes_, "hue_codes", hue_codes_spv,
                {sizeof(HueCodesPush), {buffer, buffer}, {hue_codes_group, 1, 1}});
}

}  // namespace touchable
