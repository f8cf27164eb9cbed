"""Compilers and tools of object code for tests of the kernel library; tests are skipped where one is missing."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest
from conftest import ROOT

NATIVE = ROOT / "cdpr" / "native"
TARGETS = {"x86_64": "x86-64", "x86_64_v3": "x86-64-v3", "x86_64_v4": "x86-64-v4"}


def tool(name):
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is not installed")
    return found


def flags():
    """Return the options that CMakeLists.txt compiles with."""
    (line,) = re.findall(r"^add_compile_options\((.*)\)$", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)
    return line.split()


def compile_object(source, target, out, *more):
    """Compile a file of C++ for an instruction set; return what the compiler did."""
    given = [f"-DCDPR_TARGET={target}", f'-DCDPR_TARGET_NAME="{TARGETS[target]}"', f"-march={TARGETS[target]}"]
    given += ["-DCDPR_ALONE"] if target == "x86_64" else []
    words = [
        tool("g++"),
        "-std=c++17",
        *flags(),
        "-fno-exceptions",
        "-fno-rtti",
        *given,
        f"-I{NATIVE / 'include'}",
        f"-I{ROOT}",
        *more,
        "-fPIC",
    ]
    return subprocess.run([*words, "-c", source, "-o", out], capture_output=True, text=True, check=False)


def kernels(target, folder, *more):
    """The object file of all kernels for an instruction set."""
    parts, out = [], folder / f"{target}.o"
    for source in (NATIVE / "table.cpp", *(NATIVE / "tables").glob("*.cpp")):
        parts.append(folder / f"{target}_{source.stem}.o")
        done = compile_object(source, target, parts[-1], *more)
        assert done.returncode == 0, done.stderr
    subprocess.run([tool("ld"), "-r", *parts, "-o", out], check=True)
    return out


def build_library(root):
    """Compile the kernel library of a copy of the program, for one instruction set and without optimisation."""
    native, out = root / "cdpr" / "native", root / "objects"
    out.mkdir()
    given = ["-DCDPR_ONE_TARGET", "-DCDPR_TARGET=portable", '-DCDPR_TARGET_NAME="portable"']
    paths = [f"-I{native / 'include'}", f"-I{root}"]
    options = ["-O0", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off", "-fno-math-errno", *given, *paths]
    for header in root.glob("cdpr*/**/*.hpp"):  # as an install does, for FMUs
        there = native / "include" / header.relative_to(root)
        if native not in header.parents and not there.exists():
            there.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(header, there)
    objects = []
    for source in (*native.glob("*.c"), *native.glob("*.cpp"), *(native / "tables").glob("*.cpp")):
        objects.append(out / f"{source.stem}.o")
        language = ["gcc"] if source.suffix == ".c" else ["g++", "-std=c++17", "-fno-exceptions", "-fno-rtti"]
        run(tool(language[0]), *language[1:], *options, "-c", source, "-o", objects[-1])
    run(tool("gcc"), "-shared", *objects, "-o", native / "library.abi3.so", "-lm")


def run(*words):
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout
