#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

/// Forces of a run that are known to the bit; words of `make` and of `touch`.
struct KnownRun {
    const char *force_hash, *name, *make, *touch;
    int invalid = -1;  ///< a stored value that stands for no depth in this run
};

void PrintTo(const KnownRun& run, std::ostream* out) {
    *out << run.name;
}

// The same with every compiler, at every level of optimisation, under sanitizers and on every machine. Where
// a change is meant to change forces (of scripted hands: the last four), the failures print the new hashes:
// take them over only when GCC and Clang, -O0 and -O3 agree on them.
const KnownRun known_runs[] = {
    {"1c47c7bbd25f7bf6", "Globe", "globe --frames 15", "--fingers 5"},
    {"24707e292d727893", "SlipperyGlobe", "globe --plain --frames 2", "--fingers 3"},
    {"2cf2e848c7fd8bca", "Bumps", "bumps --frames 2", "--max-stiffness 0.5"},
    {"e1f87e65462747ce", "MovingLinear", "moving --frames 15", "--interpolation linear"},
    {"c958afe3bcace83c", "MovingHeld", "moving --frames 15", "--interpolation hold"},
    {"501e5ea63f503d21", "Spheres", "spheres --frames 2", "--max-force 3"},
    {"1d67ba68f8e0ebea", "Noise", "noise --frames 2", ""},
    {"708d57c4ac576840", "NoiseFiltered", "noise --frames 2 --bits 10", "--median 5 --fingers 2"},
    {"5f9f4bbf0c944866", "HolesFilled", "cliffs --frames 2", "--fill-holes 2 --median 3", 0},
    {"b62c6b5682516172", "TerracesRemoved", "globe --frames 2 --bits 8", "--terraces on --fingers 3"},
    {"08efd1ba909ea1f2", "BumpsInPixels", "bumps --frames 2", "--metric pixel"},
    {"83935dc78f2cf3bc", "Wander", "globe --frames 15", "--hand wander --fingers 5 --seconds 0.8"},
    {"411e5c699b4a33be", "Stroke", "bumps --frames 2", "--hand stroke:angle=30,speed=0.3 --seconds 1"},
    {"97a97af93789fc7a", "Press", "moving --frames 15", "--hand press:x=0.4,depth=5 --seconds 1"},
    {"24f6383c445e477d", "Poke", "spheres --frames 2", "--hand poke:speed=0.5 --seconds 2"}};

std::vector<std::string> split(const std::string& text) {
    std::istringstream in(text);
    return {std::istream_iterator<std::string>(in), std::istream_iterator<std::string>()};
}

class Determinism : public ::testing::TestWithParam<KnownRun> {};

TEST_P(Determinism, ForcesAreTheKnownOnesToTheBit) {
    const KnownRun& known = GetParam();
    const TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv", scene = folder / "scene.json";
    auto make = split(known.make), words = split(known.touch);
    const std::string kind = make.front();
    make.erase(make.begin());
    make.insert(make.end(), {"--size", "96x64"});
    make_clip(kind, clip, make);
    words.push_back(clip);
    if (std::find(words.begin(), words.end(), "--hand") == words.end())
        words.insert(words.end(), {"--hand", zigzag_hand(folder / "zigzag.csv")});
    if (known.invalid >= 0) {
        auto description = scene_of(clip);
        description["depth"]["invalid"] = {known.invalid};
        std::ofstream(scene) << description;
        words.insert(words.end(), {"--scene", scene});
    }
    const auto report = touch(words);
    EXPECT_GT(report["finger_contact_pct"], 20) << "hardly a test of forces";
    EXPECT_EQ(report["force_hash"], std::string(known.force_hash));
}

/// Runs what it is given on one core only.
class OnOneCore {
public:
    OnOneCore() {
        sched_getaffinity(0, sizeof before_, &before_);
        cpu_set_t one;
        CPU_ZERO(&one);
        for (int core = 0; core < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++core)
            if (CPU_ISSET(core, &before_)) CPU_SET(core, &one);
        sched_setaffinity(0, sizeof one, &one);
    }
    ~OnOneCore() { sched_setaffinity(0, sizeof before_, &before_); }
    OnOneCore(const OnOneCore&) = delete;
    OnOneCore& operator=(const OnOneCore&) = delete;

private:
    cpu_set_t before_{};
};

/// Whatever codec a clip's pictures are stored by, and however many threads decode them.
TEST(Archives, GiveTheSameForces) {
    const TemporaryFolder folder;
    const std::string hand = zigzag_hand(folder / "zigzag.csv");
    std::string known;
    for (const std::string archive : {"fast", "small"}) {
        const std::string clip = folder / (archive + ".mkv");
        make_clip("moving", clip, {"--size", "300x200", "--frames", "16", "--archive", archive});
        const auto words =
            std::vector<std::string>{clip, "--hand", hand, "--fingers", "2", "--seconds", "0.5"};
        const std::string all = touch(words)["force_hash"];
        const OnOneCore alone;
        const std::string one = touch(words)["force_hash"];
        EXPECT_EQ(one, all) << archive;
        if (known.empty()) known = all;
        EXPECT_EQ(all, known) << archive;
    }
}

INSTANTIATE_TEST_SUITE_P(, Determinism, ::testing::ValuesIn(known_runs),
                         [](const auto& run) { return std::string(run.param.name); });

}  // namespace
}  // namespace touchable::test
