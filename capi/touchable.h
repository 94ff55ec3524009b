// SPDX-License-Identifier: Apache-2.0
/**
 * @file touchable.h
 * Touch depth pictures and depth video from C and from languages that can call C.
 *
 * This header belongs to two libraries:
 *   libtouchable         scenes, surfaces and the touch solver; needs neither FFmpeg nor Vulkan
 *   libtouchable-media   opens and writes files (the part under "Clips")
 *
 * Overview: a scene describes the pictures' camera and coding, a surface is built from the pictures that you push,
 * and a solver takes the goals of fingers, 1000 times a second, and returns their forces.
 *
 * Units: lengths are scene units unless a name states another unit; touch_scene_describe gives the metres per scene
 * unit (1 for scenes made by touch_scene_from_camera). Forces are newtons. Axes: X right, Y up, the camera at the
 * origin looks along -Z. Times are nanoseconds of the pictures' own clock.
 *
 * Stability: the API does not change before 1.0, except for functions marked "Not yet stable", which a minor version
 * may change.
 *
 * Rules for all functions:
 *   - A function returns a status; 0 is TOUCH_OK. (Only touch_version and touch_status_name do not.) On
 *     failure a function with a touch_error writes one line to it that states the fault and the valid values; with
 *     TOUCH_OK the error is not changed. The error may be NULL.
 *   - Handles are numbers. A handle that was destroyed, or never made, gives TOUCH_STALE; it never crashes.
 *   - Structs begin with their size, which you set to sizeof, so that a newer library supports an older program.
 *     The *_defaults functions set the size and every member.
 *   - Memory that you pass stays yours; the library does not keep it after the call.
 *   - A function throws no exception, prints nothing, starts no thread unless you request threads, and does not
 *     change locale or signals.
 *   - "Real-time" in a description: the function does not allocate, lock, wait or make system calls. All others may.
 *   - fork(): clips, writers, surfaces and solvers belong to the process that made them, like their threads and files.
 *     In a child process they give TOUCH_FORKED; ending them there returns TOUCH_OK and only forgets them. Scenes and
 *     framesets are memory, which a child process has too. A child must make its own objects.
 *   - "Threads": two threads may use different objects at once. Use one object from one thread at a time, unless
 *     its functions state otherwise; a second thread gets TOUCH_BUSY.
 */
#ifndef TOUCHABLE_H
#define TOUCHABLE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Marks the exported functions. */
#if defined(__GNUC__)
#define TOUCH_API __attribute__((visibility("default")))
#else
#define TOUCH_API
#endif

/** Version of this header: major * 10000 + minor * 100 + patch. */
#define TOUCH_VERSION 300

/* ---- Statuses and errors ------------------------------------------------------------------------------------- */

/** Result of a call: TOUCH_OK, or why it failed. */
typedef int32_t touch_status;
#define TOUCH_OK 0            /**< done */
#define TOUCH_INTERNAL 1      /**< a fault of the library */
#define TOUCH_USAGE 2         /**< an invalid argument: NULL, a size, a number out of range */
#define TOUCH_INPUT 3         /**< an invalid file, scene text or picture */
#define TOUCH_INTERRUPTED 130 /**< a stop was requested */
#define TOUCH_STALE 16        /**< the handle is not of this kind, or was destroyed */
#define TOUCH_BUSY 17         /**< another thread is using the object, or another object depends on it */
#define TOUCH_FULL 18         /**< no room for another frame yet; try again after more ticks */
#define TOUCH_END 19          /**< there are no more frames */
#define TOUCH_NO_MEMORY 20    /**< there is not enough memory, or there are too many objects */
#define TOUCH_FORKED 21       /**< the object was made before fork(), by the parent process */
#define TOUCH_EXISTS 22       /**< a file of that name exists, and may not be replaced */

/** What went wrong, in one line of UTF-8 without a newline. */
typedef struct touch_error {
    uint32_t struct_size; /**< sizeof(touch_error); you set it */
    touch_status status;  /**< what the function returned */
    char line[504]; /**< zero-terminated; a longer line is cut */
} touch_error;

/** The library's own TOUCH_VERSION. Real-time. */
TOUCH_API uint32_t touch_version(void);
/** A status in a word or two, such as "stale handle"; "unknown status" for any other number. Never NULL; the text is
 * static. Real-time. */
TOUCH_API const char *touch_status_name(touch_status status);

/* ---- Scenes -------------------------------------------------------------------------------------------------- */

/** Describes pictures: camera, depth and height coding, haptic ranges, filters. Immutable once made. */
typedef struct touch_scene {
    uint64_t id; /**< 0 is never a scene */
} touch_scene;

#define TOUCH_PLANAR 0 /**< depth is measured along -Z, as by depth cameras */
#define TOUCH_RANGE 1  /**< depth is measured along the pixel's ray */

/** A pinhole camera, its depth coding, and the stiffness and friction of its surface. */
typedef struct touch_camera {
    uint32_t struct_size; /**< sizeof this struct in your program; you set it */
    int32_t width;               /**< pixels, 1 to 16384 */
    int32_t height;              /**< pixels, 1 to 16384 */
    int32_t depth_kind;          /**< TOUCH_PLANAR or TOUCH_RANGE */
    double fx_px;                /**< focal length across, pixels, > 0 */
    double fy_px;                /**< focal length down, pixels, > 0 */
    double cx_px;                /**< column of the principal point, pixels; pixel (0, 0) has its centre at (0, 0) */
    double cy_px;                /**< its row, pixels */
    double metres_per_code;      /**< of uint16 depth, > 0; 0.001: millimetres. Depth as floats is metres, rounded to this;
                                    65535 times this is the largest possible depth. 0, the default: not stated: floats
                                    are rounded to far_m / 65534, and uint16 depth is millimetres; if a surface or clip
                                    has both, its first frame decides, and the others are rounded to its steps */
    double far_m;                /**< deeper pixels have no surface; metres, > 0. See touch_frame.lost_pixels */
    double frames_per_second;    /**< > 0; used for frames that are counted, not timed */
    double stiffness_n_per_m;    /**< used without a haptic picture; >= 0 */
    double static_friction;      /**< used without a haptic picture; coefficient >= 0 */
    double dynamic_friction;     /**< used without a haptic picture; coefficient, 0 to static_friction */
} touch_camera;

/** Fills in 640x480 pixels, 60 degrees wide, planar depth up to 10 m, metres_per_code 0, 30 frames/s, 600 N/m, friction
 * 0.4 and 0.3. `struct_size`: sizeof(touch_camera) in your program. TOUCH_USAGE: NULL, or an unknown size. */
TOUCH_API touch_status touch_camera_defaults(touch_camera *camera, uint32_t struct_size);
/** Makes a scene from a camera; its scene unit is a metre, and no filter is on (see touch_scene_with_filters). Holes
 * and the picture's edge have 100 N/m (`hole_stiffness`), as in pictures that the program opens: so the force of a
 * surface that vanishes falls by a ramp. TOUCH_USAGE: a member is out of range; the error names it. */
TOUCH_API touch_status touch_scene_from_camera(const touch_camera *camera, touch_scene *scene, touch_error *error);
/** Makes a scene from the text of a scene file (docs/scene_file.md), JSON of `length` bytes in UTF-8. TOUCH_INPUT: the
 * error names the member. Filters that the text does not state are off (see touch_scene_with_filters). */
TOUCH_API touch_status touch_scene_from_text(const char *text, size_t length, touch_scene *scene, touch_error *error);
/** Writes the scene as the text of a scene file, from which the same scene can be made, to the last bit. Writes at
 * most `capacity` bytes, with a terminating zero if there is room, to `text` (may be NULL if capacity is 0), and the
 * length of the whole text, without the zero, to `*length`. */
TOUCH_API touch_status touch_scene_text(touch_scene scene, char *text, size_t capacity, size_t *length);

/** Facts of a scene. */
typedef struct touch_scene_facts {
    uint32_t struct_size;         /**< sizeof this struct in your program; you set it */
    int32_t width;                /**< of depth, pixels */
    int32_t height;               /**< of depth, pixels */
    int32_t depth_kind;           /**< TOUCH_PLANAR or TOUCH_RANGE */
    double fx_px;                 /**< focal length across, pixels */
    double fy_px;                 /**< focal length down, pixels */
    double cx_px;                 /**< column of the principal point, pixels */
    double cy_px;                 /**< row of the principal point, pixels */
    double metres_per_scene_unit; /**< in the world that the camera saw */
    double near_units;            /**< the nearest valid depth, scene units */
    double far_units;             /**< the deepest valid depth, scene units */
    double frames_per_second;     /**< of the pictures; the mean rate if each has its own time */
    double hand_metres_per_scene_unit; /**< in the hand, as stated by the scene; 0: not stated */
    int32_t unstated_filters;     /**< 1: touch_scene_with_filters would choose some; 0: all are stated */
    int32_t reserved;             /**< 0 */
} touch_scene_facts;

/** Fills in `facts`, whose struct_size you set. Real-time. */
TOUCH_API touch_status touch_scene_describe(touch_scene scene, touch_scene_facts *facts);
/** Destroys a scene. Surfaces made from it remain. */
TOUCH_API touch_status touch_scene_destroy(touch_scene scene);

/* ---- Frames -------------------------------------------------------------------------------------------------- */

#define TOUCH_U8 1  /**< uint8_t */
#define TOUCH_U16 2 /**< uint16_t, this machine's byte order */
#define TOUCH_F32 4 /**< float, depth only: metres; values <= 0, not finite or outside the scene's depths: no surface */

/** A picture in memory that the struct does not own. */
typedef struct touch_plane {
    const void *data;     /**< the first row; NULL: no picture */
    int64_t stride_bytes; /**< from one row to the next; may be negative, may have gaps */
    int32_t width;        /**< pixels; must be the scene's */
    int32_t height;       /**< pixels; must be the scene's */
    int32_t sample;       /**< TOUCH_U8, TOUCH_U16 or TOUCH_F32, which is also its size in bytes */
    int32_t channels;     /**< 1, or 3 interleaved (red, green, blue) */
} touch_plane;

/** The pictures of one moment. Only depth is required. */
typedef struct touch_frame {
    uint32_t struct_size; /**< sizeof this struct in your program; you set it */
    int32_t reserved;    /**< 0 */
    int64_t number;      /**< from 0; later frames have larger numbers */
    int64_t time_ns;     /**< when it is shown */
    touch_plane depth;   /**< codes as in the scene (1 channel; hue coding: 3 channels of 8 bits), or TOUCH_F32 */
    touch_plane colour;  /**< 3 channels, TOUCH_U8; does not affect touch */
    touch_plane haptic;  /**< 3 channels, TOUCH_U8: stiffness, static and dynamic friction */
    touch_plane height;  /**< 1 channel: roughness */
    int64_t *lost_pixels; /**< NULL, or the output for the number of TOUCH_F32 pixels whose depth (finite, above 0) lies
                             outside the scene's depths, so that they have no surface. A renderer's background (1e9 and
                             beyond, or 65504) does not count. If most depths are lost, the frame is refused with
                             TOUCH_USAGE */
    double *lost_degrees; /**< NULL, or the output for the mean angle, degrees, by which rounding to metres_per_code turns
                             the faces of TOUCH_F32 depth; 0 for codes. A smaller far_m, or finer steps, turn them less */
} touch_frame;

/** Fills in an empty frame: number 0, time 0, no picture. `struct_size`: sizeof(touch_frame) in your program. */
TOUCH_API touch_status touch_frame_defaults(touch_frame *frame, uint32_t struct_size);

/** Converts a picture of depth codes to metres, as floats; NaN: no surface. Depth is along -Z, or along the pixel's
 * ray if the scene's depth_kind is TOUCH_RANGE. `metres` has the scene's width and height, and rows of
 * `stride_bytes`, at least 4 * width. TOUCH_USAGE: a smaller stride, or depth of another size or kind than the
 * scene's. */
TOUCH_API touch_status touch_scene_metres(touch_scene scene, const touch_plane *depth, float *metres,
                                          int64_t stride_bytes, touch_error *error);

/** Makes the scene with the filters that the program `touchable` would choose from these frames (the first `count` of
 * a recording; 16 are enough, more are ignored). Filters that the scene states are kept; for a scene made from a
 * camera all are chosen. Without frames they stay off. A frame without any surface is ignored. TOUCH_USAGE: a frame
 * does not match the scene, or the scene states the temporal filter but the noise of depth is unknown. Not yet
 * stable. */
TOUCH_API touch_status touch_scene_with_filters(touch_scene scene, const touch_frame *frames, size_t frame_stride_bytes,
                                                size_t count, touch_scene *filtered, touch_error *error);

/* ---- Surfaces ------------------------------------------------------------------------------------------------ */

/** A surface that changes in time: one thread pushes frames, another reads it with a solver; neither waits for the
 * other. */
typedef struct touch_surface {
    uint64_t id; /**< 0 is never a surface */
} touch_surface;

/** Settings of a surface. */
typedef struct touch_surface_settings {
    uint32_t struct_size; /**< sizeof this struct in your program; you set it */
    int32_t threads; /**< that filter a frame, with the caller's: 1 to 16; more than 1 starts threads. Default 1 */
    int32_t frames;  /**< kept at once, 4 to 64; default 4: those that the solver reads, and two more. Or 1: the newest,
                        for touch_surface_filtered; the surface is never full, and has no solver */
    int32_t error_bars; /**< 1: frames are measured for how wrong their touch may be (touch_contact: error_degrees); 0,
                           the default: they are not */
} touch_surface_settings;

/** Fills in 1 thread and 4 frames. `struct_size`: sizeof(touch_surface_settings) in your program. TOUCH_USAGE: NULL,
 * or an unknown size. */
TOUCH_API touch_status touch_surface_settings_defaults(touch_surface_settings *settings, uint32_t struct_size);
/** Makes a surface without a frame. `settings` may be NULL: defaults. TOUCH_USAGE: a setting is out of range. */
TOUCH_API touch_status touch_surface_create(touch_scene scene, const touch_surface_settings *settings,
                                            touch_surface *surface, touch_error *error);
/** Filters a frame and publishes it. `time_ns` and `number` must increase within an epoch. TOUCH_FULL: the solver
 * still needs all frames; nothing has changed, try again. TOUCH_USAGE: a picture has another size or kind than the
 * scene's, the number or time is not later, or the epoch has ended. Threads: one may push while another ticks. */
TOUCH_API touch_status touch_surface_push(touch_surface surface, const touch_frame *frame, touch_error *error);
/** Begins an epoch, for example after a seek: frames pushed from now on belong to it and may have any times. `epoch`
 * must be larger than before (the first is 0). The solver changes to it once its ticks name it and two of its frames
 * are published. TOUCH_USAGE: the number is not larger. Not yet stable. */
TOUCH_API touch_status touch_surface_begin_epoch(touch_surface surface, uint64_t epoch, touch_error *error);
/** Ends the epoch: it gets no more frames; its last one stands still, even if it is the only one. Not yet stable. */
TOUCH_API touch_status touch_surface_end_epoch(touch_surface surface);
/** Time of the newest frame; INT64_MIN before an epoch's first. In virtual time, push until it is later than the
 * tick's time. Any thread. Real-time. */
TOUCH_API touch_status touch_surface_newest_ns(touch_surface surface, int64_t *time_ns);
/** Metres of hand motion per scene unit, as chosen by the program `touchable`: the scene's value if stated; otherwise
 * the picture's width at the median depth of the first frame pushed is 0.16 m. TOUCH_USAGE before that frame. */
TOUCH_API touch_status touch_surface_hand_scale(touch_surface surface, double *metres_per_scene_unit,
                                                touch_error *error);
/** Memory for what filters make of a frame's depth: floats, row by row, each row `..._stride_bytes` after the one
 * before, a multiple of 4. NULL: not wanted. NaN: no surface. */
typedef struct touch_filtered {
    uint32_t struct_size; /**< sizeof this struct in your program; you set it */
    int32_t reserved;     /**< 0 */
    float *metres;        /**< width floats a row: depth, as the scene's depth_kind measures it */
    int64_t metres_stride_bytes; /**< at least 4 * width */
    float *normals;       /**< 3 * width floats a row: the surface's unit normal (x, y, z), towards the camera. NaN also where
                             no neighbour shows how the surface lies */
    int64_t normals_stride_bytes; /**< at least 12 * width */
    float *error_degrees; /**< width floats a row: about 95 of 100 normals are off by less (docs/measurements.md, Error bars).
                             Needs touch_surface_settings.error_bars */
    int64_t error_degrees_stride_bytes; /**< at least 4 * width */
} touch_filtered;

/** Hands out the frame pushed last as its filters leave it (touch_scene_with_filters chooses them). TOUCH_USAGE: a stride
 * that is too small or odd, no frame yet, or error_degrees without error_bars. Threads: that which pushes. Not yet
 * stable. */
TOUCH_API touch_status touch_surface_filtered(touch_surface surface, const touch_filtered *filtered, touch_error *error);
/** Destroys a surface and its frames. TOUCH_BUSY while it has a solver: destroy that first. */
TOUCH_API touch_status touch_surface_destroy(touch_surface surface);

/* ---- The solver ---------------------------------------------------------------------------------------------- */

/** One to 256 fingers on a surface: each has a proxy, which stays on the surface, and a guard that limits its force.
 * A force is a pure function of frames, goals, times and settings: the same bits on every machine. */
typedef struct touch_solver {
    uint64_t id; /**< 0 is never a solver */
} touch_solver;

/** Number of fingers and limits of their forces. */
typedef struct touch_solver_settings {
    uint32_t struct_size; /**< sizeof this struct in your program; you set it */
    int32_t fingers;              /**< 1 to 256; default 1 */
    double metres_per_scene_unit; /**< of the hand: a force is stiffness * this * (proxy - goal). 0, the default:
                                     touch_surface_hand_scale */
    double max_force_n;           /**< per finger, 1e-6 to 1e9; default 10. No force ever exceeds it */
    double max_stiffness_n_per_m; /**< 1e-3 to 1e12; default 10000 */
    double damping_n_s_per_m;     /**< of a damper added in contact, >= 0; default 0 */
    double passivity_n_s_per_m;   /**< largest damping of the passivity controller; 0, the default: off */
    double stribeck_m_per_s;      /**< friction decreases with speed (Stribeck); 0, the default: Coulomb friction */
    int64_t stale_after_ns;       /**< if the newest frame is older, forces ramp to zero; 0, the default: never */
    int32_t ramp_in_ticks;        /**< from the first tick, and after a fault; default 100 */
    int32_t ramp_out_ticks;       /**< after a goal that is not a number; default 100 */
    int32_t waits_to_be_free;     /**< 1: a finger that begins inside the surface has no force until it has been free;
                                     recommended for a real hand; 0, the default: off */
    int32_t reserved;             /**< 0 */
} touch_solver_settings;

/** A position in scene units, or a force in newtons. */
typedef struct touch_vec3 {
    double x; /**< to the right */
    double y; /**< up */
    double z; /**< towards the camera */
} touch_vec3;

/** A tick and the surface's moment at which it is solved. */
typedef struct touch_tick {
    uint32_t struct_size; /**< sizeof this struct in your program; you set it */
    int32_t reserved;       /**< 0 */
    int64_t tick;           /**< milliseconds of the hand's time; must increase: ticks between are missed, and more than
                               50 ms are a gap (touch_solver_come_back) */
    int64_t time_ns;        /**< moment of the frames' clock; must not decrease within an epoch */
    uint64_t epoch;         /**< epoch of this time; 0 unless touch_surface_begin_epoch was called */
    int64_t epoch_start_ns; /**< start of that epoch */
} touch_tick;

#define TOUCH_GUARD_STIFFNESS 1   /**< stiffness limited to max_stiffness_n_per_m */
#define TOUCH_GUARD_FORCE 2       /**< force limited to max_force_n */
#define TOUCH_GUARD_RAMP 4        /**< ramping in */
#define TOUCH_GUARD_FAULT 8       /**< a goal or a surface was missing or invalid: ramping to zero */
#define TOUCH_GUARD_RISE 16       /**< stiffness is still rising to the map's, by at most 4 N/mm per second */
#define TOUCH_GUARD_DAMPING 32    /**< a damper's force added */
#define TOUCH_GUARD_PASSIVITY 64  /**< the passivity controller's force added */
#define TOUCH_GUARD_JUMP 128      /**< the surface jumped: the force changes over 100 ms */
#define TOUCH_GUARD_WAITING 256   /**< no force until the finger has been free */
#define TOUCH_GUARD_GAP 512       /**< the hand was away before this tick */
#define TOUCH_GUARD_STALE 1024    /**< the surface is too old, or was */
#define TOUCH_GUARD_UNSTEADY 2048 /**< touch_surface_forces_at: the force still changes after 500 ticks */

/** A finger's contact and force in a tick. */
typedef struct touch_contact {
    uint32_t struct_size;     /**< bytes that the library filled in */
    uint32_t guard;           /**< TOUCH_GUARD_ bits: why the force differs from the solver's; 0: it does not */
    touch_vec3 force_n;       /**< force for the hand: guarded, never NaN, never longer than max_force_n */
    touch_vec3 goal;          /**< scene units: as given, or the last valid one */
    touch_vec3 proxy;         /**< scene units: position held by the surface; the goal itself out of contact */
    double pixel_x;           /**< column of the proxy in the picture, pixels; NaN if no pixel sees it */
    double pixel_y;           /**< its row, pixels; NaN if pixel_x is */
    double stiffness_n_per_m; /**< at the proxy; 0 out of contact */
    double static_friction;   /**< coefficient at the proxy; 0 out of contact */
    double dynamic_friction;  /**< coefficient at the proxy; 0 out of contact */
    int32_t touching;         /**< 1 in contact */
    int32_t in_hole;          /**< 1 if the proxy rests on a hole's wall or ground */
    double error_degrees; /**< about 95 of 100 forces err by less in direction because depth is wrong; NaN out of contact and
                             without touch_surface_settings.error_bars. docs/measurements.md, Error bars */
    double error_newtons; /**< the same of the spring's size, before limits, and less sure; NaN if error_degrees is */
} touch_contact;

/** Fills in each member's default. `struct_size`: sizeof(touch_solver_settings) in your program. TOUCH_USAGE: NULL, or
 * an unknown size. */
TOUCH_API touch_status touch_solver_settings_defaults(touch_solver_settings *settings, uint32_t struct_size);
/** Makes a solver for the surface. `settings` may be NULL: defaults. A surface has one solver at a time (TOUCH_BUSY).
 * TOUCH_USAGE: a setting is out of range, or metres_per_scene_unit is 0 and no frame was pushed yet. */
TOUCH_API touch_status touch_solver_create(touch_surface surface, const touch_solver_settings *settings,
                                           touch_solver *solver, touch_error *error);
/** Solves one tick. `goals` and `contacts` have one element per finger; `contact_stride_bytes`: sizeof(touch_contact)
 * in your program. A goal that is not a number, or far outside the scene, counts as missing: its force ramps to zero.
 * Before the first frame all forces are zero. A hand that stands still gets no force back in one step, however many
 * ticks were missed: it rises by ramps of 100 ticks. TOUCH_USAGE: NULL, an invalid stride, or a tick not larger than
 * the previous one; nothing has changed then. Real-time. Threads: one may tick while another pushes frames. */
TOUCH_API touch_status touch_solver_tick(touch_solver solver, const touch_tick *tick, const touch_vec3 *goals,
                                         touch_contact *contacts, size_t contact_stride_bytes);
/** Solves `count` ticks in one call, each with the frames published by then: tick k is `first` plus k ticks and k
 * milliseconds. `goals` and `contacts`: fingers of tick 0, fingers of tick 1, ... Real-time except for its length. */
TOUCH_API touch_status touch_solver_run(touch_solver solver, const touch_tick *first, size_t count,
                                        const touch_vec3 *goals, touch_contact *contacts, size_t contact_stride_bytes);
/** The hand was away before the next tick: force returns by its ramp, and with waits_to_be_free only to fingers that
 * have been free. A tick more than 50 ms after the previous one does this itself; call it where the ticks do not tell,
 * as after a clutch. Real-time. */
TOUCH_API touch_status touch_solver_come_back(touch_solver solver);
/** XXH64 of all forces since the solver was made, printed by the program as "force hash": equal hashes mean equal
 * forces to the last bit. Real-time. */
TOUCH_API touch_status touch_solver_force_hash(touch_solver solver, uint64_t *hash);

/** Writes what the solver remembers after its last tick, at most `capacity` bytes of it (some 700 a finger); `length`:
 * all of them. A solver with the same scene and settings goes on from there with the same forces to the bit, in another
 * process or on another machine. No frames are in it. TOUCH_USAGE: NULL, or no tick yet. Not real-time: it reads the
 * whole surface, to know it again. Not yet stable. */
TOUCH_API touch_status touch_solver_save(touch_solver solver, void *state, size_t capacity, size_t *length);
/** Goes back, or on, to a saved state. The surface must have the frames around the moment of its last tick, and none
 * that are later may have been met: after a jump back make another surface and push them again, with a temporal filter
 * from the beginning. The next tick is a later one than that. TOUCH_INPUT: damaged, of another version, scene or
 * settings, or of other frames than the surface has (the line says which); nothing has changed then. Not real-time. Not
 * yet stable. */
TOUCH_API touch_status touch_solver_load(touch_solver solver, const void *state, size_t length, touch_error *error);
/** XXH64 of what touch_solver_save writes: equal hashes mean equal forces from now on. Not real-time. Not yet stable. */
TOUCH_API touch_status touch_solver_state_hash(touch_solver solver, uint64_t *hash);
/** Destroys a solver; its surface may then get another one. TOUCH_BUSY while another thread ticks it. */
TOUCH_API touch_status touch_solver_destroy(touch_solver solver);

#define TOUCH_FRICTION_OFF 0 /**< no friction: the force is along the normal */
#define TOUCH_FRICTION_ON 1  /**< friction of the scene, which may hold a finger where it first touched the surface */

/** The forces at any number of points: each as for a single finger that reaches the point along its pixel's ray, from
 * the camera, and stays there until the force is steady, for at most 500 ticks (else contacts[k].guard has
 * TOUCH_GUARD_UNSTEADY). Forces start at full strength: `fingers`, `ramp_in_ticks`, `waits_to_be_free` and
 * `stale_after_ns` of `settings` are ignored; NULL: defaults. `moment` selects the surface, `moment->tick` is
 * ignored; later ticks must not precede it. `friction`: TOUCH_FRICTION_OFF or TOUCH_FRICTION_ON. `points` (scene
 * units) and `contacts` have `count` elements. A point that is not a number, or far outside the scene, has no force
 * and TOUCH_GUARD_FAULT. TOUCH_BUSY: the surface has a solver. TOUCH_USAGE: NULL, an invalid size, a setting out of
 * range, or no frame was pushed yet. Not yet stable. */
TOUCH_API touch_status touch_surface_forces_at(touch_surface surface, const touch_solver_settings *settings,
                                               const touch_tick *moment, int32_t friction, const touch_vec3 *points,
                                               size_t count, touch_contact *contacts, size_t contact_stride_bytes,
                                               touch_error *error);

/* ---- Clips: libtouchable-media ------------------------------------------------------------------------------- */

/** A file of any kind that the program `touchable` opens, a folder of pictures, or the address of a stream. While a
 * clip is open its decoders may run threads, and FFmpeg's log is off in this process (av_log_set_level). No function
 * of clips is real-time. */
typedef struct touch_clip {
    uint64_t id; /**< 0 is never a clip */
} touch_clip;

/** Facts that a clip does not state itself; docs/formats.md. */
typedef struct touch_clip_settings {
    uint32_t struct_size;   /**< sizeof this struct in your program; you set it */
    int32_t colour;         /**< 1, the default; 0: frames may lack colour, which saves decoding */
    const char *scene_file; /**< a scene file that replaces the clip's own; NULL, the default: its own */
    const char *preset;     /**< name of a known camera, such as "kinect"; NULL, the default: none */
    double fx_px;           /**< focal length across, pixels; 0, the default: the clip's, or a guess */
    double fy_px;           /**< focal length down, pixels; required with fx_px */
    double cx_px;           /**< column of the principal point, pixels; NaN, the default: the middle */
    double cy_px;           /**< row of the principal point, pixels; NaN, the default: the middle */
    double fov_degrees;     /**< field of view from left to right, without fx_px; 0, the default: a guess */
    double metres_per_code; /**< of a stored 1; 0, the default: the clip's, or a guess */
    double near_m;          /**< near plane of a renderer's depth buffer, or nearest depth where it has no scale; 0, the
                               default: a guess; required with far_m */
    double far_m;           /**< its far plane, or farthest depth, metres; 0, the default: a guess */
    const char *channel;    /**< channel or layer of an OpenEXR file that is depth; NULL, the default: by its name */
    const char *dataset;    /**< data set or array of an HDF5 or .npz file that is depth; NULL, the default: by its name */
    int32_t depth_kind;     /**< TOUCH_PLANAR or TOUCH_RANGE; -1, the default: the clip's, or a guess */
    int32_t reserved;       /**< 0 */
} touch_clip_settings;

/** Fills in each member's default. `struct_size`: sizeof(touch_clip_settings) in your program. TOUCH_USAGE: NULL, or
 * an unknown size. Not yet stable. */
TOUCH_API touch_status touch_clip_settings_defaults(touch_clip_settings *settings, uint32_t struct_size);
/** Opens a clip at its first frame. `path`: UTF-8. `settings` may be NULL: defaults. TOUCH_INPUT: the file is missing
 * or unreadable. TOUCH_USAGE: a setting is out of range. Gives up after 20 s if a stream does not answer. Not yet
 * stable. */
TOUCH_API touch_status touch_clip_open(const char *path, const touch_clip_settings *settings, touch_clip *clip,
                                       touch_error *error);

/** Facts of a clip. */
typedef struct touch_clip_facts {
    uint32_t struct_size;      /**< sizeof this struct in your program; you set it */
    int32_t width;             /**< pixels, of every picture */
    int32_t height;            /**< pixels, of every picture */
    int32_t depth_sample;      /**< of frames' depth: TOUCH_U8 or TOUCH_U16 */
    int32_t depth_channels;    /**< of frames' depth: 1; 3 if depth is stored as hue */
    int32_t has_colour;        /**< 1: frames have this picture, 0: they do not */
    int32_t has_haptic;        /**< 1: frames have this picture, 0: they do not */
    int32_t has_height;        /**< 1: frames have this picture, 0: they do not */
    int32_t depth_is_lossless; /**< 1: the codec keeps every value, 0: it may not */
    int32_t notes;             /**< number of notes of touch_clip_note */
    int32_t has_own_times;     /**< 1: frames have a variable rate; 0: a constant rate */
    int32_t reserved;          /**< 0 */
    int64_t frames;            /**< number of frames; -1: unknown before reading all */
    double frames_per_second;  /**< the mean rate if frames have their own times */
} touch_clip_facts;

/** Fills in `facts`, whose struct_size you set. */
TOUCH_API touch_status touch_clip_describe(touch_clip clip, touch_clip_facts *facts);
/** Time of frame number `frame`, from 0, ns of the clip's clock, without reading the frame. TOUCH_USAGE: `frame` is
 * below 0 or above 2^40, or `time_ns` is NULL. */
TOUCH_API touch_status touch_clip_time(touch_clip clip, int64_t frame, int64_t *time_ns);
/** Writes note `index`, from 0, on a clip, such as a guess about it: one line of UTF-8 for the user. Writes as
 * touch_scene_text does. TOUCH_END: no such note. Not yet stable. */
TOUCH_API touch_status touch_clip_note(touch_clip clip, int32_t index, char *text, size_t capacity, size_t *length);

#define TOUCH_FILTERS_STATED 0 /**< only filters that the clip states; the others stay unstated and off */
#define TOUCH_FILTERS_CHOSEN 1 /**< unstated filters are chosen from its first frames, as by the program */

/** Makes a scene of the clip, which you must destroy. Its rate is the mean if frames have their own times.
 * TOUCH_FILTERS_CHOSEN reads up to 16 frames and returns to the clip's present position. TOUCH_INPUT: the first frame
 * cannot be read. Not yet stable. */
TOUCH_API touch_status touch_clip_scene(touch_clip clip, int32_t filters, touch_scene *scene, touch_error *error);

/** The pictures of one moment of a clip. They stay unchanged, at the same place in memory, until released, even after
 * the clip was closed. At most 65536 framesets exist at a time. */
typedef struct touch_frameset {
    uint64_t id; /**< 0 is never a frameset */
} touch_frameset;

/** Reads the next frameset, which you must release. TOUCH_END: no more frames. TOUCH_INPUT: the error names file,
 * track and frame; touch_clip_seek beyond that frame may allow reading on. */
TOUCH_API touch_status touch_clip_next(touch_clip clip, touch_frameset *frameset, touch_error *error);
/** Sets the frame that touch_clip_next reads next: 0 to the number of frames; TOUCH_USAGE beyond. */
TOUCH_API touch_status touch_clip_seek(touch_clip clip, int64_t frame, touch_error *error);
/** A thread waiting in touch_clip_next, for example for a stream, soon gets TOUCH_INTERRUPTED, and so does every later
 * call. Threads: any. */
TOUCH_API touch_status touch_clip_interrupt(touch_clip clip);
/** Closes a clip; its framesets remain. TOUCH_BUSY while another thread reads it: call touch_clip_interrupt first. */
TOUCH_API touch_status touch_clip_close(touch_clip clip);

/** Fills in `frame`, whose struct_size you set: number, time and pictures as stored (codes, not metres). */
TOUCH_API touch_status touch_frameset_frame(touch_frameset frameset, touch_frame *frame);
/** Frees its memory; pointers into it become invalid. TOUCH_BUSY: another thread is using it. */
TOUCH_API touch_status touch_frameset_release(touch_frameset frameset);

/** A clip being written. It gets its name only when complete. */
typedef struct touch_writer {
    uint64_t id; /**< 0 is never a writer */
} touch_writer;

/** Settings of a writer. */
typedef struct touch_writer_settings {
    uint32_t struct_size; /**< sizeof this struct in your program; you set it */
    int32_t overwrite;       /**< 1: an existing file is replaced once this one is complete; 0, the default */
    int32_t small;           /**< 1: fewer bytes, but slow to write; 0, the default */
    int32_t exact_colour;    /**< 1: colour keeps every value; 0, the default: visually lossless */
    const int64_t *times_ns; /**< display times of frames at a variable rate, the first 0, each at least 1 ms after the
                                previous one; NULL, the default: at the scene's rate */
    size_t times;            /**< number of times_ns */
} touch_writer_settings;

/** Fills in each member's default. `struct_size`: sizeof(touch_writer_settings) in your program. TOUCH_USAGE: NULL, or
 * an unknown size. Not yet stable. */
TOUCH_API touch_status touch_writer_settings_defaults(touch_writer_settings *settings, uint32_t struct_size);
/** Begins a clip. Its name `path` (UTF-8) selects the form: NAME.mkv, NAME.mp4, or a folder of PNG pictures (a name
 * without a dot). Depth, haptic and height pictures keep every value. `settings` may be NULL: defaults. TOUCH_EXISTS:
 * the file exists; `overwrite` replaces it. TOUCH_USAGE: an open clip is read from it, or a setting is out of range.
 * TOUCH_INPUT: the place is not writable. Not yet stable. */
TOUCH_API touch_status touch_writer_create(const char *path, touch_scene scene, const touch_writer_settings *settings,
                                           touch_writer *writer, touch_error *error);
/** Writes a frame, with the same kinds of pictures as the first one and the scene's size. Its number and time are
 * ignored: frames are numbered in order. Depth may be TOUCH_F32. TOUCH_USAGE: a picture differs in form from the
 * first frame's; nothing was written. TOUCH_INPUT: an invalid sample, or the disk is full. */
TOUCH_API touch_status touch_writer_write(touch_writer writer, const touch_frame *frame, touch_error *error);
/** Completes the clip, gives it its name, and destroys the writer, even on failure. TOUCH_USAGE: no frame was written,
 * or the number of frames differs from that of times_ns. TOUCH_INPUT: the disk is full, or the name is taken. */
TOUCH_API touch_status touch_writer_finish(touch_writer writer, touch_error *error);
/** Destroys a writer and discards its clip; no file is left. */
TOUCH_API touch_status touch_writer_abandon(touch_writer writer);

#ifdef __cplusplus
}
#endif

#endif
