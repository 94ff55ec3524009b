// SPDX-License-Identifier: Apache-2.0
#pragma once

// A RawFrame becomes a SurfaceFrame: decoded, filtered, bounded, in integers that are the same for every
// builder.
//
// A FilterPlan, made from a Scene, is the only place that states which filters there are, in which order, how
// far each reaches, whether it depends on earlier frames and what its codes mean. Builders follow it:
// make_reference_builder (plain code, for tests), make_cpu_builder (vectors, rows on several threads, and
// partial builds of frames that changed little), make_lazy_builder (the paper's: pixels when they are
// touched), make_fallback_builder (another one, such as the GPU's, until it fails). engine/gpu has the one
// for Vulkan. A frame leaves as stored depth (filtered_scene), as floats (FilteredDepth) or as triangles
// (make_mesh, write_ply).
//
// Threads: one at a time uses a builder, and gives it the frames of an epoch in order. It allocates only
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

/// The processing of a scene's stored values: which filters, in what order, how far each reaches, what it
/// remembers, and what the final codes mean. All builders follow it.
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
        /// Largest distance, along x and y, to a pixel on which another one depends; nothing if it depends on
        /// earlier frames.
        std::optional<int> reach;
        /// Of the codes that it leaves: valid ones are in its valid range, and 0 only if the range has it.
        DepthCoding coding;
        bool operator==(const Stage&) const = default;
    };

    /// `scene` has to pass `validate`.
    explicit FilterPlan(const Scene& scene);

    DepthCoding stored;          ///< of the stored values
    std::vector<Stage> filters;  ///< in order; empty: values are only decoded

    const DepthCoding& coding() const { return filters.empty() ? stored : filters.back().coding; }
    /// Of all filters together; nothing if one depends on earlier frames.
    std::optional<int> reach() const;
    bool remembers() const { return !reach(); }
    /// Null if the scene has no such filter.
    template <class F>
    const F* find() const {
        for (const Stage& stage : filters)
            if (const F* filter = std::get_if<F>(&stage.filter)) return filter;
        return nullptr;
    }
    bool operator==(const FilterPlan&) const = default;
};

/// Refuses planes that do not have the scene's size, or the samples that it states; the message names frame
/// and plane.
Result<void> check_raw_frame(const RawFrame& raw, const Scene& scene);

/// The stored codes of a depth plane, row by row; `invalid` for invalid pixels.
struct CodePicture {
    static constexpr int invalid = -1;

    int width = 0, height = 0;
    std::vector<int> codes;

    const int* row(int y) const { return codes.data() + pixel_place(0, y, width); }
};
CodePicture code_picture(const PlaneView& depth, const DepthCoding& coding);

/// Codes of about the same depth are evaluated together: 64, or an eighth of the first one if that is more.
/// Returns the code after the window that begins with `first`.
constexpr int end_of_window(int first) {
    const int width = first / 8 > 64 ? first / 8 : 64;
    return first + width < 65536 ? first + width : 65536;
}

/// RawFrame -> SurfaceFrame: decode, pull flying pixels in, fill holes, median, temporal filter, terrace
/// removal, tile bounds, all in integers (docs/conventions.md): every builder gives the same bits. An invalid
/// pixel's code is 0, and so are validity bits beyond the width. Haptic and height planes are copied, never
/// filtered. One thread at a time. With a temporal filter a frame depends on all before it, which have to be
/// built in order; a frame whose number is not later, or whose epoch differs, begins anew.
class SurfaceBuilder {
public:
    virtual ~SurfaceBuilder() = default;
    virtual std::string_view name() const = 0;
    /// `out` may be a recycled slot of any earlier size; its memory is reused. Raw planes without the scene's
    /// size and form are refused, and `out` stays as it was.
    virtual Result<void> build(const RawFrame& raw, SurfaceFrame& out) = 0;

    /// The same in two steps: frames are finished in the order in which they were begun, and up to
    /// `frames_in_flight` may be begun before the first is finished; a GPU builder works on them in parallel.
    /// Planes last (`storage`) until their frame is finished. No frame may be in flight during `build`.
    virtual int frames_in_flight() const { return 1; }
    virtual Result<void> begin(const RawFrame& raw);
    virtual Result<void> finish(SurfaceFrame& out);
    /// Share of the last frame's tiles that were built, 0 to 1: the others were in the slot already, or are
    /// built when they are read.
    virtual double built_share() const { return 1; }

private:
    RawFrame begun_;  // for builders that build in `finish`
};

/// The plain code: the definition against which the others are tested.
std::unique_ptr<SurfaceBuilder> make_reference_builder(const Scene& scene);
/// Options of the CPU builder. The bits are the same with any of them.
struct CpuPlan {
    int threads = 0;  ///< with the building one; 0: as many as pay for the scene's size, at most 4
    VectorUnit vectors = VectorUnit::avx512;  ///< at most; units that the CPU lacks are not used
    /// Only the changed parts of a frame are built if that costs less than this share of a whole build;
    /// otherwise all of it. 0: always all; nothing: what pays.
    std::optional<double> break_even = std::nullopt;
};
/// Fast, on its own threads: they start with the first frame, sleep between frames, and are scheduled like
/// the building thread. A raw frame that keeps its planes alive (`storage`) is kept until the next one, of
/// which then only the changes since the frame in the slot are built.
std::unique_ptr<SurfaceBuilder> make_cpu_builder(const Scene& scene, const CpuPlan& plan = {});
/// Keeps the raw frame (its planes have to last as long, by `storage` or otherwise) and filters a pixel when
/// it is read: the paper's way. The frame has no codes, validity or tiles; its `vertices` return them
/// instead. Refuses to build with a temporal filter (ErrorKind::input).
std::unique_ptr<SurfaceBuilder> make_lazy_builder(const Scene& scene);

/// Builds with `first` until that fails with ErrorKind::gpu; then with `second`, beginning with the frame
/// that failed: the same bits, so no frame and no force is lost. Other errors are passed on. `told` is called
/// once, with a line for people ("frame 12: vkQueueSubmit2: ...; the cpu builder goes on"); `name` says which
/// of the two builds.
std::unique_ptr<SurfaceBuilder> make_fallback_builder(std::unique_ptr<SurfaceBuilder> first,
                                                      std::unique_ptr<SurfaceBuilder> second,
                                                      std::function<void(const std::string&)> told);

/// As `builder`, and measures how wrong the touch of each frame may be (SurfaceFrame::signs) by what its
/// filtered surface shows: docs/measurements.md, Error bars. An error that neither scatters, leans nor bends
/// the surface, such as a wrong scale, cannot be seen.
std::unique_ptr<SurfaceBuilder> with_error_bars(std::unique_ptr<SurfaceBuilder> builder, const Scene& scene);

/// The scene of a frame's filtered codes when they are stored as depth: with these codes and no filters, it
/// gives `scene`'s forces, to the bit. If filters look codes up (WorkingCodes::table), its far plane is the
/// deepest stored code's depth.
Scene filtered_scene(Scene scene);
/// A code that means no depth; nothing if all 65536 codes are valid.
std::optional<std::uint16_t> code_of_no_depth(const DepthCoding& coding);
/// Copies a built frame's codes, row by row; invalid pixels get `no_depth`.
void copy_codes(const SurfaceFrame& frame, std::uint16_t no_depth, std::uint16_t* to);

/// Rows of floats in another owner's memory.
struct FloatRows {
    float* data = nullptr;
    std::ptrdiff_t stride = 0;  ///< bytes from one row to the next

    float* row(int y) const {
        return reinterpret_cast<float*>(reinterpret_cast<unsigned char*>(data) + stride * y);
    }
};
class InverseDepths;
/// What filters make of depth, as floats; NaN: no surface. For frames of one scene with codes (not lazy).
/// Keeps tables of their codes. One thread at a time.
class FilteredDepth {
public:
    explicit FilteredDepth(const Scene& scene);
    ~FilteredDepth();
    /// Metres, as the codes measure depth: along -Z or along each pixel's ray.
    void metres(const SurfaceFrame& frame, const FloatRows& to);
    /// Unit normals, x, y and z of each pixel, towards the camera; axes of the world (X right, Y up, the
    /// camera looks along -Z). NaN also where no neighbour shows how the surface lies.
    void normals(const SurfaceFrame& frame, const FloatRows& to);
    /// ErrorBar::degrees of each pixel's block, of frames with_error_bars.
    void error_degrees(const SurfaceFrame& frame, const FloatRows& to) const;

private:
    const Camera camera_;
    const double metres_per_unit_;
    std::unique_ptr<InverseDepths> depths_;
    DepthCoding coding_;
    std::vector<float> metres_;  // of each code
};

/// The surface as triangles in the world (X right, Y up, camera at the origin looking along -Z), in scene
/// units. Every valid pixel is a vertex, height taken off; every cell of four valid pixels is two triangles,
/// cut by the diagonal from (i, j) to (i+1, j+1), counter-clockwise as the camera sees them.
struct Mesh {
    int width = 0, height = 0;                            ///< of the picture
    std::vector<glm::dvec3> positions;                    ///< row by row
    std::vector<std::uint32_t> pixels;                    ///< y * width + x of each position, ascending
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of positions
};
/// From a frame of any builder; `scene` is the one it was built for.
Mesh make_mesh(const SurfaceFrame& frame, const Scene& scene);

/// Binary little-endian PLY: x, y, z in scene units, red, green, blue if there is a colour plane (3 channels
/// of 8 bits, of the mesh's picture), and triangles. The caller commits `file`.
Result<void> write_ply(NewFile& file, const Mesh& mesh, const PlaneView& colour = {});

/// A frame's valid depths, row by row, scene units; the far plane if none is valid. Only some pixels, evenly
/// spread, of a frame larger than 4096x4096. A lazy frame is built as a whole for this. Incomplete after a
/// stop request.
std::vector<double> valid_depths(const Scene& scene, const SurfaceFrame& frame);

/// The depth that a share (0 to 1) of all depths does not exceed. Needs at least one depth; reorders them.
double quantile(std::vector<double>& depths, double share);

}  // namespace touchable
