// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/surface_recording.hpp"

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "shaders/block.spv.h"
#include "shaders/decode.spv.h"
#include "shaders/fill_holes.spv.h"
#include "shaders/flying_pixels.spv.h"
#include "shaders/hue_codes.spv.h"
#include "shaders/median3.spv.h"
#include "shaders/median5.spv.h"
#include "shaders/pack_rows.spv.h"
#include "shaders/temporal.spv.h"
#include "shaders/terraces.spv.h"
#include "shaders/tile_bounds.spv.h"

namespace touchable {

namespace {

static_assert(no_hue_code == no_hue);
static_assert(no_finer_code > 2 * terrace_range);
static_assert(most_ramp_steps == widest_ramp && most_ramp_steps == flying_reach);

/// A kernel, how many buffers of texels and then of other content it is bound to, and its workgroup's size;
/// 0: the first specialisation constant.
struct KernelForm {
    const char* name;
    std::span<const std::uint32_t> spirv;
    std::uint32_t push_bytes;
    std::size_t texels, buffers;
    std::uint32_t group_x, group_y = 1;
};
/// By SurfaceKernel.
const KernelForm forms[] = {
    {"decode", decode_spv, sizeof(StripPush), 1, 4, 0},
    {"median3", median3_spv, sizeof(StripPush), 1, 4, 0},
    {"median5", median5_spv, sizeof(StripPush), 1, 4, 0},
    {"fill_holes", fill_holes_spv, sizeof(StripPush), 1, 2, 0},
    {"block", block_spv, sizeof(BlockPush), 0, 5, block_lanes_x, block_lanes_y},
    {"terraces", terraces_spv, sizeof(TerracesPush), 2, 1, 0},
    {"flying_pixels", flying_pixels_spv, sizeof(FlyingPixelsPush), 1, 1, flying_pixels_group},
    {"temporal", temporal_spv, sizeof(TemporalPush), 2, 2, temporal_group},
    {"tile_bounds", tile_bounds_spv, sizeof(TileBoundsPush), 2, 2, tile_bounds_group},
    {"hue_codes", hue_codes_spv, sizeof(HueCodesPush), 0, 2, hue_codes_group},
    {"pack_rows", pack_rows_spv, sizeof(PackRowsPush), 0, 2, pack_rows_group},
};

static_assert(sizeof(TileBounds) == 8 && offsetof(TileBounds, least) == 0 &&
              offsetof(TileBounds, greatest) == 2 && offsetof(TileBounds, any_invalid) == 4);

/// All but no_finer_code.
constexpr ValidCodes finer_codes{
    0, no_finer_code - 1, {no_such_code, no_such_code, no_such_code, no_such_code}};

CurvePush pushed(const CodeCurve& curve) {
    return {curve.constant,           curve.linear, curve.quadratic,
            curve.falls ? 1U : 0U,    curve.last,   static_cast<std::uint32_t>(curve.shift),
            curve.from_last ? 1U : 0U};
}

Error more_than_the_device_can(const Scene& scene, const GpuDevice& device, const char* what) {
    return gpu_error("frames of " + size_text(scene.width, scene.height) + " are larger than " + what +
                     " may be on " + device.facts().name);
}

}  // namespace

SurfacePlan plan_for(const GpuFacts& facts) {
    const char* asked = std::getenv("TOUCHABLE_GPU_PLAN");
    const bool is_asked = asked && std::string_view(asked) == "discrete";
    if (facts.kind == GpuKind::software && !is_asked) return {};
    SurfacePlan plan{64, 4, true};
    plan.copies = !facts.unified_memory || is_asked;
    plan.blocks = facts.limits.max_group_invocations >= block_lanes_x * block_lanes_y;
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

Result<GpuProgram> SurfaceKernels::program(SurfaceKernel kernel, std::vector<std::uint32_t> constants) {
    GpuProgram& program = programs_[{kernel, constants}];
    if (program) return program;
    const KernelForm& form = forms[static_cast<std::size_t>(kernel)];
    GpuLayout layout{form.push_bytes,
                     std::vector(form.texels, GpuBindingKind::uniform_texels),
                     {form.group_x > 0 ? form.group_x : constants.front(), form.group_y, 1}};
    layout.bindings.resize(form.texels + form.buffers, GpuBindingKind::storage_buffer);
    TRY_ASSIGN(program, GpuProgram::create(*device_, form.name, form.spirv, std::move(layout), constants));
    return program;
}

SurfaceRecording::SurfaceRecording(const Scene& scene, std::shared_ptr<SurfaceKernels> kernels,
                                   const SurfacePlan& plan)
    : scene_(scene),
      kernels_(std::move(kernels)),
      plan_(plan),
      filters_(scene),
      valid_(valid_codes_of(scene.depth)),
      width_(static_cast<std::uint32_t>(scene.width)),
      height_(static_cast<std::uint32_t>(scene.height)),
      pitch_(groups_for(width_, 8)),
      strips_(groups_for(height_, 2)),
      segment_texels_(plan.segment_texels > 0 ? plan.segment_texels : pitch_),
      segments_(groups_for(pitch_, segment_texels_)),
      grid_(TileGrid::of(scene.width, scene.height)) {}

Result<SurfaceRecording> SurfaceRecording::create(const Scene& scene, std::shared_ptr<SurfaceKernels> kernels,
                                                  const SurfacePlan& plan) {
    SurfaceRecording recording(scene, std::move(kernels), plan);
    TRY(recording.check_limits());
    TRY(recording.make_buffers());
    return recording;
}

bool SurfaceRecording::has_room_above() const {
    return filters_.find<TerraceFilter>() != nullptr || valid_.valid_min + valid_.valid_span < no_finer_code;
}

Result<void> SurfaceRecording::check_limits() const {
    if (filters_.remembers() && !has_room_above() && valid_.valid_min == 0 &&
        valid_.excluded[0] != no_such_code)
        return Error{ErrorKind::gpu,
                     "the vulkan builder cannot filter in time (filter.temporal is on) where depth.invalid "
                     "names some of 65536 codes but neither 0 nor 65535; must be the cpu builder"};
    const GpuFacts::Limits& limits = device().facts().limits;
    // Hue has three channels.
    const std::size_t most_bytes = std::size_t{is_hue() ? 24U : 16U} * pitch_ * height_;
    if (most_bytes / 16 > limits.max_texel_buffer_elements || most_bytes > limits.max_storage_buffer_range)
        return more_than_the_device_can(scene_, device(), "a buffer");
    const std::uint32_t most_groups = std::max(
        {groups_for((filters_.find<TerraceFilter>() ? height_ : strips_) * segments_, plan_.group_size),
         groups_for(pitch_, hue_codes_group),
         plan_.packs_rows(scene_.width) ? groups_for(width_ * height_, 2 * pack_rows_group) : 0U});
    if (most_groups > limits.max_group_count[0] || height_ > limits.max_group_count[1])
        return more_than_the_device_can(scene_, device(), "a dispatch");
    return {};
}

Result<void> SurfaceRecording::make_buffers() {
    const std::size_t codes_bytes = std::size_t{16} * pitch_ * height_;
    const FilterPlan::HoleFilling* filling = filters_.find<FilterPlan::HoleFilling>();
    const bool fills = filling != nullptr, levels = filters_.find<TerraceFilter>() != nullptr,
               smooths = filters_.find<TemporalFilter>() != nullptr,
               lands = filters_.find<FlyingPixels>() != nullptr;
    const std::tuple<GpuBuffer&, const char*, std::size_t> buffers[] = {
        {parts_, "parts of bounds",
         plan_.blocks ? 0 : std::size_t{strips_} * groups_for(width_, 32) * tile_pair_bytes},
        {between_[0], "codes between stages", is_hue() || fills || levels || lands ? codes_bytes : 0},
        {between_[1], "codes between passes", fills || levels || (is_hue() && lands) ? codes_bytes : 0},
        {finer_, "finer codes", levels || smooths ? codes_bytes : 0},
        {remembered_[0], "codes remembered", smooths ? codes_bytes : 0},
        {remembered_[1], "codes remembered before", smooths ? codes_bytes : 0},
        {packed_, "codes without gaps", packs_rows() ? std::size_t{2} * width_ * height_ : 0},
        {held_, "frames held", smooths ? codes_bytes / 4 : 0},
        {fill_passes_, "passes of hole filling",
         fills ? sizeof(FillPass) * static_cast<std::size_t>(filling->passes + 1) : 0}};
    for (const auto& [buffer, name, bytes] : buffers) {
        if (bytes == 0) continue;
        TRY_ASSIGN(buffer, GpuBuffer::create(device(), name, bytes, GpuMemory::device));
    }
    return make_table();
}

/// Makes the table of the filter that looks codes up: the temporal one, which is first, or terrace removal.
Result<void> SurfaceRecording::make_table() {
    const auto* temporal = filters_.find<TemporalFilter>();
    const auto* terraces = filters_.find<TerraceFilter>();
    const auto table = temporal ? temporal->working.table : terraces ? terraces->working.table : nullptr;
    if (!table) return {};
    TRY_ASSIGN(table_, GpuBuffer::create(device(), "working codes", table->size() * sizeof(table->front()),
                                         GpuMemory::upload));
    std::copy(table->begin(), table->end(), table_.mapped<std::uint16_t>().begin());
    return {};
}

Result<void> SurfaceRecording::record(GpuCommands& commands, const StoredRows& stored, bool begins,
                                      const VulkanPlanes& planes) {
    Frame frame{commands, begins, planes, stored};
    if (is_hue()) TRY(record_hue(frame));
    for (const FilterPlan::Stage& stage : filters_.filters)
        TRY(std::visit([&](const auto& filter) { return record(filter, frame); }, stage.filter));
    TRY(record_codes(frame, nullptr, planes.codes.gpu));
    if (packs_rows()) TRY(record_packing(frame));
    return plan_.blocks ? Result<void>() : record_bounds(frame);
}

StripPush SurfaceRecording::push_for(const StoredRows& rows) const {
    StripPush push{};
    push.width = width_;
    push.height = height_;
    push.in_pitch = rows.pitch;
    push.out_pitch = pitch_;
    push.segment_texels = segment_texels_;
    push.segments = segments_;
    push.along_x = plan_.along_x ? 1 : 0;
    push.validity_words = groups_for(width_, 32);
    push.valid = rows.valid;
    push.groups = groups_for(strips_ * segments_, plan_.group_size);
    return push;
}

Result<GpuProgram> SurfaceRecording::program_for(SurfaceKernel kernel, const StoredRows& rows,
                                                 const WorkingCodes* working) {
    return kernels_->program(kernel, {plan_.group_size, rows.sample_bytes, rows.may_be_invalid() ? 1U : 0U,
                                      rows.valid.excluded[0] != no_such_code ? 1U : 0U,
                                      width_ % 8 != 0 || height_ % 2 != 0 ? 1U : 0U, working ? 1U : 0U,
                                      working && working->table ? 1U : 0U});
}

/// Records the kernel that makes codes, validity and bounds or parts of them. With `working` it makes working
/// codes, and only validity is final.
Result<void> SurfaceRecording::record_codes(Frame& frame, const WorkingCodes* working, const GpuBuffer& to) {
    TRY(plan_.blocks ? record_block(frame, working, to) : record_strips(frame, working, to));
    frame.commands.barrier(GpuStage::compute, GpuStage::compute);
    frame.commands.mark(frame.kernel == SurfaceKernel::decode ? "decode" : "median");
    return {};
}

Result<void> SurfaceRecording::record_block(Frame& frame, const WorkingCodes* working, const GpuBuffer& to) {
    const StoredRows& rows = frame.rows;
    constexpr std::uint32_t sides[] = {1, 3, 5};  // by SurfaceKernel
    TRY_ASSIGN(
        const auto program,
        kernels_->program(SurfaceKernel::block,
                          {sides[static_cast<std::size_t>(frame.kernel)], rows.sample_bytes,
                           rows.may_be_invalid() ? 1U : 0U, rows.valid.excluded[0] != no_such_code ? 1U : 0U,
                           working ? 1U : 0U, working && working->table ? 1U : 0U}));
    const BlockPush push{width_,
                         height_,
                         rows.pitch,
                         pitch_,
                         groups_for(width_, 32),
                         static_cast<std::uint32_t>(grid_.tiles_x),
                         static_cast<std::uint32_t>(grid_.tiles_y),
                         working ? static_cast<std::uint32_t>(working->factor) : 1,
                         rows.valid};
    const VulkanPlanes& planes = frame.planes;
    frame.commands.dispatch(
        program, push,
        {rows.buffer, to, planes.validity.gpu, planes.tiles.gpu, table_ ? table_ : planes.tiles.gpu},
        {groups_for(width_, block_width), groups_for(height_, block_height)});
    return {};
}

Result<void> SurfaceRecording::record_strips(Frame& frame, const WorkingCodes* working, const GpuBuffer& to) {
    TRY_ASSIGN(const auto program, program_for(frame.kernel, frame.rows, working));
    StripPush push = push_for(frame.rows);
    push.factor = working ? static_cast<std::uint32_t>(working->factor) : 1;
    frame.commands.dispatch(
        program, push, {frame.rows.buffer, to, frame.planes.validity.gpu, parts_, table_ ? table_ : parts_},
        {push.groups});
    return {};
}

/// Records working codes, unless they are there already.
Result<void> SurfaceRecording::record_finer(const WorkingCodes& working, Frame& frame) {
    if (std::exchange(frame.is_finer, true)) return {};
    TRY(record_codes(frame, has_room_above() ? &working : nullptr, finer_));
    frame.rows = {finer_, 2, pitch_, finer_codes};
    frame.kernel = SurfaceKernel::decode;
    return {};
}

Result<void> SurfaceRecording::record(const FilterPlan::MedianWindow& window, Frame& frame) {
    frame.kernel = window.side == 3 ? SurfaceKernel::median3 : SurfaceKernel::median5;
    return {};
}

/// The filter's input and output change places from frame to frame.
Result<void> SurfaceRecording::record(const TemporalFilter& filter, Frame& frame) {
    TRY(record_finer(filter.working, frame));
    TRY_ASSIGN(const auto program, kernels_->program(SurfaceKernel::temporal));
    ValidCodes valid = finer_codes;
    if (!has_room_above()) {
        valid.valid_min = valid_.valid_min;
        valid.valid_span = valid_.valid_span;
    }
    const TemporalPush push{
        height_, pitch_, frame.begins ? 1U : 0U, pushed(filter.gate), has_room_above() ? no_finer_code : 0,
        valid};
    std::swap(remembered_[0], remembered_[1]);
    frame.commands.dispatch(program, push, {frame.rows.buffer, remembered_[1], remembered_[0], held_},
                            {groups_for(pitch_, temporal_group), height_});
    frame.commands.barrier(GpuStage::compute, GpuStage::compute);
    frame.commands.mark("temporal");
    frame.rows = {remembered_[0], 2, pitch_, valid};
    return {};
}

Result<void> SurfaceRecording::record(const TerraceFilter& filter, Frame& frame) {
    TRY(record_finer(filter.working, frame));
    const TerracesPush push{width_,
                            height_,
                            pitch_,
                            segments_,
                            segment_texels_,
                            plan_.along_x ? 1U : 0U,
                            pushed(filter.steps),
                            pushed(filter.levels),
                            static_cast<std::uint32_t>(filter.fraction),
                            static_cast<std::uint32_t>(filter.step),
                            static_cast<std::uint32_t>(filter.noise)};
    const GpuBuffer first = frame.rows.buffer;
    GpuBuffer from = first;
    for (int pass = 0; pass < filter.passes(); ++pass) {
        const bool is_last = pass + 1 == filter.passes();
        TRY_ASSIGN(const auto program,
                   kernels_->program(SurfaceKernel::terraces,
                                     {plan_.group_size, static_cast<std::uint32_t>(filter.tap_of(pass)),
                                      is_last ? 1U : 0U, filter.is_even() ? 0U : 1U}));
        const GpuBuffer& to = between_[pass % 2];
        frame.commands.dispatch(program, push, {from, first, to},
                                {groups_for(height_ * segments_, plan_.group_size)});
        frame.commands.barrier(GpuStage::compute, GpuStage::compute);
        from = to;
    }
    frame.commands.mark("terraces");
    frame.rows = {from, 2, pitch_, finer_codes};
    return {};
}

Result<void> SurfaceRecording::record_hue(Frame& frame) {
    TRY_ASSIGN(auto program, kernels_->program(SurfaceKernel::hue_codes));
    const HueCodesPush push{width_, height_, frame.rows.pitch * 4, pitch_,
                            static_cast<std::uint32_t>(scene_.depth.least_sum)};
    frame.commands.dispatch(program, push, {frame.rows.buffer, between_[0]},
                            {groups_for(pitch_, hue_codes_group), height_});
    frame.commands.barrier(GpuStage::compute, GpuStage::compute);
    frame.commands.mark("hue");
    frame.rows = {between_[0], 2, pitch_, valid_};
    return {};
}

Result<void> SurfaceRecording::record(const FlyingPixels& filter, Frame& frame) {
    StoredRows& rows = frame.rows;
    TRY_ASSIGN(const auto program, kernels_->program(SurfaceKernel::flying_pixels, {rows.sample_bytes}));
    const GpuBuffer& to = between_[rows.buffer.handle() == between_[0].handle() ? 1 : 0];
    const FlyingPixelsPush push{width_, height_, rows.pitch, pitch_, pushed(filter.gate), rows.valid};
    frame.commands.dispatch(program, push, {rows.buffer, to},
                            {groups_for(pitch_, flying_pixels_group), height_});
    frame.commands.barrier(GpuStage::compute, GpuStage::compute);
    frame.commands.mark("flying pixels");
    rows = {to, 2, pitch_, valid_};
    return {};
}

/// A pass that fills no hole leaves both buffers alike, so that all passes after it are skipped, except for
/// the second: the first one does not read from these buffers.
Result<void> SurfaceRecording::record(const FilterPlan::HoleFilling& filling, Frame& frame) {
    StoredRows& rows = frame.rows;
    if (!rows.may_be_invalid()) return {};
    GpuCommands& commands = frame.commands;
    commands.fill(fill_passes_, 0);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    for (int pass = 0; pass < filling.passes; ++pass) {
        const GpuBuffer& to = between_[rows.buffer.handle() == between_[0].handle() ? 1 : 0];
        TRY_ASSIGN(const auto program, program_for(SurfaceKernel::fill_holes, rows));
        StripPush push = push_for(rows);
        push.pass = static_cast<std::uint32_t>(pass);
        if (pass < 2)
            commands.dispatch(program, push, {rows.buffer, to, fill_passes_}, {push.groups});
        else
            commands.dispatch_indirect(program, push, {rows.buffer, to, fill_passes_}, fill_passes_,
                                       sizeof(FillPass) * push.pass);
        commands.barrier(GpuStage::compute, GpuStage::compute);
        commands.barrier(GpuStage::compute, GpuStage::indirect);
        rows = {to, 2, pitch_, valid_};
    }
    commands.mark("fill");
    return {};
}

Result<void> SurfaceRecording::record_packing(const Frame& frame) {
    TRY_ASSIGN(const auto program, kernels_->program(SurfaceKernel::pack_rows));
    const PackRowsPush push{width_, width_ * height_, 4 * pitch_};
    frame.commands.dispatch(program, push, {frame.planes.codes.gpu, packed_},
                            {groups_for(groups_for(push.count, 2), pack_rows_group)});
    return {};
}

Result<void> SurfaceRecording::record_bounds(const Frame& frame) {
    const VulkanPlanes& planes = frame.planes;
    TRY_ASSIGN(auto program, kernels_->program(SurfaceKernel::tile_bounds));
    const TileBoundsPush push{width_,
                              height_,
                              pitch_,
                              groups_for(width_, 32),
                              strips_,
                              static_cast<std::uint32_t>(grid_.tiles_x),
                              static_cast<std::uint32_t>(grid_.tiles_y)};
    frame.commands.dispatch(program, push, {parts_, planes.codes.gpu, planes.validity.gpu, planes.tiles.gpu},
                            {groups_for(push.words * push.tiles_y, tile_bounds_group)});
    frame.commands.mark("bounds");
    return {};
}

}  // namespace touchable
