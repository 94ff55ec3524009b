#pragma once

#include <memory>

#include "bench/suite.hpp"
#include "bench/surface/surface_case.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// Codes that differ, and one more for each of validity and bounds that does.
long mismatches(const SurfaceFrame& expected, const SurfaceFrame& actual);

/// Codes with as many passes of hole filling as there may be, of which most find nothing left to fill.
Result<void> measure_filling(const SurfaceCase& c, const Picture& picture, int frames,
                             const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures);
/// Codes without terraces, where they have bits to spare for that.
Result<void> measure_terraces(const SurfaceCase& c, const Picture& picture, int frames,
                              const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures);
/// The raster painter's own view, a pixel of the picture for every one of the frame.
Result<void> measure_drawing(const SurfaceCase& c, const Picture& picture, SurfaceBuilder& builder,
                             int frames, const std::shared_ptr<GpuDevice>& device, Figures& figures);

}  // namespace touchable
