// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/vulkan_builder.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/gpu/surface_kernels.hpp"
#include "engine/gpu/surface_recording.hpp"
#include "engine/scene/plane_memory.hpp"

namespace touchable {

namespace {

constexpr std::size_t row_texel_bytes = 16;

/// Frames that are begun before the first is finished: one that the CPU reads or takes, one that the GPU
/// works at, and one that is ready for it.
constexpr int most_in_flight = 3;

class Builder final : public VulkanSurfaceBuilder {
public:
    Builder(const Scene& scene, std::shared_ptr<GpuDevice> device, const SurfacePlan& plan,
            SurfaceRecording recording)
        : scene_(scene),
          device_(std::move(device)),
          plan_(plan),
          recording_(std::move(recording)),
          stored_(device_, valid_codes_of(scene.depth), plan, most_in_flight) {}

    /// Makes a frame's programs before the first frame is waited for: on a GPU that takes longer than many
    /// frames.
    Result<void> make_programs() {
        TRY_ASSIGN(auto planes, take_spare());
        TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "surface"));
        const std::uint32_t sample_bytes = scene_.depth_bits > 8 ? 2 : 1;
        TRY(recording_.record(commands, {planes.codes.gpu, sample_bytes, 1, valid_codes_of(scene_.depth)},
                              true, planes));
        keep(std::move(planes));
        return {};  // nothing is submitted
    }

    std::string_view name() const override { return "vulkan"; }
    const std::vector<GpuDevice::Time>& stages() const override { return stages_; }
    int frames_in_flight() const override { return most_in_flight; }

    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        assert(begun_.empty());
        TRY(check_raw_frame(raw, scene_));
        if (auto* slot = dynamic_cast<VulkanVertices*>(out.vertices.get()))
            keep(std::exchange(slot->planes, {}));
        TRY(begin(raw));
        return finish(out);
    }

    Result<void> begin(const RawFrame& raw) override {
        assert(static_cast<int>(begun_.size()) < frames_in_flight());
        TRY(check_raw_frame(raw, scene_));
        TRY_ASSIGN(auto planes, take_spare());
        Begun frame{raw, std::move(planes)};
        if (newest_.depth.empty() || !same_samples(newest_.haptic, raw.haptic) ||
            !same_samples(newest_.height, raw.height))
            touch_planes_ = new_content_number();
        newest_ = raw.storage ? raw : RawFrame{};
        frame.touch_planes = touch_planes_;
        TRY(submit(frame));
        begun_.push_back(std::move(frame));
        return {};
    }

    Result<void> finish(SurfaceFrame& out) override {
        assert(!begun_.empty());
        Begun frame = std::move(begun_.front());
        begun_.pop_front();
        stages_.clear();
        if (auto waited = frame.submission->wait(); !waited) {
            last_.reset();
            return waited;
        }
        stages_ = frame.submission->times();
        VulkanVertices& slot = give(std::move(frame.planes), out);
        show(slot.planes, out);
        if (std::exchange(slot.touch_planes, frame.touch_planes) != frame.touch_planes)
            copy_touch_planes(frame.raw, out);
        out.filled = frame.raw.filled;
        return {};
    }

private:
    struct Begun {
        RawFrame raw;
        VulkanPlanes planes;
        std::uint64_t touch_planes = 0;
        std::optional<GpuCommands::Submission> submission{};
    };

    /// Keeps planes for a later frame.
    void keep(VulkanPlanes planes) {
        if (planes.serves(*device_, scene_.width, scene_.height, plan_)) spare_.push_back(std::move(planes));
    }
    Result<VulkanPlanes> take_spare() {
        if (spare_.empty()) return VulkanPlanes::create(*device_, scene_.width, scene_.height, plan_);
        VulkanPlanes planes = std::move(spare_.back());
        spare_.pop_back();
        return planes;
    }

    /// Gives the slot these planes; those that it had serve a later frame.
    VulkanVertices& give(VulkanPlanes planes, SurfaceFrame& slot) {
        if (auto* const there = dynamic_cast<VulkanVertices*>(slot.vertices.get())) {
            keep(std::exchange(there->planes, std::move(planes)));
            return *there;
        }
        auto made = std::make_unique<VulkanVertices>(slot, std::move(planes));
        VulkanVertices& vertices = *made;
        slot.vertices = std::move(made);
        return vertices;
    }

    Result<void> submit(Begun& frame) {
        TRY_ASSIGN(auto rows, stored_.take(frame.raw));
        TRY_ASSIGN(auto commands, GpuCommands::begin(device_, "surface"));
        const bool begins = !last_ || !last_->is_before(frame.raw);
        last_.reset();  // until all of it is submitted
        stored_.record_reading_in(commands);
        TRY(recording_.record(commands, rows, begins, frame.planes));
        if (frame.planes.codes.is_copied()) record_reading_back(commands, frame.planes);
        TRY_ASSIGN(auto submission, std::move(commands).submit());
        frame.submission.emplace(std::move(submission));
        last_.emplace(frame.raw);
        return {};
    }

    void record_reading_back(GpuCommands& commands, const VulkanPlanes& planes) const {
        commands.barrier(GpuStage::compute, GpuStage::transfer);
        for (const auto& [from, to] : {std::pair(recording_.codes_of(planes), planes.codes.host),
                                       {planes.validity.gpu, planes.validity.host},
                                       {planes.tiles.gpu, planes.tiles.host}})
            commands.copy(from, 0, to, 0, to.bytes());
        commands.mark("read back");
    }

    void show(const VulkanPlanes& planes, SurfaceFrame& out) const {
        out.width = scene_.width;
        out.height = scene_.height;
        out.coding = recording_.filters().coding();
        out.raw = {};
        const auto codes = planes.codes.host.mapped<std::uint16_t>();
        const auto width = static_cast<std::size_t>(scene_.width),
                   height = static_cast<std::size_t>(scene_.height), pitch = codes.size() / height;
        if (width == pitch) {
            out.codes.adopt(codes, planes.codes.host.keep_alive());
        } else {
            out.codes.resize(width * height);
            for (std::size_t y = 0; y < height; ++y)
                std::memcpy(out.codes.data() + y * width, codes.data() + y * pitch, 2 * width);
        }
        out.validity.adopt(planes.validity.host.mapped<std::uint32_t>(), planes.validity.host.keep_alive());
        out.tiles.adopt(planes.tiles.host.mapped<TileBounds>(), planes.tiles.host.keep_alive());
    }

    const Scene scene_;
    const std::shared_ptr<GpuDevice> device_;
    const SurfacePlan plan_;
    SurfaceRecording recording_;
    RawFrame newest_;                 // empty if it does not keep its planes
    std::uint64_t touch_planes_ = 0;  // names its haptic and height planes
    StoredPlane stored_;
    std::optional<RawFrame::Place> last_;  // of the last submitted frame
    std::deque<Begun> begun_;
    std::vector<VulkanPlanes> spare_;
    std::vector<GpuDevice::Time> stages_;
};

// ---- The race

// Measures the builders on the device itself: copies over the bus take many times a kernel's time on one
// machine and nothing on another, and the kind of device does not tell which.

constexpr int race_width = 1920, race_height = 1080;
constexpr std::size_t frame_count = 4;

/// Noise of all codes, in the memory that decoders write to.
Result<std::vector<RawFrame>> noisy_frames() {
    constexpr std::size_t bytes = std::size_t{2} * race_width * race_height;
    std::vector<RawFrame> frames(frame_count);
    std::uint64_t state = 1;
    for (std::size_t n = 0; n < frame_count; ++n) {
        const std::shared_ptr<std::uint8_t> plane = take_plane_memory(bytes);
        if (!plane) return Error{ErrorKind::internal, "no memory for a frame"};
        for (std::size_t k = 0; k < bytes; k += sizeof(state)) {
            state = state * 6364136223846793005U + 1442695040888963407U;
            std::memcpy(plane.get() + k, &state, sizeof(state));
        }
        frames[n].number = static_cast<std::int64_t>(n);
        frames[n].depth = packed_plane(plane.get(), race_width, race_height, 2, 1);
        frames[n].storage = plane;
    }
    return frames;
}

bool same_frames(const SurfaceFrame& a, const SurfaceFrame& b) {
    return a.codes == b.codes && a.validity == b.validity && a.tiles == b.tiles;
}

using Slots = SurfaceFrame[2];

/// The least time of a frame, ms, after building each `warm` times; the slots then hold the last two.
Result<double> least_ms(SurfaceBuilder& builder, const std::vector<RawFrame>& frames, int warm, int timed,
                        Slots& slots) {
    double least = HUGE_VAL;
    for (int n = 0; n < warm + timed; ++n) {
        if (stop_requested()) return interrupted_error();
        for (std::size_t k = 0; k < frames.size(); ++k) {
            const auto begin = std::chrono::steady_clock::now();
            TRY(builder.build(frames[k], slots[k % 2]));
            const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
            if (n >= warm) least = std::min(least, took.count());
        }
    }
    return least;
}

Result<void> race(const std::shared_ptr<GpuDevice>& device, const SurfacePlan& plan,
                  GpuFacts::Measured& measured) {
    TRY_ASSIGN(const auto frames, noisy_frames());
    Scene scene;
    scene.width = race_width;
    scene.height = race_height;
    scene.depth_bits = 16;
    scene.camera = {race_width, race_width, race_width / 2.0, race_height / 2.0};
    scene.depth.near = 500;
    scene.depth.far = 1500;
    scene.depth.code_max = 65535;
    scene.depth.valid_max = 65535;
    scene.filter.median = 3;

    Slots right;
    TRY_ASSIGN(measured.cpu_ms, least_ms(*make_cpu_builder(scene), frames, 1, 3, right));
    measured.vulkan_ms = HUGE_VAL;
    TRY_ASSIGN(const auto builder,
               make_vulkan_builder(scene, std::make_shared<SurfaceKernels>(device), plan));
    Slots made;
    TRY_ASSIGN(const double took, least_ms(*builder, frames, 2, 6, made));
    if (std::ranges::equal(made, right, same_frames)) measured.vulkan_ms = took;
    return {};
}

}  // namespace

Result<void> StoredPlane::make_own(std::size_t bytes) {
    if (!copies_) return {};
    return own_.reserve(*device_, "stored values of the GPU", bytes, GpuMemory::device);
}

/// Finds the plane's block, imported once, if it can be copied in place, with rows of whole texels.
bool StoredPlane::find_block(const RawFrame& raw, std::size_t least_pitch) {
    const PlaneView& depth = raw.depth;
    const auto pitch = static_cast<std::size_t>(std::max<std::ptrdiff_t>(depth.stride, 0));
    const std::size_t bytes = pitch * static_cast<std::size_t>(depth.height);
    const GpuFacts::Limits& limits = device_->facts().limits;
    if (!imports_ || !raw.storage || pitch < least_pitch || pitch % row_texel_bytes != 0 ||
        bytes > limits.max_storage_buffer_range || bytes / row_texel_bytes > limits.max_texel_buffer_elements)
        return false;
    const auto block = plane_block_of(depth.data, bytes);
    if (!block) return false;
    if (block->bytes() > most_imported_bytes / 3) return false;  // it would not be lent again
    const auto from = static_cast<std::size_t>(depth.data - block->data());
    const auto found =
        std::ranges::find(imported_, block->id(), [](const auto& each) { return each.block->id(); });
    if (found != imported_.end()) {
        Imported used = std::move(*found);
        imported_.erase(found);
        imported_.push_front(std::move(used));
    } else {
        auto made = GpuBuffer::import(*device_, "a reader's plane", block);
        if (!made) {
            imports_ = false;
            return false;
        }
        // Only the import owns blocks that are not lent again, by two handles.
        std::erase_if(imported_, [](const Imported& each) { return each.block.use_count() <= 2; });
        imported_.push_front({block, *made});
        std::size_t bytes_of_all = 0;
        for (const Imported& each : imported_) bytes_of_all += each.block->bytes();
        for (; bytes_of_all > most_imported_bytes; imported_.pop_back())
            bytes_of_all -= imported_.back().block->bytes();
    }
    source_.buffer = imported_.front().buffer;
    source_.from = from;
    source_.storage = raw.storage;
    return true;
}

/// Copies rows by the CPU, each to begin at a texel.
Result<void> StoredPlane::upload(const PlaneView& depth, std::size_t pitch) {
    turn_ = (turn_ + 1) % uploads_.size();
    GpuBuffer& buffer = uploads_[turn_];
    const std::size_t bytes = pitch * static_cast<std::size_t>(depth.height);
    if (!buffer || buffer.bytes() != bytes)
        TRY(assign(buffer, GpuBuffer::create(*device_, "stored values", bytes, GpuMemory::upload)));
    std::byte* to = buffer.mapped<std::byte>().data();
    if (depth.stride == static_cast<std::ptrdiff_t>(pitch)) {
        std::memcpy(to, depth.row(0), bytes - (pitch - depth.row_bytes()));
    } else {
        depth.copy_rows(reinterpret_cast<std::uint8_t*>(to), pitch);
    }
    source_.buffer = buffer;
    source_.from = 0;
    return {};
}

Result<StoredRows> StoredPlane::take(const RawFrame& raw) {
    const PlaneView& depth = raw.depth;
    const auto pixel_bytes = static_cast<std::size_t>(depth.channels * depth.bytes_per_sample);
    // Whole texels, and whole groups of 8 pixels, which is what kernels read.
    const std::size_t groups = (static_cast<std::size_t>(depth.width) + 7) / 8;
    std::size_t pitch = (groups * 8 * pixel_bytes + row_texel_bytes - 1) / row_texel_bytes * row_texel_bytes;
    source_ = {};
    if (find_block(raw, pitch)) {
        pitch = static_cast<std::size_t>(depth.stride);
    } else {
        TRY(upload(depth, pitch));
    }
    TRY(make_own(pitch * static_cast<std::size_t>(depth.height)));
    StoredRows taken{copies_ ? own_ : source_.buffer, static_cast<std::uint32_t>(depth.bytes_per_sample),
                     static_cast<std::uint32_t>(pitch / row_texel_bytes), valid_};
    source_.bytes = pitch * static_cast<std::size_t>(depth.height);
    return taken;
}

void StoredPlane::record_reading_in(GpuCommands& commands) {
    const Source source = std::exchange(source_, {});
    if (source.storage) commands.keep(source.storage);
    if (!copies_) return;
    commands.copy(source.buffer, source.from, own_, 0, source.bytes);
    commands.barrier(GpuStage::transfer, GpuStage::compute);
    commands.mark("read in");
}

Result<VulkanPlanes> VulkanPlanes::create(const GpuDevice& device, int width, int height,
                                          const SurfacePlan& plan) {
    VulkanPlanes made{device.vulkan(), width, height, plan.packs_rows(width)};
    const auto rows = static_cast<std::size_t>(height), columns = static_cast<std::size_t>(width);
    const std::size_t codes_bytes = rows * ((columns + 7) / 8) * 16;
    const struct {
        Plane& plane;
        std::string name;
        std::size_t bytes;
    } planes[] = {{made.codes, "codes", codes_bytes},
                  {made.validity, "validity", rows * ((columns + 31) / 32) * sizeof(std::uint32_t)},
                  {made.tiles, "tiles", TileGrid::of(width, height).count() * sizeof(TileBounds)}};
    for (const auto& [plane, name, bytes] : planes) {
        TRY_ASSIGN(plane.gpu, GpuBuffer::create(device, name, bytes,
                                                plan.copies ? GpuMemory::device : GpuMemory::shared));
        plane.host = plane.gpu;
        if (!plan.copies) continue;
        const std::size_t copied = made.packed && &plane == &made.codes ? 2 * rows * columns : bytes;
        TRY_ASSIGN(plane.host, GpuBuffer::create(device, name + " read back", copied, GpuMemory::readback));
    }
    return made;
}

bool VulkanPlanes::serves(const GpuDevice& device, int for_width, int for_height,
                          const SurfacePlan& plan) const {
    return is_on(device) && width == for_width && height == for_height && codes.is_copied() == plan.copies &&
           packed == plan.packs_rows(width);
}

Result<std::unique_ptr<VulkanSurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                                  std::shared_ptr<SurfaceKernels> kernels,
                                                                  const SurfacePlan& plan) {
    const std::shared_ptr<GpuDevice> device = kernels->device();
    TRY_ASSIGN(auto recording, SurfaceRecording::create(scene, std::move(kernels), plan));
    auto builder = std::make_unique<Builder>(scene, device, plan, std::move(recording));
    TRY(builder->make_programs());
    return builder;
}

Result<std::unique_ptr<SurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                            std::shared_ptr<GpuDevice> device) {
    const SurfacePlan plan = plan_for(device->facts());
    TRY_ASSIGN(auto builder,
               make_vulkan_builder(scene, std::make_shared<SurfaceKernels>(std::move(device)), plan));
    return builder;
}

void measure_builders(const std::shared_ptr<GpuDevice>& device) {
    GpuFacts& facts = device->vulkan()->facts;
    const SurfacePlan plan = plan_for(facts);
    if (facts.kind == GpuKind::software || !plan.blocks || facts.measured.cpu_ms >= 0 ||
        std::getenv("TOUCHABLE_GPU_PLAN") != nullptr)
        return;
    GpuFacts::Measured measured;
    // A device that the race lost is not measured again. After missing memory or a stop it is.
    if (!race(device, plan, measured) && !device->lost()) return;
    facts.measured.cpu_ms = measured.cpu_ms;
    facts.measured.vulkan_ms = measured.vulkan_ms;
}

}  // namespace touchable
