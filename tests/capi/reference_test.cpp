// touchable.h describes every public name: what it is, in which unit, and which statuses it gives. (Doxygen,
// where it is there, refuses a name without a description; what a description has to say is looked at here.)
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

namespace touchable::test {
namespace {

std::string header() {
    std::ifstream in(std::string(TOUCHABLE_SOURCE_DIR) + "/capi/touchable.h");
    return {std::istreambuf_iterator<char>(in), {}};
}

/// A declaration, and the comment that describes it.
struct Described {
    std::string name, declaration, comment;
};

std::vector<Described> functions_of(const std::string& text) {
    std::vector<Described> functions;
    static const std::regex function(R"(TOUCH_API [^;]*?(touch_\w+)\([^;]*\);)");
    for (auto at = std::sregex_iterator(text.begin(), text.end(), function); at != std::sregex_iterator();
         ++at) {
        const auto begin = static_cast<std::size_t>(at->position());
        const bool has_comment = text.compare(begin - 3, 3, "*/\n") == 0;
        const auto open = text.rfind("/**", begin);
        functions.push_back({(*at)[1], at->str(), has_comment ? text.substr(open, begin - open) : ""});
    }
    return functions;
}

std::vector<Described> members_of(const std::string& text) {
    std::vector<Described> members;
    static const std::regex member(R"(\n    [\w ]+[ *](\w+)(?:\[\d+\])?; */\*\*<([^*]*(?:\*[^/][^*]*)*)\*/)");
    for (auto at = std::sregex_iterator(text.begin(), text.end(), member); at != std::sregex_iterator(); ++at)
        members.push_back({(*at)[1], at->str(), (*at)[2]});
    return members;
}

bool says(const std::string& text, const std::string& pattern) {
    return std::regex_search(text, std::regex(pattern));
}

TEST(Reference, EveryFunctionIsDescribedWithItsStatuses) {
    const auto functions = functions_of(header());
    EXPECT_GT(functions.size(), 40u);
    for (const Described& function : functions) {
        EXPECT_FALSE(function.comment.empty()) << function.name << " has no comment of its own";
        if (says(function.declaration, "touch_error \\*")) {
            EXPECT_TRUE(says(function.comment, "TOUCH_(USAGE|INPUT|BUSY|FULL|END|INTERRUPTED)"))
                << function.name << ": its comment names no status";
        }
    }
}

/// Numbers that stand for a length, a time, a force: in the name, or in the comment.
TEST(Reference, EveryNumberHasItsUnit) {
    const std::string unit =
        "_px|_m$|_ns|_per_|_units|_code|_degrees|_bytes|_ticks|_n$|pixels|metres|scene "
        "units|newtons|coefficient|"
        "milliseconds|frames|right|up|camera|likewise|number|how many";
    const auto members = members_of(header());
    EXPECT_GT(members.size(), 90u);
    for (const Described& member : members)
        if (says(member.declaration, "\\b(double|int64_t)\\b")) {
            EXPECT_TRUE(says(member.name, unit) || says(member.comment, unit)) << member.declaration;
        }
}

TEST(Reference, WhatIsRealTimeSaysSo) {
    for (const Described& function : functions_of(header()))
        if (says(function.name, "solver_(tick|run|come_back|force_hash)|newest_ns|describe|touch_version")) {
            EXPECT_TRUE(says(function.comment, "Real-time") || says(function.name, "clip_describe"))
                << function.name;
        }
}

}  // namespace
}  // namespace touchable::test
