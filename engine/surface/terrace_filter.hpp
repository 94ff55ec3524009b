#pragma once

#include <cstdint>
#include <iterator>
#include <vector>

#include "engine/frame/surface_frame.hpp"
#include "engine/scene/terraces.hpp"
#include "engine/surface/row_bands.hpp"
#include "engine/surface/terrace_rows.hpp"

namespace touchable {

/// Takes the terraces off quantised depth (docs/conventions.md). The passes go down a band of rows together,
/// each as far behind the one before it as its taps reach, so that a row is still in the cache when it is
/// needed.
class TerraceRemover {
public:
    explicit TerraceRemover(VectorUnit unit) : unit_(unit) {}

    /// To be called before the others, of each frame. No allocation once it has seen the size.
    void begin(int width, int threads);
    /// The rows of a band of `to`, which has the size: finer codes, 0 where invalid, and validity. Of `from`
    /// rows up to terrace_reach beyond the band are read.
    void remove(const RowBand& band, const TerraceFilter& filter, const SurfaceFrame& from, SurfaceFrame& to);

private:
    static constexpr int passes = std::size(terrace_steps);
    /// The last rows that a pass has to read: row y in slot y % count.
    struct Ring {
        int count = 0;
        std::vector<std::int16_t> codes;
    };
    /// What a thread has at hand.
    struct Work {
        Ring rings[passes + 1];  // before each pass, and after the last
        // Of every row that any pass still reads, and after them of one outside the picture.
        std::vector<std::int16_t> masks;
        std::vector<std::uint32_t> holes;
    };

    void load(const TerraceFilter& filter, const SurfaceFrame& from, int y, Work& work) const;
    void store(const TerraceFilter& filter, const SurfaceFrame& from, int y, Work& work,
               SurfaceFrame& to) const;
    /// Row y before a pass; nothing counts in a row outside the picture.
    TerraceRow row(const Work& work, int pass, int y, int height) const;
    std::int16_t* codes(Work& work, int pass, int y) const;

    VectorUnit unit_;
    int words_ = 0;
    std::ptrdiff_t pitch_ = 0;
    std::vector<Work> work_;  // of each thread
};

}  // namespace touchable
