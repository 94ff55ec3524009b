#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/stream_figures.hpp"
#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

struct TrackInfo {
    std::string role;           ///< "depth", "colour", "haptic", "height"
    std::string codec;          ///< as FFmpeg names it, or "t3dz", "t3d2"
    std::string pixel_format;   ///< FFmpeg's, or how samples are split
    int width = 0, height = 0;  ///< as stored, before resampling to the depth plane's size
    bool lossless = false;      ///< says who wrote it, though the codec need not be
};

/// Whether anybody looks at a clip's colour (ClipReader::leave_out_colour).
enum class Colour { wanted, left_out };

/// Reads a touchable clip frame by frame. One thread at a time, but for `interrupt`.
class ClipReader {
public:
    virtual ~ClipReader() = default;
    virtual const Scene& scene() const = 0;
    /// Filters that its description leaves open, which are off in `scene`.
    virtual UnstatedFilters unstated_filters() const { return {}; }
    /// The clip as it is to be described where it is written again: those filters stay open.
    SceneDescription described() const {
        SceneDescription described(scene());
        described.unstated.filters = unstated_filters();
        return described;
    }
    virtual const std::vector<TrackInfo>& tracks() const = 0;
    /// As the container says; nullopt where only reading would tell.
    virtual std::optional<std::int64_t> frame_count() const = 0;
    /// What a person should know beside the scene's remarks: planes resampled, far plane found in the frames,
    /// defaults assumed.
    virtual const std::vector<std::string>& notes() const = 0;
    /// The camera of each frame as it is stored, where some have another than the scene's; otherwise none.
    /// (`open_clip` gives all frames the scene's.)
    virtual std::span<const Camera> frame_cameras() const { return {}; }
    /// The next frame, whose `storage` keeps its planes; nullopt after the last. An error names file, track
    /// and frame.
    virtual Result<std::optional<RawFrame>> next() = 0;
    /// Back to the first frame.
    virtual Result<void> rewind() = 0;
    /// `next` gives this frame next: from 0 to the clip's last, or one further, the end. An error of kind
    /// usage beyond that.
    virtual Result<void> seek(std::int64_t frame);
    /// The last frame up to this one from which `seek` decodes nothing that is not wanted; 0 where every seek
    /// begins at the clip's beginning.
    virtual std::int64_t access_point(std::int64_t) const { return 0; }
    /// Nobody looks at colour: frames that are read from now on may come without it, where that saves
    /// decoding. What is stored of it is still counted, timed and checked for damage.
    virtual void leave_out_colour() {}

    // Of a live source.
    /// Frames come as they are taken: none is there before its time, and one that was missed is gone.
    virtual bool is_live() const { return false; }
    /// A run begins, and this is time 0 of its frames: from here on they come when they are taken, after
    /// those that `next` has given so far, and `seek` and `rewind` are refused. Once, while no other thread
    /// reads.
    virtual Result<void> begin(std::chrono::steady_clock::time_point) { return {}; }
    /// From any thread: a `next` that waits for its source ends with an error of kind interrupted, and so
    /// does every later one of that run.
    virtual void interrupt() {}
    /// From any thread: how long before its time a frame was taken, ns, as far as that is known of the newest
    /// frames; 0 where its time is when it was taken.
    virtual std::int64_t taken_before(std::int64_t /*frame*/) const { return 0; }
    /// Of a run of it that was kept: when a frame was taken, where its number and the rate do not tell.
    virtual std::optional<std::int64_t> taken_at(std::int64_t) const { return std::nullopt; }
    /// From any thread: what a person should know of a run so far, such as that the camera was unplugged. A
    /// source that is gone has no next frame.
    virtual std::vector<std::string> remarks() const { return {}; }

    /// Likewise, of one that comes over a network; nothing of others.
    virtual std::optional<StreamFigures> stream_figures() const { return std::nullopt; }

    /// Every file that this clip is read from: first that with its pictures, or each of them, then what lies
    /// beside it, its scene file. Nobody may write there.
    const std::vector<std::filesystem::path>& inputs() const { return inputs_; }
    /// A file that was read to open it.
    void add_input(std::filesystem::path file) { inputs_.push_back(std::move(file)); }
    /// It is read from none that is on this machine.
    void forget_inputs() { inputs_.clear(); }

private:
    std::vector<std::filesystem::path> inputs_;
};

/// The file that may have the clip's sound, that with its pictures; empty where each is a file of its own.
const std::filesystem::path& sound_file_of(const ClipReader& clip);

/// All a person should know of a clip: what was guessed or remarked of its scene, then the reader's notes.
std::vector<Remark> remarks_of(const ClipReader& clip);
/// The same in words (remark_in_words).
std::vector<std::string> clip_notes(const ClipReader& clip);

}  // namespace touchable
