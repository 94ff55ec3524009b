// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>
#include <nlohmann/json_fwd.hpp>

#include <csignal>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/temporary_files.hpp"

namespace touchable::test {

using Words = std::vector<std::string>;

/// Exit code and output of a run of the program `touchable`.
struct Outcome {
    int code = -1;  ///< exit code; -signal where it died of one
    std::string out, err;
    double peak_mebibytes = 0;  ///< the most memory that it had resident

    /// True for one line that begins with the program's name, as every failure has.
    bool one_line_of_error() const;
};

/// Runs it to its end.
Outcome run_touchable(const Words& arguments);
/// The same, and the test fails at the caller's line unless its exit code is 0.
Outcome succeed(const Words& arguments, const char* file = __builtin_FILE(), int line = __builtin_LINE());
/// The test fails at the caller's line unless the run has ended with `code` and one line of error, with these
/// words.
Outcome expect_failure(Outcome run, int code, const std::string& words = "",
                       const char* file = __builtin_FILE(), int line = __builtin_LINE());
Outcome expect_failure(const Words& arguments, int code, const std::string& words = "",
                       const char* file = __builtin_FILE(), int line = __builtin_LINE());

/// What a run that must succeed prints with --json, or a file holds.
nlohmann::json json_of(const Words& words, const char* file = __builtin_FILE(), int line = __builtin_LINE());
nlohmann::json json_in(const std::filesystem::path& file);

/// True where `part` stands in `text`; for EXPECT_PRED2.
bool says(const std::string& text, const std::string& part);
Words plus(Words words, const Words& more);

/// Starts it beside the test, in a process group of its own, as a shell does; its id. Its streams lead there;
/// -1: nowhere.
pid_t start_touchable(const Words& arguments, int in = -1, int out = -1, int err = -1);

/// Starts it in `folder`, for names that are relative.
Outcome run_in_folder(const Words& arguments, const std::filesystem::path& folder);

/// Starts it there and sends SIGINT once that is enough.
Outcome run_in_folder_until(const Words& arguments, const std::filesystem::path& folder,
                            const std::function<bool()>& is_enough);

/// Starts it there and, once `file` is there, stops it for 400 ms after each 10 ms (60 where it is
/// sanitized) that it computes, or a second that it waits: a machine that is busy with others.
Outcome run_in_folder_halting(const Words& arguments, const std::filesystem::path& folder,
                              const std::filesystem::path& file);

/// Puts the program into a folder as an installation does, where it finds other files of its own; its path.
std::filesystem::path install_program(const std::filesystem::path& prefix);

/// Starts it and sends SIGINT once what it has said on its error stream is enough, as is asked whenever there
/// is more of it. `program`: one that was installed; empty: as it was built.
Outcome run_until_it_says(const Words& arguments,
                          const std::function<bool(const std::string& err)>& is_enough,
                          const std::filesystem::path& program = {});

/// Starts it with a standard output whose reader has gone away.
Outcome run_unheard(const Words& arguments);

/// Starts it with standard output into a pipe that is full, and that is not read though it stays open; sends
/// SIGINT after a second where it is to be `interrupted`.
Outcome run_unread(const Words& arguments, bool interrupted = false);

/// Starts it with standard output on a disk that is full.
Outcome run_with_full_output(const Words& arguments);

/// How the program, or the file system it is on, treats files that are not complete.
enum class Unfinished { unnamed, named };

/// Starts it, sends SIGINT, or `signal`, once it has opened a file in `folder`, and waits for its end.
/// `named`: the system refuses files without names, as some file systems do.
Outcome run_interrupted(const Words& arguments, const std::filesystem::path& folder, int signal = SIGINT,
                        Unfinished files = Unfinished::unnamed);

/// Runs it where there are no files without names.
Outcome run_with_named_files(const Words& arguments);

/// Starts it, sends SIGINT once it has said something, and waits for its end.
Outcome run_interrupted_once_it_speaks(const Words& arguments);

/// Starts it, sends SIGINT as soon as it minds that, and waits for its end.
Outcome run_interrupted_at_once(const Words& arguments);

/// Starts a live session on a terminal, sends SIGINT once its line there has moved, and waits for its end.
/// `err` is what stays on the terminal.
Outcome run_interrupted_while_live(const Words& arguments);

/// Runs it with its error stream on a terminal of its own, and sends SIGINT once that has shown enough, upon
/// which it ends with exit code 130.
Outcome run_on_terminal(const Words& arguments,
                        const std::function<bool(const std::string&)>& has_shown_enough);
/// Runs it with both streams on terminals of so many columns.
Outcome run_on_screen(const Words& arguments, int columns);
/// How many moments the line of a live run has shown there.
std::size_t moments_shown(const std::string& terminal);

/// Starts it, told to ignore SIGHUP as nohup does, sends that once SIGINT would be minded, and waits for its
/// end.
Outcome run_under_nohup(const Words& arguments);

/// Runs it where no file may grow beyond `kibibytes`: a full disk, for its files but not for what it says.
Outcome run_on_full_disk(const Words& arguments, int kibibytes);

/// Runs it where no flush to the disk succeeds.
Outcome run_on_lossy_disk(const Words& arguments);

/// Runs it where it may have no more than `mebibytes` of memory, its libraries included.
Outcome run_in_memory(const Words& arguments, int mebibytes);

/// Runs it where there is memory for so many threads beside the first, whose stacks are a gibibyte.
Outcome run_with_threads(const Words& arguments, int threads);

std::string file_contents(const std::filesystem::path& file);
/// Names in a folder, hidden ones too, sorted.
Words names_in(const std::filesystem::path& folder);

}  // namespace touchable::test
