#include "player/window/text_files.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "engine/new_file.hpp"
#include "engine/start_thread.hpp"

namespace touchable {

void TextFiles::write(Text text) {
    {
        const std::lock_guard lock(mutex_);
        const auto earlier = std::ranges::find(waiting_, text.file, &Text::file);
        if (earlier != waiting_.end())
            *earlier = std::move(text);
        else
            waiting_.push_back(std::move(text));
        is_ending_ = false;
    }
    changed_.notify_one();
    if (thread_.joinable()) return;
    auto started =
        start_thread(thread_, "text-files", "that writes what is painted", [this] { write_all(); });
    if (started.ok()) return;
    const std::lock_guard lock(mutex_);
    for (const Text& unwritten : waiting_) note(unwritten, started.error());
    waiting_.clear();
}

void TextFiles::note(const Text& text, Result<void> result) {
    done_.push_back({text.file, text.kind, text.clip, std::move(result)});
}

std::vector<TextFiles::Written> TextFiles::take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(done_, {});
}

void TextFiles::finish() {
    if (!thread_.joinable()) return;
    {
        const std::lock_guard lock(mutex_);
        is_ending_ = true;
    }
    changed_.notify_one();
    thread_.join();
}

Result<void> TextFiles::write_now(const Text& text) {
    if (text.check)
        if (auto may = text.check(text.file); !may.ok()) return may;
    std::error_code failed;
    if (text.file.has_parent_path()) std::filesystem::create_directories(text.file.parent_path(), failed);
    if (failed)
        return input_error(text.file.parent_path().string() + ": cannot be made: " + failed.message());
    NewFile file(text.file);
    if (auto usable = file.check(); !usable.ok()) return usable;
    if (auto written = file.write(text.text); !written.ok()) return written;
    return file.commit();
}

void TextFiles::write_all() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [this] { return is_ending_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        const Text text = std::move(waiting_.front());
        waiting_.pop_front();
        lock.unlock();
        auto written = write_now(text);
        lock.lock();
        note(text, std::move(written));
    }
}

}  // namespace touchable
