// SPDX-License-Identifier: Apache-2.0
#include "tests/stream/served_clip.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>

extern char** environ;

namespace touchable::test {
namespace {

constexpr const char* program = TOUCHABLE_PROGRAM;

/// Its first line, or what there is of it once it has ended or 60 s have passed.
std::string first_line(int descriptor) {
    std::string said;
    char one = 0;
    pollfd waits{descriptor, POLLIN, 0};
    while (::poll(&waits, 1, 60'000) > 0 && ::read(descriptor, &one, 1) == 1 && one != '\n') said += one;
    return said;
}

}  // namespace

Result<std::unique_ptr<ServedClip>> ServedClip::start(const std::filesystem::path& clip,
                                                      std::vector<std::string> options,
                                                      std::filesystem::path report) {
    options.insert(options.begin(), {program, "serve", clip.string()});
    options.insert(options.end(), {"--json", report.string(), "--overwrite"});
    std::vector<char*> words;
    for (std::string& option : options) words.push_back(option.data());
    words.push_back(nullptr);
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return Error{ErrorKind::internal, "no pipe can be made"};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 1);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 2);
    // SIGINT ends it (end()), though this process may run in a shell's background, where it is ignored.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t asked;
    sigemptyset(&asked);
    sigaddset(&asked, SIGINT);
    posix_spawnattr_setsigdefault(&attributes, &asked);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
    pid_t process = 0;
    const int failed = posix_spawn(&process, program, &actions, &attributes, words.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    if (failed != 0) {
        ::close(ends[0]);
        return input_error(std::string(program) + ": cannot be run; build the target touchable");
    }
    std::unique_ptr<ServedClip> served(new ServedClip(process, ends[0], std::move(report)));
    // "listening on tcp://127.0.0.1:7000: touchable play ...", or that it sends there.
    const std::string said = first_line(ends[0]);
    const std::size_t to = std::min(said.rfind(": touchable play "), said.size());
    const std::size_t from = said.rfind(' ', to > 0 ? to - 1 : 0);
    if (from == std::string::npos || said.find("://") == std::string::npos)
        return Error{ErrorKind::check, "touchable serve does not begin; it says: " + said};
    served->address_ = said.substr(from + 1, to - from - 1);
    return served;
}

ServedClip::~ServedClip() {
    if (process_ > 0) {
        ::kill(process_, SIGKILL);
        ::waitpid(process_, nullptr, 0);
    }
    ::close(says_);
}

std::int64_t ServedClip::cpu_ns() const {
    clockid_t clock = 0;
    timespec time{};
    if (::clock_getcpuclockid(process_, &clock) != 0 || ::clock_gettime(clock, &time) != 0) return 0;
    return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

Result<nlohmann::ordered_json> ServedClip::end() {
    ::kill(process_, SIGINT);
    ::waitpid(process_, nullptr, 0);
    process_ = 0;
    std::ifstream file(report_);
    auto report = nlohmann::ordered_json::parse(file, nullptr, false);
    if (report.is_discarded()) return Error{ErrorKind::check, "touchable serve wrote no report"};
    return report;
}

}  // namespace touchable::test
