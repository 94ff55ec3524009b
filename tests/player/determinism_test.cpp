#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::testing {
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
// a change is meant to change forces, the failures print the new hashes: take them over only when GCC and
// Clang, -O0 and -O3 agree on them.
const KnownRun known_runs[] = {
    {"bb54d7c01c433260", "GlobeOfFiveFingers", "globe --frames 15", "--fingers 5 --seconds 0.8"},
    {"8924f8a6712568df", "SlipperyGlobe", "globe --plain --frames 2",
     "--hand press:x=0.4,depth=5 --fingers 3"},
    {"95c43c4ab5c19bed", "BumpsStroked", "bumps --frames 15", "--hand stroke:angle=30,speed=0.3 --seconds 1"},
    {"853a6d79dde8849a", "MovingLinear", "moving --frames 15", "--interpolation linear --seconds 0.8"},
    {"52b04c5c7fd3e84d", "MovingHeld", "moving --frames 15", "--interpolation hold --seconds 0.8"},
    {"bbf94138feb67d43", "Noise", "noise --frames 2", "--hand wander:speed=0.3 --seconds 0.8"},
    {"1228bfd46504c0fb", "NoiseFiltered", "noise --frames 2", "--median 5 --fingers 2 --seconds 0.8"},
    {"7f5f692e4100a6a7", "SpheresPoked", "spheres --frames 2", "--hand poke:speed=0.5 --seconds 2"},
    {"4f3ed5e5ea2c7c49", "BumpsInPixels", "bumps --frames 2", "--metric pixel --seconds 0.8"},
    {"6afab78b7ae3cb03", "HolesFilled", "cliffs --frames 2", "--fill-holes 2 --median 5 --seconds 1", 0}};

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

INSTANTIATE_TEST_SUITE_P(, Determinism, ::testing::ValuesIn(known_runs),
                         [](const auto& run) { return std::string(run.param.name); });

}  // namespace
}  // namespace touchable::testing
