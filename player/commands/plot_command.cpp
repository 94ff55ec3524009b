#include "player/commands/commands.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cerrno>
#include <cstring>
#include <iostream>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

/// Debian's matplotlib belongs to this Python; without it the first in PATH.
const char* python() {
    constexpr const char* system = "/usr/bin/python3";
    return access(system, X_OK) == 0 ? system : "python3";
}

/// The last non-empty line: for a Python exception the one that names it.
std::string last_line(const std::string& text) {
    const std::size_t end = text.find_last_not_of("\n ");
    if (end == std::string::npos) return "";
    const std::size_t before = text.find_last_of('\n', end);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    return text.substr(begin, end + 1 - begin);
}

std::string read_all(int from) {
    std::string text;
    std::array<char, 4096> block;
    for (;;) {
        const ssize_t count = read(from, block.data(), block.size());
        if (count > 0) text.append(block.data(), static_cast<std::size_t>(count));
        if (count == 0 || (count < 0 && errno != EINTR)) return text;
    }
}

/// Starts `command` with standard output into `to` and standard error into `errors`. Returns 0 or errno.
int start(const std::vector<std::string>& command, const fs::path& to, int errors, pid_t& child) {
    std::vector<char*> words;
    for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    posix_spawn_file_actions_t files;
    if (const int why = posix_spawn_file_actions_init(&files)) return why;
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, to.c_str(), O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&files, errors, STDERR_FILENO);
    const int why = posix_spawnp(&child, words[0], &files, nullptr, words.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    return why;
}

/// Path of plot.py in the build tree or the installation, relative to the program.
fs::path plot_script() {
    std::error_code fault;
    const fs::path program = fs::read_symlink("/proc/self/exe", fault);
    return (program.parent_path() / TOUCHABLE_PLOT_FROM_PROGRAM / "plot.py").lexically_normal();
}

/// Runs player/plot/plot.py, which needs Python and matplotlib, with these words. Its picture goes to the
/// file `to`. Its complaints about the input become input errors.
Result<void> run_plot_script(const std::vector<std::string>& words, const fs::path& to) {
    const fs::path script = plot_script();
    if (access(script.c_str(), R_OK) != 0)
        return input_error(script.string() +
                           " does not exist; `plot` needs it where touchable is installed or was built");
    std::vector<std::string> command{python(), "-B", script.string()};  // -B: writes no cache files
    command.insert(command.end(), words.begin(), words.end());
    std::array<int, 2> errors;
    if (pipe2(errors.data(), O_CLOEXEC) != 0)
        return internal_error(std::string("no pipe to Python: ") + std::strerror(errno));
    pid_t child = 0;
    const int why = start(command, to, errors[1], child);
    close(errors[1]);
    const std::string said = why == 0 ? last_line(read_all(errors[0])) : "";
    close(errors[0]);
    if (why != 0)
        return input_error(std::string("Python cannot be started (") + std::strerror(why) +
                           "); Debian: python3-matplotlib");
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
    if (said.find("ModuleNotFoundError") != std::string::npos)
        return input_error("Python lacks what `plot` needs (" + said + "); Debian: python3-matplotlib");
    return WIFEXITED(status) && WEXITSTATUS(status) == 3 ? input_error(said)
                                                         : internal_error("the plot failed: " + said);
}

struct PlotOptions {
    fs::path forces, picture;
    std::optional<fs::path> over;
    Existing existing = Existing::keep;
};

/// Refuses files that would block the script or fill its memory.
Result<void> check_given(const std::vector<NamedFile>& inputs) {
    constexpr std::uint64_t largest = std::uint64_t{256} << 20;  // same as compare's
    for (const NamedFile& input : inputs) {
        const std::string named = input.name + " " + input.path.string();
        TRY_ASSIGN(const auto given, GivenFile::open(input.path, named, "a file that touch or export wrote"));
        if (given.size() > largest) return input_error(named + ": is larger than " + in_bytes(largest));
    }
    return {};
}

Result<void> plot(const PlotOptions& options) {
    std::vector<NamedFile> inputs{{"the forces file", options.forces}};
    std::vector<std::string> words{options.forces.string()};
    if (options.over) {
        for (const char* name : {"scene.json", "codes.png", "valid.png"})
            inputs.push_back({"--over", *options.over / name});
        words.push_back(options.over->string());
    }
    if (auto free = check_outputs({{{"the picture", options.picture}}, options.existing}, inputs); !free)
        return free;
    TRY(check_given(inputs));
    NewFile file(options.picture, options.existing);
    TRY(file.check());
    TRY(run_plot_script(words, file.path()));
    TRY(file.commit());
    std::cout << "plot: " << one_line(file.target().string()) << '\n';
    return {};
}

}  // namespace

void add_plot_command(CLI::App& app, Command& command) {
    auto* sub =
        app.add_subcommand("plot", "draw the forces of a run over time, or the fingers' paths over a frame");
    auto options = std::make_shared<PlotOptions>();
    add_file_option(*sub, "FORCES", options->forces, "forces file (touchable touch --forces)")->required();
    add_file_option(*sub, "PICTURE", options->picture, "PNG file to write")
        ->required()
        ->check(ends_in({".png"}, "a picture"));
    add_file_option(*sub, "--over", options->over,
                    "draw the fingers' paths over depth of the frame in this folder (touchable export --out)")
        ->type_name("FOLDER");
    add_overwrite_option(*sub, options->existing);
    set_work(*sub, command, [options] { return plot(*options); });
}

}  // namespace touchable
