// Compression of messages by zstd (RFC 8878). SPDX-License-Identifier: Apache-2.0
//
// Successive rows of a run differ in few bytes, so no search is needed: bytes are compared with those of the row
// before, and numbers and times of a message with those of the message before. Literals are stored as they are.
#pragma once

#include <string.h>

#include <cdpr/log/zstd_sequences.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int64_t ZSTD_BLOCK = 1 << 17;   // content of a block, bytes, at most
constexpr int64_t ZSTD_OFFSET = 1 << 20;  // of a match, bytes, at most
constexpr int64_t SHORTEST_MATCH = 4;     // 3 is allowed and 6 % smaller, and takes 1.4 times as long
constexpr int64_t WORD = 8;
constexpr int64_t FRAME_HEAD = 9;                  // bytes
constexpr int64_t ZSTD_SPARE = LONGEST_HEAD + 32;  // bytes that are written and not used

struct ZstdFrame {
    const int64_t* buffer;  // (c), contains the content
    const int64_t* heads;   // (h), positions in a row of bytes that equal those of the message before, in order
    const int64_t* before;  // (h), distances to these
    int64_t* sequences;     // (s), one for each 4 bytes of a block; fewer are used, as literals precede short matches
    int64_t* frame;         // (f): 9 bytes, the content, 3 for each block, and ZSTD_SPARE
    int64_t* size;          // (1), of the frame, bytes
    int64_t start, count;   // of the content, bytes
    int64_t row;            // bytes
    int64_t c, h, s, f;
    static constexpr char fields[] =
        "buffer(c), heads(h), before(h), work sequences(s), frame(f), size(1), start >= 0, count >= 0, row >= 1, c, h, "
        "s, f";
};

inline uint64_t word_at(const uint8_t* place) {
    uint64_t word = 0;
    memcpy(&word, place, WORD);
    return word;
}

inline uint64_t difference(const uint8_t* place, int64_t offset) { return word_at(place) ^ word_at(place - offset); }

// Numbers of equal bytes at the start and at the end of words that differ.
inline int64_t equal_start(uint64_t difference) { return __builtin_ctzll(difference) >> 3; }
inline int64_t equal_end(uint64_t difference) { return __builtin_clzll(difference) >> 3; }

// Writer of the content of one frame; a match may refer to earlier blocks.
struct ZstdWriter {
    const uint8_t *begin, *end, *readable;  // content; end of the buffer
    int64_t row;
    const int64_t *heads, *before;
    int64_t h;
    int64_t* sequences;
    const uint8_t* head_row;  // row of the next head
    int64_t head;             // index of the next head
    int64_t recent[3];        // last offsets

    inline const uint8_t* match_end(const uint8_t* place, int64_t offset, const uint8_t* stop) const;
    inline int64_t head_distance(const uint8_t* place);
    inline int64_t offset_number(int64_t offset, int64_t literals);
    inline uint8_t* copy(const uint8_t* from, const uint8_t* to, uint8_t* out) const;
    inline uint8_t* block(const uint8_t* start, const uint8_t* stop, uint8_t* out);
};

// Return the end of a match.
inline const uint8_t* ZstdWriter::match_end(const uint8_t* place, int64_t offset, const uint8_t* stop) const {
    for (; stop - place >= 2 * WORD; place += 2 * WORD) {
        const uint64_t first = difference(place, offset), second = difference(place + WORD, offset);
        if (first) return place + equal_start(first);
        if (second) return place + WORD + equal_start(second);
    }
    while (place < stop && *place == place[-offset]) place++;
    return place;
}

// Return the distance to the message before if this place is a head; otherwise 0.
inline int64_t ZstdWriter::head_distance(const uint8_t* place) {
    if (h == 0) return 0;
    while (head_row + heads[head] < place) {
        if (++head == h) {
            head = 0;
            head_row += row;
        }
    }
    const int64_t distance = head_row + heads[head] == place ? before[head] : 0;
    return 0 < distance && distance <= place - begin && distance <= ZSTD_OFFSET ? distance : 0;
}

// Return the number that names an offset after some literals, and make the offset the most recent one.
inline int64_t ZstdWriter::offset_number(int64_t offset, int64_t literals) {
    const int64_t none = literals == 0;  // the most recent offset then has no number
    if (offset == recent[0] && !none) return 1;
    int64_t number = offset + 3;
    if (offset == recent[1]) {
        number = 2 - none;
    } else {
        if (offset == recent[2]) number = 3 - none;
        recent[2] = recent[1];
    }
    recent[1] = recent[0];
    recent[0] = offset;
    return number;
}

// Copy bytes, and perhaps up to 15 more; return the end of the copy.
inline uint8_t* ZstdWriter::copy(const uint8_t* from, const uint8_t* to, uint8_t* out) const {
    uint8_t* const after = out + (to - from);
    if (readable - to < 16) {
        memcpy(out, from, size_t(to - from));
        return after;
    }
    for (; from < to; from += 16, out += 16) memcpy(out, from, 16);
    return after;
}

// Write one block at `out`, with 3 more bytes than its content at most, and spare bytes after it; return its end.
inline uint8_t* ZstdWriter::block(const uint8_t* start, const uint8_t* stop, uint8_t* out) {
    const int64_t content = stop - start, last = stop == end;
    const int64_t old[3] = {recent[0], recent[1], recent[2]};
    const uint8_t *literal = start, *place = start;
    uint8_t* literals = out + 6;
    int64_t* sequence = sequences;
    if (row > ZSTD_OFFSET) place = stop;
    if (place - begin < row) place = stop - begin < row ? stop : begin + row;
    const auto add = [&](const uint8_t* to, int64_t length, int64_t offset) {
        literals = copy(literal, to, literals);
        const int64_t count = to - literal;
        *sequence++ = Sequence::packed(count, length, offset_number(offset, count));
        literal = to + length;
    };
    int64_t equal = 0;  // number of equal bytes just before
    while (stop - place >= WORD) {
        const uint64_t differing = difference(place, row);
        if (differing) {
            const int64_t more = equal_start(differing);
            if (equal + more < SHORTEST_MATCH) {
                equal = equal_end(differing);
                place += WORD;
                continue;
            }
            add(place - equal, equal + more, row);
            place += more;
            equal = more ? 0 : equal_end(differing);
            if (!more) place += WORD;
            continue;
        }
        add(place - equal, match_end(place + WORD, row, stop) - place + equal, row);
        equal = 0;
        place = literal;
        const int64_t distance = head_distance(place);
        if (distance && stop - place >= WORD && difference(place, distance) == 0) {
            add(place, match_end(place + WORD, distance, stop) - place, distance);
            place = literal;
        }
    }
    literals = copy(literal, stop, literals);
    const int64_t count = literals - (out + 6);
    uint8_t* written = nullptr;
    if (sequence > sequences) written = put_sequences(sequences, sequence - sequences, literals, out + content);
    if (written == nullptr || written - out >= content + 3) {
        for (int i = 0; i < 3; i++) recent[i] = old[i];
        put_bytes(out, last | 0 << 1 | content << 3, 3);
        return copy(start, stop, out + 3);
    }
    put_bytes(out, last | 2 << 1 | (written - out - 3) << 3, 3);
    put_bytes(out + 3, 0 | 3 << 2 | count << 4, 3);
    return written;
}

inline int write_zstd(ZstdFrame& problem) {
    const int64_t blocks = problem.count / ZSTD_BLOCK + 1;
    const int64_t most = problem.count < ZSTD_BLOCK ? problem.count : ZSTD_BLOCK;
    const bool held = problem.start <= WORD * problem.c && problem.count <= WORD * problem.c - problem.start;
    if (!held || problem.count > UINT32_MAX || problem.s < most / SHORTEST_MATCH ||
        WORD * problem.f < FRAME_HEAD + problem.count + 3 * blocks + ZSTD_SPARE)
        return 1;
    const uint8_t* const buffer = reinterpret_cast<const uint8_t*>(problem.buffer);
    const uint8_t* start = buffer + problem.start;
    const uint8_t* const end = start + problem.count;
    ZstdWriter writer = {start,          end,       buffer + WORD * problem.c, problem.row, problem.heads,
                         problem.before, problem.h, problem.sequences,         start,       0,
                         {1, 4, 8}};
    uint8_t* const frame = reinterpret_cast<uint8_t*>(problem.frame);
    put_bytes(frame, 0xfd2fb528, 4);
    put_bytes(frame + 4, 0xa0, 1);  // one segment, whose size has 4 bytes
    put_bytes(frame + 5, problem.count, 4);
    uint8_t* out = frame + FRAME_HEAD;
    do {
        const uint8_t* const stop = end - start < ZSTD_BLOCK ? end : start + ZSTD_BLOCK;
        out = writer.block(start, stop, out);
        start = stop;
    } while (start < end);
    *problem.size = out - frame;
    return 0;
}

}  // namespace cdpr::CDPR_TARGET
