// SPDX-License-Identifier: Apache-2.0
// Columns of the 3x3 windows of two rows, for GLSL.
#ifndef TOUCHABLE_SHADERS_COLUMNS3_H
#define TOUCHABLE_SHADERS_COLUMNS3_H

/// A column of the upper row's window (rows 0 to 2) and of the lower one's (rows 1 to 3); the rows' own codes
/// and validity, and how many codes of each are invalid.
struct Column {
    Ranked3 upper, lower;
    uint upper_code, lower_code, upper_invalid, lower_invalid;
    bool upper_valid, lower_valid;
};

Column rank_column(uint codes[4], bool valid[4]) {
    uint v[4], invalid[4];
    [[unroll]] for (int k = 0; k < 4; ++k) {
        v[k] = valid[k] ? codes[k] : 65535u;
        invalid[k] = valid[k] ? 0u : 1u;
    }
    order(v[1], v[2]);
    uint upper[3] = uint[3](v[0], v[1], v[2]), lower[3] = uint[3](v[3], v[1], v[2]);
    insert3(upper);
    insert3(lower);
    const uint shared_invalid = invalid[1] + invalid[2];
    Column column;
    column.upper_invalid = shared_invalid + invalid[0];
    column.lower_invalid = shared_invalid + invalid[3];
    column.upper = balanced3(upper, column.upper_invalid);
    column.lower = balanced3(lower, column.lower_invalid);
    column.upper_code = codes[1];
    column.lower_code = codes[2];
    column.upper_valid = valid[1];
    column.lower_valid = valid[2];
    return column;
}

#endif
