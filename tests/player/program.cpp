// SPDX-License-Identifier: Apache-2.0
#include "tests/player/program.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <set>
#include <span>
#include <thread>

#include "tests/limits.hpp"

namespace touchable::test {
namespace fs = std::filesystem;
namespace {

using Hook = std::function<void()>;

/// A child's stream, as it comes: by a pipe, or by a terminal of its own.
class Pipe {
public:
    enum class Kind { pipe, terminal };
    explicit Pipe(Kind kind = Kind::pipe) {
        if (kind == Kind::pipe) {
            if (pipe(ends_.data()) != 0) std::abort();
            return;
        }
        ends_[0] = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
        if (ends_[0] < 0 || grantpt(ends_[0]) != 0 || unlockpt(ends_[0]) != 0) std::abort();
        ends_[1] = open(ptsname(ends_[0]), O_RDWR | O_NOCTTY);
    }
    ~Pipe() {
        for (const int end : ends_) close(end);
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;

    /// In the child: `stream` goes here.
    void take_over(int stream) const { dup2(ends_[1], stream); }
    /// In the parent: only the child writes.
    void leave_to_child() {
        close(ends_[1]);
        ends_[1] = -1;
    }
    int reading_end() const { return ends_[0]; }
    /// Adds what is there; false at the end.
    bool read_into(std::string& text) const {
        std::array<char, 4096> some;
        const auto count = ::read(ends_[0], some.data(), some.size());
        if (count > 0) text.append(some.data(), static_cast<std::size_t>(count));
        return count > 0;
    }

private:
    std::array<int, 2> ends_{-1, -1};
};

/// Reads both streams to their ends; `heard` is called whenever there is more of one.
void read_all(const Pipe& out, const Pipe& err, Outcome& outcome, const Hook& heard) {
    std::array<pollfd, 2> waiting{{{out.reading_end(), POLLIN, 0}, {err.reading_end(), POLLIN, 0}}};
    for (int open = 2; open > 0;) {
        poll(waiting.data(), waiting.size(), -1);
        for (std::size_t k = 0; k < waiting.size(); ++k) {
            if (waiting[k].revents == 0) continue;
            const bool more = k == 0 ? out.read_into(outcome.out) : err.read_into(outcome.err);
            if (more) continue;
            waiting[k].fd = -1;  // poll looks past it
            --open;
        }
        heard();
    }
}

/// `prepare` runs in the child, `meanwhile` in the parent, with the child's id. The child is sent SIGINT once
/// what it has said is enough.
struct Hooks {
    Hook prepare = [] {};
    std::function<void(pid_t)> meanwhile = [](pid_t) {};
    std::function<bool(const Outcome&)> is_enough = [](const Outcome&) { return false; };
    Pipe::Kind err = Pipe::Kind::pipe, out = Pipe::Kind::pipe;
    std::string program = TOUCHABLE_PROGRAM;
};

/// Libraries that are loaded before the program, so that a busy machine is waited for: a GPU has the time
/// that it needs, and the clock of a window that goes by a script waits for the window. GCC's
/// AddressSanitizer allows nothing before itself.
std::string loaded_before(const Words& arguments) {
    const char* const asked = std::getenv("LD_PRELOAD");
    std::string libraries = asked ? asked : "";
#ifndef __SANITIZE_ADDRESS__
    const auto has = [&](const char* word) {
        return std::find(arguments.begin(), arguments.end(), word) != arguments.end();
    };
    libraries += (libraries.empty() ? "" : ":") + std::string(TOUCHABLE_PATIENT_GPU);
    if (has("--headless") && has("--script")) libraries += std::string(":") + TOUCHABLE_TURNS_CLOCK;
#endif
    return libraries;
}

/// This process becomes that program.
[[noreturn]] void become(Words words) {
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    execv(argv[0], argv.data());
    _exit(127);
}

/// As from a terminal, though these tests may run in a shell's background, where they are ignored.
void mind_signals() {
    for (const int asked : {SIGINT, SIGTERM, SIGHUP, SIGTSTP, SIGTTIN, SIGTTOU}) std::signal(asked, SIG_DFL);
}

Outcome run(const Words& arguments, const Hooks& hooks) {
    const std::string libraries = loaded_before(arguments);

    Pipe out(hooks.out), err(hooks.err);
    const pid_t child = fork();
    if (child == 0) {
        out.take_over(STDOUT_FILENO);
        err.take_over(STDERR_FILENO);
        mind_signals();
        setenv("LD_PRELOAD", libraries.c_str(), 1);
        hooks.prepare();
        become(plus({hooks.program}, arguments));
    }
    out.leave_to_child();
    err.leave_to_child();
    hooks.meanwhile(child);
    Outcome outcome;
    bool told = false;
    read_all(out, err, outcome, [&] {
        if (told || !hooks.is_enough(outcome)) return;
        told = true;
        kill(child, SIGINT);
    });
    int status = 0;
    rusage used{};
    wait4(child, &status, 0, &used);
    outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    outcome.peak_mebibytes = static_cast<double>(used.ru_maxrss) / 1024;
    return outcome;
}

/// Of all its threads.
std::chrono::nanoseconds cpu_time_of(pid_t child) {
    clockid_t clock{};
    timespec time{};
    if (clock_getcpuclockid(child, &clock) != 0 || clock_gettime(clock, &time) != 0) return {};
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

/// Waits until it does what `is_enough` looks for, or has ended.
void wait_until_it(pid_t child, const std::function<bool()>& is_enough) {
    siginfo_t ended{};
    while (!is_enough() &&
           waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           ended.si_pid == 0)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void wait_until_it_minds_interrupts(pid_t child) {
    wait_until_it(child, [&] {
        std::ifstream status("/proc/" + std::to_string(child) + "/status");
        const std::string name = "SigCgt:";
        for (std::string line; std::getline(status, line);)
            if (line.starts_with(name))
                return (std::stoull(line.substr(name.size()), nullptr, 16) >> (SIGINT - 1) & 1U) == 1;
        return false;
    });
}

Outcome run_limited(const Words& arguments, decltype(RLIMIT_AS) what, rlim_t bytes) {
    Hooks hooks;
    hooks.prepare = [=] {
        rlimit limit{};
        getrlimit(what, &limit);
        limit.rlim_cur = bytes;
        setrlimit(what, &limit);
    };
    return run(arguments, hooks);
}

/// True where a program has a file open there, be it one without a name.
bool has_opened_a_file_in(const fs::path& folder, pid_t program) {
    const std::string prefix = fs::canonical(folder).string() + '/';
    std::error_code failure;
    for (const auto& entry : fs::directory_iterator("/proc/" + std::to_string(program) + "/fd", failure))
        if (fs::read_symlink(entry.path(), failure).string().starts_with(prefix)) return true;
    return false;
}

/// The program that this process becomes has these rules for its system calls.
void obey(std::span<sock_filter> rules) {
    const sock_fprog program{static_cast<unsigned short>(rules.size()), rules.data()};
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
        prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0)
        _exit(126);
}

/// For the program that this process becomes: opening a file without a name fails as on a file system that
/// has none.
void refuse_unnamed_files() {
    constexpr auto unnamed = static_cast<std::uint32_t>(O_TMPFILE & ~O_DIRECTORY);
    constexpr auto number = offsetof(seccomp_data, nr), flags = offsetof(seccomp_data, args[2]);
    std::array<sock_filter, 6> rules{
        sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, number),
        sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_openat, 0, 3),
        sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, flags),  // the low half comes first
        sock_filter BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, unnamed, 0, 1),
        sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EOPNOTSUPP),
        sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)};
    obey(rules);
}

/// For the program that this process becomes: a disk that loses what is flushed to it.
void fail_flushes() {
    std::array<sock_filter, 5> rules{
        sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
        sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_fsync, 1, 0),
        sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_syncfs, 0, 1),
        sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EIO),
        sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)};
    obey(rules);
}

}  // namespace

bool Outcome::one_line_of_error() const {
    return err.rfind("touchable: ", 0) == 0 && std::count(err.begin(), err.end(), '\n') == 1 &&
           err.back() == '\n';
}

Outcome run_touchable(const Words& arguments) {
    return run(arguments, {});
}

Outcome succeed(const Words& arguments, const char* file, int line) {
    Outcome done = run_touchable(arguments);
    if (done.code != 0) ADD_FAILURE_AT(file, line) << "exit code " << done.code << ": " << done.err;
    return done;
}

Outcome expect_failure(Outcome run, int code, const std::string& words, const char* file, int line) {
    if (run.code != code || !run.one_line_of_error() || !says(run.err, words))
        ADD_FAILURE_AT(file, line) << "exit code " << run.code << " for " << code << ", and \"" << words
                                   << "\" in a line, not: " << run.err << run.out;
    return run;
}
Outcome expect_failure(const Words& arguments, int code, const std::string& words, const char* file,
                       int line) {
    return expect_failure(run_touchable(arguments), code, words, file, line);
}

nlohmann::json json_of(const Words& words, const char* file, int line) {
    return nlohmann::json::parse(succeed(words, file, line).out, nullptr, false);
}

nlohmann::json json_in(const std::filesystem::path& file) {
    return nlohmann::json::parse(file_contents(file), nullptr, false);
}

bool says(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

Words plus(Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

pid_t start_touchable(const Words& arguments, int in, int out, int err) {
    const pid_t child = fork();
    if (child != 0) return child;
    setpgid(0, 0);
    mind_signals();
    const int nowhere = open("/dev/null", O_RDWR);
    for (const auto& [stream, to] : {std::pair{STDIN_FILENO, in}, {STDOUT_FILENO, out}, {STDERR_FILENO, err}})
        dup2(to < 0 ? nowhere : to, stream);
    become(plus({TOUCHABLE_PROGRAM}, arguments));
}

Outcome run_in_folder(const Words& arguments, const fs::path& folder) {
    Hooks hooks;
    hooks.prepare = [&] {
        if (chdir(folder.c_str()) != 0) _exit(126);
    };
    return run(arguments, hooks);
}

Outcome run_in_folder_until(const Words& arguments, const fs::path& folder,
                            const std::function<bool()>& is_enough) {
    Hooks hooks;
    hooks.prepare = [&] {
        if (chdir(folder.c_str()) != 0) _exit(126);
    };
    hooks.meanwhile = [&](pid_t child) {
        wait_until_it(child, is_enough);
        kill(child, SIGINT);
    };
    return run(arguments, hooks);
}

Outcome run_in_folder_halting(const Words& arguments, const fs::path& folder, const fs::path& file) {
    Hooks hooks;
    hooks.prepare = [&] {
        if (chdir(folder.c_str()) != 0) _exit(126);
    };
#ifdef TOUCHABLE_SANITIZED  // a turn takes some six times as long
    constexpr std::chrono::milliseconds goes_on{60};
#else
    constexpr std::chrono::milliseconds goes_on{10};
#endif
    hooks.meanwhile = [&](pid_t child) {
        wait_until_it(child, [&] { return fs::exists(file); });
        wait_until_it(child, [&] {
            kill(child, SIGSTOP);
            std::this_thread::sleep_for(std::chrono::milliseconds(400));
            kill(child, SIGCONT);
            const auto used = cpu_time_of(child);
            for (int ms = 0; ms < 1000 && cpu_time_of(child) - used < goes_on; ++ms)
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            return false;
        });
    };
    return run(arguments, hooks);
}

fs::path install_program(const fs::path& prefix) {
    const fs::path program = prefix / "bin/touchable";
    fs::create_directories(program.parent_path());
    std::error_code elsewhere;  // a link leads to no other file system
    fs::create_hard_link(TOUCHABLE_PROGRAM, program, elsewhere);
    if (elsewhere) fs::copy_file(TOUCHABLE_PROGRAM, program);
    return program;
}

Outcome run_until_it_says(const Words& arguments, const std::function<bool(const std::string&)>& is_enough,
                          const fs::path& program) {
    Hooks hooks;
    if (!program.empty()) hooks.program = program.string();
    hooks.is_enough = [&](const Outcome& outcome) { return is_enough(outcome.err); };
    return run(arguments, hooks);
}

Outcome run_unheard(const Words& arguments) {
    Hooks hooks;
    hooks.prepare = [] {
        Pipe nobody_reads;
        nobody_reads.take_over(STDOUT_FILENO);
    };
    return run(arguments, hooks);
}

Outcome run_unread(const Words& arguments, bool interrupted) {
    Hooks hooks;
    hooks.prepare = [] {
        std::array<int, 2> ends{};  // this process keeps both
        if (pipe(ends.data()) != 0 || fcntl(ends[1], F_SETFL, O_NONBLOCK) != 0) _exit(126);
        const std::array<char, 4096> some{};
        while (write(ends[1], some.data(), some.size()) > 0) {
        }
        fcntl(ends[1], F_SETFL, 0);
        dup2(ends[1], STDOUT_FILENO);
    };
    if (interrupted)
        hooks.meanwhile = [](pid_t child) {
            wait_until_it_minds_interrupts(child);
            std::this_thread::sleep_for(std::chrono::seconds(1));
            kill(child, SIGINT);
        };
    return run(arguments, hooks);
}

Outcome run_with_full_output(const Words& arguments) {
    Hooks hooks;
    hooks.prepare = [] { dup2(open("/dev/full", O_WRONLY), STDOUT_FILENO); };
    return run(arguments, hooks);
}

Outcome run_interrupted(const Words& arguments, const fs::path& folder, int signal, Unfinished files) {
    Hooks hooks;
    if (files == Unfinished::named) hooks.prepare = refuse_unnamed_files;
    hooks.meanwhile = [&](pid_t child) {
        wait_until_it(child, [&] { return has_opened_a_file_in(folder, child); });
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        kill(child, signal);
    };
    return run(arguments, hooks);
}

Outcome run_with_named_files(const Words& arguments) {
    Hooks hooks;
    hooks.prepare = refuse_unnamed_files;
    return run(arguments, hooks);
}

Outcome run_interrupted_once_it_speaks(const Words& arguments) {
    Hooks hooks;
    hooks.is_enough = [](const Outcome& outcome) { return !outcome.out.empty(); };
    return run(arguments, hooks);
}

Outcome run_interrupted_at_once(const Words& arguments) {
    Hooks hooks;
    hooks.meanwhile = [](pid_t child) {
        wait_until_it_minds_interrupts(child);
        kill(child, SIGINT);
    };
    return run(arguments, hooks);
}

Outcome run_interrupted_while_live(const Words& arguments) {
    // Its line moves on: it has run for a tenth of a second at least.
    Outcome outcome =
        run_on_terminal(arguments, [](const std::string& shown) { return moments_shown(shown) > 1; });
    // The text that stays on the terminal, whose lines end with two characters.
    const std::string cleared = "\r\033[K";
    if (const std::size_t at = outcome.err.rfind(cleared); at != std::string::npos)
        outcome.err.erase(0, at + cleared.size());
    std::erase(outcome.err, '\r');
    return outcome;
}

Outcome run_on_terminal(const Words& arguments,
                        const std::function<bool(const std::string&)>& has_shown_enough) {
    Hooks hooks;
    hooks.err = Pipe::Kind::terminal;
    hooks.is_enough = [&](const Outcome& outcome) { return has_shown_enough(outcome.err); };
    return run(arguments, hooks);
}

Outcome run_on_screen(const Words& arguments, int columns) {
    Hooks hooks;
    hooks.err = hooks.out = Pipe::Kind::terminal;
    hooks.prepare = [columns] {
        const winsize size{24, static_cast<unsigned short>(columns), 0, 0};
        if (ioctl(STDOUT_FILENO, TIOCSWINSZ, &size) != 0 || unsetenv("COLUMNS") != 0) _exit(126);
    };
    Outcome outcome = run(arguments, hooks);
    std::erase(outcome.out, '\r');
    return outcome;
}

std::size_t moments_shown(const std::string& terminal) {
    const std::string begin = "\rlive ", end = " s,";
    std::set<std::string> moments;
    for (std::size_t at = 0; (at = terminal.find(begin, at)) != std::string::npos;) {
        at += begin.size();
        moments.insert(terminal.substr(at, terminal.find(end, at) - at));
    }
    return moments.size();
}

Outcome run_under_nohup(const Words& arguments) {
    Hooks hooks;
    hooks.prepare = [] { std::signal(SIGHUP, SIG_IGN); };
    hooks.meanwhile = [](pid_t child) {
        wait_until_it_minds_interrupts(child);
        kill(child, SIGHUP);
    };
    return run(arguments, hooks);
}

Outcome run_on_full_disk(const Words& arguments, int kibibytes) {
    return run_limited(arguments, RLIMIT_FSIZE, static_cast<rlim_t>(kibibytes) * 1024);
}

Outcome run_on_lossy_disk(const Words& arguments) {
    Hooks hooks;
    hooks.prepare = fail_flushes;
    return run(arguments, hooks);
}

Outcome run_in_memory(const Words& arguments, int mebibytes) {
    return run_limited(arguments, RLIMIT_AS, static_cast<rlim_t>(mebibytes) << 20);
}

Outcome run_with_threads(const Words& arguments, int threads) {
    constexpr rlim_t stack = rlim_t{1} << 30;
    Hooks hooks;
    hooks.prepare = [=] {
        const rlimit of_stack{stack, stack}, of_all{stack * static_cast<rlim_t>(threads) + stack * 9 / 10,
                                                    stack * static_cast<rlim_t>(threads) + stack * 9 / 10};
        setrlimit(RLIMIT_STACK, &of_stack);
        setrlimit(RLIMIT_AS, &of_all);
    };
    return run(arguments, hooks);
}

std::string file_contents(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

Words names_in(const fs::path& folder) {
    Words names;
    std::error_code failure;
    for (const auto& entry : fs::directory_iterator(folder, failure))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

}  // namespace touchable::test
