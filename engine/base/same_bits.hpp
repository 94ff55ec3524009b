#pragma once

// Arithmetic with the same bits on every CPU, compiler and C library, and the hash that compares two runs.
//
// Functions whose result reaches a force, a depth code or a generated scene must not call what each library
// may round in its own way (docs/architecture.md, decision 3). Sine, cosine and angles use only + - x /, sqrt
// and the exact fmod: within 2 ulp of the correctly rounded value for |x| <= 1e6, with fewer digits beyond;
// arguments in radians. exponential and logarithm, for depths of logarithmic codes, use only + - x / and the
// exact floor, frexp and ldexp: within 1 ulp. All are tested against long double. sorted_element is for
// medians.
//
// Threads: any may call these pure functions; one at a time uses a ByteHash.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
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

/// XXH64 (seed 0) of bytes that are added piece by piece.
class ByteHash : NonCopyable {
public:
    ByteHash();
    ~ByteHash();

    void add(const void* bytes, std::size_t size);
    std::uint64_t value() const;
    std::string hex() const;  ///< 16 digits

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace touchable
