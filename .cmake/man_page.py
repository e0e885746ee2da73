#!/usr/bin/env python3
"""Makes a manual page from what a program says with --help, and each of its commands.

    man_page.py PROGRAM NAME SECTION VERSION OUTPUT

The page is compressed as Debian wants it: the same bytes for the same help. Reads the layout that CLI11 writes: a description, "Usage:", blocks of two-column items below a heading with a colon,
and at the end whatever examples and notes the program adds. A help that does not begin so is an error.
"""

import gzip
import pathlib
import re
import subprocess
import sys

HEADING = re.compile(r"^(\S[^:]*):$")
ITEM = re.compile(r"^  (\S.*)$")
USAGE = re.compile(r"^Usage: \S+ ?(.*)$")


def help_of(program, words):
    done = subprocess.run([program, *words, "--help"], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{program} {' '.join(words)} --help ended with {done.returncode}: {done.stderr}")
    lines = done.stdout.splitlines()
    usage = [i for i, line in enumerate(lines) if USAGE.match(line)]
    if not usage or not lines[0]:
        sys.exit(f"{program} {' '.join(words)} --help is not understood: it has no description or no usage")
    about = " ".join(lines[: usage[0]]).strip()
    arguments = USAGE.match(lines[usage[0]]).group(1)
    if words:  # the names of the commands stand in the usage too
        arguments = arguments.removeprefix(" ".join(words)).strip()
    sections, notes = sections_of(lines[usage[0] + 1:])
    return about, arguments, sections, notes


def sections_of(lines):
    """The blocks of items, and the lines after two empty ones."""
    sections, notes, items = [], [], None
    for i, line in enumerate(lines):
        if not line and i + 1 < len(lines) and not lines[i + 1]:
            notes = lines[i + 2:]
            break
        heading = HEADING.match(line)
        if heading:
            items = []
            sections.append((heading.group(1), items))
        elif items is not None and line.startswith(" " * 30) and items:
            items[-1][1] = f"{items[-1][1]} {line.strip()}".strip()
        elif items is not None and ITEM.match(line):
            # A name that is too long for its column has its description in the next line.
            below = i + 1 < len(lines) and lines[i + 1].startswith(" " * 30)
            short = not below and line[29:30] in ("", " ")
            items.append([line[2:30].rstrip(), line[30:].strip()] if short else [line[2:], ""])
    return sections, notes


def plain(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def option(name):
    """`--domain INT:INT in [0 - 232] (Env:X)` with the name in bold."""
    first, _, rest = name.partition(" ")
    return f"\\fB{plain(first)}\\fR {plain(rest)}".rstrip()


def items_in(sections, skipped=()):
    out = []
    for heading, items in sections:
        if heading == "Subcommands":
            continue
        for name, what in items:
            if name not in skipped:
                out += [".TP", option(name), plain(what)]
    return out


def notes_in(notes):
    """Lines as they are: examples have their own columns."""
    while notes and not notes[0]:
        notes = notes[1:]
    return [".nf", *[plain(line) for line in notes], ".fi"] if notes else []


def commands_in(program, name, words, sections, common):
    out = []
    for heading, items in sections:
        for command, _ in items if heading == "Subcommands" else []:
            path = [*words, command]
            about, arguments, inner, notes = help_of(program, path)
            out += [f".SS {plain(' '.join([name, *path]))} {plain(arguments)}".rstrip(), plain(about)]
            out += items_in(inner, common)
            if notes:
                out += [".PP", *notes_in(notes)]
            out += commands_in(program, name, path, inner, common)
    return out


def main():
    program, name, section, version, output = sys.argv[1:]
    about, arguments, sections, notes = help_of(program, [])
    common = {item for _, items in sections for item, _ in items}
    first = about.split(". ")[0].rstrip(".")
    out = [f'.TH {name.upper()} {section} "" "motionlab\\-gateway {version}"', ".SH NAME",
           f"{plain(name)} \\- {plain(first[0].lower() + first[1:])}", ".SH SYNOPSIS",
           f"\\fB{plain(name)}\\fR {plain(arguments)}", ".SH DESCRIPTION", plain(about)]
    out += [".SH OPTIONS", *items_in(sections)]
    commands = commands_in(program, name, [], sections, common)
    if commands:
        out += [".SH COMMANDS", *commands]
    if notes:
        out += [".SH EXAMPLES AND NOTES", *notes_in(notes)]
    page = ("\n".join(out) + "\n").encode()
    pathlib.Path(output).write_bytes(gzip.compress(page, mtime=0))


if __name__ == "__main__":
    main()
