"""Contractor of distances: beta_q >= 0, beta_q = |d_q|^2 - rho_q^2, lambda_q beta_q = kappa gamma."""

from __future__ import annotations

from deploy.theory.certify.boxes.intervals import add, down, mul, root_above, root_below, square, sub, up
from deploy.theory.certify.boxes.kernel import compiled
from deploy.theory.certify.boxes.scene import Box, Derived, Scene, inverted, lower, upper


@compiled
def enclose(scene: Scene, box: Box, out: Derived) -> bool:
    """Derive y, gamma, s, d_q, beta_q from b and kappa; contract lambda. False: the box holds nothing."""
    n, last = len(scene.goals), len(box) - 1
    gamma = (0.0, 0.0)
    for row in range(n):
        y = sub((box[row, 0], box[row, 1]), (scene.goals[row], scene.goals[row]))
        out.pull[row] = y
        gamma = add(gamma, square(y))
    s = mul((box[last, 0], box[last, 1]), (max(0.0, gamma[0]), gamma[1]))
    out.total[0] = max(0.0, gamma[0]), gamma[1]
    out.total[1] = max(0.0, s[0]), s[1]
    for q in range(len(scene.first)):
        _separation(scene, box, out, q)
        if out.beta[q, 0] > out.beta[q, 1]:
            return False
        if out.beta[q, 0] > 0.0:
            upper(box, n + q, up(out.total[1, 1] / out.beta[q, 0]))
        if out.beta[q, 1] > 0.0:
            lower(box, n + q, down(out.total[1, 0] / out.beta[q, 1]))
        if box[n + q, 0] > box[n + q, 1]:
            return False
        if box[n + q, 0] > 0.0:
            upper(out.beta, q, up(out.total[1, 1] / box[n + q, 0]))
        if box[n + q, 1] > 0.0:
            lower(out.beta, q, down(out.total[1, 0] / box[n + q, 1]))
        if out.beta[q, 0] > out.beta[q, 1]:
            return False
    return True


@compiled
def _separation(scene: Scene, box: Box, out: Derived, q: int) -> None:
    i, j = scene.first[q], scene.second[q]
    contact = (scene.contact[q, 0], scene.contact[q, 1])
    for a in range(2):
        own = (box[2 * i + a, 0], box[2 * i + a, 1])
        out.apart[q, a] = own if j < 0 else sub(own, (box[2 * j + a, 0], box[2 * j + a, 1]))
    far = add(
        square((out.apart[q, 0, 0], out.apart[q, 0, 1])), square((out.apart[q, 1, 0], out.apart[q, 1, 1]))
    )
    beta = sub(contact, far) if j < 0 else sub(far, contact)
    out.beta[q] = max(0.0, beta[0]), beta[1]


@compiled
def contract_distances(scene: Scene, box: Box, out: Derived) -> bool:
    """Contract b to where every beta_q can have the values that it was enclosed in."""
    for q in range(len(scene.first)):
        i, j = scene.first[q], scene.second[q]
        contact = (scene.contact[q, 0], scene.contact[q, 1])
        beta = (out.beta[q, 0], out.beta[q, 1])
        far = sub(contact, beta) if j < 0 else add(contact, beta)
        for a in range(2):
            other = square((out.apart[q, 1 - a, 0], out.apart[q, 1 - a, 1]))
            rest = sub(far, other)
            if rest[1] < 0.0:
                return False
            most, least = root_above(rest[1]), root_below(rest[0])
            low, high = max(out.apart[q, a, 0], -most), min(out.apart[q, a, 1], most)
            if low > -least:
                low = max(low, least)
            if high < least:
                high = min(high, -least)
            if low > high:
                return False
            out.apart[q, a] = low, high
            if j < 0:
                lower(box, 2 * i + a, low)
                upper(box, 2 * i + a, high)
            else:
                one, two = 2 * i + a, 2 * j + a
                moved = add((box[two, 0], box[two, 1]), (low, high))
                lower(box, one, moved[0])
                upper(box, one, moved[1])
                moved = sub((box[one, 0], box[one, 1]), (low, high))
                lower(box, two, moved[0])
                upper(box, two, moved[1])
    return not inverted(box, len(scene.goals))
