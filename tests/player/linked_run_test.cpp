// The room of a run links into any program (touch_a_clip.cpp), which feels what `touchable touch` does.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(LinkedRun, GivesTheForcesOfTheProgram) {
    const TemporaryFolder folder;
    const auto clip = folder / "clip.mkv", report = folder / "report.json", hash = folder / "hash";
    ASSERT_EQ(run_touchable({"make", "bumps", clip, "--frames", "2"}).code, 0);
    ASSERT_EQ(run_touchable({"touch", clip, "--hand", "press", "--builder", "cpu", "--json", report}).code,
              0);
    const std::string command =
        std::string("'" TOUCHABLE_LINKED_RUN "' '") + clip.string() + "' > '" + hash.string() + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
    EXPECT_EQ(text_of(hash),
              nlohmann::json::parse(text_of(report)).at("force_hash").get<std::string>() + "\n");
}

// A library that a program needs is named in it.
TEST(LinkedRun, NeedsNoWindowAndNoVulkan) {
    const std::string program = text_of(TOUCHABLE_LINKED_RUN);
    ASSERT_NE(program.find("libavformat.so"), std::string::npos);
    for (const char* library :
         {"libvulkan.so", "libglfw.so", "libX11.so", "libasound.so", "libcairo.so", "libusb"})
        EXPECT_EQ(program.find(library), std::string::npos) << library;
}

}  // namespace
}  // namespace touchable::test
