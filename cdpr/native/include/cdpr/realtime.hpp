// Desired motion, controller and tension distribution in a real-time program. SPDX-License-Identifier: Apache-2.0
//
// `cdpr export --to native` writes the structure of a pipeline into a header and its numbers into a file: 8-byte words,
// little-endian: magic, version, signature of the structure, count, the numbers, and the CRC-32 of the preceding words.
// Nothing here allocates; all memory belongs to the caller.
#pragma once

#include <stdint.h>
#include <string.h>

#include <cdpr/table.h>
#include <cdpr/calls.hpp>
#include <cdpr/number.hpp>

namespace cdpr::CDPR_TARGET {

constexpr uint64_t NUMBERS_MAGIC = 0x006d756e72706463;  // "cdprnum"
constexpr uint64_t NUMBERS_VERSION = 1;
constexpr size_t NUMBERS_HEAD = 4;       // words
constexpr double UNIT_TOLERANCE = 1e-3;  // allowed difference of the squared norm of a quaternion from 1

enum class Loaded { YES, BAD_SIZE, BAD_MAGIC, BAD_VERSION, BAD_SIGNATURE, BAD_CHECKSUM };

// Member of an operation's struct: an address in the numbers or integers, a number itself, or an integer.
enum class MemberKind { NUMBERS_AT, INTEGERS_AT, NUMBER, WORD };
struct ExportedMember {
    MemberKind kind;
    uint64_t value;  // an index, or of WORD the bits
};

struct ExportedCall {
    cdpr_entry entry;
    size_t first;  // index of its first member
    bool in_order;
    Vital vital;
    size_t skip;
    int repair;
};

// Structure of a pipeline: everything except its numbers.
struct ExportedPipeline {
    uint64_t signature;
    const ExportedCall* calls;
    const ExportedMember* members;
    const int64_t* integers;  // initial integers
    size_t call_count, member_count, integer_count;
    size_t number_count, work_count;  // numbers in the file; additional scratch space
    size_t cables;
    size_t state, desired, tension, report;  // indices into the numbers

    constexpr size_t file_words() const { return NUMBERS_HEAD + number_count + 1; }
    constexpr size_t memory_words() const {
        return call_count * (sizeof(Call) / 8) + member_count + integer_count + number_count + work_count;
    }
};

// Parts of a pipeline's memory.
struct ExportedMemory {
    uint64_t *calls, *members, *integers, *numbers;

    ExportedMemory(const ExportedPipeline& pipeline, uint64_t* memory)
        : calls(memory),
          members(calls + pipeline.call_count * (sizeof(Call) / 8)),
          integers(members + pipeline.member_count),
          numbers(integers + pipeline.integer_count) {}

    const Call* call() const { return reinterpret_cast<const Call*>(calls); }
    double* number(size_t index) const { return reinterpret_cast<double*>(numbers + index); }
};

inline uint64_t checksum_of(const unsigned char* bytes, size_t size) {
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
    }
    return crc ^ 0xffffffffu;
}

// Check a file of numbers, at any alignment.
inline Loaded check_numbers(const ExportedPipeline& pipeline, const unsigned char* file, size_t size) {
    uint64_t head[NUMBERS_HEAD] = {}, checksum = 0;
    if (size < sizeof head) return Loaded::BAD_SIZE;
    memcpy(head, file, sizeof head);
    if (head[0] != NUMBERS_MAGIC) return Loaded::BAD_MAGIC;
    if (head[1] != NUMBERS_VERSION) return Loaded::BAD_VERSION;
    if (size % 8 != 0 || head[3] != size / 8 - NUMBERS_HEAD - 1) return Loaded::BAD_SIZE;
    if (head[2] != pipeline.signature || head[3] != pipeline.number_count) return Loaded::BAD_SIGNATURE;
    memcpy(&checksum, file + size - 8, 8);
    return checksum == checksum_of(file, size - 8) ? Loaded::YES : Loaded::BAD_CHECKSUM;
}

// Fill the memory of a pipeline: numbers, integers, and the structs and calls that refer to them.
inline void bind_pipeline(const ExportedPipeline& pipeline, const unsigned char* file, uint64_t* memory) {
    const ExportedMemory parts(pipeline, memory);
    memcpy(parts.numbers, file + 8 * NUMBERS_HEAD, 8 * pipeline.number_count);
    memset(parts.numbers + pipeline.number_count, 0, 8 * pipeline.work_count);
    memcpy(parts.integers, pipeline.integers, 8 * pipeline.integer_count);
    for (size_t i = 0; i < pipeline.member_count; i++) {
        const ExportedMember& member = pipeline.members[i];
        uint64_t word = member.value;
        if (member.kind == MemberKind::NUMBER) word = parts.numbers[member.value];
        if (member.kind == MemberKind::NUMBERS_AT) word = uint64_t(uintptr_t(parts.numbers + member.value));
        if (member.kind == MemberKind::INTEGERS_AT) word = uint64_t(uintptr_t(parts.integers + member.value));
        memcpy(parts.members + i, &word, 8);
    }
    for (size_t i = 0; i < pipeline.call_count; i++) {
        const ExportedCall& from = pipeline.calls[i];
        const Call call = {from.entry.call, parts.members + from.first, from.in_order, from.vital, from.skip,
                           from.repair};
        memcpy(parts.calls + i * (sizeof call / 8), &call, sizeof call);
    }
}

CDPR_INLINE bool is_unit(const double* q) {
    const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    return square > 1.0 - UNIT_TOLERANCE && square < 1.0 + UNIT_TOLERANCE;
}

// Return whether a state (13) and a desired motion (19) are finite, with unit quaternions.
inline bool sound_input(double time, const double* state, const double* desired) {
    return finite(time) && all_finite(state, 13) && all_finite(desired, 19) && is_unit(state + 3) &&
           is_unit(desired + 3);
}

// Write the desired motion at a time, by the last call of the pipeline.
inline void sample_motion(const ExportedPipeline& pipeline, uint64_t* memory, double time, double* desired) {
    const ExportedMemory parts(pipeline, memory);
    const Call& motion = parts.call()[pipeline.call_count - 1];
    motion.operation(motion.place, time);
    memcpy(desired, parts.number(pipeline.desired), 19 * sizeof(double));
}

// Run one control step; return the failed call, nullptr for success. Tensions (m) are written on success.
inline const Call* step_pipeline(const ExportedPipeline& pipeline, uint64_t* memory, double time, const double* state,
                                 const double* desired, double* tension) {
    const ExportedMemory parts(pipeline, memory);
    memcpy(parts.number(pipeline.state), state, 13 * sizeof(double));
    memcpy(parts.number(pipeline.desired), desired, 19 * sizeof(double));
    const Call* failed = make_calls(parts.call(), pipeline.call_count, time);
    if (!failed) memcpy(tension, parts.number(pipeline.tension), pipeline.cables * sizeof(double));
    return failed;
}

}  // namespace cdpr::CDPR_TARGET
