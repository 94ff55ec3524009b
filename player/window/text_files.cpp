#include "player/window/text_files.hpp"

#include <algorithm>
#include <deque>
#include <mutex>
#include <system_error>
#include <utility>

#include "engine/base/new_file.hpp"

namespace touchable {
namespace {

Result<void> write_now(const TextFiles::Text& text) {
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

}  // namespace

struct TextFiles::Files {
    /// False: it has the place of one that waits.
    bool add(Text text);
    void write_next();
    void give_up();
    void note(const Text& text, Result<void> result) {
        done.push_back({text.file, text.kind, text.clip, std::move(result)});
    }

    std::mutex mutex;
    // Guarded by it.
    std::deque<Text> waiting;  // where one lies it stays: only the thread takes it away
    bool is_writing = false;   // the first one
    std::vector<Written> done;
    bool is_given_up = false;
};

bool TextFiles::Files::add(Text text) {
    const std::lock_guard lock(mutex);
    const auto earlier = std::find_if(waiting.begin() + (is_writing ? 1 : 0), waiting.end(),
                                      [&text](const Text& waits) { return waits.file == text.file; });
    const bool is_another = earlier == waiting.end();
    if (is_another)
        waiting.push_back(std::move(text));
    else
        *earlier = std::move(text);
    return is_another;
}

void TextFiles::Files::write_next() {
    std::unique_lock lock(mutex);
    if (is_given_up) return;
    is_writing = true;
    const Text& text = waiting.front();
    lock.unlock();
    auto written = write_now(text);
    lock.lock();
    if (!is_given_up) note(text, std::move(written));
    waiting.pop_front();
    is_writing = false;
}

void TextFiles::Files::give_up() {
    const std::lock_guard lock(mutex);
    is_given_up = true;
    for (const Text& text : waiting) note(text, disk_does_not_answer(text.file));
}

TextFiles::TextFiles() : files_(std::make_shared<Files>()) {}

void TextFiles::write(Text text) {
    if (!disk_) {
        auto started = DiskWork::start("text-files", "that writes what is painted");
        if (!started.ok()) {
            const std::lock_guard lock(files_->mutex);
            return files_->note(text, started.error());
        }
        disk_ = std::move(*started);
    }
    if (files_->add(std::move(text))) disk_->give([files = files_] { files->write_next(); });
}

std::vector<TextFiles::Written> TextFiles::take() {
    const std::lock_guard lock(files_->mutex);
    return std::exchange(files_->done, {});
}

void TextFiles::finish(std::chrono::milliseconds longest) {
    if (!disk_) return;
    if (!disk_->finish(longest)) files_->give_up();
    disk_.reset();
}

}  // namespace touchable
