#include "engine/base/child_process.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chrono>

#include "engine/base/threads.hpp"

namespace touchable::test {
namespace {

using std::chrono::milliseconds;
constexpr std::chrono::minutes ample(2);

Result<std::string> output_of(std::vector<std::string> words, std::size_t most = 1 << 20,
                              milliseconds longest = ample, const ChildLimits& limits = {},
                              const std::vector<std::string>& settings = {}) {
    auto child = ChildProcess::start(std::move(words), limits, settings);
    if (!child) return child.error();
    if (!*child) return input_error("is not there");
    return (*child)->all_output(most, longest);
}
std::string failure_of(const Result<std::string>& output) {
    return output ? "" : output.error().message;
}
bool has_children() {
    return ::waitpid(-1, nullptr, WNOHANG) >= 0;
}

TEST(ChildProcess, GivesAllThatItWrites) {
    const auto output = output_of({"sh", "-c", "head -c 300000 /dev/zero; cat; echo end"});
    ASSERT_EQ(failure_of(output), "");
    EXPECT_EQ(output->size(), 300004U) << "standard input is empty";
    EXPECT_TRUE(output->ends_with("end\n"));
    EXPECT_FALSE(has_children());
}

TEST(ChildProcess, SaysHowItEnded) {
    EXPECT_EQ(failure_of(output_of({"sh", "-c", "echo first >&2; echo Oh no >&2; exit 3"})),
              "ended with status 3: Oh no");
    EXPECT_EQ(failure_of(output_of({"sh", "-c", "kill -9 $$"})), "ended by signal 9");
    EXPECT_EQ(failure_of(output_of({"no-such-program-here"})), "is not there");
}

TEST(ChildProcess, HasItsOwnSettings) {
    const auto output = output_of({"sh", "-c", "echo $HOME-$EXTRA"}, 100, ample, {}, {"HOME=a", "EXTRA=b"});
    ASSERT_EQ(failure_of(output), "");
    EXPECT_EQ(*output, "a-b\n");
}

TEST(ChildProcess, IsBoundedInOutput) {
    EXPECT_EQ(failure_of(output_of({"yes"}, 4096)), "gives more than 4 KiB");
    EXPECT_FALSE(has_children());
}

TEST(ChildProcess, IsBoundedInTime) {
    EXPECT_EQ(failure_of(output_of({"sleep", "1000"}, 4096, milliseconds(100))), "has not ended after 0.1 s");
    // One that writes on, one that closed its output, and one that does not hear SIGTERM.
    for (const char* lines : {"while :; do echo; sleep 0.01; done", "exec >&-; sleep 1000",
                              "trap '' TERM; while :; do sleep 0.1; done"})
        EXPECT_EQ(failure_of(output_of({"sh", "-c", lines}, 1 << 20, milliseconds(100))),
                  "has not ended after 0.1 s");
    EXPECT_FALSE(has_children());
}

TEST(ChildProcess, IsBoundedInMemoryAndProcessorTime) {
    const ChildLimits little{.memory_bytes = std::uint64_t{256} << 20, .processor_seconds = 0};
    const auto output = output_of({"sh", "-c", "sleep 0.1; dd if=/dev/zero of=/dev/null bs=1G count=1"},
                                  1 << 20, ample, little);
    EXPECT_NE(failure_of(output).find("ended with status 1: dd: memory exhausted"), std::string::npos)
        << failure_of(output);
    const ChildLimits short_time{.memory_bytes = 0, .processor_seconds = 1};
    EXPECT_EQ(failure_of(output_of({"sh", "-c", "while :; do :; done"}, 100, ample, short_time))
                  .find("ended by signal "),
              0U);
}

/// As in a program that links this library.
TEST(ChildProcess, EndsWhereTheProgramIgnoresItsChildren) {
    const auto before = std::signal(SIGCHLD, SIG_IGN);
    const auto output = output_of({"sh", "-c", "sleep 0.1; echo words"});
    std::signal(SIGCHLD, before);
    ASSERT_EQ(failure_of(output), "");
    EXPECT_EQ(*output, "words\n");
}

TEST(ChildProcess, AStopEndsItsOutput) {
    auto child = ChildProcess::start({"sleep", "1000"});
    ASSERT_TRUE(child);
    ASSERT_TRUE(*child);
    const auto output = work_until(std::chrono::steady_clock::now() + milliseconds(50),
                                   [&] { return (*child)->all_output(100, ample); });
    ASSERT_FALSE(output);
    EXPECT_EQ(output.error().kind, ErrorKind::interrupted);
}

}  // namespace
}  // namespace touchable::test
