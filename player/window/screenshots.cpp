#include "player/window/screenshots.hpp"

#include <deque>
#include <mutex>
#include <string>
#include <system_error>
#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

fs::path free_name() {
    for (int number = 1;; ++number) {
        fs::path file = "touchable-" + std::to_string(number) + ".png";
        std::error_code ignored;
        if (!fs::exists(file, ignored)) return file;
    }
}

Result<void> write_screenshot(const Image& image, const fs::path& file, Existing existing) {
    NewFile out(file, existing);
    if (auto usable = out.check(); !usable.ok()) return usable;
    if (auto written = write_png(out, image.view()); !written.ok()) return written;
    return out.commit();
}

}  // namespace

struct Screenshots::Files {
    explicit Files(Write by) : write(std::move(by)) {}

    void write_next(const Image& image);
    void give_up();

    const Write write;
    std::mutex mutex;
    // Guarded by it.
    std::deque<fs::path> waiting;  // the first one is being written; empty: it has no name yet
    std::vector<Result<fs::path>> done;
    bool is_given_up = false;
};

void Screenshots::Files::write_next(const Image& image) {
    std::unique_lock lock(mutex);
    if (is_given_up) return;
    fs::path name = waiting.front();
    if (name.empty()) {
        lock.unlock();
        name = free_name();
        lock.lock();
        if (is_given_up) return;
        waiting.front() = name;
    }
    lock.unlock();
    const Result<void> written = write(image, name);
    lock.lock();
    if (is_given_up) return;
    done.push_back(written.ok() ? Result<fs::path>(std::move(name)) : written.error());
    waiting.pop_front();
}

void Screenshots::Files::give_up() {
    const std::lock_guard lock(mutex);
    is_given_up = true;
    for (const fs::path& name : waiting)
        done.push_back(disk_does_not_answer(name.empty() ? "the window's picture" : name));
    waiting.clear();
}

Screenshots::Screenshots(Write write) : files_(std::make_shared<Files>(std::move(write))) {}

Screenshots::Screenshots(Existing existing)
    : Screenshots([existing](const Image& image, const fs::path& name) {
          return write_screenshot(image, name, existing);
      }) {}

Result<void> Screenshots::keep(Image image, fs::path name) {
    if (!disk_) {
        TRY_ASSIGN(auto started, DiskWork::start("screenshots", "that writes pictures of the window"));
        disk_ = std::move(started);
    }
    {
        const std::lock_guard lock(files_->mutex);
        if (files_->waiting.size() == most_waiting)
            return input_error("the window's picture is not kept: " + std::to_string(most_waiting) +
                               " earlier ones are still being written");
        files_->waiting.push_back(std::move(name));
    }
    disk_->give([files = files_, image = std::move(image)] { files->write_next(image); });
    return {};
}

std::vector<Result<fs::path>> Screenshots::take() {
    const std::lock_guard lock(files_->mutex);
    return std::exchange(files_->done, {});
}

void Screenshots::finish(std::chrono::milliseconds longest) {
    if (!disk_) return;
    if (!disk_->finish(longest)) files_->give_up();
    disk_.reset();
}

}  // namespace touchable
