#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/base/vector_unit.hpp"
#include "engine/scene/surface_frame.hpp"

namespace touchable {

/// RawFrame -> SurfaceFrame: decode, fill holes, median, temporal filter, terrace removal, tile bounds, all
/// in integers (docs/conventions.md): every builder gives the same bits. An invalid pixel's code is 0, and so
/// are validity bits beyond the width. Haptic and height planes are copied, never filtered. One thread at a
/// time. With a temporal filter a frame is made of all before it, which are to be built in order; one whose
/// number is not later, or whose epoch is another, begins anew.
class SurfaceBuilder {
public:
    virtual ~SurfaceBuilder() = default;
    virtual std::string_view name() const = 0;
    /// `out` may be a recycled slot of any earlier size; its memory is reused. Refused, and `out` left as it
    /// was, where the raw planes do not have the scene's size and form.
    virtual Result<void> build(const RawFrame& raw, SurfaceFrame& out) = 0;
    /// Of the last frame's tiles the share that was built, 0 to 1: the others were in the slot already, or
    /// are built when they are asked for.
    virtual double built_share() const { return 1; }
};

/// The obvious code: the definition that the others are tested against.
std::unique_ptr<SurfaceBuilder> make_reference_builder(const Scene& scene);
/// How the CPU builder does its work. The bits are the same with any plan.
struct CpuPlan {
    int threads = 0;  ///< with the one that builds; 0: as many as pay for the scene's size, at most 4
    VectorUnit vectors = VectorUnit::avx512;  ///< at most; what the CPU lacks is not used
    /// Of a frame that has changed in part, as much is built as has changed where that costs less than this
    /// share of what the whole does; all of it elsewhere. 0: always all; nothing: what pays.
    std::optional<double> break_even = std::nullopt;
};
/// Fast, on some threads of its own: they start with the first frame, sleep between frames, and are scheduled
/// as the thread that builds. A raw frame that keeps its planes alive (`storage`) is kept until the next one,
/// of which then only what has changed since the frame that the slot holds is built.
std::unique_ptr<SurfaceBuilder> make_cpu_builder(const Scene& scene);
std::unique_ptr<SurfaceBuilder> make_cpu_builder(const Scene& scene, const CpuPlan& plan);
/// Keeps the raw frame (its planes are to last as long, by `storage` or otherwise) and filters a pixel when
/// it is asked for: the paper's way. The frame has no codes, validity or tiles of its own; its `vertices`
/// answer instead. Refuses to build with a temporal filter (ErrorKind::input).
std::unique_ptr<SurfaceBuilder> make_lazy_builder(const Scene& scene);

}  // namespace touchable
