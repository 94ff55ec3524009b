// SPDX-License-Identifier: Apache-2.0
#include "bench/targets.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/base/words.hpp"

namespace touchable {
namespace {

std::optional<double> metric_of(const std::vector<CaseFigures>& measured, const std::string& name,
                                const std::string& metric) {
    for (const CaseFigures& c : measured)
        if (c.name == name)
            for (const Figure& figure : c.figures)
                if (figure.metric == metric) return figure.value;
    return std::nullopt;
}

std::string text(double value, const std::string& unit) {
    return formatted("%.5g", value) + (unit.empty() ? "" : " " + unit);
}

std::string in_words(const Limit& limit) {
    if (limit.sense == Limit::Sense::none) return "";
    const char* const sign = limit.sense == Limit::Sense::below     ? "< "
                             : limit.sense == Limit::Sense::at_most ? "<= "
                                                                    : ">= ";
    return sign + text(limit.value, limit.unit);
}

bool keeps(double value, const Limit& limit) {
    switch (limit.sense) {
        case Limit::Sense::below:
            return value < limit.value;
        case Limit::Sense::at_most:
            return value <= limit.value;
        case Limit::Sense::at_least:
            return value >= limit.value;
        case Limit::Sense::none:
            break;
    }
    return true;
}

/// NaN counts as worst.
bool is_worse(double value, double than, const Limit& limit) {
    return limit.sense == Limit::Sense::at_least ? !(value >= than) : !(value <= than);
}

const char* in_a_word(const Target& target, const Verdict& verdict) {
    if (!verdict.asked) return "not asked here";
    if (verdict.met) return target.limit.sense == Limit::Sense::none ? "" : "met";
    return "MISSED";
}

std::string left_aligned(std::string words, std::size_t width) {
    if (words.size() < width) words.resize(width, ' ');
    return words;
}

}  // namespace

Verdict judge(const Target& target, const std::vector<CaseFigures>& measured) {
    Verdict verdict;
    double unit = 1;
    if (!target.relative_to.empty()) {
        const auto base = metric_of(measured, target.relative_to, target.metric);
        if (!base) return verdict;
        unit = *base;
    }
    std::size_t left_out = 0;
    for (const std::string& name : target.cases) {
        const auto value = metric_of(measured, name, target.metric);
        if (!value) continue;
        if (!target.only_where.empty() && metric_of(measured, name, target.only_where) != 1.0) {
            ++left_out;
            continue;
        }
        const double share = *value / unit;
        if (verdict.cases == 0 || is_worse(share, verdict.value, target.limit)) {
            verdict.value = share;
            verdict.worst = name;
        }
        ++verdict.cases;
        if (std::isnan(share)) break;  // nothing is worse
    }
    verdict.asked = verdict.cases > 0 || left_out == 0;
    verdict.met = verdict.cases > 0 && keeps(verdict.value, target.limit);
    return verdict;
}

std::vector<Target> measured_targets(std::vector<Target> targets, const std::vector<CaseFigures>& measured) {
    std::erase_if(targets, [&](const Target& target) {
        return std::ranges::none_of(
            measured, [&](const CaseFigures& c) { return std::ranges::count(target.cases, c.name) > 0; });
    });
    return targets;
}

std::string table_of(const std::vector<Target>& targets, const std::vector<CaseFigures>& measured) {
    const auto line = [](const std::string& what, const std::string& wanted, const std::string& value,
                         const std::string& cases, const std::string& verdict) {
        return left_aligned(what, 46) + left_aligned(wanted, 12) + left_aligned(value, 14) +
               left_aligned(cases, 8) + verdict + "\n";
    };
    std::string table = line("target", "wanted", "measured", "cases", "");
    for (const Target& target : targets) {
        const Verdict verdict = judge(target, measured);
        table += line(target.what, in_words(target.limit),
                      verdict.cases > 0 ? text(verdict.value, target.limit.unit) : "nothing",
                      std::to_string(verdict.cases) + "/" + std::to_string(target.cases.size()),
                      in_a_word(target, verdict));
    }
    return table;
}

std::vector<CaseFigures> records_of(const std::vector<Target>& targets,
                                    const std::vector<CaseFigures>& measured) {
    std::vector<CaseFigures> records;
    std::string above;
    for (const Target& target : targets) {
        const bool is_below = target.what.starts_with("  ");
        if (!is_below) above = target.what;
        if (measured_targets({target}, measured).empty()) continue;
        const Verdict verdict = judge(target, measured);
        CaseFigures record{"target: " + (is_below ? above + ": " + target.what.substr(2) : target.what), {}};
        if (verdict.cases > 0) {
            record.figures.push_back({"worst", verdict.value, target.limit.unit});
            record.figures.push_back(named("worst_case", verdict.worst));
        }
        record.figures.push_back(named("metric", target.metric));
        record.figures.push_back(named("limit", in_words(target.limit)));
        record.figures.push_back(named("verdict", in_a_word(target, verdict)));
        records.push_back(std::move(record));
    }
    return records;
}

}  // namespace touchable
