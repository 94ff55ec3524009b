#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Edges of colour against edges of depth. Where a near surface ends before a far one, its colour should end
/// at the same pixel.
class ColourEdges {
public:
    explicit ColourEdges(const Scene& scene);

    /// Looks at a frame with colour. `where`: pixels of edges whose colour is two steps or more away are set
    /// to 1 there, row by row; nothing: nobody wants to know.
    void add(const RawFrame& frame, std::vector<std::uint8_t>* where = nullptr);

    /// Medians, in pixels of the depth plane.
    struct Fit {
        std::int64_t edges = 0;  ///< places that were compared
        /// Share of them within two steps of their median, across or down, whichever is less. Where colour
        /// lies far beside depth, by more than is looked at, edges of colour are found by chance, all over
        /// the window: then the other figures mean nothing.
        double agreement = 0;
        bool agrees() const { return agreement >= 0.45; }
        /// By how much colour lies to the right of depth, and below it. Nothing: too few edges face both
        /// ways.
        std::optional<double> right, below;
        /// By how much near surfaces reach beyond their colour, so that the background's colour lies on
        /// their rims; below 0: their colour reaches beyond them.
        double rim = 0;
    };
    /// Nothing where there were too few edges.
    std::optional<Fit> fit() const;

private:
    enum Facing { to_right, to_left, down, up };  // from the near surface to the far one
    static constexpr int reach = 8;               // steps on either side that are looked at
    static constexpr int offsets = 2 * reach + 1;

    struct Line;
    static bool is_silhouette(const Line& line, int at, int out);
    static std::optional<int> offset_of_colour(const Line& line, int at, int out);
    void look(const Line& line, int at, Facing facing, std::vector<std::uint8_t>* where);
    std::int64_t count(Facing facing) const;
    double median(Facing facing) const;
    std::int64_t near_median(Facing facing) const;
    double agreement(Facing a, Facing b) const;

    const DepthCoding coding_;
    const int step_;  // pixels from one sample of a profile to the next
    std::vector<float> depths_;
    std::array<std::array<std::int64_t, offsets>, 4> counts_{};
};

}  // namespace touchable
