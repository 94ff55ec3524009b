#pragma once

#include <functional>
#include <string>

#include "engine/surface/surface_builder.hpp"

namespace touchable {

/// Builds with `first` until that fails with ErrorKind::gpu; then with `second`, beginning with the very
/// frame that failed: the same bits, so no frame and no force is lost. Other errors are passed on. `told` is
/// called once, with a line for people ("frame 12: vkQueueSubmit2: ...; the cpu builder goes on"); its name
/// says which of the two builds.
std::unique_ptr<SurfaceBuilder> make_fallback_builder(std::unique_ptr<SurfaceBuilder> first,
                                                      std::unique_ptr<SurfaceBuilder> second,
                                                      std::function<void(const std::string&)> told);

}  // namespace touchable
