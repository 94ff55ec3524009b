// SPDX-License-Identifier: Apache-2.0
/* A finger strokes a hill: an array of depth, a camera, 2000 ticks of a millisecond each.
 *     cc touch_hill.c $(pkg-config --cflags --libs touchable) -lm && ./a.out                                      */
#include <math.h>
#include <stdio.h>
#include <touchable.h>

enum { width = 320, height = 240 };
static float depth[height][width]; /* metres; 0: no surface */

int main(void) {
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) depth[y][x] = (float)(0.5 - 0.04 * exp(-pow(hypot(x - 160, y - 120) / 60, 2)));

    touch_error error = {sizeof error, 0, ""};
    touch_camera camera;
    touch_camera_defaults(&camera, sizeof camera);
    camera.width = width, camera.height = height;
    camera.far_m = 0.6; /* the nearer, the finer are the steps of depth */
    camera.fx_px = camera.fy_px = 300, camera.cx_px = 159.5, camera.cy_px = 119.5;
    touch_frame frame;
    touch_frame_defaults(&frame, sizeof frame);
    frame.depth = (touch_plane){depth, sizeof depth[0], width, height, TOUCH_F32, 1};

    touch_scene scene;
    touch_surface surface;
    touch_solver solver;
    if (touch_scene_from_camera(&camera, &scene, &error) || touch_surface_create(scene, NULL, &surface, &error) ||
        touch_surface_push(surface, &frame, &error) || touch_solver_create(surface, NULL, &solver, &error))
        return fprintf(stderr, "%s\n", error.line), 1;

    for (int64_t tick = 0; tick < 2000; ++tick) { /* across the hill, 1 cm below its top */
        const touch_tick now = {sizeof now, 0, tick, tick * 1000000, 0, 0};
        const touch_vec3 goal = {-0.1 + 0.0001 * (double)tick, 0, -0.47};
        touch_contact contact;
        if (touch_solver_tick(solver, &now, &goal, &contact, sizeof contact)) return 1;
        if (tick % 200 == 0)
            printf("%4d ms: force %7.3f %7.3f %7.3f N%s\n", (int)tick, contact.force_n.x, contact.force_n.y,
                   contact.force_n.z, contact.touching ? ", touching" : "");
    }
    touch_solver_destroy(solver);
    touch_surface_destroy(surface);
    touch_scene_destroy(scene);
    return 0;
}
