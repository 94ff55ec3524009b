/* The header is C: this file is compiled as such, and every struct has its size first. */
#include "capi/touchable.h"

#define SIZE_IS_FIRST(type) _Static_assert(offsetof(type, struct_size) == 0, #type " does not begin with its size")
SIZE_IS_FIRST(touch_error);
SIZE_IS_FIRST(touch_camera);
SIZE_IS_FIRST(touch_scene_facts);
SIZE_IS_FIRST(touch_frame);
SIZE_IS_FIRST(touch_surface_settings);
SIZE_IS_FIRST(touch_solver_settings);
SIZE_IS_FIRST(touch_tick);
SIZE_IS_FIRST(touch_contact);

