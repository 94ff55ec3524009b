#include <string>

#include "engine/base/try.hpp"

#include "player/draw/gpu_painters.hpp"

namespace touchable {
namespace {

using OpenGpu = std::function<Result<std::shared_ptr<GpuDevice>>()>;

Result<std::unique_ptr<SurfacePainter>> gpu_painter(std::string_view name, const OpenGpu& open_gpu) {
    TRY_ASSIGN(auto device, open_gpu());
    const GpuFacts& facts = device->facts();
    const bool draws_fast = facts.kind != GpuKind::software && facts.draws_triangles;
    if (name == "mesh" || (name == "auto" && draws_fast)) return make_mesh_painter(std::move(device));
    return make_raster_painter(std::move(device));
}

}  // namespace

Result<std::unique_ptr<SurfacePainter>> make_painter(std::string_view name, const OpenGpu& open_gpu) {
    if (name == "cpu") return make_cpu_painter();
    if (name != "auto" && name != "raster" && name != "mesh")
        return usage_error(
            "painter " + std::string(name) + " is not known; there are auto, cpu, raster and mesh",
            {{Setting::painter}});
    auto painter = gpu_painter(name, open_gpu);
    if (!painter.ok() && name == "auto") return make_cpu_painter();
    return painter;
}

}  // namespace touchable
