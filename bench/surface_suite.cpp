#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "bench/clocks.hpp"
#include "bench/suite.hpp"
#include "bench/surface/codes_race.hpp"
#include "bench/surface/race.hpp"
#include "engine/scene/terraces.hpp"
#include "engine/surface/vulkan_builder.hpp"
#include "player/view/gpu_lattice.hpp"
#include "player/view/gpu_painters.hpp"
#include "player/view/view_camera.hpp"

namespace touchable {
namespace {

struct SurfaceCase {
    int width, height, bits;
    int holes_pct = 0;  ///< pixels without depth
};

std::string name_of(const SurfaceCase& c) {
    return std::to_string(c.width) + "x" + std::to_string(c.height) + "-" + std::to_string(c.bits) +
           (c.holes_pct > 0 ? "-holes" + std::to_string(c.holes_pct) : "");
}

/// Depth as cameras give it: a slope with noise, and code 0 where there is none.
struct Picture {
    Scene scene;
    std::vector<std::uint8_t> memory;
    RawFrame raw;

    explicit Picture(const SurfaceCase& c) {
        scene.width = c.width;
        scene.height = c.height;
        scene.depth_bits = c.bits;
        scene.camera = {0.9 * c.width, 0.9 * c.width, c.width / 2.0, c.height / 2.0};
        scene.depth.near = 500;
        scene.depth.far = 1000;
        scene.depth.code_max = static_cast<std::uint16_t>((1 << c.bits) - 1);
        scene.depth.invalid_code_count = c.holes_pct > 0 ? 1 : 0;
        derive_valid_range(scene.depth);
        const int bytes = c.bits > 8 ? 2 : 1;
        memory.resize(static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height * bytes));
        std::uint64_t state = 7;
        const auto random = [&state] {
            return (state = state * 6364136223846793005U + 1442695040888963407U) >> 33;
        };
        for (int y = 0; y < c.height; ++y)
            for (int x = 0; x < c.width; ++x) {
                auto code =
                    static_cast<std::uint16_t>(1 + (static_cast<std::uint64_t>(scene.depth.code_max - 1) *
                                                        static_cast<std::uint64_t>(x + y) /
                                                        static_cast<std::uint64_t>(c.width + c.height) +
                                                    random() % 20) %
                                                       scene.depth.code_max);
                if (static_cast<int>(random() % 100) < c.holes_pct) code = 0;
                std::memcpy(memory.data() + (static_cast<std::ptrdiff_t>(y) * c.width + x) * bytes, &code,
                            static_cast<std::size_t>(bytes));
            }
        raw.depth = {memory.data(), std::ptrdiff_t{c.width} * bytes, c.width, c.height, bytes, 1};
    }
};

long mismatches(const SurfaceFrame& expected, const SurfaceFrame& actual) {
    if (expected.codes.size() != actual.codes.size()) return static_cast<long>(expected.codes.size());
    long different = 0;
    for (std::size_t n = 0; n < expected.codes.size(); ++n) different += expected.codes[n] != actual.codes[n];
    return different + (expected.validity == actual.validity ? 0 : 1) +
           (expected.tiles == actual.tiles ? 0 : 1);
}

template <class Work>
Result<FrameTimes> least_times(int repeats, Work&& work) {
    FrameTimes times;
    for (int n = 0; n < repeats; ++n) {
        const std::int64_t wall = monotonic_ns(), cpu = process_cpu_ns();
        if (Result<void> done = work(); !done.ok()) return done.error();
        times.wall_ms = std::min(times.wall_ms, static_cast<double>(monotonic_ns() - wall) * 1e-6);
        times.cpu_ms = std::min(times.cpu_ms, static_cast<double>(process_cpu_ns() - cpu) * 1e-6);
    }
    return times;
}

Result<FrameTimes> time_frames(SurfaceBuilder& builder, const RawFrame& raw, SurfaceFrame& out, int frames) {
    return least_times(frames, [&] { return builder.build(raw, out); });
}

FramePair still(const SurfaceFrame& frame) {
    return {{0, 0, &frame}, {0, 0, &frame}, 0};
}

Error wrong(const SurfaceCase& c, const std::string& what) {
    return {ErrorKind::check, name_of(c) + ": " + what};
}

/// q to 1e-6 and the tiles of q exactly, against their twins on the CPU.
Result<void> check_surface(const SurfaceCase& c, const HeightField& field, const ViewSurface& surface) {
    const std::vector<float> twin = q_of(field);
    if (twin.size() != surface.q.size() || !surface.on_gpu) return wrong(c, "q is not the kernel's");
    for (std::size_t k = 0; k < twin.size(); ++k)
        if (!(std::fabs(surface.q[k] - twin[k]) <= 1e-6F * twin[k]))
            return wrong(c, "q differs at pixel " + std::to_string(k));
    if (surface.tiles != classify_tiles(c.width, c.height, surface.q)) return wrong(c, "tiles differ");
    return {};
}

/// Codes with as many passes of hole filling as there may be, of which most find nothing left to fill.
Result<void> measure_filling(const SurfaceCase& c, const Picture& picture, int frames,
                             const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures) {
    Scene scene = picture.scene;
    scene.filter = {3, 16};
    auto vulkan = make_vulkan_builder(scene, kernels, plan_for(kernels->device()->facts()));
    if (!vulkan.ok()) return vulkan.error();
    SurfaceFrame expected, frame;
    if (auto built = make_cpu_builder(scene)->build(picture.raw, expected); !built.ok()) return built;
    if (auto built = (*vulkan)->build(picture.raw, frame); !built.ok()) return built;
    if (mismatches(expected, frame) > 0) return wrong(c, "filled codes differ from the CPU builder's");
    const auto times = time_frames(**vulkan, picture.raw, frame, frames);
    if (!times.ok()) return times.error();
    add_times(figures, "filled3", *times);
    return {};
}

/// Codes without terraces, where they have bits to spare for that.
Result<void> measure_terraces(const SurfaceCase& c, const Picture& picture, int frames,
                              const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures) {
    Scene scene = picture.scene;
    scene.filter = {.terraces = TerraceRemoval::on};
    const auto cpu = make_cpu_builder(scene);
    auto vulkan = make_vulkan_builder(scene, kernels, plan_for(kernels->device()->facts()));
    if (!vulkan.ok()) return vulkan.error();
    SurfaceFrame expected, frame;
    if (auto built = cpu->build(picture.raw, expected); !built.ok()) return built;
    if (auto built = (*vulkan)->build(picture.raw, frame); !built.ok()) return built;
    if (mismatches(expected, frame) > 0)
        return wrong(c, "codes without terraces differ from the CPU builder's");
    const auto times = time_frames(**vulkan, picture.raw, frame, frames);
    if (!times.ok()) return times.error();
    add_times(figures, "terraces", *times);
    for (const GpuTime& stage : (*vulkan)->stages())
        if (std::string_view(stage.label) == "terraces")
            figures.push_back({"terraces_kernels_ms", stage.ms, "ms"});
    const auto cpu_times = time_frames(*cpu, picture.raw, expected, std::max(frames / 4, 3));
    if (!cpu_times.ok()) return cpu_times.error();
    add_times(figures, "cpu_builder_terraces", *cpu_times);
    return {};
}

/// The eye's way, from stored values to q of every vertex and lists of tiles to draw.
Result<void> measure_mesh(const SurfaceCase& c, const Picture& picture, SurfaceBuilder& builder, int frames,
                          const std::shared_ptr<GpuDevice>& device, Figures& figures) {
    const std::string what = "mesh" + std::to_string(picture.scene.filter.median);
    SurfaceFrame frame;
    if (auto built = builder.build(picture.raw, frame); !built.ok()) return built;
    GpuLattices lattices(device);
    const HeightField field(picture.scene, still(frame));
    const auto surface = lattices.surface_of(field, still(frame), {});
    if (!surface.ok()) return surface.error();
    if (auto checked = check_surface(c, field, *surface); !checked.ok()) return checked;

    GpuLattice lattice;
    std::vector<GpuTime> stages;
    const auto times = least_times(frames, [&]() -> Result<void> {
        if (auto built = builder.build(picture.raw, frame); !built.ok()) return built;
        auto commands = GpuCommands::begin(device, "mesh");
        if (!commands.ok()) return commands.error();
        const HeightField moment(picture.scene, still(frame));
        if (auto recorded = lattices.record(*commands, moment, still(frame), lattice); !recorded.ok())
            return recorded;
        const auto submission = std::move(*commands).submit();
        if (!submission.ok()) return submission.error();
        if (auto done = submission->wait(); !done.ok()) return done;
        stages = submission->times();
        return {};
    });
    if (!times.ok()) return times.error();
    add_times(figures, what, *times);
    for (const GpuTime& stage : stages) figures.push_back({what + "_" + stage.label + "_ms", stage.ms, "ms"});
    return {};
}

/// The raster painter's own view, a pixel of the picture for every one of the frame.
Result<void> measure_drawing(const SurfaceCase& c, const Picture& picture, SurfaceBuilder& builder,
                             int frames, const std::shared_ptr<GpuDevice>& device, Figures& figures) {
    if (!device->facts().int64_atomics) return {};
    const auto painter = make_raster_painter(device);
    if (!painter.ok()) return painter.error();
    SurfaceFrame frame;
    if (auto built = builder.build(picture.raw, frame); !built.ok()) return built;
    const HeightField field(picture.scene, still(frame));
    const auto surface = (*painter)->surface_of(field, still(frame), {});
    if (!surface.ok()) return surface.error();
    const ViewCamera camera = own_view(picture.scene, c.width, c.height, picture.scene.depth.near / 2);
    const auto twin = make_cpu_painter()->paint(*surface, camera);
    if (!twin.ok()) return twin.error();
    Result<PicturePlanes> drawn = (*painter)->paint(*surface, camera);
    if (!drawn.ok()) return drawn.error();
    std::size_t covered = 0, different = 0;
    for (std::size_t k = 0; k < twin->z.size(); ++k) {
        covered += twin->z[k] > 0;
        different += !(std::fabs(twin->z[k] - drawn->z[k]) <= 1e-6F);
    }
    if (different > covered / 1000)
        return wrong(c, std::to_string(different) + " pixels of " + std::to_string(covered) +
                            " are not drawn as by the cpu painter");
    const auto times = least_times(frames, [&]() -> Result<void> {
        drawn = (*painter)->paint(*surface, camera);
        if (!drawn.ok()) return drawn.error();
        return {};
    });
    if (!times.ok()) return times.error();
    add_times(figures, "draw", *times);
    return {};
}

Result<void> measure(const SurfaceCase& c, int frames, const std::shared_ptr<SurfaceKernels>& kernels,
                     Figures& figures) {
    Picture picture(c);
    long mismatched = 0;
    for (const int side : {3, 5, 0}) {
        picture.scene.filter.median = side;
        const std::string what = std::to_string(side);
        const auto cpu = make_cpu_builder(picture.scene);
        auto vulkan = make_vulkan_builder(picture.scene, kernels, plan_for(kernels->device()->facts()));
        if (!vulkan.ok()) return vulkan.error();
        SurfaceFrame expected, frame;
        if (auto built = cpu->build(picture.raw, expected); !built.ok()) return built;
        const auto first = time_frames(**vulkan, picture.raw, frame, 1);
        if (!first.ok()) return first.error();
        mismatched += mismatches(expected, frame);
        if (mismatched > 0)
            return wrong(c,
                         std::to_string(mismatched) + " codes differ from the CPU builder's, median " + what);
        if (auto raced = race_for_codes(picture.scene, picture.raw, **vulkan, frames, figures); !raced.ok())
            return wrong(c, raced.error().message);
        double kernels_ms = 0;
        for (const GpuTime& stage : (*vulkan)->stages()) kernels_ms += stage.ms;
        figures.push_back({"codes" + what + "_kernels_ms", kernels_ms, "ms"});
        figures.push_back({"codes" + what + "_first_ms", first->wall_ms, "ms"});
        if (side == 0) continue;
        if (auto done = measure_mesh(c, picture, **vulkan, frames, kernels->device(), figures); !done.ok())
            return done;
        if (side == 5) continue;
        if (auto done = measure_drawing(c, picture, **vulkan, frames / 5, kernels->device(), figures);
            !done.ok())
            return done;
    }
    if (terrace_factor(picture.scene.depth) > 0)
        if (auto done = measure_terraces(c, picture, frames, kernels, figures); !done.ok()) return done;
    if (c.holes_pct > 0)
        if (auto done = measure_filling(c, picture, frames, kernels, figures); !done.ok()) return done;
    figures.push_back({"mismatched_codes", static_cast<double>(mismatched), ""});
    return {};
}

/// One device for all cases, opened when the first is measured.
class Shelf {
public:
    Result<std::shared_ptr<SurfaceKernels>> take() {
        if (!kernels_) {
            auto device = GpuDevice::open();
            if (!device.ok()) return device.error();
            kernels_ = std::make_shared<SurfaceKernels>(*device);
        }
        return kernels_;
    }

private:
    std::shared_ptr<SurfaceKernels> kernels_;
};

}  // namespace

std::vector<BenchCase> surface_cases(bool quick) {
    const auto shelf = std::make_shared<Shelf>();
    std::vector<BenchCase> cases;
    for (const SurfaceCase& c : {SurfaceCase{320, 240, 16},
                                 {720, 480, 8},
                                 {720, 480, 16},
                                 {1920, 1080, 8},
                                 {1920, 1080, 16},
                                 {1920, 1080, 16, 40},
                                 {3840, 2160, 16}}) {
        if (quick && c.width > 1920) continue;
        cases.push_back({name_of(c), [c, quick, shelf](Figures& figures) -> Result<void> {
                             auto kernels = shelf->take();
                             if (!kernels.ok()) return kernels.error();
                             return measure(c, quick ? 50 : 300, *kernels, figures);
                         }});
    }
    return cases;
}

}  // namespace touchable
