// Declaration of an operation's arguments, which Python reads. SPDX-License-Identifier: Apache-2.0
//
//     template <class T> struct CrossProducts {
//         const T* left;   // (n, 3)
//         const T* right;  // (n, 3)
//         T* product;      // (n, 3)
//         int64_t n;
//         static constexpr char fields[] = "left(n, 3), right(n, 3), product(n, 3), n";
//     };
//
// The fields name the members in their order, arrays with their dimensions: sizes, integers or sums of products of
// them, or a size with its least value, such as "w >= 6". An array whose member is `const T*` is read, another one is
// written: nothing is read that the same call did not write. "both state(13)" is read and written; "work spare(m)" is
// scratch space with arbitrary content. An integer that is part of a dimension is a size, which the binding computes;
// another number is an argument, which may have a least value, too: "every >= 1".
#pragma once

#include <stdint.h>

#include <cdpr/table.h>
#include <cdpr/target.hpp>

namespace cdpr::CDPR_TARGET {

struct Lanes;  // lanes.hpp

// Name of a member's type; nullptr of another type.
template <class T> inline constexpr const char* type_name = nullptr;
template <> inline constexpr const char* type_name<double> = "double";
template <> inline constexpr const char* type_name<int64_t> = "int64";
template <> inline constexpr const char* type_name<double*> = "double*";
template <> inline constexpr const char* type_name<int64_t*> = "int64*";
template <> inline constexpr const char* type_name<Lanes*> = "lanes*";
template <> inline constexpr const char* type_name<const double*> = "const double*";
template <> inline constexpr const char* type_name<const int64_t*> = "const int64*";
template <> inline constexpr const char* type_name<const Lanes*> = "const lanes*";

template <int size> struct Text {
    char text[size] = {};

    constexpr operator const char*() const { return text; }
};

template <int... sizes> constexpr Text<(sizes + ... + 1) - int(sizeof...(sizes))> join(const char (&... parts)[sizes]) {
    Text<(sizes + ... + 1) - int(sizeof...(sizes))> all = {};
    int place = 0;
    const auto append = [&](const char* part) {
        while (*part) all.text[place++] = *part++;
    };
    (append(parts), ...);
    return all;
}

// Fields of a struct whose first member is a struct with fields of its own, which the others follow.
template <int size, int... sizes> constexpr auto extended(const char (&first)[size], const char (&... more)[sizes]) {
    return join(first, ", ", more...);
}

}  // namespace cdpr::CDPR_TARGET
