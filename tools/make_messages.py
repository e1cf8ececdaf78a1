"""Write the two halves of the protocol that firmware/messages.toml describes.

``python tools/make_messages.py`` writes the C header and the Python module;
a test compares both with what this program would write.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "firmware" / "messages.toml"
HEADER = ROOT / "firmware" / "link" / "messages.h"
MODULE = ROOT / "python" / "agrik_fast" / "drivers" / "_messages.py"

NOTE = "Made by tools/make_messages.py of firmware/messages.toml: change that, not this."
ENUMS = {
    "boards": ("Board", "The kind of a board."),
    "states": ("State", "What a board is doing."),
    "faults": ("Fault", "Why a board stopped."),
    "codes": ("Code", "A board's answer to a command."),
    "resets": ("Reset", "What started a board."),
    "flags": ("Flags", "Bits of `Servos.flags`."),
}
C_TYPES = {
    "u8": "uint8_t",
    "u16": "uint16_t",
    "u32": "uint32_t",
    "i16": "int16_t",
    "i32": "int32_t",
}
STRUCT = {"u8": "B", "u16": "H", "u32": "I", "i16": "h", "i32": "i"}


def _split(kind: str) -> tuple[str, int, bool]:
    """Return base type, count and whether it is a text of a field's kind."""
    if text := re.fullmatch(r"s(\d+)", kind):
        return "u8", int(text[1]), True
    base, _, count = kind.partition("*")
    return base, int(count or 1), False


def c_header(data: dict[str, Any]) -> str:
    """Return the text of messages.h."""
    lines = [f"/* {NOTE} */", "#ifndef AGRIK_MESSAGES_H", "#define AGRIK_MESSAGES_H", ""]
    lines += ["#include <stdint.h>", ""]
    lines += [f"#define LINK_{name.upper()} {value}UL" for name, value in data["link"].items()]
    for table in ENUMS:
        prefix = table.removesuffix("s").upper()
        members = ", ".join(f"{prefix}_{k.upper()} = {v}" for k, v in data[table].items())
        lines += ["", f"enum {{ {members} }};"]
    lines += ["", "enum {"]
    lines += [f"    MSG_{name.upper()} = 0x{m['type']:02x}," for name, m in data["message"].items()]
    lines += ["};"]
    for name, message in data["message"].items():
        fields = message.get("fields")
        if not fields:
            continue
        lines += ["", "struct __attribute__((packed)) msg_" + name + " {"]
        for field, kind in fields:
            base, count, text = _split(kind)
            c_type = "char" if text else C_TYPES[base]
            lines.append(f"    {c_type} {field}{f'[{count}]' if count > 1 else ''};")
        lines.append("};")
    lines += ["", "#endif"]
    return "\n".join(lines) + "\n"


def _python_field(kind: str) -> tuple[str, str]:
    base, count, text = _split(kind)
    if text:
        return "bytes", f"{count}s"
    if count > 1:
        return f"tuple[{', '.join(['int'] * count)}]", f"{count}{STRUCT[base]}"
    return "int", STRUCT[base]


def _class(name: str) -> str:
    return "".join(part.capitalize() for part in name.split("_"))


def python_module(data: dict[str, Any]) -> str:
    """Return the text of _messages.py."""
    lines = [f'"""{NOTE}"""', "", "from __future__ import annotations", ""]
    lines += ["import struct", "from dataclasses import dataclass", "from enum import IntEnum"]
    lines += ["from typing import ClassVar", ""]
    lines += [f"{name.upper()} = {value}" for name, value in data["link"].items()]
    for table, (title, text) in ENUMS.items():
        lines += ["", "", f"class {title}(IntEnum):", f'    """{text}"""', ""]
        lines += [f"    {name.upper()} = {value}" for name, value in data[table].items()]
    lines += ["", "", "class Type(IntEnum):", '    """What a frame says."""', ""]
    lines += [f"    {name.upper()} = 0x{m['type']:02X}" for name, m in data["message"].items()]
    replies = {}
    for name, message in data["message"].items():
        if message["type"] < 0x80:
            replies[name] = message.get("reply", "ack")
        fields = message.get("fields")
        if not fields:
            continue
        parts = [(field, *_python_field(kind)) for field, kind in fields]
        form = "<" + "".join(code for _, _, code in parts)
        lines += ["", "", "@dataclass(frozen=True, slots=True)", f"class {_class(name)}:"]
        lines += [f'    """Payload of `Type.{name.upper()}`."""', ""]
        lines += [f"    {field}: {kind}" for field, kind, _ in parts]
        lines += ["", f'    FORM: ClassVar[struct.Struct] = struct.Struct("{form}")']
        lines += ["", "    def pack(self) -> bytes:", '        """Return the payload."""']
        values = ", ".join(
            f"*self.{field}" if kind.startswith("tuple") else f"self.{field}"
            for field, kind, _ in parts
        )
        lines += _call("        return self.FORM.pack(", values.split(", "))
        lines += ["", "    @classmethod", f"    def unpack(cls, payload: bytes) -> {_class(name)}:"]
        lines += ['        """Read a payload; `struct.error` for one of another length."""']
        lines += ["        values = cls.FORM.unpack(payload)"]
        at, given = 0, []
        for _, kind, _ in parts:
            count = kind.count("int") if kind.startswith("tuple") else 1
            given.append(f"values[{at}:{at + count}]" if count > 1 else f"values[{at}]")
            at += count
        lines += _call("        return cls(", given)
    lines += ["", "", "REPLIES = {"]
    lines += [f"    Type.{name.upper()}: Type.{reply.upper()}," for name, reply in replies.items()]
    lines += ["}", '"""The type of the answer to each request."""']
    return "\n".join(lines) + "\n"


def _call(head: str, values: list[str]) -> list[str]:
    """Return a call as the formatter writes it."""
    line = f"{head}{', '.join(values)})"
    if len(line) <= 100:
        return [line]
    indent = " " * (len(head) - len(head.lstrip()))
    inner = f"{indent}    {', '.join(values)}"
    if len(inner) <= 100:
        return [head, inner, f"{indent})"]
    return [head, *(f"{indent}    {value}," for value in values), f"{indent})"]


def texts() -> dict[Path, str]:
    """Return the files and what should stand in them."""
    data = tomllib.loads(SOURCE.read_text(encoding="utf-8"))
    return {HEADER: c_header(data), MODULE: python_module(data)}


def main() -> None:
    """Write both files."""
    for path, text in texts().items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
