#pragma once

#include <filesystem>

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
