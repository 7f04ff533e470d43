"""The kernel is written in a small language, which is defined here; what it does not list is refused.

Loops treat all elements alike: what the solver shows of those it can tell apart then holds of any number.
Numbers are ids, versions, phases or states, as their words say, and compared only with their own kind. Only
the listed fields are kept. A rule stores nothing before its last precondition or question of geometry, a
question nothing at all. Types are left to mypy; what may be None, and whether the right things are stored,
to the solver.
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
KEPT |= {"End": "disk life dead", "Binding": "number low high asked first told"}
KEPT |= {"Listed": "number peer first place static", "Told": "life version number region bindings"}
KEPT |= {"Pair": "living static", "Ledger": "version disks pairs _geometry"}
KEPT |= {"OwnEnd": "number peer low state lines half place static"}
KEPT |= {"RobotLife": "name life body own part version number region offered_number offered ends _geometry"}
KEPT |= {"Owner": "held_number held number seen open", "Follower": "held_number held seen"}
FIELDS = {name: fields.split() for name, fields in KEPT.items()}  # all that the model has
STORED = {  # by a class, beside fields of its own objects
    "Ledger": "disk.phase disk.life disk.still pair.living pair.static living.end(disk.name).dead "
    "binding.first binding.told self.disks[name] self.pairs[name] self.pairs[low.name][high.name] "
    "self.pairs[high.name][low.name]",
    "RobotLife": "end.place end.static self.ends[listed.number]",
}
OWN = r"self\.(\w+|begin\(listed\.first\)|_geometry\.note\(disk\))"  # what is done by whatever is made
OF_PAIR = r"(pair|living|static)\..+"  # what `_end` and `_begin` read, ask and store for a loop

KINDS = {
    "id": "name peer asked part",
    "version": "version life number dead told acknowledged granted offered_number held_number seen each[0]",
    "phase": "phase GONE ANNOUNCED PRESENT",
    "state": "state ASKED LINES HALF",
    "none": "NO 0",
    "bool": "True False moved begins lives still static low holds tied fits behind within clear apart beside "
    "inside keeps",
}
NOUNS = {word: kind for kind, words in KINDS.items() for word in words.split()}
NUMBERS = NOUNS | {"disk": "id", "held": "version"}  # as arguments of type int
CONSTANTS = {word for word in NOUNS if word.isupper()}
TYPES = {*FIELDS, "LedgerGeometry", "RobotGeometry", "R", "L", "B", "L_contra", "B_contra"}
WORDS = {*TYPES, "int", "bool", "str", "list", "dict", "tuple", "Iterable", "None"}  # of annotations
IMPORTS = {"__future__": {"annotations"}, "collections.abc": {"Iterable"}, "mypy_extensions": {"mypyc_attr"}}
IMPORTS |= {"typing": {"Final", "Generic", "Protocol", "TypeVar"}, "protocol.errors": {"DisknavError"}}
IMPORTS |= {f"protocol.kernel.{name}": {*TYPES, *CONSTANTS, "require"} for name in SOURCES}

COMPARED = r".+ is (not )?None|other is not disk|\w+\.name < \w+\.(name|peer)|disk == self\.low\.disk"
COMPARED += r"|number == held|line in self\.kept\(end\)"
PAIRS = r"self\.pairs\[\w+\.name\]"
ENTRIES = rf"self\.disks\[(name|peer)\]|self\.disks\.get\(name\)|{PAIRS}(\.get\(\w+\.name\))?"
ENTRIES += r"|known\.get\(listed\.number\)|(\w+\.)+regions\[(0|-1)\](\[1\])?|each\[0\]"
MANY = rf"({PAIRS}|self\.(disks|ends)|places)\.(values|items)\(\)|list\({PAIRS}\)"
LOOPS = {  # and what they require or do of each element; there may be none
    r"name in self\._geometry\.around\(disk, region\)": r"other = self\.disks\[name\]|require\("
    r"self\._geometry\.(clear\(other\.held, region\)|apart\(other\.held, disk\.held\)), .+\)",
    r"other in self\.disks\.values\(\)": r"require\(self\._geometry\.apart\(other\.held, disk\.held\), .+\)",
    r"end in self\.ends\.values\(\)": r"require\(self\._geometry\.keeps\(covered, end\), .+\)",
    r"disk in self\.disks\.values\(\)": r"self\._geometry\.note\(disk\)",
    rf"pair in {PAIRS}\.values\(\)": r"self\._(end|begin)\(pair, disk\)",
    rf"peer in list\({PAIRS}\)": r"self\._release\(disk, self\.disks\[peer\]\)",
    r"listed in told\.bindings": r"self\.ends\[listed\.number\] = end|"
    r"end\.place, end\.static = \(listed\.place, listed\.static\)",
    r"number, line in self\.open": r"self\.held = line",
    rf"peer, pair in {PAIRS}\.items\(\)": r"other = self\.disks\[peer\]",
}
LOCAL = r"(?!other$)\w+"  # names that a loop may give anything
ELEMENTS = r"name(, place)? in places(\.items\(\))?|(each|_, line) in self\.(open|regions)|binding in "
ELEMENTS += r"\(pair\.living, pair\.static\)|" + "|".join(LOOPS)
GROWS = r"(found|listed)\.(append|extend)\(.+\)"  # a list of the method's own
CHANGES = rf"{GROWS}|require\(.+\)|self\.(open|regions)\.(append|extend)\(.+\)"
CHANGES += r"|self\.pairs\[(one|other)\.name\]\.pop\((one|other)\.name, None\)"

TEXT = '("""|\'|")((?!\\1)(?s:.))*\\1'
TOP = rf"{TEXT}|({'|'.join(CONSTANTS)}): Final = [012]"  # what a module has beside classes and imports
TOP += r"|(?P<name>\w+) = TypeVar\('(?P=name)'(, contravariant=True)?\)"
TOP += r'|def require\(holds: bool, what: str\) -> None:\n    """[^"]*"""\n    if not holds:\n'
TOP += r"        raise RefusedError\(what\)"
HEADS = r"class RefusedError\(DisknavError\):\n|class \w+Geometry\(Protocol\[[RLB, _contra]+\]\):\n"
HEADS += r"|@mypyc_attr\(allow_interpreted_subclasses=True\)\nclass \w+(\(Generic\[[RLB, ]+\]\))?:\n"

PLAIN = ast.Return | ast.Continue | ast.Tuple | ast.List | ast.Dict
PLAIN |= ast.expr_context | ast.boolop | ast.unaryop | ast.cmpop | ast.operator


class StrangeError(Exception):
    """The kernel says what the language does not have."""


def need(holds: object, node: ast.AST, why: str = "is not of the language") -> None:
    if not holds:
        raise StrangeError(f"line {getattr(node, 'lineno', 0)}: {ast.unparse(node)[:60]} {why}")


def said(node: ast.AST, pattern: str) -> bool:
    return bool(re.fullmatch(pattern, ast.unparse(node)))


def is_word(name: str) -> bool:
    """Whether an argument, a local or a method may be called so."""
    taken = {"require", *dir(builtins), *dir(list), *dir(dict)} - {"clear", "remove"}
    return bool(re.fullmatch(r"_?[a-z][a-z_]*|_", name)) and name not in taken


def noun(node: ast.expr) -> str:
    """The kind of a number or condition, by its last word."""
    if isinstance(node, ast.Compare | ast.BoolOp) or isinstance(getattr(node, "op", None), ast.Not):
        return "bool"
    if isinstance(node, ast.IfExp):
        kinds = {noun(node.body), noun(node.orelse)}
        return kinds.pop() if len(kinds) == 1 else (kinds - {"none"}).pop() if "none" in kinds else ""
    kind = NOUNS.get(getattr(getattr(node, "func", node), "attr", ast.unparse(node)), "")
    return kind if kind == "bool" or not isinstance(node, ast.Call) else ""


def goes(given: str, wanted: str) -> bool:
    """Whether what is of one kind may be given as another; "" is of none."""
    return given == wanted or (given, wanted) in (("none", "id"), ("none", "version"), ("bool", ""))


def assigned(node: Any) -> list[tuple[ast.expr, ast.expr]]:
    """Targets of a statement, and what each gets."""
    pairs = [(each, node.value) for each in getattr(node, "targets", [getattr(node, "target", None)])]
    for target, value in pairs:
        need(not isinstance(target, ast.Tuple) or len(target.elts) == len(getattr(value, "elts", ())), node)
    parts = [zip(a.elts, b.elts, strict=True) if isinstance(a, ast.Tuple) else [(a, b)] for a, b in pairs]
    return [each for part in parts for each in part]


def names_in(node: ast.AST) -> set[str]:
    return {each.id for each in ast.walk(node) if isinstance(each, ast.Name)}


def is_loop(node: ast.AST) -> bool:
    """Whether it goes through elements, and not through parts of one, which the solver knows."""
    return isinstance(node, ast.For) and not isinstance(node.iter, ast.Tuple)


class Kernel:
    """Modules of a kernel, by name."""

    def __init__(self, sources: dict[str, str]) -> None:
        self._top = [node for source in sources.values() for node in ast.parse(source).body]
        kinds = [node for node in self._top if isinstance(node, ast.ClassDef)]
        parts = [(kind.name, each) for kind in kinds for each in kind.body]
        self.methods = {(kind, each.name): each for kind, each in parts if isinstance(each, ast.FunctionDef)}

    def strange(self) -> Iterator[str]:
        """What is not of the language."""
        checks: list[tuple[Any, Any]] = [(self._check_top, [node]) for node in self._top]
        for check, of in [*checks, *((self._check, name) for name in self.methods)]:
            try:
                check(*of)
            except StrangeError as error:
                yield str(error)

    def _check_top(self, node: ast.stmt) -> None:
        match node:
            case ast.ImportFrom(module=module, names=names):
                need({ast.unparse(each) for each in names} <= IMPORTS.get(f"{module}", set()), node)
            case ast.ClassDef(name=name, body=[ast.Expr(value=ast.Constant()), *methods]):
                need(re.fullmatch(HEADS, ast.unparse(node).partition('    """')[0]), node)
                need(all(each in self.methods.values() for each in methods), node)
                made = self.methods.get((name, "__init__"), ast.Module([], [])).body
                targets = [target for each in made if hasattr(each, "value") for target, _ in assigned(each)]
                fields = {each.attr for each in targets if isinstance(each, ast.Attribute)}
                need(fields == set(FIELDS.get(name, ())), node, "has other fields")
            case _:
                need(said(node, TOP), node)

    def _check(self, owner: str, name: str) -> None:
        node, args = self.methods[owner, name], self.methods[owner, name].args
        made = [ast.unparse(each) for each in (*node.decorator_list, *args.defaults)]
        need(made in ([], ["property"]) or (made == ["NO"] and args.args[-1].arg == "part"), node)
        need((is_word(name) or name == "__init__") and "*" not in ast.unparse(args), node)
        for each in ast.walk(node):
            for word in {"annotation", "returns"} & {*each._fields}:
                text = ast.unparse(getattr(each, word) or ast.Name("None"))
                need(re.fullmatch(r"[\w\[\], |]+", text) and {*re.findall(r"\w+", text)} <= WORDS, each)
            if isinstance(each, ast.AnnAssign):
                each.annotation = ast.Constant(None)  # nothing else looks at it
        for arg in args.args[1:]:
            kind, text = NUMBERS.get(arg.arg, ""), ast.unparse(arg).partition(": ")[2]
            is_record = re.fullmatch(r"End|[A-Z]\w+\[.*\]", text) or arg.arg == "held"
            kinds = {"int": kind not in ("", "bool"), "bool": kind in ("", "bool")}
            need(is_word(arg.arg) and kinds.get(text, not kind or is_record), arg, "is of another kind")
        names = {each.arg for each in args.args}
        self._check_names(node.body, names, names)
        self._check_acts(owner, node)
        parts = [each for statement in node.body for each in ast.walk(statement)]
        fields = [each for each in parts if isinstance(each, ast.Attribute)]
        known = [each.func for each in parts if isinstance(each, ast.Call)]
        known += [each.value for each in fields if said(each.value, "self")]
        growing = {each.value for each in fields if each.attr in ("append", "extend")}
        lists = {each.id for each in growing if isinstance(each, ast.Name)}
        made = chain(*(assigned(each) for each in parts if isinstance(each, ast.Assign | ast.AnnAssign)))
        begun = sorted((ast.unparse(to), ast.unparse(what)) for to, what in made if names_in(to) & lists)
        need(begun == [(name, "[]") for name in sorted(lists)], node, "adds to what is no list of its own")
        done = [each.value for each in parts if isinstance(each, ast.Expr)]
        for part in parts:
            need(part in known or self._is_known(part, owner), part)
            if isinstance(part, ast.Call) and part not in done:
                asked = [each for each in self._called(part, owner) if each[1] != "__init__"]
                acts = {act for each in asked for act in self._acts(each[0], self.methods[each].body)}
                need(acts <= {"require"} and not said(part, CHANGES), part, "changes something")

    def _is_known(self, node: ast.AST, owner: str) -> bool:
        """Whether an expression may be said."""
        match node:
            case ast.Name(id=name):
                return (is_word(name) and name != "self") or name in CONSTANTS
            case ast.Attribute(value=of, attr=name, ctx=ast.Load()):
                mine = [owner] if said(of, "self") else [*FIELDS]
                asked = [self.methods[each, name] for each in mine if (each, name) in self.methods]
                is_field = any(name in FIELDS[each] for each in mine if each in FIELDS)
                return is_field or any(each.decorator_list for each in asked)
            case ast.Subscript(ctx=ast.Load()):
                return said(node, ENTRIES)
            case ast.Attribute() | ast.Subscript():
                is_own = said(node, rf"self\.({'|'.join(FIELDS.get(owner, ()))})")
                return is_own or ast.unparse(node) in STORED.get(owner, "").split()
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                kinds = {noun(left), noun(right)}
                is_equal = isinstance(op, ast.Eq | ast.NotEq) and not kinds & {"", "bool"}
                is_later = isinstance(op, ast.Lt | ast.LtE | ast.Gt | ast.GtE) and kinds == {"version"}
                return is_later or (is_equal and len(kinds - {"none"}) == 1) or said(node, COMPARED)
            case ast.Call(keywords=[]):
                return self._is_call(node, owner)
            case ast.Constant() | ast.UnaryOp(op=ast.USub()):
                return said(node, f"None|True|False|0|1|-1|{TEXT}")
        return isinstance(node, PLAIN) or self._is_statement(node)

    def _is_statement(self, node: ast.AST) -> bool:
        """Whether a statement, or what has conditions, may be said."""
        match node:
            case ast.BoolOp(values=tests):
                return {noun(each) for each in tests} == {"bool"}
            case ast.UnaryOp(op=ast.Not(), operand=test) | ast.If(test=test) | ast.IfExp(test=test):
                return noun(test) == "bool"
            case ast.For(orelse=[]) | ast.comprehension():
                head = f"{ast.unparse(node.target).strip('()')} in {ast.unparse(node.iter)}"
                is_tested = all(noun(each) == "bool" for each in getattr(node, "ifs", ()))
                return bool(re.fullmatch(ELEMENTS, head)) and is_tested
            case ast.AugAssign(target=ast.Attribute() as target, op=ast.Add(), value=value):
                return noun(target) == "version" and said(value, "1")
            case ast.Assign() | ast.AnnAssign():
                return all(self._gets(*each) for each in assigned(node))
            case ast.Starred(value=ast.ListComp()) | ast.Expr(value=ast.Call() | ast.Constant()):
                return True
        return isinstance(node, ast.ListComp | ast.DictComp) and len(node.generators) == 1

    def _gets(self, target: ast.expr, value: ast.expr) -> bool:
        """Whether a field gets a number of its kind, or a local an object or a condition."""
        wanted, given = NOUNS.get(getattr(target, "attr", ast.unparse(target)), ""), noun(value)
        if isinstance(target, ast.Name):
            return wanted in (given, "") and given in ("", "bool")
        return goes(given, wanted) or (given, wanted) == ("", "bool") or said(value, "held")

    def _is_call(self, node: ast.Call, owner: str) -> bool:
        """Whether a call gives numbers and conditions of their kinds to a method, or is a listed one."""
        if said(node.func, "require"):
            return noun(node.args[0]) == "bool" and isinstance(node.args[-1], ast.Constant)
        called = [self.methods[each].args.args[1:] for each in self._called(node, owner)]
        kinds = [
            (noun(each), {"int": NUMBERS.get(arg.arg, ""), "bool": "bool"}.get(text, ""))
            for args in called
            for arg, each in zip(args, node.args, strict=False)
            for text in [ast.unparse(arg).partition(": ")[2]]
        ]
        is_kept = bool(called) and all(goes(*each) for each in kinds)
        return is_kept or said(node, f"{CHANGES}|{ENTRIES}|{MANY}")

    def _called(self, node: ast.Call, owner: str) -> list[tuple[str, str]]:
        """Methods that a call may mean."""
        if not isinstance(node.func, ast.Attribute):
            return [each for each in self.methods if each == (getattr(node.func, "id", ""), "__init__")]
        of, name = ast.unparse(node.func.value), node.func.attr
        found = [each for each in self.methods if each[1] == name and (each[0] == owner) == (of == "self")]
        found = [each for each in found if each[0].endswith("Geometry") == (of == "self._geometry")]
        return [each for each in found if not self.methods[each].decorator_list]

    def _check_names(self, body: list[ast.stmt], names: set[str], fixed: set[str]) -> None:
        """A block reads what has a value; arguments, and in a loop all names around it, keep theirs."""
        names = set(names)
        for node in body:
            inner, around = set(names), fixed
            parts = [*ast.walk(getattr(node, "test", getattr(node, "iter", node)))]
            through = [each for each in (node, *parts) if isinstance(each, ast.For | ast.comprehension)]
            within = set().union(*(names_in(each.target) for each in through))
            need(not within & names, node, "names what has a value")
            words = [each for each in parts if isinstance(each, ast.Name)]
            read = {each.id for each in words if isinstance(each.ctx, ast.Load) and is_word(each.id)}
            stored = {each.id for each in words if isinstance(each.ctx, ast.Store)} - within
            need(read <= names | within, node, "reads what has no value")
            need(not stored & fixed, node, "gives another value")
            names |= stored
            if isinstance(node, ast.For):
                inner |= within
                around = inner if is_loop(node) else fixed
            for block in (getattr(node, "body", []), getattr(node, "orelse", [])):
                self._check_names(block if isinstance(block, list) else [], inner, around)

    # -- effects

    def _acts(self, owner: str, body: list[ast.stmt], deep: bool = True) -> list[str]:
        """What statements do, in order: require, of geometry as well, or what they store; one branch, or the
        other, in a row.
        """
        acts: list[str] = []
        for node in body:
            head = getattr(node, "test", getattr(node, "iter", node))
            calls = [each for each in ast.walk(head) if isinstance(each, ast.Call)]
            asked = chain(*(self._called(each, owner) for each in calls[isinstance(node, ast.Expr) :]))
            acts += ["require" for each in asked if self._asks(*each)]
            match node:
                case ast.If(body=one, orelse=other):
                    both = [self._acts(owner, each, deep) for each in (one, other)]
                    is_ordered = all(each == sorted(each, key="require".__ne__) for each in both)
                    acts += sorted([*both[0], *both[1]], key="require".__ne__ if is_ordered else lambda _: 0)
                case ast.For(body=inner):
                    acts += self._acts(owner, inner, deep)
                case ast.Expr(value=ast.Call() as call) if said(call.func, "require"):
                    acts.append("require")
                case ast.Expr(value=ast.Call() as call) if not said(call, GROWS):
                    called = self._called(call, owner) if deep else []
                    inner_acts = [self._acts(each[0], self.methods[each].body) for each in called]
                    acts += [act for each in inner_acts for act in each] or [ast.unparse(call)]
                case ast.Assign() | ast.AnnAssign() | ast.AugAssign():
                    targets = [each for each, _ in assigned(node) if not isinstance(each, ast.Name)]
                    acts += [ast.unparse(each) for each in targets]
        return acts

    def _asks(self, owner: str, name: str) -> bool:
        """Whether a method asks geometry, which has to be told of changes first."""
        requires = "require" in self._acts(owner, self.methods[owner, name].body)
        return owner.endswith("Geometry") or (name != "__init__" and requires)

    def _check_acts(self, owner: str, node: ast.FunctionDef) -> None:
        acts = self._acts(owner, node.body)
        first = min((at for at, each in enumerate(acts) if each != "require"), default=len(acts))
        need("require" not in acts[first:], node, "stores before a precondition")
        need(not acts or not node.decorator_list, node, "is read, and does something")
        is_question = not said(node.returns or node, "None|DiskRecord.*")
        need(not is_question or first == len(acts), node, "is a question, and stores")
        own = [re.fullmatch(OWN, each) for each in self._acts(owner, node.body, deep=False)]
        need(node.name != "__init__" or all(own), node, "changes what it is made of")
        if node.name in ("_begin", "_end", "_release"):
            need(all(re.fullmatch(f"{OF_PAIR}|{CHANGES}", each) for each in acts), node, "is of no pair")
        if node.name in ("_begin", "_end"):
            read = [ast.unparse(use) for use in ast.walk(node) if isinstance(use, ast.Attribute | ast.Call)]
            need(all(re.fullmatch(OF_PAIR + r"|self\.version|disk\.name", each) for each in read), node)
        for each in ast.walk(node):
            if is_loop(each):
                self._check_loop(owner, each)

    def _check_loop(self, owner: str, loop: Any) -> None:
        """A loop requires or does of each element what `LOOPS` says, and asks nothing else."""
        inside = [each for statement in loop.body for each in ast.walk(statement)]
        head = f"{ast.unparse(loop.target).strip('()')} in {ast.unparse(loop.iter)}"
        does = next((does for elements, does in LOOPS.items() if re.fullmatch(elements, head)), "")
        made = [each for each in inside if isinstance(each, ast.Assign | ast.AnnAssign | ast.AugAssign)]
        done = [each for each in made if not all(said(to, LOCAL) for to, _ in assigned(each))]
        done += [each for each in inside if isinstance(each, ast.Expr) and not said(each, GROWS)]
        within = list(chain(*map(ast.walk, done)))
        changes = any(not said(each, r"(require|other = ).+") for each in done)
        for each in inside:
            need(not is_loop(each) and not isinstance(each, ast.Return | ast.ListComp), each, "is in a loop")
            need(each not in done or said(each, does), each, "is of no element")
            if isinstance(each, ast.Call):
                called = [self.methods[name] for name in self._called(each, owner)]
                need(not any(map(is_loop, chain(*map(ast.walk, called)))), each, "loops in a loop")
                asks = any(self._asks(*name) for name in self._called(each, owner))
                is_made = getattr(each.func, "attr", "get") in ("get", "append", "extend")
                need(each in within or is_made or not (asks or changes), each, "asks what is of no element")
