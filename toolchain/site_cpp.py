# SPDX-License-Identifier: Apache-2.0
"""The public headers of slipstack::friction as a page of the site, from their docstrings by Doxygen. What is public and has
none is an error."""

import pathlib
import re
import shutil
import subprocess
import tempfile
import xml.etree.ElementTree as ET

# What slipstack/friction.h brings, in the order of the page. Each effect of the catalogue has a page of its own
# (docs/effects); what all of them offer is in effect.h.
HEADERS = ["friction/displacement.h", "friction/virgin_curves.h", "friction/maxwell_slip.h", "friction/packed_maxwell_slip.h",
           "friction/memory_stack.h", "effects/effect.h", "effects/catalogue.h", "effects/model.h", "effects/model_hash.h"]
SETTINGS = """
PROJECT_NAME = slipstack
INPUT = {headers}
OUTPUT_DIRECTORY = {out}
STRIP_FROM_PATH = {root}
GENERATE_HTML = NO
GENERATE_LATEX = NO
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
EXTRACT_STATIC = YES
HIDE_UNDOC_MEMBERS = NO
EXCLUDE_SYMBOLS = slipstack::detail slipstack::detail::* slipstack::portable*
JAVADOC_AUTOBRIEF = NO
QUIET = YES
WARN_IF_UNDOCUMENTED = YES
WARN_FORMAT = "$file:$line: $text"
WARN_LOGFILE = {out}/warnings
"""
INTRODUCTION = """# C++ reference of slipstack::friction

What `#include <slipstack/friction.h>` brings, from the docstrings of the headers; how it is built and linked stands in
[the friction core as a library](library.md). Everything is in namespace `slipstack`. The effects of the catalogue offer what
`Effect` asks for, each is described on [its page](effects/README.md).
"""


class Undocumented(Exception):
    """What Doxygen has to say about the headers."""


def escaped(text):
    return re.sub(r"([\\`*_<>\[\]#|])", r"\\\1", text)


def words(text):
    return escaped(re.sub(r"\s+", " ", text or ""))


def blocks_of(node):
    """A description as Markdown blocks: paragraphs, and formulas as code."""
    for para in node:
        if para.tag != "para":
            continue
        text = words(para.text)
        for child in para:
            inner = "".join(child.itertext())
            if child.tag in ("preformatted", "verbatim", "programlisting"):
                if text.strip():
                    yield text.strip()
                yield "```\n" + inner.strip("\n") + "\n```"
                text = ""
            else:
                text += f"`{inner}`" if child.tag == "computeroutput" else words(inner)
            text += words(child.tail)
        if text.strip():
            yield text.strip()


def described(node):
    return "\n\n".join(block for part in ("briefdescription", "detaileddescription") if node.find(part) is not None
                       for block in blocks_of(node.find(part)))


def template_of(node):
    parameters = node.find("templateparamlist")
    if parameters is None:
        return ""
    texts = []
    for one in parameters.findall("param"):
        text = "".join(one.find("type").itertext())
        name = one.findtext("declname")
        default = "".join(one.find("defval").itertext()) if one.find("defval") is not None else ""
        texts.append(text + (f" {name}" if name else "") + (f" = {default}" if default else ""))
    return f"template <{', '.join(texts)}>\n"


def source_of(node, root):
    """The definition in the header, from its template line on: of a concept, which Doxygen's XML has without it."""
    lines = (root / node.find("location").get("file")).read_text(encoding="utf-8").splitlines()
    begin = end = int(node.find("location").get("line")) - 1
    while lines[begin - 1].startswith("template"):
        begin -= 1
    while not lines[end].endswith(";") or lines[end].startswith(" "):
        end += 1
    return "\n".join(lines[begin:end + 1])


def declaration(member):
    kind, name = member.get("kind"), member.findtext("name")
    head = template_of(member)
    kind_of = "".join(member.find("type").itertext()) if member.find("type") is not None else ""
    if kind == "enum":
        values = [f"  {one.findtext('name')}," for one in member.findall("enumvalue")]
        return f"enum class {name} : {kind_of} {{\n" + "\n".join(values) + "\n};"
    if kind == "typedef":
        return f"{head}using {name} = {kind_of};"
    initial = member.findtext("initializer") or ""
    if initial.startswith("="):
        initial = " = " + initial[1:].strip()
    # Doxygen has the specifiers within the type, and static apart.
    static = "static " if member.get("static") == "yes" else ""
    return f"{head}{static}{kind_of} {name}".replace("slipstack::", "") + (member.findtext("argsstring") or "") + initial + ";"


def fields_text(members):
    """Variables and types of a class, one line each."""
    lines = []
    for one in members:
        text = " ".join(described(one).split())
        lines.append(f"- `{' '.join(declaration(one).split()).rstrip(';')}`: {text}\n")
    return "".join(lines)


def member_text(member, level):
    parts = [f"{'#' * level} {escaped(member.findtext('name'))}\n\n```cpp\n{declaration(member)}\n```\n\n{described(member)}\n"]
    values = [(one.findtext("name"), described(one)) for one in member.findall("enumvalue")]
    parts += [f"- `{name}`: {text}" for name, text in values if text]
    return "\n".join(parts) + "\n"


def members_of(node):
    sections = [one for one in node.findall("sectiondef") if not one.get("kind").startswith(("private", "friend"))]
    return [member for section in sections for member in section.findall("memberdef")]


def line_of(node):
    return int(node.find("location").get("line"))


def header_text(folder, index, header, root):
    """All that one header defines, in its order."""
    path = f"firmware/{header}"
    found = []
    for compound in index:
        tree = ET.parse(folder / f"{compound}.xml").getroot().find("compounddef")
        kind = tree.get("kind")
        if kind == "namespace":
            found += [(line_of(one), member_text(one, 3)) for one in members_of(tree) if one.find("location").get("file").endswith(path)]
        elif kind in ("class", "struct", "concept") and tree.get("prot") != "private" and tree.find("location").get("file").endswith(path):
            name = re.sub(r"^slipstack::", "", tree.findtext("compoundname"))
            word = kind + " " + name
            if kind == "concept":
                code = source_of(tree, root)
            else:
                code = template_of(tree) + word + ";"
            text = f"### {escaped(name)}\n\n```cpp\n{code}\n```\n\n{described(tree)}\n\n"
            members = members_of(tree)
            fields = [one for one in members if one.get("kind") in ("variable", "typedef")]
            text += fields_text(fields) + "\n"
            found.append((line_of(tree), text + "\n".join(member_text(one, 4) for one in members if one not in fields)))
    return f"## {header}\n\n" + "\n".join(text for _, text in sorted(found))


def page(root):
    """The page as Markdown. Throws Undocumented; FileNotFoundError where Doxygen is not installed."""
    if shutil.which("doxygen") is None:
        raise FileNotFoundError("doxygen is not installed (toolchain/install full)")
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder)
        headers = " ".join(f'"{root / "firmware" / header}"' for header in HEADERS)
        settings = out / "Doxyfile"
        settings.write_text(SETTINGS.format(headers=headers, out=out, root=root), encoding="utf-8")
        subprocess.run(["doxygen", str(settings)], check=True, stdout=subprocess.DEVNULL)
        warnings = (out / "warnings").read_text(encoding="utf-8").strip()
        if warnings:
            raise Undocumented(warnings)
        index = [one.get("refid") for one in ET.parse(out / "xml/index.xml").getroot()
                 if one.get("kind") in ("class", "struct", "concept", "namespace")]
        return INTRODUCTION + "\n" + "\n".join(header_text(out / "xml", index, header, root) for header in HEADERS)
