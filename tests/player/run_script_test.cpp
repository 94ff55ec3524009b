// `./run` on a machine that lacks what it needs.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

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
    const Answer answer = run_script("build", path.path());
    EXPECT_EQ(answer.code, 2) << answer.text;
    EXPECT_EQ(answer.text.find("asked"), answer.text.rfind("asked")) << answer.text;
    EXPECT_NE(answer.text.find("as root: apt-get install --no-install-recommends g++ "), std::string::npos)
        << answer.text;
}

}  // namespace
}  // namespace touchable::test
