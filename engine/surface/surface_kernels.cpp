#include "engine/surface/surface_kernels.hpp"

#include <algorithm>
#include <bit>

#include "engine/frame/stored_code.hpp"
#include "engine/scene/terraces.hpp"
#include "shaders/decode.spv.h"
#include "shaders/fill_holes.spv.h"
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

Result<GpuProgram> SurfaceKernels::strip(StripKernel kernel, const StripConstants& c) {
    const auto constants = std::bit_cast<Constants>(c);
    GpuProgram& program = strips_[{kernel, constants}];
    if (program) return program;
    GpuLayout layout{sizeof(StripPush), {texels, buffer}, {c.group_size, 1, 1}};
    layout.bindings.insert(layout.bindings.end(), kernel == StripKernel::fill_holes ? 1 : 3, buffer);
    const KernelSource source = source_of(kernel);
    auto made = GpuProgram::create(*device_, source.name, source.spirv, std::move(layout), constants);
    if (made.ok()) program = *made;
    return made;
}

Result<GpuProgram> SurfaceKernels::terraces(std::uint32_t group_size, int step, bool is_last) {
    const std::array<std::uint32_t, 3> constants{group_size, static_cast<std::uint32_t>(step),
                                                 is_last ? 1U : 0U};
    GpuProgram& program = terraces_[constants];
    if (program) return program;
    auto made =
        GpuProgram::create(*device_, "terraces", terraces_spv,
                           {sizeof(TerracesPush), {texels, texels, buffer}, {group_size, 1, 1}}, constants);
    if (made.ok()) program = *made;
    return made;
}

Result<GpuProgram> SurfaceKernels::temporal() {
    if (temporal_) return temporal_;
    auto made =
        GpuProgram::create(*device_, "temporal", temporal_spv,
                           {sizeof(TemporalPush), {texels, texels, buffer, buffer}, {temporal_group, 1, 1}});
    if (made.ok()) temporal_ = *made;
    return made;
}

Result<GpuProgram> SurfaceKernels::tile_bounds() {
    if (tile_bounds_) return tile_bounds_;
    auto made = GpuProgram::create(
        *device_, "tile_bounds", tile_bounds_spv,
        {sizeof(TileBoundsPush), {texels, texels, buffer, buffer, buffer}, {tile_bounds_group, 1, 1}});
    if (made.ok()) tile_bounds_ = *made;
    return made;
}

Result<GpuProgram> SurfaceKernels::hue_codes() {
    if (hue_codes_) return hue_codes_;
    auto made = GpuProgram::create(*device_, "hue_codes", hue_codes_spv,
                                   {sizeof(HueCodesPush), {buffer, buffer}, {hue_codes_group, 1, 1}});
    if (made.ok()) hue_codes_ = *made;
    return made;
}

}  // namespace touchable
