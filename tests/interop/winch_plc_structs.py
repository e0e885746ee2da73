#!/usr/bin/env python3
"""The PLC's structs (deploy/plc, Structured Text) are the codec's (drivers/winch), member by member.

    winch_plc_structs.py SOURCE_DIR

Names, types, order, offsets under packing 1 and 8, sizes, layout version. Exits 1 with the first difference.
"""
import pathlib
import re
import sys

SIZES = {"BOOL": 1, "BYTE": 1, "USINT": 1, "UINT": 2, "UDINT": 4, "ULINT": 8, "LREAL": 8}


def without_comments(text):
    return re.sub(r"//[^\n]*", "", text)


def members_of_st(text, name):
    """[(name, type)] of a STRUCT in Structured Text, which must ask for packing 1."""
    text = without_comments(text)
    found = re.search(r"\{attribute 'pack_mode' := '1'\}\s*TYPE\s+(\w+)\s*:\s*STRUCT(.*?)END_STRUCT\s*END_TYPE",
                      text, re.S)
    assert found, f"{name}: no packed struct"
    assert found[1] == name, f"{found[1]} instead of {name}"
    members = []
    for declaration in filter(None, (part.strip() for part in found[2].split(";"))):
        member, kind = re.fullmatch(r"(\w+)\s*:\s*(.*?)(?:\s*:=.*)?", declaration, re.S).groups()
        members.append((member, re.sub(r"\s+", " ", kind)))
    return members


def size_of(kind):
    array = re.fullmatch(r"ARRAY \[(\d+)\.\.(\d+)\] OF (\w+)", kind)
    if array:
        first, last, element = array.groups()
        return (int(last) - int(first) + 1) * SIZES[element], SIZES[element]
    return SIZES[kind], SIZES[kind]


def laid_out(members, packing):
    """([(name, type, offset, size)], size of the whole)"""
    at, widest, places = 0, 1, []
    for name, kind in members:
        size, element = size_of(kind)
        align = min(element, packing)
        at = (at + align - 1) // align * align
        places.append((name, kind, at, size))
        at, widest = at + size, max(widest, align)
    return places, (at + widest - 1) // widest * widest


def members_of_codec(text, table):
    """[(name, type, offset, size)] of a table of winch_wire_structs.cpp."""
    body = re.search(rf"constexpr std::array {table} = \{{(.*?)\n\}};", text, re.S)[1]
    short = {"udint": "UDINT", "lreal": "LREAL", "uint": "UINT", "boolean": "BOOL"}
    members = []
    for call in re.finditer(r'(\w+)\("(\w+)", (\d+)\)|Member\{"(\w+)", "([^"]+)", DataType::\w+, (\d+), (\d+)\}', body):
        if call[1]:
            kind = short[call[1]]
            members.append((call[2], kind, int(call[3]), SIZES[kind]))
        else:
            members.append((call[4], call[5], int(call[6]), int(call[7])))
    return members


def number(text, pattern):
    return int(re.search(pattern, text)[1])


def main():
    root = pathlib.Path(sys.argv[1])
    codec = (root / "drivers/winch/winch_wire_structs.cpp").read_text()
    header = (root / "drivers/winch/winch_wire_structs.hpp").read_text()
    for name, table, constant in (("ST_WinchCommand", "kCommandMembers", "kCommandSize"),
                                  ("ST_WinchStatus", "kStatusMembers", "kStatusSize")):
        declared = members_of_st((root / f"deploy/plc/{name}.st").read_text(), name)
        ours = members_of_codec(codec, table)
        for packing in (1, 8):
            places, size = laid_out(declared, packing)
            for theirs, mine in zip(places, ours):
                assert theirs == mine, f"{name}, packing {packing}: the PLC has {theirs}, the codec {mine}"
            assert len(places) == len(ours), f"{name}: {len(places)} members in the PLC, {len(ours)} in the codec"
            assert size == number(header, rf"{constant} = (\d+)"), f"{name}: {size} bytes"
    gvl = without_comments((root / "deploy/plc/GVL_Winch.st").read_text())
    assert number(gvl, r"LAYOUT_VERSION\s*:\s*UDINT := (\d+)") == number(header, r"kLayoutVersion = (\d+)")
    assert re.search(r"stCommand\s*:\s*ST_WinchCommand;\s*stStatus\s*:\s*ST_WinchStatus;", gvl), "GVL_Winch"
    states = re.search(r"enum class PlcState[^{]*\{(.*?)\}", header, re.S)[1]
    block = without_comments((root / "deploy/plc/FB_WinchGateway.st").read_text())
    for value, state in enumerate(part.strip() for part in states.split(",") if part.strip()):
        assert re.search(rf"S_{state.upper()}\s*:\s*UINT := {value};", block), f"eState {state} is not {value}"
    written = set(re.findall(r"GVL_Winch\.stStatus\.(\w+) :=", block))
    told = {name for name, *_ in members_of_codec(codec, "kStatusMembers")} - {"nReserved"}
    assert written == told, f"the function block does not write {told ^ written}"
    print("the PLC's structs are the codec's")


if __name__ == "__main__":
    main()
