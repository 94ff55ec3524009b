// SPDX-License-Identifier: Apache-2.0
#include "bench/surface/eye_race.hpp"

#include <algorithm>
#include <cmath>

#include "bench/surface/race.hpp"
#include "player/draw/cpu_painting.hpp"
#include "player/draw/gpu_painting.hpp"
#include "tests/view/shown.hpp"

namespace touchable {
namespace {

bool nearly_equal(const std::vector<float>& twin, const std::vector<float>& q) {
    if (q.size() != twin.size()) return false;
    for (std::size_t k = 0; k < twin.size(); ++k)
        if (!(std::fabs(q[k] - twin[k]) <= 1e-6F * twin[k])) return false;
    return true;
}

/// With kernels: the builder's, then unproject, then (for tiles) those that list them.
class ByKernels {
public:
    ByKernels(const Picture& picture, VulkanSurfaceBuilder& builder, std::shared_ptr<GpuDevice> device)
        : picture_(picture), builder_(builder), device_(device), unproject_(device), lattices_(device) {}

    Result<void> make_q() {
        if (!q_) {
            auto made = GpuBuffer::create(
                *device_, "q", SurfaceUnproject::q_bytes(picture_.scene.width, picture_.scene.height),
                device_->facts().unified_memory ? GpuMemory::shared : GpuMemory::device);
            if (!made) return made.error();
            q_ = *made;
        }
        return frame([&](GpuCommands& commands, const HeightField& field) {
            return unproject_.record(commands, field, still(frame_), q_);
        });
    }
    Result<void> make_tiles() {
        return frame([&](GpuCommands& commands, const HeightField& field) {
            auto recorded = lattices_.record(commands, field, still(frame_), lattice_);
            return recorded ? lattices_.record_view(commands, false, lattice_) : recorded;
        });
    }
    /// q of the last tiles.
    std::vector<float> seen() const { return test::rows_in<float>(device_, lattice_, lattice_.q); }
    const std::vector<GpuDevice::Time>& stages() const { return stages_; }
    const SurfaceFrame& codes() const { return frame_; }

private:
    template <class Record>
    Result<void> frame(Record&& record) {
        if (auto built = builder_.build(kept(picture_.raw), frame_); !built) return built;
        auto commands = GpuCommands::begin(device_, "eye");
        if (!commands) return commands.error();
        const HeightField field(picture_.scene, still(frame_));
        if (auto recorded = record(*commands, field); !recorded) return recorded;
        const auto submission = std::move(*commands).submit();
        if (!submission) return submission.error();
        if (auto done = submission->wait(); !done) return done;
        stages_ = submission->times();
        return {};
    }

    const Picture& picture_;
    VulkanSurfaceBuilder& builder_;
    std::shared_ptr<GpuDevice> device_;
    SurfaceUnproject unproject_;
    GpuLattices lattices_;
    GpuLattice lattice_;
    GpuBuffer q_;
    SurfaceFrame frame_;
    std::vector<GpuDevice::Time> stages_;
};

/// With the CPU builder and the cpu painter's lattices.
class ByCpu {
public:
    ByCpu(const Picture& picture, int threads)
        : picture_(picture), builder_(make_cpu_builder(picture.scene, {threads})), lattices_(threads) {}

    Result<void> make_q() {
        if (auto built = builder_->build(picture_.raw, frame_); !built) return built;
        lattices_.q_of(HeightField(picture_.scene, still(frame_)), still(frame_), q_);
        return {};
    }
    Result<void> make_tiles() {
        if (auto made = make_q(); !made) return made;
        tiles_ = lattices_.tiles_of(picture_.scene.width, picture_.scene.height, q_);
        return {};
    }
    const std::vector<float>& q() const { return q_; }
    const ViewSurface::Tiles& tiles() const { return tiles_; }

private:
    const Picture& picture_;
    std::unique_ptr<SurfaceBuilder> builder_;
    CpuLattices lattices_;
    SurfaceFrame frame_;
    std::vector<float> q_;
    ViewSurface::Tiles tiles_;
};

ViewSurface::Tiles tiles_of_marks(const std::vector<std::uint8_t>& marks) {
    ViewSurface::Tiles tiles;
    for (std::size_t n = 0; n < marks.size(); ++n)
        if ((marks[n] & 2U) != 0)
            (marks[n] == 3 ? tiles.mixed : tiles.whole).push_back(static_cast<std::uint32_t>(n));
    return tiles;
}

/// Runs all racers once and checks their results.
Result<void> verify(const SurfaceCase& c, const Picture& picture, ByKernels& kernels, ByCpu& one, ByCpu& two,
                    OpenCvPipeline* opencv) {
    for (const auto& made : {kernels.make_q(), kernels.make_tiles(), one.make_tiles(), two.make_tiles()})
        if (!made) return made;
    const std::vector<float> twin = q_of(HeightField(picture.scene, still(kernels.codes())));
    if (!nearly_equal(twin, kernels.seen())) return wrong(c, "the kernel's q are not the field's");
    if (!nearly_equal(twin, one.q()) || one.q() != two.q())
        return wrong(c, "the CPU's q are not the field's");
    const ViewSurface::Tiles tiles = test::classify_tiles(c.width, c.height, one.q());
    if (one.tiles() != tiles || two.tiles() != tiles) return wrong(c, "the CPU's tiles differ");
    if (opencv == nullptr) return {};
    opencv->median();
    opencv->q();
    opencv->mark_cuts();
    if (!nearly_equal(twin, opencv->q_plane())) return wrong(c, "OpenCV's q are not the field's");
    if (tiles_of_marks(opencv->cut_marks()) != test::classify_tiles(c.width, c.height, opencv->q_plane()))
        return wrong(c, "the cut marks beside OpenCV differ");
    return {};
}

}  // namespace

Result<void> race_for_the_eye(const SurfaceCase& c, const Picture& picture, VulkanSurfaceBuilder& vulkan,
                              const std::shared_ptr<GpuDevice>& device, OpenCvPipeline& opencv, int rounds,
                              Figures& figures) {
    const bool with_opencv = has_opencv() && c.holes_pct == 0;
    ByKernels kernels(picture, vulkan, device);
    ByCpu one(picture, 1), two(picture, 2);
    if (auto right = verify(c, picture, kernels, one, two, with_opencv ? &opencv : nullptr); !right)
        return right;

    const std::string side = std::to_string(picture.scene.filter.median);
    std::vector<GpuDevice::Time> stages;
    std::vector<Racer> racers{{"positions" + side, [&] { return kernels.make_q(); }},
                              {"cpu_positions" + side + "_1t", [&] { return one.make_q(); }},
                              {"cpu_positions" + side + "_2t", [&] { return two.make_q(); }},
                              {"mesh" + side,
                               [&]() -> Result<void> {
                                   auto made = kernels.make_tiles();
                                   stages = kernels.stages();
                                   return made;
                               }},
                              {"cpu_mesh" + side + "_1t", [&] { return one.make_tiles(); }},
                              {"cpu_mesh" + side + "_2t", [&] { return two.make_tiles(); }}};
    const auto add_opencv = [&](const std::string& name, auto&& then) {
        racers.push_back({name + side, [&opencv, then]() -> Result<void> {
                              opencv.median();
                              then(opencv);
                              return {};
                          }});
    };
    if (with_opencv) {
        add_opencv("opencv_positions", [](OpenCvPipeline& o) { o.q(); });
        add_opencv("opencv_mask", [](OpenCvPipeline& o) {
            o.q();
            o.mark_cuts();
        });
    }
    if (auto raced = race(racers, rounds); !raced) return raced;
    for (const Racer& racer : racers) add_times(figures, racer.name, racer.times);
    for (const GpuDevice::Time& stage : stages)
        figures.push_back({"mesh" + side + "_" + stage.label + "_ms", stage.ms, "ms"});
    if (!with_opencv) return {};
    const FrameTimes &positions = racers[6].times, &mask = racers[7].times;
    const auto add_ratio = [&](const std::string& ours, const FrameTimes& times, const std::string& vs,
                               const FrameTimes& theirs) {
        figures.push_back({ours + vs, times.wall_ms / theirs.wall_ms, ""});
        figures.push_back({ours + "_cpu" + vs, times.cpu_ms / theirs.cpu_ms, ""});
    };
    add_ratio("positions" + side, racers[0].times, "_vs_opencv", positions);
    add_ratio("cpu_positions" + side + "_2t", racers[2].times, "_vs_opencv", positions);
    add_ratio("mask" + side, racers[3].times, "_vs_opencv_mask", mask);
    add_ratio("cpu_mask" + side, racers[5].times, "_vs_opencv_mask", mask);
    return {};
}

}  // namespace touchable
