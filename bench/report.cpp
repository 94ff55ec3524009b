#include "bench/report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/new_file.hpp"

namespace touchable {
namespace {

bool same_metrics(const Figures& a, const Figures& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const Figure& x, const Figure& y) { return x.metric == y.metric; });
}

/// A metric's name over several lines, broken behind underscores.
std::vector<std::string> broken(const std::string& metric) {
    constexpr std::size_t widest = 9;
    std::vector<std::string> lines{""};
    for (std::size_t begin = 0; begin < metric.size();) {
        const std::size_t end = std::min(metric.find('_', begin), metric.size() - 1) + 1;
        if (!lines.back().empty() && lines.back().size() + end - begin > widest) lines.emplace_back();
        lines.back().append(metric, begin, end - begin);
        begin = end;
    }
    return lines;
}

std::string text_of(double value) {
    char text[64];
    const bool whole = value == std::floor(value) && std::fabs(value) < 1e9;
    std::snprintf(text, sizeof text, whole ? "%.0f" : "%.4g", value);
    return text;
}

std::string padded(const std::string& text, std::size_t width) {
    return std::string(width - std::min(width, text.size()), ' ') + text;
}

/// One column: heading lines, unit, and a value per case.
struct Column {
    std::vector<std::string> heading, values;
    std::size_t width() const {
        std::size_t widest = 0;
        for (const auto* lines : {&heading, &values})
            for (const std::string& line : *lines) widest = std::max(widest, line.size());
        return widest;
    }
};

std::string table_of(const CaseFigures* first, const CaseFigures* last) {
    std::vector<Column> columns;
    std::size_t heading_lines = 0, name_width = 0;
    for (std::size_t m = 0; m < first->figures.size(); ++m) {
        Column column{broken(first->figures[m].metric), {}};
        if (!first->figures[m].unit.empty())
            column.heading.push_back(std::string("(").append(first->figures[m].unit).append(")"));
        for (const CaseFigures* c = first; c != last; ++c)
            column.values.push_back(text_of(c->figures[m].value));
        heading_lines = std::max(heading_lines, column.heading.size());
        columns.push_back(std::move(column));
    }
    for (const CaseFigures* c = first; c != last; ++c) name_width = std::max(name_width, c->name.size());

    std::string text;
    for (std::size_t line = 0; line < heading_lines; ++line) {
        text += std::string(name_width, ' ');
        for (const Column& column : columns)
            text += "  " + padded(line < column.heading.size() ? column.heading[line] : "", column.width());
        text += '\n';
    }
    for (const CaseFigures* c = first; c != last; ++c) {
        text += c->name + std::string(name_width - c->name.size(), ' ');
        for (const Column& column : columns)
            text += "  " + padded(column.values[static_cast<std::size_t>(c - first)], column.width());
        text += '\n';
    }
    return text;
}

Error cannot_write(const std::filesystem::path& file) {
    return input_error(file.string() + ": cannot be written; its folder must exist and be writable");
}

}  // namespace

std::string tables_of(const std::vector<CaseFigures>& cases) {
    std::string text;
    const CaseFigures* const end = cases.data() + cases.size();
    for (const CaseFigures* first = cases.data(); first != end;) {
        const CaseFigures* last = first + 1;
        while (last != end && same_metrics(first->figures, last->figures)) ++last;
        if (!text.empty()) text += '\n';
        text += table_of(first, last);
        first = last;
    }
    return text;
}

Result<void> check_writable(const std::filesystem::path& file) {
    const NewFile probe(file);  // removed at the end of this function
    if (auto usable = probe.check_target(); !usable.ok()) return usable;
    if (!std::ofstream(probe.path())) return cannot_write(file);
    return {};
}

Result<void> write_report(const std::filesystem::path& file, std::string_view suite,
                          const std::vector<CaseFigures>& cases) {
    NewFile whole(file);
    std::ofstream out(whole.path());
    const char* separator = "[\n";
    for (const CaseFigures& c : cases)
        for (const Figure& figure : c.figures) {
            const nlohmann::ordered_json row{{"suite", suite},
                                             {"case", c.name},
                                             {"metric", figure.metric},
                                             {"value", figure.value},
                                             {"unit", figure.unit}};
            out << separator << row.dump();
            separator = ",\n";
        }
    out << "\n]\n";
    out.close();
    if (!out) return cannot_write(file);
    return whole.commit();
}

}  // namespace touchable
