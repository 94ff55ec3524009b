// Opening that is given up ends at once, though a disk does not answer.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/magic.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "engine/base/threads.hpp"
#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/kept_clips.hpp"

namespace touchable::test {
namespace {

/// As long as it lives, reads that may wait are answered so many times, and then wait for its end.
class SilentDisk {
public:
    explicit SilentDisk(int answers) {
        const std::lock_guard lock(mutex);
        left = answers;
    }
    ~SilentDisk() {
        const std::lock_guard lock(mutex);
        left.reset();
        changed.notify_all();
    }
    SilentDisk(const SilentDisk&) = delete;
    SilentDisk& operator=(const SilentDisk&) = delete;

    /// Until a read waits; false where `over` came first.
    bool await_silence(std::stop_token over) {
        std::unique_lock lock(mutex);
        return changed.wait(lock, std::move(over), [] { return left && *left < 0; });
    }

    static bool is_there() {
        const std::lock_guard lock(mutex);
        return left.has_value();
    }
    static void read() {
        std::unique_lock lock(mutex);
        if (!left || --*left >= 0) return;
        changed.notify_all();
        changed.wait(lock, [] { return !left; });
    }

private:
    static inline std::mutex mutex;
    static inline std::condition_variable_any changed;
    static inline std::optional<int> left;
};

}  // namespace
}  // namespace touchable::test

// In place of the C library's for this program: nothing is in memory already.
extern "C" ssize_t preadv2(int file, const iovec* to, int count, off_t at, int flags) {
    using touchable::test::SilentDisk;
    if (SilentDisk::is_there()) {
        if (flags == RWF_NOWAIT) {
            errno = EAGAIN;
            return -1;
        }
        SilentDisk::read();
    }
    return syscall(SYS_preadv2, file, to, count, at, 0, flags);
}
extern "C" int fstatfs(int file, struct statfs* about) noexcept {
    const auto status = static_cast<int>(syscall(SYS_fstatfs, file, about));
    if (about->f_type == TMPFS_MAGIC) about->f_type = EXT4_SUPER_MAGIC;
    return status;
}

namespace touchable::test {
namespace {

using Clock = std::chrono::steady_clock;

struct Ending {
    bool was_silent = false;
    std::chrono::duration<double> took{};  // from when it was given up
};

/// Opens a clip on a disk that falls silent after so many answers; then somebody gives it up.
Ending open_on(const std::filesystem::path& clip, int answers) {
    SilentDisk disk(answers);
    std::stop_source given_up, over;
    Clock::time_point asked;
    bool was_silent = false;
    std::thread person([&] {
        was_silent = disk.await_silence(over.get_token());
        asked = Clock::now();
        given_up.request_stop();
    });
    const auto reader = work_until(given_up.get_token(), [&] { return open_clip(clip); });
    const auto ended = Clock::now();
    over.request_stop();
    person.join();
    if (was_silent) {
        EXPECT_FALSE(reader) << "opened, though it was given up";
        EXPECT_TRUE(reader || reader.error().kind == ErrorKind::interrupted) << message(reader);
    } else {
        EXPECT_EQ(message(reader), "");
    }
    return {was_silent, ended - asked};
}

/// Wherever the disk falls silent.
void expect_given_up_at_once(const std::filesystem::path& clip) {
    std::chrono::duration<double> quickest{1e9};
    int silent = 0;
    for (int answers = 0;; ++answers) {
        SCOPED_TRACE(answers);
        const Ending ending = open_on(clip, answers);
        if (!ending.was_silent) break;
        ++silent;
        quickest = std::min(quickest, ending.took);
        ASSERT_FALSE(::testing::Test::HasFailure());
    }
    EXPECT_GT(silent, 0);
    EXPECT_LT(quickest.count(), 0.05);
}

TEST(GivenUp, FilesOfEveryKind) {
    const TemporaryFolder folder;
    for (const std::string& kept : kept_clips) {
        SCOPED_TRACE(kept);
        expect_given_up_at_once(copied_clip(kept, folder.path()));
        if (::testing::Test::HasFailure()) return;
    }
}

TEST(GivenUp, AFolder) {
    const TemporaryFolder folder;
    for (int n = 0; n < 5; ++n) {
        const auto number = std::to_string(n);
        Image depth{8, 6, 2, 1, std::vector<std::uint8_t>(96, static_cast<std::uint8_t>(3 + n))};
        Image colour{8, 6, 1, 3, std::vector<std::uint8_t>(144, static_cast<std::uint8_t>(n))};
        colour.samples.front() = 200;
        ASSERT_EQ(message(write_png(folder / ("depth_" + number + ".png"), depth.view())), "");
        ASSERT_EQ(message(write_png(folder / ("image_" + number + ".png"), colour.view())), "");
    }
    expect_given_up_at_once(folder.path());
}

TEST(GivenUp, WorkWithinWork) {
    std::stop_source around, within;
    EXPECT_FALSE(stop_requested());
    {
        const StopScope outer(around.get_token());
        {
            const StopScope inner(within.get_token());
            EXPECT_FALSE(stop_requested());
            around.request_stop();
            EXPECT_TRUE(stop_requested()) << "who gives up all gives up each part";
            const StopScope* const of_this_thread = StopScope::current();
            std::thread([&] {
                EXPECT_FALSE(stop_requested()) << "of this thread alone";
                {
                    const StopScope part(of_this_thread);
                    EXPECT_TRUE(stop_requested()) << "but for what it does a part of";
                }
                EXPECT_FALSE(stop_requested());
            }).join();
        }
        EXPECT_TRUE(stop_requested());
    }
    EXPECT_FALSE(stop_requested());
    {
        within.request_stop();
        const StopScope inner(within.get_token());
        EXPECT_TRUE(stop_requested());
    }
}

}  // namespace
}  // namespace touchable::test
