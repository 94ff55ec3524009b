#include "engine/gpu/vulkan_builder.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/gpu/block_list.hpp"
#include "engine/gpu/stored_plane.hpp"
#include "engine/gpu/surface_recording.hpp"
#include "engine/gpu/vulkan_vertices.hpp"
#include "engine/surface/raw_check.hpp"

namespace touchable {
namespace {

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
    const std::vector<GpuTime>& stages() const override { return stages_; }
    double built_share() const override { return list_.share(); }
    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override;

private:
    Result<VulkanVertices*> slot_of(SurfaceFrame& out) const;
    Result<void> build_listed(const RawFrame& raw, const VulkanVertices& slot);
    void record_reading_back(GpuCommands& commands, const VulkanVertices& slot) const;
    void show(const VulkanVertices& slot, SurfaceFrame& out) const;

    const Scene scene_;
    const std::shared_ptr<GpuDevice> device_;
    const SurfacePlan plan_;
    SurfaceRecording recording_;
    BlockList list_;
    StoredPlane stored_;
    std::optional<FramePlace> last_;  // of the frame that is remembered
    std::vector<GpuTime> stages_;
};

Result<void> Builder::build(const RawFrame& raw, SurfaceFrame& out) {
    if (auto checked = check_raw_frame(raw, scene_); !checked) return checked;
    TRY_ASSIGN(const auto slot, slot_of(out));
    const BuildNumber held = std::exchange(slot->build, {});
    const BuildNumber newest = list_.advance(raw, held);
    if (auto built = build_listed(raw, *slot); !built.ok()) return built;
    list_.done();
    show(*slot, out);
    if (!list_.same_touch_planes(held)) copy_touch_planes(raw, out);
    out.filled = raw.filled;
    slot->build = newest;
    return {};
}

/// The slot's memory, new where it has none that serves.
Result<VulkanVertices*> Builder::slot_of(SurfaceFrame& out) const {
    auto* slot = dynamic_cast<VulkanVertices*>(out.vertices.get());
    if (slot != nullptr && slot->serves(*device_, scene_.width, scene_.height, plan_.copies)) return slot;
    TRY_ASSIGN(auto created,
               VulkanVertices::create(*device_, out, scene_.width, scene_.height, plan_.copies));
    slot = created.get();
    out.vertices = std::move(created);
    return slot;
}

Result<void> Builder::build_listed(const RawFrame& raw, const VulkanVertices& slot) {
    stages_.clear();
    if (list_.rows().count() == 0) return {};
    TRY_ASSIGN(auto rows, stored_.take(raw.depth, list_.rows()));
    TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "surface"));
    const bool begins = !last_ || !last_->is_before(raw);
    last_.reset();  // until all of it is done
    stored_.record_reading_in(commands);
    if (auto recorded = recording_.record(commands, rows, list_, begins, slot); !recorded.ok())
        return recorded;
    if (slot.codes.is_copied()) record_reading_back(commands, slot);
    TRY_ASSIGN(const auto submission, std::move(commands).submit());
    if (auto done = submission.wait(); !done.ok()) return done;
    last_.emplace(raw);
    stages_ = submission.times();
    return {};
}

/// Rows of listed blocks: what a slot holds of others in the GPU's memory it holds in the CPU's.
void Builder::record_reading_back(GpuCommands& commands, const VulkanVertices& slot) const {
    commands.barrier(GpuStage::compute, GpuStage::transfer);
    const auto copy = [&](const SharedPlane& plane, std::uint32_t rows, const RowRange& range) {
        const std::size_t row_bytes = plane.gpu.bytes() / rows, first = range.first * row_bytes;
        if (range.count() > 0) commands.copy(plane.gpu, first, plane.host, first, range.count() * row_bytes);
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

void Builder::show(const VulkanVertices& slot, SurfaceFrame& out) const {
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

}  // namespace

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
    std::unique_ptr<VulkanSurfaceBuilder> builder =
        std::make_unique<Builder>(scene, device, plan, std::move(recording), std::move(list));
    return builder;
}

Result<std::unique_ptr<VulkanSurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                                  std::shared_ptr<GpuDevice> device) {
    const SurfacePlan plan = plan_for(device->facts());
    return make_vulkan_builder(scene, std::make_shared<SurfaceKernels>(std::move(device)), plan);
}

}  // namespace touchable
