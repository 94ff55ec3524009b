/* SPDX-License-Identifier: Apache-2.0
 * bin/touchable of the portable archive (./run portable): starts libexec/touchable with the right C library.
 *
 * The archive's libraries find each other by $ORIGIN. Some lie apart, in lib/fallback/GROUP, as those of the machine serve
 * better where it has them: a driver of the machine needs its own C and C++ library or newer ones, sound needs the plugins
 * beside the machine's libasound. A group is used if the machine has no such library, or an older one. Static, as there may
 * be no library at all.
 */
#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/auxv.h>
#include <unistd.h>

struct group {
    const char *name, *library;
    const char *version; /* what stands before the number of a version; NULL: any will do */
};
static const struct group groups[] = {{"libc", "libc.so.6", "GLIBC_2."},
                                      {"libstdc++", "libstdc++.so.6", "GLIBCXX_3.4."},
                                      {"alsa", "libasound.so.2", NULL},
                                      {"drm", "libdrm.so.2", NULL},
                                      {"vulkan", "libvulkan.so.1", "vkCmdPipelineBarrier"}, /* 2, from Vulkan 1.3 on */
                                      {"wayland", "libwayland-client.so.0", NULL},
                                      {"x11", "libX11.so.6", NULL}};
static const char *const machine[] = {"/lib/x86_64-linux-gnu", "/usr/lib/x86_64-linux-gnu", "/lib64", "/usr/lib64", "/lib", "/usr/lib"};
static const char *const drivers[] = {"/etc/vulkan/icd.d", "/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d",
                                      "/usr/local/etc/vulkan/icd.d"};

static char *text(const char *a, const char *b, const char *c) {
    char *made = malloc(strlen(a) + strlen(b) + strlen(c) + 1);
    if (!made) exit(1);
    return strcat(strcat(strcpy(made, a), b), c);
}

/* The highest number behind `version` in a library of 64 bits; 0: there is none, or no such library; 1: no version asked. */
static long newest(const char *file, const char *version) {
    long most = 0;
    FILE *in = fopen(file, "rb");
    if (!in) return 0;
    char *bytes = NULL;
    size_t size = 0, room = 0, got = 1;
    while (got > 0) {
        if (size + 1 >= room && !(bytes = realloc(bytes, room = 2 * room + 65536))) exit(1);
        size += got = fread(bytes + size, 1, room - size - 1, in);
    }
    fclose(in);
    bytes[size] = 0;
    if (size > 5 && memcmp(bytes, "\177ELF\2", 5) == 0) most = version == NULL;
    for (char *at = bytes; version && size > 5 && bytes[4] == 2; at += strlen(version)) {
        at = memmem(at, (size_t)(bytes + size - at), version, strlen(version));
        if (!at) break;
        const long number = strtol(at + strlen(version), NULL, 10);
        if (number > most && number < 1000) most = number;
    }
    free(bytes);
    return most;
}

static int has_drivers(void) {
    for (size_t k = 0; k < sizeof drivers / sizeof *drivers; ++k) {
        DIR *folder = opendir(drivers[k]);
        for (struct dirent *entry; folder && (entry = readdir(folder));)
            if (strstr(entry->d_name, ".json")) return 1;
        if (folder) closedir(folder);
    }
    return 0;
}

int main(int count, char **words) {
    char own[PATH_MAX];
    const char *executed = (const char *)getauxval(AT_EXECFN); /* without /proc */
    const ssize_t length = readlink("/proc/self/exe", own, sizeof own - 1);
    if (length > 0) own[length] = 0;
    else if (!executed || !realpath(executed, own)) return fputs("touchable: cannot find its own folder: /proc is missing\n", stderr), 1;
    char *home = strdup(own);
    for (int up = 0; up < 2; ++up) *strrchr(home, '/') = 0; /* bin/touchable */

    char *path = text("", "", ""), *loader = NULL;
    for (size_t k = 0; k < sizeof groups / sizeof *groups; ++k) {
        const struct group *group = &groups[k];
        char *folder = text(home, "/lib/fallback/", group->name);
        long theirs = 0;
        for (size_t m = 0; m < sizeof machine / sizeof *machine && theirs == 0; ++m)
            theirs = newest(text(machine[m], "/", group->library), group->version);
        if (theirs > 0 && (!group->version || theirs >= newest(text(folder, "/", group->library), group->version))) continue;
        if (k == 0) loader = text(folder, "/ld-linux-x86-64.so.2", "");
        path = text(path, *path ? ":" : "", folder);
    }
    if (!loader) loader = "/lib64/ld-linux-x86-64.so.2";

    setenv("TOUCHABLE_STARTED_AS", own, 1);
    unsetenv("LD_LIBRARY_PATH"); /* of other programs' libraries */
    unsetenv("LD_PRELOAD");
    if (!getenv("VK_DRIVER_FILES") && !getenv("VK_ICD_FILENAMES") && !has_drivers()) {
        const char *ours = text(home, "/share/vulkan/icd.d/lvp_icd.json", "");
        setenv("VK_DRIVER_FILES", ours, 1);
        setenv("VK_ICD_FILENAMES", ours, 1); /* loaders before 1.3.207 */
    }
    if (!getenv("FONTCONFIG_FILE") && access("/etc/fonts/fonts.conf", R_OK) != 0)
        setenv("FONTCONFIG_FILE", text(home, "/share/fonts/fonts.conf", ""), 1);

    char **all = calloc((size_t)count + 5, sizeof *all);
    if (!all) return 1;
    int n = 0;
    all[n++] = loader;
    all[n++] = "--library-path";
    all[n++] = path;
    all[n++] = text(home, "/libexec/touchable", "");
    for (int k = 1; k < count; ++k) all[n++] = words[k];
    execv(loader, all);
    fprintf(stderr, "touchable: %s: %s\n", loader, strerror(errno));
    return 1;
}
