// SPDX-License-Identifier: Apache-2.0
#include "bench/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>

#include "engine/base/files.hpp"
#include "engine/base/hand_thresholds.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

/// Most cases, or metrics, that fit side by side.
constexpr std::size_t most_cases = 10, most_metrics = 30;

bool is_wide(const CaseFigures& c) {
    return c.figures.size() > most_metrics;
}

bool same_metrics(const Figures& a, const Figures& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const Figure& x, const Figure& y) { return x.metric == y.metric; });
}

/// A name over several lines, broken after underscores and hyphens.
std::vector<std::string> broken(const std::string& name) {
    constexpr std::size_t widest = 9;
    std::vector<std::string> lines{""};
    for (std::size_t begin = 0; begin < name.size();) {
        const std::size_t end = std::min(name.find_first_of("_-", begin), name.size() - 1) + 1;
        if (!lines.back().empty() && lines.back().size() + end - begin > widest) lines.emplace_back();
        lines.back().append(name, begin, end - begin);
        begin = end;
    }
    return lines;
}

std::string text_of(const Figure& figure) {
    if (figure.name) return *figure.name;
    const double value = figure.value;
    const bool whole = value == std::floor(value) && std::fabs(value) < 1e9;
    return formatted(whole ? "%.0f" : "%.4g", value);
}

std::string padded(const std::string& text, std::size_t width) {
    return std::string(width - std::min(width, text.size()), ' ') + text;
}

/// One column: heading lines, unit, and a value per row.
struct Column {
    std::vector<std::string> heading, values;
    std::size_t width() const {
        std::size_t widest = 0;
        for (const auto* lines : {&heading, &values})
            for (const std::string& line : *lines) widest = std::max(widest, line.size());
        return widest;
    }
};

std::string table_of(const std::vector<std::string>& rows, const std::vector<Column>& columns) {
    std::size_t heading_lines = 0, name_width = 0;
    for (const Column& column : columns) heading_lines = std::max(heading_lines, column.heading.size());
    for (const std::string& row : rows) name_width = std::max(name_width, row.size());
    std::string text;
    for (std::size_t line = 0; line < heading_lines; ++line) {
        text += std::string(name_width, ' ');
        for (const Column& column : columns)
            text += "  " + padded(line < column.heading.size() ? column.heading[line] : "", column.width());
        text += '\n';
    }
    for (std::size_t n = 0; n < rows.size(); ++n) {
        text += rows[n] + std::string(name_width - rows[n].size(), ' ');
        for (const Column& column : columns) text += "  " + padded(column.values[n], column.width());
        text += '\n';
    }
    return text;
}

std::string with_unit(const std::string& name, std::string_view unit, const char* before) {
    return unit.empty() ? name : name + before + "(" + std::string(unit) + ")";
}

/// A row per case; all have the same metrics.
std::string row_per_case(const CaseFigures* first, const CaseFigures* last) {
    std::vector<std::string> rows;
    for (const CaseFigures* c = first; c != last; ++c) rows.push_back(c->name);
    std::vector<Column> columns;
    for (std::size_t m = 0; m < first->figures.size(); ++m) {
        const Figure& figure = first->figures[m];
        Column column{broken(figure.metric), {}};
        if (!figure.unit.empty()) column.heading.push_back(with_unit("", figure.unit, ""));
        for (const CaseFigures* c = first; c != last; ++c) column.values.push_back(text_of(c->figures[m]));
        columns.push_back(std::move(column));
    }
    return table_of(rows, columns);
}

/// A row per metric of any of the cases, in the order of the first that has it.
std::string row_per_metric(std::span<const CaseFigures> cases) {
    std::vector<std::string> metrics, rows;
    for (const CaseFigures& c : cases) {
        std::size_t at = 0;  // after the previous metric: keeps metrics that other cases lack in order
        for (const Figure& figure : c.figures) {
            const auto known = std::find(metrics.begin(), metrics.end(), figure.metric);
            if (known == metrics.end()) {
                const auto place = static_cast<std::ptrdiff_t>(at);
                metrics.insert(metrics.begin() + place, figure.metric);
                rows.insert(rows.begin() + place, with_unit(figure.metric, figure.unit, " "));
                ++at;
            } else {
                at = static_cast<std::size_t>(known - metrics.begin()) + 1;
            }
        }
    }
    std::vector<Column> columns;
    for (const CaseFigures& c : cases) {
        Column column{broken(c.name), {}};
        for (const std::string& metric : metrics) {
            const auto figure = std::find_if(c.figures.begin(), c.figures.end(),
                                             [&](const Figure& f) { return f.metric == metric; });
            column.values.push_back(figure == c.figures.end() ? "" : text_of(*figure));
        }
        columns.push_back(std::move(column));
    }
    return table_of(rows, columns);
}

Error cannot_write(const std::filesystem::path& file) {
    return input_error(file.string() + ": cannot be written; its folder must exist and be writable");
}

}  // namespace

std::string tables_of(const std::vector<CaseFigures>& measured) {
    std::vector<CaseFigures> cases = measured;
    for (CaseFigures& c : cases)
        std::erase_if(c.figures, [](const Figure& figure) { return !figure.in_tables; });
    std::string text;
    const CaseFigures* const end = cases.data() + cases.size();
    for (const CaseFigures* first = cases.data(); first != end;) {
        const CaseFigures* last = first + 1;
        const bool wide = is_wide(*first);
        const auto belongs = [&](const CaseFigures& c) {
            return wide ? is_wide(c) && last < first + most_cases : same_metrics(first->figures, c.figures);
        };
        while (last != end && belongs(*last)) ++last;
        if (!text.empty()) text += '\n';
        text += wide ? row_per_metric({first, last}) : row_per_case(first, last);
        first = last;
    }
    return text;
}

void add_jnd(Figures& figures) {
    Figures with;
    for (Figure& figure : figures) {
        std::string metric = figure.metric;
        const double jnd = direction_jnd(figure.value);
        const auto at = metric.find("_deg");
        const bool is_direction = std::ranges::any_of(
            std::array{"force_angle", "face_angle", "force_jitter"},
            [&](const char* begin) { return at != std::string::npos && metric.starts_with(begin); });
        with.push_back(std::move(figure));
        if (!is_direction) continue;
        const bool is_of_a_bin = metric.back() >= '0' && metric.back() <= '9';
        with.push_back({metric.replace(at, 4, "_jnd"), jnd, "JND", !is_of_a_bin});
    }
    figures = std::move(with);
}

Result<void> check_writable(const std::filesystem::path& file) {
    const NewFile probe(file);  // removed at the end of this function
    return probe.check();
}

Result<void> write_report(const std::filesystem::path& file, std::string_view suite,
                          const std::vector<CaseFigures>& cases) {
    NewFile whole(file);
    std::ofstream out(whole.path());
    const char* separator = "[\n";
    for (const CaseFigures& c : cases)
        for (const Figure& figure : c.figures) {
            nlohmann::ordered_json row{{"suite", suite},
                                       {"case", c.name},
                                       {"metric", figure.metric},
                                       {"value", figure.value},
                                       {"unit", figure.unit}};
            if (figure.name) row["value"] = *figure.name;
            out << separator << row.dump();
            separator = ",\n";
        }
    out << "\n]\n";
    out.close();
    if (!out) return cannot_write(file);
    return whole.commit();
}

}  // namespace touchable
