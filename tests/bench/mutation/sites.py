# SPDX-License-Identifier: Apache-2.0
"""The places of C++ headers where a small change makes another program, found with libclang."""

import dataclasses
import hashlib
import pathlib
import re
import sys

sys.path.append("/usr/lib/python3/dist-packages")  # Debian's python3-clang-14, whatever python3 is first in the path
try:
    import clang.cindex as clang
except ImportError:
    clang = None

COMPARISONS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
LOGIC = {"&&": "||", "||": "&&"}
ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*", "%": "*", "&": "|", "|": "&", "<<": ">>", ">>": "<<"}
ASSIGNMENTS = {"+=": "-=", "-=": "+=", "*=": "/=", "/=": "*=", "|=": "&=", "&=": "|=", "<<=": ">>=", ">>=": "<<="}


@dataclasses.dataclass
class Site:
    """One mutant: bytes begin to end of the file become `changed`, or the statement there goes."""

    path: str
    begin: int
    end: int
    line: int
    kind: str  # comparison, arithmetic, logic, constant, statement
    function: str
    original: str
    changed: str  # "" for a statement that goes

    def key(self):
        """What the site is called in the list of survivors: stays when lines move."""
        return f"{self.function}: {self.original} -> {self.changed or 'nothing'}"

    def rank(self, seed, again):
        return hashlib.sha256(f"{seed}|{self.key()}|{again}".encode()).hexdigest()


def one_line(text):
    """Without comments and line breaks."""
    text = re.sub(r"//[^\n]*", "", text)
    return re.sub(r"\s+", " ", text).strip()


class Finder:
    """Walks the trees of one translation unit that includes the headers."""

    def __init__(self, root, files, arguments):
        if clang is None:
            raise ModuleNotFoundError("python3-clang-14")
        kinds = clang.CursorKind
        self.texts = {str(root / name): (root / name).read_bytes() for name in files}
        self.names = {str(root / name): name for name in files}
        self.sites = []
        self.function = ""
        self.owner = ""  # the same as the compiler knows it
        self.owners = {}  # of sites, by place in the list
        self.calls = {}  # callers of a function, by USR; "" is the compiler
        # What the compiler computes is no place for a mutant: a mutant is chosen when the program runs.
        self.never = {kinds.STATIC_ASSERT, kinds.ENUM_DECL, kinds.TEMPLATE_TYPE_PARAMETER,
                      kinds.TEMPLATE_NON_TYPE_PARAMETER, kinds.ALIGNED_ATTR, kinds.TYPE_ALIAS_DECL,
                      kinds.TYPE_ALIAS_TEMPLATE_DECL, kinds.USING_DECLARATION}
        self.functions = {kinds.FUNCTION_DECL, kinds.CXX_METHOD, kinds.CONSTRUCTOR, kinds.DESTRUCTOR,
                          kinds.FUNCTION_TEMPLATE, kinds.CONVERSION_FUNCTION}
        self.statements = {kinds.CALL_EXPR, kinds.COMPOUND_ASSIGNMENT_OPERATOR, kinds.BINARY_OPERATOR,
                           kinds.UNARY_OPERATOR}
        source = "".join(f'#include "{root / name}"\n' for name in files)
        unit = clang.Index.create().parse("all_headers.cpp", args=arguments, unsaved_files=[("all_headers.cpp", source)])
        errors = [d for d in unit.diagnostics if d.severity >= clang.Diagnostic.Error]
        if errors:
            raise RuntimeError(f"clang: {errors[0].spelling} at {errors[0].location}")
        for top in unit.cursor.get_children():
            if self.ours(top):
                self.visit(top, None)
        only_compiler = self.only_compiler()
        self.sites = [site for place, site in enumerate(self.sites) if self.owners[place] not in only_compiler]

    def only_compiler(self):
        """Functions that make constants only, as the tables of objects: nothing asks for a mutant there."""
        found = set()
        while True:
            more = {callee for callee, callers in self.calls.items() if callers <= found | {""}} - found
            if not more:
                return found
            found |= more

    def note_calls(self, cursor, caller):
        for child in cursor.walk_preorder():
            if child.kind == clang.CursorKind.CALL_EXPR and child.referenced is not None:
                self.calls.setdefault(child.referenced.get_usr(), set()).add(caller)

    def ours(self, cursor):
        return cursor.location.file is not None and cursor.location.file.name in self.texts

    def text(self, cursor_or_range):
        extent = getattr(cursor_or_range, "extent", cursor_or_range)
        return self.texts[extent.start.file.name][extent.start.offset:extent.end.offset].decode()

    def add(self, cursor, kind, changed, begin=None, end=None):
        path = cursor.extent.start.file.name
        begin = cursor.extent.start.offset if begin is None else begin
        end = cursor.extent.end.offset if end is None else end
        original = one_line(self.texts[path][begin:end].decode())
        self.owners[len(self.sites)] = self.owner
        self.sites.append(Site(self.names[path], begin, end, cursor.extent.start.line, kind, self.function, original,
                               one_line(changed)))

    def visit(self, cursor, parent):
        kinds = clang.CursorKind
        if cursor.kind in self.never or cursor.extent.start.file is None:
            self.note_calls(cursor, "")
            return
        if cursor.extent.start.file.name not in self.texts or cursor.extent.end.file.name != cursor.extent.start.file.name:
            return
        outer = self.function, self.owner
        if cursor.kind in self.functions:
            owner = cursor.semantic_parent.spelling
            self.function = f"{owner}::{cursor.spelling}" if owner not in ("", "slipstack", "canopen") else cursor.spelling
            self.owner = cursor.get_usr()
        elif cursor.kind == kinds.CALL_EXPR and cursor.referenced is not None:
            self.calls.setdefault(cursor.referenced.get_usr(), set()).add(self.owner or "a file")
        if cursor.kind == kinds.FIELD_DECL:
            # What a member begins with is nearly always written before it is read.
            return
        if not (cursor.kind == kinds.VAR_DECL and self.is_constant(cursor)) and "if constexpr" not in self.text(cursor)[:12]:
            self.look(cursor, parent)
            self.descend(cursor)
        else:
            self.note_calls(cursor, "")
        self.function, self.owner = outer

    def is_constant(self, variable):
        before = self.text(variable).split(variable.spelling or "=", 1)[0]
        # A constant that the compiler may compute, and a table of the file.
        outside = variable.semantic_parent.kind not in self.functions
        literal = re.search(r"\bconst\b", before) and re.search(r"[=({]\s*-?[\d.x]+[uUfFlL]*\s*[)}]?$", self.text(variable))
        return "constexpr" in before or outside or bool(literal)

    def descend(self, cursor):
        kinds = clang.CursorKind
        children = list(cursor.get_children())
        if cursor.kind == kinds.CASE_STMT:
            children = children[1:]  # the label
        for child in children:
            # Array bounds and template arguments are constants.
            if cursor.kind in (kinds.VAR_DECL, kinds.FIELD_DECL, kinds.PARM_DECL) and child.kind.is_expression():
                between = self.texts[cursor.extent.start.file.name][cursor.extent.start.offset:child.extent.start.offset]
                if between.decode().count("<") > between.decode().count(">") or between.decode().rstrip().endswith("["):
                    continue
            if cursor.kind in (kinds.DECL_REF_EXPR, kinds.MEMBER_REF_EXPR) and self.is_template_argument(cursor, child):
                continue
            self.visit(child, cursor)

    def is_template_argument(self, reference, child):
        text = self.texts[reference.extent.start.file.name]
        before = text[reference.extent.start.offset:child.extent.start.offset].decode().replace("->", "")
        return before.count("<") > before.count(">")

    def look(self, cursor, parent):
        kinds = clang.CursorKind
        if not self.function:
            return
        if cursor.kind == kinds.BINARY_OPERATOR:
            self.binary(cursor)
        elif cursor.kind == kinds.COMPOUND_ASSIGNMENT_OPERATOR:
            self.replace_operator(cursor, ASSIGNMENTS, "arithmetic")
        elif cursor.kind == kinds.UNARY_OPERATOR:
            operand = next(cursor.get_children())
            sign = self.text(cursor)[:1]
            if sign in "!-" and self.text(cursor)[:2] not in ("--",) and self.number(cursor) is not None:
                self.add(cursor, "logic" if sign == "!" else "arithmetic",
                         f"bool({self.text(operand)})" if sign == "!" else f"({self.text(operand)})")
        elif cursor.kind in (kinds.INTEGER_LITERAL, kinds.FLOATING_LITERAL):
            self.literal(cursor)
        elif cursor.kind == kinds.DECL_REF_EXPR and re.fullmatch(r"k[A-Z]\w*", self.text(cursor)):
            self.named_constant(cursor)
        elif cursor.kind == kinds.IF_STMT:
            self.condition(cursor)
        elif cursor.kind == kinds.RETURN_STMT:
            for value in cursor.get_children():
                if value.type.get_canonical().kind == clang.TypeKind.BOOL:
                    self.add(value, "logic", f"!({self.text(value)})")
        if cursor.kind in (kinds.COMPOUND_STMT, kinds.IF_STMT, kinds.FOR_STMT, kinds.WHILE_STMT, kinds.CASE_STMT):
            self.statements_of(cursor)

    def number(self, cursor):
        """'integer', 'real', 'bool', 'unknown' in a template; None for what is no number."""
        kind = cursor.type.get_canonical().kind
        if kind == clang.TypeKind.BOOL:
            return "bool"
        if kind in (clang.TypeKind.FLOAT, clang.TypeKind.DOUBLE):
            return "real"
        if clang.TypeKind.CHAR_U.value <= kind.value <= clang.TypeKind.INT128.value:
            return "integer"
        return "unknown" if kind in (clang.TypeKind.DEPENDENT, clang.TypeKind.UNEXPOSED) else None

    def operator_of(self, cursor):
        left, right = list(cursor.get_children())[:2]
        file = cursor.extent.start.file.name
        between = one_line(self.texts[file][left.extent.end.offset:right.extent.start.offset].decode())
        return left, right, between

    def replace_operator(self, cursor, table, kind):
        left, right, operator = self.operator_of(cursor)
        if operator not in table or None in (self.number(left), self.number(right)):
            return
        # && binds tighter than ||, & tighter than |: the tree is to stay.
        template = "({}) {} ({})" if table in (LOGIC, ARITHMETIC) and operator in "&&||" else "{} {} {}"
        self.add(cursor, kind, f"({template.format(self.text(left), table[operator], self.text(right))})")

    def binary(self, cursor):
        left, right, operator = self.operator_of(cursor)
        numbers = {self.number(left), self.number(right)}
        if operator in LOGIC:
            self.replace_operator(cursor, LOGIC, "logic")
        elif operator in COMPARISONS:
            # Of reals, < and <= are the same but for one value in 10^7: negated instead.
            if operator in ("==", "!=") or numbers == {"integer"}:
                self.add(cursor, "comparison", f"({self.text(left)} {COMPARISONS[operator]} {self.text(right)})")
            if operator not in ("==", "!="):
                self.add(cursor, "comparison", f"!({self.text(cursor)})")
        elif operator in ARITHMETIC:
            self.replace_operator(cursor, ARITHMETIC, "arithmetic")

    def literal(self, cursor):
        text = self.text(cursor)
        if cursor.kind == clang.CursorKind.INTEGER_LITERAL:
            self.add(cursor, "constant", f"({text} + 1)")
            return
        zero = float(re.sub(r"[fFlL]$", "", text)) == 0.0 if "0x" not in text else False
        self.add(cursor, "constant", f"({text} + 1.0F)" if zero else f"(2.0F * {text})")

    def named_constant(self, cursor):
        if self.number(cursor) == "integer":
            self.add(cursor, "constant", f"({self.text(cursor)} + 1)")
        elif self.number(cursor) == "real":
            self.add(cursor, "constant", f"(2.0F * {self.text(cursor)})")

    def condition(self, statement):
        condition = next(statement.get_children())
        if condition.kind.is_expression():
            self.add(condition, "logic", f"!({self.text(condition)})")

    def statements_of(self, block):
        file = self.texts[block.extent.start.file.name]
        children = list(block.get_children())
        if block.kind == clang.CursorKind.IF_STMT:
            children = children[1:]
        elif block.kind in (clang.CursorKind.FOR_STMT, clang.CursorKind.WHILE_STMT):
            children = children[-1:]
        for child in children:
            inner = child
            if inner.kind == clang.CursorKind.UNEXPOSED_EXPR:
                inner = next(inner.get_children(), inner)
            if inner.kind not in self.statements or child.extent.end.file is None:
                continue
            if inner.kind == clang.CursorKind.BINARY_OPERATOR and self.operator_of(inner)[2] != "=":
                continue
            end = child.extent.end.offset
            after = re.match(rb"\s*;", file[end:])
            if not after:
                continue  # a condition, or an expression that something else is made of
            self.add(child, "statement", "", end=end + after.end())


def find(root, folders, arguments):
    """All sites of the sources below `folders`, in the order of the files. `arguments` are the compiler's."""
    root = pathlib.Path(root).resolve()
    files = sorted(str(path.relative_to(root)) for folder in folders for path in (root / folder).rglob("*") if path.suffix in (".h", ".cpp"))
    seen, sites = set(), []
    for site in Finder(root, files, [*arguments, f"-I{root}"]).sites:
        place = (site.path, site.begin, site.end, site.changed)
        if place not in seen and site.original != site.changed:
            seen.add(place)
            sites.append(site)
    return sorted(sites, key=lambda site: (site.path, site.begin, -site.end))
