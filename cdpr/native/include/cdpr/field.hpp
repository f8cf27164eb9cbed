// Declaration of an operation's arguments, which Python reads. SPDX-License-Identifier: Apache-2.0
//
//   template <class T> struct CrossProducts {
//       const T* left;   // (n, 3)
//       const T* right;  // (n, 3)
//       T* product;      // (n, 3)
//       int64_t n;
//       static constexpr char fields[] = "left(n, 3), right(n, 3), product(n, 3), n";
//   };
//
// The fields name the members in order, arrays with their dimensions: sizes, integers or sums of products of them, or a
// size with a lower limit, such as "w >= 6". An array with the member type `const T*` is read, others are written: a
// call reads nothing that it did not write. "both state(13)" is read and written; "work spare(m)" is scratch space with
// arbitrary content. An integer in a dimension is a size, which the binding computes; another number is an argument,
// which may have a lower limit, too: "every >= 1".
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

// Fields of a struct that begins with a struct with its own fields, followed by more fields.
template <int size, int... sizes> constexpr auto extended(const char (&first)[size], const char (&... more)[sizes]) {
    return join(first, ", ", more...);
}
template <int size, int... sizes> constexpr auto extended(const Text<size>& first, const char (&... more)[sizes]) {
    return join(first.text, ", ", more...);
}

}  // namespace cdpr::CDPR_TARGET
