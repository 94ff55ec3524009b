// SPDX-License-Identifier: Apache-2.0
#include "engine/base/child_process.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

constexpr std::chrono::milliseconds child_step(10);
// From SIGTERM to SIGKILL; once this program is asked to stop it has to end within 0.2 s itself.
constexpr std::chrono::milliseconds child_grace(2000), child_grace_at_stop(100);

struct Pipe {
    Descriptor out, in;  ///< the end to read from without waiting; the end to write to
};
Result<Pipe> make_pipe() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return internal_error("no pipe can be made: " + failure_words(errno));
    Pipe made{Descriptor(ends[0]), Descriptor(ends[1])};
    ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
    return made;
}

/// Returns the null-terminated array of C strings that exec takes.
std::vector<char*> ends_with_null(std::vector<std::string>& words) {
    std::vector<char*> all;
    for (std::string& word : words) all.push_back(word.data());
    all.push_back(nullptr);
    return all;
}

/// Returns this program's environment, with variables replaced by those in `settings`.
std::vector<std::string> environment_with(const std::vector<std::string>& settings) {
    std::vector<std::string> all = settings;
    for (char** each = ::environ; *each != nullptr; ++each) {
        const std::string_view own = *each;
        const std::string_view name = own.substr(0, own.find('=') + 1);
        if (std::ranges::none_of(settings, [&](const auto& set) { return set.starts_with(name); }))
            all.emplace_back(own);
    }
    return all;
}

/// Returns 0, or the errno that says why the program cannot be started.
int spawn(std::vector<std::string>& words, std::vector<std::string>& environment, int output, int errors,
          ::pid_t& process) {
    ::posix_spawn_file_actions_t files;
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&files, errors, STDERR_FILENO);
    ::posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
    ::posix_spawnattr_t attributes;
    ::posix_spawnattr_init(&attributes);
    sigset_t none, all;
    ::sigemptyset(&none);
    ::sigfillset(&all);
    ::posix_spawnattr_setsigmask(&attributes, &none);
    ::posix_spawnattr_setsigdefault(&attributes, &all);
    ::posix_spawnattr_setflags(&attributes,
                               POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    const int failure = ::posix_spawnp(&process, words.front().c_str(), &files, &attributes,
                                       ends_with_null(words).data(), ends_with_null(environment).data());
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
    return failure;
}

void set_limit(::pid_t process, __rlimit_resource what, std::uint64_t soft, std::uint64_t hard) {
    if (soft == 0) return;
    const ::rlimit limit{soft, hard};
    // Failure is harmless: the child has ended, or it inherits a lower limit of this program.
    (void)::prlimit(process, what, &limit, nullptr);
}

}  // namespace

Result<std::unique_ptr<ChildProcess>> ChildProcess::start(std::vector<std::string> words,
                                                          const ChildLimits& limits,
                                                          const std::vector<std::string>& settings) {
    TRY_ASSIGN(auto output, make_pipe());
    TRY_ASSIGN(auto errors, make_pipe());
    constexpr int roomy = 1 << 20;
    (void)::fcntl(output.in.get(), F_SETPIPE_SZ, roomy);  // if refused, the default size stays
    std::vector<std::string> environment = environment_with(settings);
    ::pid_t process = -1;
    const int failure = spawn(words, environment, output.in.get(), errors.in.get(), process);
    if (failure == ENOENT) return std::unique_ptr<ChildProcess>();
    if (failure != 0) return input_error("cannot be started: " + failure_words(failure));
    set_limit(process, RLIMIT_AS, limits.memory_bytes, limits.memory_bytes);
    set_limit(process, RLIMIT_CPU, limits.processor_seconds, limits.processor_seconds + 1);  // first SIGXCPU
    return std::unique_ptr<ChildProcess>(
        new ChildProcess(process, std::move(output.out), std::move(errors.out)));
}

/// The id of the group is not reused until the first process has been waited for.
ChildProcess::~ChildProcess() {
    ::kill(-process_, SIGTERM);
    siginfo_t how;
    // A process of the group that still writes holds the output open.
    const auto since = std::chrono::steady_clock::now();
    while (!(has_ended(how) && output_.get() < 0) &&
           std::chrono::steady_clock::now() - since <
               (stop_requested() ? child_grace_at_stop : child_grace)) {
        std::array<std::uint8_t, 65536> unread;
        if (read(unread).value_or(0) == 0) std::this_thread::sleep_for(child_step);
    }
    ::kill(-process_, SIGKILL);
    constexpr int most_steps = 200;
    for (int k = 0; k < most_steps && ::waitpid(process_, nullptr, WNOHANG) == 0; ++k)
        std::this_thread::sleep_for(child_step);
}

std::optional<std::size_t> ChildProcess::read(std::span<std::uint8_t> into) {
    hear_errors();
    if (output_.get() < 0) return std::nullopt;
    const auto got = ::read(output_.get(), into.data(), into.size());
    if (got > 0) return static_cast<std::size_t>(got);
    if (got < 0 && would_wait(errno)) return std::size_t{0};
    output_.reset();
    return std::nullopt;
}

std::array<::pollfd, 2> ChildProcess::waits() const {
    return {::pollfd{output_.get(), POLLIN, 0}, {errors_.get(), POLLIN, 0}};
}

Result<std::string> ChildProcess::all_output(std::size_t most) {
    std::string all;
    std::array<std::uint8_t, 65536> piece;
    while (const auto got = read(piece)) {
        if (stop_requested()) return interrupted_error();
        if (*got > most - all.size()) return input_error("gives more than " + in_bytes(most));
        all.append(reinterpret_cast<const char*>(piece.data()), *got);
        if (*got > 0) continue;
        auto sources = waits();
        (void)::poll(sources.data(), sources.size(), static_cast<int>(stop_look.count()));
    }
    siginfo_t end;
    if (!wait_unless_stopped([&] { return has_ended(end); }, child_step)) return interrupted_error();
    hear_errors();
    TRY(outcome(end));
    return all;
}

std::string ChildProcess::how_it_ended() {
    constexpr int most_looks = 20;
    siginfo_t how;
    bool ended = has_ended(how);
    for (int looks = 0; !ended && looks < most_looks; ++looks) {
        std::this_thread::sleep_for(child_step);
        ended = has_ended(how);
    }
    hear_errors();
    if (!ended) return "closed its standard output" + last_words();
    const auto well = outcome(how);
    return well ? "ended" : well.error().message;
}

/// Of a child that has ended; an error unless it ended well.
Result<void> ChildProcess::outcome(const ::siginfo_t& how) const {
    const std::string status = std::to_string(how.si_status);
    if (how.si_code == CLD_EXITED)
        return how.si_status == 0 ? Result<void>()
                                  : input_error("ended with status " + status + last_words());
    if (how.si_status == SIGXCPU)
        return Error{ErrorKind::input, "used up its processor time", {}, Error::Cause::out_of_time};
    return input_error("ended by signal " + status + last_words());
}

void ChildProcess::hear_errors() {
    constexpr std::size_t most_kept = 2000;
    constexpr int most_at_once = 16;
    for (int k = 0; k < most_at_once && errors_.get() >= 0; ++k) {
        std::array<char, 4096> words;
        const auto got = ::read(errors_.get(), words.data(), words.size());
        if (got < 0 && would_wait(errno)) return;
        if (got <= 0) return errors_.reset();
        errors_said_.append(words.data(), static_cast<std::size_t>(got));
        if (errors_said_.size() > most_kept) errors_said_.erase(0, errors_said_.size() - most_kept);
    }
}

std::string ChildProcess::last_words() const {
    constexpr std::size_t longest = 500;  // two long paths and the reason
    const std::size_t end = errors_said_.find_last_not_of(" \t\r\n");
    if (end == std::string::npos) return "";
    const std::size_t before = errors_said_.find_last_of("\r\n", end);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    return ": " + printable(errors_said_.substr(begin, end + 1 - begin), longest);
}

bool ChildProcess::has_ended(siginfo_t& how) const {
    how = {};
    const int got = ::waitid(P_PID, static_cast<::id_t>(process_), &how, WEXITED | WNOHANG | WNOWAIT);
    if (got == 0) return how.si_pid == process_;
    // A program that links this library may wait for all children itself, or ignore how they end.
    how.si_code = CLD_EXITED;
    return errno == ECHILD;
}

}  // namespace touchable
