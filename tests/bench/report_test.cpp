#include "bench/report.hpp"

#include <gtest/gtest.h>

#include <string>

namespace touchable {
namespace {

TEST(Report, OfFewCasesHasARowPerMetricAndAColumnPerCase) {
    const std::string table =
        tables_of({{"one", {{"common_ms", 1, "ms"}, {"last", 3, ""}}},
                   {"another", {{"common_ms", 2.5, "ms"}, {"between", 7, ""}, {"last", 4, ""}}}});
    EXPECT_EQ(table,
              "                one  another\n"
              "common_ms (ms)    1      2.5\n"
              "between                    7\n"
              "last              3        4\n");
}

TEST(Report, OfManyCasesHasARowPerCase) {
    std::vector<CaseFigures> cases;
    for (int n = 0; n < 20; ++n)
        cases.push_back({"case" + std::to_string(n), {{"time", static_cast<double>(n), "us"}}});
    cases.push_back({"other", {{"count", 5, ""}}});
    const std::string tables = tables_of(cases);
    EXPECT_NE(tables.find("        time\n"), std::string::npos) << tables;
    EXPECT_NE(tables.find("\ncase7      7\n"), std::string::npos) << tables;
    EXPECT_NE(tables.find("\n\n       count\nother      5\n"), std::string::npos) << tables;
}

}  // namespace
}  // namespace touchable
