// SPDX-License-Identifier: Apache-2.0
// The programs of examples/, as a reader of docs/install.md runs them.

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <type_traits>
#include <vector>

#include "capi/touchable.hpp"
#include "tests/capi/hill.hpp"
#include "tests/temporary_files.hpp"

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

TEST(Examples, OwnImporterConvertsRawDepth) {
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

// touchable.h describes every public name: what it is, in which unit, and which statuses it gives. (Doxygen,
// where it is there, refuses a name without a description; what a description has to say is looked at here.)

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

TEST(Reference, DocumentsEveryFunctionsStatuses) {
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
TEST(Reference, GivesEveryNumbersUnit) {
    const std::string unit =
        "_px|_m$|_ns|_per_|_units|_code|_degrees|_bytes|_ticks|_n$|pixels|metres|scene "
        "units|newtons|coefficient|"
        "milliseconds|frames|right|up|camera|number|how many";
    const auto members = members_of(header());
    EXPECT_GT(members.size(), 90u);
    for (const Described& member : members)
        if (says(member.declaration, "\\b(double|int64_t)\\b")) {
            EXPECT_TRUE(says(member.name, unit) || says(member.comment, unit)) << member.declaration;
        }
}

TEST(Reference, MarksRealTimeFunctions) {
    for (const Described& function : functions_of(header()))
        if (says(function.name, "solver_(tick|run|come_back|force_hash)|newest_ns|describe|touch_version")) {
            EXPECT_TRUE(says(function.comment, "Real-time") || says(function.name, "clip_describe"))
                << function.name;
        }
}

// The C++ wrapper is the C API: same forces, objects that end themselves, errors that are thrown.

TEST(Wrapper, GivesTheSameForces) {
    const Hill hill;
    touch::Scene scene(Hill::camera());
    touch::Surface surface(scene);
    EXPECT_TRUE(surface.push(hill.frame()));
    touch::Solver solver(surface);
    TouchedHill touched;
    for (std::int64_t tick = 0; tick < 300; ++tick) {
        const touch_vec3 goal = goal_at(tick);
        touch_contact contact;
        ASSERT_EQ(solver.tick(touch::tick_at(tick), &goal, &contact), TOUCH_OK);
        ASSERT_EQ(touched.tick(tick), TOUCH_OK);
    }
    EXPECT_EQ(solver.force_hash(), touched.hash());
}

TEST(Wrapper, DestroysObjectsAndThrowsErrors) {
    static_assert(!std::is_copy_constructible_v<touch::Surface>);
    touch_surface left{};
    {
        const touch::Scene scene(Hill::camera());
        EXPECT_EQ(touch::Scene(scene.text()).text(), scene.text());
        touch::Surface surface(scene);
        touch::Surface moved(std::move(surface));
        left = moved.get();
        EXPECT_THROW(moved.hand_scale(), touch::Error) << "no frame yet";
        EXPECT_TRUE(moved.push(Hill().frame()));
        EXPECT_GT(moved.hand_scale(), 0);
        EXPECT_THROW(moved.push(Hill().frame()), touch::Error) << "not later";
    }
    EXPECT_EQ(touch_surface_destroy(left), TOUCH_STALE);
    try {
        const touch::Scene scene(std::string_view("{}"));
        FAIL() << "no scene at all";
    } catch (const touch::Error& error) {
        EXPECT_EQ(error.status(), TOUCH_INPUT);
        EXPECT_GT(std::string(error.what()).size(), 10U);
    }
}

}  // namespace
}  // namespace touchable::test
