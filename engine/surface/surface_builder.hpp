#pragma once

// A RawFrame becomes a SurfaceFrame: decoded, filtered, bounded, in integers that are the same for every
// builder.
//
// A FilterPlan is made of a Scene: it is the one place that says which filters there are, in which order, how
// far each reaches, whether it remembers earlier frames and what its codes mean. Builders go by it:
// make_reference_builder (plain code, for tests), make_cpu_builder (vectors, rows on several threads, and
// frames that changed little built in part), make_lazy_builder (the paper's: pixels that are touched, when
// they are touched), make_fallback_builder (another one, such as the GPU's, until it fails). engine/gpu has
// the one for Vulkan. make_mesh and write_ply hand a frame's surface to other programs, as triangles.
//
// A builder is used by one thread at a time, and sees the frames of an epoch in order. It allocates only
// until the first frames are built. Errors are lines about the frame (what is wrong with its planes).

#include <array>
#include <glm/vec3.hpp>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/vectors.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What becomes of a scene's stored values: which filters they go through, in what order, how far each of
/// them looks, what it remembers, and what the codes mean in the end. All builders go by it.
struct FilterPlan {
    /// Passes that fill holes from their rims.
    struct HoleFilling {
        int passes = 0;
        bool operator==(const HoleFilling&) const = default;
    };
    /// The lower median of a window of `side` x `side` pixels, 3 or 5.
    struct MedianWindow {
        int side = 0;
        bool operator==(const MedianWindow&) const = default;
    };
    /// Every builder has an overload for each, so that none of them can miss a new one.
    using Filter = std::variant<FlyingPixels, HoleFilling, MedianWindow, TemporalFilter, TerraceFilter>;
    struct Stage {
        Filter filter;
        /// How far away, along x and along y, a pixel may be that another one depends on; nothing where that
        /// may be one of a frame before.
        std::optional<int> reach;
        /// Of the codes that it leaves: each valid one is in its valid range, and 0 only where that has it.
        DepthCoding coding;
        bool operator==(const Stage&) const = default;
    };

    /// Needs a scene that `validate` accepts.
    explicit FilterPlan(const Scene& scene);

    DepthCoding stored;          ///< of the codes that stored values are
    std::vector<Stage> filters;  ///< in order; empty: values are only decoded

    const DepthCoding& coding() const { return filters.empty() ? stored : filters.back().coding; }
    /// Of all filters together; nothing where one remembers frames before.
    std::optional<int> reach() const;
    bool remembers() const { return !reach(); }
    /// Null where the scene does not ask for it.
    template <class F>
    const F* find() const {
        for (const Stage& stage : filters)
            if (const F* filter = std::get_if<F>(&stage.filter)) return filter;
        return nullptr;
    }
    bool operator==(const FilterPlan&) const = default;
};

/// Refuses planes that are not of the scene's size, or whose samples are not what the scene says; the message
/// names frame and plane.
Result<void> check_raw_frame(const RawFrame& raw, const Scene& scene);

/// The stored codes of a depth plane, row by row; of invalid pixels `invalid`.
struct CodePicture {
    static constexpr int invalid = -1;

    int width = 0, height = 0;
    std::vector<int> codes;

    const int* row(int y) const {
        return codes.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    }
};
CodePicture code_picture(const PlaneView& depth, const DepthCoding& coding);

/// Codes of about the same depth are looked at together: 64, or an eighth of the first one where that is
/// more. The code after those that begin with `first`.
constexpr int end_of_window(int first) {
    const int width = first / 8 > 64 ? first / 8 : 64;
    return first + width < 65536 ? first + width : 65536;
}

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

    /// The same in two steps: frames that are begun are finished in that order, and another may be begun
    /// before the first of so many is finished, which a builder on a GPU works at side by side. Planes last
    /// (`storage`) until their frame is finished. None may be begun where one is built.
    virtual int frames_in_flight() const { return 1; }
    virtual Result<void> begin(const RawFrame& raw);
    virtual Result<void> finish(SurfaceFrame& out);
    /// Of the last frame's tiles the share that was built, 0 to 1: the others were in the slot already, or
    /// are built when they are asked for.
    virtual double built_share() const { return 1; }

private:
    RawFrame begun_;  // where they are not built side by side
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
std::unique_ptr<SurfaceBuilder> make_cpu_builder(const Scene& scene, const CpuPlan& plan = {});
/// Keeps the raw frame (its planes are to last as long, by `storage` or otherwise) and filters a pixel when
/// it is asked for: the paper's way. The frame has no codes, validity or tiles of its own; its `vertices`
/// answer instead. Refuses to build with a temporal filter (ErrorKind::input).
std::unique_ptr<SurfaceBuilder> make_lazy_builder(const Scene& scene);

/// Builds with `first` until that fails with ErrorKind::gpu; then with `second`, beginning with the very
/// frame that failed: the same bits, so no frame and no force is lost. Other errors are passed on. `told` is
/// called once, with a line for people ("frame 12: vkQueueSubmit2: ...; the cpu builder goes on"); its name
/// says which of the two builds.
std::unique_ptr<SurfaceBuilder> make_fallback_builder(std::unique_ptr<SurfaceBuilder> first,
                                                      std::unique_ptr<SurfaceBuilder> second,
                                                      std::function<void(const std::string&)> told);

/// The surface as triangles in the world (X right, Y up, camera at the origin looking along -Z), in scene
/// units. Every valid pixel is a vertex, height taken off; every cell of four valid pixels is two triangles,
/// cut by the diagonal from (i, j) to (i+1, j+1), counter-clockwise as the camera sees them.
struct Mesh {
    int width = 0, height = 0;                            ///< of the picture
    std::vector<glm::dvec3> positions;                    ///< row by row
    std::vector<std::uint32_t> pixels;                    ///< y * width + x of each position, ascending
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of positions
};
/// Of a frame from any builder; `scene` is the one it was built for.
Mesh make_mesh(const SurfaceFrame& frame, const Scene& scene);

enum class PlyCoordinates { single_precision, double_precision };
/// Binary little-endian PLY: x, y, z in scene units, red, green, blue where there is a colour plane (3
/// channels of 8 bits, of the mesh's picture), and triangles. The caller commits `file`.
Result<void> write_ply(NewFile& file, const Mesh& mesh, const PlaneView& colour = {},
                       PlyCoordinates coordinates = PlyCoordinates::single_precision);

/// A frame's valid depths, row by row, scene units; the far plane where none is valid. Of a frame larger than
/// 4096x4096 every so many pixels, evenly spread. Of a lazy frame all of it is built for that. Unfinished
/// where it is asked to stop meanwhile.
std::vector<double> valid_depths(const Scene& scene, const SurfaceFrame& frame);

/// So many of them, of all (`share`: 0 to 1), are not above it. Needs one; changes their order.
double quantile(std::vector<double>& depths, double share);

}  // namespace touchable
