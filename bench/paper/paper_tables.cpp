// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "bench/paper/scratch_run.hpp"
#include "bench/paper/scripted_path.hpp"
#include "bench/paper/sweep_run.hpp"
#include "bench/suite.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

using Measured = std::vector<CaseFigures>;

std::optional<double> figure_of(const Measured& measured, const std::string& name,
                                const std::string& metric) {
    for (const CaseFigures& c : measured)
        for (const Figure& figure : c.figures)
            if (c.name == name && figure.metric == metric) return figure.value;
    return std::nullopt;
}

bool has_case_with(const Measured& measured, const std::string& part) {
    for (const CaseFigures& c : measured)
        if (c.name.find(part) != std::string::npos) return true;
    return false;
}

// --- Fig. 19

/// mN RMS, decibels relative to no median, and how far the finger is held back; empty: not measured.
std::string cell_of(const Measured& measured, const std::string& name, const std::string& without_filter) {
    const auto band = figure_of(measured, name, "force_band_mn");
    const auto back = figure_of(measured, name, "held_back_mm");
    const auto none = figure_of(measured, without_filter, "force_band_mn");
    if (!band || !back) return "";
    if (none && *none > 0)
        return formatted("%8.1f %6.1f dB %6.1f mm", *band, 20 * std::log10(*band / *none), *back);
    return formatted("%8.1f %9s %6.1f mm", *band, "", *back);
}

struct FilterRow {
    const char *words, *filter, *more;  // parts of the cases' names
};
constexpr FilterRow filter_rows[] = {{"no median", "", ""},
                                     {"median 3x3", "-m3", ""},
                                     {"median 5x5", "-m5", ""},
                                     {"5x5, terraces removed", "-m5-t", ""},
                                     {"the same, averaged over frames", "-m5-t", "-temporal"}};

/// Prints a block: the filters of one clip, in both metrics.
void print_filters(const Measured& measured, const std::string& heading, const std::string& run) {
    std::string lines;
    for (const FilterRow& row : filter_rows) {
        std::string cells[2];
        for (int k = 0; k < 2; ++k) {
            const std::string begin = std::string("chest-320x240-8-1f-") + (k == 0 ? "pixel" : "world");
            cells[k] = cell_of(measured, begin + row.filter + run + row.more, begin + run);
        }
        if (cells[0].empty() && cells[1].empty()) continue;
        lines += formatted("    %-32s %-29s %s\n", row.words, cells[0].c_str(), cells[1].c_str());
    }
    if (!lines.empty()) std::printf("  %s\n%s", heading.c_str(), lines.c_str());
}

void print_figure_19(const Measured& measured) {
    std::printf(
        "\nFig. 19: a scripted hand scratches for 100 s. Force between 20 and 500 Hz, mN RMS; the same in "
        "decibels\n"
        "to no median; how far the surface holds the finger back. The paper's text gives no figures: with a\n"
        "median the density \"noticeably decreased\", and without one the finger \"fell into the "
        "crevasses\".\n"
        "    %-32s %-29s %s\n",
        "", "metric pixel, the paper's", "metric world, ours");
    for (const std::string noise : {"1", "0.5", "2"}) {
        const std::string levels = "noise of " + noise + (noise == "1" ? " level" : " levels");
        for (const ScratchHand& hand : scratch_hands)
            print_filters(measured, levels + ", the clip plays, " + std::string(hand.words),
                          "-scratch-n" + noise + std::string(hand.name));
        print_filters(measured, levels + ", one frame, softly", "-scratch-n" + noise + "-still");
    }
}

// --- Table I

struct PaperRow {
    const char* who;
    double microseconds, primitives;
};
struct Content {
    const char* words;
    const char* begin;  // start of the cases' names
    const char* ours;   // filter
    std::array<PaperRow, 4> paper;
};
constexpr std::array contents{
    Content{"synthetic contents, 720x480",
            "globe-720x480-8-1f-",
            "-t",
            {PaperRow{"user 1", 274.5, 6.712}, PaperRow{"user 2", 229.3, 4.433},
             PaperRow{"user 3", 256.5, 5.502}, PaperRow{"average", papers_globe_us, 5.549}}},
    Content{"natural contents, 320x240",
            "chest-320x240-8-1f-",
            "-m5-t",
            {PaperRow{"user 1", 77.5, 3.303}, PaperRow{"user 2", 74.1, 3.017},
             PaperRow{"user 3", 91.0, 4.174}, PaperRow{"average", papers_chest_us, 3.498}}}};

constexpr std::array table_columns{"tick_us_second_max", "tick_us_second_max_undisturbed", "tick_us_p50",
                                   "tick_us_p99",        "primitives_second_max",          "primitives_mean"};
using Row = std::array<double, table_columns.size()>;

std::optional<Row> row_of(const Measured& measured, const std::string& name) {
    Row row{};
    for (std::size_t k = 0; k < table_columns.size(); ++k) {
        const auto value = figure_of(measured, name, table_columns[k]);
        if (!value) return std::nullopt;
        row[k] = *value;
    }
    return row;
}

void print_row(const std::string& who, const Row& row) {
    std::printf("    %-24s", who.c_str());
    for (const double value : row) std::printf(" %11.4g", value);
    std::printf("\n");
}

/// Prints a row per scripted hand, and their average if all were measured.
void print_hands(const Measured& measured, const std::string& words, const std::string& begin) {
    Row average{};
    std::size_t hands = 0;
    for (const ScriptedPath& path : fast_hands) {
        const std::string hand(path.name);
        const auto row = row_of(measured, begin + "-" + hand);
        if (!row) continue;
        print_row(words + ", " + hand, *row);
        for (std::size_t k = 0; k < average.size(); ++k) average[k] += (*row)[k] / std::size(fast_hands);
        ++hands;
    }
    if (hands == std::size(fast_hands)) print_row(words + ", average", average);
}

void print_table_1(const Measured& measured) {
    std::printf(
        "\nTable I: a hand moves fast, in contact. Hands here are scripted. us; \"largest\" is the mean over "
        "the seconds of\n"
        "the largest of each, \"undisturbed\" the same of each tick's least time over the repeats.\n"
        "    %-24s %44s %24s\n"
        "    %-24s %11s %11s %11s %11s %11s %11s\n",
        "", "time of a tick", "primitives passed", "", "largest", "undisturbed", "median", "99 %", "largest",
        "mean");
    for (const Content& content : contents) {
        std::printf("  %s\n", content.words);
        for (const PaperRow& row : content.paper)
            std::printf("    %-24s %11.4g %11s %11s %11s %11.4g\n",
                        (std::string("paper, ") + row.who).c_str(), row.microseconds, "", "", "",
                        row.primitives);
        const std::string begin = content.begin;
        print_hands(measured, "its method", begin + "pixel-m3-lazy");
        print_hands(measured, "ours", begin + "world" + content.ours);
    }
}

}  // namespace

Result<void> conclude_paper(const Measured& measured) {
    if (has_case_with(measured, "scratch")) print_figure_19(measured);
    for (const ScriptedPath& path : fast_hands)
        if (has_case_with(measured, "-" + std::string(path.name))) {
            print_table_1(measured);
            break;
        }
    return {};
}

}  // namespace touchable
