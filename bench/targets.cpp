#include "bench/targets.hpp"

#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

namespace touchable {
namespace {

using Names = std::vector<std::string>;

const Names up_to_full_hd{"320x240", "720x480", "1280x720", "1920x1080"};

/// <scene>-<size>-<rest>, for each size and each of the ends.
Names cases_of(const std::string& scene, const Names& sizes, const Names& rests) {
    Names names;
    for (const std::string& size : sizes)
        for (const std::string& rest : rests) names.push_back(scene + "-" + size + "-" + rest);
    return names;
}

Names both(Names a, const Names& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

std::vector<Target> make_targets() {
    std::vector<Target> targets;
    const auto add = [&](const char* what, const char* elsewhere, Names cases, const char* metric,
                         Limit limit, std::string relative_to = "") {
        targets.push_back(
            {what, elsewhere, std::move(cases), metric, std::move(limit), std::move(relative_to)});
    };
    const auto below = [](double value, const char* unit) { return Limit{value, false, unit}; };
    const auto at_most = [](double value, const char* unit) { return Limit{value, true, unit}; };

    const std::string small = "bumps-320x240-16-1f-world", huge = "bumps-3840x2160-16-1f-world";
    const Names bumps = cases_of("bumps", up_to_full_hd, {"16-1f-world"});
    add("tick, bumps, to 1920x1080, mean", "253 (paper), 3-15", bumps, "tick_us_mean", below(0.5, "us"));
    add("tick, bumps, to 1920x1080, p99", "9-51", bumps, "tick_us_p99", below(2, "us"));
    add("tick, bumps, 3840x2160, mean", "", {huge}, "tick_us_mean", below(1, "us"));
    add("a cell, 3840x2160 over 320x240", "", {huge}, "ns_per_cell", at_most(1, ""), small);
    add("tick of 5 fingers, 1920x1080, mean", "1267 (paper)", {"bumps-1920x1080-16-5f-world"}, "tick_us_mean",
        below(3, "us"));
    add("tick of 10 fingers, 1920x1080, mean", "", {"bumps-1920x1080-16-10f-world"}, "tick_us_mean",
        below(6, "us"));
    add("new frame, to the solver", "72e3-1755e3", cases_of("moving", up_to_full_hd, {"16-1f-world-frames"}),
        "new_frame_us", below(1, "us"));

    const std::string sharp = "globe-1920x1080-16-1f-world", coarse = "globe-720x480-16-1f-world";
    add("force direction, globe, 1920x1080", "49 (paper)", {sharp}, "force_angle_deg_rms", below(1.2, "deg"));
    add("  less than 45 deg from the axis", "", {sharp}, "force_angle_deg_rms_0_45", below(0.5, "deg"));
    add("force direction, globe, 720x480", "49 (paper)", {coarse}, "force_angle_deg_rms", below(2.2, "deg"));

    const Names proven{sharp + "-proven", coarse + "-proven"};
    add("  from long double's, globe, same basin", "", proven, "reference_angle_deg_max", below(1e-7, "deg"));

    const Names follow{"16-1f-world-follow-0.05", "16-1f-world-follow-0.1", "16-1f-world-follow-0.3"};
    const Names bumps_runs = cases_of("bumps", up_to_full_hd, follow);
    const Names moving_runs = cases_of("moving", up_to_full_hd, follow);
    add("off the surface, bumps, 0.05-0.3 m/s", "up to 89", bumps_runs, "off_surface_pct", at_most(0, "%"));
    add("off the surface, moving, 0.05-0.3 m/s", "99.8", moving_runs, "off_surface_pct", at_most(0, "%"));
    add("contact lost, bumps and moving", "279-299 in 20 s", both(bumps_runs, moving_runs),
        "contact_lost_ticks", at_most(0, "ticks"));

    const Names rough =
        cases_of("rough", up_to_full_hd,
                 {"16-1f-world-proven-0.05", "16-1f-world-proven-0.1", "16-1f-world-proven-0.3"});
    add("rough, 0.05-0.3 m/s: no minimum", "", rough, "non_minima_ticks", at_most(0, "ticks"));
    add("  fallen through", "", rough, "tunnelled_ticks", at_most(0, "ticks"));
    add("  |P - G| over long double's", "", rough, "distance_over_reference_max", at_most(1.0001, ""));

    add("energy of a loop over what holding gives", "", {sharp, coarse}, "energy_held_over_bound",
        at_most(1, ""));
    add("energy of a loop, holding left out", "9.7-14 (paper)", {sharp, coarse}, "energy_created_mj_max",
        at_most(0, "mJ"));
    return targets;
}

std::optional<double> metric_of(const std::vector<CaseFigures>& measured, const std::string& name,
                                const std::string& metric) {
    for (const CaseFigures& c : measured)
        if (c.name == name)
            for (const Figure& figure : c.figures)
                if (figure.metric == metric) return figure.value;
    return std::nullopt;
}

std::string text(double value, const std::string& unit) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.5g", value);
    return unit.empty() ? digits : std::string(digits) + " " + unit;
}

std::string left_aligned(std::string words, std::size_t width) {
    if (words.size() < width) words.resize(width, ' ');
    return words;
}

}  // namespace

const std::vector<Target>& touch_targets() {
    static const std::vector<Target> targets = make_targets();
    return targets;
}

Verdict judge(const Target& target, const std::vector<CaseFigures>& measured) {
    Verdict verdict;
    double unit = 1;
    if (!target.relative_to.empty()) {
        const auto base = metric_of(measured, target.relative_to, target.metric);
        if (!base) return verdict;
        unit = *base;
    }
    verdict.value = -std::numeric_limits<double>::infinity();
    for (const std::string& name : target.cases)
        if (const auto value = metric_of(measured, name, target.metric)) {
            const double share = *value / unit;
            if (!(share <= verdict.value)) verdict.value = share;
            ++verdict.cases;
            if (std::isnan(share)) break;  // nothing is worse
        }
    const bool within =
        target.limit.may_equal ? verdict.value <= target.limit.value : verdict.value < target.limit.value;
    verdict.met = verdict.cases > 0 && within;
    return verdict;
}

std::string table_of(const std::vector<Target>& targets, const std::vector<CaseFigures>& measured) {
    const auto line = [](const std::string& what, const std::string& elsewhere, const std::string& wanted,
                         const std::string& value, const std::string& cases, const std::string& verdict) {
        return left_aligned(what, 43) + left_aligned(elsewhere, 22) + left_aligned(wanted, 12) +
               left_aligned(value, 14) + left_aligned(cases, 8) + verdict + "\n";
    };
    std::string table = line("target", "elsewhere", "wanted", "measured", "cases", "");
    for (const Target& target : targets) {
        const Verdict verdict = judge(target, measured);
        const Limit& limit = target.limit;
        table += line(target.what, target.elsewhere,
                      (limit.may_equal ? "<= " : "< ") + text(limit.value, limit.unit),
                      verdict.cases > 0 ? text(verdict.value, limit.unit) : "nothing",
                      std::to_string(verdict.cases) + "/" + std::to_string(target.cases.size()),
                      verdict.met ? "met" : "MISSED");
    }
    return table;
}

}  // namespace touchable
