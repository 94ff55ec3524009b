// SPDX-License-Identifier: Apache-2.0
// Readers' notes and seeking; planes: found by role, checked, brought to a scene's form and size; frames at
// another size; what writers check.
#include "engine/clip/clip.hpp"

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/tracks.hpp"

namespace touchable {
namespace {

// By PlaneRole.
constexpr std::array<std::string_view, all_roles.size()> role_names{"depth", "colour", "haptic", "height"};
constexpr std::array role_planes{&RawFrame::depth, &RawFrame::colour, &RawFrame::haptic, &RawFrame::height};
constexpr std::array role_patterns{&FolderSource::depth, &FolderSource::colour, &FolderSource::haptic,
                                   &FolderSource::height};

std::string kind_text(const PlaneView& plane) {
    return std::to_string(8 * plane.bytes_per_sample) + "-bit " + (plane.channels == 1 ? "grey" : "RGB");
}

std::uint16_t largest_sample(const PlaneView& plane) {
    std::uint16_t largest = 0;
    for (int y = 0; y < plane.height; ++y) {
        const std::uint8_t* row = plane.row(y);
        if (plane.bytes_per_sample == 1) {
            for (int x = 0; x < plane.width; ++x) largest = std::max<std::uint16_t>(largest, row[x]);
            continue;
        }
        for (int x = 0; x < plane.width; ++x) {
            std::uint16_t sample;
            std::memcpy(&sample, row + 2 * std::ptrdiff_t{x}, 2);
            largest = std::max(largest, sample);
        }
    }
    return largest;
}

Result<void> check_largest(const PlaneView& plane, int most, std::string_view where,
                           std::string_view promise) {
    const int largest = largest_sample(plane);
    if (largest <= most) return {};
    return input_error(std::string(where) + ": holds the value " + std::to_string(largest) + ", but " +
                       std::string(promise) + " allows at most " + std::to_string(most));
}

Result<void> check_depth(const PlaneView& plane, const Scene& scene, std::string_view where) {
    if (scene.depth.kind == DepthCodingKind::hue) {
        if (plane.channels == 3 && plane.bytes_per_sample == 1) return {};
        return input_error(std::string(where) + ": is " + kind_text(plane) +
                           ", but the scene's depth.coding, hue, needs 8-bit RGB");
    }
    const int bits = scene.depth_bits, bytes = bits > 8 ? 2 : 1;
    if (plane.channels != 1 || plane.bytes_per_sample != bytes)
        return input_error(std::string(where) + ": is " + kind_text(plane) +
                           ", but the scene's depth.bits, " + std::to_string(bits) + ", needs " +
                           std::to_string(8 * bytes) + "-bit grey");
    if (bits == 8 * bytes) return {};
    return check_largest(plane, (1 << bits) - 1, where,
                         "the scene's depth.bits, " + std::to_string(bits) + ",");
}

Result<void> check_height(const PlaneView& plane, const Scene& scene, std::string_view where) {
    const int most = scene.height_coding.code_max;
    if (plane.channels != 1 || (plane.bytes_per_sample == 1 && most > 255))
        return input_error(std::string(where) + ": is " + kind_text(plane) +
                           ", but the scene's height_map.bits needs " +
                           (most > 255 ? "16-bit grey" : "grey"));
    return check_largest(plane, most, where, "the scene's height_map.bits");
}

/// Refuses a track with too few bits for the scene's largest code: 10-bit codes read as 16-bit ones would all
/// lie at one plane. Exempt: metric codes, lengths in any number of bits; hue, made of three samples.
Result<void> check_bits(PlaneRole role, int bits, const Scene& scene, std::string_view where) {
    if (bits == 0) return {};
    const bool depth = role == PlaneRole::depth;
    const DepthCodingKind kind = scene.depth.kind;
    const bool free =
        depth ? kind == DepthCodingKind::metric || kind == DepthCodingKind::hue : role != PlaneRole::height;
    const int largest = (1 << bits) - 1,
              code_max = depth ? scene.depth.code_max : scene.height_coding.code_max;
    if (free || code_max <= largest) return {};
    return input_error(std::string(where) + ": is " + std::to_string(bits) + "-bit grey, but the scene's " +
                       (depth ? "depth.code_max" : "largest height code (height_map.bits)") + " is " +
                       std::to_string(code_max) + ": must be at most " + std::to_string(largest));
}

/// A packed plane whose pixels are made by `pixel(to, from)` from the nearest ones of the plane.
template <class Pixel>
Plane mapped(const PlaneView& plane, int width, int height, int channels, Pixel&& pixel) {
    const int bytes = plane.bytes_per_sample;
    std::vector<int> columns = nearest_samples(plane.width, width);
    for (int& column : columns) column *= bytes * plane.channels;
    Image image = blank_image(width, height, bytes, channels);
    std::uint8_t* to = image.samples.data();
    for (const int y : nearest_samples(plane.height, height)) {
        const std::uint8_t* row = plane.row(y);
        for (const int column : columns) {
            pixel(to, row + column);
            to += bytes * channels;
        }
    }
    return plane_from(std::move(image));
}

Plane resampled(const PlaneView& plane, int width, int height) {
    const auto bytes = static_cast<std::size_t>(plane.bytes_per_sample * plane.channels);
    return mapped(plane, width, height, plane.channels,
                  [bytes](std::uint8_t* to, const std::uint8_t* from) { std::memcpy(to, from, bytes); });
}

/// RGB from grey colour, or from grey haptic: stiffness, with constant frictions (take_grey_haptic).
Plane grey_as_rgb(PlaneRole role, const PlaneView& plane, int bits, int width, int height) {
    const int white = bits > 0 && bits < 8 ? 255 / ((1 << bits) - 1) : 1;  // exact for 1, 2 and 4 bits
    const bool in_all = role == PlaneRole::colour;
    return mapped(plane, width, height, 3, [white, in_all](std::uint8_t* to, const std::uint8_t* from) {
        to[0] = static_cast<std::uint8_t>(white * *from);
        to[1] = to[2] = in_all ? to[0] : std::uint8_t{0};
    });
}

/// Maps columns of one picture to the other's: column x lies at a + b x.
struct Columns {
    double a = 0, b = 1;
};
Columns fitted_columns(int from, int to) {
    const std::vector<int> samples = nearest_samples(from, to);
    Columns columns{0, static_cast<double>(from) / to};
    for (int x = 0; x < to; ++x) columns.a += samples[static_cast<std::size_t>(x)] - columns.b * x;
    columns.a /= to;
    return columns;
}

/// Which samples of `from` a sample of `to` covers, and each one's share: whole numbers that sum up to
/// `from`.
struct Covered {
    int first = 0;
    std::vector<std::int64_t> shares;
};
std::vector<Covered> covered_samples(int from, int to) {
    std::vector<Covered> all(static_cast<std::size_t>(to));
    for (std::int64_t k = 0; k < to; ++k) {
        // In units of 1/to samples: [k from, (k + 1) from), sample s being [s to, (s + 1) to).
        const std::int64_t begin = k * from, end = begin + from;
        Covered& one = all[static_cast<std::size_t>(k)];
        one.first = static_cast<int>(begin / to);
        for (std::int64_t s = one.first; s * to < end; ++s)
            one.shares.push_back(std::min(end, (s + 1) * to) - std::max(begin, s * to));
    }
    return all;
}

Plane averaged(const PlaneView& plane, int width, int height) {
    const std::vector<Covered> columns = covered_samples(plane.width, width),
                               rows = covered_samples(plane.height, height);
    const std::int64_t whole = std::int64_t{plane.width} * plane.height;
    Image image{width, height, 1, plane.channels, {}};
    image.samples.reserve(columns.size() * rows.size() * static_cast<std::size_t>(plane.channels));
    for (const Covered& row : rows)
        for (const Covered& column : columns)
            for (int channel = 0; channel < plane.channels; ++channel) {
                std::int64_t sum = 0;
                for (std::size_t y = 0; y < row.shares.size(); ++y) {
                    const std::uint8_t* from =
                        plane.row(row.first + static_cast<int>(y)) + column.first * plane.channels + channel;
                    std::int64_t of_row = 0;
                    for (const std::int64_t share : column.shares) {
                        of_row += share * *from;
                        from += plane.channels;
                    }
                    sum += row.shares[y] * of_row;
                }
                image.samples.push_back(static_cast<std::uint8_t>((2 * sum + whole) / (2 * whole)));
            }
    return plane_from(std::move(image));
}

/// Calls `add(x, y, at_x, at_y)` for each pixel of the original and the nearest one of the smaller picture.
void each_nearest(const PlaneView& before, const PlaneView& now, auto&& add) {
    const std::vector<int> columns = nearest_samples(now.width, before.width),
                           rows = nearest_samples(now.height, before.height);
    for (int y = 0; y < before.height; ++y)
        for (int x = 0; x < before.width; ++x)
            add(x, y, columns[static_cast<std::size_t>(x)], rows[static_cast<std::size_t>(y)]);
}

void add_values(const PlaneView& before, const PlaneView& now, PlaneLoss& loss) {
    loss.samples += std::int64_t{before.width} * before.height * before.channels;
    if (same_samples(before, now)) return;
    each_nearest(before, now, [&](int x, int y, int at_x, int at_y) {
        for (int channel = 0; channel < before.channels; ++channel) {
            const int error = std::abs(now.sample(at_x, at_y, channel) - before.sample(x, y, channel));
            loss.changed += error != 0;
            loss.largest = std::max(loss.largest, error);
            loss.squares += static_cast<double>(error) * error;
        }
    });
}

/// Depth along the optical axis per unit of length along a pixel's ray.
double axis_share(const Camera& camera, int x, int y) {
    const double right = (x - camera.cx) / camera.fx, down = (y - camera.cy) / camera.fy;
    return 1 / std::sqrt(1 + right * right + down * down);
}

void add_depths(const PlaneView& before, const Scene& scene, const PlaneView& now, const Scene& recoded,
                PlaneLoss& loss) {
    const bool turns_to_axis = scene.depth.semantics != recoded.depth.semantics;
    each_nearest(before, now, [&](int x, int y, int at_x, int at_y) {
        const auto was = stored_code(before, scene.depth, x, y),
                   is = stored_code(now, recoded.depth, at_x, at_y);
        const bool was_there = scene.depth.is_valid(was), is_there = recoded.depth.is_valid(is);
        loss.appeared += is_there && !was_there;
        loss.disappeared += was_there && !is_there;
        if (!was_there || !is_there) return;
        const double share = turns_to_axis ? axis_share(scene.camera, x, y) : 1;
        const double metres =
            std::abs(recoded.depth.depth(is) - scene.depth.depth(was) * share) * scene.metres_per_unit;
        loss.changed += loss.is_recoded && metres > 0;
        ++loss.pixels;
        loss.largest_metres = std::max(loss.largest_metres, metres);
        loss.squares_metres += metres * metres;
    });
}

}  // namespace

Result<void> ClipReader::seek(std::int64_t frame) {
    if (frame < 0) return usage_error("frame " + std::to_string(frame) + " is before the clip's first, 0");
    TRY(rewind());
    for (std::int64_t number = 0; number < frame; ++number) {
        TRY_ASSIGN(const auto passed, next());
        if (!passed)
            return usage_error("the clip has no frame " + std::to_string(frame) + ": its last is " +
                               std::to_string(number - 1));
    }
    return {};
}

const std::filesystem::path& sound_file_of(const ClipReader& clip) {
    static const std::filesystem::path none;
    return clip.inputs().empty() || clip.scene().folder ? none : clip.inputs().front();
}

std::vector<Remark> remarks_of(const ClipReader& clip) {
    std::vector<Remark> remarks = clip.scene().remarks;
    for (const std::string& note : clip.notes()) remarks.push_back({note});
    return remarks;
}

std::string_view role_name(PlaneRole role) {
    return role_names[static_cast<std::size_t>(role)];
}

std::optional<PlaneRole> role_named(std::string_view name) {
    const auto found = std::ranges::find(role_names, name);
    if (found == role_names.end()) return std::nullopt;
    return all_roles[static_cast<std::size_t>(found - role_names.begin())];
}

const PlaneView& plane_of(const RawFrame& frame, PlaneRole role) {
    return frame.*role_planes[static_cast<std::size_t>(role)];
}

PlaneView& plane_of(RawFrame& frame, PlaneRole role) {
    return frame.*role_planes[static_cast<std::size_t>(role)];
}

std::vector<std::pair<PlaneRole, PlaneView>> planes_of(const RawFrame& frame) {
    std::vector<std::pair<PlaneRole, PlaneView>> planes;
    for (const PlaneRole role : all_roles)
        if (!plane_of(frame, role).empty()) planes.emplace_back(role, plane_of(frame, role));
    return planes;
}

PngColours png_colours(PlaneRole role) {
    return role == PlaneRole::haptic ? PngColours::indexed_if_few : PngColours::rgb;
}

const std::string& pattern_of(const FolderSource& source, PlaneRole role) {
    return source.*role_patterns[static_cast<std::size_t>(role)];
}

std::string& pattern_of(FolderSource& source, PlaneRole role) {
    return source.*role_patterns[static_cast<std::size_t>(role)];
}

const PictureNumbers& numbers_of(const FolderSource& source, PlaneRole role) {
    return role == PlaneRole::colour   ? source.colour_numbers
           : role == PlaneRole::haptic ? source.haptic_numbers
                                       : source.height_numbers;
}

Plane plane_from(Image image, int bits) {
    const auto owned = std::make_shared<const Image>(std::move(image));
    return {owned->view(), owned, bits};
}

void add_plane(RawFrame& frame, PlaneRole role, Plane plane) {
    plane_of(frame, role) = plane.view;
    if (!frame.storage) {
        frame.storage = std::move(plane.storage);
        return;
    }
    using Both = std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>;
    frame.storage = std::make_shared<const Both>(std::move(frame.storage), std::move(plane.storage));
}

Result<void> check_plane(PlaneRole role, const PlaneView& plane, const Scene& scene, std::string_view where) {
    if (role == PlaneRole::depth) return check_depth(plane, scene, where);
    if (role == PlaneRole::height) return check_height(plane, scene, where);
    if (plane.bytes_per_sample == 1 && (plane.channels == 3 || plane.channels == 1)) return {};
    return input_error(
        std::string(where) + ": is " + kind_text(plane) + "; " + std::string(role_name(role)) +
        (role == PlaneRole::colour ? " is 8-bit RGB or grey" : " is 8-bit RGB, or grey for stiffness alone"));
}

Result<Plane> fit_plane(PlaneRole role, Plane plane, const Scene& scene, std::string_view where) {
    TRY(check_plane(role, plane.view, scene, where));
    TRY(check_bits(role, plane.bits, scene, where));
    const PlaneView& view = plane.view;
    const bool own_camera = role == PlaneRole::colour && scene.colour_camera;
    const int width = own_camera ? scene.colour_camera->width : scene.width,
              height = own_camera ? scene.colour_camera->height : scene.height;
    const bool same_size = view.width == width && view.height == height;
    if (own_camera && !same_size)
        return input_error(std::string(where) + ": is " + size_text(view.width, view.height) +
                           ", but the scene's colour_camera is " + size_text(width, height));
    if (role == PlaneRole::depth && !same_size)
        return input_error(std::string(where) + ": is " + size_text(view.width, view.height) +
                           ", but the scene is " + size_text(scene.width, scene.height));
    if ((role == PlaneRole::colour || role == PlaneRole::haptic) && view.channels == 1)
        return grey_as_rgb(role, view, plane.bits, width, height);
    return same_size ? std::move(plane) : resampled(view, scene.width, scene.height);
}

ClipNote take_grey_haptic(Scene& scene) {
    const double held = scene.default_properties.static_friction,
                 sliding = scene.default_properties.dynamic_friction;
    scene.haptic.static_friction = {held, held};
    scene.haptic.dynamic_friction = {sliding, sliding};
    return {PlaneRole::haptic, "grey: stiffness alone, " + exact_number(scene.haptic.stiffness.min) + " to " +
                                   exact_number(scene.haptic.stiffness.max) + " N/mm; friction " +
                                   exact_number(held) + " static, " + exact_number(sliding) +
                                   " dynamic everywhere, as the scene's default_properties have it"};
}

ClipNote resampling_note(PlaneRole role, int width, int height, const Scene& scene) {
    if (role == PlaneRole::colour && scene.colour_camera)
        return {role, size_text(width, height) + ", by a camera of its own"};
    return {role, size_text(width, height) + ": resampled to the nearest pixel of depth's " +
                      size_text(scene.width, scene.height)};
}

std::optional<ClipNote> default_touch_note(bool has_haptic, const Scene& scene) {
    if (has_haptic) return std::nullopt;
    const HapticProperties& felt = scene.default_properties;
    ClipNote note("no haptic plane: " + exact_number(felt.stiffness / 1000.0) +
                  " N/mm everywhere, friction " + exact_number(felt.static_friction) + " static, " +
                  exact_number(felt.dynamic_friction) + " dynamic");
    note.plane = PlaneRole::haptic;
    return note;
}

std::optional<std::string> no_depth_note(const RawFrame& frame, const DepthCoding& coding) {
    if (has_valid_pixel(frame.depth, coding)) return std::nullopt;
    return "frame " + std::to_string(frame.number) +
           " has no valid depth, so nothing in it can be touched: do the scene's depth.near, far, code_max "
           "and invalid fit these pictures?";
}

std::vector<ClipNote> describe_planes(const std::vector<TrackInfo>& tracks, const RawFrame& first,
                                      Scene& scene) {
    std::vector<ClipNote> notes;
    bool has_haptic = false;
    for (const TrackInfo& track : tracks) {
        const PlaneRole role = role_named(track.role).value_or(PlaneRole::depth);
        has_haptic = has_haptic || role == PlaneRole::haptic;
        if (role == PlaneRole::haptic && track.pixel_format.starts_with("gray"))
            notes.push_back(take_grey_haptic(scene));
        if (track.width != scene.width || track.height != scene.height)
            notes.push_back(resampling_note(role, track.width, track.height, scene));
        if (track.lossless) continue;
        if (auto note = lossy_note(role, track.codec)) notes.push_back(std::move(*note));
    }
    if (auto note = no_depth_note(first, scene.depth)) notes.push_back(std::move(*note));
    if (auto note = default_touch_note(has_haptic, scene)) notes.push_back(std::move(*note));
    return notes;
}

std::vector<int> nearest_samples(int from, int to) {
    std::vector<int> samples(static_cast<std::size_t>(to));
    for (int k = 0; k < to; ++k)
        samples[static_cast<std::size_t>(k)] =
            static_cast<int>((2 * std::int64_t{k} + 1) * from / (2 * std::int64_t{to}));
    return samples;
}

Scene resized_scene(Scene scene, int width, int height) {
    const Columns x = fitted_columns(scene.width, width), y = fitted_columns(scene.height, height);
    scene.camera.fx /= x.b;
    scene.camera.fy /= y.b;
    scene.camera.cx = (scene.camera.cx - x.a) / x.b;
    scene.camera.cy = (scene.camera.cy - y.a) / y.b;
    scene.width = width;
    scene.height = height;
    return scene;
}

RawFrame resized_frame(const RawFrame& frame, int width, int height) {
    RawFrame out;
    out.number = frame.number;
    out.time_ns = frame.time_ns;
    out.epoch = frame.epoch;
    for (const auto& [role, plane] : planes_of(frame))
        add_plane(
            out, role,
            role == PlaneRole::colour ? averaged(plane, width, height) : resampled(plane, width, height));
    return out;
}

void add_loss(const RawFrame& before, const RawFrame& now, const Scene& scene, PlaneLosses& losses) {
    for (const PlaneRole role : all_roles) {
        const PlaneView &was = plane_of(before, role), &is = plane_of(now, role);
        if (was.empty() || is.empty()) continue;
        PlaneLoss& loss = losses[static_cast<std::size_t>(role)];
        add_values(was, is, loss);
        if (role == PlaneRole::depth && !same_samples(was, is)) add_depths(was, scene, is, scene, loss);
    }
}

void add_recoded_loss(const RawFrame& before, const Scene& scene, const RawFrame& now, const Scene& recoded,
                      PlaneLosses& losses) {
    PlaneLoss& loss = losses[static_cast<std::size_t>(PlaneRole::depth)];
    loss.is_recoded = true;
    loss.samples += std::int64_t{before.depth.width} * before.depth.height;
    add_depths(before.depth, scene, now.depth, recoded, loss);
}

Result<void> FrameCheck::check(const RawFrame& frame, const Scene& scene) {
    const std::string number = std::to_string(frame.number);
    const auto misuse = [&](const std::string& what) {
        return internal_error("frame " + number + " given to the clip writer: " + what);
    };
    if (frame.number != frames_) return misuse("number " + std::to_string(frames_) + " was due");
    if (frame.depth.empty()) return misuse("it has no depth");
    for (const PlaneRole role : all_roles) {
        const PlaneView& plane = plane_of(frame, role);
        const std::string name(role_name(role));
        PlaneView& first = forms_[static_cast<std::size_t>(role)];
        if (frames_ == 0) first = plane;
        if (!same_form(plane, first)) return misuse(name + " is of another size or kind than in frame 0");
        if (plane.empty()) continue;
        if (plane.width != scene.width || plane.height != scene.height)
            return misuse(name + " is not of the scene's size");
        if ((role == PlaneRole::colour || role == PlaneRole::haptic) && plane.channels != 3)
            return misuse(name + " is not RGB");
        TRY(check_plane(role, plane, scene, "frame " + number + ", " + name));
    }
    ++frames_;
    return {};
}

}  // namespace touchable
