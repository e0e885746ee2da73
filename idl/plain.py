#!/usr/bin/env python3
"""Makes the plain C++ structs of the house from the .idl files, so that the vocabulary is written once.

    plain.py OUTPUT_FOLDER FILE.idl …

For `Mru.idl` it writes `mru.hpp` with `motionlab::topic::Mru`: the same fields in the same order with the same
comments, trivially copyable, all zero at birth, and with two visitors: `fields` (name and value) and `zip` (value and
the accessor of a generated twin). It understands exactly the dialect of this folder: one module, enums, one @final
struct, scalars, bounded strings and one-dimensional arrays. Anything else is an error with file and line.
"""

import pathlib
import re
import sys

SCALARS = {
    "boolean": "bool", "octet": "std::uint8_t", "double": "double", "float": "float",
    "short": "std::int16_t", "unsigned short": "std::uint16_t", "long": "std::int32_t",
    "unsigned long": "std::uint32_t", "long long": "std::int64_t", "unsigned long long": "std::uint64_t",
}
FIELD = re.compile(r"^\s*(?P<key>@key\s+)?(?P<type>string<(?P<chars>\d+)>|[A-Za-z][A-Za-z ]*?)\s+(?P<name>\w+)"
                   r"(\[(?P<count>\d+)\])?;\s*(//\s*(?P<doc>.*))?$")


def snake(name):
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


def fail(path, number, line, why):
    sys.exit(f"{path}:{number}: {why}: {line.strip()}")


def parse_enum(text):
    name, body = re.match(r"enum\s+(\w+)\s*\{([^}]*)\}", text, re.S).groups()
    values = [value.strip() for value in body.split(",")]
    prefix = values[0][: values[0].index("_") + 1]
    while not all(value.startswith(prefix) for value in values):
        prefix = prefix[: prefix.rstrip("_").rfind("_") + 1]
    while True:  # the longest common prefix that ends in an underscore
        rest = values[0][len(prefix):]
        longer = prefix + rest[: rest.find("_") + 1]
        if "_" not in rest or not all(value.startswith(longer) for value in values):
            break
        prefix = longer
    return name, [value[len(prefix):].lower() for value in values]


def parse(path):
    lines = path.read_text().splitlines()
    text = "\n".join(lines)
    head = []
    for line in lines:
        if not line.startswith("//"):
            break
        head.append(line[2:].strip())
    includes = re.findall(r'^#include "(\w+)\.idl"', text, re.M)
    enums = [parse_enum(found) for found in re.findall(r"enum\s+\w+\s*\{[^}]*\}", text, re.S)]
    fields, struct = [], None
    for number, line in enumerate(lines, 1):
        opening = re.match(r"\s*struct\s+(\w+)\s*\{", line)
        if opening:
            if "@final" not in lines[number - 2]:
                fail(path, number, line, "every struct is written @final (other DDS implementations need it)")
            struct = opening.group(1)
        elif struct and line.strip() == "};":
            break
        elif struct:
            field = FIELD.match(line)
            if field:
                fields.append(field.groupdict())
            elif line.strip().startswith("//") and fields:
                fields[-1]["doc"] = f"{fields[-1]['doc'] or ''} {line.strip()[2:].strip()}".strip()
            elif line.strip():
                fail(path, number, line, "not understood by plain.py")
    if struct != path.stem:
        sys.exit(f"{path}: the struct is called {struct}, the file {path.stem}; they must agree")
    return struct, head, includes, enums, fields


def cpp_type(field):
    base = f"Text<{field['chars']}>" if field["chars"] else SCALARS.get(field["type"], field["type"])
    return f"std::array<{base}, {field['count']}>" if field["count"] else base


def emit(path):
    struct, head, includes, enums, fields = parse(path)
    out = [f"/// @file  Made by plain.py from {path.name}; edit that.", "#pragma once", "",
           "#include <array>", "#include <cstdint>", "#include <string_view>", "",
           '#include "drivers/core/text.hpp"']
    out += [f'#include "idl/{snake(name)}.hpp"' for name in includes]
    out += ["", "namespace motionlab::topic {", ""]
    for name, values in enums:
        out += [f"enum class {name} : std::uint32_t {{ {', '.join(values)} }};", "",
                f"[[nodiscard]] constexpr std::string_view to_string({name} value) noexcept {{",
                f"  constexpr std::string_view names[] = {{{', '.join(chr(34) + v + chr(34) for v in values)}}};",
                f"  const auto index = static_cast<std::size_t>(value);",
                f"  return index < {len(values)} ? names[index] : std::string_view{{\"?\"}};", "}", ""]
    out += [f"/// {line}" for line in head]
    out += [f"struct {struct} {{", f'  static constexpr std::string_view kTypeName = "motionlab::{struct}";', ""]
    for field in fields:
        doc = f"  ///< {field['doc']}" if field["doc"] else ""
        out.append(f"  {cpp_type(field)} {field['name']}{{}};{doc}")
    out += ["", "  /// Calls f(name, value) for every field in order.", "  template <class Self, class F>",
            "  static constexpr void fields(Self& self, F&& f) {"]
    out += [f'    f(std::string_view{{"{field["name"]}"}}, self.{field["name"]});' for field in fields]
    out += ["  }", "", "  /// Calls f(our value, the twin's value) for every field in order.",
            "  template <class Self, class Twin, class F>", "  static void zip(Self& self, Twin& twin, F&& f) {"]
    out += [f"    f(self.{field['name']}, twin.{field['name']}());" for field in fields]
    keys = [field["name"] for field in fields if field["key"]]
    out += ["  }", "", f"  static constexpr bool kKeyed = {'true' if keys else 'false'};"]
    if keys:
        out += ["  /// The instance that this sample belongs to.",
                "  [[nodiscard]] std::array<std::string_view, %d> key() const {" % len(keys),
                f"    return {{{', '.join(name + '.view()' for name in keys)}}};", "  }"]
    out += ["};", "", "}  // namespace motionlab::topic", ""]
    return snake(struct), struct, "\n".join(out)


def inlined(path, done):
    """The text of an .idl file with what it includes in place of the includes, each once."""
    if path in done:
        return ""
    done.add(path)
    out = []
    for line in path.read_text().splitlines():
        include = re.match(r'#include "(\w+\.idl)"', line)
        out.append(inlined(path.parent / include.group(1), done) if include else line)
    return "\n".join(out).rstrip() + "\n"


def emit_texts(paths):
    out = ["/// @file  Made by plain.py: the .idl text of every topic, includes inlined, for tools that read schemas.",
           "#pragma once", "", "#include <string_view>", "", '#include "idl/topics.hpp"', "",
           "namespace motionlab::topic {", "", "template <class T>", "inline constexpr std::string_view kIdlText{};", ""]
    for path in paths:
        out += ["template <>", f'inline constexpr std::string_view kIdlText<{path.stem}>{{R"idl({inlined(path, set())})idl"}};', ""]
    return "\n".join(out + ["}  // namespace motionlab::topic", ""])


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    made = [emit(pathlib.Path(name)) for name in sys.argv[2:]]
    every = ["/// @file  Made by plain.py: every topic's struct.", "#pragma once", ""]
    every += [f'#include "idl/{name}.hpp"' for name, _, _ in made]
    every += ["", "/// Calls X(Type) for every topic's struct.", "#define MOTIONLAB_FOR_EACH_TOPIC_TYPE(X) \\",
              " \\\n".join(f"  X({struct})" for _, struct, _ in made), ""]
    for name, text in [(name, text) for name, _, text in made] + [
            ("topics", "\n".join(every)), ("texts", emit_texts([pathlib.Path(name) for name in sys.argv[2:]]))]:
        target = folder / f"{name}.hpp"
        if not target.exists() or target.read_text() != text:
            target.write_text(text)
        else:
            target.touch()


if __name__ == "__main__":
    main()
