// SPDX-License-Identifier: Apache-2.0
#pragma once

// Inner loops over 16-bit values, written once with the vectors of GCC and Clang and compiled for each vector
// unit that CPUs may have.
//
// usable_vector_units lists the units of this CPU, the widest first; run_vectors calls a kernel in a function
// compiled for one unit, with the vectors that fit it (std::type_identity). The kernels share the loads,
// stores and comparisons below. Every unit gives the same bits, which tests compare.
//
// Vectors never cross a function call that is not inlined, so the ABI of vectors that the oldest CPUs lack
// does not matter (-Wno-psabi): a kernel, and all that it calls with vectors, is `always_inline`.
// Threads: any; pure functions.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>

namespace touchable {

/// Vector units of CPUs; each includes those before it. `baseline` is the unit that every CPU of the
/// architecture has.
enum class VectorUnit { baseline, sse4, avx2, avx512 };

/// Returns the units of this CPU, the widest first; never empty.
inline std::span<const VectorUnit> usable_vector_units() {
    static constexpr VectorUnit all[] = {VectorUnit::avx512, VectorUnit::avx2, VectorUnit::sse4,
                                         VectorUnit::baseline};
    const std::span<const VectorUnit> units(all);
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx512bw")) return units;
    if (__builtin_cpu_supports("avx2")) return units.subspan(1);
    if (__builtin_cpu_supports("sse4.1")) return units.subspan(2);
#endif
    return units.subspan(3);
}

/// Vectors of 16-bit values; the number is the size in bytes.
using Lanes16 = std::uint16_t __attribute__((vector_size(16)));
using Lanes32 = std::uint16_t __attribute__((vector_size(32)));
using Lanes64 = std::uint16_t __attribute__((vector_size(64)));

template <class Lanes>
inline constexpr int lane_count = sizeof(Lanes) / sizeof(std::uint16_t);

template <class Lanes, class Value>
[[gnu::always_inline]] inline Lanes load_lanes(const Value* from) {
    static_assert(sizeof(Value) == sizeof(std::uint16_t));
    Lanes values;
    std::memcpy(&values, from, sizeof(values));
    return values;
}
[[gnu::always_inline]] inline void store_lanes(const auto& values, std::uint16_t* to) {
    std::memcpy(to, &values, sizeof(values));
}

/// Lane by lane.
template <class Lanes>
[[gnu::always_inline]] inline Lanes lesser(const Lanes& a, const Lanes& b) {
    return a < b ? a : b;
}
template <class Lanes>
[[gnu::always_inline]] inline Lanes greater(const Lanes& a, const Lanes& b) {
    return a < b ? b : a;
}

/// Splits the values of two consecutive vectors into those with an even and those with an odd index.
template <class Lanes>
[[gnu::always_inline]] inline void split_lanes(const Lanes& a, const Lanes& b, Lanes& even, Lanes& odd) {
    const auto split = [&]<std::size_t... n>(std::index_sequence<n...>) __attribute__((always_inline)) {
        even = __builtin_shufflevector(a, b, (2 * n)...);
        odd = __builtin_shufflevector(a, b, (2 * n + 1)...);
    };
    split(std::make_index_sequence<lane_count<Lanes>>());
}
/// The inverse of split_lanes.
template <class Lanes>
[[gnu::always_inline]] inline void join_lanes(const Lanes& even, const Lanes& odd, Lanes& a, Lanes& b) {
    const auto join = [&]<std::size_t... n>(std::index_sequence<n...>) __attribute__((always_inline)) {
        a = __builtin_shufflevector(even, odd, (n / 2 + n % 2 * lane_count<Lanes>)...);
        b = __builtin_shufflevector(even, odd, ((lane_count<Lanes> + n) / 2 + n % 2 * lane_count<Lanes>)...);
    };
    join(std::make_index_sequence<lane_count<Lanes>>());
}

#ifdef __x86_64__
[[gnu::target("sse4.1")]] void run_with_sse4(const auto& kernel) {
    kernel(std::type_identity<Lanes16>());
}
[[gnu::target("avx2")]] void run_with_avx2(const auto& kernel) {
    kernel(std::type_identity<Lanes32>());
}
[[gnu::target("avx512bw")]] void run_with_avx512(const auto& kernel) {
    kernel(std::type_identity<Lanes64>());
}
#endif

/// Calls `kernel(std::type_identity<Lanes>())` in a function compiled for this unit, which the CPU must have.
void run_vectors(VectorUnit unit, const auto& kernel) {
#ifdef __x86_64__
    if (unit == VectorUnit::avx512) return run_with_avx512(kernel);
    if (unit == VectorUnit::avx2) return run_with_avx2(kernel);
    if (unit == VectorUnit::sse4) return run_with_sse4(kernel);
#endif
    static_cast<void>(unit);
    kernel(std::type_identity<Lanes16>());
}

}  // namespace touchable
