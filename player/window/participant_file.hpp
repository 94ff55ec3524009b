#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/result.hpp"

namespace touchable {

/// The results of one participant, a table (CSV) in the folder of the study: participant-007.partial.csv
/// while it grows, participant-007.csv once it is whole, participant-007.left.csv where the participant went
/// away. Each row is safe on the disk before the next one, so that a program that is killed, or a machine
/// that is switched off, costs the row that it was at. Nothing is ever written over. All calls wait for the
/// disk.
class ParticipantFile {
public:
    /// Of the next participant: one more than the largest number in the folder, whatever became of that one.
    /// Refused (ErrorKind::input) where no file can be made.
    static Result<ParticipantFile> create(const std::filesystem::path& folder, const std::string& header);
    ~ParticipantFile();
    ParticipantFile(ParticipantFile&& other) noexcept;
    ParticipantFile& operator=(ParticipantFile&&) = delete;

    std::size_t number() const { return number_; }
    /// Its name is safe on the disk, too: until then a machine that is switched off may lose the file.
    void secure();
    /// A row, whole, and what still waits. Where there is no room it waits for the next one, and `fault`
    /// says so.
    void add(const std::string& row);
    /// Why rows are not in the file; nothing where all are.
    const std::optional<Error>& fault() const { return fault_; }

    enum class End { finished, left };
    /// Safe on the disk, and under its last name. Refused where rows are missing, or the name is taken: then
    /// it stays what it is, partial.
    Result<void> finish(End end);

private:
    ParticipantFile(std::filesystem::path folder, std::size_t number, int out);
    std::filesystem::path named(const char* ending) const;
    void write();
    Error failed(int why) const;

    std::filesystem::path folder_;
    std::size_t number_;
    int out_;
    std::string waiting_;  // whole rows
    std::optional<Error> fault_;
};

}  // namespace touchable
