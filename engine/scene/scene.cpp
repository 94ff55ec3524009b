// SPDX-License-Identifier: Apache-2.0
#include "engine/scene/scene.hpp"

#include <concepts>
#include <tuple>

#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/scene/filter_codes.hpp"

namespace touchable {

namespace {

/// The code, as a real number, that would stand for `depth`; any number if there is none.
double real_code(const DepthCoding& coding, double depth) {
    if (coding.kind == DepthCodingKind::metric) return depth / coding.scale;
    const double shift = coding.shift, deep = 1.0 / (coding.far + shift);
    const double from_far = coding.kind == DepthCodingKind::inverse
                                ? (1.0 / (depth + shift) - deep) / (1.0 / (coding.near + shift) - deep)
                            : coding.kind == DepthCodingKind::log
                                ? logarithm((coding.far + shift) / (depth + shift)) / coding.log_span()
                                : (coding.far - depth) / (coding.far - coding.near);
    return coding.code_max * (coding.near_is_high ? from_far : 1.0 - from_far);
}

/// Whether codes stand for depths at all. The valid range is derived before a Scene is validated.
bool has_depths(const DepthCoding& coding) {
    if (coding.code_max == 0) return false;
    const auto has_inverse = [](double plane) {
        return plane > 0 && std::isfinite(1.0 / plane) && std::isfinite(plane);
    };
    if (coding.kind == DepthCodingKind::log)
        return has_inverse(coding.near + coding.shift) && has_inverse(coding.far + coding.shift) &&
               coding.near < coding.far;
    return coding.kind != DepthCodingKind::inverse || (has_inverse(coding.near) && has_inverse(coding.far));
}

// A byte that is no UTF-8 becomes three in JSON; the text can still be read again.
constexpr std::size_t longest_made = longest_remark / 4;

constexpr int max_side = 16384;
constexpr std::int64_t max_rate_term = 1'000'000'000;
/// Lengths and focal lengths beyond these are slips of a decimal point, and squares of extreme ones would
/// overflow a double.
constexpr double longest = 1e12, shortest = 1e-12;

std::string text(double number) {
    return exact_number(number, std::chars_format::general);
}
std::string text(std::integral auto number) {
    return std::to_string(number);
}

Error refuse(const std::string& member, auto value, const std::string& right) {
    return input_error(member + " is " + text(value) + ": must be " + right);
}

template <class Number>
Result<void> check_within(const std::string& member, Number value, Number least, Number most) {
    if (value >= least && value <= most) return {};  // refuses NaN too
    return refuse(member, value, "from " + text(least) + " to " + text(most));
}

/// A length, a focal length or a scale.
Result<void> check_length(const std::string& member, double value) {
    if (value > 0.0) return check_within(member, value, shortest, longest);
    return refuse(member, value, "greater than 0");
}

Result<void> check_not_negative(const std::string& member, double value) {
    return check_within(member, value, 0.0, longest);
}

Result<void> check_camera(const std::string& member, const Camera& camera) {
    TRY(check_length(member + ".fx", camera.fx));
    TRY(check_length(member + ".fy", camera.fy));
    TRY(check_within(member + ".cx", camera.cx, -longest, longest));
    return check_within(member + ".cy", camera.cy, -longest, longest);
}

Result<void> check_lens(const std::string& member, const LensDistortion& lens) {
    constexpr double strongest = 1e6;
    for (const double term : lens.terms)
        TRY(check_within(member + ".distortion", term, -strongest, strongest));
    return {};
}

Result<void> check_pose(const std::string& member, const CameraPose& pose) {
    if (!is_rotation(pose.rotation))
        return input_error(member +
                           " does not begin with a rotation in its rows: must be [r, r, r, t, r, r, r, t, r, "
                           "r, r, t, 0, 0, 0, 1]");
    for (const double length : pose.translation)
        TRY(check_within(member + "'s translation", length, -longest, longest));
    return {};
}

Result<void> check_colour_camera(const Scene& scene) {
    if (!scene.colour_camera) return {};
    const ColourCamera& colour = *scene.colour_camera;
    TRY(check_within("colour_camera.width", colour.width, 1, max_side));
    TRY(check_within("colour_camera.height", colour.height, 1, max_side));
    TRY(check_camera("colour_camera", colour.camera));
    TRY(check_lens("colour_camera", colour.lens));
    return check_pose("colour_camera.from_depth", colour.from_depth);
}

Result<void> check_planes(const DepthCoding& depth) {
    const bool is_log = depth.kind == DepthCodingKind::log;
    if (depth.kind == DepthCodingKind::metric) TRY(check_length("depth.scale", depth.scale));
    // Near may be 0 if its code is no depth, and for log codes if the shift is above 0.
    TRY(is_log || depth.kind == DepthCodingKind::metric ? check_not_negative("depth.near", depth.near)
                                                        : check_length("depth.near", depth.near));
    TRY(check_length("depth.far", depth.far));
    if (!is_log && depth.kind != DepthCodingKind::inverse) return {};
    TRY(check_within("depth.shift", depth.shift, -longest, longest));
    if (depth.near + depth.shift >= shortest) return {};
    return refuse("depth.shift", depth.shift, "greater than -depth.near, which is " + text(-depth.near));
}

/// Checks valid_min and valid_max. No file has them, but code that makes a Scene can forget to derive them.
Result<void> check_valid_range(const DepthCoding& depth) {
    DepthCoding derived = depth;
    derive_valid_range(derived);
    if (derived.valid_min > derived.valid_max)
        return refuse("depth.far", depth.far,
                      "the depth of at least one code; no code lies between depth.near, which is " +
                          text(depth.near) + ", and depth.far that is not in depth.invalid");
    if (depth.valid_min != derived.valid_min)
        return refuse("depth.valid_min", int{depth.valid_min},
                      text(int{derived.valid_min}) + ", the least valid code: derive_valid_range sets it");
    if (depth.valid_max != derived.valid_max)
        return refuse("depth.valid_max", int{depth.valid_max},
                      text(int{derived.valid_max}) + ", the greatest valid code: derive_valid_range sets it");
    return {};
}

/// The largest ratio of the deepest valid depth to the nearest: between neighbours farther apart, doubles do
/// not tell the places of a cell apart well enough for a proxy to find its foot.
constexpr double most_depth_ratio = 1e6;

/// Needs a valid range that passed check_valid_range.
Result<void> check_depth_ratio(const DepthCoding& depth) {
    const double deepest = depth.deepest_depth();
    if (deepest <= most_depth_ratio * depth.nearest_depth()) return {};
    return refuse("depth.near", depth.near,
                  "at least " + text(deepest / most_depth_ratio) +
                      ", a millionth of the deepest valid depth, which is " + text(deepest));
}

Result<void> check_depth(const Scene& scene) {
    const DepthCoding& depth = scene.depth;
    const bool hue = depth.kind == DepthCodingKind::hue;
    TRY(check_within("depth.bits", scene.depth_bits, 8, 16));
    if (hue && scene.depth_bits != 8)
        return refuse("depth.bits", scene.depth_bits, "8, of each of red, green and blue, for hue");
    TRY(check_within("depth.least_sum", depth.least_sum, 0, hue ? 3 * 255 : 0));
    const int largest_code = hue ? DepthCoding::hue_circle : (1 << scene.depth_bits) - 1;
    TRY(check_within("depth.code_max", int{depth.code_max}, 1, largest_code));
    TRY(check_planes(depth));
    TRY(check_not_negative("depth.float_scale", scene.float_scale));
    if (!(depth.near < depth.far))
        return refuse("depth.near", depth.near, "less than depth.far, which is " + text(depth.far));
    TRY(check_within("depth.invalid's number of codes", depth.invalid_code_count, 0,
                     DepthCoding::max_invalid_codes));
    TRY(check_valid_range(depth));
    TRY(check_depth_ratio(depth));
    if (scene.float_scale == 0) return {};
    DepthCoding of_floats = depth;
    of_floats.scale = scene.float_scale;
    derive_valid_range(of_floats);
    if (of_floats.valid_min > of_floats.valid_max)
        return refuse("depth.float_scale", scene.float_scale, "so fine that a code is a valid depth");
    return check_depth_ratio(of_floats);
}

/// The largest height must leave a thousandth of the nearest depth, and `most_depth_ratio` must hold: a pixel
/// nearer to the camera's plane is so small beside its neighbours that no fraction of a pixel finds it. Needs
/// a depth coding that passed check_depth.
Result<void> check_height(const Scene& scene) {
    const HeightCoding& height = scene.height_coding;
    TRY(check_not_negative("height_map.max", height.max_height));
    const int steps = height.code_max + 1;
    if (height.code_max < 255 || (steps & (steps - 1)) != 0)
        return refuse("the largest height code", int{height.code_max},
                      "2^height_map.bits - 1, bits from 8 to 16");
    if (height.max_height == 0.0) return {};
    if (height.units == HeightUnits::levels && scene.depth.kind != DepthCodingKind::linear)
        return input_error("height_map.units is levels: must be world, because depth.coding is not linear");
    const double nearest = scene.depth.nearest_depth();
    const double thousandth = 1e-3 * nearest;
    const double left = std::max(thousandth, scene.depth.deepest_depth() / most_depth_ratio);
    if (nearest - largest_height(height, scene.depth) >= left) return {};
    const bool in_levels = height.units == HeightUnits::levels;
    return refuse(
        "height_map.max", height.max_height,
        "at most " + text((nearest - left) / (in_levels ? scene.depth.level() : 1.0)) +
            (in_levels ? " levels" : " scene units") + ", because it is taken off depths as small as " +
            text(nearest) + ", of which " +
            (left > thousandth ? text(left) + ", a millionth of the deepest," : std::string("a thousandth")) +
            " has to be left");
}

Result<void> check_range(const std::string& member, const PropertyRange& range) {
    TRY(check_not_negative(member + "'s minimum", range.min));
    if (range.max >= range.min) return check_not_negative(member + "'s maximum", range.max);
    return refuse(member + "'s maximum", range.max, "at least its minimum, which is " + text(range.min));
}

Result<void> check_properties(const HapticProperties& properties) {
    const double static_friction = properties.static_friction, dynamic_friction = properties.dynamic_friction;
    if (!(properties.stiffness > 0.0 && properties.stiffness <= longest))
        return refuse("default_properties.stiffness (in N/m)", properties.stiffness,
                      "greater than 0 and at most " + text(longest));
    TRY(check_not_negative("default_properties.static_friction", static_friction));
    TRY(check_not_negative("default_properties.dynamic_friction", dynamic_friction));
    if (dynamic_friction <= static_friction) return {};
    return refuse("default_properties.dynamic_friction", dynamic_friction,
                  "at most static_friction, which is " + text(static_friction));
}

/// `whose`: the member, as in "filter.levels'".
Result<void> check_along_depth(const std::string& whose, const DepthLength& length) {
    TRY(check_not_negative(whose + " constant", length.constant));
    return check_not_negative(whose + " quadratic", length.quadratic);
}

Result<void> check_filter(const Scene& scene) {
    const FilterSettings& filter = scene.filter;
    for (const FilterSetting& setting : filter_settings()) {
        const std::string name = std::string("filter.") + setting.name;
        const DepthLength value = setting.value.of(filter);
        if (setting.range.is_length) {
            TRY(check_along_depth(name + (name.ends_with('s') ? "'" : "'s"), value));
        } else if (!setting.range.has(value.constant)) {
            return refuse(name, value.constant, setting.range.in_words());
        }
    }
    if (filter.temporal && filter.temporal_noise == DepthLength{})
        return input_error(
            "filter.temporal_noise is [0, 0]: must be [constant, quadratic], how noisy depth is in scene "
            "units, because filter.temporal is on");
    if (filter.terraces == TerraceRemoval::on && !has_working_codes(scene))
        return input_error(
            "filter.terraces is on: must be off or auto where fewer than two codes are valid, or "
            "filter.levels are as far apart as nearly all depths");
    return {};
}

/// One field %d or %0Nd (N from 1 to 9), and no other percent sign, is safe to fill in. Or one star; or
/// neither: the name of a single picture.
bool is_file_pattern(const std::string& pattern) {
    const std::size_t percent = pattern.find('%'), star = pattern.find('*');
    if (star != std::string::npos)
        return percent == std::string::npos && pattern.find('*', star + 1) == std::string::npos;
    if (percent == std::string::npos) return !pattern.empty();
    if (pattern.find('%', percent + 1) != std::string::npos) return false;
    const std::string field = pattern.substr(percent + 1, 3);
    const bool plain = field.starts_with('d');
    const bool padded =
        field.size() == 3 && field[0] == '0' && field[1] >= '1' && field[1] <= '9' && field[2] == 'd';
    return plain || padded;
}

Result<void> check_pattern(const std::string& member, const std::string& pattern) {
    const bool clean = std::ranges::none_of(pattern, [](unsigned char c) { return c < 0x20 || c == 0x7f; });
    if (clean && is_file_pattern(pattern)) return {};
    return input_error(
        member + " is " + in_quotes(pattern) +
        ": must be a file name with one field of digits, %d or %0Nd with N from 1 to 9, no other % and no "
        "control characters, such as \"depth_%04d.png\"; with one star instead, such as \"depth/*.png\"; a "
        "list, such as \"depth.txt\"; or the name of a single picture");
}

constexpr int largest_number = 999'999'999;

/// Files of a star or a list are paired with depth's, and not numbered.
Result<void> check_numbers(const std::string& member, const std::string& pattern,
                           const PictureNumbers& numbers) {
    if (numbers.any() && !is_numbered(pattern))
        return input_error(member + (numbers.first ? ".first" : ".step") + " is " +
                           text(numbers.first ? *numbers.first : *numbers.step) +
                           ": must be left out, because " + in_quotes(pattern) +
                           " has no field of digits, such as %06d");
    TRY(check_within(member + ".first", numbers.first.value_or(0), 0, largest_number));
    return check_within(member + ".step", numbers.step.value_or(1), 1, largest_number);
}

/// A still has one picture of each kind. (A still of another plane may serve a series of depths.)
Result<void> check_still(const FolderSource& folder) {
    for (const auto& [member, name] :
         {std::pair<const char*, const std::string&>{"folder.colour", folder.colour},
          {"folder.haptic", folder.haptic},
          {"folder.height", folder.height}})
        if (!name.empty() && is_still(folder.depth) && !is_still(name))
            return input_error(std::string(member) + " is " + in_quotes(name) +
                               ": must be, like folder.depth (" + in_quotes(folder.depth) +
                               "), the name of a single picture");
    if (!is_still(folder.depth)) return {};
    if (folder.first != 0)
        return refuse("folder.first", folder.first, "0, because folder.depth is a single picture");
    if (folder.count > 1)
        return refuse("folder.count", folder.count, "0 or 1, because folder.depth is a single picture");
    return {};
}

Result<void> check_cameras(const FolderSource& folder) {
    if (folder.cameras.empty() && !folder.camera_numbers.any()) return {};
    TRY(check_pattern("folder.cameras", folder.cameras));
    if (is_still(folder.cameras))
        return input_error(
            "folder.cameras is " + in_quotes(folder.cameras) +
            ": must be a file for each frame, such as \"cameras/%06d.json\", \"cameras/*.pincam\" or a list, "
            "\"cameras.txt\"; one of all frames is the scene's camera");
    return check_numbers("folder.cameras", folder.cameras, folder.camera_numbers);
}

Result<void> check_folder(const FolderSource& folder) {
    TRY(check_pattern("folder.depth", folder.depth));
    const std::tuple<const char*, const std::string&, const PictureNumbers&> optional_planes[] = {
        {"folder.colour", folder.colour, folder.colour_numbers},
        {"folder.haptic", folder.haptic, folder.haptic_numbers},
        {"folder.height", folder.height, folder.height_numbers}};
    for (const auto& [member, pattern, numbers] : optional_planes) {
        if (pattern.empty() && !numbers.any()) continue;
        TRY(check_pattern(member, pattern));
        TRY(check_numbers(member, pattern, numbers));
    }
    TRY(check_cameras(folder));
    const PictureNumbers of_depth{{}, folder.step == 1 ? std::optional<int>() : folder.step};
    TRY(check_numbers("folder.depth", folder.depth, of_depth));
    TRY(check_within("folder.first", folder.first, 0, largest_number));
    const int most = (largest_number - folder.first) / folder.step;
    TRY(check_within("folder.count", folder.count, 0, most));
    return check_still(folder);
}

Result<void> check_one_focal_length(const Scene& scene) {
    const bool differ = scene.folder && !scene.folder->cameras.empty();
    if (!differ || scene.stored.kind != StoredDepth::Kind::disparity) return {};
    return input_error("folder.cameras is " + in_quotes(scene.folder->cameras) +
                       ": must be left out, because depth.coding is disparity, which is of one focal length");
}

Result<void> check_video(const Scene& scene) {
    const VideoSource& video = *scene.video;
    if (scene.folder) return input_error("video: must be left out where there is a folder");
    for (const auto& [member, name] : {std::pair<const char*, const std::string&>{"video.depth", video.depth},
                                       {"video.colour", video.colour},
                                       {"video.haptic", video.haptic},
                                       {"video.height", video.height}}) {
        const bool clean = std::ranges::none_of(name, [](unsigned char c) { return c < 0x20; });
        if (!clean || (name.empty() && &name == &video.depth))
            return input_error(std::string(member) + " is " + in_quotes(name) +
                               ": must be the name of a file, without control characters");
    }
    if (video.layout != VideoLayout::alone && !video.colour.empty())
        return input_error("video.colour is " + in_quotes(video.colour) +
                           ": must be left out, because by video.layout colour is beside depth");
    const bool is_hue = scene.depth.kind == DepthCodingKind::hue;
    if ((video.values == VideoValues::hue) != is_hue)
        return input_error(std::string("video.values: must be ") +
                           (is_hue ? "hue, as depth.coding is" : "grey or mean, as depth.coding is not hue"));
    return {};
}

}  // namespace

double DepthCoding::log_span() const {
    return logarithm((far + shift) / (near + shift));
}

double DepthCoding::log_depth(double share) const {
    return (near + shift) * exponential((1.0 - share) * log_span()) - shift;
}

std::uint16_t DepthCoding::code(double depth) const {
    // The nearest code is one of the two around the real-valued one, or, if those are marked invalid, a few
    // codes farther.
    constexpr int reach = max_invalid_codes + 2;
    const double target = depth > near ? std::min(depth, far) : near;  // a number even if depth is NaN
    const double estimate = std::floor(real_code(*this, target));
    int around = valid_min;
    if (estimate >= valid_max)
        around = valid_max;
    else if (estimate > valid_min)
        around = static_cast<int>(estimate);
    std::uint16_t best = valid_min;
    double best_distance = HUGE_VAL;
    for (int c = std::max<int>(valid_min, around - reach); c <= std::min<int>(valid_max, around + reach);
         ++c) {
        const auto candidate = static_cast<std::uint16_t>(c);
        const double distance = std::fabs(this->depth(candidate) - target);
        if (is_valid(candidate) && distance < best_distance) {
            best = candidate;
            best_distance = distance;
        }
    }
    return best;
}

void derive_valid_range(DepthCoding& coding) {
    const auto marked = coding.invalid_codes.begin() +
                        std::clamp(coding.invalid_code_count, 0, DepthCoding::max_invalid_codes);
    const auto fits = [&](int code) {
        const double depth = coding.depth(static_cast<std::uint16_t>(code));
        return depth > 0.0 && depth >= coding.near && depth <= coding.far &&
               std::find(coding.invalid_codes.begin(), marked, code) == marked;
    };
    int low = 0, high = has_depths(coding) ? coding.code_max : -1;
    while (low <= high && !fits(low)) ++low;
    while (high >= low && !fits(high)) --high;
    if (low > high) low = 1, high = 0;  // no code at all
    coding.valid_min = static_cast<std::uint16_t>(low);
    coding.valid_max = static_cast<std::uint16_t>(high);
}

void add_remark(std::vector<Remark>& remarks, Remark remark) {
    remark.what = printable(remark.what, longest_made);
    const std::string text = remark_text(remark);
    const bool is_new = std::ranges::find(remarks, text, remark_text) == remarks.end();
    if (is_new && remarks.size() < most_remarks) remarks.push_back(std::move(remark));
}

std::vector<Remark> joined_remarks(std::vector<Remark> first, const std::vector<Remark>& rest) {
    for (const Remark& remark : rest) add_remark(first, remark);
    return first;
}

std::string remark_in_words(const Remark& remark) {
    const std::string text = printable(remark_text(remark), longest_remark);
    if (!remark.is_guess && remark.otherwise.empty() && remark.hints.empty()) return text;
    return text + " (" + (remark.otherwise.empty() ? "a scene file says otherwise" : remark.otherwise) + ")";
}

bool is_still(std::string_view pattern) {
    return pattern.find_first_of("%*") == std::string_view::npos && !pattern.ends_with(".txt");
}

bool is_numbered(std::string_view pattern) {
    return pattern.find('%') != std::string_view::npos;
}

VideoValues usual_values(DepthCodingKind kind) {
    return kind == DepthCodingKind::hue ? VideoValues::hue : VideoValues::grey;
}

double largest_height(const HeightCoding& height, const DepthCoding& depth) {
    return height.units == HeightUnits::levels ? height.max_height * depth.level() : height.max_height;
}

Result<void> validate(const Scene& scene) {
    TRY(check_within("width", scene.width, 1, max_side));
    TRY(check_within("height", scene.height, 1, max_side));
    TRY(check_within("rate's numerator", scene.rate.num, std::int64_t{1}, max_rate_term));
    TRY(check_within("rate's denominator", scene.rate.den, std::int64_t{1}, max_rate_term));
    TRY(check_length("metres_per_unit", scene.metres_per_unit));
    TRY(check_camera("camera", scene.camera));
    TRY(check_lens("camera", scene.lens));
    TRY(check_colour_camera(scene));
    TRY(check_depth(scene));
    TRY(check_height(scene));
    TRY(check_range("haptic.stiffness", scene.haptic.stiffness));
    TRY(check_range("haptic.static_friction", scene.haptic.static_friction));
    TRY(check_range("haptic.dynamic_friction", scene.haptic.dynamic_friction));
    TRY(check_properties(scene.default_properties));
    if (scene.hole_stiffness) TRY(check_not_negative("hole_stiffness", *scene.hole_stiffness));
    TRY(check_filter(scene));
    if (scene.device_metres_per_unit)
        TRY(check_length("device_metres_per_unit", *scene.device_metres_per_unit));
    if (scene.folder) TRY(check_folder(*scene.folder));
    TRY(check_one_focal_length(scene));
    return scene.video ? check_video(scene) : Result<void>();
}

Result<void> validate(const SceneDescription& described) {
    if (!described.unstated.far) return validate(described.scene);
    // The room for terrace removal is known only with the far plane.
    Scene scene = described.scene;
    if (scene.filter.terraces == TerraceRemoval::on) scene.filter.terraces = TerraceRemoval::automatic;
    return validate(scene);
}

Result<Scene> settle(const SceneDescription& described, const SceneDescription::FoundInClip& found) {
    SceneDescription settled = described;
    Scene& scene = settled.scene;
    const SceneDescription::Unstated& open = described.unstated;
    if (open.camera && !found.camera)
        return input_error(
            "camera is missing: must be given in the scene file, as its folder.cameras are of the pictures "
            "of its folder alone");
    if (open.camera) scene.camera = *found.camera;
    if (open.rate && found.rate) scene.rate = *found.rate;
    if (open.far && found.far) {
        scene.depth.far = *found.far;
        derive_valid_range(scene.depth);
        settled.unstated.far = false;
    }
    TRY(validate(settled));
    return scene;
}

}  // namespace touchable
