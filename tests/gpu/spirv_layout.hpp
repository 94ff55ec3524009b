// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_commands.hpp"

namespace touchable {

/// A kernel's interface, as its SPIR-V declares it.
struct SpirvLayout {
    std::uint32_t push_bytes = 0;  ///< as C++ counts: with padding to the alignment of the largest scalar
    std::map<std::uint32_t, std::optional<GpuBindingKind>>
        bindings;  ///< of set 0; none: a kind not bound here
    bool other_sets = false;
    std::array<std::uint32_t, 3> group_size{};         ///< with the specialisation constants given
    std::map<std::uint32_t, std::uint32_t> constants;  ///< by number, as they stand in the SPIR-V
};

/// Reads a compute kernel. `constants` are the values of specialisation constants 0, 1, 2... Refused
/// (ErrorKind::internal) where the words are no SPIR-V, hold no compute kernel, or push constants of a type
/// this does not measure.
Result<SpirvLayout> read_spirv(std::span<const std::uint32_t> words,
                               std::span<const std::uint32_t> constants = {});

/// The difference between what a kernel says and what C++ believes, in words; empty where there is none.
std::string difference(const SpirvLayout& kernel, const GpuLayout& believed, std::size_t constants);

}  // namespace touchable
