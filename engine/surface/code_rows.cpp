// SPDX-License-Identifier: Apache-2.0
// Rows of codes and validity for vector code, and the stack of a plan's filters.
#include "engine/surface/code_rows.hpp"

#include "engine/surface/flying_pixels.hpp"
#include "engine/surface/median.hpp"
#include "engine/surface/terrace_filter.hpp"

namespace touchable {
namespace {

/// Whether every code of whole strips is valid. Uses only minima and maxima, so that this is as fast as
/// memory. The exclusive or of a code and an invalid code is 0 if they are equal.
template <class Lanes>
[[gnu::always_inline]] inline bool all_valid(const DepthCoding& coding, const std::uint16_t* codes,
                                             int pixels) {
    Lanes least = load_lanes<Lanes>(codes), greatest = least, nearest_to_invalid = ~Lanes{};
    Lanes invalid[DepthCoding::max_invalid_codes];
    for (int n = 0; n < coding.invalid_code_count; ++n)
        invalid[n] = Lanes{} + coding.invalid_codes[static_cast<std::size_t>(n)];
    for (int x = 0; x < pixels; x += lane_count<Lanes>) {
        const Lanes values = load_lanes<Lanes>(codes + x);
        least = lesser(least, values);
        greatest = greater(greatest, values);
        for (int n = 0; n < coding.invalid_code_count; ++n)
            nearest_to_invalid = lesser<Lanes>(nearest_to_invalid, values ^ invalid[n]);
    }
    const Lanes lowest = Lanes{} + coding.valid_min, highest = Lanes{} + coding.valid_max, one = Lanes{} + 1;
    const Lanes wrong = (lesser(least, lowest) ^ lowest) | (greater(greatest, highest) ^ highest) |
                        (lesser(nearest_to_invalid, one) ^ one);
    std::uint64_t words[sizeof(Lanes) / sizeof(std::uint64_t)], any = 0;
    std::memcpy(words, &wrong, sizeof(words));
    for (const std::uint64_t word : words) any |= word;
    return any == 0;
}

/// `masks`: all ones if not DepthCoding::is_valid; such codes become 0. Whole strips. Without comparisons:
/// vectors of 64 bytes compare into masks of another kind, which GCC converts lane by lane.
template <class Lanes>
[[gnu::always_inline]] inline void mask_invalid(const DepthCoding& coding, std::uint16_t* codes,
                                                std::uint16_t* masks, int pixels) {
    const Lanes least = Lanes{} + coding.valid_min, greatest = Lanes{} + coding.valid_max, one = Lanes{} + 1;
    for (int x = 0; x < pixels; x += lane_count<Lanes>) {
        const Lanes values = load_lanes<Lanes>(codes + x);
        const Lanes outside = (lesser(values, least) ^ least) | (greater(values, greatest) ^ greatest);
        Lanes mask = Lanes{} - lesser(outside, one);
        for (int n = 0; n < coding.invalid_code_count; ++n)
            mask |=
                lesser<Lanes>(values ^ (Lanes{} + coding.invalid_codes[static_cast<std::size_t>(n)]), one) -
                one;
        store_lanes(mask, masks + x);
        store_lanes<Lanes>(values & ~mask, codes + x);
    }
}

/// The filters so far: lines, until a filter makes bands of them.
struct FilterStack {
    const DepthCoding& stored;
    const VectorUnit unit;
    std::unique_ptr<LineSource> lines;
    std::unique_ptr<BandSource> bands;

    void add(const FlyingPixels& filter) {
        assert(lines);
        lines = std::make_unique<FlyingPixelFilter>(std::move(lines), filter, stored, unit);
    }
    void add(const FilterPlan::HoleFilling& filling) {
        assert(lines);
        lines = std::make_unique<HoleFiller>(std::move(lines), filling.passes);
    }
    void add(const FilterPlan::MedianWindow& window) {
        assert(lines);
        bands = std::make_unique<MedianFilter>(std::move(lines), window.side, unit);
    }
    void add(const TemporalFilter& filter) { bands = make_temporal_smoother(take_bands(), filter, unit); }
    void add(const TerraceFilter& filter) {
        bands = std::make_unique<TerraceRemover>(take_bands(), filter, unit);
    }
    std::unique_ptr<BandSource> take_bands() {
        return bands ? std::move(bands) : std::make_unique<UnfilteredBands>(std::move(lines));
    }
};

}  // namespace

void CodeLine::resize(int width, int reach) {
    assert(width > 0 && 0 <= reach && reach <= strip_pixels / 2);
    if (width == width_ && reach == reach_) return;
    width_ = width;
    reach_ = reach;
    const auto strips = static_cast<std::size_t>((width + strip_pixels - 1) / strip_pixels);
    codes_.assign(strips + 1, Strip{});
    invalid_.assign(strips + 1, Strip{});
    holes_.assign(strips, 0);
    holes_near_.assign(strips, 0);
    clean_ = true;
}

void CodeLine::load(const PlaneView& depth, const DepthCoding& coding, int y) {
    std::uint16_t* codes = inside(codes_);
    if (coding.kind == DepthCodingKind::hue)
        for (int x = 0; x < width_; ++x) codes[x] = stored_code(depth, coding, x, y);
    else if (depth.bytes_per_sample == 2)
        std::memcpy(codes, depth.row(y), static_cast<std::size_t>(width_) * sizeof(std::uint16_t));
    else
        std::copy_n(depth.row(y), width_, codes);
}

void CodeLine::decode(const PlaneView& depth, const DepthCoding& coding, int y, VectorUnit unit) {
    load(depth, coding, y);
    repeat_border(codes_.front().pixels);
    const int pixels = static_cast<int>(codes_.size()) * strip_pixels;
    bool all = false;
    run_vectors(
        unit, [&](auto kind) __attribute__((always_inline)) {
            all = all_valid<typename decltype(kind)::type>(coding, codes(), pixels);
        });
    if (all) return set_clean();
    clean_ = false;
    run_vectors(
        unit, [&](auto kind) __attribute__((always_inline)) {
            mask_invalid<typename decltype(kind)::type>(coding, codes_.front().pixels,
                                                        invalid_.front().pixels, pixels);
        });
    for (int w = 0; w < strips(); ++w)
        holes_[static_cast<std::size_t>(w)] =
            bits_of_masks(inside(invalid_) + w * strip_pixels) & inside_bits(width_, w);
    look_near();
}

void CodeLine::copy(const SurfaceFrame& decoded, int y) {
    std::memcpy(inside(codes_), decoded.codes.data() + decoded.index(0, y),
                static_cast<std::size_t>(width_) * sizeof(std::uint16_t));
    repeat_border(codes_.front().pixels);
    const std::uint32_t* validity = decoded.validity_row(y);
    std::uint32_t any = 0;
    for (int w = 0; w < strips(); ++w) any |= ~validity[w] & inside_bits(width_, w);
    if (any == 0) return set_clean();
    clean_ = false;
    for (int w = 0; w < strips(); ++w) {
        holes_[static_cast<std::size_t>(w)] = ~validity[w] & inside_bits(width_, w);
        masks_of_bits(holes_[static_cast<std::size_t>(w)], inside(invalid_) + w * strip_pixels);
    }
    repeat_border(invalid_.front().pixels);
    look_near();
}

void CodeLine::repeat_border(std::uint16_t* line) const {
    std::uint16_t* first = line + reach_;
    std::fill(line, first, *first);
    std::fill(first + width_, line + codes_.size() * strip_pixels, first[width_ - 1]);
}

void CodeLine::set_clean() {
    if (clean_) return;
    clean_ = true;
    std::fill(invalid_.begin(), invalid_.end(), Strip{});
    std::fill(holes_.begin(), holes_.end(), 0U);
    std::fill(holes_near_.begin(), holes_near_.end(), 0U);
}

// The repeated border is within reach of the border's own pixel.
void CodeLine::look_near() {
    for (std::size_t w = 0; w < holes_.size(); ++w) {
        std::uint32_t holes = holes_[w];
        if (w > 0)
            holes |= static_cast<std::uint32_t>(std::uint64_t{holes_[w - 1]} >> (strip_pixels - reach_));
        if (w + 1 < holes_.size())
            holes |= static_cast<std::uint32_t>(std::uint64_t{holes_[w + 1]} << (strip_pixels - reach_));
        holes_near_[w] = holes;
    }
}

void CodeLine::write_codes(std::uint16_t* codes) const {
    std::memcpy(codes, this->codes() + reach_, static_cast<std::size_t>(width_) * sizeof(std::uint16_t));
}

void CodeLine::write_validity(std::uint32_t* validity) const {
    for (int w = 0; w < strips(); ++w)
        validity[w] = ~holes_[static_cast<std::size_t>(w)] & inside_bits(width_, w);
}

void BandSource::make_all(const RawFrame& raw, RowBands& bands, SurfaceFrame& out,
                          const BandFinished& finished) {
    begin(raw, bands);
    out.width = raw.depth.width;
    out.height = raw.depth.height;
    out.codes.resize(out.index(0, out.height));
    out.validity.resize(static_cast<std::size_t>(out.validity_words_per_row()) *
                        static_cast<std::size_t>(out.height));
    bands.for_each_band(out.height, TileGrid::cells, [&](const RowBand& band) {
        make(band, out);
        if (finished) finished(band);
    });
}

void UnfilteredBands::begin(const RawFrame& raw, RowBands& bands) {
    lines_->begin(raw, bands);
    line_.resize(static_cast<std::size_t>(bands.threads()));
    for (CodeLine& line : line_) line.resize(raw.depth.width, 0);
}

void UnfilteredBands::make(const RowBand& band, SurfaceFrame& out) {
    CodeLine& line = line_[static_cast<std::size_t>(band.thread)];
    for (int y = band.first; y < band.last; ++y) {
        lines_->load(y, line);
        line.write_codes(out.codes.data() + out.index(0, y));
        line.write_validity(out.validity_row(y));
    }
}

std::unique_ptr<BandSource> make_code_filters(const FilterPlan& plan, VectorUnit unit) {
    FilterStack stack{plan.stored, unit, std::make_unique<StoredLines>(plan.stored, unit), nullptr};
    for (const FilterPlan::Stage& stage : plan.filters)
        std::visit([&](const auto& filter) { stack.add(filter); }, stage.filter);
    return stack.take_bands();
}

}  // namespace touchable
