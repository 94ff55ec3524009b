#include "player/window/study_results.hpp"

#include <mutex>
#include <utility>

namespace touchable {

/// What the thread works on.
struct StudyResults::Files {
    Files(std::filesystem::path results, std::string names)
        : folder(std::move(results)), header(std::move(names)) {}

    void begin();
    void end(ParticipantFile::End how);
    /// Once more, what could not be done.
    void end_again() {
        if (ended) end(*ended);
    }
    void answer(std::optional<std::size_t> of, std::optional<Error> why);
    void tell() {
        const std::lock_guard lock(mutex);
        fault = file->fault();
    }

    const std::filesystem::path folder;
    const std::string header;
    // Of the thread alone.
    std::optional<ParticipantFile> file;
    std::optional<ParticipantFile::End> ended;  // that `file` could not be finished with

    std::mutex mutex;
    // Guarded by it.
    bool is_beginning = false;
    std::optional<std::size_t> number;
    std::optional<Error> fault;
};

void StudyResults::Files::answer(std::optional<std::size_t> of, std::optional<Error> why) {
    const std::lock_guard lock(mutex);
    is_beginning = false;
    number = of;
    fault = std::move(why);
}

void StudyResults::Files::begin() {
    end_again();
    if (ended) return answer({}, file->fault());
    auto made = ParticipantFile::create(folder, header);
    if (!made.ok()) return answer({}, made.error());
    file.emplace(std::move(*made));
    // The participant need not wait for the rest.
    answer(file->number(), {});
    file->secure();
}

void StudyResults::Files::end(ParticipantFile::End how) {
    const Result<void> done = file->finish(how);
    tell();
    ended.reset();
    if (done.ok())
        file.reset();
    else
        ended = how;
}

StudyResults::StudyResults(std::filesystem::path folder, std::string header, std::unique_ptr<DiskWork> disk)
    : files_(std::make_shared<Files>(std::move(folder), std::move(header))), disk_(std::move(disk)) {}

void StudyResults::begin() {
    {
        const std::lock_guard lock(files_->mutex);
        files_->is_beginning = true;
        files_->number.reset();
    }
    disk_->give([files = files_] { files->begin(); });
}

bool StudyResults::is_beginning() const {
    const std::lock_guard lock(files_->mutex);
    return files_->is_beginning;
}

std::optional<std::size_t> StudyResults::number() const {
    const std::lock_guard lock(files_->mutex);
    return files_->number;
}

void StudyResults::add(std::string row) {
    disk_->give([files = files_, row = std::move(row)] {
        files->file->add(row);
        files->tell();
    });
}

void StudyResults::end(ParticipantFile::End end) {
    disk_->give([files = files_, end] { files->end(end); });
}

std::optional<Error> StudyResults::fault() const {
    const std::lock_guard lock(files_->mutex);
    return files_->fault;
}

Error StudyResults::no_answer() const {
    return input_error(files_->folder.string() + ": its disk does not answer; the last answers may be lost");
}

Result<void> StudyResults::finish(std::chrono::milliseconds longest) {
    disk_->give([files = files_] { files->end_again(); });
    if (!disk_->finish(longest)) return no_answer();
    const auto missing = fault();
    return missing ? Result<void>(*missing) : Result<void>();
}

}  // namespace touchable
