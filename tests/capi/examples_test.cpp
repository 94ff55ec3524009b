// The programs of examples/, as somebody who follows docs/library.md runs them.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "capi/touchable.hpp"
#include "tests/capi/hill.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

struct Ran {
    int code = -1;
    std::string out;  ///< and what it said of errors
};

Ran run_example(const std::string& words) {
    Ran ran;
    FILE* const pipe = popen((std::string(TOUCHABLE_EXAMPLES) + "/example_" + words + " 2>&1").c_str(), "r");
    if (!pipe) return ran;
    char part[256];
    while (const std::size_t bytes = std::fread(part, 1, sizeof part, pipe)) ran.out.append(part, bytes);
    const int status = pclose(pipe);
    ran.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return ran;
}

TEST(Examples, TouchHillFeelsTheHill) {
    const Ran ran = run_example("touch_hill");
    EXPECT_EQ(ran.code, 0) << ran.out;
    EXPECT_NE(ran.out.find("touching"), std::string::npos) << ran.out;
}

TEST(Examples, OwnDeviceIsHeldUp) {
    const Ran ran = run_example("own_device as-fast-as-it-goes");
    EXPECT_EQ(ran.code, 0) << ran.out;
}

TEST(Examples, OwnDeviceReturnsAfterStall) {
    for (const int stall_ms : {20, 49, 50, 300, 1000}) {
        const Ran ran = run_example("own_device " + std::to_string(stall_ms));
        EXPECT_EQ(ran.code, 0) << stall_ms << '\n' << ran.out;
        // The tick after a stall is one more late.
        EXPECT_EQ(ran.out.find("no tick for " + std::to_string(stall_ms + 1) + " ms") != std::string::npos,
                  stall_ms >= 50)
            << ran.out;
    }
}

TEST(Examples, OwnImporterMakesAClipOfRawDepth) {
    const TemporaryFolder folder;
    const Hill hill;
    std::ofstream raw(folder / "hill.raw", std::ios::binary);
    std::vector<std::uint16_t> expected = hill.codes();
    std::vector<char> confidence(expected.size(), '\xff');
    confidence[100] = 5;
    for (int n = 0; n < 2; ++n) {
        raw.write(reinterpret_cast<const char*>(expected.data()),
                  static_cast<std::streamsize>(2 * expected.size()));
        raw.write(confidence.data(), static_cast<std::streamsize>(confidence.size()));
    }
    raw.close();
    expected[100] = 0;
    const std::string clip = folder / "hill.mkv";
    const Ran ran = run_example("own_importer " + (folder / "hill.raw").string() + " 64x48 60 30 " + clip);
    ASSERT_EQ(ran.code, 0) << ran.out;
    touch::Clip written(clip);
    EXPECT_EQ(written.facts().frames, 2);
    const auto frameset = written.next();
    ASSERT_TRUE(frameset);
    const touch_plane depth = frameset->frame().depth;
    for (std::size_t y = 0; y < Hill::height; ++y)
        ASSERT_EQ(std::memcmp(static_cast<const char*>(depth.data) +
                                  static_cast<std::int64_t>(y) * depth.stride_bytes,
                              expected.data() + y * Hill::width, 2 * Hill::width),
                  0);
    EXPECT_EQ(run_example("own_importer " + (folder / "hill.raw").string() + " 64x48 60 30 " + clip).code, 3)
        << "replaced what was there";
    EXPECT_EQ(run_example("own_importer").code, 2);
}

}  // namespace
}  // namespace touchable::test
