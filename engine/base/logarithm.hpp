#pragma once

/// e to a power and its inverse from + - x / and the exact floor, frexp and ldexp alone, so that depths of
/// logarithmic codes are the same bits on every CPU, compiler and C library. Within 1 ulp of the truth
/// (tested against long double).
namespace touchable {

/// e^x; infinity where a double ends (above 709.78), 0 below -745.14.
double exponential(double x);
/// The natural logarithm; of 0 -infinity, of less NaN.
double logarithm(double x);

}  // namespace touchable
