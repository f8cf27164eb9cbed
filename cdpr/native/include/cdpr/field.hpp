// Declaration of an operation's arguments, which Python reads. SPDX-License-Identifier: Apache-2.0
//
//     template <class T> struct CrossProducts {
//         const T* left;   // (n, 3)
//         const T* right;  // (n, 3)
//         T* product;      // (n, 3)
//         int64_t n;
//         static constexpr Field fields[] = {in<T>("left", "n", "3"), in<T>("right", "n", "3"),
//                                            out<T>("product", "n", "3"), size("n")};
//     };
//
// The fields are in the order of the members. entry.hpp rejects a struct whose members differ from its fields in number
// or type; it cannot see that two of one type are swapped: the test of the kernel's results finds that.
#pragma once

#include <stdint.h>

#include <cdpr/table.h>
#include <cdpr/target.hpp>

namespace cdpr::CDPR_TARGET {

using Field = cdpr_field;

struct Lanes;  // lanes.hpp

template <class T> inline constexpr const char* array_type = nullptr;
template <> inline constexpr const char* array_type<double> = "double*";
template <> inline constexpr const char* array_type<int64_t> = "int64*";
template <> inline constexpr const char* array_type<Lanes> = "lanes*";

// Array that is read: the member is `const T*`. Dimensions are sizes, integers or sums of products of them, or a size
// with its least value, such as "w >= 6".
template <class T = double, class... Dimensions> constexpr Field in(const char* name, Dimensions... shape) {
    return {name, array_type<T>, "in", {shape...}};
}

// Array that is written: `T*`. Nothing is read that the same call did not write.
template <class T = double, class... Dimensions> constexpr Field out(const char* name, Dimensions... shape) {
    return {name, array_type<T>, "out", {shape...}};
}

// Array that is read and written, such as a state: `T*`.
template <class T = double, class... Dimensions> constexpr Field both(const char* name, Dimensions... shape) {
    return {name, array_type<T>, "both", {shape...}};
}

// Scratch space: `T*`. Its content on entry is arbitrary.
template <class T = double, class... Dimensions> constexpr Field work(const char* name, Dimensions... shape) {
    return {name, array_type<T>, "work", {shape...}};
}

// Number of rows, cables, ...: `int64_t`. The binding computes it from the shapes of arrays.
constexpr Field size(const char* name) { return {name, "int64", "size", {}}; }

// A number: `double`, or `int64_t` by value<int64_t>("count").
template <class T = double> constexpr Field value(const char* name) {
    return {name, array_type<T>[0] == 'd' ? "double" : "int64", "value", {}};
}

template <int count> struct Fields {
    Field list[count];

    constexpr const Field& operator[](int index) const { return list[index]; }
    constexpr operator const Field*() const { return list; }
};

// Fields of a struct whose first member is a struct with fields of its own, which the others follow.
template <int count, class... More>
constexpr Fields<count + int(sizeof...(More))> extended(const Field (&first)[count], More... more) {
    Fields<count + int(sizeof...(More))> all = {};
    for (int i = 0; i < count; i++) all.list[i] = first[i];
    int place = count;
    ((all.list[place++] = more), ...);
    return all;
}

}  // namespace cdpr::CDPR_TARGET
