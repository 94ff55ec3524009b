#pragma once

// The frames of a clip: as they are stored, and as the surface that is touched.
//
// A PlaneView shows a plane of samples that another object owns. A RawFrame is what a reader gives: depth,
// colour, haptic and height planes of one moment as they are stored, kept alive by `storage`; stored_code
// reads a depth sample as a code. A SurfaceFrame is what a builder makes of it: filtered codes, one bit of
// validity for each pixel, bounds of each tile, and the planes of touch. A VertexSource gives the depth of
// single pixels, from a frame's codes or computed when asked.
//
// A SurfaceTimeline is the ring of published frames between the thread that builds and the haptic thread. The
// builder fills a free slot and publishes it at a timestamp; the haptic thread asks for the pair of frames
// around a moment and holds it, pinned, while it reads. Neither waits for the other, and nothing is allocated
// after the start. A moment has an epoch: a seek, a loop's way back or another clip begins one, and a pair
// never reaches across (docs/architecture.md, Time).
//
// Frames do not change once they are published, and may then be read by any thread. Of a timeline one thread
// builds, one reads, and one may look at what the reader holds, to draw it.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <type_traits>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"
#include "shaders/hue_code.h"

namespace touchable {

/// How many pixels a picture has that is kept row by row, and which of them, from 0, is that of column x and
/// row y.
inline std::size_t pixel_count(int width, int height) {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}
inline std::size_t pixel_place(int x, int y, int width) {
    return pixel_count(width, y) + static_cast<std::size_t>(x);
}

/// A number that no other call in this process gets, never 0: it names samples that do not change any more.
/// Any thread.
std::uint64_t new_content_number();

/// Samples of one picture as they were decoded, which another object owns. Samples of two bytes are in host
/// order.
struct PlaneView {
    const std::uint8_t* data = nullptr;
    std::ptrdiff_t stride = 0;  ///< bytes from one row to the next
    int width = 0, height = 0;
    int bytes_per_sample = 1;  ///< 1 or 2
    int channels = 1;          ///< interleaved: 1, or 3 for red, green, blue
    /// Names these samples (new_content_number): a view with the same number, place and form shows the same.
    /// 0: the samples may change.
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
};

/// Codes of two bytes that are kept row by row, as a plane of one channel.
inline PlaneView plane_of_codes(const std::uint16_t* codes, int width, int height) {
    return {reinterpret_cast<const std::uint8_t*>(codes), std::ptrdiff_t{2} * width, width, height, 2, 1};
}

/// The planes of one moment as stored, all of the scene's width and height. Only depth is always there.
struct RawFrame {
    std::int64_t number = 0;   ///< from 0
    std::int64_t time_ns = 0;  ///< presentation timestamp
    PlaneView depth;           ///< 1 channel, stored values; for hue 3 channels, 8 bits
    PlaneView colour;          ///< 3 channels, 8 bits
    PlaneView haptic;          ///< 3 channels, 8 bits: stiffness, static friction, dynamic friction
    PlaneView height;          ///< 1 channel
    /// Keeps the planes alive, and as they are; nothing: they last only as long as a call that is given them.
    std::shared_ptr<const void> storage;
    /// Of the clip's clock (MediaMoment); 0 as a reader gives it. Frames of two epochs are not each other's
    /// neighbours, whatever their numbers.
    std::uint64_t epoch = 0;
    /// Pixels to which other frames of the clip gave their depth (with_filled_holes), as the bits of
    /// SurfaceFrame::validity; null: there are none. It shows where depth was not measured, no more.
    std::shared_ptr<const std::vector<std::uint32_t>> filled;

    /// Which frame it was, to be remembered. Between two of an epoch frames may have been left out.
    struct Place {
        std::uint64_t epoch = 0;
        std::int64_t number = 0;

        explicit Place(const RawFrame& raw) : epoch(raw.epoch), number(raw.number) {}
        bool is_before(const RawFrame& raw) const { return epoch == raw.epoch && number < raw.number; }
    };
};

/// The same to be kept beyond the call that gave it: itself where its storage keeps its planes, otherwise a
/// copy of them.
RawFrame kept_frame(const RawFrame& frame);

/// True where samples of both can be compared byte by byte, or neither plane is there.
bool same_form(const PlaneView& a, const PlaneView& b);
/// True where both planes have the same form and samples, or neither is there. Stops at the first row that
/// differs; planes at the same place are not compared.
bool same_samples(const PlaneView& a, const PlaneView& b);

/// True where depth, haptic and height planes, all that a surface is made of, have the same form and samples.
/// Stops at the first row that differs.
bool same_touch_planes(const RawFrame& a, const RawFrame& b);

/// What a hue pixel has that says nothing of its depth; beyond every coding's valid codes.
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

/// Whether a stored depth picture has any depth; ends at the first pixel that has.
inline bool has_valid_pixel(const PlaneView& depth, const DepthCoding& coding) {
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
            if (coding.is_valid(stored_code(depth, coding, x, y))) return true;
    return false;
}

/// Red, green and blue of a pixel that the colour camera does not see, such as outside of its picture: it has
/// no colour of its own.
inline constexpr std::uint8_t unseen_colour = 128;

/// `rgb`: three samples.
inline bool is_unseen_colour(const std::uint8_t* rgb) {
    return rgb[0] == unseen_colour && rgb[1] == unseen_colour && rgb[2] == unseen_colour;
}

/// One plane of a frame: an array in memory of its own, or in another's that it keeps alive (a GPU's,
/// mapped). Whatever changes its size makes it own its memory again; a copy always does.
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

    /// `memory` belongs to `owner` and is the array from now on.
    void adopt(std::span<T> memory, std::shared_ptr<const void> owner) {
        own_ = {};
        owner_ = std::move(owner);
        data_ = memory.data();
        size_ = memory.size();
    }
    bool adopted() const { return owner_ != nullptr; }

    /// New elements are zero; adopted ones are forgotten, as they are by `assign` and `clear`.
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

/// Depth of one pixel, before height is taken off. Where it is not valid, depth means nothing.
struct DepthSample {
    double depth = 0;  ///< scene units, of the coding's semantics
    bool valid = false;
};

/// Bounds on the valid depths of a tile's 17x17 vertices; may be wider than they need to be.
struct TileDepths {
    double nearest = 0, farthest = 0;  ///< scene units; nearest > farthest: no pixel is valid
    bool any_invalid = false;
};

/// Bounds of codes as bounds of depths.
TileDepths depths_of(const TileBounds& bounds, const DepthCoding& coding);

/// Depth and validity at a pixel, wherever they come from. Wait-free, no allocation; safe to call from one
/// haptic thread while others read too.
class VertexSource {
public:
    virtual ~VertexSource() = default;
    /// 0 <= x < width, 0 <= y < height.
    virtual DepthSample at(int x, int y) const = 0;
    /// 0 <= tx < tiles_x, 0 <= ty < tiles_y of the frame (see TileGrid).
    virtual TileDepths tile(int tx, int ty) const = 0;
    /// The frame whose codes and validity these vertices are, where they are no more than that: a caller that
    /// needs many reads them there (`sample_of`).
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

/// Unquantised depths, for scenes whose truth is known. No depth is invalid unless it is not finite.
class ExactVertices final : public VertexSource {
public:
    /// `depths`: width x height, row-major, scene units. Where there are fewer, the rest is not valid.
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
    int column_of_cell(int i) const { return i < 0 ? 0 : (i / cells < tiles_x ? i / cells : tiles_x - 1); }
    int row_of_cell(int j) const { return j < 0 ? 0 : (j / cells < tiles_y ? j / cells : tiles_y - 1); }
};

/// Over the valid codes of a tile's vertices inside the picture; least > greatest (65535, 0): none is valid.
/// Eight bytes, as kernels write them.
struct alignas(8) TileBounds {
    std::uint16_t least = 65535, greatest = 0;
    bool any_invalid = false;
    bool operator==(const TileBounds&) const = default;
};

/// One filtered frame. Filled by a SurfaceBuilder, then immutable until its slot is recycled; its timestamp
/// lives in the SurfaceTimeline, because an unchanged frame is published again at a later one. It stays where
/// it is: its vertices read it.
struct SurfaceFrame {
    SurfaceFrame() = default;
    SurfaceFrame(const SurfaceFrame&) = delete;
    SurfaceFrame& operator=(const SurfaceFrame&) = delete;

    int width = 0, height = 0;
    DepthCoding coding;               ///< of `codes`; a filter that adds precision has its own
    FrameArray<std::uint16_t> codes;  ///< width x height, row-major; empty where not asked for (lazy, exact)
    FrameArray<std::uint32_t> validity;  ///< one bit per pixel, rows padded to whole words, low bit first
    FrameArray<TileBounds> tiles;        ///< tiles_x x tiles_y of TileGrid::of(width, height), row-major
    std::vector<std::uint8_t> haptic;    ///< width x height x 3, never filtered; empty: the scene's defaults
    std::vector<std::uint16_t> heights;  ///< width x height codes, never filtered; empty: no height
    RawFrame raw;                        ///< what it was built from, where the vertices still read it (lazy)
    /// RawFrame::filled of what it was built from
    std::shared_ptr<const std::vector<std::uint32_t>> filled;
    std::unique_ptr<VertexSource> vertices;  ///< how the solver reads this frame; set by the builder
    /// Names what the frame holds (new_content_number): each SurfaceTimeline::publish sets another one. 0:
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

/// Copies the haptic and height planes of a raw frame, or empties them where it has none.
void copy_touch_planes(const RawFrame& raw, SurfaceFrame& out);

/// A published frame and its moment.
struct TimedFrame {
    std::int64_t number = -1;  ///< of the clip's frame
    std::int64_t time_ns = 0;
    const SurfaceFrame* frame = nullptr;
};

/// A moment on a clip's clock. Times go forward within an epoch; from one to another they may go anywhere.
struct MediaMoment {
    std::uint64_t epoch = 0;
    std::int64_t time_ns = 0;
    std::int64_t start_ns = 0;  ///< where the epoch begins
    bool operator==(const MediaMoment&) const = default;
};

/// The frames around a moment. `next` equals `prev` before the first, from the last on, and while the
/// producer is late; then blend is 0.
struct FramePair {
    TimedFrame prev, next;
    double blend = 0;  ///< 0 at prev's time, towards 1 at next's
    /// Of the clip's clock: another one has nothing to do with the frames before, whatever its times.
    std::uint64_t epoch = 0;
};

/// A ring of published SurfaceFrames between one writer (the surface thread) and one reader (the haptic
/// thread). The reader never waits; the writer's slots are recycled only once the reader has moved past them.
/// An eye (the thread that draws) may look at what the reader holds; neither of the two waits for it. Nothing
/// here locks, waits or retries: each side reads what the others last stored and works with that.
class SurfaceTimeline {
public:
    /// What the reader held in a tick.
    struct HeldPair {
        FramePair pair;
        std::int64_t tick = 0;
    };

    /// `slots`: frames that exist at once, at least 3 (the reader's pair, and one being built); 4 where
    /// epochs begin (the pair that it holds, and the one that it goes over to);
    /// with an eye 2 more.
    enum class Eye { none, one };
    explicit SurfaceTimeline(int slots, Eye eye = Eye::none);
    SurfaceTimeline(const SurfaceTimeline&) = delete;
    SurfaceTimeline& operator=(const SurfaceTimeline&) = delete;

    /// Writer. A slot to build into, or nullptr while the reader still needs all of them (or all entries).
    /// The slot stays the writer's until it is published; asking again returns the same one. It still holds
    /// the frame it was last published with. Wait-free: one look at each slot.
    SurfaceFrame* acquire();
    /// Writer. Publishes the acquired slot; there is always an entry for it. A time not later than the newest
    /// one's is refused, and the slot kept. Wait-free; only a refusal allocates, for its message.
    Result<void> publish(std::int64_t number, std::int64_t time_ns);
    /// Writer. Publishes the newest frame once more, at a later time: nothing changed. Refused while the ring
    /// of entries is full (false), with a time not later, or before the first frame of the epoch (errors).
    /// Wait-free.
    Result<bool> republish(std::int64_t number, std::int64_t time_ns);
    /// Writer. What is published from now on is of this epoch, a later one than before, and its times may be
    /// any. Wait-free.
    void begin_epoch(std::uint64_t epoch);
    /// Writer. The epoch has no more frames than are published. Wait-free.
    void end_epoch() { ended_.store(epoch_ + 1, std::memory_order_release); }

    /// Any thread. Time of the newest epoch's newest frame; INT64_MIN before the first. A reader that has
    /// seen it finds that frame. Wait-free.
    std::int64_t newest_time() const { return newest_time_.load(std::memory_order_acquire); }

    /// Reader. The pair around a moment; false while nothing has been published. Within an epoch times should
    /// not go backward: an earlier time than before gives the earliest frame still held, at blend 0. A later
    /// epoch than before is gone over to once two of its frames are published, or all that it has; until then
    /// the pair stays the one that it was, blend and all. Epochs in between are passed over. The pair stays
    /// readable until the next call; frames before `pair.prev` may be recycled from here on. Wait-free: at
    /// most one walk over the ring (4 entries per slot); no allocation.
    bool pair_at(const MediaMoment& moment, FramePair& pair);
    /// Reader. Of the epoch that it is in.
    bool pair_at(std::int64_t time_ns, FramePair& pair);

    /// Reader. Lets the eye have what the last `pair_at` gave. Wait-free; does nothing where there is no eye.
    void show(std::int64_t tick);
    /// Eye, one thread. What the reader showed last; nothing before the first. It stays readable until the
    /// next call, however long that takes. Wait-free, no allocation.
    const HeldPair* look();

private:
    struct Entry {
        std::int64_t number = 0, time_ns = 0;
        std::uint64_t epoch = 0;
        std::size_t slot = 0;
    };
    const Entry& entry(std::uint64_t sequence) const { return entries_[sequence % entries_.size()]; }
    TimedFrame timed_frame(std::uint64_t sequence) const;
    Result<void> check_later(std::int64_t number, std::int64_t time_ns) const;
    void append(std::int64_t number, std::int64_t time_ns, std::size_t slot);
    using Pins = std::array<std::uint64_t, 4>;
    Pins all_pins() const;
    bool go_over(std::uint64_t epoch, bool ended, std::uint64_t published, std::uint64_t& first);
    void hold(std::uint64_t prev, std::uint64_t next, double blend);

    // Entries are numbered from 0 without end; the ring holds entry n at n modulo its size. Those in
    // [reader_oldest_, published_) and the slots they name are the reader's, and so are the pinned slots; all
    // else is the writer's.
    std::vector<std::unique_ptr<SurfaceFrame>> slots_;
    std::vector<Entry> entries_;
    // Writer only: the slot being built, for each slot where reader_oldest_ must be to recycle it, and the
    // epoch with what was published of it.
    std::optional<std::size_t> acquired_;
    std::vector<std::uint64_t> free_from_;
    std::uint64_t epoch_ = 0;
    bool epoch_has_frames_ = false;
    // Reader only: what it holds; nothing before its first look.
    std::optional<FramePair> held_;
    // Each on its own cache line, so that the sides do not slow each other.
    alignas(64) std::atomic<std::uint64_t> published_{0};      // stored by the writer
    alignas(64) std::atomic<std::uint64_t> reader_oldest_{0};  // stored by the reader, after pinned_
    std::atomic<std::uint64_t> pinned_{0};                     // by the reader: the slots of its pair
    // Three places for pairs on their way to the eye: one is the reader's, one the eye's, one lies between
    // them, and each swaps its own for that. Pins stand beside a pair from before the reader puts it there
    // until its holder gives it up.
    const Eye eye_;
    std::array<HeldPair, 3> shown_;
    std::size_t readers_place_ = 0, eyes_place_ = 1;
    bool eye_has_seen_ = false;
    std::array<std::atomic<std::uint64_t>, 3> shown_pins_{};
    alignas(64) std::atomic<std::size_t> between_{2};    // the place, and whether it is new to the eye
    alignas(64) std::atomic<std::int64_t> newest_time_;  // stored by the writer
    std::atomic<std::uint64_t> ended_{0};                // by the writer: 1 + the epoch that has ended
};

}  // namespace touchable
