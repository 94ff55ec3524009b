#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene/scene.hpp"
#include "engine/surface/code_picture.hpp"

namespace touchable {

/// How wide and how high the terraces of coarsely stored depth are.
struct Contours {
    int width = 0;   ///< pixels: a quarter of what is no step lies on terraces at least so wide
    int height = 0;  ///< codes from one terrace to the next, where half of all steps have it; otherwise 0

    /// Whether a terrace_reach of 16 leaves contour lines.
    bool are_wide() const { return width > 2 * least_terrace_reach; }
    /// That makes slopes of them.
    int reach() const;
    /// How far levels are apart; zero: every code is one.
    DepthLength levels(const DepthCoding& coding) const;
    bool operator==(const Contours&) const = default;
};

/// Measures terraces along rows and columns of pictures: treads, which are runs of one code, and the steps
/// between them, which may be short ramps, as where a phone has enlarged its depth. Integers alone: the same
/// on every machine.
class ContourEstimator {
public:
    void add(const CodePicture& picture);
    Contours contours() const;

private:
    struct Tread {
        int first = 0, end = 0, code = 0;
    };
    struct Terrace {
        int width, step, code;  // pixels; the higher one of its two steps, codes; its own code
        bool goes_on;           // both steps go up, or both down, as on a slope
    };

    void add_line(const int* codes, std::ptrdiff_t stride, int count);
    int height() const;

    std::int64_t narrow_ = 0;  // pixels in shorter runs than treads
    std::vector<std::int64_t> steps_ = std::vector<std::int64_t>(65536);  // how many are so many codes high
    std::vector<Terrace> terraces_;                                       // with a step at either end
    std::vector<Tread> treads_;                                           // of a line
};

}  // namespace touchable
