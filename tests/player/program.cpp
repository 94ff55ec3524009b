#include "tests/player/program.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <thread>

namespace touchable::test {
namespace fs = std::filesystem;
namespace {

Outcome run(const std::vector<std::string>& arguments, const std::function<void(pid_t)>& meanwhile) {
    const TemporaryFolder folder;
    const std::string out = folder / "out", err = folder / "err";
    std::vector<std::string> words{TOUCHABLE_PROGRAM};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);

    const pid_t child = fork();
    if (child == 0) {
        dup2(open(out.c_str(), O_WRONLY | O_CREAT, 0600), STDOUT_FILENO);
        dup2(open(err.c_str(), O_WRONLY | O_CREAT, 0600), STDERR_FILENO);
        execv(argv[0], argv.data());
        _exit(127);
    }
    meanwhile(child);
    int status = 0;
    waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), file_contents(out),
            file_contents(err)};
}

}  // namespace

bool Outcome::one_line_of_error() const {
    return err.rfind("touchable: ", 0) == 0 && std::count(err.begin(), err.end(), '\n') == 1 &&
           err.back() == '\n';
}

Outcome run_touchable(const std::vector<std::string>& arguments) {
    return run(arguments, [](pid_t) {});
}

Outcome run_interrupted(const std::vector<std::string>& arguments, const fs::path& folder) {
    return run(arguments, [&](pid_t child) {
        using namespace std::chrono_literals;
        for (int tries = 0; tries < 1000 && names_in(folder).empty(); ++tries)
            std::this_thread::sleep_for(10ms);
        std::this_thread::sleep_for(50ms);
        kill(child, SIGINT);
    });
}

TemporaryFolder::TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "touchable-test-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

std::string file_contents(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::vector<std::string> names_in(const fs::path& folder) {
    std::vector<std::string> names;
    std::error_code failure;
    for (const auto& entry : fs::directory_iterator(folder, failure))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

}  // namespace touchable::test
