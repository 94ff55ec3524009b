#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/new_file.hpp"
#include "engine/clip/clip_writer.hpp"
#include "engine/clip/frame_check.hpp"
#include "engine/clip/matroska_writer.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/reserved_output.hpp"
#include "engine/picture/stored_sound.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// A clip that FFmpeg puts into a file, whatever its container: frames are checked, sound goes along with
/// them, and what failed once is not written over.
class MuxedClipWriter : public ClipWriter {
public:
    /// Before the first frame. Refused is sound that the container cannot hold.
    Result<void> open(const std::optional<SoundPart>& sound);

    Result<void> write(const RawFrame& frame) final { return keep(write_frame(frame)); }
    bool is_full() const final { return room_.is_full(); }
    Result<std::filesystem::path> complete() final;
    Result<void> finish() override;

protected:
    /// `format`: the container, as FFmpeg calls it.
    MuxedClipWriter(const std::filesystem::path& path, const SceneDescription& described,
                    const ClipStorage& storage, Existing existing, const char* format);

    /// What a container does with a frame that may be counted on (FrameCheck).
    virtual Result<void> add(const RawFrame& frame) = 0;
    /// What it held back, after the last frame.
    virtual Result<void> add_rest() { return {}; }
    /// What it adds to a file that FFmpeg has ended.
    virtual Result<void> amend() { return {}; }

    Error refuse(const std::string& what) const;
    /// An error where FFmpeg's status is one, or the file could not be written.
    Result<void> check_status(int status) const;
    /// The scene as the clip says it: its frames are here now.
    SceneDescription to_be_said() const;
    /// Of the file: its rate, and that it is a clip of ours, of this version.
    void add_tags(int version);
    /// The stream after those of the pictures, where there is sound.
    Result<void> add_sound_stream();
    Result<void> write_header(AVDictionary* options = nullptr);
    /// What is heard up to then, into that stream.
    Result<void> write_sound(std::int64_t until_ms);
    /// A packet of a picture, its times in `tick`.
    Result<void> write_picture(AVPacket& packet, std::size_t stream, AVRational tick);
    /// When a frame is shown, to the nearest millisecond.
    std::int64_t time_ms(std::int64_t frame) const;

    const Scene scene_;
    const Unstated unstated_;
    const ClipStorage storage_;
    FrameCheck check_;
    NewFile output_;
    ReservedOutput room_;
    struct MuxerCloser {
        void operator()(AVFormatContext* muxer) const { avformat_free_context(muxer); }
    };
    std::unique_ptr<AVFormatContext, MuxerCloser> muxer_;

private:
    Result<void> keep(Result<void> result);
    Result<void> write_frame(const RawFrame& frame);
    Result<void> end();
    Result<void> write_packet(AVPacket& packet, int stream, AVRational tick);

    const char* format_;
    std::unique_ptr<StoredSound> sound_;  // null: none
    int sound_stream_ = 0;
    bool over_ = false;  // complete, or failed
    bool complete_ = false;
};

/// Whatever the container: a writer of a scene that can be stored, opened.
template <class Writer>
Result<std::unique_ptr<ClipWriter>> open_clip_writer(const std::filesystem::path& path,
                                                     const SceneDescription& described,
                                                     const ClipStorage& storage, Existing existing,
                                                     const std::optional<SoundPart>& sound) {
    if (auto storable = check_storable(path, described); !storable) return storable.error();
    auto writer = std::make_unique<Writer>(path, described, storage, existing);
    if (auto opened = writer->open(sound); !opened) return opened.error();
    return std::unique_ptr<ClipWriter>(std::move(writer));
}

}  // namespace touchable
