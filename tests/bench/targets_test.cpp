#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <string>

#include "bench/report.hpp"
#include "bench/targets.hpp"
#include "tests/temporary_files.hpp"

namespace touchable {
namespace {

Target target(const Limit& limit) {
    return {"a time", {"here", "there"}, "us", limit};
}
Target below(double value) {
    return target({value, Limit::Sense::below, "us"});
}
Target at_most(double value) {
    return target({value, Limit::Sense::at_most, "us"});
}
Target at_least(double value) {
    return target({value, Limit::Sense::at_least, "us"});
}

std::vector<CaseFigures> measured(double here, double there) {
    return {{"here", {{"other", 1000, ""}, {"us", here, "us"}}}, {"there", {{"us", there, "us"}}}};
}

TEST(Targets, AreJudgedByWorstCase) {
    const Verdict verdict = judge(below(3), measured(1, 2.5));
    EXPECT_TRUE(verdict.met);
    EXPECT_EQ(verdict.value, 2.5);
    EXPECT_EQ(verdict.cases, 2U);
    EXPECT_FALSE(judge(below(3), measured(3.5, 1)).met);
}

TEST(Targets, BelowIsStrict) {
    EXPECT_FALSE(judge(below(3), measured(3, 1)).met);
    EXPECT_TRUE(judge(at_most(3), measured(3, 1)).met);
    EXPECT_FALSE(judge(at_most(0), measured(0, 1e-12)).met);
}

TEST(Targets, AtLeastTakesLeastCase) {
    const Verdict verdict = judge(at_least(2), measured(5, 2));
    EXPECT_TRUE(verdict.met);
    EXPECT_EQ(verdict.value, 2);
    EXPECT_FALSE(judge(at_least(2), measured(5, 1.9)).met);
    EXPECT_FALSE(judge(at_least(2), measured(std::numeric_limits<double>::quiet_NaN(), 5)).met);
    EXPECT_FALSE(judge(at_least(2), {}).met);
}

TEST(Targets, SkipWhereNotApplicable) {
    Target t = below(3);
    t.only_where = "on_gpu";
    std::vector<CaseFigures> figures = measured(5, 1);
    figures[0].figures.push_back({"on_gpu", 0, ""});
    figures[1].figures.push_back({"on_gpu", 1, ""});
    EXPECT_TRUE(judge(t, figures).met);
    EXPECT_EQ(judge(t, figures).cases, 1U);
    figures[1].figures.back().value = 0;
    EXPECT_FALSE(judge(t, figures).asked);
    EXPECT_NE(table_of({t}, figures).find("not asked here\n"), std::string::npos);
    EXPECT_TRUE(judge(t, {}).asked);  // whether it applies is unknown
    EXPECT_FALSE(judge(t, {}).met);
}

TEST(Targets, MayHaveNoLimit) {
    const Target t = target({0, Limit::Sense::none, "us"});
    EXPECT_TRUE(judge(t, measured(4, 5)).met);
    EXPECT_FALSE(judge(t, {}).met);
    const std::string table = table_of({t}, measured(4, 5));
    EXPECT_NE(table.find("5 us"), std::string::npos) << table;
    EXPECT_EQ(table.find("met\n"), std::string::npos) << table;
}

TEST(Targets, UnmeasuredCanBeOmitted) {
    const std::vector<Target> both{below(3), {"elsewhere", {"nowhere"}, "us", below(3).limit}};
    const std::vector<Target> left = measured_targets(both, {{"there", {}}});
    ASSERT_EQ(left.size(), 1U);
    EXPECT_EQ(left[0].what, "a time");
}

TEST(Targets, UnmeasuredOrNanIsMissed) {
    EXPECT_FALSE(judge(below(3), {}).met);
    EXPECT_FALSE(judge(below(3), {{"elsewhere", {{"us", 1, "us"}}}}).met);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(judge(below(3), measured(nan, 1)).met);
    EXPECT_FALSE(judge(below(3), measured(1, nan)).met);
}

TEST(Targets, MayBeRelative) {
    Target t = at_most(1);
    t.cases = {"there"};
    t.relative_to = "here";
    EXPECT_EQ(judge(t, measured(4, 3)).value, 0.75);
    EXPECT_TRUE(judge(t, measured(4, 3)).met);
    EXPECT_FALSE(judge(t, measured(4, 5)).met);
    t.relative_to = "nowhere";
    EXPECT_FALSE(judge(t, measured(4, 3)).met);
}

TEST(Targets, TableShowsVerdicts) {
    const std::string table = table_of({below(3), below(2)}, measured(2.5, 1));
    EXPECT_NE(table.find("< 3 us"), std::string::npos) << table;
    EXPECT_NE(table.find("2.5 us"), std::string::npos) << table;
    EXPECT_NE(table.find("met\n"), std::string::npos) << table;
    EXPECT_NE(table.find("MISSED\n"), std::string::npos) << table;
}

void expect_cases_of(const std::vector<Target>& targets, std::vector<BenchCase> (&cases)(bool quick)) {
    std::set<std::string> full, quick;
    for (const BenchCase& c : cases(false)) full.insert(c.name);
    for (const BenchCase& c : cases(true)) quick.insert(c.name);
    for (const Target& t : targets) {
        std::size_t in_quick = 0;
        for (const std::string& name : t.cases) {
            EXPECT_TRUE(full.contains(name)) << t.what << ": " << name;
            in_quick += quick.count(name);
        }
        EXPECT_GT(in_quick, 0U) << t.what;
        EXPECT_TRUE(t.relative_to.empty() || quick.contains(t.relative_to)) << t.relative_to;
    }
}

TEST(Targets, NameExistingCases) {
    expect_cases_of(touch_targets(), touch_cases);
    expect_cases_of(surface_targets(), surface_cases);
}

TEST(Suites, NameNoCaseTwice) {
    for (const bool quick : {false, true})
        for (const auto& cases : {touch_cases(quick), loop_cases(quick), surface_cases(quick),
                                  gpu_cases(quick), target_cases(quick)}) {
            std::set<std::string> names;
            for (const BenchCase& c : cases) EXPECT_TRUE(names.insert(c.name).second) << c.name;
            EXPECT_GT(names.size(), 8U);
        }
}

/// With so many more metrics, named 1000, 1001, ...
CaseFigures widened(CaseFigures c) {
    for (int n = 0; n < 31; ++n) c.figures.push_back({std::to_string(1000 + n), 0, ""});
    return c;
}

TEST(Report, ManyMetricsGetRows) {
    const std::string table =
        tables_of({widened({"one", {{"common_ms", 1, "ms"}, {"last", 3, ""}}}),
                   widened({"another", {{"common_ms", 2.5, "ms"}, {"between", 7, ""}, {"last", 4, ""}}})});
    EXPECT_EQ(table.substr(0, table.find("1000")),
              "                one  another\n"
              "common_ms (ms)    1      2.5\n"
              "between                    7\n"
              "last              3        4\n");
}

TEST(Report, SplitsTablesAfterTenCases) {
    std::vector<CaseFigures> cases;
    for (int n = 0; n < 12; ++n) cases.push_back(widened({"case" + std::to_string(n), {}}));
    cases.push_back({"narrow", {{"count", 5, ""}}});
    const std::string tables = tables_of(cases);
    EXPECT_NE(tables.find("case9\n"), std::string::npos) << tables;
    EXPECT_NE(tables.find("case11\n"), std::string::npos) << tables;
    EXPECT_NE(tables.find("\nnarrow      5\n"), std::string::npos) << tables;
}

TEST(Report, FewMetricsGetColumns) {
    std::vector<CaseFigures> cases;
    for (int n = 0; n < 20; ++n)
        cases.push_back({"case" + std::to_string(n), {{"time", static_cast<double>(n), "us"}}});
    cases.push_back({"other", {{"count", 5, ""}}});
    const std::string tables = tables_of(cases);
    EXPECT_NE(tables.find("        time\n"), std::string::npos) << tables;
    EXPECT_NE(tables.find("\ncase7      7\n"), std::string::npos) << tables;
    EXPECT_NE(tables.find("\n\n       count\nother      5\n"), std::string::npos) << tables;
}

TEST(Report, ShowsNamesAsValues) {
    const CaseFigures c{"machine", {{"cores", 2, ""}, named("gpu", "llvmpipe")}};
    EXPECT_EQ(tables_of({c}), "         cores       gpu\nmachine      2  llvmpipe\n");
    const test::TemporaryFolder folder;
    ASSERT_TRUE(write_report(folder / "r.json", "gpu", {c}));
    std::stringstream text;
    text << std::ifstream(folder / "r.json").rdbuf();
    EXPECT_NE(text.str().find(R"("metric":"gpu","value":"llvmpipe")"), std::string::npos) << text.str();
}

TEST(Report, TablesOmitPlotSeries) {
    CaseFigures c{"case", {{"shown", 5, ""}}};
    for (int n = 0; n < 100; ++n) c.figures.push_back({"curve_" + std::to_string(n), 1, "", false});
    EXPECT_EQ(tables_of({c}), "      shown\ncase      5\n");
}

}  // namespace
}  // namespace touchable
