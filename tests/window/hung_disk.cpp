#include "tests/window/hung_disk.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "engine/base/threads.hpp"

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
