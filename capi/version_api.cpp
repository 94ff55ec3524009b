// touch_version, and names of statuses.
#include "capi/touchable.h"

uint32_t touch_version(void) {
    return TOUCH_VERSION;
}

const char* touch_status_name(touch_status status) {
    switch (status) {
        case TOUCH_OK:
            return "done";
        case TOUCH_INTERNAL:
            return "internal fault";
        case TOUCH_USAGE:
            return "bad argument";
        case TOUCH_INPUT:
            return "bad input";
        case TOUCH_INTERRUPTED:
            return "interrupted";
        case TOUCH_STALE:
            return "stale handle";
        case TOUCH_BUSY:
            return "busy";
        case TOUCH_FULL:
            return "full";
        case TOUCH_END:
            return "no more frames";
        case TOUCH_NO_MEMORY:
            return "not enough memory";
        case TOUCH_FORKED:
            return "belongs to the parent process";
        default:
            return "unknown status";
    }
}
