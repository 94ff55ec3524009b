#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/scene/scene.hpp"

namespace touchable {

/// What stored codes become before terraces are removed and noise is averaged, so that a mean of two has
/// somewhere to lie: `factor` times as many. Or, where these would not fit 15 bits, or be coarse where a hand
/// is, codes of their own, looked up in a table: even steps of 1 / (depth + shift), which are about as fine
/// against a pixel's width at every depth. docs/conventions.md has the arithmetic.
struct WorkingCodes {
    int factor = 1;
    std::shared_ptr<const std::vector<std::uint16_t>> table{};  ///< of all 65536 codes; null: multiplied
    DepthCoding coding{};                                       ///< of the working codes

    std::uint16_t of(int code) const {
        return table ? (*table)[static_cast<std::size_t>(code)] : static_cast<std::uint16_t>(code * factor);
    }
    /// `count` codes of a row at once.
    template <class To>
    void row(const std::uint16_t* codes, int count, To* to) const {
        if (const std::uint16_t* const found = table ? table->data() : nullptr)
            for (int k = 0; k < count; ++k) to[k] = static_cast<To>(found[codes[k]]);
        else
            for (int k = 0; k < count; ++k)
                to[k] = static_cast<To>(static_cast<std::uint16_t>(codes[k] * factor));
    }
    bool operator==(const WorkingCodes& other) const {
        return factor == other.factor && !table == !other.table && coding == other.coding;
    }
};

/// Working codes and a gate of terrace removal are together at most this. So a second difference that leaves
/// 16 bits and wraps around is beyond twice the gate all the same, and so is one with a code of 65535, which
/// no finer one is.
inline constexpr int terrace_range = 32767;

/// Stored codes as they are.
WorkingCodes unchanged_codes(const DepthCoding& coding);
/// Those of this scene. Nothing where no code is valid, or levels are so far apart that they leave no room.
std::optional<WorkingCodes> working_codes(const Scene& scene);
/// Whether there are any; without making a table.
bool has_working_codes(const Scene& scene);

/// The largest code that a depth is told by: of metric codes only those up to `far` are.
int largest_code(const DepthCoding& coding);
/// The coding of codes `factor` times as many, of metric codes a power of two: a multiplied code is the same
/// depth, to the bit. From the least valid code to the largest all are valid.
DepthCoding finer(const DepthCoding& coding, int factor);
/// Depth from a code to the next one, scene units; of the last code that from the one before it.
double step_of_code(const DepthCoding& coding, std::uint16_t code);
/// The same at any depth: from one stored code to the next.
DepthLength code_step(const DepthCoding& coding);

}  // namespace touchable
