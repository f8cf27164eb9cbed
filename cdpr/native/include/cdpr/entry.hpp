// Entry of an operation in the table, checked at compile time. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cdpr/field.hpp>

namespace cdpr::CDPR_TARGET {

template <int... I> struct Indices {};
template <int count, int... I> struct Count : Count<count - 1, count - 1, I...> {};
template <int... I> struct Count<0, I...> {
    using type = Indices<I...>;
};

template <bool known> struct If;
template <> struct If<true> {
    using type = int;
};

// Placeholder for the value of a member, which records its type.
struct Member {
    const char** name;

    template <class T, typename If<type_name<T> != nullptr>::type = 0> constexpr operator T() const {
        *name = type_name<T>;
        return {};
    }
};

template <int count> struct Types {
    const char* names[count];
};

template <class Problem, int... I> constexpr Types<sizeof...(I)> types_of(Indices<I...>) {
    Types<sizeof...(I)> types = {};
    (void)Problem{Member{&types.names[I]}...};
    return types;
}

template <class Problem> constexpr int member_count = sizeof(Problem) / 8;
template <class Problem> inline constexpr auto member_types =
    types_of<Problem>(typename Count<member_count<Problem>>::type());

// Return whether there is a field for each type, with dimensions for arrays.
constexpr bool fields_match(const char* fields, const char* const* types, int count) {
    for (int i = 0; i < count; i++, fields += *fields == ',') {
        bool shape = false, address = false;
        int depth = 0;
        for (; *fields && (*fields != ',' || depth > 0); fields++) {
            depth += (*fields == '(') - (*fields == ')');
            shape = shape || *fields == '(';
        }
        for (const char* type = types[i]; *type; type++) address = address || *type == '*';
        if (shape != address || (*fields == 0) != (i == count - 1)) return false;
    }
    return true;
}

template <class Problem, int (*kernel)(Problem&)> int call(void* place, double) {
    return kernel(*static_cast<Problem*>(place));
}

template <class Problem> inline constexpr bool takes_lanes = false;
template <template <class> class Problem> inline constexpr bool takes_lanes<Problem<Lanes>> = true;

template <class Problem, int (*kernel)(Problem&, double)> int call(void* place, double time) {
    static_assert(!takes_lanes<Problem>, "each lane has its own time: read it from an array");
    return kernel(*static_cast<Problem*>(place), time);
}

// entry<Cross<double>, cross<double>>("cross"); the kernel may take the time [s] as a second argument.
template <class Problem, auto kernel> constexpr cdpr_entry entry(const char* name) {
    constexpr int count = member_count<Problem>;
    constexpr auto& types = member_types<Problem>.names;
    static_assert(sizeof(Problem) == 8 * count && fields_match(Problem::fields, types, count),
                  "one field per member, each of 8 bytes, and dimensions for arrays only");
    return {name, call<Problem, kernel>, count, Problem::fields, types};
}

}  // namespace cdpr::CDPR_TARGET
