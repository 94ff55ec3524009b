// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>

#include "engine/base/threads.hpp"
#include "player/window/background_writer.hpp"
#include "player/window/long_work.hpp"
#include "player/window/window_files.hpp"
#include "tests/temporary_files.hpp"
#include "tests/window/scripted_window.hpp"
#include "tests/window/window_rig.hpp"

namespace touchable::test {

/// A disk that hangs, for one folder: as long as it lives, nothing that is made safe on the disk there
/// (fsync) comes to an end. One at a time.
class HungDisk {
public:
    explicit HungDisk(const std::filesystem::path& folder);
    /// It answers, and all that waited for it has come to its end.
    ~HungDisk();
    HungDisk(const HungDisk&) = delete;
    HungDisk& operator=(const HungDisk&) = delete;

    void answer();
    /// By how many it was waited for.
    int asked() const;
};

}  // namespace touchable::test

namespace touchable::test {
namespace {

std::mutex mutex;
std::condition_variable answered;
std::string hung_folder;  // guarded by it, as is what follows; empty: none
int asked_of_it = 0;

std::string name_of(int file) {
    std::array<char, 4096> name{};
    const std::string link = "/proc/self/fd/" + std::to_string(file);
    const ssize_t size = readlink(link.c_str(), name.data(), name.size());
    return {name.data(), size > 0 ? static_cast<std::size_t>(size) : 0};
}

void wait_for_answer(const std::string& name) {
    std::unique_lock lock(mutex);
    if (hung_folder.empty() || !name.starts_with(hung_folder)) return;
    ++asked_of_it;
    answered.wait(lock, [] { return hung_folder.empty(); });
}

}  // namespace

HungDisk::HungDisk(const std::filesystem::path& folder) {
    const std::lock_guard lock(mutex);
    hung_folder = std::filesystem::canonical(folder).string();
    asked_of_it = 0;
}

HungDisk::~HungDisk() {
    answer();
    while (abandoned_threads > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void HungDisk::answer() {
    const std::lock_guard lock(mutex);
    hung_folder.clear();
    answered.notify_all();
}

int HungDisk::asked() const {
    const std::lock_guard lock(mutex);
    return asked_of_it;
}

}  // namespace touchable::test

/// Replaces the C library's in the whole program.
extern "C" int fsync(int file) {
    touchable::test::wait_for_answer(touchable::test::name_of(file));
    return static_cast<int>(syscall(SYS_fsync, file));
}
namespace touchable::test {
namespace {

// Files that a window writes off its thread, on disks that answer, hang, or refuse.

using namespace std::chrono_literals;
namespace fs = std::filesystem;
using Late = BackgroundWriter::Late;

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

class DiskWriter : public ::testing::Test {
protected:
    /// Hangs from the first job that holds it until it answers. Jobs own it, and may outlive the test.
    struct Disk {
        std::promise<void> asked, answer;
        std::vector<std::string> begun;  // the writer's thread's, until the writer has finished
    };
    BackgroundWriter::Job job(const fs::path& file) const {
        return {.file = file, .write = [disk = disk_](const fs::path& name) -> Result<void> {
                    disk->begun.push_back(name.string());
                    return {};
                }};
    }
    BackgroundWriter::Job holding(const fs::path& file) const {
        return {.file = file, .write = [disk = disk_](const fs::path& name) -> Result<void> {
                    disk->begun.push_back(name.string());
                    disk->asked.set_value();
                    disk->answer.get_future().wait();
                    return {};
                }};
    }
    void give_holding(const fs::path& file) {
        writer_.give(holding(file));
        disk_->asked.get_future().wait();
    }
    static void wait_for_abandoned() {
        while (abandoned_threads > 0) std::this_thread::sleep_for(1ms);
    }

    const std::shared_ptr<Disk> disk_ = std::make_shared<Disk>();
    BackgroundWriter writer_{"test-writer", "files of a test", 4};
};

TEST_F(DiskWriter, KeepsOrderAndLimit) {
    give_holding("a");
    auto full = job("b");
    full.write = [write = full.write](const fs::path& name) -> Result<void> {
        EXPECT_TRUE(write(name));
        return input_error("b: the disk is full");
    };
    writer_.give(full);
    for (const char* const name : {"c", "d", "e"}) writer_.give(job(name));
    EXPECT_FALSE(writer_.wait(0ms));
    const auto refused = writer_.take();
    ASSERT_EQ(refused.size(), 1u);
    EXPECT_EQ(refused[0].file, "e");
    EXPECT_EQ(refused[0].result.error().message, "e: not written: 4 files of a test are still being written");

    disk_->answer.set_value();
    EXPECT_TRUE(writer_.finish(60s));
    EXPECT_EQ(disk_->begun, (std::vector<std::string>{"a", "b", "c", "d"}));
    const auto written = writer_.take();
    ASSERT_EQ(written.size(), 4u);
    EXPECT_TRUE(written[0].result);
    ASSERT_FALSE(written[1].result);
    EXPECT_EQ(written[1].result.error().message, "b: the disk is full");
    EXPECT_EQ(written[3].file, "d");
    EXPECT_TRUE(written[3].result);
    EXPECT_TRUE(writer_.take().empty()) << "each result comes once";
}

TEST_F(DiskWriter, DropsJobsOnHungDisk) {
    auto unnamed = holding("");
    unnamed.name = [] { return fs::path("free.png"); };
    writer_.give(unnamed);
    disk_->asked.get_future().wait();
    auto tagged = job("b");
    tagged.tag = "clip.mkv";
    writer_.give(tagged);
    writer_.give(job(""));
    EXPECT_FALSE(writer_.finish(1ms));
    const auto left = writer_.take();
    ASSERT_EQ(left.size(), 3u);
    ASSERT_FALSE(left[0].result || left[1].result || left[2].result);
    EXPECT_EQ(left[0].result.error().message,
              "free.png: not written in time: the disk hangs, or this machine is busy");
    EXPECT_EQ(left[1].result.error().message,
              "b: not written in time: the disk hangs, or this machine is busy");
    EXPECT_EQ(left[1].tag, "clip.mkv");
    EXPECT_EQ(left[2].result.error().message,
              "files of a test: not written in time: the disk hangs, or this machine is busy");
    EXPECT_EQ(abandoned_threads, 1);
    disk_->answer.set_value();
    wait_for_abandoned();
    EXPECT_EQ(disk_->begun, std::vector<std::string>{"free.png"}) << "a dropped job is not begun";
    EXPECT_TRUE(writer_.take().empty()) << "each result comes once";
    writer_.give(job("c"));
    EXPECT_TRUE(writer_.finish(60s));
    EXPECT_EQ(disk_->begun.back(), "c") << "the writer goes on";
}

TEST_F(DiskWriter, FinishesLateJobsOnRequest) {
    give_holding("a");
    writer_.give(job("b"));
    EXPECT_FALSE(writer_.finish(1ms, Late::done));
    EXPECT_FALSE(writer_.finish(1ms, Late::done));
    EXPECT_EQ(abandoned_threads, 1) << "a thread counts once";
    EXPECT_TRUE(writer_.take().empty());
    disk_->answer.set_value();
    EXPECT_TRUE(writer_.finish(60s, Late::done)) << "it was only slow";
    wait_for_abandoned();
    const auto written = writer_.take();
    ASSERT_EQ(written.size(), 2u);
    EXPECT_TRUE(written[0].result && written[1].result);
}

/// A file that says what was saved is never behind it.
TEST_F(DiskWriter, ReplacesWaitingJobOfFile) {
    const TemporaryFolder folder;
    give_holding(folder / "history");
    for (const char* text : {"old", "older"}) {
        writer_.give(text_file(folder / "history", text));
        writer_.give(text_file(folder / "saved", text));
    }
    writer_.give(text_file(folder / "history", "new"));
    disk_->answer.set_value();
    EXPECT_TRUE(writer_.finish(60s));
    const auto done = writer_.take();
    ASSERT_EQ(done.size(), 3u);
    EXPECT_EQ(done[1].file, folder / "history") << "in the place of the first one";
    EXPECT_EQ(done[2].file, folder / "saved");
    EXPECT_EQ(text_of(folder / "history"), "new");
    EXPECT_EQ(text_of(folder / "saved"), "older");
}

TEST_F(DiskWriter, KeepsAllRowsOfFile) {
    give_holding("rows");
    for (int k = 0; k < 3; ++k) writer_.give(job("rows"));
    disk_->answer.set_value();
    EXPECT_TRUE(writer_.finish(60s));
    EXPECT_EQ(writer_.take().size(), 4u) << "only a job that says so replaces another";
}

TEST_F(DiskWriter, TellsWaitingFiles) {
    const auto a = writer_.waits_for("a"), b = writer_.waits_for("b");
    EXPECT_FALSE(a());
    give_holding("a");
    writer_.give(job("b"));
    EXPECT_TRUE(a()) << "it is being written";
    EXPECT_TRUE(b());
    EXPECT_FALSE(writer_.waits_for("c")());
    disk_->answer.set_value();
    EXPECT_TRUE(writer_.finish(60s));
    EXPECT_FALSE(a() || b());
}

TEST(BackgroundWriter, FinishesInDestructor) {
    const auto written = std::make_shared<int>(0);
    {
        BackgroundWriter writer("test-writer", "files of a test");
        for (int k = 0; k < 100; ++k)
            writer.give({.file = "rows", .write = [written](const fs::path&) -> Result<void> {
                             ++*written;
                             return {};
                         }});
    }
    EXPECT_EQ(*written, 100);
}

TEST(Screenshot, ReplacesNoOtherFile) {
    const TemporaryFolder folder;
    const auto grey = [](std::uint8_t value) {
        Image image;
        image.width = 2;
        image.height = 1;
        image.samples = {value, value};
        return image;
    };
    BackgroundWriter writer("test-writer", "pictures");
    writer.give(screenshot(grey(9), folder / "a.png", Existing::keep));
    EXPECT_TRUE(writer.finish(60s));
    writer.give(screenshot(grey(5), folder / "a.png", Existing::keep));
    EXPECT_TRUE(writer.finish(60s)) << "after an end, too";
    const auto written = writer.take();
    ASSERT_EQ(written.size(), 2u);
    EXPECT_TRUE(written[0].result) << written[0].result.error().message;
    EXPECT_FALSE(written[1].result);
    const auto image = read_image(folder / "a.png");
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->samples, grey(9).samples);
}

TEST(TextFile, ReportsFailedWrites) {
    const TemporaryFolder folder;
    BackgroundWriter writer("test-writer", "texts");
    std::ofstream(folder / "file") << "x";
    writer.give(text_file(folder / "file/below.json", "a"));
    writer.give(text_file(folder / "new/folder/a.json", "b", "clip.mkv"));
    writer.give(
        text_file(folder / "file", "c", {}, [](const fs::path&) { return input_error("it is dear to me"); }));
    EXPECT_TRUE(writer.finish(60s));
    const auto done = writer.take();
    ASSERT_EQ(done.size(), 3u);
    EXPECT_FALSE(done[0].result);
    EXPECT_TRUE(done[1].result);
    EXPECT_EQ(done[1].tag, "clip.mkv");
    ASSERT_FALSE(done[2].result);
    EXPECT_EQ(done[2].result.error().message, "it is dear to me");
    EXPECT_EQ(text_of(folder / "new/folder/a.json"), "b");
    EXPECT_EQ(text_of(folder / "file"), "x");
}

class Opening : public LongWork<int> {
public:
    Opening() : LongWork("test-work", "that a test needs") {}
};

Opening::Make at_once(int value) {
    return [value]() -> Result<int> { return value; };
}
/// Until it is given up, which it says.
Opening::Make never(std::atomic<int>& begun, std::atomic<int>& given_up) {
    return [&begun, &given_up]() -> Result<int> {
        ++begun;
        while (!stop_requested()) std::this_thread::yield();
        ++given_up;
        return input_error("given up");
    };
}

std::optional<Result<int>> wait_for(Opening& opening) {
    for (int k = 0; k < 5000; ++k) {
        if (auto made = opening.take()) return made;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return std::nullopt;
}

TEST(LongWork, GivesResultOnce) {
    Opening opening;
    EXPECT_FALSE(opening.is_busy());
    EXPECT_EQ(opening.words(), "");
    opening.ask("opening seven", at_once(7));
    EXPECT_EQ(opening.words(), "opening seven");
    const auto made = wait_for(opening);
    ASSERT_TRUE(made && *made);
    EXPECT_EQ(**made, 7);
    EXPECT_FALSE(opening.is_busy());
    EXPECT_FALSE(opening.take());
}

TEST(LongWork, LatestRequestReplacesEarlier) {
    std::atomic<int> begun{0}, given_up{0}, skipped{0};
    Opening opening;
    opening.ask("the first", never(begun, given_up));
    while (begun == 0) std::this_thread::yield();
    opening.ask("the second", never(skipped, skipped));
    opening.ask("the third", at_once(3));
    EXPECT_EQ(opening.words(), "the third");
    const auto made = wait_for(opening);
    ASSERT_TRUE(made && *made);
    EXPECT_EQ(**made, 3);
    EXPECT_EQ(given_up, 1);
    EXPECT_EQ(skipped, 0) << "it was replaced before its turn";
}

TEST(LongWork, DestructorCancelsWork) {
    std::atomic<int> begun{0}, given_up{0};
    {
        Opening opening;
        opening.ask("a long work", never(begun, given_up));
        while (begun == 0) std::this_thread::yield();
        opening.ask("another", never(begun, given_up));
    }
    EXPECT_EQ(begun, 1);
    EXPECT_EQ(given_up, 1);
}

TEST(LongWork, LetGoDoesNotWait) {
    std::atomic<int> begun{0}, given_up{0};
    std::atomic<bool> may_end{false};
    Opening opening;
    // Asks late whether to stop.
    opening.ask("a long work", [&]() -> Result<int> {
        ++begun;
        while (!may_end) std::this_thread::yield();
        given_up += stop_requested() ? 1 : 0;
        return 1;
    });
    while (begun == 0) std::this_thread::yield();
    opening.let_go();
    EXPECT_FALSE(opening.is_busy());
    EXPECT_EQ(opening.words(), "");
    EXPECT_FALSE(opening.take());
    std::atomic<bool> is_alone{false};
    opening.ask("the next", [&]() -> Result<int> {
        is_alone = may_end.load();
        return 2;
    });
    EXPECT_TRUE(opening.is_busy());
    EXPECT_EQ(opening.words(), "the next");
    EXPECT_FALSE(opening.take()) << "the one before has not ended";
    may_end = true;
    const auto made = wait_for(opening);
    ASSERT_TRUE(made && *made);
    EXPECT_EQ(**made, 2);
    EXPECT_EQ(given_up, 1);
    EXPECT_TRUE(is_alone);
}

TEST(LongWork, TurnsExceptionIntoError) {
    Opening opening;
    opening.ask("opening a.mkv", []() -> Result<int> { throw std::bad_alloc(); });
    auto made = wait_for(opening);
    ASSERT_TRUE(made && !*made);
    EXPECT_EQ(made->error().message, "opening a.mkv: memory does not suffice");
    opening.ask("opening b.mkv", []() -> Result<int> { throw std::runtime_error("no such thing"); });
    made = wait_for(opening);
    ASSERT_TRUE(made && !*made);
    EXPECT_EQ(made->error().kind, ErrorKind::internal);
}

// A window is closed while a disk hangs.

using Clock = std::chrono::steady_clock;

class HungDiskWindow : public ::testing::Test {
protected:
    void SetUp() override {
        clip_ = folder_ / "clip.mkv";
        ASSERT_NO_FATAL_FAILURE(write_two_surfaces(clip_, 30));
        fake_->motion = [](std::int64_t tick) { return glm::dvec3(0, 0, tick % 200 < 100 ? 0.12 : -0.04); };
    }
    PlayOptions options(const std::string& script) {
        PlayOptions options = headless_by_cpu(clip_);
        options.seconds = 60;
        options.script = inputs_of("0 loop\n" + script);
        return options;
    }
    /// The disk hangs until the window is gone, or is not for so long that it never would be.
    Result<PlayFigures> play(const PlayOptions& options) {
        HungDisk disk(folder_.path());
        std::atomic<bool> is_gone{false}, answered_too_late{false};
        std::thread looks_on([&] {
            const auto begun = Clock::now();
            while (!is_gone && Clock::now() < begun + std::chrono::seconds(60)) {
                if (fake_->newtons > 0.1) felt_ = Clock::now();
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
            answered_too_late = !is_gone;
            disk.answer();
        });
        testing::internal::CaptureStderr();
        auto played = play_in_window(options);
        told_ = testing::internal::GetCapturedStderr();
        gone_ = Clock::now();
        asked_ = disk.asked();
        abandoned_ = abandoned_threads;
        is_gone = true;
        looks_on.join();
        EXPECT_FALSE(answered_too_late) << "the window waited for the disk";
        return played;
    }
    /// How often it was told.
    int told(const std::string& words) const {
        int count = 0;
        for (std::size_t at = 0; (at = told_.find(words, at)) != std::string::npos; ++at) ++count;
        return count;
    }

    const TemporaryFolder folder_;
    std::filesystem::path clip_;
    const std::shared_ptr<FakeHand> fake_ = std::make_shared<FakeHand>();
    Clock::time_point felt_, gone_;  // written by the thread that looks on, until it is joined
    std::string told_;
    int asked_ = 0, abandoned_ = 0;
};

TEST_F(DiskWriter, WaitsForThreadThatComputes) {
    writer_.give({.file = "a", .write = [](const auto&) -> Result<void> {
                      const auto worked_s = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
                      for (const double since = worked_s(); worked_s() - since < 1.2;) {
                      }
                      return {};
                  }});
    EXPECT_TRUE(writer_.finish(1s));
}

TEST_F(HungDiskWindow, ClosesAndNamesUnfinishedPictures) {
    const std::string a = (folder_ / "a.png").string(), b = (folder_ / "b.png").string();
    PlayOptions asked = options("0.1 key f\n1.4 screenshot " + a + "\n1.5 screenshot " + b + "\n1.6 quit\n");
    asked.hand = std::make_shared<PersistentDevice>(fake_);
    const auto played = play(asked);
    ASSERT_FALSE(played) << "without a window a lost picture is an error";
    EXPECT_EQ(played.error().kind, ErrorKind::input);
    EXPECT_EQ(played.error().message, a + ": not written in time: the disk hangs, or this machine is busy; " +
                                          b +
                                          ": not written in time: the disk hangs, or this machine is busy");
    EXPECT_GT(fake_->most_newtons, 0.1);
    EXPECT_GT(gone_ - felt_, std::chrono::milliseconds(1500)) << "there was force while the window waited";
    EXPECT_EQ(asked_, 1) << "one picture after the other";
    EXPECT_EQ(abandoned_, 1) << "the program would take apart what the thread uses";
}

TEST_F(HungDiskWindow, ClosesWithUnfinishedScreenshot) {
    PlayOptions asked = options("");
    asked.screenshot = folder_ / "a.png";
    asked.seconds = 0.5;
    const auto played = play(asked);
    ASSERT_FALSE(played);
    EXPECT_EQ(played.error().message, (folder_ / "a.png").string() +
                                          ": not written in time: the disk hangs, or this machine is busy");
    EXPECT_EQ(told_, "");
}

TEST_F(HungDiskWindow, ClosesAndNamesBrushFiles) {
    const std::string saved = (folder_ / "saved.json").string();
    PlayOptions asked =
        options("0.2 material foam\n0.3 paint 20,32\n0.4 save-materials " + saved + "\n0.5 mute\n1.5 quit\n");
    asked.brush_history = folder_ / "state";
    asked.settings_file = folder_ / "play.json";
    const auto played = play(asked);
    ASSERT_FALSE(played);
    EXPECT_EQ(played.error().message,
              saved + ": not written in time: the disk hangs, or this machine is busy");
    EXPECT_EQ(told((folder_ / "state").string()), 1) << told_;
    EXPECT_EQ(told("settings are not kept: " + (folder_ / "play.json").string()), 1) << told_;
    EXPECT_EQ(told("not written in time"), 2) << told_;
    EXPECT_EQ(asked_, 2) << "the history's disk, and that of settings";
}

TEST_F(HungDiskWindow, ClosesAndReportsLostPaint) {
    PlayOptions asked = options("0.2 material foam\n0.3 paint 20,32\n1.5 quit\n");
    asked.brush_history = folder_ / "state";
    asked.settings_file = folder_ / "play.json";
    const auto played = play(asked);
    ASSERT_TRUE(played) << played.error().message;
    EXPECT_EQ(told("not written in time"), 2) << told_;
    EXPECT_EQ(played->materials.rfind("what was painted is not saved; not all of it is in ", 0), 0U)
        << played->materials;
    EXPECT_EQ(told("touchable: warning: settings are not kept: " + (folder_ / "play.json").string() +
                   ": not written in time: the disk hangs, or this machine is busy\n"),
              1)
        << told_;
}

}  // namespace
}  // namespace touchable::test
