// SPDX-License-Identifier: Apache-2.0
#include "player/commands/run_options.hpp"

#include <glm/matrix.hpp>
#include <sstream>

#include "device/drivers/device_catalog.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/commands/option_types.hpp"
#include "player/run/terminal.hpp"

namespace touchable {
namespace {

constexpr const char* right_frame =
    "16 numbers, row by row, of a rotation and a translation in metres that take points from the camera (x "
    "right, y down, z forward) to the world, or a file with them";

/// Numbers separated by commas or spaces; nothing if the text contains anything else.
std::optional<std::vector<double>> numbers_of(std::string text) {
    for (char& c : text)
        if (c == ',' || c == ';' || c == '[' || c == ']') c = ' ';
    std::istringstream in(text);
    std::vector<double> numbers;
    for (double number = 0; in >> number;) numbers.push_back(number);
    in.clear();
    std::string rest;
    if (in >> rest) return std::nullopt;
    return numbers;
}

bool is_rigid(const glm::dmat4& m) {
    const glm::dmat3 turn(m);
    const glm::dmat3 unit = glm::transpose(turn) * turn;
    bool rigid = glm::determinant(turn) > 0;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            rigid = rigid && std::abs(unit[column][row] - (column == row ? 1.0 : 0.0)) < 1e-3;
    return rigid && m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][3] == 1 &&
           glm::length(glm::dvec3(m[3])) < 1000;  // metres; false for NaN
}

bool is_simulated(const std::string& device) {
    return KeyedValues::name_and_pairs(device).first == "simulated";
}

/// Makes all devices and joins them into one.
Result<std::shared_ptr<HapticDevice>> make_held(const HeldDeviceWords& words) {
    TRY_ASSIGN(auto watchdog, SafetyWatchdog::start());
    DrivenSettings driven;
    driven.watchdog = watchdog;
    driven.as_thread_begins = [] { become_fifo(); };
    std::vector<std::unique_ptr<HapticDevice>> devices;
    if (words.is_looked_for_always) driven.away_s = std::numeric_limits<double>::infinity();
    for (const std::string& one : words.devices) {
        TRY_ASSIGN(auto device, make_device(one, driven));
        devices.push_back(std::move(device));
    }
    if (devices.size() == 1) return std::shared_ptr<HapticDevice>(std::move(devices.front()));
    return std::shared_ptr<HapticDevice>(make_device_group(std::move(devices)));
}

std::string of_its_forces(const HapticDevice& device, const HandControl& control, bool has_terminal) {
    if (device.capabilities().axes_driven == 0)
        return "the " + device.name() +
               " exerts no force, with --force-on or without: what is touched is computed and told, and not "
               "felt";
    if (control.force_is_asked()) return "forces are on; Ctrl-C ends";
    std::string ways =
        device.capabilities().buttons > 0 ? std::string("press ") + device.capabilities().first_button : "";
    if (has_terminal) ways += ways.empty() ? "press Enter" : ", or Enter,";
    if (ways.empty()) return "forces are off, and stay off: --force-on asks for them";
    return "forces are off: " + ways + " to turn them on; Ctrl-C ends";
}

constexpr double longest_seconds = 1e6;

constexpr int largest_side = 8192;

}  // namespace

void add_builder_options(CLI::App& sub, BuilderChoice& choice, const std::vector<const char*>& names) {
    std::string what = "how frames become a surface. All give the same bits; vulkan: on a GPU";
    for (const std::string_view name : names) {
        if (name == "lazy") what += "; lazy: only where it is touched";
        if (name == "reference") what += "; reference: slow";
        if (name == "auto") what += "; auto: what costs least here";
    }
    begin_topic(sub, expert_topic);
    add_word_option(sub, "--builder", choice.name, what, names)->default_str(choice.name);
    sub.add_option("--gpu", choice.gpu,
                   "which GPU builds and draws. cpu: Vulkan in software, as lavapipe; GPU: index or part of "
                   "the name of a device (touchable check lists them)")
        ->type_name(type_with_words("auto|cpu|GPU", std::array{"auto", "cpu"}))
        ->capture_default_str();
}

Result<void> check_gpu_options(const BuilderChoice& choice, bool draws_on_gpu) {
    const bool builds_on_gpu = choice.name == "vulkan" || choice.name == "auto";
    if (choice.names_gpu() && !builds_on_gpu && !draws_on_gpu)
        return usage_error(
            "--gpu goes with --builder vulkan or auto, or a --picture that is not painted by the cpu");
    return {};
}

void add_device_options(CLI::App& sub, HeldDeviceWords& words, SessionOptions& session, bool in_window) {
    begin_topic(sub, "Device");
    std::vector<std::string> names = device_words();
    if (in_window) {
        std::erase(names, "simulated");  // is moved by a scripted hand
        names.insert(names.begin(), "mouse");
    }
    sub.add_option("--device", words.devices,
                   std::string(in_window ? "what moves the fingers. Forces start when you ask for them"
                                         : "haptic device that you hold, with --live. simulated is moved by "
                                           "--hand") +
                       "; a device takes :key=value,... (docs/devices.md), and several are fingers of one "
                       "hand. touchable devices lists those that are connected")
        ->allow_extra_args(false)
        ->type_name(type_with_words("DEVICE", names));
    if (!in_window)
        sub.add_flag("--force-on", words.force_on,
                     "let the device exert forces from the start. Otherwise its button or Enter turns them "
                     "on");
    sub.add_option("--world-from-camera", words.world_from_camera,
                   "where the camera stands in the device's world, such as a robot's. 16 numbers row by row, "
                   "or a file with them")
        ->type_name("MATRIX|FILE");
    const SessionSetting& scale = *session_setting("hand-scale");
    add_number_option(sub, "--" + scale.name, session.hand_scale, scale.what, scale.range.least,
                      scale.range.most)
        ->capture_default_str();
}

Result<glm::dmat4> read_world_from_camera(const std::string& words) {
    constexpr std::size_t largest = 1 << 16;
    const std::string named = "--world-from-camera '" + words + "'";
    std::error_code ignored;
    const bool is_file = std::filesystem::exists(words, ignored);
    TRY_ASSIGN(const auto text,
               is_file ? read_given_file(words, named, right_frame, largest) : Result<std::string>(words));
    const auto numbers = numbers_of(text);
    if (!numbers || numbers->size() != 16) return usage_error(named + ": must be " + right_frame);
    glm::dmat4 frame;
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            frame[column][row] = (*numbers)[static_cast<std::size_t>(4 * row + column)];
    if (!is_rigid(frame))
        return usage_error(named +
                           ": is no rotation and translation (its rows are not unit vectors at right angles, "
                           "or the last one is not 0 0 0 1, or it is a kilometre away); must be " +
                           right_frame);
    return frame;
}

Result<void> hold_devices(const HeldDeviceWords& words, SessionOptions& session) {
    const auto& devices = words.devices;
    const bool simulated = std::ranges::any_of(devices, is_simulated);
    if (simulated && devices.size() > 1)
        return usage_error("--device simulated is held by the hand alone, not beside another device");
    if (simulated) session.device = devices.front();
    if (devices.empty() || simulated) {
        if (words.force_on || words.world_from_camera || session.hand_scale != 1)
            return usage_error(
                "--force-on, --world-from-camera and --hand-scale are for a --device that you hold");
        return {};
    }
    if (!session.live) return usage_error("--device needs --live: a device is held in real time");
    if (words.world_from_camera) {
        if (session.hand_scale != 1)
            return usage_error(
                "--hand-scale with --world-from-camera: a metre of the world is a metre of the scene; leave "
                "one out");
        TRY_ASSIGN(session.world_from_camera, read_world_from_camera(*words.world_from_camera));
    }
    TRY_ASSIGN(session.held_device, make_held(words));
    if (session.held_device->fingers() > HandControl::most_fingers)
        return usage_error("--device: must have at most " + std::to_string(HandControl::most_fingers) +
                           " fingers");
    session.control = std::make_shared<HandControl>(session.held_device->fingers(), HandMapping{});
    session.control->ask_force(words.force_on);
    if (words.force_on) session.control->insist_on_force();
    ignore_stop_keys();
    return {};
}

std::vector<std::filesystem::path> files_of(const HeldDeviceWords& words) {
    std::vector<std::filesystem::path> files;
    const auto add_if_there = [&files](const std::string& name) {
        std::error_code ignored;
        if (!name.empty() && std::filesystem::is_regular_file(name, ignored)) files.emplace_back(name);
    };
    for (const std::string& device : words.devices) {
        std::string rest = device.substr(std::min(device.find(':') + 1, device.size()));
        add_if_there(rest);
        // A FILE in "FILE:key=value", and the values of keys.
        add_if_there(rest.substr(0, rest.rfind(':')));
        for (std::string item; !rest.empty(); rest = rest.substr(std::min(item.size() + 1, rest.size()))) {
            item = rest.substr(0, rest.find(','));
            add_if_there(item.substr(std::min(item.find('=') + 1, item.size())));
        }
    }
    if (words.world_from_camera) add_if_there(*words.world_from_camera);
    return files;
}

std::string how_to_begin(const HapticDevice& device, const HandControl& control, bool has_terminal) {
    const std::string forces = of_its_forces(device, control, has_terminal), prompt = device.prompt();
    return prompt.empty() ? forces : forces + "; " + prompt;
}

std::string state_of(const HapticDevice& device, const HandControl& control) {
    const std::string prompt = device.prompt();
    std::string forces = control.force_is_asked() ? "forces on" : "forces off";
    if (control.is_repositioned()) forces = "no force while the hand is repositioned";
    if (device.capabilities().axes_driven == 0) forces = "no force from this device";
    return prompt.empty() ? forces : forces + "; " + prompt;
}

void add_playback_options(CLI::App& sub, PlaybackTyped& typed) {
    begin_topic(sub, "Playback");
    add_number_option(sub, "--start", typed.start, "where in the clip to begin", 0, longest_seconds)
        ->type_name("SECONDS");
    add_number_option(sub, "--rate", typed.rate,
                      "playback speed, 0.001 to 8. 0.5: slow motion; fingers and forces keep their own time",
                      slowest_rate * 1e-3, fastest_rate * 1e-3);
    add_number_option(sub, "--loop", typed.loop, "repeat the part between two times in seconds", 0,
                      longest_seconds)
        ->expected(2)
        ->type_name("FROM TO");
    add_file_option(sub, "--play", typed.script,
                    "file of timed commands to the clip's clock: play, pause, rate, seek, step, loop "
                    "(docs/touch.md)");
}

Result<std::vector<PlaybackCommand>> read_playback(const PlaybackTyped& typed) {
    std::vector<PlaybackCommand> commands;
    if (typed.rate) commands.push_back({0, PlaybackVerb::rate, std::llround(*typed.rate * 1000), 0});
    const double start = typed.start.value_or(typed.loop.empty() ? 0 : typed.loop[0]);
    if (start > 0) commands.push_back({0, PlaybackVerb::seek, nanoseconds_of(start), 0});
    if (!typed.loop.empty()) {
        if (nanoseconds_of(typed.loop[1]) - nanoseconds_of(typed.loop[0]) < shortest_loop_ns)
            return usage_error("--loop must end 0.1 s or more after it begins");
        commands.push_back(
            {0, PlaybackVerb::loop, nanoseconds_of(typed.loop[0]), nanoseconds_of(typed.loop[1])});
    }
    if (!typed.script) return commands;
    TRY_ASSIGN(auto script, read_playback(*typed.script));
    commands.insert(commands.end(), script.begin(), script.end());
    return commands;
}

CLI::Option* add_painter_option(CLI::App& sub, std::string& painter) {
    return add_word_option(
               sub, "--painter", painter,
               "what draws. raster (compute) and mesh (triangles) need Vulkan; auto: the faster of "
               "the two on a GPU, otherwise cpu",
               {"auto", "cpu", "raster", "mesh"})
        ->default_str(painter);
}

void add_picture_options(CLI::App& sub, PictureOptions& options) {
    begin_topic(sub, picture_topic);
    auto* picture = add_file_option(sub, "--picture", options.file, "draw the scene as a PNG")
                        ->check(ends_in({".png"}, "a picture"));
    sub.add_option(
           "--view", options.view,
           "where to look from. own: the clip's camera; or orbit, with az=DEGREES, el=DEGREES, zoom=Z "
           "and fov=DEGREES, of which those left out are the clip's camera's")
        ->type_name(type_with_words("own|orbit:...", std::array{"own", "orbit:KEYS"}))
        ->needs(picture)
        ->capture_default_str();
    add_painter_option(sub, options.painter)->needs(picture);
    sub.add_option("--picture-size", options.size, "size in pixels")
        ->type_name("WxH")
        ->needs(picture)
        ->capture_default_str();
    const auto read_overlay = [&options](const std::string& name) -> Result<void> {
        if (name.empty()) return usage_error("names no overlay");
        TRY_ASSIGN(options.show, overlay_after(options.show, name));
        return {};
    };
    add_read_option(sub, "--show", read_overlay,
                    "what colours the surface. depth: equalised; errors: how wrong forces may point; "
                    "friction: static; tiles: which are drawn; validity: where there is depth")
        ->type_name(type_with_words("WORD", overlay_names()))
        ->needs(picture);
    add_word_option(sub, "--light", options.light, "light on the clip's colours, which shows relief",
                    {light_names.begin(), light_names.end()})
        ->default_str(options.light)
        ->needs(picture);
}

Result<std::optional<PictureOrder>> order_picture(const PictureOptions& options, Existing existing,
                                                  const BuilderChoice& choice, RunGpu& gpu) {
    if (!options.file) return std::optional<PictureOrder>();
    PictureOrder order;
    TRY_ASSIGN(order.settings.viewpoint, parse_viewpoint(options.view));
    TRY_ASSIGN(const auto size, read_pixel_size("--picture-size", options.size, 1, largest_side));
    order.settings.width = size.width;
    order.settings.height = size.height;
    if (options.draws_on_gpu() && choice.names_gpu()) TRY(gpu.open());
    TRY_ASSIGN(order.painter, make_painter(options.painter, [&gpu, &options] {
                   return options.painter == "auto" ? gpu.open_measured(measure_painters) : gpu.open();
               }));
    order.any_painter = options.painter == "auto";
    order.show = options.show;
    TRY_ASSIGN(order.light, light_after(order.light, options.light));
    order.file = std::make_unique<NewFile>(*options.file, existing);
    if (auto usable = order.file->hold(); !usable)
        return Error{usable.error().kind, "--picture " + usable.error().message};
    return std::optional<PictureOrder>(std::move(order));
}

Result<Image> PictureOrder::draw(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                                 std::span<const FingerMark> fingers) {
    Overlays overlays;
    const Overlays::Picture* const overlay =
        show == Overlay::colour ? nullptr : &overlays.paint(show, field, pair);
    const ViewSurface surface =
        surface_of(field, pair, overlay ? overlay->view() : colour, overlay ? light_of(show) : light);
    const Viewpoint::Subject subject = subject_of(field);
    TRY_ASSIGN(auto image, make_picture(settings, field.scene(), surface, subject, fingers,
                                        mark_sizes(field.scene(), subject.middle), *painter));
    if (overlay) TRY(draw_scale_bar(overlay->scale, image));
    return image;
}

Result<void> PictureOrder::deliver(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                                   std::span<const FingerMark> fingers) {
    auto image = draw(field, pair, colour, fingers);
    if (!image && image.error().kind == ErrorKind::gpu && any_painter) {
        say_on_stderr("warning: " + image.error().message + "; the cpu painter draws instead");
        painter = make_cpu_painter();
        image = draw(field, pair, colour, fingers);
    }
    if (!image) return image.error();
    TRY(write_png(*file, image->view()));
    return file->commit();
}

}  // namespace touchable
