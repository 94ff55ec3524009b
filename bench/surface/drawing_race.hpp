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

/// Pictures of `width` x `height` of a surface of that size of which every pixel changes, by each GPU painter
/// and of frames by each builder: a surface shown and drawn (`<painter>_<builder>`), and a frame built before
/// that (`..._frame`); each pair for so many seconds, and twice at least.
Result<void> measure_pictures_by_builder(int width, int height, double seconds,
                                         const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures);

}  // namespace touchable
