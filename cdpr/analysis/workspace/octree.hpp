// Interpolation of workspace results in boxes of cells, and division of boxes. SPDX-License-Identifier: Apache-2.0
//
// A box (3, 2) spans its lowest to its highest cell, both included, on each axis. Its eight corners are known. The last
// axis is the fastest, for cells as well as for corners and points. Values may be infinite or NaN.
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int64_t UNKNOWN = -1, OUTSIDE = 0, INSIDE = 1;  // sides of the edge

// Results of all cells of a table.
struct CellTable {
    const int64_t* strides;  // (3)
    double* value;           // (cells)
    int64_t* limit;          // (cells), limiting cause
    int64_t* side;           // (cells)
    double edge;             // value between inside and outside
    int64_t cells;
    static constexpr char fields[] = "strides(3), both value(cells), both limit(cells), both side(cells), edge, cells";
};

struct BoxCorners {
    int64_t cell[8];
    double value[8];
    int64_t size[3];
    bool finite;

    BoxCorners(const CellTable& table, const int64_t* box) {
        for (int64_t i = 0; i < 3; i++) size[i] = box[2 * i + 1] - box[2 * i];
        for (int64_t k = 0; k < 8; k++) {
            const int64_t at[3] = {box[k >> 2], box[2 + (k >> 1 & 1)], box[4 + (k & 1)]};
            cell[k] = at[0] * table.strides[0] + at[1] * table.strides[1] + at[2] * table.strides[2];
            value[k] = table.value[cell[k]];
        }
        finite = all_finite(value, 8);
    }

    // Return a step along an axis as a share of the side, 0 in a flat box.
    CDPR_INLINE double share(int64_t axis, int64_t step) const {
        return size[axis] > 0 ? double(step) / double(size[axis]) : 0.0;
    }

    // Return the trilinear interpolation at shares of the sides; corners with zero weight are ignored.
    CDPR_INLINE double at(const double* share) const {
        const double x = share[0], y = share[1], z = share[2], a = 1.0 - x, b = 1.0 - y, c = 1.0 - z;
        const double weight[8] = {a * b * c, a * b * z, a * y * c, a * y * z,
                                  x * b * c, x * b * z, x * y * c, x * y * z};
        const double* v = value;
        if (finite)
            return weight[0] * v[0] + weight[1] * v[1] + weight[2] * v[2] + weight[3] * v[3] + weight[4] * v[4] +
                   weight[5] * v[5] + weight[6] * v[6] + weight[7] * v[7];
        double sum = 0.0;
        for (int64_t k = 0; k < 8; k++)
            if (weight[k] != 0.0) sum += weight[k] * v[k];
        return sum;
    }

    // Return the cell of the nearest corner, the upper one in the middle.
    CDPR_INLINE int64_t nearest(const double* share) const {
        return cell[(share[0] >= 0.5) * 4 + (share[1] >= 0.5) * 2 + (share[2] >= 0.5)];
    }

    // Return whether the corners determine all cells in between: all are on the same side, and farther from the edge
    // than `need` and a share `near` of their spread, or all are NaN or the same infinity.
    inline bool determine(const CellTable& table, double near, double need) const;

    // Call `use(point, cell, share)` for the 27 points in the lowest, middle and highest cells.
    template <class Use> CDPR_INLINE void points(const CellTable& table, const int64_t* box, const Use& use) const;
};

inline bool BoxCorners::determine(const CellTable& table, double near, double need) const {
    double least = INFINITE, low = INFINITE, high = -INFINITE;
    int64_t missing = 0;
    for (int64_t k = 0; k < 8; k++) {
        if (table.side[cell[k]] != table.side[cell[0]]) return false;
        const double off = value[k] - table.edge;
        if (off != off) {
            missing++;
            continue;
        }
        if (absolute(off) < least) least = absolute(off);
        if (off < low) low = off;
        if (off > high) high = off;
    }
    if (missing > 0) return missing == 8;
    if (low == high && absolute(low) == INFINITE) return true;
    return least > near * (high - low) && least > need;
}

template <class Use>
CDPR_INLINE void BoxCorners::points(const CellTable& table, const int64_t* box, const Use& use) const {
    const int64_t* strides = table.strides;
    for (int64_t i = 0; i < 3; i++) {
        for (int64_t j = 0; j < 3; j++) {
            for (int64_t k = 0; k < 3; k++) {
                const int64_t step[3] = {i * size[0] / 2, j * size[1] / 2, k * size[2] / 2};
                const double shares[3] = {share(0, step[0]), share(1, step[1]), share(2, step[2])};
                const int64_t at =
                    (box[0] + step[0]) * strides[0] + (box[2] + step[1]) * strides[1] + (box[4] + step[2]) * strides[2];
                use(9 * i + 3 * j + k, at, shares);
            }
        }
    }
}

// Interpolates the unknown cells of boxes with corners that determine them.
struct SettleBoxes {
    CellTable table;
    const int64_t* boxes;  // (n, 3, 2)
    const double* need;    // (n), minimum distance of the corners' values from the edge
    double near;           // the same as a share of their spread
    int64_t* settled;      // (n), 1 for these boxes
    int64_t n;
    static constexpr auto fields = extended(CellTable::fields, "boxes(n, 3, 2), need(n), near, settled(n), n");
};

inline int settle_boxes(SettleBoxes& call) {
    const CellTable& table = call.table;
    for (int64_t n = 0; n < call.n; n++) {
        const int64_t* box = call.boxes + 6 * n;
        const BoxCorners corners(table, box);
        call.settled[n] = corners.determine(table, call.near, call.need[n]);
        if (call.settled[n] == 0) continue;
        const int64_t side = table.side[corners.cell[0]];
        double share[3];
        for (int64_t i = 0; i <= corners.size[0]; i++) {
            share[0] = corners.share(0, i);
            for (int64_t j = 0; j <= corners.size[1]; j++) {
                share[1] = corners.share(1, j);
                const int64_t row = corners.cell[0] + i * table.strides[0] + j * table.strides[1];
                for (int64_t k = 0; k <= corners.size[2]; k++) {
                    const int64_t cell = row + k * table.strides[2];
                    if (table.side[cell] != UNKNOWN) continue;
                    share[2] = corners.share(2, k);
                    table.value[cell] = corners.at(share);
                    table.limit[cell] = table.limit[corners.nearest(share)];
                    table.side[cell] = side;
                }
            }
        }
    }
    return 0;
}

// Interpolates the points of boxes, and lists those that may lie on the other side of the edge than their values.
struct BoxPoints {
    CellTable table;
    const int64_t* boxes;  // (n, 3, 2)
    const double* need;    // (n), minimum distance of a value from the edge without doubt
    double* values;        // (n, 27)
    int64_t* doubtful;     // (27 n): the first `count` cells, several times if they belong to several boxes
    int64_t* count;        // (1)
    int64_t n;
    static constexpr auto fields =
        extended(CellTable::fields, "boxes(n, 3, 2), need(n), values(n, 27), doubtful(27*n), count(1), n");
};

inline int box_points(BoxPoints& call) {
    call.count[0] = 0;
    for (int64_t n = 0; n < call.n; n++) {
        const int64_t* box = call.boxes + 6 * n;
        const BoxCorners corners(call.table, box);
        corners.points(call.table, box, [&](int64_t point, int64_t cell, const double* share) {
            const double value = call.values[27 * n + point] = corners.at(share);
            if (!(absolute(value - call.table.edge) > call.need[n])) call.doubtful[call.count[0]++] = cell;
        });
    }
    return 0;
}

// Divides boxes into up to eight, after the evaluation of doubtful points; the other points get interpolated values.
struct DivideBoxes {
    CellTable table;
    const int64_t* boxes;  // (n, 3, 2)
    const double* values;  // (n, 27), interpolated before the evaluation
    int64_t* parts;        // (8 n, 3, 2): the first `count` boxes, which have cells other than corners
    double* error;         // (8 n), largest difference between known and interpolated values of the divided box
    int64_t* count;        // (1)
    int64_t n;
    static constexpr auto fields =
        extended(CellTable::fields, "boxes(n, 3, 2), values(n, 27), parts(8*n, 3, 2), error(8*n), count(1), n");
};

// Append the parts of a box that have cells other than corners.
inline void append_parts(DivideBoxes& call, const int64_t* box, const BoxCorners& corners, double error) {
    for (int64_t k = 0; k < 8; k++) {
        const int64_t upper[3] = {k >> 2, k >> 1 & 1, k & 1};
        int64_t* part = call.parts + 6 * call.count[0];
        int64_t longest = 0;
        bool empty = false;
        for (int64_t i = 0; i < 3; i++) {
            const int64_t middle = box[2 * i] + corners.size[i] / 2;
            part[2 * i] = upper[i] ? middle : box[2 * i];
            part[2 * i + 1] = upper[i] ? box[2 * i + 1] : middle;
            const int64_t size = part[2 * i + 1] - part[2 * i];
            empty |= size == 0 && (corners.size[i] > 0 || upper[i]);
            if (size > longest) longest = size;
        }
        if (empty || longest < 2) continue;
        call.error[call.count[0]++] = error;
    }
}

inline int divide_boxes(DivideBoxes& call) {
    const CellTable& table = call.table;
    call.count[0] = 0;
    for (int64_t n = 0; n < call.n; n++) {
        const int64_t* box = call.boxes + 6 * n;
        const BoxCorners corners(table, box);
        double error = 0.0;
        corners.points(table, box, [&](int64_t point, int64_t cell, const double* share) {
            const double value = call.values[27 * n + point];
            if (table.side[cell] == UNKNOWN) {
                table.value[cell] = value;
                table.limit[cell] = table.limit[corners.nearest(share)];
                table.side[cell] = value > table.edge ? INSIDE : OUTSIDE;
            }
            const double missed = absolute(table.value[cell] - value);
            if (!(missed < INFINITE)) error = INFINITE;  // infinite or NaN
            if (missed > error) error = missed;
        });
        append_parts(call, box, corners, error);
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
