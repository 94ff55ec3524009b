#pragma once

#include <memory>
#include <string_view>

#include "engine/frame/surface_frame.hpp"
#include "engine/result.hpp"

namespace touchable {

/// RawFrame -> SurfaceFrame: decode, fill holes, median, tile bounds, all in integers (docs/conventions.md):
/// every builder gives the same bits. An invalid pixel's code is 0, and so are validity bits
/// beyond the width. Haptic and height planes are copied, never filtered. One thread at a time.
class SurfaceBuilder {
public:
    virtual ~SurfaceBuilder() = default;
    virtual std::string_view name() const = 0;
    /// `out` may be a recycled slot of any earlier size; its memory is reused. Refused, and `out` left as it
    /// was, where the raw planes do not have the scene's size and form.
    virtual Result<void> build(const RawFrame& raw, SurfaceFrame& out) = 0;
};

/// The obvious code: the definition that the others are tested against.
std::unique_ptr<SurfaceBuilder> make_reference_builder(const Scene& scene);
/// The whole frame, fast.
std::unique_ptr<SurfaceBuilder> make_cpu_builder(const Scene& scene);
/// Keeps the raw frame (and its storage) and filters a pixel when it is asked for: the paper's way. The frame
/// has no codes, validity or tiles of its own; its `vertices` answer instead.
std::unique_ptr<SurfaceBuilder> make_lazy_builder(const Scene& scene);

}  // namespace touchable
