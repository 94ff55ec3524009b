#include "engine/surface/vulkan_builder.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstring>
#include <utility>

#include "engine/scene/temporal.hpp"
#include "engine/scene/terraces.hpp"
#include "engine/surface/block_list.hpp"
#include "engine/surface/raw_check.hpp"
#include "engine/surface/vulkan_vertices.hpp"

namespace touchable {
namespace {

static_assert(sizeof(TileBounds) == 8 && offsetof(TileBounds, least) == 0 &&
              offsetof(TileBounds, greatest) == 2 && offsetof(TileBounds, any_invalid) == 4);

std::uint32_t whole(std::uint32_t count, std::uint32_t size) {
    return groups_for(count, size);
}

/// Where a strip kernel reads from: stored values or codes, in rows of whole texels.
struct StoredRows {
    GpuBuffer buffer;
    std::uint32_t sample_bytes = 2, pitch = 0, start = 0;  ///< texels from row to row, and before the first
    ValidCodes valid;

    bool may_be_invalid() const {
        return valid.valid_min > 0 || valid.valid_span < (sample_bytes == 1 ? 255U : 65535U) ||
               valid.excluded[0] != no_such_code;
    }
};

/// All but no_finer_code.
constexpr ValidCodes finer_codes{
    0, no_finer_code - 1, {no_such_code, no_such_code, no_such_code, no_such_code}};

/// Blocks that a lane marches along at most, where it marches along whole rows of whole frames: not so many
/// that one core waits for another.
constexpr int longest_run = 8;

/// Whether no_finer_code is beyond all codes, so that it can stand for what is invalid.
bool leaves_room_above(const ValidCodes& valid) {
    return valid.valid_min + valid.valid_span < no_finer_code;
}

class Builder final : public VulkanSurfaceBuilder {
public:
    Builder(const Scene& scene, std::shared_ptr<SurfaceKernels> kernels, const SurfacePlan& plan)
        : scene_(scene),
          kernels_(std::move(kernels)),
          plan_(plan),
          temporal_(temporal_filter(scene)),
          terraces_(terrace_filter(scene)),
          valid_(valid_codes_of(scene.depth)),
          width_(static_cast<std::uint32_t>(scene.width)),
          height_(static_cast<std::uint32_t>(scene.height)),
          pitch_(whole(width_, 8)),
          strips_(whole(height_, 2)),
          grid_(TileGrid::of(scene.width, scene.height)) {
        assert(scene.filter.median == 0 || scene.filter.median == 3 || scene.filter.median == 5);
    }

    std::string_view name() const override { return "vulkan"; }
    const std::vector<GpuTime>& stages() const override { return stages_; }
    double built_share() const override { return list_ ? list_->share() : 0; }
    Result<void> reserve();
    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override;

private:
    const GpuDevice& device() const { return *kernels_->device(); }
    bool is_hue() const { return scene_.depth.kind == DepthCodingKind::hue; }
    std::size_t codes_bytes() const { return std::size_t{16} * pitch_ * height_; }

    Result<VulkanVertices*> slot_of(SurfaceFrame& out) const;
    std::optional<int> reach() const;
    Result<void> build_listed(const RawFrame& raw, BuildNumber held, const VulkanVertices& slot);
    Result<StoredRows> import(const RawFrame& raw) const;
    bool is_importable(const PlaneView& depth) const;
    Result<StoredRows> upload(const PlaneView& depth, BuildNumber held);
    Result<void> record(GpuCommands& commands, StoredRows rows, bool begins, const VulkanVertices& slot);
    /// Otherwise 0 stands for what is invalid, as in the end: that is free then, and codes are not
    /// multiplied.
    bool has_room_above() const { return terraces_ || leaves_room_above(valid_); }
    StripPush push_for(const StoredRows& rows) const;
    Result<GpuProgram> program_for(StripKernel kernel, const StoredRows& rows, bool before_terraces = false);
    Result<void> record_codes(GpuCommands& commands, int median, const StoredRows& rows, bool before_terraces,
                              const GpuBuffer& to, const VulkanVertices& slot);
    Result<StoredRows> record_temporal(GpuCommands& commands, bool begins);
    Result<StoredRows> record_terraces(GpuCommands& commands, const GpuBuffer& finer);
    Result<StoredRows> record_hue(GpuCommands& commands, const StoredRows& rows);
    Result<StoredRows> record_filling(GpuCommands& commands, StoredRows rows);
    Result<void> record_bounds(GpuCommands& commands, const VulkanVertices& slot);
    void record_reading_back(GpuCommands& commands, const VulkanVertices& slot) const;
    void show(const VulkanVertices& slot, SurfaceFrame& out) const;

    Scene scene_;
    std::shared_ptr<SurfaceKernels> kernels_;
    SurfacePlan plan_;
    std::optional<TemporalFilter> temporal_;
    std::optional<TerraceFilter> terraces_;
    ValidCodes valid_;
    std::uint32_t width_, height_, pitch_, strips_;  // pitch in texels, of codes
    TileGrid grid_;
    std::optional<BlockList> list_;  // once there are buffers
    GpuBuffer upload_, stored_;  // as the CPU writes it; in the GPU's own memory where that is not the same
    BuildNumber uploaded_ = 0;   // which frame they hold
    RowRange upload_rows_;       // of it, that were written last
    GpuBuffer between_[2];       // codes between stages
    GpuBuffer finer_;            // codes before they are filtered in time, or terraces are removed
    GpuBuffer remembered_[2];    // codes filtered in time, of the last frame and of the one before
    GpuBuffer held_;             // for how many frames codes have only been held
    GpuBuffer fill_passes_;      // which passes of hole filling have something to do
    GpuBuffer parts_;            // of tile bounds
    std::optional<std::int64_t> last_;  // number of the frame that is remembered
    std::vector<GpuTime> stages_;
};

/// The buffers that do not depend on the form of the frames.
Result<void> Builder::reserve() {
    const GpuLimits& limits = device().facts().limits;
    const std::size_t most = std::max(codes_bytes(), std::size_t{24} * pitch_ * height_ * (is_hue() ? 1 : 0));
    if (most / 16 > limits.max_texel_buffer_elements || most > limits.max_storage_buffer_range)
        return Error{ErrorKind::gpu, "frames of " + std::to_string(width_) + "x" + std::to_string(height_) +
                                         " are larger than a buffer may be on " + device().facts().name};
    const bool fills = scene_.filter.fill_holes > 0, levels = terraces_.has_value();
    const std::tuple<GpuBuffer&, const char*, std::size_t> buffers[] = {
        {parts_, "parts of bounds", std::size_t{strips_} * whole(width_, 32) * tile_pair_bytes},
        {between_[0], "codes between stages", is_hue() || fills || levels ? codes_bytes() : 0},
        {between_[1], "codes between passes", fills || levels ? codes_bytes() : 0},
        {finer_, "finer codes", levels || temporal_ ? codes_bytes() : 0},
        {remembered_[0], "codes remembered", temporal_ ? codes_bytes() : 0},
        {remembered_[1], "codes remembered before", temporal_ ? codes_bytes() : 0},
        {held_, "frames held", temporal_ ? codes_bytes() / 4 : 0},
        {fill_passes_, "passes of hole filling",
         fills ? sizeof(FillPass) * static_cast<std::size_t>(scene_.filter.fill_holes + 1) : 0}};
    for (const auto& [buffer, name, bytes] : buffers) {
        if (bytes == 0) continue;
        auto created = GpuBuffer::create(device(), name, bytes, GpuMemory::device);
        if (!created.ok()) return created.error();
        buffer = *created;
    }
    const int run = plan_.segment_texels > 0 ? static_cast<int>(whole(plan_.segment_texels, 4)) : longest_run;
    auto list = BlockList::create(device(), scene_.width, scene_.height, reach(), plan_.break_even, run);
    if (!list.ok()) return list.error();
    list_.emplace(std::move(*list));
    return {};
}

/// Of the filters that one kernel does; what others leave between stages is only of the frame they were at
/// last.
std::optional<int> Builder::reach() const {
    if (is_hue() || scene_.filter.fill_holes > 0 || temporal_ || terraces_) return std::nullopt;
    return scene_.filter.median / 2;
}

Result<void> Builder::build(const RawFrame& raw, SurfaceFrame& out) {
    if (auto checked = check_raw_frame(raw, scene_); !checked) return checked;
    const auto slot = slot_of(out);
    if (!slot.ok()) return slot.error();
    const BuildNumber held = std::exchange((*slot)->build, 0);
    list_->advance(raw, held);
    if (auto built = build_listed(raw, held, **slot); !built.ok()) return built;
    list_->done();
    show(**slot, out);
    if (!list_->same_touch_planes(held)) copy_touch_planes(raw, out);
    (*slot)->build = list_->newest();
    return {};
}

/// The slot's memory, new where it has none that serves.
Result<VulkanVertices*> Builder::slot_of(SurfaceFrame& out) const {
    auto* slot = dynamic_cast<VulkanVertices*>(out.vertices.get());
    if (slot != nullptr && slot->read_from() == &out &&
        slot->serves(device(), scene_.width, scene_.height, plan_.copies))
        return slot;
    auto created = VulkanVertices::create(device(), out, scene_.width, scene_.height, plan_.copies);
    if (!created.ok()) return created.error();
    slot = created->get();
    out.vertices = std::move(*created);
    return slot;
}

Result<void> Builder::build_listed(const RawFrame& raw, BuildNumber held, const VulkanVertices& slot) {
    stages_.clear();
    if (!list_->all() && list_->count() == 0) {
        if (uploaded_ >= held) uploaded_ = list_->newest();
        return {};
    }
    auto rows = is_importable(raw.depth) ? import(raw) : upload(raw.depth, held);
    if (!rows.ok()) return rows.error();
    auto commands = GpuCommands::begin(kernels_->device(), "surface");
    if (!commands.ok()) return commands.error();
    const bool begins = !last_ || *last_ + 1 != raw.number;
    last_.reset();  // until all of it is done
    if (auto recorded = record(*commands, *rows, begins, slot); !recorded.ok()) return recorded;
    const auto submission = std::move(*commands).submit();
    if (!submission.ok()) return submission.error();
    if (auto done = submission->wait(); !done.ok()) return done;
    last_ = raw.number;
    stages_ = submission->times();
    return {};
}

/// A software Vulkan reads where the planes lie, in whole pages, if rows are whole texels.
bool Builder::is_importable(const PlaneView& depth) const {
    const auto address = reinterpret_cast<std::uintptr_t>(depth.data);
    return device().facts().kind == GpuKind::software && device().facts().import_alignment > 0 &&
           !plan_.copies && !is_hue() && address % 16 == 0 && depth.stride > 0 && depth.stride % 16 == 0;
}

Result<StoredRows> Builder::import(const RawFrame& raw) const {
    const PlaneView& depth = raw.depth;
    const std::uintptr_t page = device().facts().import_alignment;
    const auto address = reinterpret_cast<std::uintptr_t>(depth.data);
    const std::uintptr_t first = address / page * page;
    const std::size_t row_bytes = std::size_t{width_} * static_cast<std::size_t>(depth.bytes_per_sample),
                      end = address + (height_ - 1) * static_cast<std::size_t>(depth.stride) + row_bytes;
    std::byte* const memory = const_cast<std::byte*>(reinterpret_cast<const std::byte*>(depth.data)) -
                              static_cast<std::ptrdiff_t>(address - first);
    auto buffer = GpuBuffer::import(device(), "stored values",
                                    {memory, (end - first + page - 1) / page * page}, raw.storage);
    if (!buffer.ok()) return buffer.error();
    return StoredRows{*buffer, static_cast<std::uint32_t>(depth.bytes_per_sample),
                      static_cast<std::uint32_t>(depth.stride / 16),
                      static_cast<std::uint32_t>((address - first) / 16), valid_};
}

/// The rows of a plane, one after the other from texel to texel; of a frame that has changed in part, and if
/// what was there before is as new as the slot, those that have.
Result<StoredRows> Builder::upload(const PlaneView& depth, BuildNumber held) {
    const std::size_t row_bytes = std::size_t{width_} * static_cast<std::size_t>(depth.channels) *
                                  static_cast<std::size_t>(depth.bytes_per_sample);
    // Whole texels, and whole groups of 8 pixels, which is what kernels read.
    const std::size_t group_bytes = std::size_t{8} * static_cast<std::size_t>(depth.channels) *
                                    static_cast<std::size_t>(depth.bytes_per_sample);
    const std::size_t pitch = (group_bytes * pitch_ + 15) / 16 * 16, bytes = pitch * height_;
    BuildNumber there = std::exchange(uploaded_, 0);
    if (!upload_ || upload_.bytes() != bytes) {
        auto mapped = GpuBuffer::create(device(), "stored values", bytes, GpuMemory::upload);
        if (!mapped.ok()) return mapped.error();
        auto own = plan_.copies
                       ? GpuBuffer::create(device(), "stored values of the GPU", bytes, GpuMemory::device)
                       : mapped;
        if (!own.ok()) return own.error();
        upload_ = *mapped;
        stored_ = *own;
        there = 0;
    }
    const bool in_part = !list_->all() && there >= held;
    upload_rows_ = in_part ? list_->rows() : RowRange{0, height_};
    std::byte* to = upload_.mapped<std::byte>().data() + pitch * upload_rows_.first;
    const std::uint8_t* from = depth.row(static_cast<int>(upload_rows_.first));
    if (depth.stride == static_cast<std::ptrdiff_t>(pitch)) {
        std::memcpy(to, from, pitch * upload_rows_.count() - (pitch - row_bytes));
    } else {
        for (std::uint32_t n = 0; n < upload_rows_.count(); ++n, to += pitch, from += depth.stride)
            std::memcpy(to, from, row_bytes);
    }
    uploaded_ = list_->newest();
    return StoredRows{stored_, static_cast<std::uint32_t>(depth.bytes_per_sample),
                      static_cast<std::uint32_t>(pitch / 16), 0, valid_};
}

/// `begins`: nothing is remembered of the frame before.
Result<void> Builder::record(GpuCommands& commands, StoredRows rows, bool begins,
                             const VulkanVertices& slot) {
    if (plan_.copies) {
        const std::size_t row_bytes = upload_.bytes() / height_, first = upload_rows_.first * row_bytes;
        commands.copy(upload_, first, stored_, first, upload_rows_.count() * row_bytes);
        commands.barrier(GpuStage::transfer, GpuStage::compute);
        commands.mark("read in");
    }
    if (is_hue()) {
        auto hues = record_hue(commands, rows);
        if (!hues.ok()) return hues.error();
        rows = *hues;
    }
    if (scene_.filter.fill_holes > 0 && rows.may_be_invalid()) {
        auto filled = record_filling(commands, rows);
        if (!filled.ok()) return filled.error();
        rows = *filled;
    }
    int median = scene_.filter.median;
    if (temporal_ || terraces_) {
        if (auto filtered = record_codes(commands, median, rows, has_room_above(), finer_, slot);
            !filtered.ok())
            return filtered;
        rows = {finer_, 2, pitch_, 0, finer_codes};
        median = 0;
    }
    if (temporal_) {
        auto smoothed = record_temporal(commands, begins);
        if (!smoothed.ok()) return smoothed.error();
        rows = *smoothed;
    }
    if (terraces_) {
        auto levelled = record_terraces(commands, rows.buffer);
        if (!levelled.ok()) return levelled.error();
        rows = *levelled;
    }
    if (auto ended = record_codes(commands, median, rows, false, slot.codes.gpu, slot); !ended.ok())
        return ended;
    if (auto bounded = record_bounds(commands, slot); !bounded.ok()) return bounded;
    if (slot.codes.is_copied()) record_reading_back(commands, slot);
    return {};
}

StripPush Builder::push_for(const StoredRows& rows) const {
    StripPush push{};
    push.width = width_;
    push.height = height_;
    push.in_start = rows.start;
    push.in_pitch = rows.pitch;
    push.out_pitch = pitch_;
    push.segment_texels = plan_.segment_texels > 0 ? plan_.segment_texels : pitch_;
    push.segments = whole(pitch_, push.segment_texels);
    push.along_x = plan_.along_x ? 1 : 0;
    push.validity_words = whole(width_, 32);
    push.groups = whole(strips_ * push.segments, plan_.group_size);
    push.factor = static_cast<std::uint32_t>(temporal_   ? temporal_->factor
                                             : terraces_ ? terraces_->factor
                                                         : 0);
    push.valid = rows.valid;
    push.listed = list_->count();
    if (push.listed > 0) push.groups = whole(push.listed * strips_per_tile, plan_.group_size);
    return push;
}

Result<GpuProgram> Builder::program_for(StripKernel kernel, const StoredRows& rows, bool before_terraces) {
    return kernels_->strip(kernel,
                           {plan_.group_size, rows.sample_bytes, rows.may_be_invalid() ? 1U : 0U,
                            rows.valid.excluded[0] != no_such_code ? 1U : 0U,
                            width_ % 8 != 0 || height_ % 2 != 0 ? 1U : 0U, before_terraces ? 1U : 0U});
}

/// The kernel that ends in codes, validity and parts of bounds. `before_terraces` codes are those that
/// terraces are removed from, and only validity is final.
Result<void> Builder::record_codes(GpuCommands& commands, int median, const StoredRows& rows,
                                   bool before_terraces, const GpuBuffer& to, const VulkanVertices& slot) {
    const StripKernel kernel = median == 0   ? StripKernel::decode
                               : median == 3 ? StripKernel::median3
                                             : StripKernel::median5;
    const auto program = program_for(kernel, rows, before_terraces);
    if (!program.ok()) return program.error();
    const StripPush push = push_for(rows);
    commands.dispatch(*program, push, {rows.buffer, to, slot.validity.gpu, parts_, list_->buffer()},
                      {push.groups});
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.mark(median == 0 ? "decode" : "median");
    return {};
}

/// What the filter reads and writes changes places from frame to frame.
Result<StoredRows> Builder::record_temporal(GpuCommands& commands, bool begins) {
    const auto program = kernels_->temporal();
    if (!program.ok()) return program.error();
    const TemporalGate& gate = temporal_->gate;
    ValidCodes valid = finer_codes;
    if (!has_room_above()) {
        valid.valid_min = valid_.valid_min;
        valid.valid_span = valid_.valid_span;
    }
    const TemporalPush push{height_,
                            pitch_,
                            begins ? 1U : 0U,
                            gate.constant,
                            gate.linear,
                            gate.quadratic,
                            gate.last,
                            static_cast<std::uint32_t>(gate.shift),
                            gate.from_last ? 1U : 0U,
                            has_room_above() ? no_finer_code : 0,
                            valid};
    std::swap(remembered_[0], remembered_[1]);
    commands.dispatch(*program, push, {finer_, remembered_[1], remembered_[0], held_},
                      {whole(pitch_, temporal_group), height_});
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.mark("temporal");
    return StoredRows{remembered_[0], 2, pitch_, 0, valid};
}

Result<StoredRows> Builder::record_terraces(GpuCommands& commands, const GpuBuffer& finer) {
    TerracesPush push{width_,
                      height_,
                      pitch_,
                      1,
                      pitch_,
                      plan_.along_x ? 1U : 0U,
                      static_cast<std::uint32_t>(terraces_->gate),
                      static_cast<std::uint32_t>(terraces_->most)};
    if (plan_.segment_texels > 0) {
        push.segment_texels = plan_.segment_texels;
        push.segments = whole(pitch_, push.segment_texels);
    }
    GpuBuffer from = finer;
    for (std::size_t pass = 0; pass < std::size(terrace_steps); ++pass) {
        const bool is_last = pass + 1 == std::size(terrace_steps);
        const auto program = kernels_->terraces(plan_.group_size, terrace_steps[pass], is_last);
        if (!program.ok()) return program.error();
        const GpuBuffer& to = between_[pass % 2];
        commands.dispatch(*program, push, {from, finer, to},
                          {whole(push.height * push.segments, plan_.group_size)});
        commands.barrier(GpuStage::compute, GpuStage::compute);
        from = to;
    }
    commands.mark("terraces");
    return StoredRows{from, 2, pitch_, 0, finer_codes};
}

Result<StoredRows> Builder::record_hue(GpuCommands& commands, const StoredRows& rows) {
    auto program = kernels_->hue_codes();
    if (!program.ok()) return program.error();
    const HueCodesPush push{width_, height_, rows.pitch * 4, pitch_,
                            static_cast<std::uint32_t>(scene_.depth.least_sum)};
    commands.dispatch(*program, push, {rows.buffer, between_[0]}, {whole(pitch_, hue_codes_group), height_});
    commands.barrier(GpuStage::compute, GpuStage::compute);
    commands.mark("hue");
    return StoredRows{between_[0], 2, pitch_, 0, valid_};
}

/// A pass that fills no hole leaves both buffers alike, so that all after it may be left out, but for the
/// second: what the first one reads is not in these buffers.
Result<StoredRows> Builder::record_filling(GpuCommands& commands, StoredRows rows) {
    commands.fill(fill_passes_, 0);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    for (int pass = 0; pass < scene_.filter.fill_holes; ++pass) {
        const GpuBuffer& to = between_[rows.buffer.handle() == between_[0].handle() ? 1 : 0];
        const auto program = program_for(StripKernel::fill_holes, rows);
        if (!program.ok()) return program.error();
        StripPush push = push_for(rows);
        push.pass = static_cast<std::uint32_t>(pass);
        if (pass < 2)
            commands.dispatch(*program, push, {rows.buffer, to, fill_passes_}, {push.groups});
        else
            commands.dispatch_indirect(*program, push, {rows.buffer, to, fill_passes_}, fill_passes_,
                                       sizeof(FillPass) * push.pass);
        commands.barrier(GpuStage::compute, GpuStage::compute);
        commands.barrier(GpuStage::compute, GpuStage::indirect);
        rows = {to, 2, pitch_, 0, valid_};
    }
    commands.mark("fill");
    return rows;
}

Result<void> Builder::record_bounds(GpuCommands& commands, const VulkanVertices& slot) {
    auto program = kernels_->tile_bounds();
    if (!program.ok()) return program.error();
    const TileBoundsPush push{width_,
                              height_,
                              pitch_,
                              whole(width_, 32),
                              strips_,
                              static_cast<std::uint32_t>(grid_.tiles_x),
                              static_cast<std::uint32_t>(grid_.tiles_y),
                              list_->count()};
    const std::uint32_t pairs = push.listed > 0 ? push.listed : push.words * push.tiles_y;
    commands.dispatch(*program, push,
                      {parts_, slot.codes.gpu, slot.validity.gpu, slot.tiles.gpu, list_->buffer()},
                      {whole(pairs, tile_bounds_group)});
    commands.mark("bounds");
    return {};
}

/// Rows of listed blocks: what a slot holds of others in the GPU's memory it holds in the CPU's.
void Builder::record_reading_back(GpuCommands& commands, const VulkanVertices& slot) const {
    commands.barrier(GpuStage::compute, GpuStage::transfer);
    const auto copy = [&](const SharedPlane& plane, std::uint32_t rows, const RowRange& range) {
        const std::size_t row_bytes = plane.gpu.bytes() / rows, first = range.first * row_bytes;
        if (range.count() > 0) commands.copy(plane.gpu, first, plane.host, first, range.count() * row_bytes);
    };
    const RowRange rows = list_->rows();
    const auto tile_rows = static_cast<std::uint32_t>(grid_.tiles_y);
    copy(slot.codes, height_, rows);
    copy(slot.validity, height_, rows);
    copy(slot.tiles, tile_rows,
         {std::min(rows.first / tile_cells, tile_rows), std::min(whole(rows.last, tile_cells), tile_rows)});
    commands.mark("read back");
}

void Builder::show(const VulkanVertices& slot, SurfaceFrame& out) const {
    out.width = scene_.width;
    out.height = scene_.height;
    out.coding = terraces_ ? terraces_->coding : temporal_ ? temporal_->coding : scene_.depth;
    out.raw = {};
    const auto codes = slot.codes.host.mapped<std::uint16_t>();
    if (width_ % 8 == 0) {
        out.codes.adopt(codes, slot.codes.host.keep_alive());
    } else {
        out.codes.resize(std::size_t{width_} * height_);
        for (std::size_t y = 0; y < height_; ++y)
            std::memcpy(out.codes.data() + y * width_, codes.data() + y * pitch_ * 8,
                        std::size_t{2} * width_);
    }
    out.validity.adopt(slot.validity.host.mapped<std::uint32_t>(), slot.validity.host.keep_alive());
    out.tiles.adopt(slot.tiles.host.mapped<TileBounds>(), slot.tiles.host.keep_alive());
}

}  // namespace

Result<std::unique_ptr<VulkanSurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                                  std::shared_ptr<SurfaceKernels> kernels,
                                                                  const SurfacePlan& plan) {
    const ValidCodes valid = valid_codes_of(scene.depth);
    if (scene.filter.temporal && !leaves_room_above(valid) && valid.valid_min == 0 &&
        valid.excluded[0] != no_such_code)
        return Error{
            ErrorKind::gpu,
            "the vulkan builder cannot filter in time (filter.temporal is on) where depth.invalid names some "
            "of 65536 codes but neither 0 nor 65535; must be the cpu builder"};
    auto builder = std::make_unique<Builder>(scene, std::move(kernels), plan);
    if (auto reserved = builder->reserve(); !reserved.ok()) return reserved.error();
    return std::unique_ptr<VulkanSurfaceBuilder>(std::move(builder));
}

Result<std::unique_ptr<VulkanSurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                                  std::shared_ptr<GpuDevice> device) {
    const SurfacePlan plan = plan_for(device->facts());
    return make_vulkan_builder(scene, std::make_shared<SurfaceKernels>(std::move(device)), plan);
}

}  // namespace touchable
