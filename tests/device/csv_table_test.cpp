#include "device/hand.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tests/device/temporary_file.hpp"
#include "tests/limited_memory.hpp"

namespace touchable {
namespace {

std::string table_refusal(const std::string& text, const std::string& column = "") {
    const TemporaryFile file("table.csv", text);
    const Result<CsvTable> table = CsvTable::read(file.path());
    Error error;
    if (!table) {
        error = table.error();
    } else {
        const Result<std::size_t> at = table->column(column);
        if (!at) {
            error = at.error();
        } else {
            const Result<std::vector<double>> numbers = table->numbers(*at);
            if (numbers) return "accepted";
            error = numbers.error();
        }
    }
    EXPECT_EQ(error.kind, ErrorKind::input);
    EXPECT_TRUE(error.message.starts_with(file.path() + ": ")) << error.message;
    return error.message.substr(file.path().size() + 2);
}

TEST(CsvTable, ReadsNamedColumns) {
    const TemporaryFile file("table.csv", "t,\"x, m\",note\n0,1.5,a\n0.5, -2e-3 ,b\n1,+7,\"c,d\"\n");
    const Result<CsvTable> table = CsvTable::read(file.path());
    ASSERT_TRUE(table) << table.error().message;
    EXPECT_EQ(table->rows(), 3u);
    EXPECT_EQ(table->columns(), 3u);
    EXPECT_TRUE(table->names("x, m"));
    EXPECT_FALSE(table->names("y"));
    EXPECT_EQ(*table->column("x, m"), 1u);
    EXPECT_EQ(*table->numbers(1), (std::vector<double>{1.5, -2e-3, 7}));
    EXPECT_FALSE(table->numbers(2));
}

TEST(CsvTable, WithoutAHeaderColumnsHaveNumbersFromOne) {
    const TemporaryFile file("table.csv", "1,2\n3,4\n");
    const Result<CsvTable> table = CsvTable::read(file.path());
    ASSERT_TRUE(table);
    EXPECT_EQ(table->rows(), 2u);
    EXPECT_EQ(*table->numbers(*table->column("2")), (std::vector<double>{2, 4}));
    EXPECT_FALSE(table->column("0"));
    EXPECT_FALSE(table->column("3"));
}

TEST(CsvTable, LineEndsByteOrderMarkAndLastLineDoNotMatter) {
    for (const std::string text :
         {"a,b\n1,2\n", "a,b\r\n1,2\r\n", "a,b\n1,2", "a,b\n1,2\n\n", "a,b\n1,2\n\n \r\n\t\n",
          "\xEF\xBB\xBF"
          "a,b\n1,2\n"}) {
        const TemporaryFile file("table.csv", text);
        const Result<CsvTable> table = CsvTable::read(file.path());
        ASSERT_TRUE(table) << text;
        EXPECT_EQ(table->rows(), 1u) << text;
        EXPECT_EQ(*table->column("a"), 0u) << text;
        EXPECT_EQ(*table->numbers(1), std::vector<double>{2}) << text;
    }
}

TEST(CsvTable, OtherSeparatorsAreRead) {
    for (const std::string text :
         {"t_s;x;note, such as this\n0;1;a,b\n0.5;-2;c\n", "t_s\tx\tnote\n0\t1\t\n0.5\t-2\tc d\n",
          "t_s x  note\n 0   1 a\n0.5\t-2 \"b c\" \n", "t_s, x, a;b\n0, 1, c;d\n0.5, -2, e\n"}) {
        const TemporaryFile file("table.csv", text);
        const Result<CsvTable> table = CsvTable::read(file.path());
        ASSERT_TRUE(table) << text << table.error().message;
        EXPECT_EQ(table->columns(), 3u) << text;
        EXPECT_EQ(*table->numbers(*table->column("t_s")), (std::vector<double>{0, 0.5})) << text;
        EXPECT_EQ(*table->numbers(*table->column("x")), (std::vector<double>{1, -2})) << text;
    }
    const TemporaryFile one("table.csv", "penetration depth\n0.1\n0.2\n");
    const Result<CsvTable> table = CsvTable::read(one.path());
    ASSERT_TRUE(table);
    EXPECT_EQ(*table->numbers(*table->column("penetration depth")), (std::vector<double>{0.1, 0.2}));
    EXPECT_EQ(table_refusal("t_s;x\n0;1,5\n", "x"),
              "line 2, column 'x' holds '1,5'; expected a finite number");
}

TEST(CsvTable, LargeFilesAreRefusedBeforeTheyAreRead) {
    const TemporaryFile file("table.csv", "t_s,x\n0,1\n");
    std::filesystem::resize_file(file.path(), std::uintmax_t{4} << 30);
    const test::LimitedMemory little(256);
    const Result<CsvTable> table = CsvTable::read(file.path());
    ASSERT_FALSE(table);
    EXPECT_NE(table.error().message.find("is larger than 256 MiB"), std::string::npos);
}

TEST(CsvTable, RowsAreCounted) {
    std::string text;
    for (int n = 0; n < 10'000'002; ++n) text += "1\n";
    EXPECT_EQ(table_refusal(text, "1"),
              "has more than 10000000 rows; give a recorded motion of at most an hour");
}

TEST(CsvTable, WhatIsQuotedIsShort) {
    const std::string wide(3'000'000, 'x');
    EXPECT_LT(table_refusal("a,b\n1,2\n3," + wide + "\n", "b").size(), 200u);
    EXPECT_LT(table_refusal("a," + wide + "\n1,2\n", "c").size(), 600u);
    EXPECT_LT(table_refusal("a," + wide + "\n1,\n", wide).size(), 200u);
}

TEST(CsvTable, RefusalNamesLineAndColumn) {
    EXPECT_EQ(table_refusal("a,b\n1,2\n3,x\n", "b"),
              "line 3, column 'b' holds 'x'; expected a finite number");
    EXPECT_EQ(table_refusal("a,b\n1,\n", "b"), "line 2, column 'b' holds nothing; expected a finite number");
    EXPECT_EQ(table_refusal("a,b\n1,nan\n", "b"), "line 2, column 'b' holds 'nan'; expected a finite number");
    EXPECT_EQ(table_refusal("1\n-inf\n", "1"), "line 2, column '1' holds '-inf'; expected a finite number");
    EXPECT_EQ(table_refusal("a,b\n1,1e999\n", "b"),
              "line 2, column 'b' holds '1e999'; expected a finite number");
    EXPECT_EQ(table_refusal("a,b\n1,2\n", "c"), "has no column 'c'; columns are 1 to 2, a, b");
    EXPECT_EQ(table_refusal("a,b\n1,2\n3\n"), "line 3 has 1 fields; the lines before have 2");
    EXPECT_EQ(table_refusal("a,b\n1,2\n\n3,4\n"), "line 3 has 1 fields; the lines before have 2");
    EXPECT_EQ(table_refusal(""), "has no row of data; expected numbers");
    EXPECT_EQ(table_refusal("a,b\n"), "has no row of data; expected numbers");
    EXPECT_EQ(table_refusal("a,\"b\n1,2\n"), "line 1: a quote is opened and not closed");
    EXPECT_EQ(table_refusal("a,\"b\"c\n1,2\n"), "line 1: text follows a closing quote; expected a comma");
    EXPECT_EQ(table_refusal(std::string("a,b\n1,\0\n", 8)),
              "line 2 holds bytes that are no text; give a comma-separated table");
}

TEST(CsvTable, AFieldMayBeEmptyWhereThatIsAsked) {
    const TemporaryFile file("table.csv", "a,b\n1,2\n,x\n3,4\n");
    const Result<CsvTable> table = CsvTable::read(file.path());
    ASSERT_TRUE(table) << table.error().message;
    const Result<std::vector<double>> given = table->numbers_where_given(0);
    ASSERT_TRUE(given) << given.error().message;
    ASSERT_EQ(given->size(), 3u);
    EXPECT_EQ((*given)[0], 1);
    EXPECT_TRUE(std::isnan((*given)[1]));
    EXPECT_EQ((*given)[2], 3);
    EXPECT_FALSE(table->numbers(0));
    const Result<std::vector<double>> letter = table->numbers_where_given(1);
    ASSERT_FALSE(letter);
    EXPECT_TRUE(letter.error().message.ends_with("line 3, column 'b' holds 'x'; expected a finite number"));
}

TEST(CsvTable, RefusesWhatIsNoFile) {
    EXPECT_FALSE(CsvTable::read(::testing::TempDir() + "there-is-no-such.csv"));
    EXPECT_FALSE(CsvTable::read(::testing::TempDir()));
}

}  // namespace
}  // namespace touchable
