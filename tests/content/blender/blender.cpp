#include "tests/content/blender/blender.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace fs = std::filesystem;
namespace {

std::string lines_of(const fs::path& file, const std::string& beginning) {
    std::ifstream in(file);
    std::string lines;
    for (std::string line; std::getline(in, line);)
        if (line.starts_with(beginning)) (lines += line) += '\n';
    return lines;
}

std::vector<char*> pointers_to(std::vector<std::string>& words) {
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    return pointers;
}

}  // namespace

bool has_blender() {
    return std::system("blender --version >/dev/null 2>&1") == 0;
}

BlenderRun run_blender(const std::vector<fs::path>& scripts, const std::vector<std::string>& words,
                       const std::vector<std::string>& environment, const std::function<bool()>& is_enough) {
    const TemporaryFolder streams;
    std::vector<std::string> all{"env"};
    all.insert(all.end(), environment.begin(), environment.end());
    all.insert(all.end(), {"blender", "-b", "--factory-startup", "--python-exit-code", "9"});
    for (const fs::path& script : scripts) all.insert(all.end(), {"-P", script.string()});
    all.emplace_back("--");
    all.insert(all.end(), words.begin(), words.end());
    const std::vector<char*> argv = pointers_to(all);
    const std::string out = streams / "out", err = streams / "err";

    const pid_t child = fork();
    if (child == 0) {
        for (const auto& [file, stream] : {std::pair{&out, STDOUT_FILENO}, std::pair{&err, STDERR_FILENO}})
            dup2(open(file->c_str(), O_WRONLY | O_CREAT, 0600), stream);
        // These tests may run in a shell's background, where it is ignored.
        std::signal(SIGINT, SIG_DFL);
        execvp(argv[0], argv.data());
        _exit(127);
    }
    int status = 0;
    bool asked = false;
    while (waitpid(child, &status, WNOHANG) == 0) {
        if (is_enough && !asked && is_enough()) {
            asked = true;
            kill(child, SIGINT);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), lines_of(out, "touchable: "),
            lines_of(err, "")};
}

BlenderRun export_scene(const std::string& scene, const std::vector<std::string>& words,
                        const std::function<bool()>& is_enough) {
    const fs::path root(TOUCHABLE_SOURCE_DIR);
    return run_blender(
        {root / "tests/content/blender/test_scenes.py", root / "engine/content/blender/export.py"}, words,
        {"SCENE=" + scene, "TOUCHABLE=" TOUCHABLE_PROGRAM}, is_enough);
}

}  // namespace touchable::test
