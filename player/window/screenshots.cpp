#include "player/window/screenshots.hpp"

#include <utility>

#include "engine/start_thread.hpp"

namespace touchable {
namespace {

std::filesystem::path free_name() {
    for (int number = 1;; ++number) {
        std::filesystem::path file = "touchable-" + std::to_string(number) + ".png";
        std::error_code ignored;
        if (!std::filesystem::exists(file, ignored)) return file;
    }
}

Result<std::filesystem::path> write_screenshot(const Image& image, const std::filesystem::path& name,
                                               Existing existing) {
    const std::filesystem::path file = name.empty() ? free_name() : name;
    NewFile out(file, existing);
    if (auto usable = out.check(); !usable.ok()) return usable.error();
    if (auto written = write_png(out, image.view()); !written.ok()) return written.error();
    if (auto done = out.commit(); !done.ok()) return done.error();
    return file;
}

}  // namespace

Screenshots::Screenshots(Existing existing)
    : write_([existing](const Image& image, const std::filesystem::path& name) {
          return write_screenshot(image, name, existing);
      }) {}

Result<void> Screenshots::keep(Image image, std::filesystem::path name) {
    {
        const std::lock_guard lock(mutex_);
        if (waiting_.size() == most_waiting)
            return input_error("the window's picture is not kept: " + std::to_string(most_waiting) +
                               " earlier ones are still being written");
        waiting_.push_back({std::move(image), std::move(name)});
        is_ending_ = false;
    }
    changed_.notify_one();
    if (thread_.joinable()) return {};
    auto started =
        start_thread(thread_, "screenshots", "that writes pictures of the window", [this] { write_all(); });
    if (!started.ok()) waiting_.clear();
    return started;
}

std::vector<Result<std::filesystem::path>> Screenshots::take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(done_, {});
}

void Screenshots::finish() {
    if (!thread_.joinable()) return;
    {
        const std::lock_guard lock(mutex_);
        is_ending_ = true;
    }
    changed_.notify_one();
    thread_.join();
}

void Screenshots::write_all() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [this] { return is_ending_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        const Picture& picture = waiting_.front();  // where it lies it stays: only this thread takes it away
        lock.unlock();
        auto written = write_(picture.image, picture.name);
        lock.lock();
        done_.push_back(std::move(written));
        waiting_.pop_front();
    }
}

}  // namespace touchable
