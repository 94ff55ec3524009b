// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "bench/suite.hpp"
#include "bench/surface/surface_case.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// Number of different codes, plus one each if validity or bounds differ.
long mismatches(const SurfaceFrame& expected, const SurfaceFrame& actual);

/// Measures codes with the most passes of hole filling; most passes find nothing left to fill.
Result<void> measure_filling(const SurfaceCase& c, const Picture& picture, int frames,
                             const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures);
/// Measures codes with terrace removal, if they have spare bits.
Result<void> measure_terraces(const SurfaceCase& c, const Picture& picture, int frames,
                              const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures);
/// Measures the raster painter's own view, one picture pixel per frame pixel.
Result<void> measure_drawing(const SurfaceCase& c, const Picture& picture, SurfaceBuilder& builder,
                             int frames, const std::shared_ptr<GpuDevice>& device, Figures& figures);

}  // namespace touchable
