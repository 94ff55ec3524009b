// SPDX-License-Identifier: Apache-2.0
#include "bench/surface/changed_race.hpp"

#include <cstring>

#include "bench/surface/race.hpp"

namespace touchable {
namespace {

enum class Where { disc, tiles };

/// A depth plane in memory of its own.
RawFrame copy_of(const RawFrame& raw) {
    const PlaneView& from = raw.depth;
    const std::ptrdiff_t row_bytes = std::ptrdiff_t{from.width} * from.bytes_per_sample;
    const auto memory =
        std::make_shared<std::vector<std::uint8_t>>(static_cast<std::size_t>(row_bytes * from.height));
    for (int y = 0; y < from.height; ++y)
        std::memcpy(memory->data() + row_bytes * y, from.row(y), static_cast<std::size_t>(row_bytes));
    RawFrame copy;
    copy.depth = {memory->data(), row_bytes, from.width, from.height, from.bytes_per_sample, 1};
    copy.storage = memory;
    return copy;
}

/// Flips the lowest bit, so that a valid code stays valid.
void change_pixel(const RawFrame& copy, int x, int y) {
    const PlaneView& plane = copy.depth;
    // The memory is from `copy_of`, so writable.
    std::uint8_t* sample =
        const_cast<std::uint8_t*>(plane.row(y)) + std::ptrdiff_t{x} * plane.bytes_per_sample;
    std::uint16_t code = plane.sample(x, y);
    code = static_cast<std::uint16_t>(code > 2 ? code ^ 1 : code);
    std::memcpy(sample, &code, static_cast<std::size_t>(plane.bytes_per_sample));
}

/// A copy with `pct` per cent of the tiles changed.
RawFrame changed(const RawFrame& raw, int pct, Where where) {
    RawFrame copy = copy_of(raw);
    const int width = raw.depth.width, height = raw.depth.height;
    const TileGrid grid = TileGrid::of(width, height);
    // Squared radius of a disc with that share of the picture, if within it.
    const double square = static_cast<double>(pct) * width * height / 314;
    std::uint64_t state = 5;
    for (int ty = 0; ty < grid.tiles_y; ++ty)
        for (int tx = 0; tx < grid.tiles_x; ++tx) {
            const int left = tx * TileGrid::cells, top = ty * TileGrid::cells;
            const double dx = left + 8 - 0.5 * width, dy = top + 8 - 0.5 * height;
            state = state * 6364136223846793005U + 1442695040888963407U;
            const bool chosen = where == Where::disc ? dx * dx + dy * dy < square
                                                     : static_cast<int>((state >> 33) % 100) < pct;
            if (!chosen) continue;
            for (int y = top; y < std::min(top + TileGrid::cells, height); ++y)
                for (int x = left; x < std::min(left + TileGrid::cells, width); ++x) change_pixel(copy, x, y);
        }
    return copy;
}

/// More than the frames that a builder skips comparing after comparing did not pay, so that the mean includes
/// the cost of comparing.
constexpr int frames_per_turn = 9;

FrameTimes per_frame(const FrameTimes& turn) {
    return {turn.wall_ms / frames_per_turn, turn.cpu_ms / frames_per_turn};
}

/// Builds two frames alternately into one slot.
struct Turns {
    std::unique_ptr<SurfaceBuilder> builder;
    RawFrame frames[2];
    int next = 0;
    SurfaceFrame slot = {};

    Result<void> build() {
        for (int n = 0; n < frames_per_turn; ++n) {
            next = 1 - next;
            if (auto built = builder->build(frames[1 - next], slot); !built) return built;
        }
        return {};
    }
};

Result<void> check(const std::string& name, const Turns& turns, const MakeBuilder& make_builder) {
    SurfaceFrame whole;
    if (auto built = make_builder()->build(turns.frames[1 - turns.next], whole); !built) return built;
    const SurfaceFrame& slot = turns.slot;
    if (whole.codes == slot.codes && whole.validity == slot.validity && whole.tiles == slot.tiles) return {};
    return Error{ErrorKind::check, name + " differs from the whole frame"};
}

/// Copies of the frame's bytes.
class Copies {
public:
    explicit Copies(const RawFrame& from) : from_(from.depth), to_(bytes()) {}
    void make() {
        for (int n = 0; n < frames_per_turn; ++n) std::memcpy(to_.data(), from_.data, to_.size());
    }

private:
    std::size_t bytes() const { return static_cast<std::size_t>(from_.stride) * from_.height; }
    const PlaneView from_;
    std::vector<std::uint8_t> to_;
};

/// Races only against whole frames and copies, so that caches hold as much of the data as with a clip.
Result<void> race_with_whole(const std::string& name, const RawFrame& before, const RawFrame& after,
                             const MakeBuilder& make_builder, int rounds, Figures& figures) {
    Turns turns[] = {{make_builder(), {before, after}}, {make_builder(), {before, after}}};
    for (RawFrame& frame : turns[1].frames) frame.storage = nullptr;  // disables comparison of frames
    Copies copies(before);
    std::vector<Racer> racers{{name, [&] { return turns[0].build(); }},
                              {"full", [&] { return turns[1].build(); }},
                              {"copy", [&]() -> Result<void> {
                                   copies.make();
                                   return {};
                               }}};
    for (const int count : {1, rounds}) {
        for (Racer& racer : racers) racer.times = {};
        if (auto raced = race(racers, count); !raced) return raced;
        for (const Turns& some : turns)
            if (auto checked = check(name, some, make_builder); !checked) return checked;
    }
    add_times(figures, name, per_frame(racers[0].times));
    figures.push_back({name + "_vs_full", racers[0].times.wall_ms / racers[1].times.wall_ms, ""});
    figures.push_back({name + "_cpu_vs_full", racers[0].times.cpu_ms / racers[1].times.cpu_ms, ""});
    figures.push_back({name + "_cpu_vs_copy", racers[0].times.cpu_ms / racers[2].times.cpu_ms, ""});
    figures.push_back({name + "_tiles_pct", 100 * turns[0].builder->built_share(), "%"});
    return {};
}

}  // namespace

Result<void> race_changed(const RawFrame& raw, const MakeBuilder& make_builder, int rounds,
                          Figures& figures) {
    struct Kind {
        std::string name;
        int pct;
        Where where;
    };
    for (const Kind& kind : {Kind{"unchanged", 0, Where::tiles}, Kind{"dirty10", 10, Where::disc},
                             Kind{"dirty10_scattered", 10, Where::tiles}})
        if (auto raced = race_with_whole(kind.name, copy_of(raw), changed(raw, kind.pct, kind.where),
                                         make_builder, rounds, figures);
            !raced)
            return raced;
    return {};
}

}  // namespace touchable
