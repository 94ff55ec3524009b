// Recordings are looked for by one function, so that one word in the environment takes all of them away.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

TEST(RealData, IsFoundByRealDataAlone) {
    int files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(TOUCHABLE_SOURCE_DIR) / "tests")) {
        const fs::path& file = entry.path();
        if (file.extension() != ".cpp" && file.extension() != ".hpp") continue;
        if (file.filename() == "real_data.hpp" || file.filename() == "real_data_test.cpp") continue;
        std::ifstream in(file);
        const std::string text{std::istreambuf_iterator<char>(in), {}};
        ++files;
        for (const char* way : {"TOUCHABLE_TEST_DATA", "shared/data"})
            EXPECT_EQ(text.find(way), std::string::npos)
                << file << " finds recordings by " << way << ", not by real_data()";
    }
    EXPECT_GT(files, 300) << "hardly anything was looked at";
}

}  // namespace
}  // namespace touchable::test
