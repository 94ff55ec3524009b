#include "engine/gpu/vulkan_builder.hpp"

#include "engine/base/try.hpp"
#include "engine/gpu/surface_recording.hpp"

namespace touchable {

namespace {

/// They are compared within about 50 us.
constexpr long pixels_compared_per_thread = 800'000;

constexpr std::size_t row_texel_bytes = 16;

/// Blocks that a lane marches along at most, where it marches along whole rows of whole frames: not so many
/// that one core waits for another.
constexpr int longest_run = 8;

class Builder final : public VulkanSurfaceBuilder {
public:
    Builder(const Scene& scene, std::shared_ptr<GpuDevice> device, const SurfacePlan& plan,
            SurfaceRecording recording, BlockList list)
        : scene_(scene),
          device_(std::move(device)),
          plan_(plan),
          recording_(std::move(recording)),
          list_(std::move(list)),
          stored_(device_, valid_codes_of(scene.depth), plan.copies) {}

    std::string_view name() const override { return "vulkan"; }
    const std::vector<GpuDevice::Time>& stages() const override { return stages_; }
    double built_share() const override { return list_.share(); }
    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        TRY(check_raw_frame(raw, scene_));
        TRY_ASSIGN(const auto slot, slot_of(out));
        const BuildNumber held = std::exchange(slot->build, {});
        const BuildNumber newest = list_.advance(raw, held);
        TRY(build_listed(raw, *slot));
        list_.done();
        show(*slot, out);
        if (!list_.same_touch_planes(held)) copy_touch_planes(raw, out);
        out.filled = raw.filled;
        slot->build = newest;
        return {};
    }

private:
    /// The slot's memory, new where it has none that serves.
    Result<VulkanVertices*> slot_of(SurfaceFrame& out) const {
        auto* slot = dynamic_cast<VulkanVertices*>(out.vertices.get());
        if (slot != nullptr && slot->serves(*device_, scene_.width, scene_.height, plan_.copies)) return slot;
        TRY_ASSIGN(auto created,
                   VulkanVertices::create(*device_, out, scene_.width, scene_.height, plan_.copies));
        slot = created.get();
        out.vertices = std::move(created);
        return slot;
    }

    Result<void> build_listed(const RawFrame& raw, const VulkanVertices& slot) {
        stages_.clear();
        if (list_.rows().count() == 0) return {};
        TRY_ASSIGN(auto rows, stored_.take(raw.depth, list_.rows()));
        TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "surface"));
        const bool begins = !last_ || !last_->is_before(raw);
        last_.reset();  // until all of it is done
        stored_.record_reading_in(commands);
        TRY(recording_.record(commands, rows, list_, begins, slot));
        if (slot.codes.is_copied()) record_reading_back(commands, slot);
        TRY_ASSIGN(const auto submission, std::move(commands).submit());
        TRY(submission.wait());
        last_.emplace(raw);
        stages_ = submission.times();
        return {};
    }

    /// Rows of listed blocks: what a slot holds of others in the GPU's memory it holds in the CPU's.
    void record_reading_back(GpuCommands& commands, const VulkanVertices& slot) const {
        commands.barrier(GpuStage::compute, GpuStage::transfer);
        const auto copy = [&](const VulkanVertices::Plane& plane, std::uint32_t rows, const RowRange& range) {
            const std::size_t row_bytes = plane.gpu.bytes() / rows, first = range.first * row_bytes;
            if (range.count() > 0)
                commands.copy(plane.gpu, first, plane.host, first, range.count() * row_bytes);
        };
        const RowRange rows = list_.rows();
        const auto height = static_cast<std::uint32_t>(scene_.height),
                   tile_rows = static_cast<std::uint32_t>(TileGrid::of(scene_.width, scene_.height).tiles_y);
        copy(slot.codes, height, rows);
        copy(slot.validity, height, rows);
        copy(slot.tiles, tile_rows,
             {std::min(rows.first / tile_cells, tile_rows),
              std::min(groups_for(rows.last, tile_cells), tile_rows)});
        commands.mark("read back");
    }

    void show(const VulkanVertices& slot, SurfaceFrame& out) const {
        out.width = scene_.width;
        out.height = scene_.height;
        out.coding = recording_.filters().coding();
        out.raw = {};
        const auto codes = slot.codes.host.mapped<std::uint16_t>();
        const auto width = static_cast<std::size_t>(scene_.width),
                   height = static_cast<std::size_t>(scene_.height), pitch = (width + 7) / 8 * 8;
        if (width == pitch) {
            out.codes.adopt(codes, slot.codes.host.keep_alive());
        } else {
            out.codes.resize(width * height);
            for (std::size_t y = 0; y < height; ++y)
                std::memcpy(out.codes.data() + y * width, codes.data() + y * pitch, 2 * width);
        }
        out.validity.adopt(slot.validity.host.mapped<std::uint32_t>(), slot.validity.host.keep_alive());
        out.tiles.adopt(slot.tiles.host.mapped<TileBounds>(), slot.tiles.host.keep_alive());
    }

    const Scene scene_;
    const std::shared_ptr<GpuDevice> device_;
    const SurfacePlan plan_;
    SurfaceRecording recording_;
    BlockList list_;
    StoredPlane stored_;
    std::optional<RawFrame::Place> last_;  // of the frame that is remembered
    std::vector<GpuDevice::Time> stages_;
};

}  // namespace

Result<BlockList> BlockList::create(const GpuDevice& device, int width, int height, std::optional<int> reach,
                                    double most, int run) {
    BlockList list;
    TRY_ASSIGN(auto buffer, GpuBuffer::create(device, "blocks to build",
                                              BlockGrid::of(width, height).count() * sizeof(ListedBlocks),
                                              GpuMemory::upload));
    list.buffer_ = buffer;
    list.height_ = static_cast<std::uint32_t>(height);
    list.most_ = most;
    list.run_ = run;
    // A tile's bounds are those of its own blocks and of the pixels after them, to the right and below.
    if (reach) {
        list.changes_ =
            std::make_unique<FrameChanges>(width, height, *reach + 1, usable_vector_units().front());
        list.bands_ =
            std::make_unique<RowBands>(threads_for(long{width} * height, pixels_compared_per_thread));
    }
    return list;
}

BuildNumber BlockList::advance(const RawFrame& raw, const BuildNumber& held) {
    const bool was_done = std::exchange(done_, false);
    share_ = 1;
    count_ = 0;
    rows_ = {0, height_};
    if (!changes_) return {};
    const BuildNumber newest = changes_->advance(raw, *bands_);
    const auto stale = was_done ? changes_->stale_blocks(held) : std::nullopt;
    if (!stale) return newest;
    const double share = static_cast<double>(stale->count()) / static_cast<double>(stale->grid().count());
    if (share > most_) {
        changes_->comparing_was_in_vain();
    } else {
        share_ = share;
        list(*stale);
    }
    return newest;
}

void BlockList::list(const FrameChanges::StaleBlocks& stale) {
    const BlockGrid grid = stale.grid();
    const auto listed = buffer_.mapped<ListedBlocks>();
    int first = grid.rows, last = 0;
    for (int row = 0; row < grid.rows; ++row) {
        BlockGrid::Run run;
        while (!(run = stale.next_run(row, row + 1, run.last)).empty()) {
            run.last = std::min(run.last, run.first + run_);
            listed[count_++] = {static_cast<std::uint32_t>(grid.index(run.first, row)),
                                static_cast<std::uint32_t>(run.last - run.first)};
            first = std::min(first, row);
            last = row + 1;
        }
    }
    rows_ = {static_cast<std::uint32_t>(std::min(first, last) * BlockGrid::height),
             std::min(static_cast<std::uint32_t>(last * BlockGrid::height), height_)};
}

Result<void> StoredPlane::make_buffers(std::size_t bytes) {
    if (upload_ && upload_.bytes() == bytes) return {};
    TRY_ASSIGN(auto mapped, GpuBuffer::create(*device_, "stored values", bytes, GpuMemory::upload));
    GpuBuffer own = mapped;
    if (copies_) {
        TRY_ASSIGN(own, GpuBuffer::create(*device_, "stored values of the GPU", bytes, GpuMemory::device));
    }
    upload_ = mapped;
    stored_ = own;
    return {};
}

/// Rows one after the other from texel to texel.
Result<StoredRows> StoredPlane::take(const PlaneView& depth, const RowRange& rows) {
    const std::size_t pixel_bytes =
        static_cast<std::size_t>(depth.channels) * static_cast<std::size_t>(depth.bytes_per_sample);
    const std::size_t row_bytes = static_cast<std::size_t>(depth.width) * pixel_bytes;
    // Whole texels, and whole groups of 8 pixels, which is what kernels read.
    const std::size_t groups = (static_cast<std::size_t>(depth.width) + 7) / 8;
    const std::size_t pitch =
        (groups * 8 * pixel_bytes + row_texel_bytes - 1) / row_texel_bytes * row_texel_bytes;
    TRY(make_buffers(pitch * static_cast<std::size_t>(depth.height)));
    taken_first_ = pitch * rows.first;
    taken_bytes_ = pitch * rows.count();
    std::byte* to = upload_.mapped<std::byte>().data() + taken_first_;
    const std::uint8_t* from = depth.row(static_cast<int>(rows.first));
    if (depth.stride == static_cast<std::ptrdiff_t>(pitch)) {
        std::memcpy(to, from, taken_bytes_ - (pitch - row_bytes));
    } else {
        for (std::uint32_t n = 0; n < rows.count(); ++n, to += pitch, from += depth.stride)
            std::memcpy(to, from, row_bytes);
    }
    return StoredRows{stored_, static_cast<std::uint32_t>(depth.bytes_per_sample),
                      static_cast<std::uint32_t>(pitch / row_texel_bytes), valid_};
}

void StoredPlane::record_reading_in(GpuCommands& commands) const {
    if (!copies_) return;
    commands.copy(upload_, taken_first_, stored_, taken_first_, taken_bytes_);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    commands.mark("read in");
}

Result<VulkanVertices::Plane> VulkanVertices::Plane::create(const GpuDevice& device, const std::string& name,
                                                            std::size_t bytes, bool copied) {
    TRY_ASSIGN(auto gpu,
               GpuBuffer::create(device, name, bytes, copied ? GpuMemory::device : GpuMemory::shared));
    if (!copied) return Plane{gpu, gpu};
    TRY_ASSIGN(auto host, GpuBuffer::create(device, name + " read back", bytes, GpuMemory::readback));
    return Plane{gpu, host};
}

Result<std::unique_ptr<VulkanVertices>> VulkanVertices::create(const GpuDevice& device,
                                                               const SurfaceFrame& frame, int width,
                                                               int height, bool copied) {
    std::unique_ptr<VulkanVertices> made(new VulkanVertices(device, frame, width, height));
    const auto rows = static_cast<std::size_t>(height), columns = static_cast<std::size_t>(width);
    const TileGrid grid = TileGrid::of(width, height);
    const std::tuple<Plane&, const char*, std::size_t> planes[] = {
        {made->codes, "codes", rows * ((columns + 7) / 8) * 16},
        {made->validity, "validity", rows * ((columns + 31) / 32) * sizeof(std::uint32_t)},
        {made->tiles, "tiles",
         static_cast<std::size_t>(grid.tiles_x) * static_cast<std::size_t>(grid.tiles_y) *
             sizeof(TileBounds)}};
    for (const auto& [plane, name, bytes] : planes) {
        TRY_ASSIGN(auto created, Plane::create(device, name, bytes, copied));
        plane = created;
    }
    return made;
}

bool VulkanVertices::serves(const GpuDevice& device, int width, int height, bool copied) const {
    return codes.is_copied() == copied && is_on(device) && width_ == width && height_ == height;
}

Result<std::unique_ptr<VulkanSurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                                  std::shared_ptr<SurfaceKernels> kernels,
                                                                  const SurfacePlan& plan) {
    const std::shared_ptr<GpuDevice> device = kernels->device();
    TRY_ASSIGN(auto recording, SurfaceRecording::create(scene, std::move(kernels), plan));
    const int run =
        plan.segment_texels > 0 ? static_cast<int>(groups_for(plan.segment_texels, 4)) : longest_run;
    TRY_ASSIGN(auto list, BlockList::create(*device, scene.width, scene.height,
                                            plan.break_even > 0 ? recording.reach() : std::nullopt,
                                            plan.break_even, run));
    return std::make_unique<Builder>(scene, device, plan, std::move(recording), std::move(list));
}

Result<std::unique_ptr<SurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                            std::shared_ptr<GpuDevice> device) {
    const SurfacePlan plan = plan_for(device->facts());
    TRY_ASSIGN(auto builder,
               make_vulkan_builder(scene, std::make_shared<SurfaceKernels>(std::move(device)), plan));
    return builder;
}

}  // namespace touchable
