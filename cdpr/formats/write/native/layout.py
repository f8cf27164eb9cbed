"""Layout of an exported pipeline in the memory of a real-time controller."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from cdpr.native.exported_pipeline import ExportedPipeline, Member, Operation

# As in cdpr/realtime.hpp.
MAGIC, VERSION, HEAD, CALL_WORDS = b"cdprnum\0", 1, 4, 5


@dataclass(eq=False)
class Layout:
    """Positions of a pipeline's arrays and struct members.

    Attributes:
        numbers: float64 values in the file: arrays, then members of structs.
        work: number of float64 of scratch space, which follows them.
        integers: int64 arrays at the start.
        calls: operations, each with the index of its first member.
        members: (kind, value) of each member; the kinds are those of `MemberKind` in cdpr/realtime.hpp.
        places: index of each array in the numbers, by name.
    """

    numbers: list[float] = field(default_factory=list)
    work: int = 0
    integers: list[int] = field(default_factory=list)
    calls: list[tuple[Operation, int]] = field(default_factory=list)
    members: list[tuple[str, int]] = field(default_factory=list)
    places: dict[str, int] = field(default_factory=dict)

    @classmethod
    def of(cls, pipeline: ExportedPipeline) -> Layout:
        """Return the layout of a pipeline."""
        layout = cls()
        array_places = layout._arrays(pipeline)
        values = [word for call in pipeline.operations for word in call.members if _is_number(word)]
        after = len(layout.numbers)
        layout.numbers += [struct.unpack("<d", struct.pack("<Q", word.value))[0] for word in values]
        scratch = len(layout.numbers)  # follows the numbers of the file
        indices = iter(range(after, scratch))
        for operation in pipeline.operations:
            layout.calls.append((operation, len(layout.members)))
            for member in operation.members:
                layout.members.append(_placed(member, array_places, scratch, indices))
        return layout

    def _arrays(self, pipeline: ExportedPipeline) -> list[tuple[str, int]]:
        """Append the arrays; return the kind and position of each."""
        found = []
        for array in pipeline.arrays:
            content = np.ravel(array.content)
            if content.dtype == np.int64:
                found.append(("INTEGERS_AT", len(self.integers)))
                self.integers += content.tolist()
            elif array.kind == "work":
                found.append(("WORK_AT", self.work))
                self.work += content.size
            else:
                found.append(("NUMBERS_AT", len(self.numbers)))
                self.places[array.name] = len(self.numbers)
                self.numbers += content.tolist()
        return found

    @property
    def file_bytes(self) -> int:
        """Size of the file of numbers."""
        return 8 * (HEAD + len(self.numbers) + 1)

    @property
    def memory_words(self) -> int:
        """Size of the controller's memory in 8-byte words."""
        return CALL_WORDS * len(self.calls) + len(self.members) + len(self.integers) + len(self.numbers) + self.work

    def file(self, signature: int) -> bytes:
        """Return the file of numbers."""
        count = len(self.numbers)
        content = struct.pack(f"<8sQQQ{count}d", MAGIC, VERSION, signature, count, *self.numbers)
        return content + struct.pack("<Q", zlib.crc32(content))


def _is_number(member: Member) -> bool:
    return member.array is None and member.is_number


def _placed(member: Member, arrays: list[tuple[str, int]], scratch: int, indices: Iterator[int]) -> tuple[str, int]:
    if member.array is None:
        return ("NUMBER", next(indices)) if member.is_number else ("WORD", member.value)
    kind, place = arrays[member.array]
    if kind == "WORK_AT":
        return "NUMBERS_AT", scratch + place + member.value
    return kind, place + member.value
