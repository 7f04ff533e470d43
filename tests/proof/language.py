"""The subset of Python in which the kernel is written; its checker refuses everything else.

Loops treat all elements alike, so that a proof for the few elements that the solver distinguishes holds for
any number. Integers are ids, versions, phases or states, by their names, and compared only with their own
kind. Classes have only the listed fields. A rule assigns nothing before its last precondition or query of the
geometry; a query assigns nothing. mypy checks types; the solver, what may be None and which values are
assigned.
"""

from __future__ import annotations

import ast
import builtins
import re
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any

KERNEL = Path(__file__).resolve().parents[2] / "protocol" / "kernel"
SOURCES = {path.stem: path.read_text() for path in sorted(KERNEL.glob("*.py"))}

KEPT = {"Held": "acknowledged granted regions", "DiskRecord": "name held phase life still"}
KEPT |= {"End": "disk life dead", "Binding": "number low high asked first since"}
KEPT |= {"Listed": "number peer first place static", "LifeGrants": "life version number region bindings"}
KEPT |= {"Pair": "living static", "Ledger": "version disks pairs _geometry"}
KEPT |= {"OwnEnd": "number peer low state lines half place static"}
KEPT |= {"RobotLife": "name life body own part version number region offered_number offered ends _geometry"}
KEPT |= {"Owner": "held_number held number seen open", "Follower": "held_number held seen"}
FIELDS = {name: fields.split() for name, fields in KEPT.items()}  # as in the model
WRITABLE = {  # targets of assignments in a class, besides its own fields
    "Ledger": "disk.phase disk.life disk.still pair.living pair.static living.end(disk.name).dead "
    "binding.first binding.since self.disks[name] self.pairs[name] self.pairs[low.name][high.name] "
    "self.pairs[high.name][low.name]",
    "RobotLife": "end.place end.static self.ends[listed.number]",
}
OWN = r"self\.(\w+|begin\(listed\.first\)|_geometry\.note\(disk\))"  # effects of an `__init__`
OF_PAIR = r"(pair|living|static)\..+"  # all that `_end` and `_begin` read, query and assign

KINDS = {
    "id": "name peer asked part",
    "version": "version life number dead since acknowledged granted offered_number held_number seen each[0]",
    "phase": "phase GONE ANNOUNCED PRESENT",
    "state": "state ASKED LINES HALF",
    "none": "NO 0",
    "bool": "True False moved begins lives still static low holds tied fits behind within clear apart beside "
    "inside keeps",
}
NOUNS = {word: kind for kind, words in KINDS.items() for word in words.split()}
NUMBERS = NOUNS | {"disk": "id", "held": "version"}  # parameters of type int
CONSTANTS = {word for word in NOUNS if word.isupper()}
TYPES = {*FIELDS, "LedgerGeometry", "RobotGeometry", "R", "L", "B", "L_contra", "B_contra"}
ANNOTATIONS = {*TYPES, "int", "bool", "str", "list", "dict", "tuple", "Iterable", "None"}
IMPORTS = {"__future__": {"annotations"}, "collections.abc": {"Iterable"}, "mypy_extensions": {"mypyc_attr"}}
IMPORTS |= {"typing": {"Final", "Generic", "Protocol", "TypeVar"}, "protocol.errors": {"DisknavError"}}
IMPORTS |= {f"protocol.kernel.{name}": {*TYPES, *CONSTANTS, "require"} for name in SOURCES}

COMPARED = r".+ is (not )?None|other is not disk|\w+\.name < \w+\.(name|peer)|disk == self\.low\.disk"
COMPARED += r"|number == held|line in self\.kept\(end\)"
PAIRS = r"self\.pairs\[\w+\.name\]"
ENTRIES = rf"self\.disks\[(name|peer)\]|self\.disks\.get\(name\)|{PAIRS}(\.get\(\w+\.name\))?"
ENTRIES += r"|known\.get\(listed\.number\)|(\w+\.)+regions\[(0|-1)\](\[1\])?|each\[0\]"
VIEWS = rf"({PAIRS}|self\.(disks|ends)|places)\.(values|items)\(\)|list\({PAIRS}\)"
LOOPS = {  # and the only statement for an element; there may be no element
    r"name in self\._geometry\.around\(disk, region\)": r"other = self\.disks\[name\]|require\("
    r"self\._geometry\.(clear\(other\.held, region\)|apart\(other\.held, disk\.held\)), .+\)",
    r"other in self\.disks\.values\(\)": r"require\(self\._geometry\.apart\(other\.held, disk\.held\), .+\)",
    r"end in self\.ends\.values\(\)": r"require\(self\._geometry\.keeps\(covered, end\), .+\)",
    r"disk in self\.disks\.values\(\)": r"self\._geometry\.note\(disk\)",
    rf"pair in {PAIRS}\.values\(\)": r"self\._(end|begin)\(pair, disk\)",
    rf"peer in list\({PAIRS}\)": r"self\._release\(disk, self\.disks\[peer\]\)",
    r"listed in grants\.bindings": r"self\.ends\[listed\.number\] = end|"
    r"end\.place, end\.static = \(listed\.place, listed\.static\)",
    r"number, line in self\.open": r"self\.held = line",
    rf"peer, pair in {PAIRS}\.items\(\)": r"other = self\.disks\[peer\]",
}
LOCAL = r"(?!other$)\w+"  # may be assigned in a loop
ELEMENTS = r"name(, place)? in places(\.items\(\))?|(each|_, line) in self\.(open|regions)|binding in "
ELEMENTS += r"\(pair\.living, pair\.static\)|" + "|".join(LOOPS)
APPENDS = r"(found|listed)\.(append|extend)\(.+\)"  # a local list
MUTATES = rf"{APPENDS}|require\(.+\)|self\.(open|regions)\.(append|extend)\(.+\)"
MUTATES += r"|self\.pairs\[(one|other)\.name\]\.pop\((one|other)\.name, None\)"

TEXT = '("""|\'|")((?!\\1)(?s:.))*\\1'
TOP_LEVEL = rf"{TEXT}|({'|'.join(CONSTANTS)}): Final = [012]"  # of a module, besides classes and imports
TOP_LEVEL += r"|(?P<name>\w+) = TypeVar\('(?P=name)'(, contravariant=True)?\)"
TOP_LEVEL += r'|def require\(holds: bool, what: str\) -> None:\n    """[^"]*"""\n    if not holds:\n'
TOP_LEVEL += r"        raise RefusedError\(what\)"
HEADS = r"class RefusedError\(DisknavError\):\n|class \w+Geometry\(Protocol\[[RLB, _contra]+\]\):\n"
HEADS += r"|@mypyc_attr\(allow_interpreted_subclasses=True\)\nclass \w+(\(Generic\[[RLB, ]+\]\))?:\n"

PLAIN = ast.Return | ast.Continue | ast.Tuple | ast.List | ast.Dict
PLAIN |= ast.expr_context | ast.boolop | ast.unaryop | ast.cmpop | ast.operator


class LanguageError(Exception):
    """The kernel leaves the subset."""


def need(holds: object, node: ast.AST, why: str = "is not in the subset") -> None:
    if not holds:
        raise LanguageError(f"line {getattr(node, 'lineno', 0)}: {ast.unparse(node)[:60]} {why}")


def reads(node: ast.AST, pattern: str) -> bool:
    return bool(re.fullmatch(pattern, ast.unparse(node)))


def is_name(name: str) -> bool:
    """Whether a parameter, local variable or method may have this name."""
    taken = {"require", *dir(builtins), *dir(list), *dir(dict)} - {"clear", "remove"}
    return bool(re.fullmatch(r"_?[a-z][a-z_]*|_", name)) and name not in taken


def kind_of(node: ast.expr) -> str:
    """The kind of a number or condition, by its last name."""
    if isinstance(node, ast.Compare | ast.BoolOp) or isinstance(getattr(node, "op", None), ast.Not):
        return "bool"
    if isinstance(node, ast.IfExp):
        kinds = {kind_of(node.body), kind_of(node.orelse)}
        return kinds.pop() if len(kinds) == 1 else (kinds - {"none"}).pop() if "none" in kinds else ""
    kind = NOUNS.get(getattr(getattr(node, "func", node), "attr", ast.unparse(node)), "")
    return kind if kind == "bool" or not isinstance(node, ast.Call) else ""


def is_assignable(given: str, wanted: str) -> bool:
    """Whether a value of one kind may be passed as another; "" is no kind."""
    return given == wanted or (given, wanted) in (("none", "id"), ("none", "version"), ("bool", ""))


def pairs_of(node: Any) -> list[tuple[ast.expr, ast.expr]]:
    """Targets of an assignment, each with its value."""
    pairs = [(each, node.value) for each in getattr(node, "targets", [getattr(node, "target", None)])]
    for target, value in pairs:
        need(not isinstance(target, ast.Tuple) or len(target.elts) == len(getattr(value, "elts", ())), node)
    parts = [zip(a.elts, b.elts, strict=True) if isinstance(a, ast.Tuple) else [(a, b)] for a, b in pairs]
    return [each for part in parts for each in part]


def names_in(node: ast.AST) -> set[str]:
    return {each.id for each in ast.walk(node) if isinstance(each, ast.Name)}


def iterates(node: ast.AST) -> bool:
    """Whether a statement loops over any number of elements, not over the parts of one."""
    return isinstance(node, ast.For) and not isinstance(node.iter, ast.Tuple)


class Kernel:
    """Modules of a kernel, by name."""

    def __init__(self, sources: dict[str, str]) -> None:
        self._top = [node for source in sources.values() for node in ast.parse(source).body]
        kinds = [node for node in self._top if isinstance(node, ast.ClassDef)]
        parts = [(kind.name, each) for kind in kinds for each in kind.body]
        self.methods = {(kind, each.name): each for kind, each in parts if isinstance(each, ast.FunctionDef)}

    def violations(self) -> Iterator[str]:
        """Violations of the subset."""
        checks: list[tuple[Any, Any]] = [(self._check_top, [node]) for node in self._top]
        for check, of in [*checks, *((self._check, name) for name in self.methods)]:
            try:
                check(*of)
            except LanguageError as error:
                yield str(error)

    def _check_top(self, node: ast.stmt) -> None:
        match node:
            case ast.ImportFrom(module=module, names=names):
                need({ast.unparse(each) for each in names} <= IMPORTS.get(f"{module}", set()), node)
            case ast.ClassDef(name=name, body=[ast.Expr(value=ast.Constant()), *methods]):
                need(re.fullmatch(HEADS, ast.unparse(node).partition('    """')[0]), node)
                need(all(each in self.methods.values() for each in methods), node)
                made = self.methods.get((name, "__init__"), ast.Module([], [])).body
                targets = [target for each in made if hasattr(each, "value") for target, _ in pairs_of(each)]
                fields = {each.attr for each in targets if isinstance(each, ast.Attribute)}
                need(fields == set(FIELDS.get(name, ())), node, "has other fields")
            case _:
                need(reads(node, TOP_LEVEL), node)

    def _check(self, owner: str, name: str) -> None:
        node, args = self.methods[owner, name], self.methods[owner, name].args
        made = [ast.unparse(each) for each in (*node.decorator_list, *args.defaults)]
        need(made in ([], ["property"]) or (made == ["NO"] and args.args[-1].arg == "part"), node)
        need((is_name(name) or name == "__init__") and "*" not in ast.unparse(args), node)
        for each in ast.walk(node):
            for word in {"annotation", "returns"} & {*each._fields}:
                text = ast.unparse(getattr(each, word) or ast.Name("None"))
                need(re.fullmatch(r"[\w\[\], |]+", text) and {*re.findall(r"\w+", text)} <= ANNOTATIONS, each)
            if isinstance(each, ast.AnnAssign):
                each.annotation = ast.Constant(None)  # not checked further
        for arg in args.args[1:]:
            kind, text = NUMBERS.get(arg.arg, ""), ast.unparse(arg).partition(": ")[2]
            is_record = re.fullmatch(r"End|[A-Z]\w+\[.*\]", text) or arg.arg == "held"
            kinds = {"int": kind not in ("", "bool"), "bool": kind in ("", "bool")}
            need(is_name(arg.arg) and kinds.get(text, not kind or is_record), arg, "is of another kind")
        names = {each.arg for each in args.args}
        self._check_names(node.body, names, names)
        self._check_effects(owner, node)
        parts = [each for statement in node.body for each in ast.walk(statement)]
        fields = [each for each in parts if isinstance(each, ast.Attribute)]
        known = [each.func for each in parts if isinstance(each, ast.Call)]
        known += [each.value for each in fields if reads(each.value, "self")]
        growing = {each.value for each in fields if each.attr in ("append", "extend")}
        lists = {each.id for each in growing if isinstance(each, ast.Name)}
        made = chain(*(pairs_of(each) for each in parts if isinstance(each, ast.Assign | ast.AnnAssign)))
        begun = sorted((ast.unparse(to), ast.unparse(what)) for to, what in made if names_in(to) & lists)
        need(begun == [(name, "[]") for name in sorted(lists)], node, "appends to a list that is not local")
        done = [each.value for each in parts if isinstance(each, ast.Expr)]
        for part in parts:
            need(part in known or self._is_known(part, owner), part)
            if isinstance(part, ast.Call) and part not in done:
                asked = [each for each in self._called(part, owner) if each[1] != "__init__"]
                effects = {one for each in asked for one in self._effects(each[0], self.methods[each].body)}
                need(effects <= {"require"} and not reads(part, MUTATES), part, "has an effect")

    def _is_known(self, node: ast.AST, owner: str) -> bool:
        """Whether an expression is in the subset."""
        match node:
            case ast.Name(id=name):
                return (is_name(name) and name != "self") or name in CONSTANTS
            case ast.Attribute(value=of, attr=name, ctx=ast.Load()):
                mine = [owner] if reads(of, "self") else [*FIELDS]
                asked = [self.methods[each, name] for each in mine if (each, name) in self.methods]
                is_field = any(name in FIELDS[each] for each in mine if each in FIELDS)
                return is_field or any(each.decorator_list for each in asked)
            case ast.Subscript(ctx=ast.Load()):
                return reads(node, ENTRIES)
            case ast.Attribute() | ast.Subscript():
                is_own = reads(node, rf"self\.({'|'.join(FIELDS.get(owner, ()))})")
                return is_own or ast.unparse(node) in WRITABLE.get(owner, "").split()
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                kinds = {kind_of(left), kind_of(right)}
                is_equal = isinstance(op, ast.Eq | ast.NotEq) and not kinds & {"", "bool"}
                is_later = isinstance(op, ast.Lt | ast.LtE | ast.Gt | ast.GtE) and kinds == {"version"}
                return is_later or (is_equal and len(kinds - {"none"}) == 1) or reads(node, COMPARED)
            case ast.Call(keywords=[]):
                return self._is_call(node, owner)
            case ast.Constant() | ast.UnaryOp(op=ast.USub()):
                return reads(node, f"None|True|False|0|1|-1|{TEXT}")
        return isinstance(node, PLAIN) or self._is_statement(node)

    def _is_statement(self, node: ast.AST) -> bool:
        """Whether a statement, or an expression with conditions, is in the subset."""
        match node:
            case ast.BoolOp(values=tests):
                return {kind_of(each) for each in tests} == {"bool"}
            case ast.UnaryOp(op=ast.Not(), operand=test) | ast.If(test=test) | ast.IfExp(test=test):
                return kind_of(test) == "bool"
            case ast.For(orelse=[]) | ast.comprehension():
                head = f"{ast.unparse(node.target).strip('()')} in {ast.unparse(node.iter)}"
                is_tested = all(kind_of(each) == "bool" for each in getattr(node, "ifs", ()))
                return bool(re.fullmatch(ELEMENTS, head)) and is_tested
            case ast.AugAssign(target=ast.Attribute() as target, op=ast.Add(), value=value):
                return kind_of(target) == "version" and reads(value, "1")
            case ast.Assign() | ast.AnnAssign():
                return all(self._gets(*each) for each in pairs_of(node))
            case ast.Starred(value=ast.ListComp()) | ast.Expr(value=ast.Call() | ast.Constant()):
                return True
        return isinstance(node, ast.ListComp | ast.DictComp) and len(node.generators) == 1

    def _gets(self, target: ast.expr, value: ast.expr) -> bool:
        """Whether a field is assigned a number of its kind, or a local an object or a condition."""
        wanted, given = NOUNS.get(getattr(target, "attr", ast.unparse(target)), ""), kind_of(value)
        if isinstance(target, ast.Name):
            return wanted in (given, "") and given in ("", "bool")
        return is_assignable(given, wanted) or (given, wanted) == ("", "bool") or reads(value, "held")

    def _is_call(self, node: ast.Call, owner: str) -> bool:
        """Whether a call passes arguments of the right kinds to a method, or is listed."""
        if reads(node.func, "require"):
            return kind_of(node.args[0]) == "bool" and isinstance(node.args[-1], ast.Constant)
        called = [self.methods[each].args.args[1:] for each in self._called(node, owner)]
        kinds = [
            (kind_of(each), {"int": NUMBERS.get(arg.arg, ""), "bool": "bool"}.get(text, ""))
            for args in called
            for arg, each in zip(args, node.args, strict=False)
            for text in [ast.unparse(arg).partition(": ")[2]]
        ]
        is_kept = bool(called) and all(is_assignable(*each) for each in kinds)
        return is_kept or reads(node, f"{MUTATES}|{ENTRIES}|{VIEWS}")

    def _called(self, node: ast.Call, owner: str) -> list[tuple[str, str]]:
        """Methods that a call may resolve to."""
        if not isinstance(node.func, ast.Attribute):
            return [each for each in self.methods if each == (getattr(node.func, "id", ""), "__init__")]
        of, name = ast.unparse(node.func.value), node.func.attr
        found = [each for each in self.methods if each[1] == name and (each[0] == owner) == (of == "self")]
        found = [each for each in found if each[0].endswith("Geometry") == (of == "self._geometry")]
        return [each for each in found if not self.methods[each].decorator_list]

    def _check_names(self, body: list[ast.stmt], names: set[str], fixed: set[str]) -> None:
        """A block reads only assigned names; it assigns no parameter, and in a loop no outer name."""
        names = set(names)
        for node in body:
            inner, around = set(names), fixed
            parts = [*ast.walk(getattr(node, "test", getattr(node, "iter", node)))]
            through = [each for each in (node, *parts) if isinstance(each, ast.For | ast.comprehension)]
            within = set().union(*(names_in(each.target) for each in through))
            need(not within & names, node, "reuses a name")
            words = [each for each in parts if isinstance(each, ast.Name)]
            read = {each.id for each in words if isinstance(each.ctx, ast.Load) and is_name(each.id)}
            stored = {each.id for each in words if isinstance(each.ctx, ast.Store)} - within
            need(read <= names | within, node, "reads an unassigned name")
            need(not stored & fixed, node, "reassigns a name")
            names |= stored
            if isinstance(node, ast.For):
                inner |= within
                around = inner if iterates(node) else fixed
            for block in (getattr(node, "body", []), getattr(node, "orelse", [])):
                self._check_names(block if isinstance(block, list) else [], inner, around)

    # -- effects

    def _effects(self, owner: str, body: list[ast.stmt], deep: bool = True) -> list[str]:
        """Effects of statements, in order: "require", also for queries of the geometry, or an assigned
        target; those of two branches in sequence.
        """
        effects: list[str] = []
        for node in body:
            head = getattr(node, "test", getattr(node, "iter", node))
            calls = [each for each in ast.walk(head) if isinstance(each, ast.Call)]
            asked = chain(*(self._called(each, owner) for each in calls[isinstance(node, ast.Expr) :]))
            effects += ["require" for each in asked if self._queries(*each)]
            match node:
                case ast.If(body=one, orelse=other):
                    both = [self._effects(owner, each, deep) for each in (one, other)]
                    is_ordered = all(each == sorted(each, key="require".__ne__) for each in both)
                    order = "require".__ne__ if is_ordered else lambda _: 0
                    effects += sorted([*both[0], *both[1]], key=order)
                case ast.For(body=inner):
                    effects += self._effects(owner, inner, deep)
                case ast.Expr(value=ast.Call() as call) if reads(call.func, "require"):
                    effects.append("require")
                case ast.Expr(value=ast.Call() as call) if not reads(call, APPENDS):
                    called = self._called(call, owner) if deep else []
                    inner_effects = [self._effects(each[0], self.methods[each].body) for each in called]
                    effects += [effect for each in inner_effects for effect in each] or [ast.unparse(call)]
                case ast.Assign() | ast.AnnAssign() | ast.AugAssign():
                    targets = [each for each, _ in pairs_of(node) if not isinstance(each, ast.Name)]
                    effects += [ast.unparse(each) for each in targets]
        return effects

    def _queries(self, owner: str, name: str) -> bool:
        """Whether a method queries the geometry, which must be notified of changes first."""
        requires = "require" in self._effects(owner, self.methods[owner, name].body)
        return owner.endswith("Geometry") or (name != "__init__" and requires)

    def _check_effects(self, owner: str, node: ast.FunctionDef) -> None:
        effects = self._effects(owner, node.body)
        first = min((at for at, each in enumerate(effects) if each != "require"), default=len(effects))
        need("require" not in effects[first:], node, "assigns before a precondition")
        need(not effects or not node.decorator_list, node, "is a property, and has an effect")
        is_query = not reads(node.returns or node, "None|DiskRecord.*")
        need(not is_query or first == len(effects), node, "is a query, and assigns")
        own = [re.fullmatch(OWN, each) for each in self._effects(owner, node.body, deep=False)]
        need(node.name != "__init__" or all(own), node, "changes its arguments")
        if node.name in ("_begin", "_end", "_release"):
            need(all(re.fullmatch(f"{OF_PAIR}|{MUTATES}", each) for each in effects), node, "affects others")
        if node.name in ("_begin", "_end"):
            read = [ast.unparse(use) for use in ast.walk(node) if isinstance(use, ast.Attribute | ast.Call)]
            need(all(re.fullmatch(OF_PAIR + r"|self\.version|disk\.name", each) for each in read), node)
        for each in ast.walk(node):
            if iterates(each):
                self._check_loop(owner, each)

    def _check_loop(self, owner: str, loop: Any) -> None:
        """A loop has only the statement that `LOOPS` has for its elements, and no other query."""
        inside = [each for statement in loop.body for each in ast.walk(statement)]
        head = f"{ast.unparse(loop.target).strip('()')} in {ast.unparse(loop.iter)}"
        does = next((does for elements, does in LOOPS.items() if re.fullmatch(elements, head)), "")
        made = [each for each in inside if isinstance(each, ast.Assign | ast.AnnAssign | ast.AugAssign)]
        done = [each for each in made if not all(reads(to, LOCAL) for to, _ in pairs_of(each))]
        done += [each for each in inside if isinstance(each, ast.Expr) and not reads(each, APPENDS)]
        within = list(chain(*map(ast.walk, done)))
        changes = any(not reads(each, r"(require|other = ).+") for each in done)
        for each in inside:
            need(not iterates(each) and not isinstance(each, ast.Return | ast.ListComp), each, "is in a loop")
            need(each not in done or reads(each, does), each, "is not listed for this loop")
            if isinstance(each, ast.Call):
                called = [self.methods[name] for name in self._called(each, owner)]
                need(not any(map(iterates, chain(*map(ast.walk, called)))), each, "is a nested loop")
                queries = any(self._queries(*name) for name in self._called(each, owner))
                is_made = getattr(each.func, "attr", "get") in ("get", "append", "extend")
                need(each in within or is_made or not (queries or changes), each, "queries others")
