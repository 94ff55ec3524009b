// SPDX-License-Identifier: Apache-2.0
#pragma once

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <functional>

#include "engine/base/threads.hpp"
#include "engine/base/vectors.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

/// The fast path works in strips of 32 pixels of one row: the pixels of one validity word. Within a strip
/// validity is a mask of 16 bits per pixel (all ones or none), as wide as a code, so that loops over both
/// vectorise.
inline constexpr int strip_pixels = 32;

/// Pixels [left, right) x [top, bottom).
struct PixelBox {
    int left = 0, top = 0, right = 0, bottom = 0;
};

/// The bits of word `word` that lie inside a row of `width` pixels.
inline std::uint32_t inside_bits(int width, int word) {
    const int left = width - word * strip_pixels;
    return left >= strip_pixels ? ~std::uint32_t{0} : (std::uint32_t{1} << left) - 1;
}

/// Bits of 16 pixels, by their place in a word.
inline constexpr std::uint16_t bit_of_pixel[16] = {
    1, 2, 4, 8, 0x10, 0x20, 0x40, 0x80, 0x0100, 0x0200, 0x0400, 0x0800, 0x1000, 0x2000, 0x4000, 0x8000};

inline std::uint32_t bits_of_masks(const std::uint16_t* masks) {
#ifdef __SSE2__
    __m128i values[4];
    std::memcpy(values, masks, sizeof(values));
    const auto low = static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(values[0], values[1])));
    const auto high = static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(values[2], values[3])));
    return low | high << 16;
#else
    std::uint16_t low = 0, high = 0;
    for (int k = 0; k < 16; ++k) low = static_cast<std::uint16_t>(low | (masks[k] & bit_of_pixel[k]));
    for (int k = 0; k < 16; ++k) high = static_cast<std::uint16_t>(high | (masks[16 + k] & bit_of_pixel[k]));
    return low | std::uint32_t{high} << 16;
#endif
}

inline void masks_of_bits(std::uint32_t bits, std::uint16_t* masks) {
    const auto low = static_cast<std::uint16_t>(bits), high = static_cast<std::uint16_t>(bits >> 16);
    for (int k = 0; k < 16; ++k) masks[k] = (low & bit_of_pixel[k]) ? 0xFFFF : 0;
    for (int k = 0; k < 16; ++k) masks[16 + k] = (high & bit_of_pixel[k]) ? 0xFFFF : 0;
}

/// As many lanes, of 32 bits.
template <class Narrow>
struct Wide {
    using Lanes [[gnu::vector_size(2 * sizeof(Narrow))]] = std::uint32_t;
};

/// The upper half of each product.
template <class Lanes>
[[gnu::always_inline]] inline Lanes high_product(const Lanes& a, const Lanes& b) {
    return __builtin_convertvector((__builtin_convertvector(a, typename Wide<Lanes>::Lanes) *
                                    __builtin_convertvector(b, typename Wide<Lanes>::Lanes)) >>
                                       16,
                                   Lanes);
}

/// CodeCurve::at for every lane.
template <class Lanes>
[[gnu::always_inline]] inline Lanes curve_at(const CodeCurve& curve, const Lanes& codes) {
    const Lanes constant = Lanes{} + curve.constant;
    if ((curve.linear | curve.quadratic) == 0) return constant;
    const Lanes n = (curve.from_last ? curve.last - codes : codes) << curve.shift;
    // Wide products are slow, and most curves lack one.
    Lanes sum = constant;
    if (curve.quadratic > 0) sum += high_product<Lanes>(high_product<Lanes>(n, n), Lanes{} + curve.quadratic);
    if (curve.linear > 0) {
        const Lanes sloped = high_product<Lanes>(n, Lanes{} + curve.linear);
        sum = curve.falls ? sum - lesser<Lanes>(sum, sloped) : sum + sloped;
    }
    return lesser<Lanes>(sum, Lanes{} + std::uint16_t{code_curve_most});
}

/// One row of decoded pixels for windows of a filter: the border is repeated on both sides, on the right to
/// the end of the memory, so that windows need no clamping and vectors no special end. Codes of invalid
/// pixels are 0.
class CodeLine {
public:
    /// Windows reach `reach` pixels to each side, half a strip at most. No allocation at the same size.
    void resize(int width, int reach);

    /// Reads row `y` of stored values, by `coding`.
    void decode(const PlaneView& depth, const DepthCoding& coding, int y, VectorUnit unit);
    /// Reads row `y` of decoded pixels.
    void copy(const SurfaceFrame& decoded, int y);

    /// Begins at the left end of the window around pixel 0; readable for `strips() + 1` strips.
    const std::uint16_t* codes() const { return codes_.front().pixels; }
    /// All ones for invalid pixels; as long as codes.
    const std::uint16_t* invalid() const { return invalid_.front().pixels; }
    /// Invalid pixels as bits, none outside the picture; a word per strip.
    const std::uint32_t* holes() const { return holes_.data(); }
    /// Per strip: not 0 if a window around one of its pixels has an invalid one.
    const std::uint32_t* holes_near() const { return holes_near_.data(); }
    int strips() const { return static_cast<int>(holes_.size()); }

    void write_codes(std::uint16_t* codes) const;
    void write_validity(std::uint32_t* validity) const;

private:
    struct alignas(64) Strip {
        std::uint16_t pixels[strip_pixels];
    };
    void load(const PlaneView& depth, const DepthCoding& coding, int y);
    void repeat_border(std::uint16_t* line) const;
    void set_clean();
    void look_near();
    std::uint16_t* inside(std::vector<Strip>& line) { return line.front().pixels + reach_; }

    int width_ = 0, reach_ = 0;
    std::vector<Strip> codes_, invalid_;
    std::vector<std::uint32_t> holes_, holes_near_;
    bool clean_ = false;
};

/// A frame after the filters so far, by lines, for a filter whose window reads several of them.
class LineSource {
public:
    virtual ~LineSource() = default;
    /// To be called first for each frame. No allocation after the first frame of a size.
    virtual void begin(const RawFrame& raw, RowBands& bands) = 0;
    virtual void load(int y, CodeLine& line) const = 0;
};

/// Lines decoded one by one, when a window reads them.
class StoredLines final : public LineSource {
public:
    StoredLines(const DepthCoding& coding, VectorUnit unit) : coding_(coding), unit_(unit) {}
    void begin(const RawFrame& raw, RowBands&) override { depth_ = raw.depth; }
    void load(int y, CodeLine& line) const override { line.decode(depth_, coding_, y, unit_); }

private:
    const DepthCoding coding_;
    const VectorUnit unit_;
    PlaneView depth_;
};

/// Called for each finished band of rows, while it is still in the cache.
using BandFinished = std::function<void(const RowBand& band)>;

/// A frame after the filters so far, by bands, each made once: a band in the cache can be filtered again
/// before the next one is made.
class BandSource {
public:
    virtual ~BandSource() = default;
    virtual void begin(const RawFrame& raw, RowBands& bands) = 0;
    /// Makes codes and validity of a band of `out`, which has its size. Called by several threads at once.
    virtual void make(const RowBand& band, SurfaceFrame& out) = 0;

    /// Makes all codes and validity of a frame. No allocation if `out` has had the size.
    void make_all(const RawFrame& raw, RowBands& bands, SurfaceFrame& out, const BandFinished& finished = {});
    /// Takes in a frame that is not shown, as far as later ones depend on it; `scratch` is any frame.
    virtual void remember(const RawFrame& raw, RowBands& bands, SurfaceFrame& scratch) {
        make_all(raw, bands, scratch);
    }
};

/// Lines as bands, without a further filter.
class UnfilteredBands final : public BandSource {
public:
    explicit UnfilteredBands(std::unique_ptr<LineSource> lines) : lines_(std::move(lines)) {}
    void begin(const RawFrame& raw, RowBands& bands) override;
    void make(const RowBand& band, SurfaceFrame& out) override;

private:
    const std::unique_ptr<LineSource> lines_;
    std::vector<CodeLine> line_;  // one per thread
};

/// Averages noise from frame to frame.
std::unique_ptr<BandSource> make_temporal_smoother(std::unique_ptr<BandSource> before,
                                                   const TemporalFilter& filter, VectorUnit unit);

/// A plan's filters on the CPU, one on top of the other: from stored values to codes and validity, of a whole
/// picture or of a part.
std::unique_ptr<BandSource> make_code_filters(const FilterPlan& plan, VectorUnit unit);

}  // namespace touchable
