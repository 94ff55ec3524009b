#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "engine/base/result.hpp"
#include "tests/verify/geometry.hpp"

namespace touchable::verify {

/// Three numbers per haptic pixel: stiffness (N/m), static and dynamic friction.
struct Touch {
    real stiffness = 0, mu_static = 0, mu_dynamic = 0;
    bool operator==(const Touch&) const = default;
};

/// What scene.json says, read without the engine: the meaning of the numbers in the pictures.
struct Meaning {
    enum class Kind { linear, inverse, log, metric };
    int width = 0, height = 0;
    real fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
    Kind kind = Kind::linear;
    bool range = true;         ///< depth along the pixel's ray; otherwise along -Z
    bool near_is_high = true;  ///< all but metric
    real near = 0, far = 0;    ///< of the codes, scene units
    real shift = 0;            ///< of inverse and log: scene units, added to a depth
    real scene_far = 0;        ///< of holes and of what is around the picture
    real scale = 0;            ///< metric: scene units per code
    real code_max = 255;
    real largest_height = 0;  ///< scene units at the largest height code
    real height_code_max = 255;
    Touch low, high;  ///< of haptic values 0 and 255
    Touch by_default;
    std::optional<real> hole_stiffness;  ///< N/m
    bool operator==(const Meaning&) const = default;

    /// Scene units, of the coding's own kind (range or planar).
    real depth(std::uint16_t code) const;
};

/// One folder as `touchable export` writes it.
struct ExportedFrame {
    Meaning meaning;
    std::vector<std::uint16_t> codes, heights;  ///< heights: empty where there are none
    std::vector<std::uint8_t> valid;            ///< 0 or 255
    std::vector<std::uint8_t> haptic;           ///< RGB; empty: the defaults everywhere
};

Result<Meaning> read_meaning(const std::filesystem::path& folder);
Result<ExportedFrame> read_frame(const std::filesystem::path& folder);

/// Frames by number, read when first asked for; only a few are kept.
class FrameStore {
public:
    explicit FrameStore(std::filesystem::path folder) : folder_(std::move(folder)) {}
    /// The frame stays in memory until `kept` others have been asked for. All frames must mean the same.
    Result<const ExportedFrame*> get(std::int64_t number);

private:
    static constexpr std::size_t kept = 4;
    std::filesystem::path folder_;
    std::map<std::int64_t, ExportedFrame> frames_;
    std::vector<std::int64_t> recent_;  // oldest first
};

}  // namespace touchable::verify
