#pragma once

// How containers are opened: what they claim of themselves is checked, then FFmpeg reads them.
//
// end_of_boxes, end_of_riff and end_of_container find where a container ends by its own account, which need
// not be where its file does: a recorder that crashed leaves the room that it had asked for, gigabytes of
// zeros, and one that is at work goes on writing. check_matroska and check_box_tables (ffmpeg.hpp) refuse
// what FFmpeg would believe. open_input lets FFmpeg read a ByteSource by our own reads, up to that end, and
// open_flow bytes as they come. Errors are lines about the file; functions keep no state.

#include <algorithm>
#include <array>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

/// How a container is opened.
struct InputKind {
    const char* format = nullptr;  ///< as FFmpeg calls it; null: what the bytes look like, of `formats`
    const char* formats = nullptr;
    int error_recognition = 0;  ///< AV_EF_
    int most_streams = 0;       ///< 0: as many as FFmpeg allows
    std::int64_t probed = 0;    ///< bytes that are looked at to open it; 0: as many as FFmpeg likes
};

/// Lets FFmpeg see the first `end` bytes, under the name `file`. Once the program is asked to stop it is
/// given no more of them, however far it would read on (ErrorKind::interrupted). An error's words go behind
/// the name and a colon (error_at).
Result<InputPtr> open_input(std::unique_ptr<ByteSource> bytes, std::uint64_t end, const std::string& file,
                            const InputKind& kind);

/// The same of bytes as they come. What keeps them from coming is for `flow` to say, and to end.
Result<InputPtr> open_flow(std::shared_ptr<Demuxer::ByteFlow> flow, const InputKind& kind);

/// Why it reads no further with this status: what its bytes say, or FFmpeg.
Error input_failure(const AVFormatContext& container, int status);

/// Of QuickTime and MP4, behind its outermost boxes, each a length, a type and a content; nothing where one
/// is cut, with which FFmpeg is content. Record3D puts JSON behind the last box.
Result<std::optional<std::uint64_t>> end_of_boxes(ByteSource& bytes);

/// Of AVI and WAV, behind its first chunk and further ones of a large file; nothing where one is cut.
Result<std::optional<std::uint64_t>> end_of_riff(ByteSource& bytes);

/// Of any container that has sound (Matroska, QuickTime, WAV, AVI), or all of the bytes where it does not
/// tell.
Result<std::uint64_t> end_of_container(ByteSource& bytes, const std::string& file);

/// Where a segment ends: what the file has behind it is not of it.
struct MatroskaEnd {
    std::uint64_t at = 0;
    /// Otherwise it does not say how long it is, as of a stream or of a file that was never completed, and it
    /// ends with its last whole element.
    bool is_stated = true;
    /// There is a part of one more element, or the file is shorter than its segment says: it ends with its
    /// last whole element too.
    bool is_cut = false;
};

/// What FFmpeg's demuxer does not tell: whether a Matroska file is whole (its segment is as long as it says),
/// or cut behind a whole cluster (before one it is refused), and whether its headers, tags and attachments
/// are as they were written (their CRC-32, where they carry one). Clusters are skipped: decoding finds what
/// is wrong with them. Says "file: what is wrong".
Result<MatroskaEnd> check_matroska(ByteSource& bytes, const std::string& file);

/// The first `count` bytes of what is between two places of a source; beyond its end they are zero.
template <std::size_t count>
Result<std::array<std::uint8_t, count>> head_at(ByteSource& bytes, std::uint64_t at, std::uint64_t end) {
    std::array<std::uint8_t, count> head{};
    const auto some = static_cast<std::size_t>(std::min<std::uint64_t>(count, end - at));
    if (const auto read = bytes.read(at, reinterpret_cast<char*>(head.data()), some); !read)
        return read.error();
    return head;
}

}  // namespace touchable
