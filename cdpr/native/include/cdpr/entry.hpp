// Entry of an operation in the table, checked at compile time. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>

namespace cdpr::CDPR_TARGET {

constexpr bool same(const char* a, const char* b) { return *a == *b && (*a == 0 || same(a + 1, b + 1)); }

// Compile-time index of a member's type by its field.
constexpr int member_kind(const Field& field) {
    const bool read_only = same(field.role, "in");
    if (same(field.type, "double")) return 0;
    if (same(field.type, "int64")) return 1;
    if (same(field.type, "double*")) return read_only ? 2 : 3;
    if (same(field.type, "int64*")) return read_only ? 4 : 5;
    return read_only ? 6 : 7;
}

// clang-format off
template <int kind> struct Member;
template <> struct Member<0> { using type = double; };
template <> struct Member<1> { using type = int64_t; };
template <> struct Member<2> { using type = const double*; };
template <> struct Member<3> { using type = double*; };
template <> struct Member<4> { using type = const int64_t*; };
template <> struct Member<5> { using type = int64_t*; };
template <> struct Member<6> { using type = const Lanes*; };
template <> struct Member<7> { using type = Lanes*; };
// clang-format on

template <int... I> struct Indices {};
template <int count, int... I> struct Count : Count<count - 1, count - 1, I...> {};
template <int... I> struct Count<0, I...> {
    using type = Indices<I...>;
};

template <class A, class B> struct Same {};
template <class A> struct Same<A, A> {
    using yes = int;
};

// Stands for a value that converts to nothing but its own type.
template <class T> struct Only {
    template <class U, typename Same<T, U>::yes = 0> operator U() const;
};

// Fails to compile where a member's type differs from its field.
template <class Problem, int... I> constexpr bool members_match(Indices<I...>) {
    return sizeof(Problem{Only<typename Member<member_kind(Problem::fields[I])>::type>()...}) > 0;
}

template <class Problem> constexpr int field_count = sizeof(Problem::fields) / sizeof(Field);

template <class Problem, int (*kernel)(Problem&)> int call(void* place, double) {
    return kernel(*static_cast<Problem*>(place));
}

template <class Problem, int (*kernel)(Problem&, double)> int call(void* place, double time) {
    return kernel(*static_cast<Problem*>(place), time);
}

// entry<Cross<double>, cross<double>>("cross"); the kernel may take the time [s] as a second argument.
template <class Problem, auto kernel> constexpr cdpr_entry entry(const char* name) {
    constexpr int count = field_count<Problem>;
    static_assert(sizeof(Problem) == 8 * count, "one field per member, each of 8 bytes");
    static_assert(members_match<Problem>(typename Count<count>::type()));
    return {name, call<Problem, kernel>, sizeof(Problem), Problem::fields, count};
}

}  // namespace cdpr::CDPR_TARGET
