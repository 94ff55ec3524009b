// SPDX-License-Identifier: Apache-2.0
// What records of measurements tell: targets, tables, and the page of `./run bench`.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "bench/gpu/gpu_cases.hpp"
#include "bench/report.hpp"
#include "bench/suite.hpp"
#include "bench/targets.hpp"
#include "engine/base/hand_thresholds.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "tests/temporary_files.hpp"

namespace touchable {
namespace {

std::string text_of(const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

bool says(const std::string& text, const std::string& words) {
    return text.find(words) != std::string::npos;
}

struct Answer {
    int code = -1;
    std::string text;
};

Answer answer_to(const std::string& command) {
    Answer answer;
    FILE* const program = popen((command + " 2>&1").c_str(), "r");
    std::array<char, 4096> some;
    while (std::fgets(some.data(), some.size(), program)) answer.text += some.data();
    answer.code = WEXITSTATUS(pclose(program));
    return answer;
}

bool has_matplotlib() {
    return answer_to("/usr/bin/python3 -c 'import matplotlib'").code == 0;
}

Answer plot(const std::string& words) {
    return answer_to("/usr/bin/python3 " TOUCHABLE_SOURCE_DIR "/bench/plot.py " + words);
}

/// The page of one suite's records; `old`: to compare with, if any.
std::string page_of(const test::TemporaryFolder& folder, const char* suite,
                    const std::vector<CaseFigures>& records, const std::vector<CaseFigures>& old = {}) {
    const std::string now = folder / "now.json", before = folder / "before.json", page = folder / "page.html";
    EXPECT_TRUE(write_report(now, suite, records));
    EXPECT_TRUE(old.empty() || write_report(before, suite, old));
    const Answer answer = plot("report " + now + " " + page + (old.empty() ? "" : " --compare " + before));
    EXPECT_EQ(answer.code, 0) << answer.text;
    EXPECT_EQ(answer.text, "");
    return text_of(page);
}

Result<void> measure(const std::string& name, Figures& figures) {
    for (const BenchCase& c : gpu_cases(true))
        if (c.name == name) return c.measure(figures);
    return usage_error("no case " + name);
}

TEST(GpuSuite, MeasuresAndPlotsTinyCase) {
    if (!GpuDevice::open()) GTEST_SKIP() << "no Vulkan";
    Figures frames, fingers;
    const auto by_frame = measure("ways-320x240-m3", frames),
               by_finger = measure("ways-320x240-m3-1f", fingers);
    ASSERT_TRUE(by_frame) << by_frame.error().message;
    ASSERT_TRUE(by_finger) << by_finger.error().message;
    const auto value = [&](const std::string& metric) {
        for (const Figures& figures : {frames, fingers})
            for (const Figure& figure : figures)
                if (figure.metric == metric) return figure.value;
        return std::nan("");
    };
    EXPECT_EQ(value("lazy_possible"), 1);
    EXPECT_GT(value("cpu_ms_per_s_60hz"), value("cpu_ms_per_s_30hz"));
    EXPECT_GT(value("lazy_tick_us"), 0);

    if (!has_matplotlib()) GTEST_SKIP() << "no matplotlib: the page is not made";
    const test::TemporaryFolder folder;
    const CaseFigures machine{"machine",
                              {named("gpu", "RTX <1>"), named("gpu_driver", "N"), named("vulkan", "1.3")}};
    const std::string page =
        page_of(folder, "gpu", {machine, {"ways-320x240-m3", frames}, {"ways-320x240-m3-1f", fingers}});
    EXPECT_PRED2(says, page, "<svg");
    EXPECT_PRED2(says, page, "GPU: RTX &lt;1&gt;</h2>");
    EXPECT_PRED2(says, page, "Force error on a moving surface");
    EXPECT_FALSE(says(page, "Jitter")) << "it was not measured";
}

Target target(Limit::Sense sense, double value = 0) {
    return {"a time", {"here", "there"}, "us", {value, sense, "us"}};
}

std::vector<CaseFigures> measured(double here, double there) {
    return {{"here", {{"other", 1000, ""}, {"us", here, "us"}}}, {"there", {{"us", there, "us"}}}};
}

constexpr auto below = Limit::Sense::below, at_most = Limit::Sense::at_most,
               at_least = Limit::Sense::at_least, no_limit = Limit::Sense::none;

TEST(Targets, AreJudgedByWorstCase) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const struct {
        Target target;
        std::vector<CaseFigures> figures;
        bool met;
        double value;  // nan: of no matter
    } cases[] = {{target(below, 3), measured(1, 2.5), true, 2.5},
                 {target(below, 3), measured(3.5, 1), false, 3.5},
                 {target(below, 3), measured(3, 1), false, 3},
                 {target(at_most, 3), measured(3, 1), true, 3},
                 {target(at_most, 0), measured(0, 1e-12), false, 1e-12},
                 {target(at_least, 2), measured(5, 2), true, 2},
                 {target(at_least, 2), measured(5, 1.9), false, 1.9},
                 {target(at_least, 2), measured(nan, 5), false, nan},
                 {target(at_least, 2), {}, false, nan},
                 {target(no_limit), measured(4, 5), true, 5},
                 {target(no_limit), {}, false, nan},
                 {target(below, 3), {}, false, nan},
                 {target(below, 3), {{"elsewhere", {{"us", 1, "us"}}}}, false, nan},
                 {target(below, 3), measured(nan, 1), false, nan},
                 {target(below, 3), measured(1, nan), false, nan}};
    for (const auto& one : cases) {
        const Verdict verdict = judge(one.target, one.figures);
        EXPECT_EQ(verdict.met, one.met) << &one - cases;
        EXPECT_TRUE(std::isnan(one.value) || verdict.value == one.value) << &one - cases << verdict.value;
    }
    EXPECT_EQ(judge(target(below, 3), measured(1, 2.5)).cases, 2U);
}

TEST(Targets, SkipWhereNotApplicable) {
    Target t = target(below, 3);
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
    const std::vector<Target> left =
        measured_targets({target(below, 3), {"elsewhere", {"nowhere"}, "us", t.limit}}, {{"there", {}}});
    ASSERT_EQ(left.size(), 1U);
    EXPECT_EQ(left[0].what, "a time");
}

TEST(Targets, MayBeRelative) {
    Target t = target(at_most, 1);
    t.cases = {"there"};
    t.relative_to = "here";
    EXPECT_EQ(judge(t, measured(4, 3)).value, 0.75);
    EXPECT_TRUE(judge(t, measured(4, 3)).met);
    EXPECT_FALSE(judge(t, measured(4, 5)).met);
    t.relative_to = "nowhere";
    EXPECT_FALSE(judge(t, measured(4, 3)).met);
}

TEST(Targets, TableShowsVerdicts) {
    const std::string table = table_of({target(below, 3), target(below, 2)}, measured(2.5, 1));
    for (const char* words : {"< 3 us", "2.5 us", "met\n", "MISSED\n"})
        EXPECT_NE(table.find(words), std::string::npos) << table;
    EXPECT_EQ(table_of({target(no_limit)}, measured(4, 5)).find("met\n"), std::string::npos);
}

TEST(Targets, RecordsNameParentAndWorstCase) {
    std::vector<Target> targets{target(below, 3), target(at_least, 2), target(below, 2), target(below, 3)};
    targets[1].cases = targets[2].cases = {"nowhere"};
    targets[2].what = "unmeasured";
    targets[3].what = "  on a GPU";
    const std::vector<CaseFigures> records = records_of(targets, measured(1, 3.5));
    ASSERT_EQ(records.size(), 2U) << "two were not measured";
    EXPECT_EQ(records[0].name, "target: a time");
    EXPECT_EQ(records[1].name, "target: unmeasured: on a GPU");
    std::map<std::string, std::string> words;
    for (const Figure& figure : records[0].figures) words[figure.metric] = figure.name.value_or("");
    EXPECT_EQ(words["verdict"], "MISSED");
    EXPECT_EQ(words["limit"], "< 3 us");
    EXPECT_EQ(words["worst_case"], "there");
    EXPECT_EQ(words["metric"], "us");
    EXPECT_EQ(records[0].figures[0].metric, "worst");
    EXPECT_EQ(records[0].figures[0].value, 3.5);
    EXPECT_EQ(records[0].figures[0].unit, "us");
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

/// Barbagli et al. 2006; Pang, Tan and Durlach 1991.
TEST(HandThresholds, MatchTheirSources) {
    EXPECT_DOUBLE_EQ(direction_jnd(18.4), 1);
    EXPECT_NEAR(direction_jnd(1.74), 0.09, 0.005) << "the globe";
    EXPECT_NEAR(direction_jnd(49), 2.7, 0.05) << "the paper's method";
    EXPECT_EQ(hand_thresholds::felt_degrees, 25.6);
    EXPECT_EQ(direction_jnd_words(9.2), "0.5 of what a hand just notices where it sees the scene");
    EXPECT_DOUBLE_EQ(just_noticed_newtons(2.5).value_or(0), 0.175);
    EXPECT_DOUBLE_EQ(just_noticed_newtons(10).value_or(0), 0.7);
    EXPECT_FALSE(just_noticed_newtons(2.4) || just_noticed_newtons(10.1));
}

TEST(Report, AddsJndBesideDirections) {
    Figures figures{{"tick_us_mean", 1, "us"},
                    {"force_angle_deg_rms", 9.2, "deg"},
                    {"force_angle_deg_rms_0_15", 36.8, "deg"},
                    {"plane_error_deg", 1, "deg"}};
    add_jnd(figures);
    ASSERT_EQ(figures.size(), 6U);
    EXPECT_EQ(figures[2].metric, "force_angle_jnd_rms");
    EXPECT_DOUBLE_EQ(figures[2].value, 0.5);
    EXPECT_EQ(figures[2].unit, "JND");
    EXPECT_EQ(figures[4].metric, "force_angle_jnd_rms_0_15");
    EXPECT_DOUBLE_EQ(figures[4].value, 2);
    EXPECT_EQ(figures[5].metric, "plane_error_deg") << "is no error of a force";
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
    std::vector<CaseFigures> cases;
    for (int n = 0; n < 12; ++n) cases.push_back(widened({"case" + std::to_string(n), {}}));
    const std::string tables = tables_of(cases);
    for (const char* end : {"case9\n", "case11\n"}) EXPECT_NE(tables.find(end), std::string::npos) << tables;
}

TEST(Report, ShowsNamesAsValues) {
    const CaseFigures c{"machine", {{"cores", 2, ""}, named("gpu", "llvmpipe")}};
    CaseFigures plotted = c;
    plotted.figures.push_back({"curve", 1, "", false});
    EXPECT_EQ(tables_of({plotted}), "         cores       gpu\nmachine      2  llvmpipe\n");
    const test::TemporaryFolder folder;
    ASSERT_TRUE(write_report(folder / "r.json", "gpu", {c}));
    std::stringstream text;
    text << std::ifstream(folder / "r.json").rdbuf();
    EXPECT_NE(text.str().find(R"("metric":"gpu","value":"llvmpipe")"), std::string::npos) << text.str();
}

/// The part of a page from a heading to the next one.
std::string part_of(const std::string& page, const std::string& heading) {
    const std::size_t begin = page.find(">" + heading);
    if (begin == std::string::npos) return "";
    return page.substr(begin, page.find("<h", begin) - begin);
}

TEST(Page, TellsWhatGotWorse) {
    if (!has_matplotlib()) GTEST_SKIP();
    const auto records = [](double mean, double p99, double roots, double angle, double lost, double rate,
                            double odd, const char* hash) {
        return std::vector<CaseFigures>{
            {"machine", {{"quick", 1, ""}}},
            {"rough-1f",
             {{"tick_us_mean", mean, "us"},
              {"tick_us_p99", p99, "us"},
              {"tick_roots", roots, ""},
              {"force_angle_deg_rms", angle, "deg"},
              {"contact_lost_ticks", lost, ""},
              {"frames_per_s", rate, ""},
              {"odd_share", odd, ""},
              {"strange", odd, ""},
              named("force_hash", hash)}},
            {"target: odd", {named("metric", "odd_share"), named("limit", ">= 2"), named("verdict", "met")}}};
    };
    const auto old = records(1, 10, 50, 2, 0, 30, 3, "aa");
    const test::TemporaryFolder folder;
    const std::string page = page_of(folder, "touch", records(1.2, 19, 52, 1.9, 3, 20, 2.5, "bb"), old);
    const std::string worse = part_of(page, "Worse: 4 figures"), better = part_of(page, "Better: 1 figure<"),
                      changed = part_of(page, "Changed, neither better nor worse: 2 figures");
    for (const char* metric : {"tick_us_mean", "contact_lost_ticks", "frames_per_s", "odd_share"})
        EXPECT_PRED2(says, worse, metric);
    EXPECT_PRED2(says, worse, "<td class=n>1 µs</td><td class=n>1.20 µs</td><td class=n>1.20</td>");
    EXPECT_PRED2(says, worse, "<code>touchable-bench touch --quick --filter rough-1f</code>");
    EXPECT_PRED2(says, better, "force_angle_deg_rms");
    EXPECT_PRED2(says, changed, "force_hash");
    EXPECT_PRED2(says, changed, "strange") << "no target, name or unit tells what is better";
    EXPECT_FALSE(says(worse + better + changed, "tick_us_p99")) << "less than twice as long";
    EXPECT_FALSE(says(worse + better + changed, "tick_roots")) << "4 %";

    const std::string same = page_of(folder, "touch", old, old);
    for (const char* heading : {"Worse: 0", "Better: 0", "Changed, neither better nor worse: 0"})
        EXPECT_PRED2(says, part_of(same, heading), "Nothing.");
    EXPECT_FALSE(says(same, "Not the same"));
    auto elsewhere = old;
    elsewhere[0].figures.push_back(named("cpu", "another"));
    EXPECT_PRED2(says, page_of(folder, "touch", elsewhere, old), "Not the same processor");
    EXPECT_FALSE(says(page_of(folder, "touch", old), "got worse")) << "there is nothing to compare with";
}

TEST(Page, TellsBestTargetsAndTableOne) {
    if (!has_matplotlib()) GTEST_SKIP();
    const test::TemporaryFolder folder;
    const auto globe = [](const char* name, double time, double angle) {
        return CaseFigures{std::string("globe-720x480-") + name,
                           {{"tick_us_mean", time, "us"}, {"force_angle_deg_rms", angle, "deg"}}};
    };
    const CaseFigures hand{"hand",
                           {{"direction_seen_deg", 18.4, "deg"}, {"direction_felt_deg", 25.6, "deg"}}};
    const std::string best = page_of(folder, "touch",
                                     {hand,
                                      globe("8-1f-pixel", 1, 60),
                                      globe("16-1f-world", 3, 2),
                                      globe("exact-1f-world", 4, 1),
                                      {"target: a tick",
                                       {{"worst", 3, "us"},
                                        named("worst_case", "globe-720x480-16-1f-world"),
                                        named("metric", "tick_us_mean"),
                                        named("limit", "< 2 us"),
                                        named("verdict", "MISSED")}}});
    EXPECT_PRED2(says, part_of(best, "Time of a tick of one finger"),
                 "<td>16-world</td><td class=n>3 µs</td><td>exact-world</td><td class=n>4 µs</td>")
        << "the fastest is so wrong that a hand notices";
    EXPECT_PRED2(says, part_of(best, "Error of the force"), "<td>exact-world</td><td class=n>1°</td>");
    EXPECT_PRED2(says, part_of(best, "Missed"),
                 "<td>a tick</td><td class=n>&lt; 2 µs</td><td class=n>3 µs</td>");
    EXPECT_PRED2(says, part_of(best, "Run time against error</h2>"), "<svg");

    std::vector<CaseFigures> sweeps;
    for (const char* size : {"720x480", "3840x2160"})
        for (const char* fingers : {"1", "5"})
            sweeps.push_back({std::string("globe-") + size + "-8-" + fingers + "f-pixel-m3-lazy-circle",
                              {{"tick_us_mean", 2.5 * std::stod(fingers), "us"},
                               {"papers_tick_us", 253.4 * std::stod(fingers), "us"}}});
    const std::string table = part_of(page_of(folder, "paper", sweeps), "The paper's method");
    EXPECT_PRED2(says, table, "<td>720x480 in the paper</td><td class=n>253</td><td class=n>1,267</td>");
    EXPECT_PRED2(says, table, "<td>3840x2160</td><td class=n>2.50 (none)</td><td class=n>12.5 (none)</td>");
}

TEST(Page, EscapesNamesAndLoadsNothing) {
    if (!has_matplotlib()) GTEST_SKIP();
    const test::TemporaryFolder folder;
    const std::string script = "<script src=https://x.y/z.js></script>";
    const std::vector<CaseFigures> records{
        {"machine", {named("gpu", script), named("commit", script), {script, 1, "<i>"}}},
        {script, {{"tick_us_mean", 1, "us"}, {script, 2, "<i>"}}},
        {"globe-720x480-8-1f-pixel", {{"tick_us_mean", 1, "us"}, {"force_angle_deg_rms", 60, "deg"}}},
        {"target: " + script, {named("metric", script), named("limit", script), named("verdict", script)}}};
    auto old = records;
    old[1].figures = {{"tick_us_mean", 3, "us"}, {script, 5, "<i>"}};
    std::string page = page_of(folder, "touch", records, old);
    EXPECT_PRED2(says, page, "&lt;script src=https://x.y/z.js&gt;");
    for (const char* loaded : {"<script", "<link", "<img", "<iframe", "@import", "<i>"})
        EXPECT_FALSE(says(page, loaded)) << loaded;
    // What is left of addresses names the language of a drawing, and is never loaded, or is a word that is
    // shown.
    page = std::regex_replace(page, std::regex(" xmlns(:xlink)?=\"http://www.w3.org/[^\"]*\""), "");
    page = std::regex_replace(page, std::regex("&lt;script src=https:"), "");
    for (const char* address : {"http:", "https:"}) EXPECT_FALSE(says(page, address)) << address;
}

TEST(Page, RefusesForeignRecords) {
    if (!has_matplotlib()) GTEST_SKIP();
    const test::TemporaryFolder folder;
    const std::string json = folder / "x.json", page = folder / "page.html";
    const std::string row = R"({"suite":"touch","case":"a","metric":"b","unit":"us","value":)";
    const std::string foreign[] = {"",
                                   "{}",
                                   "[7]",
                                   R"([{"suite":"touch","case":"a"}])",
                                   R"([{"suite":"touch","case":["a"],"metric":"b","unit":"us","value":1}])",
                                   "[" + row + "[1]}]",
                                   "[" + row + "1" + std::string(400, '0') + "}]",
                                   "\xff\xfe",
                                   std::string(100'000, '[')};
    for (const std::string& text : foreign) {
        std::ofstream(json) << text;
        const Answer answer = plot("report " + json + " " + page);
        EXPECT_EQ(answer.code, 3) << text.substr(0, 80);
        EXPECT_EQ(std::ranges::count(answer.text, '\n'), 1) << answer.text;
        EXPECT_PRED2(says, answer.text, "plot.py: " + json + ": ");
    }
    std::ofstream(json) << "[" << row << "1}]";
    const std::string nowhere = folder / "nowhere", is_there = folder.path().string();
    for (const std::string& words :
         {"report " + nowhere + " " + page, "report " + json + " " + page + " --compare " + nowhere,
          "report " + json + " " + nowhere + "/page.html", "pareto " + json + " " + page}) {
        const Answer answer = plot(words);
        EXPECT_EQ(answer.code, 3) << words;
        EXPECT_EQ(std::ranges::count(answer.text, '\n'), 1) << answer.text;
    }
    EXPECT_EQ(plot("report " + json + " " + is_there).text,
              "plot.py: " + is_there + ": is no file; must be a file, or a new name\n");
    EXPECT_FALSE(std::filesystem::exists(page));
    EXPECT_EQ(plot("count " + is_there).text, is_there + ": 1 figures of touch\n");
}

TEST(Page, OutlivesOtherVersionsRecords) {
    if (!has_matplotlib()) GTEST_SKIP();
    const test::TemporaryFolder folder;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<CaseFigures> records{
        {"window-1920x1080-raster", {{"painter_of_later", 1, "ms"}}},
        {"pictures-1920x1080", {named("raster_cpu_ms", "a word"), {"raster_cpu_frame_ms", nan, "ms"}}},
        {"ways-320x240-m3", {{"lazy_frame_ms", nan, "ms"}}},
        {"ways-320x240-m3-1f",
         {{"lazy_ms_per_s_30hz", 1, "ms"},
          {"lazy_tick_us", nan, "us"},
          {"late_ticks_pct", 0.4, "%"},
          {"frames_in_time_pct", 80, "%"}}}};
    auto old = records;
    old[3].figures = {{"lazy_ms_per_s_30hz", nan, "ms"},
                      {"lazy_tick_us", 1, "us"},
                      {"late_ticks_pct", 0, "%"},
                      {"frames_in_time_pct", 99, "%"}};
    const std::string page = page_of(folder, "gpu", records, old);
    EXPECT_PRED2(says, page, "Not drawn; these records do not fit");
    const std::string worse = part_of(page, "Worse: 2 figures");
    EXPECT_PRED2(says, worse, "<td class=n>1 µs</td><td class=n>none</td>");
    EXPECT_PRED2(says, worse, "frames_in_time_pct") << "so much is more than threads and load do";
    EXPECT_FALSE(says(worse, "late_ticks_pct"));
    EXPECT_PRED2(says, part_of(page, "Better: 1 figure"), "<td class=n>none</td><td class=n>1 ms</td>");
}

TEST(RunBench, RefusesOptionsBeforeMeasuring) {
    const test::TemporaryFolder folder;
    const std::string there = folder.path().string();
    const std::pair<std::string, std::string> faults[] = {
        {"--compre x", "unknown option '--compre'; there is only --compare OLD"},
        {"x", "unknown option 'x'; there is only --compare OLD"},
        {"--compare", "--compare needs one file or folder of earlier records: --compare OLD"},
        {"--compare a b", "--compare needs one file or folder of earlier records: --compare OLD"},
        {"--compare " + there + "/no",
         "--compare '" + there + "/no' cannot be read; must be a file of records or a folder of such files"},
    };
    for (const auto& [words, fault] : faults) {
        const Answer answer = answer_to(TOUCHABLE_SOURCE_DIR "/run bench " + words);
        EXPECT_EQ(answer.code, 2) << words;
        EXPECT_EQ(answer.text, "run bench: " + fault + "\n");
    }
}

}  // namespace
}  // namespace touchable
