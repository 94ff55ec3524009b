#include "engine/surface/terrace_filter.hpp"

#include <algorithm>
#include <cstring>

#include "engine/surface/validity_strip.hpp"

namespace touchable {
namespace {

/// The finer codes of a strip, held near what they were before the passes, and 0 where they are not valid.
/// All in 16 bits, as CPUs like it: passes cannot move a code by more than fits them.
void store_strip(const TerraceFilter& filter, const std::int16_t* finer, const std::uint16_t* before,
                 const std::int16_t* limits, std::uint32_t validity, std::uint16_t* codes, int count) {
    std::uint16_t was[strip_pixels];
    filter.working.row(before, count, was);
    std::int16_t most[strip_pixels];
    if (filter.is_even())
        std::fill_n(most, strip_pixels, static_cast<std::int16_t>(2 * filter.most_at(0)));
    else
        for (int k = 0; k < strip_pixels; ++k) most[k] = static_cast<std::int16_t>(2 * limits[k]);
    for (int k = 0; k < count; ++k) {
        const auto twice = static_cast<std::uint16_t>(2 * was[k]);
        const auto moved = static_cast<std::int16_t>(static_cast<std::uint16_t>(finer[k]) - twice);
        codes[k] = static_cast<std::uint16_t>(
            twice + std::clamp(moved, static_cast<std::int16_t>(-most[k]), most[k]));
    }
    if (validity == ~std::uint32_t{0}) return;
    std::uint16_t masks[strip_pixels];
    masks_of_bits(validity, masks);
    for (int k = 0; k < count; ++k) codes[k] = static_cast<std::uint16_t>(codes[k] & masks[k]);
}

}  // namespace

void TerraceRemover::begin(const RawFrame& raw, RowBands& bands) {
    before_->make_all(raw, bands, with_terraces_);
    resize(raw.depth.width, bands.threads());
}

void TerraceRemover::resize(int width, int threads) {
    const int words = (width + strip_pixels - 1) / strip_pixels;
    if (words == words_ && work_.size() == static_cast<std::size_t>(threads)) return;
    words_ = words;
    pitch_ = words_ * strip_pixels + 2 * margin_;
    work_.resize(static_cast<std::size_t>(threads));
    for (Work& work : work_) {
        for (int pass = 0; pass <= filter_.passes(); ++pass) {
            Ring& ring = work.rings[pass];
            ring.count = pass < filter_.passes() ? 2 * filter_.tap_of(pass) + 1 : 1;
            ring.codes.resize(static_cast<std::size_t>(pitch_ * ring.count));
        }
        work.masks.assign(static_cast<std::size_t>(pitch_ * (known_rows_ + 1)), -1);
        for (auto* rows : {&work.gates, &work.most})
            rows->resize(filter_.is_even() ? 0
                                           : static_cast<std::size_t>(words_ * strip_pixels * known_rows_));
        work.holes.assign(static_cast<std::size_t>(hole_words() * (known_rows_ + 1)), ~std::uint32_t{0});
    }
}

void TerraceRemover::make(const RowBand& band, SurfaceFrame& out) {
    Work& work = work_[static_cast<std::size_t>(band.thread)];
    const int height = out.height;
    const int passes = filter_.passes();
    for (int loaded = std::max(band.first - filter_.reach, 0); loaded < band.last + filter_.reach; ++loaded) {
        if (loaded < height) load(loaded, work);
        // A pass follows the rows before it by its step, and is needed as far beyond the band as those after
        // it reach.
        int y = loaded, reach = filter_.reach;
        for (int pass = 0; pass < passes; ++pass) {
            const int step = filter_.tap_of(pass);
            y -= step;
            reach -= step;
            if (y < std::max(band.first - reach, 0) || y >= std::min(band.last + reach, height)) continue;
            level_row(unit_, row(work, pass, y - step), row(work, pass, y), row(work, pass, y + step), words_,
                      {step, filter_, pass + 1 == passes}, codes(work, pass + 1, y));
        }
        if (y >= band.first && y < band.last) store(y, work, out);
    }
}

void TerraceRemover::load(int y, Work& work) const {
    const SurfaceFrame& from = with_terraces_;
    const std::uint16_t* stored = from.codes.data() + from.index(0, y);
    std::int16_t* to = codes(work, 0, y);
    filter_.working.row(stored, from.width, to);
    if (!filter_.is_even())
        find_gates(unit_, filter_, to, words_, work.gates.data() + gates_at(y),
                   work.most.data() + gates_at(y));
    const std::uint32_t* validity = from.validity_row(y);
    const int slot = y % known_rows_;
    std::int16_t* masks = work.masks.data() + pitch_ * slot + margin_;
    std::uint32_t* holes = work.holes.data() + hole_words() * slot + words_beyond(margin_);
    for (int word = 0; word < words_; ++word) {
        holes[word] = ~validity[word];
        std::uint16_t bits[strip_pixels] = {};
        if (holes[word] != 0) masks_of_bits(holes[word], bits);
        std::memcpy(masks + word * strip_pixels, bits, sizeof(bits));
    }
}

void TerraceRemover::store(int y, Work& work, SurfaceFrame& out) const {
    const SurfaceFrame& from = with_terraces_;
    const std::uint32_t* validity = from.validity_row(y);
    std::copy(validity, validity + words_, out.validity_row(y));
    for (int word = 0; word < words_; ++word) {
        const int x = word * strip_pixels;
        const std::int16_t* limits = filter_.is_even() ? nullptr : work.most.data() + gates_at(y) + x;
        store_strip(filter_, codes(work, filter_.passes(), y) + x, from.codes.data() + from.index(x, y),
                    limits, validity[word], out.codes.data() + out.index(x, y),
                    std::min(strip_pixels, from.width - x));
    }
}

TerraceRow TerraceRemover::row(const Work& work, int pass, int y) const {
    const bool inside = y >= 0 && y < with_terraces_.height;
    const Ring& ring = work.rings[pass];
    const int slot = inside ? y % ring.count : 0, known = inside ? y % known_rows_ : known_rows_;
    const auto& gates = TerraceFilter::is_wide(filter_.tap_of(pass)) ? work.most : work.gates;
    return {ring.codes.data() + pitch_ * slot + margin_, work.masks.data() + pitch_ * known + margin_,
            work.holes.data() + hole_words() * known + words_beyond(margin_),
            inside && !filter_.is_even() ? gates.data() + gates_at(y) : nullptr};
}

std::ptrdiff_t TerraceRemover::gates_at(int y) const {
    return std::ptrdiff_t{words_} * strip_pixels * (y % known_rows_);
}

std::int16_t* TerraceRemover::codes(Work& work, int pass, int y) const {
    Ring& ring = work.rings[pass];
    return ring.codes.data() + pitch_ * (y % ring.count) + margin_;
}

}  // namespace touchable
