// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <linux/magic.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "engine/base/files.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/words.hpp"
#include "engine/scene/scene.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

void write_file(const std::filesystem::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
}

std::string refusal_of(const std::filesystem::path& file, std::size_t largest = 1 << 20) {
    const auto read = read_given_file(file, "--list NAME", "a list", largest);
    return read ? "" : read.error().message;
}

TEST(GivenFile, RejectsSpecialFilesAtOnce) {
    const TemporaryFolder folder;
    ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
    const int socket_number = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un name{};
    name.sun_family = AF_UNIX;
    std::strncpy(name.sun_path, (folder / "socket").c_str(), sizeof name.sun_path - 1);
    ASSERT_EQ(bind(socket_number, reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
    close(socket_number);
    alarm(30);  // opening a pipe would wait for a writer
    const std::pair<std::filesystem::path, std::string> kinds[] = {
        {folder.path(), "is a folder"},
        {folder / "pipe", "is a pipe, no ordinary file"},
        {folder / "socket", "is a socket, no ordinary file"},
        {"/dev/zero", "is a device, no ordinary file"},
        {folder / "absent", "does not exist"},
        {folder / "absent" / "file", "does not exist"}};
    for (const auto& [file, why] : kinds)
        EXPECT_EQ(refusal_of(file), "--list NAME: " + why + "; expected a list");
    alarm(0);
    EXPECT_EQ(GivenFile::open(folder.path(), "NAME", "a list").error().kind, ErrorKind::input);
}

TEST(GivenFile, RejectsTooLargeFiles) {
    const TemporaryFolder folder;
    write_file(folder / "list", "some");
    EXPECT_EQ(refusal_of(folder / "list", 4), "");
    EXPECT_EQ(refusal_of(folder / "list", 3), "--list NAME: is larger than 3 bytes; expected a list");
    std::filesystem::resize_file(folder / "list", std::uintmax_t{8} << 30U);
    EXPECT_EQ(refusal_of(folder / "list"), "--list NAME: is larger than 1 MiB; expected a list");
    EXPECT_EQ(in_bytes(0) + ", " + in_bytes(1 << 16) + ", " + in_bytes(1025), "0 bytes, 64 KiB, 1025 bytes");
}

/// Bytes of which each tells where it is, nearly.
std::string telling_bytes(std::size_t count) {
    std::string bytes(count, '\0');
    for (std::size_t k = 0; k < count; ++k) bytes[k] = static_cast<char>(k % 251);
    return bytes;
}

std::string stretch(GivenFile& file, std::uint64_t at, std::size_t count) {
    std::string bytes(count, '\0');
    const auto read = file.read(at, bytes.data(), count);
    return read ? bytes : read.error().message;
}

thread_local int waiting_reads = 0;

}  // namespace
}  // namespace touchable::test

// In place of the C library's for this program: counts the reads that may wait for a disk.
extern "C" ssize_t preadv2(int file, const iovec* to, int count, off_t at, int flags) {
    touchable::test::waiting_reads += flags == RWF_NOWAIT ? 0 : 1;
    return syscall(SYS_preadv2, file, to, count, at, 0, flags);
}

namespace touchable::test {
namespace {

TEST(GivenFile, ReadsAnyPiece) {
    const TemporaryFolder folder;
    const std::string bytes = telling_bytes(300'000);
    write_file(folder / "file", bytes);
    auto file = GivenFile::open(folder / "file", "NAME", "a file");
    ASSERT_TRUE(file);
    EXPECT_EQ(file->size(), bytes.size());
    for (const auto& [at, count] :
         {std::pair{0, 3}, {2, 200'000}, {65'530, 12}, {10, 1}, {299'999, 1}, {0, 300'000}, {300'000, 0}})
        EXPECT_EQ(stretch(*file, static_cast<std::uint64_t>(at), static_cast<std::size_t>(count)),
                  bytes.substr(static_cast<std::size_t>(at), static_cast<std::size_t>(count)));
    EXPECT_EQ(stretch(*file, 299'999, 2), "is cut short");
    EXPECT_EQ(stretch(*file, ~std::uint64_t{0}, 2), "is cut short");
    EXPECT_EQ(*read_given_file(folder / "file", "NAME", "a file", bytes.size()), bytes);
    struct statfs system = {};
    ASSERT_EQ(statfs(folder.path().c_str(), &system), 0);
    if (system.f_type != TMPFS_MAGIC) {
        EXPECT_EQ(waiting_reads, 0) << "another thread waits for a disk";
    }
}

/// A recorder goes on writing; another program cuts the file.
TEST(GivenFile, KeepsSizeFromOpening) {
    const TemporaryFolder folder;
    write_file(folder / "file", telling_bytes(100'000));
    auto file = GivenFile::open(folder / "file", "NAME", "a file");
    ASSERT_TRUE(file);
    std::filesystem::resize_file(folder / "file", 200'000);
    EXPECT_EQ(file->size(), 100'000U);
    EXPECT_EQ(stretch(*file, 99'999, 2), "is cut short");
    std::filesystem::resize_file(folder / "file", 70'000);
    EXPECT_EQ(stretch(*file, 65'536, 10'000), "is cut short");
}

/// File systems of other machines do not tell what is in memory.
TEST(GivenFile, ReadsFromSlowDisks) {
    const std::string bytes = telling_bytes(200'000);
    GivenFile file(
        [&bytes](std::uint64_t at, char* to, std::size_t count, bool may_wait) -> std::ptrdiff_t {
            if (!may_wait) return at % 2 == 0 ? -EAGAIN : -EOPNOTSUPP;
            const std::size_t some = std::min(count, std::size_t{1000});
            std::memcpy(to, bytes.data() + at, some);
            return static_cast<std::ptrdiff_t>(some);
        },
        bytes.size());
    EXPECT_EQ(stretch(file, 7, 150'000), bytes.substr(7, 150'000));
}

TEST(GivenFile, ReportsDiskFaults) {
    GivenFile file([](std::uint64_t, char*, std::size_t, bool) -> std::ptrdiff_t { return -EIO; }, 10);
    EXPECT_EQ(stretch(file, 0, 10), "cannot be read: Input/output error");
}

/// Ends the process: 0 where it was interrupted.
[[noreturn]] void end_with(const Result<void>& read) {
    std::_Exit(!read && read.error().kind == ErrorKind::interrupted ? 0 : 1);
}

[[noreturn]] void stop_while_a_disk_is_waited_for() {
    alarm(60);
    std::promise<void> never;
    const auto answer = never.get_future().share();
    GivenFile file(
        [answer](std::uint64_t, char*, std::size_t count, bool may_wait) -> std::ptrdiff_t {
            if (!may_wait) return -EAGAIN;
            request_stop();
            answer.wait();
            return static_cast<std::ptrdiff_t>(count);
        },
        10);
    char bytes[10];
    end_with(file.read(0, bytes, sizeof bytes));
}

TEST(GivenFileDeathTest, LeavesHungDiskAtStop) {
    EXPECT_EXIT(stop_while_a_disk_is_waited_for(), ::testing::ExitedWithCode(0), "");
}

[[noreturn]] void stop_in_the_middle() {
    int reads = 0;
    GivenFile file(
        [&reads](std::uint64_t, char*, std::size_t, bool) -> std::ptrdiff_t {
            if (++reads == 3) request_stop();
            return 1;
        },
        std::uint64_t{8} << 30U);
    std::string bytes(1 << 20, '\0');
    const auto read = file.read(0, bytes.data(), bytes.size());
    if (reads != 3) std::_Exit(2);
    end_with(read);
}

TEST(GivenFileDeathTest, ReadsNothingAfterStop) {
    EXPECT_EXIT(stop_in_the_middle(), ::testing::ExitedWithCode(0), "");
}

[[noreturn]] void read_after_a_stop() {
    GivenFile file(
        [](std::uint64_t, char*, std::size_t count, bool) { return static_cast<std::ptrdiff_t>(count); }, 10);
    char bytes[10];
    request_stop();
    {
        const StopScope outer = StopScope::after_stop();
        { const StopScope inner = StopScope::after_stop(); }
        if (stop_requested() || !file.read(0, bytes, sizeof bytes)) std::_Exit(2);
        bool elsewhere = false;
        std::thread([&elsewhere] { elsewhere = stop_requested(); }).join();
        if (!elsewhere) std::_Exit(3);
    }
    std::_Exit(stop_requested() ? 0 : 4);
}

TEST(GivenFileDeathTest, ReadsAfterStopWithinScope) {
    EXPECT_EXIT(read_after_a_stop(), ::testing::ExitedWithCode(0), "");
}

TEST(NearestWord, HasFewestEdits) {
    const std::vector<std::string> words{"touch", "play", "plot", "info"};
    EXPECT_EQ(nearest_word("tuoch", words), "touch");
    EXPECT_EQ(nearest_word("plat", words), "play") << "the first of two";
    EXPECT_EQ(nearest_word("plott", words), "plot");
    EXPECT_EQ(nearest_word("nfo", words), "info");
    EXPECT_EQ(nearest_word("PLAY", words), "play");
}

TEST(NearestWord, NeedsAWordNearby) {
    const std::vector<std::string> words{"touch", "play"};
    EXPECT_EQ(nearest_word("convert", words), "");
    EXPECT_EQ(nearest_word("nope", std::array<std::string, 1>{"moge"}), "") << "half of it differs";
    EXPECT_EQ(nearest_word("--json", std::array<std::string, 1>{"--fov"}), "") << "dashes do not count";
    EXPECT_EQ(nearest_word("", words), "");
    EXPECT_EQ(nearest_word("p", words), "");
    EXPECT_EQ(nearest_word("--fs", std::array<std::string, 1>{"--fps"}), "") << "too short for a guess";
    EXPECT_EQ(nearest_word(std::string(1'000'000, 'x'), words), "");
    EXPECT_EQ(nearest_word("touch", {}), "");
}

TEST(Formatted, MatchesPrintfAtAnyLength) {
    EXPECT_EQ(formatted("nothing"), "nothing");
    EXPECT_EQ(formatted("%d x %.2f %% of %s", 3, 0.125, "it"), "3 x 0.12 % of it");
    const std::string many(100'000, 'x');
    EXPECT_EQ(formatted("<%s>", many.c_str()), "<" + many + ">");
}

TEST(ExactNumber, HasFewestExactDigits) {
    EXPECT_EQ(exact_number(0.1), "0.1");
    EXPECT_EQ(exact_number(0.1F), "0.1");
    EXPECT_EQ(exact_number(static_cast<double>(0.1F)), "0.10000000149011612");
    EXPECT_EQ(exact_number(100000.0), "1e+05");
    EXPECT_EQ(exact_number(100000.0, std::chars_format::general), "100000");
    EXPECT_EQ(exact_number(-12), "-12");
}

TEST(DecimalOf, RestoresWrittenNumber) {
    EXPECT_EQ(decimal_of(0.001F), 0.001);
    EXPECT_EQ(decimal_of(-3.0F), -3.0);
}

TEST(ShortNumber, KeepsDigitsOfLargeNumbers) {
    EXPECT_EQ(short_number(0.00123456), "0.001235");
    EXPECT_EQ(short_number(123456.4), "123456");
    EXPECT_EQ(short_number(1e-9, 2), "1e-09");
    EXPECT_EQ(short_number(-0.0), "0");
}

TEST(TrimmedNumber, EndsInNoZeros) {
    EXPECT_EQ(trimmed_number(12.5), "12.5");
    EXPECT_EQ(trimmed_number(100), "100");
    EXPECT_EQ(trimmed_number(0.0000004), "0");
}

TEST(Printable, KeepsOrdinaryText) {
    EXPECT_EQ(printable("depth_%04d.png"), "depth_%04d.png");
    EXPECT_EQ(printable("Größe 3 µm"), "Größe 3 µm");
    EXPECT_EQ(printable(std::string(80, 'x')), std::string(80, 'x'));
    EXPECT_EQ(in_quotes("a"), "\"a\"");
}

TEST(Printable, QuotesFilesForShell) {
    EXPECT_EQ(shell_word("clips/my-clip_1.mkv"), "clips/my-clip_1.mkv");
    EXPECT_EQ(shell_word("Größe.json"), "Größe.json");
    EXPECT_EQ(shell_word("-clip.mkv"), "./-clip.mkv");
    EXPECT_EQ(shell_word("my clip.mkv"), "'my clip.mkv'");
    for (const std::string name :
         {"my clip.mkv", "it's.mkv", "$HOME;`ls` \"x\" *?[a]~#&|<>()!.mkv", "~", "a\\b",
          "Büro Köln ä/redwood", "two\nlines's\\.mkv", "\x1b[0m", "\u009b5", "a\u202e b", "\xff.mkv", ""}) {
        const std::string command = "bash -c " + shell_word("printf %s " + shell_word(name));
        FILE* const pipe = popen(command.c_str(), "r");
        ASSERT_NE(pipe, nullptr);
        char said[200] = {};
        const std::size_t bytes = fread(said, 1, sizeof said, pipe);
        pclose(pipe);
        EXPECT_EQ(std::string(said, bytes), name) << command;
    }
}

TEST(ParsedNumber, IsPlainNumberAndNothingElse) {
    const std::pair<const char*, double> numbers[] = {
        {"0", 0}, {"-0.5", -0.5}, {".5", 0.5}, {"5.", 5}, {"1e-3", 1e-3}, {"4.9e-324", 4.9e-324}, {"0e9", 0}};
    for (const auto& [text, number] : numbers) EXPECT_EQ(parsed_number(text), number) << text;
    for (const char* text : {"", " 1", "1 ", "+1", "-+1", "--1", "0x10", "1,5", "1e400", "-1e400", "1e-400",
                             "inf", "nan", "-inf", "1e", "one", "-", "."})
        EXPECT_FALSE(parsed_number(text)) << text;
    EXPECT_TRUE(std::isinf(parsed_as<double>("-inf").value_or(0)));
    EXPECT_TRUE(std::isnan(parsed_as<double>("nan").value_or(0)));
    EXPECT_EQ(parsed_number(std::string_view("1.5 m").substr(0, 3)), 1.5);
}

TEST(Printable, EscapesControlCharacters) {
    EXPECT_EQ(printable(std::string("a\nb\r\t\0\x1b[0m\x7f", 11)), "a\\nb\\r\\t\\x00\\x1b[0m\\x7f");
    EXPECT_EQ(printable("\u009b31m"), "\\u009b31m");  // an escape sequence begins so, too
    EXPECT_EQ(printable("a\nb\tc\x1b", 80, "\n\t"), "a\nb\tc\\x1b");
}

TEST(Printable, EscapesDirectionsOfText) {
    EXPECT_EQ(printable("a\u202egpj.exe"), "a\\u202egpj.exe");
    EXPECT_EQ(printable("\u2066\u2069\u200f\u061c\u2028"), "\\u2066\\u2069\\u200f\\u061c\\u2028");
    const std::string ordinary = "שלום عربي 漢字 ‘…’ \U0001f600 \u2065\u206a\u2027\u202f";
    EXPECT_EQ(printable(ordinary), ordinary);
}

/// Names of files need not be UTF-8.
TEST(Printable, EscapesBytesOutsideUtf8) {
    EXPECT_EQ(printable("\xff\xfe\x80 \xc3"), "\\xff\\xfe\\x80 \\xc3");
    EXPECT_EQ(printable("\xc3\x28\xe2\x82"
                        "a"),
              "\\xc3(\\xe2\\x82a");
    // Longer than they have to be, a half of a pair, beyond Unicode.
    EXPECT_EQ(printable("\xc0\x9b"), "\\xc0\\x9b");
    EXPECT_EQ(printable("\xe0\x82\x9b"), "\\xe0\\x82\\x9b");
    EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");
    EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
    EXPECT_EQ(printable("\xf4\x8f\xbf\xbf"), "\xf4\x8f\xbf\xbf");
}

TEST(Printable, CutsLongTextBetweenCharacters) {
    EXPECT_EQ(printable(std::string(3'000'000, 'x')), std::string(80, 'x') + "...");
    EXPECT_EQ(printable("abcdé", 5), "abcd...");
    EXPECT_EQ(printable("abcd\n", 5), "abcd...");
    EXPECT_EQ(printable(std::string("abc\0", 4), 5), "abc...");
}

TEST(Printable, KeepsErrorsShort) {
    const std::string long_text(1'000'000, 'y');
    for (const std::string& text :
         {"{\"" + long_text, "{\"" + long_text + "\": 1}", "[\"\x1b" + long_text, "\"" + long_text + "\"",
          "{\"touchable_scene\": 1, \"name\": 3, \"" + long_text + "\": {}}"}) {
        const auto scene = parse_scene(text, "scene.json");
        ASSERT_FALSE(scene);
        EXPECT_LT(scene.error().message.size(), 500U);
        EXPECT_EQ(scene.error().message.find_first_of("\n\x1b"), std::string::npos);
    }
}

}  // namespace
}  // namespace touchable::test
