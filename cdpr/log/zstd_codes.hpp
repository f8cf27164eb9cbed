// Codes of zstd's sequences (RFC 8878), with probabilities suited to the messages of a run.
// SPDX-License-Identifier: Apache-2.0
//
// A sequence is a number of literals, the length of the match after them, and its offset. Each of these numbers is
// coded as a symbol and additional bits. Symbols are coded by finite states: all probabilities are constant powers of
// two, so that each symbol has a constant number of bits.
#pragma once

#include <stdint.h>

#include <cdpr/target.hpp>

namespace cdpr::CDPR_TARGET {

constexpr int STATE_BITS = 8;
constexpr int STATES = 1 << STATE_BITS;

template <int symbols> struct StateCode {
    uint8_t bits[symbols] = {};        // that a state of this symbol passes on
    uint16_t first[symbols] = {};      // index of its first state in `states`
    uint8_t states[STATES] = {};       // by symbol, in ascending order
    uint8_t description[STATES] = {};  // as in a block
    int description_size = 0;
};

// `shares` are the binary logarithms of the numbers of states of each symbol.
template <int symbols> constexpr StateCode<symbols> state_code(const int (&shares)[symbols]) {
    StateCode<symbols> code;
    int symbol_of[STATES] = {}, place = 0, next = 0;
    for (int symbol = 0; symbol < symbols; symbol++)
        for (int i = 0; i < 1 << shares[symbol]; i++, place = (place + STATES / 2 + STATES / 8 + 3) % STATES)
            symbol_of[place] = symbol;
    for (int symbol = 0; symbol < symbols; symbol++) {
        code.bits[symbol] = uint8_t(STATE_BITS - shares[symbol]);
        code.first[symbol] = uint16_t(next);
        for (int state = 0; state < STATES; state++)
            if (symbol_of[state] == symbol) code.states[next++] = uint8_t(state);
    }
    uint64_t bits = STATE_BITS - 5;
    int count = 4, left = STATES + 1, threshold = STATES, width = STATE_BITS + 1;
    for (int symbol = 0; symbol < symbols; symbol++) {
        const int most = 2 * threshold - 1 - left;  // smaller values take one bit less
        int value = (1 << shares[symbol]) + 1;
        left -= 1 << shares[symbol];
        if (value >= threshold) value += most;
        bits |= uint64_t(value) << count;
        count += width - (value < most);
        for (; left < threshold && threshold > 1; threshold /= 2) width--;
        for (; count >= 8; count -= 8, bits >>= 8) code.description[code.description_size++] = uint8_t(bits);
    }
    if (count > 0) code.description[code.description_size++] = uint8_t(bits);
    return code;
}

// Symbols of numbers of literals up to 2^17 - 1: their first numbers and additional bits.
constexpr int LITERALS_SHARES[] = {7, 0, 0, 3, 3, 3, 3, 1, 0, 0, 0, 0, 2, 2, 2, 0, 0, 0,
                                   4, 4, 2, 2, 2, 3, 3, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0};
// Symbols of lengths of matches, from 3 to 2^17 + 2.
constexpr int LENGTH_SHARES[] = {1, 5, 3, 1, 0, 0, 0, 2, 2, 2, 5, 4, 3, 0, 0, 3, 3, 0, 3, 3, 0, 4, 0, 0, 0, 0, 0,
                                 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 5, 0, 2, 4, 2, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
// Symbols of offsets below 2^21.
constexpr int OFFSET_SHARES[] = {7, 6, 0, 0, 0, 2, 4, 3, 3, 2, 3, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0};

inline constexpr auto LITERALS_CODE = state_code(LITERALS_SHARES);
inline constexpr auto LENGTH_CODE = state_code(LENGTH_SHARES);
inline constexpr auto OFFSET_CODE = state_code(OFFSET_SHARES);

inline int highest_bit(int64_t number) { return 63 - __builtin_clzll(uint64_t(number)); }

// Symbols of numbers below `most`, a power of two, and the numbers of additional bits, which are the lowest ones.
// Larger numbers have one symbol for each power of two.
template <int most> struct SmallSymbols {
    uint8_t symbols[most] = {}, widths[most] = {};
    int after = 0;  // symbol of a larger number, less its binary logarithm
};

// `counts` are the numbers of symbols with 0, 1, ... additional bits.
template <int most, int widths> constexpr SmallSymbols<most> small_symbols(const int (&counts)[widths]) {
    SmallSymbols<most> small;
    int symbol = 0, number = 0;
    for (int width = 0; width < widths; width++)
        for (int i = 0; i < counts[width]; i++, symbol++)
            for (int end = number + (1 << width); number < end; number++) {
                small.symbols[number] = uint8_t(symbol);
                small.widths[number] = uint8_t(width);
            }
    small.after = symbol;
    for (int rest = most; rest > 1; rest /= 2) small.after--;
    return small;
}

constexpr int LITERALS_COUNTS[] = {16, 4, 2, 2, 1}, LENGTH_COUNTS[] = {32, 4, 2, 2, 2, 1};
inline constexpr auto SMALL_LITERALS = small_symbols<64>(LITERALS_COUNTS);
inline constexpr auto SMALL_LENGTHS = small_symbols<128>(LENGTH_COUNTS);

}  // namespace cdpr::CDPR_TARGET
