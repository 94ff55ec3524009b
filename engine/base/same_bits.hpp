// SPDX-License-Identifier: Apache-2.0
#pragma once

// Arithmetic and random numbers with the same bits on every CPU, compiler and C library, and the hash that
// compares two runs.
//
// Functions whose result reaches a force, a depth code or a generated scene must not call what each library
// may round in its own way (docs/architecture.md, decision 3). Sine, cosine and angles use only + - x /, sqrt
// and the exact fmod: within 2 ulp of the correctly rounded value for |x| <= 1e6, with fewer digits beyond;
// arguments in radians. exponential and logarithm, for depths of logarithmic codes, use only + - x / and the
// exact floor, frexp and ldexp: within 1 ulp. All are tested against long double. sorted_element is for
// medians. SplitMix64 returns random numbers one by one from a seed, mix64 one for a given number, so that
// pixels can be drawn in any order.
//
// A ByteHash is XXH64; StateBytes are what an object remembers, for another process.
//
// Threads: any may call these pure functions; one at a time uses an object.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// The element that sorting would put at this place; reorders the others.
auto sorted_element(auto& numbers, std::size_t place) {
    const auto at = numbers.begin() + static_cast<std::ptrdiff_t>(place);
    std::ranges::nth_element(numbers, at);
    return *at;
}

inline constexpr double pi = 3.14159265358979323846;

double sine(double x);
double cosine(double x);
double arctangent(double x);
/// Angle of the point (x, y), in (-pi, pi]; 0 at the origin.
double arctangent2(double y, double x);
/// Domain [-1, 1]; arguments beyond are clamped.
double arcsine(double x);

/// e^x; infinity above 709.78, where a double overflows; 0 below -745.14.
double exponential(double x);
/// The natural logarithm; -infinity for 0, NaN for negative numbers.
double logarithm(double x);

/// Spreads 64 bits over 64 bits, one to one (splitmix64's finaliser).
constexpr std::uint64_t mix64(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
}

/// splitmix64: the same numbers from a seed on every machine.
class SplitMix64 {
public:
    explicit constexpr SplitMix64(std::uint64_t seed) : state_(seed) {}

    constexpr std::uint64_t next() { return mix64(state_ += 0x9e3779b97f4a7c15U); }
    /// In [0, 1), 53 bits.
    constexpr double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
    /// In [low, high).
    constexpr double within(double low, double high) { return low + (high - low) * unit(); }

private:
    std::uint64_t state_;
};

/// XXH64 (seed 0) of bytes that are added piece by piece.
class ByteHash : NonCopyable {
public:
    ByteHash();
    ~ByteHash();

    void add(const void* bytes, std::size_t size);
    /// The same with its state saved, or read back.
    void each_state(class StateBytes& bytes);
    std::uint64_t value() const;
    std::string hex() const;  ///< 16 digits

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// An object's state as bytes that are the same on every machine: 8 for each number, flag and enumerator,
/// little-endian. An object lists its members once, for writing and for reading back:
///     void each_state(StateBytes& bytes) { bytes(speed_, has_started_); }
class StateBytes {
public:
    StateBytes() = default;  ///< writes
    explicit StateBytes(std::span<const std::uint8_t> from) : from_(from), reads_(true) {}
    void operator()(auto&... members) { (member(members), ...); }
    bool reads() const { return reads_; }
    /// What was written; what is left to be read.
    const std::vector<std::uint8_t>& written() const { return written_; }
    std::size_t left() const { return from_.size(); }
    /// False: there were too few bytes, or a value that no object has; the members read are worth nothing.
    bool is_sound() const { return sound_; }
    void expect(bool sound) { sound_ = sound_ && sound; }

private:
    template <class T>
    void member(T& value) {
        if constexpr (std::is_floating_point_v<T>) {
            value = std::bit_cast<T>(word(std::bit_cast<std::uint64_t>(value)));
            expect(value - value == 0);  // finite
        } else if constexpr (std::is_integral_v<T> || std::is_enum_v<T>) {
            const std::uint64_t bits = word(static_cast<std::uint64_t>(value));
            value = static_cast<T>(bits);
            expect(static_cast<std::uint64_t>(value) == bits);
        } else if constexpr (requires { value.has_value(); }) {
            bool has = value.has_value();
            member(has);
            if (!has)
                value.reset();
            else if (!value)
                value.emplace();
            if (has) member(*value);
        } else if constexpr (requires { value.z; }) {
            (*this)(value.x, value.y, value.z);
        } else {
            value.each_state(*this);
        }
    }
    std::uint64_t word(std::uint64_t bits);

    std::span<const std::uint8_t> from_;
    std::vector<std::uint8_t> written_;
    bool reads_ = false, sound_ = true;
};

}  // namespace touchable
