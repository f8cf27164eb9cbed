// Number of connected components of the cells inside a workspace, cells in order. SPDX-License-Identifier: Apache-2.0
//
// Union-find over labels; only those of the last layer are stored (Hoshen and Kopelman, Phys. Rev. B 14, 1976). A layer
// has rows * columns cells.
#pragma once

#include <cdpr/field.hpp>

namespace cdpr::CDPR_TARGET {

struct ConnectedCells {
    const int64_t* inside;  // (count), 0 for a cell outside
    int64_t* above;         // (size), the last label in each position of a layer, -1 outside
    int64_t* parent;        // (2 size), of each label; itself for a root
    int64_t* fresh;         // (2 size), work space
    int64_t* state;         // (2): labels in use, components so far
    int64_t first;          // number of the first cell
    int64_t columns;        // of a layer
    int64_t count;
    int64_t size;
    static constexpr char fields[] =
        "inside(count), both above(size >= 1), both parent(2*size), work fresh(2*size), both state(2), first, columns "
        ">= 1, "
        "count, size";

    CDPR_INLINE int64_t& labels() const { return state[0]; }
    CDPR_INLINE int64_t& pieces() const { return state[1]; }
    inline int64_t root(int64_t label) const;
    inline void renumber();
    inline int64_t join(int64_t mine, int64_t other);
};

// Return the root of a label, and compress the path to it.
inline int64_t ConnectedCells::root(int64_t label) const {
    while (parent[label] != label) {
        parent[label] = parent[parent[label]];
        label = parent[label];
    }
    return label;
}

// Renumber the labels of a layer from 0, and discard all others.
inline void ConnectedCells::renumber() {
    for (int64_t k = 0; k < labels(); k++) fresh[k] = -1;
    int64_t next = 0;
    for (int64_t r = 0; r < size; r++) {
        if (above[r] < 0) continue;
        const int64_t label = root(above[r]);
        if (fresh[label] < 0) fresh[label] = next++;
        above[r] = fresh[label];
    }
    for (int64_t k = 0; k < next; k++) parent[k] = k;
    labels() = next;
}

// Merge the label of a cell, -1 if it has none yet, with that of a neighbour, -1 if that is outside; return the result.
inline int64_t ConnectedCells::join(int64_t mine, int64_t other) {
    if (other < 0) return mine;
    other = root(other);
    if (mine < 0 || other == mine) return other;
    const int64_t low = mine < other ? mine : other, high = mine < other ? other : mine;
    parent[high] = low;
    pieces()--;
    return low;
}

inline int connected_cells(ConnectedCells& cells) {
    for (int64_t k = 0; k < cells.count; k++) {
        const int64_t r = (cells.first + k) % cells.size;
        if (r == 0) cells.renumber();
        int64_t mine = -1;
        if (cells.inside[k] != 0) {
            mine = cells.join(mine, cells.above[r]);
            if (r >= cells.columns) mine = cells.join(mine, cells.above[r - cells.columns]);
            if (r % cells.columns > 0) mine = cells.join(mine, cells.above[r - 1]);
            if (mine < 0) {
                mine = cells.labels()++;
                cells.parent[mine] = mine;
                cells.pieces()++;
            }
        }
        cells.above[r] = mine;
    }
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
