// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// One measured number of a case, or a name (of a GPU, for example).
struct Figure {
    std::string metric;
    double value;
    std::string_view unit;  ///< a literal: "us", "N", "deg", "JND", "mJ", "%", "ns", "ms", "KB", "MB",
                            ///< "MB/s", "GB/s", "px", "dB", "kg", "1/m", or "" for a count
    bool in_tables = true;  ///< false: one of many, for a plot; only in the JSON
    std::optional<std::string> name{};  ///< replaces the value
};
using Figures = std::vector<Figure>;
inline Figure named(std::string metric, std::string name) {
    return {std::move(metric), 0, "", true, std::move(name)};
}

/// One set-up to measure. Its name describes the set-up and is part of the interface.
struct BenchCase {
    std::string name;
    /// Appends its figures. An error if the timed result is wrong: a fast wrong answer is no result.
    std::function<Result<void>(Figures&)> measure;
};

/// The figures of one case of a suite.
struct CaseFigures {
    std::string name;
    Figures figures;
};

struct Target;

/// A suite lists its cases in one file (bench/README.md: how to add a suite).
struct BenchSuite {
    std::string_view name, what;
    /// `quick`: the same cases more coarsely, so that the suite ends within a minute.
    std::vector<BenchCase> (*cases)(bool quick);
    /// Optional: limits of figures. Those of measured cases are judged, printed and recorded; a missed one is
    /// no error.
    const std::vector<Target>& (*targets)() = nullptr;
    /// Optional: prints conclusions from all figures; an error if they miss a requirement.
    Result<void> (*conclude)(const std::vector<CaseFigures>& measured) = nullptr;
};

std::vector<BenchCase> touch_cases(bool quick);
std::vector<BenchCase> surface_cases(bool quick);
std::vector<BenchCase> gpu_cases(bool quick);
std::vector<BenchCase> loop_cases(bool quick);
std::vector<BenchCase> paper_cases(bool quick);
/// Prints the paper's figures beside the measured ones.
Result<void> conclude_paper(const std::vector<CaseFigures>& measured);
std::vector<BenchCase> stream_cases(bool quick);
std::vector<BenchCase> live_cases(bool quick);
std::vector<BenchCase> play_cases(bool quick);
/// The cases of the suites touch and surface that have targets; an error if a target is missed.
std::vector<BenchCase> target_cases(bool quick);
Result<void> conclude_targets(const std::vector<CaseFigures>& measured);

}  // namespace touchable
