// SPDX-License-Identifier: Apache-2.0
#pragma once

// Opens containers: what they claim is checked, then FFmpeg reads them.
//
// end_of_boxes, end_of_riff and end_of_container find where a container ends by its own statement, which may
// be before the file's end: a crashed recorder leaves the room that it had reserved, gigabytes of zeros, and
// a running one goes on writing. check_matroska and check_box_tables (ffmpeg.hpp) refuse what FFmpeg would
// believe. open_input lets FFmpeg read a ByteSource by our own functions, up to that end, and open_flow bytes
// as they come. Errors are lines about the file; functions keep no state.

#include <algorithm>
#include <array>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

/// How a container is opened.
struct InputKind {
    const char* format = nullptr;  ///< FFmpeg's name; null: by the bytes, among `formats`
    const char* formats = nullptr;
    int error_recognition = 0;  ///< AV_EF_
    int most_streams = 0;       ///< 0: as many as FFmpeg allows
    std::int64_t probed = 0;    ///< bytes examined to open it; 0: FFmpeg's choice
};

/// Lets FFmpeg read the first `end` bytes, under the name `file`. Once the program is to stop, reads fail
/// (ErrorKind::interrupted). An error's words go after the name and a colon (error_at).
Result<InputPtr> open_input(std::unique_ptr<ByteSource> bytes, std::uint64_t end, const std::string& file,
                            const InputKind& kind);

/// The same for bytes as they come. `flow` must end waits and report their causes.
Result<InputPtr> open_flow(std::shared_ptr<Demuxer::ByteFlow> flow, const InputKind& kind);

/// Why reading failed with this status: its bytes' error, or FFmpeg's.
Error input_failure(const AVFormatContext& container, int status);

/// iPhone's Cinematic videos have a track of disparity: HEVC, but its sample entry is called `dish`, which
/// FFmpeg does not know.
struct DisparityTracks {
    std::vector<int> ids;                 ///< track numbers, from tkhd; empty: no such tracks
    std::vector<std::uint64_t> names_at;  ///< places of the bytes `dish`
};
/// Checks the boxes' tables (check_box_tables), and finds tracks of disparity.
Result<DisparityTracks> checked_boxes(ByteSource& bytes, std::uint64_t end);

/// End of QuickTime and MP4, after the outermost boxes, each a length, a type and a content; nullopt if one
/// is truncated, which FFmpeg would accept. Record3D puts JSON after the last box.
Result<std::optional<std::uint64_t>> end_of_boxes(ByteSource& bytes);

/// End of AVI and WAV, after the first chunk and further ones of a large file; nullopt if one is truncated.
Result<std::optional<std::uint64_t>> end_of_riff(ByteSource& bytes);

/// End of any container that has sound (Matroska, QuickTime, WAV, AVI), or of all bytes if it states none.
Result<std::uint64_t> end_of_container(ByteSource& bytes, const std::string& file);

/// Where a segment ends; what follows in the file is not part of it.
struct MatroskaEnd {
    std::uint64_t at = 0;
    /// False: no length is stated, as in a stream or a file that was never completed; it ends with its last
    /// whole element.
    bool is_stated = true;
    /// There is a part of another element, or the file is shorter than its segment states; it ends with its
    /// last whole element, too.
    bool is_cut = false;
};

/// Checks what FFmpeg's demuxer does not: whether a Matroska file is whole (its segment has its stated
/// length) or truncated after a whole cluster (before one it is refused), and the CRC-32 of its headers, tags
/// and attachments, if they have one. Clusters are skipped: decoding finds damage in them. Errors are "file:
/// what is wrong".
Result<MatroskaEnd> check_matroska(ByteSource& bytes, const std::string& file);

/// `count` bytes of a source from `at` on; beyond `end` they are zero.
template <std::size_t count>
Result<std::array<std::uint8_t, count>> head_at(ByteSource& bytes, std::uint64_t at, std::uint64_t end) {
    std::array<std::uint8_t, count> head{};
    const auto some = static_cast<std::size_t>(std::min<std::uint64_t>(count, end - at));
    if (const auto read = bytes.read(at, reinterpret_cast<char*>(head.data()), some); !read)
        return read.error();
    return head;
}

}  // namespace touchable
