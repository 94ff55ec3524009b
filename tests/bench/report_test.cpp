#include "bench/report.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "tests/temporary_folder.hpp"

namespace touchable {
namespace {

/// With so many more metrics, named 1000, 1001, ...
CaseFigures widened(CaseFigures c) {
    for (int n = 0; n < 31; ++n) c.figures.push_back({std::to_string(1000 + n), 0, ""});
    return c;
}

TEST(Report, OfManyMetricsHasARowForEachAndAColumnPerCase) {
    const std::string table =
        tables_of({widened({"one", {{"common_ms", 1, "ms"}, {"last", 3, ""}}}),
                   widened({"another", {{"common_ms", 2.5, "ms"}, {"between", 7, ""}, {"last", 4, ""}}})});
    EXPECT_EQ(table.substr(0, table.find("1000")),
              "                one  another\n"
              "common_ms (ms)    1      2.5\n"
              "between                    7\n"
              "last              3        4\n");
}

TEST(Report, OfManyMetricsHasATableForEachTenCases) {
    std::vector<CaseFigures> cases;
    for (int n = 0; n < 12; ++n) cases.push_back(widened({"case" + std::to_string(n), {}}));
    cases.push_back({"narrow", {{"count", 5, ""}}});
    const std::string tables = tables_of(cases);
    EXPECT_NE(tables.find("case9\n"), std::string::npos) << tables;
    EXPECT_NE(tables.find("case11\n"), std::string::npos) << tables;
    EXPECT_NE(tables.find("\nnarrow      5\n"), std::string::npos) << tables;
}

TEST(Report, OfFewMetricsHasARowPerCase) {
    std::vector<CaseFigures> cases;
    for (int n = 0; n < 20; ++n)
        cases.push_back({"case" + std::to_string(n), {{"time", static_cast<double>(n), "us"}}});
    cases.push_back({"other", {{"count", 5, ""}}});
    const std::string tables = tables_of(cases);
    EXPECT_NE(tables.find("        time\n"), std::string::npos) << tables;
    EXPECT_NE(tables.find("\ncase7      7\n"), std::string::npos) << tables;
    EXPECT_NE(tables.find("\n\n       count\nother      5\n"), std::string::npos) << tables;
}

TEST(Report, HasNamesInPlaceOfValues) {
    const CaseFigures c{"machine", {{"cores", 2, ""}, named("gpu", "llvmpipe")}};
    EXPECT_EQ(tables_of({c}), "         cores       gpu\nmachine      2  llvmpipe\n");
    const test::TemporaryFolder folder;
    ASSERT_TRUE(write_report(folder / "r.json", "gpu", {c}));
    std::stringstream text;
    text << std::ifstream(folder / "r.json").rdbuf();
    EXPECT_NE(text.str().find(R"("metric":"gpu","value":"llvmpipe")"), std::string::npos) << text.str();
}

TEST(Report, TablesLeaveOutWhatIsForPlots) {
    CaseFigures c{"case", {{"shown", 5, ""}}};
    for (int n = 0; n < 100; ++n) c.figures.push_back({"curve_" + std::to_string(n), 1, "", false});
    EXPECT_EQ(tables_of({c}), "      shown\ncase      5\n");
}

}  // namespace
}  // namespace touchable
