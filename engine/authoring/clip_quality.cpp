// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <vector>

#include "engine/authoring/recorded_clip.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/readers.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/scene/frames.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

namespace {

constexpr float silhouette = 0.05F;  // of the depth; a larger step is one
constexpr float same_surface = 0.02F;
constexpr int widest_shadow = 3 * 8;  // steps without depth that a camera leaves beside a near surface
constexpr std::int64_t fewest = 200;  // edges for a result
constexpr int least_contrast = 60;    // of 765

using RgbValues = std::array<int, 3>;

/// Largest difference of a channel.
int difference(const PlaneView& picture, int y, int x0, int x1) {
    int most = 0;
    for (int c = 0; c < 3; ++c)
        most = std::max(most, std::abs(picture.sample(x0, y, c) - picture.sample(x1, y, c)));
    return most;
}

/// Whether values vary from pixel to pixel by a few codes, unlike in areas and smooth changes.
bool is_mixed(const PlaneView& picture, int x, int y) {
    if (x < 2 || x + 2 >= picture.width) return false;
    const int left = difference(picture, y, x, x - 1), right = difference(picture, y, x, x + 1);
    const int beyond = difference(picture, y, x - 1, x + 1);
    return left > 0 && right > 0 && left <= 12 && right <= 12 && beyond < std::max(left, right);
}

/// Marks where a flat place steps by one level: pixels of one code on one side, of another on the other.
std::vector<std::uint8_t> level_steps(const CodePicture& codes, const Scene& scene) {
    std::vector<std::uint8_t> marks(codes.codes.size());
    const auto depth = [&](int code) { return scene.depth.depth(static_cast<std::uint16_t>(code)); };
    for (int y = 0; y < codes.height; ++y) {
        const int* row = codes.row(y);
        for (int x = 1; x + 2 < codes.width; ++x) {
            if (row[x] < 0 || row[x + 1] < 0 || row[x] == row[x + 1]) continue;
            if (row[x - 1] != row[x] || row[x + 2] != row[x + 1]) continue;
            const double step = std::abs(depth(row[x + 1]) - depth(row[x]));
            if (step < 1.6 * level_distance(scene, depth(row[x]))) marks[pixel_place(x, y, codes.width)] = 1;
        }
    }
    return marks;
}

Image picture_of(const RawFrame& frame, const CodePicture& codes, const Scene& scene) {
    Image image{codes.width, codes.height, 1, 3, {}};
    image.samples.reserve(codes.codes.size() * 3);
    for (int y = 0; y < codes.height; ++y)
        for (int x = 0; x < codes.width; ++x) {
            if (!frame.colour.empty()) {
                const std::uint8_t* rgb = frame.colour.row(y) + std::ptrdiff_t{3} * x;
                image.samples.insert(image.samples.end(), rgb, rgb + 3);
                continue;
            }
            const int code = codes.row(y)[x];
            const double depth = code < 0 ? 0 : scene.depth.depth(static_cast<std::uint16_t>(code));
            const double grey = code < 0 ? 0 : 255 * scene.depth.nearest_depth() / depth;
            image.samples.insert(image.samples.end(), 3, static_cast<std::uint8_t>(grey));
        }
    return image;
}

/// Compares edges of colour with edges of depth. If a near surface ends in front of a far one, its colour
/// should end at the same pixel.
class ColourEdges {
public:
    explicit ColourEdges(const Scene& scene) : coding_(scene.depth), step_(std::max(1, scene.width / 640)) {}

    /// Adds a frame with colour. `where`, unless null: pixels of edges whose colour is two steps or more away
    /// are set to 1, row by row.
    void add(const RawFrame& frame, std::vector<std::uint8_t>* where) {
        const CodePicture codes = code_picture(frame.depth, coding_);
        depths_.resize(codes.codes.size());
        std::transform(codes.codes.begin(), codes.codes.end(), depths_.begin(), [&](int code) {
            return code == CodePicture::invalid
                       ? 0.0F
                       : static_cast<float>(coding_.depth(static_cast<std::uint16_t>(code)));
        });
        for (const bool is_row : {true, false}) {
            const int lines = is_row ? codes.height : codes.width,
                      length = is_row ? codes.width : codes.height;
            for (int fixed = 0; fixed < lines; fixed += step_) {
                const Line line{&frame.colour, depths_.data(), codes.width, length, fixed, is_row};
                for (int i = 1; i + 1 < length; ++i) {
                    const float here = line.depth(i);
                    if (here == 0.0F) continue;
                    for (const int side : {1, -1}) {
                        const float beside = line.depth(i + side);
                        if (beside == 0.0F || beside > here * (1 + silhouette))
                            look(line, i, is_row ? (side > 0 ? to_right : to_left) : (side > 0 ? down : up),
                                 where);
                    }
                }
            }
        }
    }

    /// nullopt if there were too few edges.
    std::optional<ClipQuality::ColourFit> fit() const {
        ClipQuality::ColourFit fit;
        double rims = 0;
        for (const Facing facing : {to_right, to_left, down, up}) {
            fit.edges += count(facing);
            rims -= median(facing) * static_cast<double>(count(facing));
        }
        if (fit.edges < fewest) return std::nullopt;
        fit.rim = rims / static_cast<double>(fit.edges);
        fit.agreement = std::min(agreement(to_right, to_left), agreement(down, up));
        const auto shift = [&](Facing a, Facing b) -> std::optional<double> {
            if (std::min(count(a), count(b)) < fewest / 4) return std::nullopt;
            return (median(a) - median(b)) / 2;
        };
        fit.right = shift(to_right, to_left);
        fit.below = shift(down, up);
        // Edges that face one way only cannot tell a shift from a rim.
        if (fit.right && fit.below)
            fit.rim = -(median(to_right) + median(to_left) + median(down) + median(up)) / 4;
        else if (fit.right)
            fit.rim = -(median(to_right) + median(to_left)) / 2;
        else if (fit.below)
            fit.rim = -(median(down) + median(up)) / 2;
        return fit;
    }

private:
    enum Facing { to_right, to_left, down, up };  // from the near surface to the far one
    static constexpr int reach = 8;               // steps examined on either side
    static constexpr int offsets = 2 * reach + 1;

    /// One row or column of a frame.
    struct Line {
        const PlaneView* colour;
        const float* depths;  // of all pixels, 0 where invalid
        int width, length, fixed;
        bool is_row;

        std::size_t index(int i) const {
            return is_row ? pixel_place(i, fixed, width) : pixel_place(fixed, i, width);
        }
        bool has(int i) const { return i >= 0 && i < length; }
        float depth(int i) const { return depths[index(i)]; }
        RgbValues rgb(int i) const {
            RgbValues rgb;
            for (int c = 0; c < 3; ++c)
                rgb[static_cast<std::size_t>(c)] = colour->sample(is_row ? i : fixed, is_row ? fixed : i, c);
            return rgb;
        }
    };

    /// Whether an even surface ends at `at` in front of another even surface; `out` is the step away from it.
    /// The far one may begin beyond a shadow without depth.
    static bool is_silhouette(const Line& line, int at, int out) {
        const float near = line.depth(at);
        for (int k = 1; k <= reach; ++k)
            if (std::abs(line.depth(at - k * out) - near) > near * same_surface) return false;
        float far = 0;
        for (int k = 1; k <= widest_shadow && line.has(at + k * out); ++k) {
            const float depth = line.depth(at + k * out);
            if (depth == 0.0F) continue;
            if (far == 0.0F) far = depth;
            if (far <= near * (1 + silhouette)) return false;
            if (k <= reach + 1 && std::abs(depth - far) > far * same_surface) return false;
        }
        return far != 0.0F;
    }

    /// Number of steps beyond `at` where the surface's colour ends; nullopt: it cannot be determined.
    static std::optional<int> offset_of_colour(const Line& line, int at, int out) {
        const auto mean = [&](int first, int last) {
            RgbValues sum{};
            for (int k = first; k <= last; ++k) {
                const RgbValues rgb = line.rgb(at + k * out);
                for (std::size_t c = 0; c < 3; ++c) sum[c] += rgb[c];
            }
            for (int& value : sum) value /= last - first + 1;
            return sum;
        };
        const RgbValues inside = mean(-reach, 3 - reach), outside = mean(reach - 2, reach + 1);
        int contrast = 0, square = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            contrast += std::abs(outside[c] - inside[c]);
            square += (outside[c] - inside[c]) * (outside[c] - inside[c]);
        }
        if (contrast < least_contrast) return std::nullopt;
        // Counts pixels nearer to the near colour than to the far one; they must be on one side.
        int near_pixels = 0, changes = 0;
        bool was_near = true;
        for (int k = -reach; k <= reach + 1; ++k) {
            const RgbValues rgb = line.rgb(at + k * out);
            int along = 0;
            for (std::size_t c = 0; c < 3; ++c) along += (rgb[c] - inside[c]) * (outside[c] - inside[c]);
            const bool is_near = 2 * along < square;
            near_pixels += is_near ? 1 : 0;
            changes += is_near != was_near ? 1 : 0;
            was_near = is_near;
        }
        const int offset = near_pixels - (reach + 1);  // 0: the last near pixel is the surface's last
        if (changes != 1 || offset < -reach || offset > reach) return std::nullopt;
        return offset;
    }

    /// Counts an edge, if there is one, of the surface whose last pixel is at `at`.
    void look(const Line& line, int at, Facing facing, std::vector<std::uint8_t>* where) {
        const int out = facing == to_right || facing == down ? step_ : -step_;
        if (!line.has(at - reach * out) || !line.has(at + (reach + 1) * out)) return;
        if (!is_silhouette(line, at, out)) return;
        const auto offset = offset_of_colour(line, at, out);
        if (!offset) return;
        ++counts_[facing][static_cast<std::size_t>(*offset + reach)];
        if (where != nullptr && std::abs(*offset) >= 2) (*where)[line.index(at)] = 1;
    }

    std::int64_t count(Facing facing) const {
        return std::accumulate(counts_[facing].begin(), counts_[facing].end(), std::int64_t{0});
    }

    /// Interpolated between whole steps by the counts.
    double median(Facing facing) const {
        const double half = static_cast<double>(count(facing)) / 2;
        double below = 0;
        for (int k = 0; k < offsets; ++k) {
            const auto n = static_cast<double>(counts_[facing][static_cast<std::size_t>(k)]);
            if (n > 0 && below + n >= half) return (k - reach - 0.5 + (half - below) / n) * step_;
            below += n;
        }
        return 0;
    }

    /// Number of edges at most two samples away from the median.
    std::int64_t near_median(Facing facing) const {
        const int middle = static_cast<int>(std::lround(median(facing) / step_)) + reach;
        std::int64_t sum = 0;
        for (int k = std::max(0, middle - 2); k <= std::min(offsets - 1, middle + 2); ++k)
            sum += counts_[facing][static_cast<std::size_t>(k)];
        return sum;
    }

    /// Share of edges near their median; 1 if too few edges face either way.
    double agreement(Facing a, Facing b) const {
        const std::int64_t edges = count(a) + count(b);
        if (edges < fewest / 2) return 1;
        return static_cast<double>(near_median(a) + near_median(b)) / static_cast<double>(edges);
    }

    const DepthCoding coding_;
    const int step_;  // pixels from one sample of a profile to the next
    std::vector<float> depths_;
    std::array<std::array<std::int64_t, offsets>, 4> counts_{};
};

/// Looks at all frames of a clip, in order.
class FrameTimesEstimator {
public:
    void add(const RawFrame& frame) {
        ++so_far_.frames;
        if (before_) {
            const std::int64_t step = frame.time_ns - before_->time_ns;
            const double ms = static_cast<double>(step) * 1e-6;
            steps_ns_.push_back(step);
            if (ms > so_far_.longest_ms) {
                so_far_.longest_ms = ms;
                so_far_.longest_at = frame.number;
            }
            if (same_touch_planes(*before_, frame)) {
                ++same_;
                same_of_new_colour_ += same_samples(before_->colour, frame.colour) ? 0 : 1;
            } else {
                if (same_ <= ClipQuality::FrameTimes::longest_repeat && so_far_.changed > 0) {
                    so_far_.repeated += same_;
                    so_far_.of_new_colour += same_of_new_colour_;
                }
                same_ = same_of_new_colour_ = 0;
                ++so_far_.changed;
            }
        }
        before_ = frame;
    }

    ClipQuality::FrameTimes times() const {
        ClipQuality::FrameTimes times = so_far_;
        if (steps_ns_.empty()) return times;
        std::vector<std::int64_t> sorted = steps_ns_;
        const std::int64_t usual = std::max<std::int64_t>(sorted_element(sorted, sorted.size() / 2), 1);
        times.usual_ms = static_cast<double>(usual) * 1e-6;
        for (const std::int64_t step : steps_ns_) {
            if (step > usual + usual / 2) times.missing += (step + usual / 2) / usual - 1;
            if (step < usual / 4) ++times.jumps;
        }
        return times;
    }

private:
    ClipQuality::FrameTimes so_far_;
    std::optional<RawFrame> before_;
    std::vector<std::int64_t> steps_ns_;
    std::int64_t same_ = 0, same_of_new_colour_ = 0;  // since the last change
};

/// Looks at the haptic pictures of a clip.
class HapticValuesEstimator {
public:
    explicit HapticValuesEstimator(const Scene& scene) : scene_(scene) {}

    /// Adds a frame with a haptic picture. `where`, unless null: affected pixels are set to 1, row by row.
    void add(const RawFrame& frame, ClipQuality::Where::Haptic* where) {
        const std::size_t all = pixel_count(scene_.width, scene_.height);
        if (where != nullptr)
            for (auto* marks : {&where->too_stiff, &where->more_dynamic, &where->mixed})
                marks->assign(all, 0);
        std::array<HapticProperties, 256> of_code;
        for (int code = 0; code < 256; ++code) {
            const auto value = static_cast<std::uint8_t>(code);
            of_code[static_cast<std::size_t>(code)] = scene_.haptic.at(value, value, value);
        }
        std::size_t pixel = 0;
        for (int y = 0; y < scene_.height; ++y)
            for (int x = 0; x < scene_.width; ++x, ++pixel) {
                if (!scene_.depth.is_valid(stored_code(frame.depth, scene_.depth, x, y))) continue;
                const std::uint8_t* rgb = frame.haptic.row(y) + std::ptrdiff_t{3} * x;
                const double stiffness = of_code[rgb[0]].stiffness / 1000;
                const bool too_stiff = stiffness > stiffest_of_devices;
                const bool more_dynamic = of_code[rgb[2]].dynamic_friction > of_code[rgb[1]].static_friction;
                const bool mixed = is_mixed(frame.haptic, x, y);
                ++pixels_;
                stiffest_ = std::max(stiffest_, stiffness);
                too_stiff_ += too_stiff ? 1 : 0;
                more_dynamic_ += more_dynamic ? 1 : 0;
                mixed_ += mixed ? 1 : 0;
                if (where == nullptr) continue;
                where->too_stiff[pixel] = too_stiff ? 1 : 0;
                where->more_dynamic[pixel] = more_dynamic ? 1 : 0;
                where->mixed[pixel] = mixed ? 1 : 0;
            }
    }

    ClipQuality::HapticValues values() const {
        const auto share = [&](std::int64_t count) {
            return pixels_ == 0 ? 0.0 : static_cast<double>(count) / static_cast<double>(pixels_);
        };
        return {stiffest_, share(too_stiff_), share(more_dynamic_), share(mixed_)};
    }

private:
    const Scene& scene_;
    double stiffest_ = 0;
    std::int64_t pixels_ = 0, too_stiff_ = 0, more_dynamic_ = 0, mixed_ = 0;
};

/// Measures whether a whole picture's depth oscillates from frame to frame, as with networks that scale each
/// picture on its own: a finger at rest feels a pulse. If more than half of the colours change, another shot
/// begins, and the change is ignored.
class PumpingEstimator {
public:
    explicit PumpingEstimator(const DepthCoding& coding) : coding_(coding) {}

    /// Adds the next frame.
    void add(const RawFrame& frame) {
        here_.clear();
        colours_.clear();
        for (int y = every / 2; y < frame.depth.height; y += every)
            for (int x = every / 2; x < frame.depth.width; x += every) {
                const std::uint16_t code = stored_code(frame.depth, coding_, x, y);
                here_.push_back(coding_.is_valid(code) ? coding_.depth(code) : 0.0);
                if (!frame.colour.empty())
                    colours_.push_back(static_cast<std::uint8_t>(frame.colour.sample(x, y, 1)));
            }
        ratios_.clear();
        if (before_.size() == here_.size() && !is_cut())
            for (std::size_t k = 0; k < here_.size(); ++k)
                if (before_[k] > 0 && here_[k] > 0) ratios_.push_back(here_[k] / before_[k] - 1);
        std::swap(before_, here_);
        std::swap(colours_before_, colours_);
        if (ratios_.size() < 16) {
            last_change_.reset();
            return;
        }
        const double change = sorted_element(ratios_, ratios_.size() / 2);
        if (last_change_) {
            products_ += *last_change_ * change;
            ++count_;
        }
        last_change_ = change;
    }

    /// Standard deviation of the whole picture's depth, as a share of it; 0: no oscillation. Successive
    /// changes d, d' of an oscillation have the mean product -variance; a steady change has d d' > 0. nullopt
    /// with fewer than four frames.
    std::optional<double> share() const {
        if (count_ < 2) return std::nullopt;
        return std::sqrt(std::max(0.0, -products_ / static_cast<double>(count_)));
    }

private:
    bool is_cut() const {
        constexpr int another = 24;  // levels
        if (colours_.empty() || colours_.size() != colours_before_.size()) return false;
        std::size_t changed = 0;
        for (std::size_t k = 0; k < colours_.size(); ++k)
            changed += std::abs(colours_[k] - colours_before_[k]) > another ? 1 : 0;
        return 2 * changed > colours_.size();
    }

    static constexpr int every = 4;  // pixels from one sample to the next, either way

    const DepthCoding coding_;
    std::vector<double> before_, here_, ratios_;
    std::vector<std::uint8_t> colours_before_, colours_;  // green, of the same pixels; empty: no colour
    std::optional<double> last_change_;
    double products_ = 0;
    std::int64_t count_ = 0;
};

}  // namespace

Result<ClipQuality> measure_quality(ClipReader& clip, const Scene& scene,
                                    const std::function<void(std::int64_t)>& progress) {
    FrameTimesEstimator times;
    PumpingEstimator pumping(scene.depth);
    ColourEdges colour(scene);
    HapticValuesEstimator haptic(scene);
    bool has_haptic = false;
    ClipQuality quality;
    // Properties of a picture, not of its change, are measured in some frames only.
    const auto telling = telling_frames(clip.frame_count().value_or(first_frames));
    for (std::int64_t read = 0;; ++read) {
        if (stop_requested()) return interrupted_error();
        TRY_ASSIGN(const auto next, clip.next());
        if (!next) break;
        const RawFrame& frame = *next;
        times.add(frame);
        pumping.add(frame);
        if (!has_valid_pixel(frame.depth, scene.depth) && quality.blank++ == 0)
            quality.first_blank = frame.number;
        if (read == 0) {
            const CodePicture codes = code_picture(frame.depth, scene.depth);
            quality.where.picture = picture_of(frame, codes, scene);
            quality.where.level_steps = level_steps(codes, scene);
            quality.where.colour_edges.assign(codes.codes.size(), 0);
        }
        if (std::binary_search(telling.begin(), telling.end(), read)) {
            if (!frame.colour.empty()) colour.add(frame, read == 0 ? &quality.where.colour_edges : nullptr);
            if (!frame.haptic.empty()) haptic.add(frame, read == 0 ? &quality.where.haptic : nullptr);
            has_haptic = has_haptic || !frame.haptic.empty();
        }
        progress(read + 1);
    }
    quality.times = times.times();
    quality.pumping = pumping.share();
    quality.colour = colour.fit();
    if (has_haptic) quality.haptic = haptic.values();
    return quality;
}

}  // namespace touchable
