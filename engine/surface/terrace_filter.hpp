#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene/terraces.hpp"
#include "engine/surface/code_rows.hpp"
#include "engine/surface/terrace_rows.hpp"

namespace touchable {

/// Takes the terraces off quantised depth (docs/conventions.md). The passes go down a band of rows together,
/// each as far behind the one before it as its taps reach, so that a row is still in the cache when it is
/// needed.
class TerraceRemover final : public BandSource {
public:
    TerraceRemover(std::unique_ptr<BandSource> before, const TerraceFilter& filter, VectorUnit unit)
        : before_(std::move(before)),
          filter_(filter),
          unit_(unit),
          known_rows_(filter.reach + 2),
          margin_(filter.tap_of(0)) {}
    void begin(const RawFrame& raw, RowBands& bands) override;
    /// Finer codes, 0 where invalid, and validity.
    void make(const RowBand& band, SurfaceFrame& out) override;
    void remember(const RawFrame& raw, RowBands& bands, SurfaceFrame& scratch) override {
        before_->remember(raw, bands, scratch);
    }

private:
    /// The last rows that a pass has to read: row y in slot y % count.
    struct Ring {
        int count = 0;
        std::vector<std::int16_t> codes;
    };
    /// What a thread has at hand.
    struct Work {
        Ring rings[most_terrace_passes + 1];  // before each pass, and after the last
        // Of every row that any pass still reads, and after them of one outside the picture.
        std::vector<std::int16_t> masks;
        std::vector<std::uint32_t> holes;
        std::vector<std::int16_t> gates, most;  // of those rows; empty where all levels are alike
    };

    void resize(int width, int threads);
    void load(int y, Work& work) const;
    void store(int y, Work& work, SurfaceFrame& out) const;
    /// Row y before a pass; nothing counts in a row outside the picture.
    TerraceRow row(const Work& work, int pass, int y) const;
    /// Words of holes of a row, with those beyond its ends.
    std::ptrdiff_t hole_words() const { return words_ + 2 * words_beyond(filter_.tap_of(0)); }
    std::int16_t* codes(Work& work, int pass, int y) const;
    std::ptrdiff_t gates_at(int y) const;

    const std::unique_ptr<BandSource> before_;
    const TerraceFilter filter_;
    const VectorUnit unit_;
    /// Rows of which it is kept who counts: the last pass is filter_.reach behind the row that is loaded, and
    /// reads the one before its own too.
    const int known_rows_;
    const int margin_;  // codes that a tap may be beyond a row's ends
    SurfaceFrame with_terraces_;
    int words_ = 0;
    std::ptrdiff_t pitch_ = 0;
    std::vector<Work> work_;  // of each thread
};

}  // namespace touchable
