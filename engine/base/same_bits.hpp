#pragma once

// Arithmetic that is the same bits on every CPU, compiler and C library, and the hash by which two runs are
// compared.
//
// What reaches a force, a code or a generated scene calls nothing that a library may round in its own way
// (docs/architecture.md, decision 3). Sine, cosine and angles are made of + - x /, sqrt and the exact fmod:
// within 2 ulp of the correctly rounded value for |x| <= 1e6, losing digits beyond; arguments in radians. e
// to a power and its inverse, for depths of logarithmic codes, are made of + - x / and the exact floor, frexp
// and ldexp: within 1 ulp. Both are tested against long double.
//
// Pure functions, for any thread; a ByteHash is used by one thread at a time.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "engine/base/result.hpp"

namespace touchable {

inline constexpr double pi = 3.14159265358979323846;

double sine(double x);
double cosine(double x);
double arctangent(double x);
/// Angle of the point (x, y), in (-pi, pi]; 0 at the origin.
double arctangent2(double y, double x);
/// Domain [-1, 1]; arguments beyond are clamped.
double arcsine(double x);

/// e^x; infinity where a double ends (above 709.78), 0 below -745.14.
double exponential(double x);
/// The natural logarithm; of 0 -infinity, of less NaN.
double logarithm(double x);

/// XXH64 (seed 0) of bytes as they come.
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
