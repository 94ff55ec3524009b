#pragma once

/// Sine, cosine and angles from + - x /, sqrt and the exact fmod alone, so that hands and generated scenes
/// are the same bits on every CPU, compiler and C library. Within 2 ulp of the correctly rounded value for
/// |x| <= 1e6 (tested against long double), losing digits beyond; arguments in radians.
namespace touchable {

inline constexpr double pi = 3.14159265358979323846;

double sine(double x);
double cosine(double x);
double arctangent(double x);
/// Angle of the point (x, y), in (-pi, pi]; 0 at the origin.
double arctangent2(double y, double x);
/// Domain [-1, 1]; arguments beyond are clamped.
double arcsine(double x);

}  // namespace touchable
