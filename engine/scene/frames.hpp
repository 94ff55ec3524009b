// SPDX-License-Identifier: Apache-2.0
#pragma once

// The frames of a clip: as they are stored, and as the surface that is touched.
//
// A PlaneView shows a plane of samples that another object owns. A RawFrame is what a reader returns: depth,
// colour, haptic and height planes of one moment as stored, kept alive by `storage`; stored_code reads a
// depth sample as a code. A SurfaceFrame is what a builder makes of it: filtered codes, one validity bit per
// pixel, bounds of each tile, and the planes of touch. A VertexSource returns the depth of single pixels,
// from a frame's codes or computed on demand.
//
// Threads: any may read frames once they are published (engine/run): they do not change.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <type_traits>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"
#include "shaders/hue_code.h"

namespace touchable {

/// The number of pixels of a picture that is stored row by row, and the index, from 0, of the pixel in column
/// x and row y.
inline std::size_t pixel_count(int width, int height) {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}
inline std::size_t pixel_place(int x, int y, int width) {
    return pixel_count(width, y) + static_cast<std::size_t>(x);
}

/// A number that no other call in this process returns, never 0: it names samples that do not change any
/// more. Any thread.
std::uint64_t new_content_number();

/// Decoded samples of one picture, which another object owns. Samples of two bytes are in host order.
struct PlaneView {
    const std::uint8_t* data = nullptr;
    std::ptrdiff_t stride = 0;  ///< bytes from one row to the next
    int width = 0, height = 0;
    int bytes_per_sample = 1;  ///< 1 or 2
    int channels = 1;          ///< interleaved: 1, or 3 for red, green, blue
    /// Names these samples (new_content_number): views with the same number, place and form show the same
    /// samples. 0: the samples may change.
    std::uint64_t content = 0;

    bool empty() const { return data == nullptr; }
    const std::uint8_t* row(int y) const { return data + stride * y; }
    std::uint16_t sample(int x, int y, int channel = 0) const {
        const std::uint8_t* p =
            row(y) + (static_cast<std::ptrdiff_t>(x) * channels + channel) * bytes_per_sample;
        if (bytes_per_sample == 1) return *p;
        std::uint16_t value;
        std::memcpy(&value, p, 2);
        return value;
    }
    /// Bytes of a row's samples.
    std::size_t row_bytes() const {
        return pixel_count(width, channels) * static_cast<std::size_t>(bytes_per_sample);
    }
    /// Bytes of all samples.
    std::size_t bytes() const { return row_bytes() * static_cast<std::size_t>(height); }
    /// Copies all rows; their copies begin `pitch` bytes apart.
    void copy_rows(std::uint8_t* to, std::size_t pitch) const {
        for (int y = 0; y < height; ++y, to += pitch) std::memcpy(to, row(y), row_bytes());
    }
};

/// Samples that are stored row by row without gaps, as a plane.
inline PlaneView packed_plane(const std::uint8_t* data, int width, int height, int bytes_per_sample,
                              int channels) {
    const std::ptrdiff_t stride = std::ptrdiff_t{width} * bytes_per_sample * channels;
    return {data, stride, width, height, bytes_per_sample, channels};
}
/// Codes of two bytes that are stored row by row, as a plane of one channel.
inline PlaneView plane_of_codes(const std::uint16_t* codes, int width, int height) {
    return packed_plane(reinterpret_cast<const std::uint8_t*>(codes), width, height, 2, 1);
}

/// The planes of one moment as stored, all of the scene's width and height. Only depth is always present.
struct RawFrame {
    std::int64_t number = 0;   ///< from 0
    std::int64_t time_ns = 0;  ///< presentation timestamp
    PlaneView depth;           ///< 1 channel, stored values; for hue 3 channels, 8 bits
    PlaneView colour;          ///< 3 channels, 8 bits
    PlaneView haptic;          ///< 3 channels, 8 bits: stiffness, static friction, dynamic friction
    PlaneView height;          ///< 1 channel
    /// Keeps the planes alive and unchanged; null: they last only as long as the call that receives them.
    std::shared_ptr<const void> storage;
    /// Epoch of the clip's clock (MediaMoment); 0 from a reader. Frames of two epochs are not neighbours,
    /// whatever their numbers.
    std::uint64_t epoch = 0;
    /// Pixels whose depth comes from other frames of the clip (with_filled_holes), as the bits of
    /// SurfaceFrame::validity; null: none. It only shows where depth was not measured.
    std::shared_ptr<const std::vector<std::uint32_t>> filled;

    /// Identifies a frame that is no longer held. Frames between two of an epoch may have been left out.
    struct Place {
        std::uint64_t epoch = 0;
        std::int64_t number = 0;

        explicit Place(const RawFrame& raw) : epoch(raw.epoch), number(raw.number) {}
        bool is_before(const RawFrame& raw) const { return epoch == raw.epoch && number < raw.number; }
    };
};

/// True if samples of both planes can be compared byte by byte, or both are empty.
bool same_form(const PlaneView& a, const PlaneView& b);
/// True if both planes have the same form and samples, or both are empty. Stops at the first row that
/// differs; planes at the same place are not compared.
bool same_samples(const PlaneView& a, const PlaneView& b);

/// True if depth, haptic and height planes, from which a surface is made, have the same form and samples.
/// Stops at the first row that differs.
bool same_touch_planes(const RawFrame& a, const RawFrame& b);

/// The code of a hue pixel without a depth; beyond every coding's valid codes.
inline constexpr std::uint16_t no_hue = 0xFFFF;

/// The code of a pixel of a depth plane, valid or not (DepthCoding::is_valid): the stored value, or the hue
/// of three channels.
inline std::uint16_t stored_code(const PlaneView& depth, const DepthCoding& coding, int x, int y) {
    static_assert(DepthCoding::hue_circle == HUE_CODE_CIRCLE);
    if (coding.kind != DepthCodingKind::hue) return depth.sample(x, y);
    const std::uint8_t* rgb = depth.row(y) + std::ptrdiff_t{3} * x;
    if (!hue_is_valid(rgb[0], rgb[1], rgb[2], static_cast<uint>(coding.least_sum))) return no_hue;
    return static_cast<std::uint16_t>(hue_code(rgb[0], rgb[1], rgb[2]));
}

/// Metres of each of the 65536 codes; NaN: it means no depth.
std::vector<float> metres_of_codes(const DepthCoding& coding, double metres_per_unit);

/// Whether a stored depth picture has any valid pixel; stops at the first one.
inline bool has_valid_pixel(const PlaneView& depth, const DepthCoding& coding) {
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
            if (coding.is_valid(stored_code(depth, coding, x, y))) return true;
    return false;
}

/// Red, green and blue of a pixel that the colour camera does not see, such as one outside its picture.
inline constexpr std::uint8_t unseen_colour = 128;

/// `rgb`: three samples.
inline bool is_unseen_colour(const std::uint8_t* rgb) {
    return rgb[0] == unseen_colour && rgb[1] == unseen_colour && rgb[2] == unseen_colour;
}

/// One plane of a frame: an array in its own memory, or in another owner's, which it keeps alive (a GPU's,
/// mapped). A change of its size brings it back to its own memory; a copy always has its own.
template <class T>
class FrameArray {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    using value_type = T;
    using iterator = T*;
    using const_iterator = const T*;

    FrameArray() = default;
    FrameArray(const FrameArray& other) : own_(other.begin(), other.end()) { show_own(); }
    FrameArray(FrameArray&& other) noexcept { swap(other); }
    FrameArray& operator=(FrameArray other) noexcept {
        swap(other);
        return *this;
    }
    ~FrameArray() = default;

    /// Makes `memory`, which belongs to `owner`, the array.
    void adopt(std::span<T> memory, std::shared_ptr<const void> owner) {
        own_ = {};
        owner_ = std::move(owner);
        data_ = memory.data();
        size_ = memory.size();
    }
    bool adopted() const { return owner_ != nullptr; }

    /// New elements are zero; adopted elements are dropped, as by `assign` and `clear`.
    void resize(std::size_t size) {
        change([&] { own_.resize(size); });
    }
    void assign(std::size_t size, const T& value) {
        change([&] { own_.assign(size, value); });
    }
    void clear() {
        change([&] { own_.clear(); });
    }
    void push_back(const T& value) {
        change([&] { own_.push_back(value); });
    }

    T* data() { return data_; }
    const T* data() const { return data_; }
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    T& operator[](std::size_t n) { return data_[n]; }
    const T& operator[](std::size_t n) const { return data_[n]; }
    iterator begin() { return data_; }
    iterator end() { return data_ + size_; }
    const_iterator begin() const { return data_; }
    const_iterator end() const { return data_ + size_; }

    friend bool operator==(const FrameArray& a, const FrameArray& b) {
        return std::equal(a.begin(), a.end(), b.begin(), b.end());
    }
    friend bool operator==(const FrameArray& a, const std::vector<T>& b) {
        return std::equal(a.begin(), a.end(), b.begin(), b.end());
    }

private:
    template <class Change>
    void change(Change&& change_own) {
        owner_.reset();
        change_own();
        show_own();
    }
    void show_own() {
        data_ = own_.data();
        size_ = own_.size();
    }
    void swap(FrameArray& other) noexcept {
        own_.swap(other.own_);
        owner_.swap(other.owner_);
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
    }

    std::vector<T> own_;
    std::shared_ptr<const void> owner_;  // of adopted memory
    T* data_ = nullptr;
    std::size_t size_ = 0;
};

struct SurfaceFrame;
struct TileBounds;

/// Depth of one pixel, before height is subtracted. If it is not valid, depth has no meaning.
struct DepthSample {
    double depth = 0;  ///< scene units, of the coding's semantics
    bool valid = false;
};

/// Bounds on the valid depths of a tile's 17x17 vertices; may be wider than they need to be.
struct TileDepths {
    double nearest = 0, farthest = 0;  ///< scene units; nearest > farthest: no pixel is valid
    bool any_invalid = false;
};

/// Converts bounds of codes into bounds of depths.
TileDepths depths_of(const TileBounds& bounds, const DepthCoding& coding);

/// Depth and validity at a pixel, from any source. Wait-free, no allocation; the haptic thread may call it
/// while other threads read, too.
class VertexSource {
public:
    virtual ~VertexSource() = default;
    /// 0 <= x < width, 0 <= y < height.
    virtual DepthSample at(int x, int y) const = 0;
    /// 0 <= tx < tiles_x, 0 <= ty < tiles_y of the frame (see TileGrid).
    virtual TileDepths tile(int tx, int ty) const = 0;
    /// The frame whose codes and validity these vertices merely return, if any: a caller that needs many
    /// pixels reads them there (`sample_of`).
    virtual const SurfaceFrame* read_from() const { return nullptr; }
};

/// Reads the filtered codes, validity and bounds of a SurfaceFrame, which must outlive it.
class FilteredVertices : public VertexSource {
public:
    explicit FilteredVertices(const SurfaceFrame& frame) : frame_(frame) {}
    DepthSample at(int x, int y) const override;
    TileDepths tile(int tx, int ty) const override;
    const SurfaceFrame* read_from() const override { return &frame_; }

private:
    const SurfaceFrame& frame_;
};

/// Unquantised depths, for scenes with known ground truth. Only a depth that is not finite is invalid.
class ExactVertices final : public VertexSource {
public:
    /// `depths`: width x height, row-major, scene units. If there are fewer, the other pixels are invalid.
    ExactVertices(int width, int height, std::vector<double> depths);
    DepthSample at(int x, int y) const override;
    TileDepths tile(int tx, int ty) const override;

private:
    TileDepths bound(int tx, int ty) const;

    int width_, height_;
    std::vector<double> depths_;
    std::vector<TileDepths> tiles_;
};

/// Tiles of 16x16 cells, so of 17x17 vertices. Cell (i, j) lies between pixels (i, j) and (i+1, j+1); the
/// cells of the ring around the picture, and everything beyond, belong to the nearest tile.
struct TileGrid {
    static constexpr int cells = 16;
    int tiles_x = 1, tiles_y = 1;

    static TileGrid of(int width, int height) {
        auto count = [](int pixels) { return pixels <= 1 ? 1 : (pixels - 1 + cells - 1) / cells; };
        return {count(width), count(height)};
    }
    std::size_t count() const { return pixel_count(tiles_x, tiles_y); }
    int column_of_cell(int i) const { return i < 0 ? 0 : (i / cells < tiles_x ? i / cells : tiles_x - 1); }
    int row_of_cell(int j) const { return j < 0 ? 0 : (j / cells < tiles_y ? j / cells : tiles_y - 1); }
};

/// Bounds of the valid codes of a tile's vertices inside the picture; least > greatest (65535, 0): none is
/// valid. Eight bytes, as kernels write them.
struct alignas(8) TileBounds {
    std::uint16_t least = 65535, greatest = 0;
    bool any_invalid = false;
    bool operator==(const TileBounds&) const = default;
};

/// How wrong a force may be because depth is: about 95 of 100 are not more wrong (docs/measurements.md,
/// Error bars). NaN: cannot be told.
struct ErrorBar {
    double degrees = std::numeric_limits<double>::quiet_NaN();  ///< direction, to either side
    double depth = std::numeric_limits<double>::quiet_NaN();    ///< surface, scene units to either side
};

/// What a filtered frame shows of its camera's errors (with_error_bars; docs/measurements.md, Error bars).
/// Empty: not wanted.
struct ErrorSigns {
    static constexpr int side = 5;  ///< of a block, pixels
    /// Of a block of pixels. Without a surface, depth is 0.
    struct Block {
        float depth = 0;    ///< planar, scene units
        float scatter = 0;  ///< of its faces' normals: the mean square of their distances to the mean one
        float lean = 0;     ///< distance of its mean normal to that of the 3x3 blocks around it
        float turn = 0;     ///< of a face, per scene unit of error from one pixel to the next
    };

    int columns = 0;
    std::vector<Block> blocks;  ///< row by row
    double bend = 0;            ///< by which depth errs from pixel to pixel over wide parts, scene units
    double drift = 0;           ///< of whole frames, as a share of depth
    double focal_length = 1;    ///< pixels

    /// Squares whose weighted sum is a bar's square: degrees and scene units.
    struct Squares {
        std::array<double, 4> angle, depth;
    };
    static const Squares weights;  ///< fitted to cameras with known errors
    /// Nothing if the block has no surface.
    std::optional<Squares> squares(const Block& block) const;
    ErrorBar bar(const Block& block) const;
    /// The block nearest to this place of the picture; null without blocks, and if the place is NaN.
    const Block* block_at(double x, double y) const;
    ErrorBar bar_at(double x, double y) const;
};

/// One filtered frame. Filled by a SurfaceBuilder, then immutable until its slot is recycled; its timestamp
/// lives in the SurfaceTimeline, because an unchanged frame is published again at a later time. It must not
/// move: its vertices refer to it.
struct SurfaceFrame {
    SurfaceFrame() = default;
    SurfaceFrame(const SurfaceFrame&) = delete;
    SurfaceFrame& operator=(const SurfaceFrame&) = delete;

    int width = 0, height = 0;
    DepthCoding coding;                  ///< of `codes`; finer than the scene's if a filter adds precision
    FrameArray<std::uint16_t> codes;     ///< width x height, row-major; empty if not needed (lazy, exact)
    FrameArray<std::uint32_t> validity;  ///< one bit per pixel, rows padded to whole words, low bit first
    FrameArray<TileBounds> tiles;        ///< tiles_x x tiles_y of TileGrid::of(width, height), row-major
    std::vector<std::uint8_t> haptic;    ///< width x height x 3, never filtered; empty: the scene's defaults
    std::vector<std::uint16_t> heights;  ///< width x height codes, never filtered; empty: no height
    ErrorSigns signs;
    RawFrame raw;                        ///< the raw frame, if the vertices still read it (lazy)
    /// RawFrame::filled of the raw frame
    std::shared_ptr<const std::vector<std::uint32_t>> filled;
    std::unique_ptr<VertexSource> vertices;  ///< how the solver reads this frame; set by the builder
    /// Names the frame's content (new_content_number): each SurfaceTimeline::publish sets a new number. 0:
    /// the frame was never published, and its planes may change.
    std::uint64_t content = 0;

    int validity_words_per_row() const { return (width + 31) / 32; }
    std::size_t index(int x, int y) const { return pixel_place(x, y, width); }
    std::uint32_t* validity_row(int y) {
        return validity.data() + std::ptrdiff_t{y} * validity_words_per_row();
    }
    const std::uint32_t* validity_row(int y) const {
        return validity.data() + std::ptrdiff_t{y} * validity_words_per_row();
    }
    bool is_valid(int x, int y) const { return (validity_row(y)[x >> 5] >> (x & 31)) & 1U; }
};

/// Depth of a pixel of a frame that has codes, and whether it is valid.
inline DepthSample sample_of(const SurfaceFrame& frame, int x, int y) {
    if (!frame.is_valid(x, y)) return {};
    return {frame.coding.depth(frame.codes[frame.index(x, y)]), true};
}

/// True for a frame of this size with vertices, whose planes are of that size or empty.
bool has_size(const SurfaceFrame& frame, int width, int height);

/// Copies the haptic and height planes of a raw frame, or empties them if it has none.
void copy_touch_planes(const RawFrame& raw, SurfaceFrame& out);

/// A published frame and its moment.
struct TimedFrame {
    std::int64_t number = -1;  ///< of the clip's frame
    std::int64_t time_ns = 0;
    const SurfaceFrame* frame = nullptr;
};

/// The frames around a moment. `next` equals `prev`, and blend is 0, before the first frame, from the last
/// on, and while the producer is late.
struct FramePair {
    TimedFrame prev, next;
    double blend = 0;  ///< 0 at prev's time, towards 1 at next's
    /// Epoch of the clip's clock: frames of two epochs are unrelated, whatever their times.
    std::uint64_t epoch = 0;

    /// The frame nearer in time.
    const TimedFrame& nearer() const { return blend < 0.5 ? prev : next; }
};

}  // namespace touchable
