// `./run` on a machine that lacks what it needs.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/player/program.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

struct Answer {
    int code = -1;
    std::string text;
};

/// What `./run` with these words says where no other programs are than those in `path`.
Answer run_script(const std::string& words, const fs::path& path, const std::string& through = "") {
    const std::string command = "PATH='" + path.string() + "' " + through + " '" + (path / "bash").string() +
                                "' '" TOUCHABLE_SOURCE_DIR "/run' " + words + " 2>&1";
    Answer answer;
    FILE* script = popen(command.c_str(), "r");
    std::array<char, 256> some;
    while (std::fgets(some.data(), some.size(), script)) answer.text += some.data();
    answer.code = WEXITSTATUS(pclose(script));
    return answer;
}

TEST(RunScript, NamesTheProgramsThatAreMissing) {
    const TemporaryFolder path;
    for (const char* name : {"bash", "dirname", "nproc"}) {
        fs::path program = fs::path("/usr/bin") / name;
        ASSERT_TRUE(fs::exists(program)) << program;
        fs::create_symlink(program, path / name);
    }
    for (const char* words : {"build --no-install", "test --no-install", "demo --no-install"}) {
        const Answer answer = run_script(words, path.path());
        EXPECT_EQ(answer.code, 2) << words;
        EXPECT_EQ(std::count(answer.text.begin(), answer.text.end(), '\n'), 1) << answer.text;
        for (const char* missing :
             {"g++ (Debian: g++)", "cmake (Debian: cmake)", "ninja (Debian: ninja-build)"})
            EXPECT_NE(answer.text.find(missing), std::string::npos) << answer.text;
    }
    std::error_code failure;
    fs::create_symlink("/usr/bin/true", path / "cmake", failure);
    EXPECT_EQ(run_script("build --no-install", path.path()).text.find("cmake"), std::string::npos);
}

TEST(RunScript, AWindowWithoutADisplayIsRefusedBeforeAnythingIsBuilt) {
    const Answer answer =
        run_script("demo --window --no-install", "/usr/bin", "env -u DISPLAY -u WAYLAND_DISPLAY");
    EXPECT_EQ(answer.code, 2) << answer.text;
    EXPECT_EQ(std::count(answer.text.begin(), answer.text.end(), '\n'), 1) << answer.text;
    EXPECT_NE(answer.text.find("./run demo touches the globe without"), std::string::npos) << answer.text;
}

/// A program of a folder, as a script.
void put_script(const fs::path& path, const std::string& text) {
    std::ofstream(path) << "#!/usr/bin/bash\n" << text << '\n';
    fs::permissions(path, fs::perms::owner_all);
}

TEST(RunScript, APersonWhomSudoRefusesIsAskedOnceAndGetsTheLineForRoot) {
    const TemporaryFolder path;
    for (const char* name : {"bash", "dirname", "nproc"})
        fs::create_symlink(fs::path("/usr/bin") / name, path / name);
    put_script(path / "id", "echo 1000");
    put_script(path / "dpkg-query", "exit 1");  // nothing is installed
    put_script(path / "sudo", "echo asked; exit 1");
    // The tests may themselves have been asked for by `./run test --no-install`.
    const Answer answer = run_script("build", path.path(), "/usr/bin/env -u TOUCHABLE_INSTALL");
    EXPECT_EQ(answer.code, 2) << answer.text;
    EXPECT_EQ(answer.text.find("asked"), answer.text.rfind("asked")) << answer.text;
    EXPECT_NE(answer.text.find("as root: apt-get install --no-install-recommends g++ "), std::string::npos)
        << answer.text;
}

// The globe fills 80 % of the picture's height; what is behind it pushes back, too.
TEST(RunScript, DemoFingersStayOnGlobe) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", forces = folder / "forces.csv";
    const double width = 360, height = 240;
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--size", "360x240", "--frames", "90"}).code, 0);
    const std::regex in_words(R"(globe\.mkv"? (?:--live )?--hand (\S+) --fingers 5)");
    std::set<std::string> hands;
    int commands = 0;
    for (const char* file : {TOUCHABLE_SOURCE_DIR "/run", TOUCHABLE_SOURCE_DIR "/README.md"}) {
        const std::string text = file_contents(file);
        for (std::sregex_iterator match(text.begin(), text.end(), in_words), end; match != end; ++match) {
            hands.insert((*match)[1]);
            ++commands;
        }
    }
    EXPECT_EQ(commands, 3) << "two of the demo, and the README's";
    for (const std::string& hand : hands) {
        const Outcome touched = run_touchable(
            {"touch", clip, "--hand", hand, "--fingers", "5", "--forces", forces, "--overwrite"});
        ASSERT_EQ(touched.code, 0) << touched.err;
        std::ifstream rows(forces);
        std::string header, row;
        std::getline(rows, header);
        const auto column = [&](const char* name) {
            const std::size_t at = ("," + header + ",").find(std::string(",") + name + ",");
            EXPECT_NE(at, std::string::npos) << name;
            return std::count(header.begin(), header.begin() + static_cast<std::ptrdiff_t>(at), ',');
        };
        const auto finger = column("finger"), contact = column("contact"), x = column("pixel_x"),
                   y = column("pixel_y");
        std::array<int, 5> touching{};
        double farthest = 0;
        while (std::getline(rows, row)) {
            std::vector<double> values;
            std::istringstream fields(row);
            for (std::string field; std::getline(fields, field, ',');) values.push_back(std::stod(field));
            const auto at = [&](std::ptrdiff_t n) { return values.at(static_cast<std::size_t>(n)); };
            if (at(contact) == 0) continue;
            ++touching.at(static_cast<std::size_t>(at(finger)));
            farthest = std::max(farthest, std::hypot(at(x) - 0.5 * (width - 1), at(y) - 0.5 * (height - 1)));
        }
        EXPECT_LT(farthest, 0.8 * height / 2) << hand;
        for (const int ticks : touching) EXPECT_GT(ticks, 2500) << hand << ": of 3000";
    }
}

}  // namespace
}  // namespace touchable::test
