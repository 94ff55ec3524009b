// SPDX-License-Identifier: Apache-2.0
// `touchable formats`: sources of depth, what to type for each, and the kinds of files. Each row of `rows` is
// a row of the table in docs/formats.md; tests/import/sources_test.cpp opens each source.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/base/words.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/formats/source_description.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {
namespace {

const DepthSource rows[] = {
    {"iphone", "iPhone portrait", ".heic as the phone made it", "touchable portrait.heic",
     "disparity, camera, colour; most programs that send or edit photos drop the depth", "nothing",
     "Phones and tablets"},
    {"iphone-jpeg", "iPhone portrait as JPEG", "IMG_0042.JPG, disparity behind it", "touchable IMG_0042.JPG",
     "disparity, camera, colour", "nothing"},
    {"cinematic", "iPhone Cinematic video", "IMG_0001.MOV, exported as \"Unmodified Original\"",
     "touchable IMG_0001.MOV", "disparity, colour, rate", "camera, scale"},
    {"iphone-tiff", "iPhone LiDAR apps that write TIFF", "NAME_depth.tiff (floats), NAME_image.jpg",
     "touchable NAME_depth.tiff", "depth, colour (under this name)", "camera, unit, planar"},
    {"dynamic-depth", "Android portrait, Dynamic Depth", "one .jpg, its depth map behind the picture",
     "touchable portrait.jpg", "depth, unit, camera, colour", "nothing"},
    {"gdepth", "Google Camera's Lens Blur, GDepth", "one .jpg, its depth map in the XMP",
     "touchable portrait.jpg", "depth, colour", "camera, unit"},
    {"depth16", "Android DEPTH16, ARCore", "PNG of the 16 bits: millimetres below a confidence",
     "touchable depth.png --preset depth16", "depth, unit", "camera"},
    {"record3d", "Record3D, export EXR + RGB", "depth/0.exr, rgb/0.jpg, metadata.json", "touchable my_take",
     "depth, camera, rate, colour, where the camera stood", "unit, planar"},
    {"record3d-video", "Record3D, export RGBD video", "one .mp4: hue on the left, colour on the right",
     "touchable export.mp4", "depth, unit, camera, colour, rate", "coding"},
    {"stray", "Stray Scanner", "depth/000000.png, rgb.mp4, camera_matrix.csv, odometry.csv",
     "touchable my_scan", "depth, camera, rate, colour", "unit"},
    {"polycam", "Polycam raw data", "keyframes/ with depth, images, cameras (one JSON a frame)",
     "touchable keyframes", "depth, camera of each frame, colour", "unit, rate"},
    {"nerf", "NeRFCapture, instant-ngp", "transforms.json, images/0.png, images/0.depth.png",
     "touchable my_capture", "depth, unit, camera, colour", "rate"},
    {"nerfstudio", "nerfstudio, ns-process-data",
     "transforms.json, images/frame_00001.png, depth/frame_00001.png", "touchable my_capture",
     "depth, camera, colour", "unit, rate"},
    {"arkitscenes", "ARKitScenes", "lowres_depth, lowres_wide, lowres_wide_intrinsics (.pincam)",
     "touchable 41048190", "depth, unit, camera of each frame, rate, colour (under these names)", "coding"},

    {"realsense", "RealSense Viewer snapshot", "snap_Depth.raw, snap_Depth_metadata.csv, snap_Color.png",
     "touchable snap_Depth.raw",
     "depth, unit, camera, colour (under these names); snap_Depth.png is depth in colours, of no use",
     "nothing", "Depth cameras"},
    {"realsense-bag", "RealSense recording", "one .bag of the Viewer or of librealsense",
     "touchable recording.bag", "depth, unit, camera, rate, colour on depth's pixels", "nothing"},
    {"ros1", "ROS 1 bag", "one .bag with topics of depth, colour and camera_info", "touchable recording.bag",
     "depth, camera, rate, colour", "unit"},
    {"ros2", "ROS 2 bag", ".mcap or .db3, or the folder with metadata.yaml", "touchable recording.mcap",
     "depth, camera, rate, colour", "unit"},
    {"azure-kinect", "Azure Kinect, Orbbec Femto Bolt and Mega", "one .mkv of k4arecorder",
     "touchable recording.mkv", "depth, unit, camera and lens, rate, colour on depth's pixels", "nothing"},
    {"kinect2", "Kinect v2 by libfreenect2", "np.save of Frame::Depth, 512x424 floats: millimetres",
     "touchable depth.npy --fov 70.6", "depth", "unit, planar"},
    {"kinect-raw", "Kinect v1 by libfreenect", "PNG of 16 bits with the 11 bits of freenect",
     "touchable my_recording", "depth, colour; the camera is a usual Kinect's", "rate, coding"},
    {"kinect-sdk1", "Kinect v1 by Microsoft's SDK 1", "PNG of 16 bits, a person's number in the lowest 3",
     "touchable depth.png", "depth, unit", "camera, coding"},
    {"zed", "ZED", "left000000.png, depth000000.png of svo_export.py --mode 4", "touchable my_export",
     "depth, colour", "camera, unit, rate, planar"},
    {"oak", "OAK, DepthAI", "PNG of 16 bits of StereoDepth's depth: millimetres",
     "touchable my_recording --fov 72", "depth, colour; --fov 69 where depth is aligned to colour",
     "unit, rate"},
    {"depthkit", "Depthkit", "Take.mp4, Take.Metadata.asset", "touchable Take.mp4",
     "depth, camera, rate, colour", "nothing"},

    {"blender", "Blender", "OpenEXR MultiLayer with the passes Combined and Z",
     "touchable render.exr --fov 39.6", "depth, colour, materials", "unit, planar",
     "Renderers and simulators"},
    {"unreal", "Unreal, Movie Render Queue", "EXR with a layer ...WorldDepth, centimetres",
     "touchable Shot.0001.exr --fov 90", "depth, unit, colour by its channel", "coding"},
    {"carla", "CARLA", "depth and rgb, PNG of image.save_to_disk", "touchable _out --preset carla",
     "depth, unit, colour; --fov where the sensor's is not 90", "camera, rate"},
    {"airsim", "AirSim", "np.save of get_pfm_array(response), metres", "touchable depth.npy --fov 90",
     "depth; of DepthPerspective --depth range. A .pfm by airsim.write_pfm opens upside down",
     "unit, planar"},
    {"isaac", "Isaac Sim, Omniverse Replicator",
     "distance_to_image_plane_0000.npy, rgb_0000.png, camera_params_0000.json", "touchable _out_camera",
     "depth, unit, camera, colour; distance_to_camera is along the ray (under this name)", "rate, planar"},
    {"unity", "Unity, EncodeFloatRGBA", "PNG: depth over a far plane of 10 m",
     "touchable depth.png --depth-unit 10", "depth", "camera, planar"},

    {"midas", "MiDaS, DPT", "PNG of 16 bits of run.py --grayscale: 1/depth",
     "touchable depth.png --preset relative-inverse", "order of depth", "camera, scale", "Networks"},
    {"depth-anything", "Depth Anything V1, V2", "PNG of --pred-only --grayscale: 1/depth",
     "touchable depth.png --preset relative-inverse", "order of depth", "camera, scale"},
    {"depth-anything-metric", "Depth Anything V2, metric", "NAME_raw_depth_meter.npy of --save-numpy",
     "touchable NAME_raw_depth_meter.npy", "depth", "camera, unit, planar"},
    {"da3", "Depth Anything 3", "results.npz: depth, conf, intrinsics, extrinsics", "touchable results.npz",
     "depth, each frame's camera; unsure places are left out", "unit, rate, planar"},
    {"vda", "Video Depth Anything", "NAME_depths.npz, NAME_src.mp4",
     "touchable NAME_depths.npz --preset relative-inverse",
     "order of depth, rate, colour (under these names)", "camera, scale"},
    {"moge", "MoGe", "depth.exr, fov.json, image.jpg", "touchable my_output", "depth, camera, colour",
     "unit, planar"},
    {"depth-pro", "Depth Pro", "NAME.npz, NAME.jpg", "touchable NAME.npz",
     "depth; NAME.jpg is depth in colours: put your photo in its place", "camera, unit, planar"},
    {"zoedepth", "ZoeDepth, save_raw_16bit", "PNG of 16 bits, 256 codes a metre",
     "touchable depth.png --depth-unit 0.00390625", "depth", "camera"},
    {"depth-buffer", "PyBullet, MuJoCo, robosuite, ReShade", "depth.npy, .exr, .tiff: 0 to 1, not linear",
     "touchable depth.npy --near 0.1 --far 100", "depth", "camera"},
    {"marigold", "Marigold", "depth_npy/NAME_pred.npy: 0 is near, 1 is far", "touchable NAME_pred.npy",
     "order of depth", "camera, scale"},
    {"rgbd", "RGB-D picture (Looking Glass, Depth3D)", "PNG or JPEG, colour beside or above depth",
     "touchable desk_rgbd.png", "order of depth, colour", "camera, scale"},
    {"mvsnet", "MVSNet, DTU", "depth_map_0000.pfm, millimetres", "touchable depth_map_0000.pfm", "depth",
     "camera, unit, planar"},

    {"tum", "TUM RGB-D", "depth.txt, rgb.txt, groundtruth.txt, depth/, rgb/",
     "touchable rgbd_dataset_freiburg1_xyz --preset tum",
     "depth, unit, times, colour, where the camera stood (under these names)", "nothing", "Data sets"},
    {"7scenes", "7-Scenes", "frame-000000.depth.png, .color.png, .pose.txt",
     "touchable seq-01 --preset 7scenes", "depth, unit, colour", "rate"},
    {"scannet", "ScanNet, exported", "depth/0.png, color/0.jpg, intrinsic/intrinsic_depth.txt",
     "touchable scene0000_00 --preset scannet", "depth, unit, camera, colour", "rate"},
    {"midair", "Mid-Air, CO3D", "PNG of 16 bits, each the bits of a 16-bit float",
     "touchable trajectory_3000", "depth, colour", "camera, unit, rate, planar, coding"},
    {"bop", "BOP", "depth/000000.png, rgb/, scene_camera.json", "touchable 000001",
     "depth, unit and camera of each frame, colour", "rate"},
    {"nyu", "NYU Depth, raw", "d-TIME-TICKS.pgm, r-TIME-TICKS.ppm", "touchable basement_0001a --preset nyu",
     "depth, unit, times, colour", "nothing"},
    {"sun", "SUN RGB-D", "depth/NAME.png, image/NAME.jpg, intrinsics.txt", "touchable NYU0001 --preset sun",
     "depth, unit, camera, colour", "nothing"},
    {"redwood", "Redwood, Open3D", "depth/, image/ or color/: PNG, JPEG",
     "touchable my_scan --preset redwood", "depth, unit, colour, where the camera stood", "rate"},
    {"icl", "ICL-NUIM, TUM's form", "depth/0.png, rgb/0.png", "touchable living_room_traj0 --preset icl",
     "depth, unit, colour", "rate"},
    {"void", "VOID", "ground_truth/, image/, K.txt", "touchable office0 --preset void",
     "depth, unit, camera, times, colour; ground_truth before sparse_depth (under this name)", "nothing"},
    {"kitti", "KITTI depth", "proj_depth/groundtruth/image_02/0000000005.png",
     "touchable image_02 --preset kitti", "depth, unit", "rate"},
    {"kitti-stereo", "KITTI stereo", "disp_occ_0/000000_10.png, image_2/, calib_cam_to_cam/000000.txt",
     "touchable training", "disparity, baseline, camera, colour (under these names)", "unit, coding"},
    {"vkitti", "Virtual KITTI 2", "frames/depth/Camera_0/depth_00000.png, intrinsic.txt",
     "touchable frames/depth/Camera_0 --preset vkitti", "depth, unit, camera (under these names)", "rate"},
    {"diode", "DIODE", "NAME_depth.npy, NAME_depth_mask.npy, NAME.png", "touchable NAME_depth.npy",
     "depth, colour (under this name)", "camera, unit, planar"},
    {"middlebury", "Middlebury stereo", "disp0.pfm, im0.png, calib.txt",
     "touchable disp0.pfm --preset middlebury", "disparity, baseline, camera, colour (under this name)",
     "nothing"},
    {"tartanair", "TartanAir V2", "depth_lcam_front/, image_lcam_front/: PNG, depth of floats in RGBA",
     "touchable P000 --fov 90", "depth, colour", "unit, rate, planar, coding"},
    {"pointodyssey", "PointOdyssey", "depths/depth_00000.png, rgbs/rgb_00000.jpg, anno.npz",
     "touchable ani --depth-unit 0.01525902", "depth, camera, colour", "rate"},
    {"sintel", "MPI Sintel", "depth/alley_1/frame_0001.dpt", "touchable alley_1", "depth",
     "camera, unit, rate, planar"},
    {"lerobot", "LeRobot", "meta/info.json, videos/KEY/chunk-000/file-000.mp4", "touchable my_data_set",
     "depth, unit, rate, colour (under these names)", "camera"},
    {"hypersim", "Hypersim", "frame.0000.depth_meters.hdf5, floats along each ray",
     "touchable scene_cam_00_geometry_hdf5 --fov 60", "depth, unit, along each ray (under this name)",
     "rate, planar"},
    {"nyuv2", "NYU Depth v2, labeled", "nyu_depth_v2_labeled.mat (HDF5)",
     "touchable nyu_depth_v2_labeled.mat --fov 57.8", "depths, 1449 frames", "unit, rate, planar"},
    {"robomimic", "robomimic", "HDF5 with data/demo_0/obs/agentview_depth",
     "touchable image_demo.hdf5 --dataset /data/demo_1/obs/agentview_depth --fov 45", "that demo's depth",
     "unit, rate, planar"},
    {"pcl", "PCL, Open3D, an organised cloud", "PCD with HEIGHT above 1, PLY with a grid",
     "touchable cloud.pcd", "depth, camera, colour", "unit"},
};

/// Meaning of the words in `guessed`, and the options that correct them.
constexpr std::pair<std::string_view, std::string_view> guesses[] = {
    {"camera", "camera: what it sees from left to right (--fov DEGREES, --intrinsics FX,FY)"},
    {"unit", "unit: metres that a stored 1 stands for (--depth-unit METRES)"},
    {"scale", "scale: the nearest is taken for 0.5 m, the farthest for 1.5 m (a scene file)"},
    {"rate", "rate: 30 frames a second (a scene file)"},
    {"planar", "planar: depth goes along the camera's axis, not along each ray (--depth range)"},
    {"coding", "coding: how depth is stored, by its values (--preset NAME)"},
};

/// Whether a row's example uses this format.
bool is_in_rows(const ClipFormat& format) {
    std::string command = format.command + typed_options(format.settings);
    if (const auto at = command.find(" play "); at != std::string::npos) command.erase(at, 5);
    return std::ranges::any_of(rows, [&](const DepthSource& row) { return row.command == command; });
}

nlohmann::ordered_json in_json(const DepthSource& row) {
    return {{"name", row.name},       {"what", row.what}, {"files", row.files},
            {"command", row.command}, {"read", row.read}, {"guessed", row.guessed}};
}

nlohmann::ordered_json in_json(const SourceDescription::Preset& preset) {
    return {{"name", preset.name}, {"what", preset.what}};
}

nlohmann::ordered_json all_in_json() {
    nlohmann::ordered_json sources, others, presets;
    for (const DepthSource& row : rows) sources.push_back(in_json(row));
    for (const ClipFormat& format : clip_formats())
        if (!is_in_rows(format))
            others.push_back(
                {{"what", format.what}, {"command", format.command + typed_options(format.settings)}});
    for (const auto& preset : all_presets()) presets.push_back(in_json(preset));
    return {{"touchable_formats", 1}, {"sources", sources}, {"other_files", others}, {"presets", presets}};
}

Result<void> print_formats(const JsonOutput& json) {
    if (json.replaces_words()) return json.write(all_in_json());
    std::cout << "I have ..., what do I type? More of one: touchable formats NAME, such as bop.\n";
    for (const DepthSource& row : rows) {
        if (row.heading) std::cout << '\n' << row.heading << '\n';
        std::cout << "  " << row.name << '\n'
                  << paragraph(std::string(row.what) + ": " + row.files, 6) << paragraph(row.command, 6);
    }
    std::cout << "\nOther files (docs/formats.md)\n";
    for (const ClipFormat& format : clip_formats())
        if (!is_in_rows(format))
            std::cout << paragraph(format.what, 2)
                      << paragraph(format.command + typed_options(format.settings), 6);
    std::cout << "  any of these with a map of touch (docs/scene_file.md)\n"
                 "      --haptic PICTURE, X3D or glTF; --height PICTURE\n"
                 "\nPresets of pictures, --preset NAME\n"
              << paragraph(listed(all_presets(), &SourceDescription::Preset::name), 6)
              << "  of videos\n"
                 "      hue (depth is hue), mean (depth is the mean of red, green and blue)\n";
    return json.write(all_in_json());
}

Result<void> print_source(const std::string& name, const JsonOutput& json) {
    const auto* const row = std::ranges::find(rows, name, &DepthSource::name);
    const auto* const preset = preset_named(name);
    const bool is_row = row != std::end(rows);
    if (!is_row && !preset) {
        std::vector<std::string> names;
        for (const DepthSource& each : rows) names.emplace_back(each.name);
        const std::string meant = nearest_word(name, names);
        return usage_error(
            "formats: no source is called " + in_quotes(name) +
            (meant.empty() ? "; touchable formats lists them" : "; did you mean " + meant + '?'));
    }
    nlohmann::ordered_json json_of_it{{"touchable_source", 1}};
    json_of_it.update(is_row ? in_json(*row) : in_json(*preset));
    if (json.replaces_words()) return json.write(json_of_it);
    const auto print = [](const std::string& title, const std::string& text) {
        std::cout << "  " << title << '\n' << paragraph(text, 6);
    };
    if (is_row) {
        std::cout << name << ": " << row->what << '\n';
        print("files", row->files);
        print("type", row->command);
        print("read", row->read);
        std::cout << "  guessed, as touchable info says\n";
        const std::string guessed = row->guessed;
        if (guessed == "nothing") std::cout << paragraph(guessed, 6);
        for (const auto& [word, meaning] : guesses)
            if (guessed.find(word) != std::string::npos) std::cout << paragraph(std::string(meaning), 6);
    }
    if (preset) print("--preset " + name, preset->what);
    return json.write(json_of_it);
}

}  // namespace

std::span<const DepthSource> depth_sources() {
    return rows;
}

void add_formats_command(CLI::App& app, Command& command) {
    auto* const sub = app.add_subcommand("formats", "list what can be opened, and how");
    auto name = std::make_shared<std::string>();
    std::vector<const char*> names;
    for (const DepthSource& row : rows) names.push_back(row.name);
    sub->add_option("NAME", *name, "print all about this one, or about a preset")
        ->type_name(type_with_words("NAME", names));
    auto json = std::make_shared<JsonOutput>();
    add_json_option(*sub, *json, "print the same as JSON");
    set_work(*sub, command, [name, json]() -> Result<void> {
        TRY(json->check());
        return name->empty() ? print_formats(*json) : print_source(small_letters(*name), *json);
    });
}

}  // namespace touchable
