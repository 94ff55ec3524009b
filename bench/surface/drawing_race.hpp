// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "bench/suite.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// Cases of pictures of 1280x720 with five fingers, of the globe and, if available, of a recording: a
/// window's drawing (SurfaceDrawing) beside a picture in a file. `kernels` supplies the device.
std::vector<BenchCase> drawing_cases(bool quick,
                                     const std::function<Result<std::shared_ptr<SurfaceKernels>>()>& kernels);

/// Measures pictures of `width` x `height` of a surface of that size whose every pixel changes, with each GPU
/// painter and builder: a surface shown and drawn (`<painter>_<builder>`), and with a frame built before
/// (`..._frame`); each pair for `seconds`, at least twice.
Result<void> measure_pictures_by_builder(int width, int height, double seconds,
                                         const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures);

}  // namespace touchable
