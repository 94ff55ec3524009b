#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "bench/suite.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// Cases of pictures of 1280x720 with five fingers, of the globe and, where it is there, of a recording: what
/// a window draws (SurfaceDrawing) beside what a picture in a file needs. `kernels` gives the device.
std::vector<BenchCase> drawing_cases(bool quick,
                                     const std::function<Result<std::shared_ptr<SurfaceKernels>>()>& kernels);

}  // namespace touchable
