// Sequences of a block of zstd (RFC 8878), written as bits from the last one to the first.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string.h>

#include <cdpr/log/zstd_codes.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int64_t SHORTEST_LENGTH = 3;  // of a match
constexpr int LONGEST_HEAD = 256;       // bytes before the bits of the sequences, at most

// Sequence in one integer: number of literals, length of the match, and the number that names its offset.
struct Sequence {
    static constexpr int WIDTH = 18;
    static constexpr int64_t MASK = (1 << WIDTH) - 1;

    static int64_t packed(int64_t literals, int64_t length, int64_t offset) {
        return literals | length << WIDTH | offset << 2 * WIDTH;
    }
};

inline void put_bytes(uint8_t* out, int64_t number, int count) {
    for (int i = 0; i < count; i++) out[i] = uint8_t(number >> 8 * i);
}

struct BitWriter {
    uint8_t* out;
    uint64_t bits;
    int count;

    inline void put(uint64_t value, int width) {
        bits |= value << count;
        count += width;
    }
    inline void flush() {
        memcpy(out, &bits, sizeof bits);
        out += count >> 3;
        bits >>= count & ~7;
        count &= 7;
    }
};

// Symbol of a number with its additional bits.
struct Symbol {
    int symbol, width;
    uint64_t extra;
};

template <int most> inline Symbol symbol_of(const SmallSymbols<most>& small, int64_t number) {
    if (number < most) {
        const int width = small.widths[number];
        return {small.symbols[number], width, uint64_t(number & ((1 << width) - 1))};
    }
    const int high = highest_bit(number);
    return {high + small.after, high, uint64_t(number) ^ 1ull << high};
}

inline Symbol offset_symbol(int64_t value) {
    const int high = highest_bit(value);
    return {high, high, uint64_t(value) ^ 1ull << high};
}

// State of a code; the sequences are written backwards.
template <int symbols> struct StateWriter {
    const StateCode<symbols>& code;
    int state;

    StateWriter(const StateCode<symbols>& code, int symbol) : code(code), state(code.states[code.first[symbol]]) {}

    // Write what leads from a symbol to the present state, and change to the symbol's.
    void step(BitWriter& writer, int symbol) {
        const int width = code.bits[symbol];
        writer.put(uint64_t(state & ((1 << width) - 1)), width);
        state = code.states[code.first[symbol] + (state >> width)];
    }
};

template <int symbols> inline uint8_t* put_description(const StateCode<symbols>& code, uint8_t* out) {
    for (int i = 0; i < code.description_size; i++) *out++ = code.description[i];
    return out;
}

// Write sequences, 1 to 0x7eff, the last one first, up to `limit`; return their end, or nullptr if they do not fit.
inline uint8_t* put_sequences(const int64_t* sequences, int64_t count, uint8_t* out, const uint8_t* limit) {
    if (count >= 128) *out++ = uint8_t((count >> 8) + 128);
    *out++ = uint8_t(count);
    *out++ = 0xa8;  // all three codes are described
    out = put_description(LITERALS_CODE, out);
    out = put_description(OFFSET_CODE, out);
    out = put_description(LENGTH_CODE, out);
    BitWriter writer = {out, 0, 0};
    const auto literals_at = [&](int64_t i) { return symbol_of(SMALL_LITERALS, sequences[i] & Sequence::MASK); };
    const auto length_at = [&](int64_t i) {
        return symbol_of(SMALL_LENGTHS, (sequences[i] >> Sequence::WIDTH & Sequence::MASK) - SHORTEST_LENGTH);
    };
    const auto offset_at = [&](int64_t i) { return offset_symbol(sequences[i] >> 2 * Sequence::WIDTH); };
    Symbol literals = literals_at(count - 1), length = length_at(count - 1), offset = offset_at(count - 1);
    StateWriter<36> literals_state(LITERALS_CODE, literals.symbol);
    StateWriter<53> length_state(LENGTH_CODE, length.symbol);
    StateWriter<21> offset_state(OFFSET_CODE, offset.symbol);
    for (int64_t i = count - 1;;) {
        writer.put(literals.extra, literals.width);
        if (literals.width + length.width + offset.width > 32) writer.flush();
        writer.put(length.extra, length.width);
        writer.put(offset.extra, offset.width);
        writer.flush();
        if (writer.out > limit) return nullptr;
        if (--i < 0) break;
        literals = literals_at(i), length = length_at(i), offset = offset_at(i);
        offset_state.step(writer, offset.symbol);
        length_state.step(writer, length.symbol);
        literals_state.step(writer, literals.symbol);
    }
    writer.put(uint64_t(length_state.state), STATE_BITS);
    writer.put(uint64_t(offset_state.state), STATE_BITS);
    writer.put(uint64_t(literals_state.state), STATE_BITS);
    writer.put(1, 1);
    writer.flush();
    if (writer.count > 0) writer.out++;
    return writer.out;
}

}  // namespace cdpr::CDPR_TARGET
