#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/clip/track_writer.hpp"
#include "engine/picture/demuxer.hpp"
#include "engine/scene/frame_rate.hpp"

namespace touchable {

/// Tracks of a touchable clip in Matroska as they are stored there, for a clip of the same frames: nothing is
/// decoded or encoded, and what its coding once made of colour stays as it is.
class TrackCopy {
public:
    /// Null where they cannot be copied: the file is no Matroska, or has not all of these roles, or other
    /// programs wrote it.
    static Result<std::unique_ptr<TrackCopy>> open(const std::filesystem::path& file,
                                                   std::vector<PlaneRole> roles);

    std::size_t count() const { return streams_.size(); }
    bool has(PlaneRole role) const { return std::find(roles_.begin(), roles_.end(), role) != roles_.end(); }
    PlaneRole role(std::size_t track) const { return roles_[track]; }
    const AVStream& stream(std::size_t track) const;
    /// Frames that its pictures were taken for so far.
    std::int64_t frames(std::size_t track) const { return frames_[track]; }
    /// A track's next picture, with its BlockAddition; `packet` is null after the last.
    Result<StoredPicture> next(std::size_t track);

private:
    TrackCopy() = default;

    std::string file_;
    std::unique_ptr<Demuxer> demuxer_;
    std::vector<PlaneRole> roles_;
    std::vector<int> streams_;
    std::vector<std::int64_t> frames_;  // that each track's pictures were shown for so far
};

}  // namespace touchable
