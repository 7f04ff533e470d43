"""Necessary conditions of critical points other than the goal, and of minima, checked on a box with Arb.

The equations are those of `deploy.theory.certify.contractors`, implemented independently from
docs/theory/propositions.md: the two share notation and the order of rows, but no code.

Ends of intervals are Arb balls; the library encloses each operation, nothing is rounded here. An interval (l,
h) means every x with x >= some number of l and x <= some number of h. A comparison of balls is true only if
it holds for all their numbers; each branch below is correct in either case.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from itertools import combinations

from deploy.theory.certify.certificate import GoalSet
from protocol.process.installation import missing_library

try:
    from flint import arb
except ModuleNotFoundError as error:
    raise missing_library("verifying", "python-flint", "certify") from error

Ends = tuple[arb, arb]

ZERO, INFINITE = arb(0), arb("+inf")


def add(a: Ends, b: Ends) -> Ends:

    return a[0] + b[0], a[1] + b[1]


def sub(a: Ends, b: Ends) -> Ends:

    return a[0] - b[1], a[1] - b[0]


def negative(a: Ends) -> Ends:

    return -a[1], -a[0]


def scale(w: Ends, b: Ends) -> Ends:
    """w b for w >= 0, whose upper end may be infinite, and finite b."""
    low = b[0] * w[0] if b[0] >= 0 else b[0] * w[1]
    high = b[1] * w[0] if b[1] <= 0 else b[1] * w[1]
    return low, high


def mul(a: Ends, b: Ends) -> Ends:
    """a b, both finite."""
    s, t, u, v = a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]
    return s.min(t).min(u.min(v)), s.max(t).max(u.max(v))


def square(a: Ends) -> Ends:

    s, t = a[0] * a[0], a[1] * a[1]
    return s.min(t) if a[0] > 0 or a[1] < 0 else ZERO, s.max(t)


def over(a: Ends, b: Ends) -> Ends:
    """a / b for b > 0 or b < 0, finite; the ends of a may be infinite."""
    if b[0] > 0:
        low = a[0] / b[1] if a[0] >= 0 else a[0] / b[0]
        high = a[1] / b[1] if a[1] <= 0 else a[1] / b[0]
        return low, high
    return negative(over(a, negative(b)))


def ball(a: Ends) -> arb:
    """A ball that contains a finite interval."""
    return a[0].union(a[1])


def middle(row: Sequence[arb]) -> float:
    """Approximate middle of a row."""
    return 0.5 * (float(row[0].mid()) + float(row[1].mid()))


def ends(x: arb) -> Ends:
    """A ball as an interval."""
    return x.lower(), x.upper()


def narrow(row: list[arb], new: Ends) -> bool:
    """Intersect [low, high] with `new` in place. False: certainly empty."""
    row[0] = max(row[0], new[0])
    row[1] = min(row[1], new[1])
    return not row[0] > row[1]


def rests(terms: list[Ends]) -> list[Ends]:
    """For each term the sum of all others."""
    before, after = [(ZERO, ZERO)], [(ZERO, ZERO)]
    for term in terms[:-1]:
        before.append(add(before[-1], term))
    for term in terms[:0:-1]:
        after.append(add(after[-1], term))
    return [add(one, other) for one, other in zip(before, reversed(after), strict=True)]


Rows = list[list[arb]]


class BoxConditions:
    """One box: rows of (b, lambda, kappa), narrowed in place. A method returns False if the box is empty."""

    def __init__(self, goals: GoalSet, rows: Rows) -> None:
        self.goals, self.rows = goals, rows
        p = self.p = len(goals.radii)
        self.n = 2 * p
        self.factors: list[tuple[int, int]] = [*combinations(range(p), 2), *((i, -1) for i in range(p))]
        self.contact = [_contact(goals, i, j) for i, j in self.factors]
        self.g = [arb(x) for goal in goals.goals for x in goal]

    def b(self, row: int) -> Ends:
        """Interval of a row."""
        low, high = self.rows[row]
        return low, high

    def weight(self, q: int) -> Ends:
        """lambda_q."""
        return self.b(self.n + q)

    def derive(self) -> bool:
        """Derive y, gamma, s, d, beta from b; narrow lambda by beta, and beta by lambda."""
        self.y = [sub(self.b(row), (g, g)) for row, g in enumerate(self.g)]
        self.gamma = _sum([square(y) for y in self.y])
        self.s = scale(self.gamma, self.b(len(self.rows) - 1))
        self.d: list[list[Ends]] = []
        self.beta: list[Ends] = []
        return all(self._derive(q, i, j) for q, (i, j) in enumerate(self.factors))

    def _derive(self, q: int, i: int, j: int) -> bool:
        d = [self.b(2 * i + a) if j < 0 else sub(self.b(2 * i + a), self.b(2 * j + a)) for a in (0, 1)]
        far = add(square(d[0]), square(d[1]))
        beta = [*(sub(self.contact[q], far) if j < 0 else sub(far, self.contact[q]))]
        if not narrow(beta, (ZERO, INFINITE)):
            return False
        row = self.rows[self.n + q]
        if not narrow(row, _quotient(self.s, beta)) or not narrow(beta, _quotient(self.s, row)):
            return False
        self.d.append(d)
        self.beta.append((beta[0], beta[1]))
        return True

    def distances(self) -> bool:
        """Narrow b to distances that beta allows."""
        for q, (i, j) in enumerate(self.factors):
            far = sub(self.contact[q], self.beta[q]) if j < 0 else add(self.contact[q], self.beta[q])
            d = self.d[q]
            for a in (0, 1):
                rest = sub(far, square(d[1 - a]))
                if rest[1] < 0:
                    return False
                most = rest[1].upper().sqrt()
                least = rest[0].sqrt() if rest[0] > 0 else ZERO
                new = [*d[a]]
                if not narrow(new, (-most, most)):
                    return False
                if new[0] > -least and not narrow(new, (least, INFINITE)):
                    return False
                if new[1] < least and not narrow(new, (-INFINITE, -least)):
                    return False
                d[a] = new[0], new[1]
                one, two = 2 * i + a, 2 * j + a
                if j < 0:
                    narrow(self.rows[one], d[a])
                else:
                    narrow(self.rows[one], add(self.b(two), d[a]))
                    narrow(self.rows[two], sub(self.b(one), d[a]))
        return not any(low > high for low, high in self.rows)

    def work(self) -> bool:
        """sum lambda_q w_q = gamma, and sum w_q / beta_q >= 1 / kappa."""
        work = [self._work(q, i, j) for q, (i, j) in enumerate(self.factors)]
        k = ZERO
        for w, beta in zip(work, self.beta, strict=True):
            if w[1] <= 0:
                k += w[1] / beta[1] if beta[1] > 0 else ZERO
            elif beta[0] > 0:
                k += w[1] / beta[0]
            else:
                k = INFINITE
                break
        if k * self.rows[-1][1] < 1:
            return False
        others = rests([scale(self.weight(q), w) for q, w in enumerate(work)])
        for q, w in enumerate(work):
            rest = sub(self.gamma, others[q])
            if w[0] > 0 or w[1] < 0:
                if not narrow(self.rows[self.n + q], over(rest, w)):
                    return False
            elif not narrow([*scale(self.weight(q), w)], rest):
                return False
        return True

    def _work(self, q: int, i: int, j: int) -> Ends:
        total = (ZERO, ZERO)
        for a in (0, 1):
            half = (self.g[2 * i + a] - (self.g[2 * j + a] if j >= 0 else ZERO)) / 2
            moved = square(sub(self.d[q][a], (half, half)))
            total = add(total, (moved[0] - half * half, moved[1] - half * half))
        return total if j >= 0 else negative(total)

    def balance(self, members: frozenset[int]) -> bool:
        """Force balance of a set of robots, axis by axis."""
        crossing = self._crossing(members)
        for a in (0, 1):
            forces = [self._force(q, a, sign) for q, sign in crossing]
            rows = [2 * i + a for i in members]
            pulls = [self.y[row] for row in rows]
            force = _sum(forces)
            for row, rest in zip(rows, rests(pulls), strict=True):
                new = [*self.y[row]]
                if not narrow(new, sub(force, rest)):
                    return False
                self.y[row] = new[0], new[1]
                if not narrow(self.rows[row], add(self.y[row], (self.g[row], self.g[row]))):
                    return False
            pull = _sum([self.y[row] for row in rows])
            for (q, sign), rest in zip(crossing, rests(forces), strict=True):
                d = self.d[q][a] if sign > 0 else negative(self.d[q][a])
                if (d[0] > 0 or d[1] < 0) and not narrow(self.rows[self.n + q], over(sub(pull, rest), d)):
                    return False
        return True

    def _crossing(self, members: frozenset[int]) -> list[tuple[int, int]]:
        found = []
        for q, (i, j) in enumerate(self.factors):
            sign = -(i in members) if j < 0 else (i in members) - (j in members)
            if sign:
                found.append((q, sign))
        return found

    def _force(self, q: int, a: int, sign: int) -> Ends:
        force = scale(self.weight(q), self.d[q][a])
        return force if sign > 0 else negative(force)

    def torque(self, members: frozenset[int]) -> bool:
        """sum_C b x g = sum over crossing pairs lambda_ij b_i x b_j."""
        total = (ZERO, ZERO)
        for q, sign in self._crossing(members):
            i, j = self.factors[q]
            if j >= 0:
                turn = scale(
                    self.weight(q),
                    sub(mul(self.b(2 * i), self.b(2 * j + 1)), mul(self.b(2 * i + 1), self.b(2 * j))),
                )
                total = add(total, turn if sign > 0 else negative(turn))
        arms = {2 * i: self.g[2 * i + 1] for i in members} | {2 * i + 1: -self.g[2 * i] for i in members}
        return self._linear(arms, total)

    def upright(self) -> bool:
        """sum b . g >= 0; otherwise rotating the whole fleet descends."""
        return self._linear(dict(enumerate(self.g)), (ZERO, INFINITE))

    def _linear(self, factors: dict[int, arb], value: Ends) -> bool:
        """Narrow b by the sum of some rows, each times its factor, which is in `value`."""
        terms = [mul(self.b(row), (factor, factor)) for row, factor in factors.items()]
        for (row, factor), rest in zip(factors.items(), rests(terms), strict=True):
            left = sub(value, rest)
            if factor == 0:
                if left[0] > 0 or left[1] < 0:
                    return False
            elif not narrow(self.rows[row], over(left, (factor, factor))):
                return False
        return True

    def stiffness(self, q: int) -> arb:
        """Upper bound of lambda_q / beta_q; infinite if contact is possible."""
        beta = self.beta[q][0]
        if not beta > 0:
            return INFINITE
        return (self.rows[self.n + q][1] / beta).min(self.s[1] / (beta * beta))


def _contact(goals: GoalSet, i: int, j: int) -> Ends:
    other = goals.radii[j] if j >= 0 else None
    reach = arb(goals.workspace) - arb(goals.radii[i]) if other is None else arb(goals.radii[i]) + arb(other)
    return square((reach, reach))


def _quotient(s: Ends, by: list[arb]) -> Ends:
    low = s[0] / by[1] if by[1] > 0 and by[1] < INFINITE else ZERO
    high = s[1] / by[0] if by[0] > 0 else INFINITE
    return low, high


def _sum(terms: list[Ends]) -> Ends:
    return reduce(add, terms, (ZERO, ZERO))


def whole(goals: GoalSet, kappa: Ends) -> Rows:
    """Every free configuration, every lambda, these kappa."""
    rows: Rows = []
    for radius in goals.radii:
        reach = arb(goals.workspace) - arb(radius)
        rows += [[-reach, reach], [-reach, reach]]
    p = len(goals.radii)
    rows += [[ZERO, INFINITE] for _ in range(p * (p + 1) // 2)]
    return [*rows, [kappa[0], kappa[1]]]
