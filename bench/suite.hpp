#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// One measured number of a case, or a name of what it was measured on.
struct Figure {
    std::string metric;
    double value;
    std::string_view unit;  ///< a literal: "us", "N", "deg", "mJ", "%", "ns", "ms", "KB", "MB", "MB/s",
                            ///< "GB/s", "px", "dB", or "" for a count
    bool in_tables = true;  ///< false: many of its kind, for a plot; in the JSON alone
    std::optional<std::string> name{};  ///< stands in place of the value
};
using Figures = std::vector<Figure>;
inline Figure named(std::string metric, std::string name) {
    return {std::move(metric), 0, "", true, std::move(name)};
}

/// One set-up that is measured. Its name tells the set-up and is part of the interface.
struct BenchCase {
    std::string name;
    /// Appends its figures. An error where what was to be timed is not right: a fast wrong answer is no
    /// result.
    std::function<Result<void>(Figures&)> measure;
};

/// The figures of one case of a suite.
struct CaseFigures {
    std::string name;
    Figures figures;
};

/// A suite is a file that lists its cases (bench/README.md: how to add one).
struct BenchSuite {
    std::string_view name, what;
    /// `quick`: the same things more coarsely, so that the suite ends within a minute.
    std::vector<BenchCase> (*cases)(bool quick);
    /// Where there is one: prints what follows from all figures; an error where they are not what they should
    /// be.
    Result<void> (*conclude)(const std::vector<CaseFigures>& measured) = nullptr;
};

std::vector<BenchCase> touch_cases(bool quick);
std::vector<BenchCase> surface_cases(bool quick);
std::vector<BenchCase> gpu_cases(bool quick);
std::vector<BenchCase> loop_cases(bool quick);
std::vector<BenchCase> paper_cases(bool quick);
std::vector<BenchCase> media_cases(bool quick);
/// Prints which codec stores each plane in the least time of decoding, and which in the fewest bytes.
Result<void> conclude_media(const std::vector<CaseFigures>& measured);
/// Prints the paper's figures beside ours.
Result<void> conclude_paper(const std::vector<CaseFigures>& measured);
/// Print the table of the suite's targets, of touch those of real cameras' depth; missing one is no error
/// here.
Result<void> conclude_touch(const std::vector<CaseFigures>& measured);
Result<void> conclude_surface(const std::vector<CaseFigures>& measured);
std::vector<BenchCase> stream_cases(bool quick);
std::vector<BenchCase> capi_cases(bool quick);
std::vector<BenchCase> live_cases(bool quick);
/// Prints the table of targets; missing one is no error here.
Result<void> conclude_live(const std::vector<CaseFigures>& measured);
std::vector<BenchCase> play_cases(bool quick);
/// Prints the table of targets; missing one is no error here.
Result<void> conclude_play(const std::vector<CaseFigures>& measured);
/// Those of the suites touch and surface that targets stand on; tables of both, and an error where one is
/// missed.
std::vector<BenchCase> target_cases(bool quick);
Result<void> conclude_targets(const std::vector<CaseFigures>& measured);

}  // namespace touchable
