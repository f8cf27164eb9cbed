// Random numbers: MRG32k3a, uniform and normal. SPDX-License-Identifier: Apache-2.0
//
// L'Ecuyer (1999), "Good parameters and implementations for combined multiple recursive random number generators",
// Operations Research 47(1), fig. I; period 2^191. All its integers are below 2^53, hence exact as doubles. The
// functions use no mathematics of the C library but the square root: the same bits in lanes and on every processor.
#pragma once

#include <cdpr/field.hpp>
#include <cdpr/status.hpp>

namespace cdpr::CDPR_TARGET {

constexpr double MODULUS_1 = 4294967087.0, MODULUS_2 = 4294944443.0;

// The nearest whole number; x below 2^51 in size.
template <class T> CDPR_INLINE T rounded(T x) {
    constexpr double SHIFT = 6755399441055744.0;  // 1.5 * 2^52: doubles of this size have no fraction
    return (x + SHIFT) - SHIFT;
}

// Number of steps from which on doubles resolve no single ones.
constexpr double MANY = 1e15;

// Return the nearest multiple of a step; the value itself where it has too many steps.
template <class T> CDPR_INLINE T nearest_multiple(T value, T step) {
    const T steps = value / step;
    return select((steps < T(MANY)) & (steps > T(-MANY)), rounded(steps) * step, value);
}

// x modulo a whole number m; x a whole number below 2^53 in size.
template <class T> CDPR_INLINE T modulo(T x, double m) {
    const T rest = x - rounded(x * T(1.0 / m)) * T(m);
    return select(rest < T(0.0), rest + T(m), rest);
}

// Return whether three numbers are whole, from 0 to m - 1, and not all 0.
template <class T> CDPR_INLINE Truth<T> valid_component(const T* s, double m) {
    Truth<T> valid = s[0] + s[1] + s[2] > T(0.0);
    for (int i = 0; i < 3; i++) valid = valid & (s[i] >= T(0.0)) & (s[i] < T(m)) & (rounded(s[i]) == s[i]);
    return valid;
}

template <class T> CDPR_INLINE Truth<T> valid_stream(const T* state) {
    return valid_component(state, MODULUS_1) & valid_component(state + 3, MODULUS_2);
}

// State of a stream while numbers are drawn: an array would not be kept in registers.
template <class T> struct RandomState {
    T a0, a1, a2, b0, b1, b2;
};

template <class T> CDPR_INLINE RandomState<T> random_state(const T* s) { return {s[0], s[1], s[2], s[3], s[4], s[5]}; }

template <class T> CDPR_INLINE void store(const RandomState<T>& s, T* state) {
    state[0] = s.a0, state[1] = s.a1, state[2] = s.a2, state[3] = s.b0, state[4] = s.b1, state[5] = s.b2;
}

template <class T>
CDPR_INLINE RandomState<T> select(Truth<T> condition, const RandomState<T>& a, const RandomState<T>& b) {
    return {select(condition, a.a0, b.a0), select(condition, a.a1, b.a1), select(condition, a.a2, b.a2),
            select(condition, a.b0, b.b0), select(condition, a.b1, b.b1), select(condition, a.b2, b.b2)};
}

// Advance a stream; return the next uniform number in (0, 1), a multiple of 1 / (MODULUS_1 + 1).
template <class T> CDPR_INLINE T next_uniform(RandomState<T>& s) {
    const T first = modulo(T(1403580.0) * s.a1 - T(810728.0) * s.a0, MODULUS_1);
    const T second = modulo(T(527612.0) * s.b2 - T(1370589.0) * s.b0, MODULUS_2);
    s = {s.a1, s.a2, first, s.b1, s.b2, second};
    const T whole = first - second;
    return select(whole > T(0.0), whole, whole + T(MODULUS_1)) * T(2.328306549295728e-10);
}

template <class T> CDPR_INLINE void scale_up(T& x, T& halvings, double below, double factor, double exponent) {
    const Truth<T> small = x < T(below);
    x = select(small, x * T(factor), x);
    halvings = select(small, halvings + T(exponent), halvings);
}

// Natural logarithm of x from 2^-32 to 1: that of x 2^k in [sqrt(1/2), sqrt(2)) by the series of the inverse hyperbolic
// tangent, minus k log(2).
template <class T> CDPR_INLINE T natural_logarithm(T x) {
    T halvings = 0.0;
    scale_up(x, halvings, 0x1p-16, 0x1p16, 16.0);
    scale_up(x, halvings, 0x1p-8, 0x1p8, 8.0);
    scale_up(x, halvings, 0x1p-4, 0x1p4, 4.0);
    scale_up(x, halvings, 0x1p-2, 0x1p2, 2.0);
    scale_up(x, halvings, 0x1p-1, 0x1p1, 1.0);
    scale_up(x, halvings, 0.70710678118654752, 0x1p1, 1.0);
    const T s = (x - T(1.0)) / (x + T(1.0)), z = s * s;  // z < 0.0295
    T series = 1.0 / 21.0;
    for (int odd = 19; odd > 0; odd -= 2) series = series * z + T(1.0 / odd);
    return T(2.0) * s * series - halvings * T(0.69314718055994531);
}

template <class T> CDPR_INLINE T polynomial(const double (&coefficients)[8], T x) {
    T value = coefficients[0];
    for (int i = 1; i < 8; i++) value = value * x + T(coefficients[i]);
    return value;
}

// The number that a standard normal variable does not exceed with a probability from 2^-32 to 1 - 2^-32: Wichura
// (1988), algorithm AS 241 (PPND16), Applied Statistics 37(3).
template <class T> CDPR_INLINE T normal_quantile(T probability) {
    constexpr double CENTRE_ABOVE[] = {2509.0809287301226727, 33430.575583588128105, 67265.770927008700853,
                                       45921.953931549871457, 13731.693765509461125, 1971.5909503065514427,
                                       133.14166789178437745, 3.3871328727963666080};
    constexpr double CENTRE_BELOW[] = {
        5226.4952788528545610, 28729.085735721942674, 39307.895800092710610, 21213.794301586595867,
        5394.1960214247511077, 687.18700749205790830, 42.313330701600911252, 1.0};
    constexpr double TAIL_ABOVE[] = {7.74545014278341407640e-4, 2.27238449892691845833e-2, 2.41780725177450611770e-1,
                                     1.27045825245236838258,    3.64784832476320460504,    5.76949722146069140550,
                                     4.63033784615654529590,    1.42343711074968357734};
    constexpr double TAIL_BELOW[] = {
        1.05075007164441684324e-9, 5.47593808499534494600e-4, 1.51986665636164571966e-2, 1.48103976427480074590e-1,
        6.89767334985100004550e-1, 1.67638483018380384940,    2.05319162663775882187,    1.0};
    const T from_half = probability - T(0.5);
    const T r = T(0.180625) - from_half * from_half;
    const T centre = polynomial(CENTRE_ABOVE, r) * from_half / polynomial(CENTRE_BELOW, r);
    const Truth<T> tail = absolute(from_half) > T(0.425);
    if (!any(tail)) return centre;
    // sqrt(-log p) is below 4.8 in these tails, so the third approximation of AS 241, from 5, is not needed.
    const Truth<T> lower = from_half < T(0.0);
    const T t = square_root(-natural_logarithm(select(lower, probability, T(1.0) - probability))) - T(1.6);
    const T size = polynomial(TAIL_ABOVE, t) / polynomial(TAIL_BELOW, t);
    return select(tail, select(lower, -size, size), centre);
}

// Replace eight probabilities by such numbers.
template <class T> CDPR_INLINE void normal_quantiles(T (&numbers)[8]) {
    for (int i = 0; i < 8; i++) numbers[i] = normal_quantile(numbers[i]);
}
#ifdef CDPR_LANES
template <> CDPR_INLINE void normal_quantiles<double>(double (&numbers)[8]) {
    scatter(normal_quantile(gather(numbers, 1)), numbers);
}
#endif

template <class T> struct RandomNumbers {
    T* state;    // (6), of the stream: whole numbers, three below MODULUS_1 and three below MODULUS_2
    T* numbers;  // (n), the next ones of the stream
    int64_t n;
    static constexpr char fields[] = "both state(6), numbers(n), n";
};

// Advance a stream by n numbers. With an invalid state return BAD_INPUT, for lanes their bits; the state does not
// change and the numbers are NaN.
template <class T, class Next> CDPR_INLINE int draw(RandomNumbers<T>& stream, Next next) {
    const Truth<T> valid = valid_stream(stream.state);
    const T one = 1.0;
    const RandomState<T> before = random_state(stream.state), ones = {one, one, one, one, one, one};
    RandomState<T> state = select(valid, before, ones);
    for (int64_t k = 0; k < stream.n; k++) stream.numbers[k] = select(valid, next(state), T(NOT_A_NUMBER));
    store(select(valid, state, before), stream.state);
    return code(select(valid, T(double(OK)), T(double(BAD_INPUT))));
}

// Uniform numbers in (0, 1).
template <class T> inline int uniform_numbers(RandomNumbers<T>& stream) {
    return draw(stream, [](RandomState<T>& state) { return next_uniform(state); });
}

// Numbers of the standard normal distribution, from -6.3 to 6.3.
template <class T> inline int normal_numbers(RandomNumbers<T>& stream) {
    return draw(stream, [](RandomState<T>& state) { return normal_quantile(next_uniform(state)); });
}

}  // namespace cdpr::CDPR_TARGET
