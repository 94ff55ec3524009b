
#include "engine/authoring/hole_filling.hpp"
#include "engine/authoring/recorded_clip.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"

namespace touchable {

namespace {

constexpr std::size_t most_bytes = std::size_t{512} << 20;  // of all that is kept
constexpr std::int64_t measured_frames = 32, least_frames = Rest::least_between_cuts;
constexpr long pixels_per_thread = 20'000;

/// What is behind while the camera rests.
struct KnownRest {
    std::int64_t first = 0, end = 0;  // frames
    Background background;
};

/// What reading all frames tells.
struct Known {
    Known(const DepthCoding& coding, bool with_colour) : depth(coding), uses_colour(with_colour) {}
    CodedDepth depth;
    bool uses_colour;              // to tell what is behind; where a camera rests it always tells
    std::vector<KnownRest> rests;  // in the order of their frames
    std::int64_t frames = 0;       // that could be read
    std::int64_t moving = 0;       // frames in which the camera moves
    std::int64_t forgotten = 0;    // frames of rests for which there was no memory
};

class Learning {
public:
    Learning(const Scene& scene, Known& known)
        : known_(known),
          rest_(known.depth),
          model_(known.depth, scene.width, scene.height),
          bands_(threads_for(long{scene.width} * scene.height, pixels_per_thread)) {}

    void add(const RawFrame& frame) {
        RawFrame coded;  // as cells know depth: one channel
        coded.depth = known_.depth.codes_of(frame, hue_codes_);
        known_.depth.remember(frame, coded.depth);
        if (frame.colour.width == coded.depth.width && frame.colour.height == coded.depth.height)
            coded.colour = frame.colour;
        if (rest_.ends_with(cell_picture(coded, known_.depth.coding()))) keep(rest_.ended());
        if (!known_.uses_colour) coded.colour = {};
        has_colour_ = has_colour_ && !coded.colour.empty();
        model_.add(coded.depth, coded.colour, bands_);
        ++known_.frames;
    }
    void finish() {
        if (known_.frames > 0) keep(rest_.current());
    }

private:
    void keep(const Rest& rest) {
        const std::size_t bytes =
            known_.rests.empty() ? 0 : known_.rests.front().background.size() * sizeof(BackgroundPixel);
        const bool has_memory = (known_.rests.size() + 1) * bytes <= most_bytes;
        if (rest.is_long_enough() && has_memory) {
            known_.rests.push_back({rest.first, rest.first + rest.count, model_.finish(has_colour_)});
        } else {
            (rest.is_long_enough() ? known_.forgotten : known_.moving) += rest.count;
            model_.begin();
        }
        has_colour_ = true;
    }

    Known& known_;
    CameraRest rest_;
    BackgroundModel model_;
    RowBands bands_;
    std::vector<std::uint16_t> hue_codes_;
    bool has_colour_ = true;  // of all frames of the rest
};

/// Damaged frames tell nothing, nor what comes after them: reading on tells of it.
Result<void> learn(ClipReader& clip, Known& known) {
    Learning learning(clip.scene(), known);
    while (true) {
        if (stop_requested()) return interrupted_error();
        const auto frame = clip.next();
        if (!frame && frame.error().kind == ErrorKind::interrupted) return frame.error();
        if (!frame || !*frame) break;
        learning.add(**frame);
    }
    learning.finish();
    return {};
}

std::string percent_of(double share) {
    return formatted("%.3g %%", 100 * share);
}

class FilledReader final : public ChangedClip {
public:
    FilledReader(std::unique_ptr<ClipReader> clip, Known known)
        : ChangedClip(std::move(clip)), known_(std::move(known)), filling_(known_.depth) {}
    Result<std::optional<RawFrame>> next() override {
        auto frame = ReaderAround::next();
        if (!frame || !*frame) return frame;
        const std::int64_t number = (*frame)->number;
        for (const KnownRest& rest : known_.rests)
            if (rest.first <= number && number < rest.end)
                filling_.fill(**frame, rest.background, known_.uses_colour);
        return frame;
    }
    /// It tells what is behind.
    void leave_out_colour() override {
        if (known_.rests.empty() || !known_.uses_colour) ReaderAround::leave_out_colour();
    }
    /// Looks at some frames all over the clip, and does without colour if that misleads there. Says what was
    /// found.
    Result<void> prepare() {
        TRY(measure());
        if (filling_.is_misled_by_colour()) {
            TRY(inner().rewind());
            known_ = Known(scene().depth, false);
            TRY(learn(inner(), known_));
            TRY(measure());
        }
        notes_.push_back(in_words());
        return rewind();
    }

private:
    Result<void> measure() {
        std::int64_t at_rest = 0;
        for (const KnownRest& rest : known_.rests) at_rest += rest.end - rest.first;
        const std::int64_t count = std::min(measured_frames, at_rest);
        measured_ = holes_ = filled_ = 0;
        for (std::int64_t k = 0; k < count; ++k) {
            TRY(seek(frame_at_rest(k * at_rest / count)));
            TRY(next());
            ++measured_;
            holes_ += filling_.holes();
            filled_ += filling_.filled();
        }
        return {};
    }

    std::string in_words() const {
        const std::string why = "no hole is filled from motion, because ";
        const auto frames = [](std::int64_t count) {
            return std::to_string(count) + (count == 1 ? " frame" : " frames");
        };
        if (known_.frames < least_frames)
            return why + "it takes " + frames(least_frames) + " to tell that a camera stands still";
        if (known_.moving == known_.frames) return why + "the camera moves: the clip is left as it is";
        std::string said;
        if (measured_ == 0 || holes_ == 0) {
            said = "holes are filled from frames that saw what is behind, but the " + frames(measured_) +
                   " that were measured have none";
        } else {
            const auto pixels = static_cast<double>(measured_) * scene().width * scene().height;
            said = "holes are filled from frames that saw what is behind: " +
                   percent_of(static_cast<double>(holes_) / pixels) + " of depth was holes, " +
                   percent_of(static_cast<double>(holes_ - filled_) / pixels) + " is; " +
                   std::to_string(filled_ / measured_) + " pixels a frame were filled (of " +
                   frames(measured_) + ")";
        }
        if (!known_.uses_colour)
            said +=
                "; colour is not used: where depth shows something nearer, colour often shows what is behind "
                "(it does not lie on depth's pixels, or both look alike)";
        if (known_.moving > 0)
            said += "; " + frames(known_.moving) + " of " + std::to_string(known_.frames) +
                    ", in which the camera moves, are left as they are";
        if (known_.forgotten > 0)
            said += "; " + frames(known_.forgotten) +
                    " are left as they are, as there is no memory for more shots";
        return said;
    }

    /// The nth of the frames in which the camera rests.
    std::int64_t frame_at_rest(std::int64_t n) const {
        for (const KnownRest& rest : known_.rests) {
            if (n < rest.end - rest.first) return rest.first + n;
            n -= rest.end - rest.first;
        }
        return 0;
    }

    Known known_;
    HolesFromMotion filling_;
    std::int64_t measured_ = 0, holes_ = 0, filled_ = 0;  // frames; pixels of those
};

}  // namespace

Result<std::unique_ptr<ClipReader>> with_filled_holes(std::unique_ptr<ClipReader> clip) {
    if (clip->is_live())
        return usage_error(clip->inputs().front().string() +
                           ": is a live camera, of which no later frame can tell what is behind a hole");
    Known known(clip->scene().depth, true);
    TRY(learn(*clip, known));
    auto filled = std::make_unique<FilledReader>(std::move(clip), std::move(known));
    TRY(filled->prepare());
    return filled;
}

}  // namespace touchable
