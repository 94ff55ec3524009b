#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/result.hpp"

namespace touchable {

/// One measured number of a case.
struct Figure {
    std::string metric;
    double value;
    std::string_view unit;  ///< a literal: "us", "N", "deg", "mJ", "%", "ns", "ms", or "" for a count
};
using Figures = std::vector<Figure>;

/// One set-up that is measured. Its name tells the set-up and is part of the interface.
struct BenchCase {
    std::string name;
    /// Appends its figures. An error where what was to be timed is not right: a fast wrong answer is no
    /// result.
    std::function<Result<void>(Figures&)> measure;
};

/// A suite is a file that lists its cases (bench/README.md: how to add one).
struct BenchSuite {
    std::string_view name, what;
    /// `quick`: the same things more coarsely, so that the suite ends within a minute.
    std::vector<BenchCase> (*cases)(bool quick);
};

std::vector<BenchCase> touch_cases(bool quick);
std::vector<BenchCase> surface_cases(bool quick);

}  // namespace touchable
