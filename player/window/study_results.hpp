#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "player/window/disk_work.hpp"
#include "player/window/participant_file.hpp"

namespace touchable {

/// The results of participants, one after the other: a ParticipantFile each. A thread of their own writes
/// them, so that no call waits for the disk but `wait` and `finish`. All calls are the window's.
class StudyResults {
public:
    StudyResults(std::filesystem::path folder, std::string header, std::unique_ptr<DiskWork> disk);

    /// Asks for the file of the next participant. Where that of the one before could not be finished, that
    /// comes first.
    void begin();
    /// Whether that is not answered yet.
    bool is_beginning() const;
    /// The number of the participant whose file is there; nothing where none was asked for, or can be made.
    std::optional<std::size_t> number() const;
    void add(std::string row);
    /// The participant has finished, or left.
    void end(ParticipantFile::End end);

    /// Why answers are not kept, of what is done; nothing where all are.
    std::optional<Error> fault() const;
    /// Whether all that was asked for is done, after that long at most.
    bool wait(std::chrono::milliseconds longest) const { return disk_->wait(longest); }
    /// Once, the last call: waits, for that long at most. Refused where answers are missing.
    Result<void> finish(std::chrono::milliseconds longest);

    Error no_answer() const;

private:
    struct Files;
    const std::shared_ptr<Files> files_;
    const std::unique_ptr<DiskWork> disk_;
};

}  // namespace touchable
