// SPDX-License-Identifier: Apache-2.0
// A clip whose depth holes are filled with what other frames saw there.
//
// While the camera rests (CameraRest), a BackgroundModel gathers the background of each pixel;
// HolesFromMotion fills holes with that depth. All frames are read once before the first is returned.

#include <array>
#include <cstdlib>

#include "engine/authoring/recorded_clip.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

namespace {

using Rgb = std::array<std::uint8_t, 3>;

constexpr double share_of_depth = 1.0 / 64;
constexpr std::int32_t least_tolerance = 2, most_of_codes = 8;

std::int32_t tolerance_of(const DepthCoding& coding, std::uint16_t code) {
    if (coding.valid_min == coding.valid_max) return least_tolerance;
    const auto beside = static_cast<std::uint16_t>(code < coding.valid_max ? code + 1 : code - 1);
    const double depth = coding.depth(code), step = depth - coding.depth(beside);
    const double size = step < 0 ? -step : step;
    const std::int32_t most = std::max<std::int32_t>(least_tolerance, coding.code_max / most_of_codes);
    if (!(size * most > share_of_depth * depth)) return most;
    return std::clamp(static_cast<std::int32_t>(share_of_depth * depth / size), least_tolerance, most);
}

constexpr std::int64_t least_elsewhere = 48;
constexpr std::int32_t same_level = 5 * CellPicture::per_level / 2,
                       much_other_level = 24 * CellPicture::per_level;
/// Brightness shows whether the camera moved only if one of so many cells with depth is textured.
constexpr std::size_t texture_share = 6;
constexpr std::int32_t times_much = 16;

/// Median brightness that cells gained: a change of the camera's exposure.
std::int32_t exposure_change(const CellPicture& then, const CellPicture& now) {
    std::vector<std::int32_t> gained;
    for (std::size_t k = 0; k < now.cells.size(); ++k)
        gained.push_back(now.cells[k].luma - then.cells[k].luma);
    return sorted_element(gained, gained.size() / 2);
}

constexpr std::int32_t colour_tolerance = 16;  // of 255, in each channel
constexpr std::int32_t code_parts = 256, colour_parts = 16;
constexpr std::int32_t longest_mean = 64, most_counted = 65535;  // frames
/// The least frames in which a mode that counts was seen, and divisors for the least share of frames.
constexpr std::int32_t least_seen = 3, share_with_colour = 16, share_without = 4;

Rgb colour_of(const std::array<std::uint16_t, 3>& mean) {
    Rgb rgb{};
    for (std::size_t k = 0; k < 3; ++k)
        rgb[k] = static_cast<std::uint8_t>((mean[k] + colour_parts / 2) / colour_parts);
    return rgb;
}

/// A depth camera's shadow is a narrow strip: at most this share of the picture's width.
constexpr int narrow_share = 16, least_narrow = 8;
constexpr std::size_t most_nearer = 4;
/// Without colour, a hole that is narrow in parts only is no shadow. The parts to be filled may touch the
/// rest in at most this share of the places in which they touch background.
constexpr std::size_t left_share = 4;
/// Limit of nearer pixels that look like background: 16 % in a registered recording of a person, 40 to 100 %
/// for hands whose colour is off by 24 pixels. Fewer than `least_nearer` pixels prove nothing.
constexpr double most_alike = 0.25;
constexpr std::int64_t least_nearer = 100;

Rgb colour_at(const PlaneView& colour, int x, int y) {
    const std::uint8_t* rgb = colour.row(y) + std::ptrdiff_t{3} * x;
    return {rgb[0], rgb[1], rgb[2]};
}

/// Whether both may be the same thing in the same light.
bool agree(const Rgb& a, const Rgb& b) {
    for (std::size_t k = 0; k < 3; ++k)
        if (std::abs(a[k] - b[k]) > colour_tolerance) return false;
    return true;
}

/// Compares codes of a clip's depth, by tables.
class CodedDepth {
public:
    explicit CodedDepth(const DepthCoding& coding)
        : coding_(coding), deeper_is_higher_(coding.deeper_is_higher()), tolerance_(65536) {
        for (std::int32_t code = coding.valid_min; code <= coding.valid_max; ++code) {
            const auto word = static_cast<std::uint16_t>(code);
            if (coding.is_valid(word)) tolerance_[word] = tolerance_of(coding, word);
        }
        if (coding.kind != DepthCodingKind::hue) return;
        hue_of_.resize(DepthCoding::hue_circle);
        is_known_.resize(DepthCoding::hue_circle);
    }

    const DepthCoding& coding() const { return coding_; }
    bool is_valid(std::uint16_t code) const { return tolerance_[code] != 0; }
    /// Codes by which two measurements of one surface may differ: 1/64 of the depth, at least 2, at most an
    /// eighth of all codes; 0 for invalid codes.
    std::int32_t tolerance(std::uint16_t code) const { return tolerance_[code]; }
    /// By how many codes `code` is deeper than `than`.
    std::int32_t deeper_by(std::uint16_t code, std::uint16_t than) const {
        return deeper_is_higher_ ? code - than : than - code;
    }

    /// The depth of a frame as a plane of codes, 1 channel; for hue it is made in `codes`.
    PlaneView codes_of(const RawFrame& frame, std::vector<std::uint16_t>& codes) const {
        if (coding_.kind != DepthCodingKind::hue) return frame.depth;
        const PlaneView& depth = frame.depth;
        codes.resize(pixel_count(depth.width, depth.height));
        std::uint16_t* to = codes.data();
        for (int y = 0; y < depth.height; ++y)
            for (int x = 0; x < depth.width; ++x) *to++ = stored_code(depth, coding_, x, y);
        return plane_of_codes(codes.data(), depth.width, depth.height);
    }

    /// Records a pixel for each hue seen, for `put`. `codes`: codes_of of that frame.
    void remember(const RawFrame& frame, const PlaneView& codes) {
        if (coding_.kind != DepthCodingKind::hue) return;
        for (int y = 0; y < codes.height; ++y) {
            const std::uint8_t* rgb = frame.depth.row(y);
            for (int x = 0; x < codes.width; ++x, rgb += 3) {
                const std::uint16_t code = codes.sample(x, y);
                if (code == no_hue || is_known_[code]) continue;
                is_known_[code] = true;
                hue_of_[code] = {rgb[0], rgb[1], rgb[2]};
            }
        }
    }

    /// Writes a code that was seen into pixel x, of the row of a depth plane.
    void put(std::uint16_t code, std::uint8_t* row, int x, int bytes_per_sample) const {
        if (coding_.kind == DepthCodingKind::hue)
            std::memcpy(row + std::ptrdiff_t{3} * x, hue_of_[code].data(), 3);
        else if (bytes_per_sample == 1)
            row[x] = static_cast<std::uint8_t>(code);
        else
            std::memcpy(row + std::ptrdiff_t{2} * x, &code, 2);
    }

private:
    DepthCoding coding_;
    bool deeper_is_higher_;
    std::vector<std::int32_t> tolerance_;              // of each code
    std::vector<std::array<std::uint8_t, 3>> hue_of_;  // of each hue, the first pixel that had it
    std::vector<bool> is_known_;                       // whether a pixel had it
};

/// Consecutive frames in which a camera stood where it did in the first of them.
struct Rest {
    static constexpr std::int64_t least_between_cuts = 4;  ///< frames
    std::int64_t first = 0, count = 0;
    bool begins_with_cut = true;  ///< or with the clip; otherwise the camera had moved
    bool ends_with_cut = true;

    /// Whether it proves that the camera stood still: soon between two cuts, otherwise after two seconds at
    /// 24 Hz, as a slow camera looks still for a while.
    bool is_long_enough() const {
        return count >= (begins_with_cut && ends_with_cut ? least_between_cuts : least_elsewhere);
    }
};

/// Finds where a camera rests, frame by frame. It has moved if most textured cells have another brightness
/// than in the first frame of the rest, or most cells with depth have another depth. So moving things must be
/// the smaller part of the picture.
class CameraRest {
public:
    explicit CameraRest(const CodedDepth& depth) : depth_(depth) {}
    /// Whether this frame ended a rest (`ended`); `current` goes on or begins with this frame.
    bool ends_with(CellPicture picture) {
        const std::int64_t frame = current_.first + current_.count;
        if (frame == 0 || before_.cells.size() != picture.cells.size()) {
            first_ = before_ = std::move(picture);
            ended_ = std::exchange(current_, {frame, 1, true, true});
            return frame > 0;
        }
        const Changes since_first = changes(first_, picture);
        const bool has_moved = 2 * since_first.depth > since_first.known ||
                               (texture_share * since_first.textured >= since_first.known &&
                                2 * since_first.luma > since_first.textured);
        if (has_moved) {
            const Changes at_once = changes(before_, picture);
            const bool is_cut = 2 * at_once.much_luma > at_once.all || 2 * at_once.much_depth > at_once.known;
            current_.ends_with_cut = is_cut;
            ended_ = std::exchange(current_, {frame, 1, is_cut, true});
            first_ = picture;
        } else {
            ++current_.count;
            for (std::size_t k = 0; k < first_.cells.size(); ++k)
                if (first_.cells[k].depth == CellPicture::none)
                    first_.cells[k].depth = picture.cells[k].depth;
        }
        before_ = std::move(picture);
        return has_moved;
    }

    const Rest& ended() const { return ended_; }
    const Rest& current() const { return current_; }

private:
    /// How many cells changed from one picture to another.
    struct Changes {
        std::size_t known = 0, depth = 0, much_depth = 0;  // with depth in both
        std::size_t all = 0, luma = 0, textured = 0, much_luma = 0;
    };
    Changes changes(const CellPicture& then, const CellPicture& now) const {
        Changes changes;
        const bool has_colour = then.has_colour && now.has_colour;
        const std::int32_t gain = has_colour ? exposure_change(then, now) : 0;
        for (std::size_t k = 0; k < now.cells.size(); ++k) {
            const CellPicture::Cell &was = then.cells[k], &is = now.cells[k];
            ++changes.all;
            const std::int32_t level = has_colour ? std::abs(is.luma - was.luma - gain) : 0;
            changes.textured += was.is_textured;
            changes.luma += was.is_textured && level > same_level;
            changes.much_luma += level > much_other_level;
            if (was.depth == CellPicture::none || is.depth == CellPicture::none) continue;
            ++changes.known;
            // A quarter of a pixel's tolerance and half a code, as a cell is the mean of many pixels.
            const auto code = static_cast<std::uint16_t>(was.depth / CellPicture::per_code);
            const std::int32_t tolerance = (depth_.tolerance(code) + 2) * CellPicture::per_code / 4;
            changes.depth += std::abs(is.depth - was.depth) > tolerance;
            changes.much_depth += std::abs(is.depth - was.depth) > times_much * tolerance;
        }
        return changes;
    }

    const CodedDepth& depth_;
    CellPicture first_, before_;  // of the rest; depth missing in the first one comes from later ones
    Rest current_, ended_;
};

/// The background at a pixel.
struct BackgroundPixel {
    std::uint16_t code = 0;
    bool is_known = false;
    /// Something nearer of the same colour was there, too: colour does not tell the two apart.
    bool is_ambiguous = false;
    Rgb colour{};  ///< mean of the frames in which that depth was seen
};
using Background = std::vector<BackgroundPixel>;

/// The depths that each pixel of a resting camera had, as a few modes: bounded memory, however many frames
/// there are. Integers only; frames in their order.
class BackgroundModel {
public:
    BackgroundModel(const CodedDepth& depth, int width, int height)
        : depth_(depth), width_(width), pixels_(pixel_count(width, height)) {}
    /// `codes`: from CodedDepth::codes_of. `colour`: of the same size if all frames have it; otherwise empty.
    void add(const PlaneView& codes, const PlaneView& colour, RowBands& bands) {
        ++frames_;
        bands.for_each_band(codes.height, 1, [&](const RowBand& band) { add_rows(codes, colour, band); });
    }

    /// Returns for each pixel the deepest of its modes that was seen for long: in 1/16 of the frames, without
    /// colour in a quarter, as then a passing thing may look like background. Then begins anew.
    Background finish(bool has_colour) {
        const std::int32_t least =
            std::clamp(frames_ / (has_colour ? share_with_colour : share_without), least_seen, most_counted);
        Background background;
        background.reserve(pixels_.size());
        for (const Modes& modes : pixels_) background.push_back(behind(modes, least, has_colour));
        begin();
        return background;
    }

    /// Forgets all frames.
    void begin() {
        std::fill(pixels_.begin(), pixels_.end(), Modes{});
        frames_ = 0;
    }

private:
    struct Mode {
        std::int32_t mean = 0;                  // 1/256 of a code
        std::uint16_t code = 0;                 // the seen code nearest to the mean
        std::uint16_t count = 0;                // at most 65535; 0: no mode
        std::array<std::uint16_t, 3> colour{};  // mean, sixteenths
    };
    using Modes = std::array<Mode, 3>;

    void add_rows(const PlaneView& codes, const PlaneView& colour, const RowBand& band) {
        for (int y = band.first; y < band.last; ++y) {
            Modes* modes = pixels_.data() + std::ptrdiff_t{y} * width_;
            const std::uint8_t* rgb = colour.empty() ? nullptr : colour.row(y);
            for (int x = 0; x < width_; ++x, ++modes) {
                const std::uint16_t code = codes.sample(x, y);
                if (depth_.is_valid(code)) see(*modes, code, rgb ? rgb + std::ptrdiff_t{3} * x : nullptr);
            }
        }
    }

    /// Moves the mode of the sample's depth and colour towards it; a sample without a mode replaces the mode
    /// seen least. (A hand that rests on a table is nearly as deep, and must not draw the table to it.)
    void see(Modes& modes, std::uint16_t code, const std::uint8_t* rgb) const {
        const std::int32_t exact = code * code_parts, tolerance = depth_.tolerance(code) * code_parts;
        const auto may_be = [&](const Mode& mode) {
            return mode.count > 0 && std::abs(exact - mode.mean) <= tolerance &&
                   (!rgb || agree({rgb[0], rgb[1], rgb[2]}, colour_of(mode.colour)));
        };
        Mode* nearest = nullptr;
        for (Mode& mode : modes)
            if (may_be(mode) && (!nearest || std::abs(exact - mode.mean) < std::abs(exact - nearest->mean)))
                nearest = &mode;
        if (!nearest) {
            nearest = &*std::ranges::min_element(modes, {}, &Mode::count);
            *nearest = {exact, code, 0, {}};
        }
        Mode& mode = *nearest;
        if (mode.count < most_counted) ++mode.count;
        const std::int32_t frames = std::min<std::int32_t>(mode.count, longest_mean);
        mode.mean += (exact - mode.mean) / frames;
        if (std::abs(exact - mode.mean) <= std::abs(mode.code * code_parts - mode.mean)) mode.code = code;
        if (!rgb) return;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int32_t now = rgb[k] * colour_parts, mean = mode.colour[k];
            mode.colour[k] = static_cast<std::uint16_t>(mean + (now - mean) / frames);
        }
    }

    BackgroundPixel behind(const Modes& modes, std::int32_t least, bool has_colour) const {
        const Mode* chosen = nullptr;
        for (const Mode& mode : modes)
            if (mode.count >= least && (!chosen || depth_.deeper_by(mode.code, chosen->code) > 0))
                chosen = &mode;
        if (!chosen) return {};
        // Noise and shades may have made several modes of one surface: then take the most frequent.
        const Mode deepest = *chosen;
        const auto is_apart = [&](const Mode& mode) {
            return std::abs(mode.code - deepest.code) > 2 * depth_.tolerance(deepest.code);
        };
        for (const Mode& mode : modes)
            if (mode.count > chosen->count && !is_apart(mode)) chosen = &mode;
        BackgroundPixel pixel{chosen->code, true, false, colour_of(chosen->colour)};
        for (const Mode& mode : modes)
            if (has_colour && mode.count >= least_seen && is_apart(mode) &&
                agree(colour_of(mode.colour), pixel.colour))
                pixel.is_ambiguous = true;
        return pixel;
    }

    const CodedDepth& depth_;
    int width_;
    std::vector<Modes> pixels_;
    std::int32_t frames_ = 0;
};

/// Fills holes of a frame with the background's depth, if the hole shows the background:
/// - the pixel has the background's colour, and so have most pixels beside it; without colour, or if colour
///   cannot tell, the hole is narrow in its row or column and has background at an end of that;
/// - and of the depths around touching pixels of this kind, at most four times as many are nearer than the
///   background as are background: a hole inside a hand is the hand's;
/// - and, without colour, narrow parts are hardly ever parts of a hole that is not narrow.
class HolesFromMotion {
public:
    explicit HolesFromMotion(const CodedDepth& depth) : depth_(depth) {}
    /// Replaces the frame's depth plane and marks the filled pixels in `filled`; leaves a frame without any
    /// as it was.
    void fill(RawFrame& frame, const Background& background, bool uses_colour) {
        filled_ = 0;
        const bool has_colour =
            frame.colour.width == frame.depth.width && frame.colour.height == frame.depth.height;
        const PlaneView colour = uses_colour && has_colour ? frame.colour : PlaneView{};
        find_places(depth_.codes_of(frame, hue_codes_), colour, background);
        if (holes_.empty()) return;
        find_candidates(colour, background);
        leave_those_of_nearer_things(!colour.empty());
        filled_ = static_cast<std::int64_t>(fills_.size());
        if (filled_ > 0) write(frame, background);
    }

    /// Whether colour misled in all frames so far: pixels that depth shows to be nearer often have the
    /// background's colour, because colour does not lie on depth's pixels, or both look alike.
    bool is_misled_by_colour() const {
        return nearer_ >= least_nearer &&
               static_cast<double>(nearer_but_alike_) > most_alike * static_cast<double>(nearer_);
    }

    /// Pixels of the last frame.
    std::int64_t holes() const { return static_cast<std::int64_t>(holes_.size()); }
    std::int64_t filled() const { return filled_; }

private:
    enum class Place : std::uint8_t {
        other,      // other depth, or the background is not known
        behind,     // depth of the background
        nearer,     // depth of something in front of it
        hole,       // hole that stays
        candidate,  // hole to be filled, unless its surroundings forbid it
        looked_at   // candidate whose surroundings are known
    };
    /// `colour` may be empty.
    void find_places(const PlaneView& codes, const PlaneView& colour, const Background& background) {
        width_ = codes.width;
        height_ = codes.height;
        places_.resize(background.size());
        holes_.clear();
        std::size_t pixel = 0;
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x, ++pixel) {
                const std::uint16_t code = codes.sample(x, y);
                if (!depth_.is_valid(code)) {
                    places_[pixel] = Place::hole;
                    holes_.push_back(pixel);
                    continue;
                }
                const BackgroundPixel& behind = background[pixel];
                const std::int32_t deeper = depth_.deeper_by(code, behind.code);
                const std::int32_t apart = 2 * depth_.tolerance(code);
                places_[pixel] = !behind.is_known || deeper > apart ? Place::other
                                 : deeper < -apart                  ? Place::nearer
                                                                    : Place::behind;
                if (places_[pixel] != Place::nearer || colour.empty() || behind.is_ambiguous) continue;
                ++nearer_;
                nearer_but_alike_ += agree(colour_at(colour, x, y), behind.colour);
            }
    }

    /// Whether the pixel, and the majority of the 3x3 around it, has the background's colour: a single one
    /// may look alike by chance, and at the edge of a nearer thing some are that thing's.
    bool is_coloured_as_behind(const PlaneView& colour, const Background& background,
                               std::size_t pixel) const {
        const int x = static_cast<int>(pixel) % width_, y = static_cast<int>(pixel) / width_;
        const auto agrees = [&](int u, int v) {
            return agree(colour_at(colour, u, v),
                         background[static_cast<std::size_t>(v * width_ + u)].colour);
        };
        if (!agrees(x, y)) return false;
        int alike = 0, other = 0;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height_ - 1); ++v)
            for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width_ - 1); ++u)
                if (background[static_cast<std::size_t>(v * width_ + u)].is_known)
                    ++(agrees(u, v) ? alike : other);
        return alike > other;
    }

    void find_candidates(const PlaneView& colour, const Background& background) {
        for (const std::size_t pixel : holes_) {
            const BackgroundPixel& behind = background[pixel];
            if (!behind.is_known) continue;
            const bool has_its_colour = colour.empty() || is_coloured_as_behind(colour, background, pixel);
            const bool colour_tells = !colour.empty() && !behind.is_ambiguous;
            if (has_its_colour && (colour_tells || is_beside_what_is_behind(pixel)))
                places_[pixel] = Place::candidate;
        }
    }

    bool is_beside_what_is_behind(std::size_t pixel) const {
        const auto columns = static_cast<std::size_t>(width_);
        return has_end_behind(pixel, 1, static_cast<int>(pixel % columns), width_) ||
               has_end_behind(pixel, width_, static_cast<int>(pixel / columns), height_);
    }

    /// Whether the hole is narrow along `step` and ends at background; the pixel is number `place` there.
    bool has_end_behind(std::size_t pixel, std::ptrdiff_t step, int place, int places) const {
        const int most = std::max(least_narrow, width_ / narrow_share);
        int length = 1;
        bool any = false;
        const auto go = [&](std::ptrdiff_t by, int left) {
            for (auto at = static_cast<std::ptrdiff_t>(pixel) + by; left > 0 && length <= most;
                 --left, at += by) {
                const Place there = places_[static_cast<std::size_t>(at)];
                if (there != Place::hole && there != Place::candidate) {
                    any = any || there == Place::behind;
                    return;
                }
                ++length;
            }
        };
        go(-step, place);
        go(step, places - 1 - place);
        return any && length <= most;
    }

    /// Decides for each group of touching candidates.
    void leave_those_of_nearer_things(bool colour_tells) {
        const auto columns = static_cast<std::size_t>(width_);
        fills_.clear();
        for (const std::size_t first : holes_) {
            if (places_[first] != Place::candidate) continue;
            std::size_t behind = 0, nearer = 0, left = 0;
            group_.assign(1, first);
            places_[first] = Place::looked_at;
            const auto look = [&](std::size_t pixel) {
                Place& place = places_[pixel];
                behind += place == Place::behind;
                nearer += place == Place::nearer;
                left += place == Place::hole;
                if (place != Place::candidate) return;
                place = Place::looked_at;
                group_.push_back(pixel);
            };
            for (std::size_t k = 0; k < group_.size(); ++k) {
                const std::size_t pixel = group_[k], x = pixel % columns;
                if (x > 0) look(pixel - 1);
                if (x + 1 < columns) look(pixel + 1);
                if (pixel >= columns) look(pixel - columns);
                if (pixel + columns < places_.size()) look(pixel + columns);
            }
            const bool is_whole = colour_tells || left_share * left <= behind;
            if (behind > 0 && nearer <= most_nearer * behind && is_whole)
                fills_.insert(fills_.end(), group_.begin(), group_.end());
        }
    }

    void write(RawFrame& frame, const Background& background) {
        const PlaneView stored = frame.depth;
        Image image = packed_image(stored);
        const std::size_t row_bytes = stored.row_bytes();
        const auto columns = static_cast<std::size_t>(stored.width);
        const std::size_t words = (columns + 31) / 32;
        auto filled =
            std::make_shared<std::vector<std::uint32_t>>(words * static_cast<std::size_t>(stored.height));
        for (const std::size_t pixel : fills_) {
            const std::size_t x = pixel % columns, y = pixel / columns;
            depth_.put(background[pixel].code, image.samples.data() + y * row_bytes, static_cast<int>(x),
                       stored.bytes_per_sample);
            (*filled)[y * words + x / 32] |= 1U << (x % 32);
        }
        add_plane(frame, PlaneRole::depth, plane_from(std::move(image)));
        frame.filled = std::move(filled);
    }

    const CodedDepth& depth_;
    int width_ = 0, height_ = 0;
    std::vector<Place> places_;
    std::vector<std::size_t> holes_, fills_, group_;
    std::vector<std::uint16_t> hue_codes_;
    std::int64_t filled_ = 0;
    std::int64_t nearer_ = 0, nearer_but_alike_ = 0;  // pixels whose colour can decide
};

constexpr std::size_t most_bytes = std::size_t{512} << 20;  // of all backgrounds kept
constexpr std::int64_t measured_frames = 32, least_frames = Rest::least_between_cuts;
constexpr long pixels_per_thread = 20'000;

/// The background during a rest of the camera.
struct KnownRest {
    std::int64_t first = 0, end = 0;  // frames
    Background background;
};

/// Results of reading all frames.
struct Known {
    Known(const DepthCoding& coding, bool with_colour) : depth(coding), uses_colour(with_colour) {}
    CodedDepth depth;
    bool uses_colour;              // to find the background; rests always use it
    std::vector<KnownRest> rests;  // in the order of their frames
    std::int64_t frames = 0;       // frames that could be read
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
        RawFrame coded;  // depth of one channel, for cell_picture
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

/// Stops at a damaged frame without an error: reading the clip reports it later.
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
    Result<void> change(RawFrame& frame) override {
        const std::int64_t number = frame.number;
        for (const KnownRest& rest : known_.rests)
            if (rest.first <= number && number < rest.end)
                filling_.fill(frame, rest.background, known_.uses_colour);
        return {};
    }
    /// Keeps colour if that finds the background.
    void leave_out_colour() override {
        if (known_.rests.empty() || !known_.uses_colour) ReaderAround::leave_out_colour();
    }
    /// Measures some frames all over the clip, and learns again without colour if that misleads there. Adds a
    /// note of the result.
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
        const auto frames = [](std::int64_t count) { return counted(count, "frame"); };
        if (known_.frames < least_frames)
            return why + "it takes " + frames(least_frames) + " to tell that a camera stands still";
        if (known_.moving == known_.frames) return why + "the camera moves: the clip is left as it is";
        std::string said;
        if (holes_ == 0) {
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
        return usage_error(clip->name() +
                           ": is a live camera, of which no later frame can tell what is behind a hole");
    Known known(clip->scene().depth, true);
    TRY(learn(*clip, known));
    auto filled = std::make_unique<FilledReader>(std::move(clip), std::move(known));
    TRY(filled->prepare());
    return filled;
}

}  // namespace touchable
