// SPDX-License-Identifier: Apache-2.0
/* Touches a clip with goals of a file, and prints the hash of the forces: that which the program prints for them.
 *     touchable touch CLIP --forces forces.csv
 *     cc touch_clip.c $(pkg-config --cflags --libs touchable-media) && ./a.out CLIP forces.csv                     */
#include <inttypes.h>
#include <stdio.h>
#include <touchable.h>

static touch_error error = {sizeof error, 0, ""};

/* Pushes frames until the newest one is later than `time_ns`; at the clip's end the last one stands still. */
static touch_status push_until(touch_clip clip, touch_surface surface, int64_t time_ns) {
    static int ended = 0;
    int64_t newest_ns;
    touch_status status = touch_surface_newest_ns(surface, &newest_ns);
    while (!status && !ended && newest_ns <= time_ns) {
        touch_frameset set;
        touch_frame frame = {.struct_size = sizeof frame};
        if ((status = touch_clip_next(clip, &set, &error)) == TOUCH_END) {
            ended = 1;
            return touch_surface_end_epoch(surface);
        }
        if (status) return status;
        if (!(status = touch_frameset_frame(set, &frame))) status = touch_surface_push(surface, &frame, &error);
        touch_frameset_release(set);
        if (!status) status = touch_surface_newest_ns(surface, &newest_ns);
    }
    return status;
}

int main(int count, char **words) {
    FILE *goals = count == 3 ? fopen(words[2], "r") : NULL;
    if (!goals) return fprintf(stderr, "touch_clip CLIP FORCES: a clip, and what touchable touch --forces wrote\n"), 2;

    touch_clip clip;
    touch_scene scene;
    touch_surface surface;
    touch_solver solver; /* of one finger; it knows the hand's scale by the first frame */
    touch_status status = touch_clip_open(words[1], NULL, &clip, &error);
    if (!status) status = touch_clip_scene(clip, TOUCH_FILTERS_CHOSEN, &scene, &error);
    if (!status) status = touch_surface_create(scene, NULL, &surface, &error);
    if (!status) status = push_until(clip, surface, 0);
    if (!status) status = touch_solver_create(surface, NULL, &solver, &error);

    char line[1024];
    while (!status && fgets(line, sizeof line, goals)) {
        touch_tick now = {.struct_size = sizeof now};
        touch_vec3 goal;
        touch_contact contact;
        if (sscanf(line, "%" SCNd64 ",%*f,0,%lf,%lf,%lf", &now.tick, &goal.x, &goal.y, &goal.z) != 4) continue;
        now.time_ns = now.tick * 1000000;
        status = push_until(clip, surface, now.time_ns);
        if (!status) status = touch_solver_tick(solver, &now, &goal, &contact, sizeof contact);
    }
    uint64_t hash;
    if (!status) status = touch_solver_force_hash(solver, &hash);
    if (status) return fprintf(stderr, "%s: %s\n", touch_status_name(status), error.line), 1;
    printf("%016" PRIx64 "\n", hash);
    return 0;
}
