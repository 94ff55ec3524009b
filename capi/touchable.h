/**
 * @file touchable.h
 * Touch depth pictures and depth video from C, and from whatever can call C.
 *
 * Two libraries stand behind this header:
 *   libtouchable         scenes, surfaces and the touch solver; needs neither FFmpeg nor Vulkan
 *   libtouchable-media   opens and writes files (the part under "Clips")
 *
 * How it goes: a scene says what the pictures mean, a surface is made of the pictures that you push, and a solver
 * takes the goals of fingers, 1000 times a second, and gives their forces.
 *
 * Units: lengths are scene units unless a name says otherwise; touch_scene_describe tells how many metres one is
 * (1 for scenes made by touch_scene_from_camera). Forces are newtons. Axes: X right, Y up, the camera at the origin
 * looks along -Z. Times are nanoseconds of the pictures' own clock.
 *
 * Stability: what is described here stays as it is until 1.0, but for the functions marked "Not yet stable", which a
 * minor version may change.
 *
 * Rules that every function keeps:
 *   - It returns a status; 0 is TOUCH_OK. (touch_version and touch_status_name alone do not.) Where it takes a
 *     touch_error, that gets one line that says what is wrong and what would be right; it stays as it is where the
 *     status is TOUCH_OK. The error may be NULL.
 *   - Handles are numbers. A handle that was destroyed, or was never made, gives TOUCH_STALE; nothing crashes.
 *   - Structs begin with their size, which you set to sizeof; a newer library understands an older program.
 *     The *_defaults functions set it, and every member.
 *   - Memory that you hand over stays yours, and is not kept after the call.
 *   - No exception comes out, nothing is printed, no thread starts unless you ask for threads, and neither locale
 *     nor signals are touched.
 *   - "Real-time" in a description: it does not allocate, lock, wait or call the system. All others may do.
 *   - fork(): clips, writers, surfaces and solvers belong to the process that made them, as their threads and files
 *     do. In a child process they give TOUCH_FORKED; ending them there is TOUCH_OK, and only forgets them. Scenes and
 *     framesets are memory, which a child has too. A child makes objects of its own.
 *   - "Threads": two threads may use different objects at once. Use one object from one thread at a time, unless
 *     its functions say otherwise; a second thread gets TOUCH_BUSY.
 */
#ifndef TOUCHABLE_H
#define TOUCHABLE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** What the libraries export. */
#if defined(__GNUC__)
#define TOUCH_API __attribute__((visibility("default")))
#else
#define TOUCH_API
#endif

/** Version of this header: major * 10000 + minor * 100 + patch. */
#define TOUCH_VERSION 200

/* ---- Statuses and errors ------------------------------------------------------------------------------------- */

/** How a call went: TOUCH_OK, or why nothing came of it. */
typedef int32_t touch_status;
#define TOUCH_OK 0            /**< done */
#define TOUCH_INTERNAL 1      /**< a fault of the library */
#define TOUCH_USAGE 2         /**< an argument cannot be: NULL, a size, a number out of range */
#define TOUCH_INPUT 3         /**< a file, a scene's text or a picture is not what it should be */
#define TOUCH_INTERRUPTED 130 /**< a stop was requested */
#define TOUCH_STALE 16        /**< the handle is not, or no longer, one of this kind */
#define TOUCH_BUSY 17         /**< another thread is using the object, or another object depends on it */
#define TOUCH_FULL 18         /**< no room for another frame yet; try again once ticks have gone on */
#define TOUCH_END 19          /**< there are no more frames */
#define TOUCH_NO_MEMORY 20    /**< there is not enough memory, or there are too many objects */
#define TOUCH_FORKED 21       /**< the object was made before fork(), by the parent process */

/** What went wrong, in one line of UTF-8 without a newline. */
typedef struct touch_error {
    uint32_t struct_size; /**< sizeof(touch_error); you set it */
    touch_status status;  /**< what the function gave */
    char line[504]; /**< ends with a zero; cut where it is longer */
} touch_error;

/** The library's own TOUCH_VERSION. Real-time. */
TOUCH_API uint32_t touch_version(void);
/** A status in a word or two, such as "stale handle"; "unknown status" for a number that is none. Never NULL; the
 * text lasts for ever. Real-time. */
TOUCH_API const char *touch_status_name(touch_status status);

/* ---- Scenes -------------------------------------------------------------------------------------------------- */

/** What pictures mean: camera, depth and height coding, haptic ranges, filters. It does not change once it is made. */
typedef struct touch_scene {
    uint64_t id; /**< 0 is never a scene */
} touch_scene;

#define TOUCH_PLANAR 0 /**< depth is measured along -Z, as depth cameras give it */
#define TOUCH_RANGE 1  /**< depth is measured along the pixel's ray */

/** A pinhole camera, its depth, and what its surface feels like. */
typedef struct touch_camera {
    uint32_t struct_size; /**< sizeof this struct, of your program; you set it */
    int32_t width;               /**< pixels, 1 to 16384 */
    int32_t height;              /**< pixels, 1 to 16384 */
    int32_t depth_kind;          /**< TOUCH_PLANAR or TOUCH_RANGE */
    double fx_px;                /**< focal length across, pixels, > 0 */
    double fy_px;                /**< focal length down, pixels, > 0 */
    double cx_px;                /**< column of the principal point, pixels; pixel (0, 0) has its centre at (0, 0) */
    double cy_px;                /**< its row, pixels */
    double metres_per_code;      /**< of uint16 depth; 0.001: millimetres. Depth as floats is metres, rounded to this; 65535
                                    times this is the farthest that can be */
    double far_m;                /**< deeper pixels have no surface; metres, > 0. See touch_frame.lost_pixels */
    double frames_per_second;    /**< > 0; used where frames are counted and not timed */
    double stiffness_n_per_m;    /**< where no haptic picture says otherwise; >= 0 */
    double static_friction;      /**< coefficient >= 0 */
    double dynamic_friction;     /**< coefficient, 0 to static_friction */
} touch_camera;

/** Fills in 640x480 pixels, 60 degrees wide, planar depth in millimetres up to 10 m, 30 frames/s, 600 N/m, friction
 * 0.4 and 0.3. `struct_size`: sizeof(touch_camera) of your program. TOUCH_USAGE: NULL, or a size that this library does not know. */
TOUCH_API touch_status touch_camera_defaults(touch_camera *camera, uint32_t struct_size);
/** A scene of a camera; its scene unit is a metre, and no filter is on (see touch_scene_with_filters). TOUCH_USAGE:
 * a member is out of its range, which the error names. */
TOUCH_API touch_status touch_scene_from_camera(const touch_camera *camera, touch_scene *scene, touch_error *error);
/** A scene of the text of a scene file (docs/scene_file.md), JSON of `length` bytes in UTF-8. TOUCH_INPUT: the error
 * names the member. Filters that the text leaves open are off (see touch_scene_with_filters). */
TOUCH_API touch_status touch_scene_from_text(const char *text, size_t length, touch_scene *scene, touch_error *error);
/** The scene as the text of a scene file, which gives the same scene again, to the last bit. Writes at most
 * `capacity` bytes, with a zero at the end where there is room, to `text` (may be NULL where capacity is 0), and to
 * `*length` how many the whole text has, without the zero. */
TOUCH_API touch_status touch_scene_text(touch_scene scene, char *text, size_t capacity, size_t *length);

/** A scene in figures. */
typedef struct touch_scene_facts {
    uint32_t struct_size;         /**< sizeof this struct, of your program; you set it */
    int32_t width;                /**< of depth, pixels */
    int32_t height;               /**< of depth, pixels */
    int32_t depth_kind;           /**< TOUCH_PLANAR or TOUCH_RANGE */
    double fx_px;                 /**< focal length across, pixels */
    double fy_px;                 /**< focal length down, pixels */
    double cx_px;                 /**< column of the principal point, pixels */
    double cy_px;                 /**< row of the principal point, pixels */
    double metres_per_scene_unit; /**< of the world that the camera saw */
    double near_units;            /**< the nearest depth that counts, scene units */
    double far_units;             /**< the deepest depth that counts, scene units */
    double frames_per_second;     /**< of the pictures; their mean where each has a time of its own */
    double hand_metres_per_scene_unit; /**< of the hand, as the scene states it; 0: it does not */
    int32_t unstated_filters;     /**< 1 where touch_scene_with_filters would choose some; 0 where all are stated */
    int32_t reserved;             /**< 0 */
} touch_scene_facts;

/** Fills in `facts`, whose struct_size you set. Real-time. */
TOUCH_API touch_status touch_scene_describe(touch_scene scene, touch_scene_facts *facts);
/** Ends a scene. Surfaces that were made of it go on. */
TOUCH_API touch_status touch_scene_destroy(touch_scene scene);

/* ---- Frames -------------------------------------------------------------------------------------------------- */

#define TOUCH_U8 1  /**< uint8_t */
#define TOUCH_U16 2 /**< uint16_t, this machine's byte order */
#define TOUCH_F32 4 /**< float, depth alone: metres; not above 0, not finite or outside the scene's depths: no surface there */

/** One picture in memory that it does not own. */
typedef struct touch_plane {
    const void *data;     /**< the first row; NULL: there is no such picture */
    int64_t stride_bytes; /**< from one row to the next; may be negative, may have gaps */
    int32_t width;        /**< pixels; that of the scene */
    int32_t height;       /**< pixels; that of the scene */
    int32_t sample;       /**< TOUCH_U8, TOUCH_U16 or TOUCH_F32, which is also its bytes */
    int32_t channels;     /**< 1, or 3 (red, green, blue) side by side */
} touch_plane;

/** The pictures of one moment. Only depth must be there. */
typedef struct touch_frame {
    uint32_t struct_size; /**< sizeof this struct, of your program; you set it */
    int32_t reserved;    /**< 0 */
    int64_t number;      /**< from 0; later frames have larger numbers */
    int64_t time_ns;     /**< when it is shown */
    touch_plane depth;   /**< codes as the scene says (1 channel; hue coding: 3 channels of 8 bits), or TOUCH_F32 */
    touch_plane colour;  /**< 3 channels, TOUCH_U8; not touched */
    touch_plane haptic;  /**< 3 channels, TOUCH_U8: stiffness, static and dynamic friction */
    touch_plane height;  /**< 1 channel: roughness */
    int64_t *lost_pixels; /**< NULL, or where functions that take the frame write how many pixels of TOUCH_F32 have a
                             depth (finite, above 0) that lies outside the scene's, and so have no surface. A renderer's
                             background (1e9 and beyond, or 65504) is no depth. Where most of the depths are lost the
                             frame is refused with TOUCH_USAGE */
} touch_frame;

/** Fills in an empty frame: number 0, time 0, no picture. `struct_size`: sizeof(touch_frame) of your program. */
TOUCH_API touch_status touch_frame_defaults(touch_frame *frame, uint32_t struct_size);

/** Depth of a picture of codes in metres, row after row, as floats; NaN where there is no surface. As the codes say
 * it: along -Z, or along the pixel's ray where the scene's depth_kind is TOUCH_RANGE. `metres` has the scene's width
 * and height, and rows of `stride_bytes`, at least 4 * width. TOUCH_USAGE: that is not so, or depth has not the
 * scene's size and kind. */
TOUCH_API touch_status touch_scene_metres(touch_scene scene, const touch_plane *depth, float *metres,
                                          int64_t stride_bytes, touch_error *error);

/** Gives the scene with the filters that the program `touchable` would choose by these frames (`frames` of a
 * recording from the first one on; 16 are enough, more are not looked at). Filters that the scene states stay as
 * they are; of a scene made from a camera all are chosen. With no frames they stay off. A frame whose depth has no
 * surface at all tells nothing. TOUCH_USAGE: a frame has not the scene's form, or the scene wants the temporal filter
 * and nothing says how noisy depth is. Not yet stable. */
TOUCH_API touch_status touch_scene_with_filters(touch_scene scene, const touch_frame *frames, size_t frame_stride_bytes,
                                                size_t count, touch_scene *filtered, touch_error *error);

/* ---- Surfaces ------------------------------------------------------------------------------------------------ */

/** A surface in time: frames go in by one thread, a solver reads by another, and neither waits for the other. */
typedef struct touch_surface {
    uint64_t id; /**< 0 is never a surface */
} touch_surface;

/** How a surface is made. */
typedef struct touch_surface_settings {
    uint32_t struct_size; /**< sizeof this struct, of your program; you set it */
    int32_t threads; /**< that filter a frame, with the caller's: 1 to 16; more than 1 starts threads. 1 by default */
    int32_t frames;  /**< that are kept at once, 4 to 64; 4 by default: what the solver reads, and two more */
    int32_t reserved; /**< 0 */
} touch_surface_settings;

/** Fills in 1 thread and 4 frames. `struct_size`: sizeof(touch_surface_settings) of your program. TOUCH_USAGE: NULL,
 * or a size that this library does not know. */
TOUCH_API touch_status touch_surface_settings_defaults(touch_surface_settings *settings, uint32_t struct_size);
/** A surface without a frame. `settings` may be NULL: defaults. TOUCH_USAGE: a setting is out of its range. */
TOUCH_API touch_status touch_surface_create(touch_scene scene, const touch_surface_settings *settings,
                                            touch_surface *surface, touch_error *error);
/** Filters a frame and publishes it. Frames come in order: `time_ns` and `number` grow within an epoch. TOUCH_FULL: the
 * solver still needs all frames that there are; nothing has changed, try again. TOUCH_USAGE: a picture has not the
 * scene's size or kind, or the time is not later. Threads: one pushes while another ticks. */
TOUCH_API touch_status touch_surface_push(touch_surface surface, const touch_frame *frame, touch_error *error);
/** What is pushed from now on belongs to this epoch, a larger number than before (the first is 0): its times may be
 * any, as after a seek. The solver goes over to it when its ticks name it and two of its frames are there.
 * TOUCH_USAGE: it is no larger. Not yet stable. */
TOUCH_API touch_status touch_surface_begin_epoch(touch_surface surface, uint64_t epoch, touch_error *error);
/** The epoch has no more frames: its last one stands still, also where it is the only one. Not yet
 * stable. */
TOUCH_API touch_status touch_surface_end_epoch(touch_surface surface);
/** Time of the newest frame; INT64_MIN before the first one of an epoch. In virtual time, push until it is later than the tick's
 * time. Any thread. Real-time. */
TOUCH_API touch_status touch_surface_newest_ns(touch_surface surface, int64_t *time_ns);
/** How far a hand moves for a scene unit, in metres, as the program `touchable` chooses it: what the scene states;
 * otherwise the picture's width at the median depth of the first frame that was pushed is 0.16 m. TOUCH_USAGE
 * before that frame. */
TOUCH_API touch_status touch_surface_hand_scale(touch_surface surface, double *metres_per_scene_unit,
                                                touch_error *error);
/** Ends a surface and its frames. TOUCH_BUSY while a solver reads it: destroy that first. */
TOUCH_API touch_status touch_surface_destroy(touch_surface surface);

/* ---- The solver ---------------------------------------------------------------------------------------------- */

/** One to 256 fingers on a surface: a proxy for each, which stays on the surface, and a guard between its force and
 * the hand. A force is a pure function of frames, goals, times and settings: the same bits on every machine. */
typedef struct touch_solver {
    uint64_t id; /**< 0 is never a solver */
} touch_solver;

/** Fingers, and the limits of their forces. */
typedef struct touch_solver_settings {
    uint32_t struct_size; /**< sizeof this struct, of your program; you set it */
    int32_t fingers;              /**< 1 to 256; 1 by default */
    double metres_per_scene_unit; /**< of the hand: a force is stiffness * this * (proxy - goal). 0, the default: as
                                     touch_surface_hand_scale says */
    double max_force_n;           /**< per finger, 1e-6 to 1e9; 10 by default. No force is ever longer */
    double max_stiffness_n_per_m; /**< 1e-3 to 1e12; 10000 by default */
    double damping_n_s_per_m;     /**< of a damper added in contact, >= 0; 0 by default */
    double passivity_n_s_per_m;   /**< largest damping of the passivity controller; 0, the default: it is off */
    double stribeck_m_per_s;      /**< friction falls with speed (Stribeck); 0, the default: Coulomb's */
    int64_t stale_after_ns;       /**< a surface whose newest frame is older ramps away; 0, the default: never */
    int32_t ramp_in_ticks;        /**< from the first tick, and after a fault; 100 by default */
    int32_t ramp_out_ticks;       /**< after a goal that is no number; 100 by default */
    int32_t waits_to_be_free;     /**< 1: no force in a finger that begins inside the surface until it has been free, as
                                     a hand wants it; 0, the default */
    int32_t reserved;             /**< 0 */
} touch_solver_settings;

/** A place in scene units, or a force in newtons. */
typedef struct touch_vec3 {
    double x; /**< to the right */
    double y; /**< up */
    double z; /**< towards the camera */
} touch_vec3;

/** Which moment of the surface a tick meets. */
typedef struct touch_tick {
    uint32_t struct_size; /**< sizeof this struct, of your program; you set it */
    int32_t reserved;       /**< 0 */
    int64_t tick;           /**< milliseconds of the hand's time; larger than before: those between are missed */
    int64_t time_ns;        /**< moment of the frames' clock; does not go back within an epoch */
    uint64_t epoch;         /**< that this time is of; 0 unless touch_surface_begin_epoch was called */
    int64_t epoch_start_ns; /**< where that epoch begins */
} touch_tick;

#define TOUCH_GUARD_STIFFNESS 1   /**< stiffness limited to max_stiffness_n_per_m */
#define TOUCH_GUARD_FORCE 2       /**< force limited to max_force_n */
#define TOUCH_GUARD_RAMP 4        /**< ramping in */
#define TOUCH_GUARD_FAULT 8       /**< a goal or a surface was missing or impossible: ramping to zero */
#define TOUCH_GUARD_RISE 16       /**< stiffness not yet risen to the map's */
#define TOUCH_GUARD_DAMPING 32    /**< a damper's force added */
#define TOUCH_GUARD_PASSIVITY 64  /**< the passivity controller's force added */
#define TOUCH_GUARD_JUMP 128      /**< the surface jumped: the change of force comes on over 100 ms */
#define TOUCH_GUARD_WAITING 256   /**< no force until the finger has been free */
#define TOUCH_GUARD_GAP 512       /**< the hand had been left alone */
#define TOUCH_GUARD_STALE 1024    /**< the surface is too old, or was */
#define TOUCH_GUARD_UNSTEADY 2048 /**< of touch_surface_forces_at: the force still changes after 500 ticks */

/** What a finger met in a tick. */
typedef struct touch_contact {
    uint32_t struct_size;     /**< how much of it the library filled in */
    uint32_t guard;           /**< TOUCH_GUARD_ bits: why the force is not simply the solver's; 0: it is */
    touch_vec3 force_n;       /**< what the hand is to be given: guarded, never NaN, never longer than max_force_n */
    touch_vec3 goal;          /**< scene units: as given, or the last one that was a number */
    touch_vec3 proxy;         /**< scene units: where the surface holds the finger; the goal itself out of contact */
    double pixel_x;           /**< column of the proxy in the picture, pixels; NaN where no pixel sees it */
    double pixel_y;           /**< its row, pixels */
    double stiffness_n_per_m; /**< at the proxy; 0 out of contact */
    double static_friction;   /**< a coefficient */
    double dynamic_friction;  /**< a coefficient */
    int32_t touching;         /**< 1 in contact */
    int32_t in_hole;          /**< 1 where the proxy rests on a hole's wall or ground */
} touch_contact;

/** Fills in what stands beside each member. `struct_size`: sizeof(touch_solver_settings) of your program. TOUCH_USAGE:
 * NULL, or a size that this library does not know. */
TOUCH_API touch_status touch_solver_settings_defaults(touch_solver_settings *settings, uint32_t struct_size);
/** A solver of the surface. `settings` may be NULL: defaults. A surface has one solver at a time (TOUCH_BUSY).
 * TOUCH_USAGE: a setting is out of its range, or metres_per_scene_unit is 0 and no frame was pushed yet. */
TOUCH_API touch_status touch_solver_create(touch_surface surface, const touch_solver_settings *settings,
                                           touch_solver *solver, touch_error *error);
/** One tick. `goals` and `contacts` have one element per finger; `contact_stride_bytes`: sizeof(touch_contact) of your
 * program. A goal that is no number, or far outside the scene, counts as missing: its force ramps to zero. Without a
 * frame yet all forces are zero. TOUCH_USAGE: NULL, a stride, or a tick that is not larger than the one before; then
 * nothing happened. Real-time. Threads: one ticks while another pushes frames. */
TOUCH_API touch_status touch_solver_tick(touch_solver solver, const touch_tick *tick, const touch_vec3 *goals,
                                         touch_contact *contacts, size_t contact_stride_bytes);
/** `count` ticks in one call, each with the frames that are published by then: tick k is `first` with k ticks and k
 * milliseconds added. `goals` and `contacts`: ticks one after the other, fingers within. Real-time but for its
 * length. */
TOUCH_API touch_status touch_solver_run(touch_solver solver, const touch_tick *first, size_t count,
                                        const touch_vec3 *goals, touch_contact *contacts, size_t contact_stride_bytes);
/** The hand was away before the next tick, for more than 50 ms or with its clutch held: force comes back by its ramp,
 * and with waits_to_be_free only to fingers that have been free. Real-time. */
TOUCH_API touch_status touch_solver_come_back(touch_solver solver);
/** XXH64 of all forces since the solver was made, the figure that the program prints as "force hash": equal hashes mean
 * equal forces to the last bit. Real-time. */
TOUCH_API touch_status touch_solver_force_hash(touch_solver solver, uint64_t *hash);
/** Ends a solver; its surface is free for another one. TOUCH_BUSY while another thread ticks it. */
TOUCH_API touch_status touch_solver_destroy(touch_solver solver);

#define TOUCH_FRICTION_OFF 0 /**< the surface is as smooth as can be: its force pushes along the normal */
#define TOUCH_FRICTION_ON 1  /**< friction as the scene has it, which may hold a finger where it met the surface */

/** The force at any number of places: each as of a finger alone that came to it along its pixel's ray, from the camera,
 * and stays there until the force is steady, for 500 ticks at most (contacts[k].guard has TOUCH_GUARD_UNSTEADY where it
 * was not). Forces are there at once: `fingers`, `ramp_in_ticks`, `waits_to_be_free` and `stale_after_ns` of `settings`
 * do not count; NULL: defaults. `moment` says which surface is met, `moment->tick` does not count; later ticks do not go
 * back before it. `friction`: TOUCH_FRICTION_OFF or TOUCH_FRICTION_ON. `points` (scene units) and `contacts` have `count`
 * elements. A place that is no number, or far outside the scene, has no force, and TOUCH_GUARD_FAULT. TOUCH_BUSY: the
 * surface has a solver. TOUCH_USAGE: NULL, a size, a setting out of its range, or no frame was pushed yet.
 * Not yet stable. */
TOUCH_API touch_status touch_surface_forces_at(touch_surface surface, const touch_solver_settings *settings,
                                               const touch_tick *moment, int32_t friction, const touch_vec3 *points,
                                               size_t count, touch_contact *contacts, size_t contact_stride_bytes,
                                               touch_error *error);

/* ---- Clips: libtouchable-media ------------------------------------------------------------------------------- */

/** A file of any kind that the program `touchable` opens, a folder of pictures, or the address of a stream. While one
 * is open its decoders may run threads of their own, and FFmpeg's log is off in this process (av_log_set_level). Not
 * real-time, none of it. */
typedef struct touch_clip {
    uint64_t id; /**< 0 is never a clip */
} touch_clip;

/** What is known of a clip that does not say it itself; docs/formats.md. */
typedef struct touch_clip_settings {
    uint32_t struct_size;   /**< sizeof this struct, of your program; you set it */
    int32_t colour;         /**< 1, the default; 0: frames may come without it, which saves decoding */
    const char *scene_file; /**< a scene file that describes the clip instead of its own; NULL, the default: its own */
    const char *preset;     /**< what is known of a camera by name, such as "kinect"; NULL, the default: nothing */
    double fx_px;           /**< focal length across, pixels; 0, the default: as the clip says, or a guess */
    double fy_px;           /**< focal length down, pixels, where fx_px is given */
    double cx_px;           /**< column of the principal point, pixels; NaN, the default: the middle */
    double cy_px;           /**< row of the principal point, pixels; NaN, the default: the middle */
    double fov_degrees;     /**< seen from left to right, where fx_px is not given; 0, the default: a guess */
    double metres_per_code; /**< of a stored 1; 0, the default: as the clip says, or a guess */
} touch_clip_settings;

/** Fills in what stands beside each member. `struct_size`: sizeof(touch_clip_settings) of your program. TOUCH_USAGE:
 * NULL, or a size that this library does not know. Not yet stable. */
TOUCH_API touch_status touch_clip_settings_defaults(touch_clip_settings *settings, uint32_t struct_size);
/** Opens a clip at its first frame. `path`: UTF-8. `settings` may be NULL: defaults. TOUCH_INPUT: the file is not
 * there, or none that can be read. TOUCH_USAGE: a setting is out of its range. A stream that does not answer is given
 * up after 20 s. Not yet stable. */
TOUCH_API touch_status touch_clip_open(const char *path, const touch_clip_settings *settings, touch_clip *clip,
                                       touch_error *error);

/** A clip in figures. */
typedef struct touch_clip_facts {
    uint32_t struct_size;      /**< sizeof this struct, of your program; you set it */
    int32_t width;             /**< pixels, of every picture */
    int32_t height;            /**< pixels, of every picture */
    int32_t depth_sample;      /**< of frames' depth: TOUCH_U8 or TOUCH_U16 */
    int32_t depth_channels;    /**< of frames' depth: 1; 3 where depth is stored as hue */
    int32_t has_colour;        /**< 1 where frames have such a picture, 0 where not */
    int32_t has_haptic;        /**< 0 or 1 */
    int32_t has_height;        /**< 0 or 1 */
    int32_t depth_is_lossless; /**< 1 where the codec keeps every value, 0 where it may not */
    int32_t notes;             /**< how many touch_clip_note gives */
    int32_t has_own_times;     /**< 1 where frames come at a variable rate; 0 where evenly */
    int32_t reserved;          /**< 0 */
    int64_t frames;            /**< -1: only reading would tell */
    double frames_per_second;  /**< their mean where frames have times of their own */
} touch_clip_facts;

/** Fills in `facts`, whose struct_size you set. */
TOUCH_API touch_status touch_clip_describe(touch_clip clip, touch_clip_facts *facts);
/** When a frame of the clip is shown, from 0, ns of its own clock, without reading it. TOUCH_USAGE: `frame` is below 0
 * or above 2^40, or `time_ns` is NULL. */
TOUCH_API touch_status touch_clip_time(touch_clip clip, int64_t frame, int64_t *time_ns);
/** What a person should know of a clip, such as what was guessed of it: note `index`, from 0, in a line of UTF-8.
 * Writes as touch_scene_text does. TOUCH_END: there is no such note. Not yet stable. */
TOUCH_API touch_status touch_clip_note(touch_clip clip, int32_t index, char *text, size_t capacity, size_t *length);

#define TOUCH_FILTERS_STATED 0 /**< those that the clip states; what it leaves open stays open, and off */
#define TOUCH_FILTERS_CHOSEN 1 /**< what it leaves open is chosen by its first frames, as the program does it */

/** What the clip's pictures mean, a new scene that is yours to end. Its rate is the mean where frames have times of
 * their own. TOUCH_FILTERS_CHOSEN reads up to 16 frames for
 * it, and goes back to where the clip was. TOUCH_INPUT: the first one cannot be read. Not yet stable. */
TOUCH_API touch_status touch_clip_scene(touch_clip clip, int32_t filters, touch_scene *scene, touch_error *error);

/** The pictures of one moment of a clip. They stay as they are, at their place in memory, until they are released,
 * also where the clip has been closed. At most 65536 are held at a time. */
typedef struct touch_frameset {
    uint64_t id; /**< 0 is never a frameset */
} touch_frameset;

/** The next one, which is yours to release. TOUCH_END: there are no more. TOUCH_INPUT: the error names file, track
 * and frame; what comes after may be read where touch_clip_seek skips it. */
TOUCH_API touch_status touch_clip_next(touch_clip clip, touch_frameset *frameset, touch_error *error);
/** `touch_clip_next` gives this frame next: 0 to the number of frames; TOUCH_USAGE beyond. */
TOUCH_API touch_status touch_clip_seek(touch_clip clip, int64_t frame, touch_error *error);
/** A thread that waits in touch_clip_next, as for a stream, gets TOUCH_INTERRUPTED soon, and so does every later one.
 * Threads: any. */
TOUCH_API touch_status touch_clip_interrupt(touch_clip clip);
/** Ends a clip; its framesets go on. TOUCH_BUSY while another thread reads it: interrupt that first. */
TOUCH_API touch_status touch_clip_close(touch_clip clip);

/** Fills in `frame`, whose struct_size you set: number, time and pictures as they are stored (codes, not metres). */
TOUCH_API touch_status touch_frameset_frame(touch_frameset frameset, touch_frame *frame);
/** Gives its memory back; pointers into it end. TOUCH_BUSY: another thread is asking for it. */
TOUCH_API touch_status touch_frameset_release(touch_frameset frameset);

/** A clip that is being written. It has its name only once it is whole. */
typedef struct touch_writer {
    uint64_t id; /**< 0 is never a writer */
} touch_writer;

/** How a clip is written. */
typedef struct touch_writer_settings {
    uint32_t struct_size; /**< sizeof this struct, of your program; you set it */
    int32_t overwrite;       /**< 1: a file that is there already is replaced once this one is whole; 0, the default */
    int32_t small;           /**< 1: few bytes rather than quick to decode; 0, the default */
    int32_t exact_colour;    /**< 1: colour keeps every value; 0, the default: as good as the eye can tell */
    const int64_t *times_ns; /**< of frames at a variable rate: when each is shown, the first at 0, each at least 1 ms
                                after the one before; NULL, the default: at the scene's rate */
    size_t times;            /**< how many */
} touch_writer_settings;

/** Fills in what stands beside each member. `struct_size`: sizeof(touch_writer_settings) of your program. TOUCH_USAGE:
 * NULL, or a size that this library does not know. Not yet stable. */
TOUCH_API touch_status touch_writer_settings_defaults(touch_writer_settings *settings, uint32_t struct_size);
/** Begins a clip. By its name `path` (UTF-8) it becomes NAME.mkv, NAME.mp4, or a folder of PNG pictures (a name without
 * a dot). Depth, haptic and height pictures keep every value. `settings` may be NULL: defaults. TOUCH_USAGE: it is
 * there already, an open clip is read from it, or a setting is out of its range. TOUCH_INPUT: nothing can be written
 * there. Not yet stable. */
TOUCH_API touch_status touch_writer_create(const char *path, touch_scene scene, const touch_writer_settings *settings,
                                           touch_writer *writer, touch_error *error);
/** Every frame has the pictures of the first one, of the scene's size. Its number and time do not count: frames are
 * numbered as they come. Depth may be TOUCH_F32. TOUCH_USAGE: a picture has not the first one's form, nothing was
 * written. TOUCH_INPUT: a sample cannot be, or the disk is full. */
TOUCH_API touch_status touch_writer_write(touch_writer writer, const touch_frame *frame, touch_error *error);
/** Completes the clip, gives it its name, and ends the writer, whatever comes of it. TOUCH_USAGE: no frame was written,
 * or another number of them than there are times. TOUCH_INPUT: the disk is full, or the name is taken. */
TOUCH_API touch_status touch_writer_finish(touch_writer writer, touch_error *error);
/** Ends a writer whose clip is not to be; nothing is left of it. */
TOUCH_API touch_status touch_writer_abandon(touch_writer writer);

#ifdef __cplusplus
}
#endif

#endif
