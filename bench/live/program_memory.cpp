// SPDX-License-Identifier: Apache-2.0
#include "bench/live/program_memory.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>

extern char** environ;

namespace touchable {
namespace {

/// Peak memory of a process so far, bytes; 0: it has ended. Linux only: "VmHWM:   12345 kB".
std::int64_t peak_memory_of(pid_t process) {
    std::ifstream status("/proc/" + std::to_string(process) + "/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmHWM:")) return 1024 * std::stoll(line.substr(6));
    return 0;
}

/// Runs the program to its end and returns its peak memory, bytes.
Result<std::int64_t> peak_of_program(const std::vector<std::string>& arguments) {
    constexpr const char* program = TOUCHABLE_PROGRAM;
    std::vector<char*> words{const_cast<char*>(program)};
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    posix_spawn_file_actions_t quiet;
    posix_spawn_file_actions_init(&quiet);
    posix_spawn_file_actions_addopen(&quiet, 1, "/dev/null", O_WRONLY, 0);
    pid_t process = 0;
    const int failed = posix_spawn(&process, program, &quiet, nullptr, words.data(), environ);
    posix_spawn_file_actions_destroy(&quiet);
    if (failed != 0) return input_error(std::string(program) + ": cannot be run; build the target touchable");
    // rusage of a child starts at its parent's peak. The high-water mark in /proc does not and never
    // decreases, so the last sample misses only the last millisecond.
    std::int64_t peak = 0;
    int status = 0;
    pid_t ended = 0;
    while ((ended = waitpid(process, &status, WNOHANG)) == 0) {
        peak = std::max(peak, peak_memory_of(process));
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (ended != process || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
        return Error{ErrorKind::check, std::string(program) + " " + arguments.front() + " failed"};
    if (peak == 0) return Error{ErrorKind::check, "/proc does not tell how much memory a process holds"};
    return peak;
}

}  // namespace

Result<void> measure_program_memory(const LiveClip& clip, LiveClips& clips, Figures& figures) {
    const auto made = clips.place("made.mkv");
    if (!made) return made.error();
    const std::string size = std::to_string(clip.width) + "x" + std::to_string(clip.height);
    const auto make = peak_of_program(
        {"make", clip.scene, made->string(), "--size", size, "--frames", "20", "--overwrite"});
    if (!make) return make.error();
    const auto file = clips.file(clip);
    if (!file) return file.error();
    const auto live =
        peak_of_program({"touch", file->string(), "--live", "--fingers", "5", "--seconds", "3"});
    if (!live) return live.error();
    figures.push_back({"make_mb", static_cast<double>(*make) * 1e-6, "MB"});
    figures.push_back({"live_mb", static_cast<double>(*live) * 1e-6, "MB"});
    return {};
}

}  // namespace touchable
