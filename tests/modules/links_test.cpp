// Pages refer to each other by links: each leads to a file that is there, and to a heading of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> pages() {
    std::vector<fs::path> found;
    const fs::path root = TOUCHABLE_SOURCE_DIR;
    for (const char* folder : {"docs", "bench", "shaders", "examples", "python", "capi", "tests"})
        for (const auto& entry : fs::recursive_directory_iterator(root / folder))
            if (entry.path().extension() == ".md") found.push_back(entry.path());
    for (const auto& entry : fs::directory_iterator(root))
        if (entry.path().extension() == ".md") found.push_back(entry.path());
    return found;
}

/// Lines of a page outside its blocks of code.
std::vector<std::string> lines_of(const fs::path& page) {
    std::ifstream in(page);
    std::vector<std::string> lines;
    bool is_code = false;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("```")) is_code = !is_code;
        if (!is_code && !line.starts_with("    ")) lines.push_back(line);
    }
    return lines;
}

/// What a link to a heading is called, as GitHub does it: small letters, strokes for spaces, no signs.
std::string anchor_of(const std::string& heading) {
    std::string anchor;
    for (const char letter : heading) {
        const auto byte = static_cast<unsigned char>(letter);
        if (std::isalnum(byte) || letter == '-' || letter == '_' || byte >= 0x80)
            anchor += static_cast<char>(std::tolower(byte));
        if (letter == ' ') anchor += '-';
    }
    return anchor;
}

std::set<std::string> anchors_of(const fs::path& page) {
    static const std::regex link(R"(\[([^\]]*)\]\([^)]*\))");
    std::set<std::string> anchors;
    for (const std::string& line : lines_of(page)) {
        if (!line.starts_with('#')) continue;
        const std::string heading = line.substr(line.find_first_not_of("# "));
        anchors.insert(anchor_of(std::regex_replace(heading, link, "$1")));
    }
    return anchors;
}

TEST(Links, LeadToPagesAndHeadingsThatAreThere) {
    static const std::regex link(R"(\]\(([^)\s]+)\))");
    int checked = 0;
    for (const fs::path& page : pages())
        for (const std::string& line : lines_of(page))
            for (std::sregex_iterator at(line.begin(), line.end(), link), end; at != end; ++at) {
                const std::string to = (*at)[1];
                if (to.find("://") != std::string::npos || to.starts_with("mailto:")) continue;
                const std::size_t sharp = std::min(to.find('#'), to.size());
                const fs::path file = sharp == 0 ? page : page.parent_path() / to.substr(0, sharp);
                ++checked;
                if (!fs::exists(file)) {
                    ADD_FAILURE() << page << ": " << to << " is not there";
                    continue;
                }
                const bool names_heading = sharp < to.size() && file.extension() == ".md";
                EXPECT_TRUE(!names_heading || anchors_of(file).contains(to.substr(sharp + 1)))
                    << page << ": " << to << " is no heading there";
            }
    EXPECT_GT(checked, 300);
}

}  // namespace
}  // namespace touchable::test
