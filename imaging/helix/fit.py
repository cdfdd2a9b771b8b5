"""Fit the phase, axis, radius and lean of two twisted strands to their visible edges.

Strategy: every edge point must lie at the effective tube radius from the nearest point of its
strand's centreline. Least squares with Tukey weights; second differences of the phase and the axis
and first differences of the radius and the lean are penalised, with weights from the data
(`imaging.helix.prior`). Neighbouring edge points err together, so the noise variance that enters is
the one of independent points: the residuals' variance nearby times their correlation length.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix, diags, hstack

from imaging.helix.chain import inverse, solve
from imaging.helix.edges import OUTER, Edges
from imaging.helix.model import Model, feet, positions
from imaging.helix.prior import ABRUPT, PENALISED, STRAIGHTER, Prior, first_prior
from imaging.helix.splines import basis

Array = np.ndarray
Mask = np.ndarray
TUKEY = 4.685
RUN = 10.0  # edge points along which shading errs alike
FACING = 0.5  # sine of the lean that a photographer may leave
LEAST_NOISE = 1e-3  # px
LONE = 20.0  # times the typical distance from the outline; more counts as this much
UPDATES = 4  # of the prior, each step
EVEN = 1e6  # largest ratio of a penalty to the information in the data


@dataclass(frozen=True)
class Fit:
    """A fitted model with what is needed for its uncertainty.

    Attributes
    ----------
    model : Model
    covariance : (p, p) array
        Posterior covariance of the unknowns.
    prior : Prior
        Penalties, as estimated.
    freedom : dict
        Effective number of free parameters of each block.
    noise : float
        Robust standard deviation of one edge point [px].
    correlation : float
        Number of neighbouring edge points that err as one.
    residual : (n,) array
        Distance of every edge point from the fitted outline [px].
    """

    model: Model
    covariance: Array
    prior: Prior
    freedom: dict[str, float]
    noise: float
    correlation: float
    residual: Array


def fit_best(first: Fit, edges: Edges, held: dict[str, Mask], rounds: int = 6) -> Fit:
    """Fit again, with smooth and with abrupt changes of phase; return the more probable fit.

    Smooth changes may then be smoother here than there; many weights would not be compared fairly
    with one. How much the lean may vary is taken anew from the bends of the axis fitted first.
    """
    old = first.prior
    prior = replace(first_prior(first.model, held), seen=old.seen, shading=old.shading)
    smooth = fit(first.model, edges, replace(prior, weights=first.prior.weights), rounds)
    # From a slack prior, or the smooth fit would hold the local weights alike.
    abrupt = fit(smooth.model, edges, prior.fresh(ABRUPT), 2 * rounds)
    precision = _noise(smooth.model, smooth.residual, edges)[2]
    gain = evidence(abrupt, edges, precision) - evidence(smooth, edges, precision)
    if gain > 0:
        return abrupt
    return fit(smooth.model, edges, smooth.prior.localised(smooth.model), rounds)


def fit(model: Model, edges: Edges, prior: Prior, rounds: int = 6) -> Fit:
    """Fit a model to edges.

    Parameters
    ----------
    model : Model
        Where to start; must be within about a quarter turn.
    edges : Edges
    prior : Prior
        Differences to penalise, and the penalty weights to start from.
    rounds : int
        Gauss-Newton steps.
    """
    for _ in range(rounds):
        residual, design = _linearised(model, edges)
        noise, correlation, precision = _noise(model, residual, edges)
        information = (design.T @ diags(precision) @ design).toarray()
        target = design.T @ (precision * residual) + information @ model.beta
        if prior.seen is not None:
            target[model.layout.blocks["mid"]] += np.prod(prior.seen, axis=0)
        beta, prior = _penalised(model, information, target, prior)
        model = model.moved(beta)
    covariance = inverse(_stiffened(model, _held(model, information, prior), prior))
    freedom = _freedom(model, information, covariance)
    residual, _ = _linearised(model, edges)
    return Fit(model, covariance, prior, freedom, noise, correlation, residual)


def miss(residual: Array, edges: Edges, s: Array, reach: float) -> Array:
    """Mean distance [px] of the outer edges within ``reach`` of ``s`` from the outline."""
    outer = edges.border == OUTER
    place, size = edges.s[outer], np.abs(residual[outer])
    if not size.size:
        return np.zeros(len(s))
    total = np.concatenate([[0.0], np.cumsum(np.minimum(size, LONE * np.median(size)))])
    first, last = (np.searchsorted(place, s + side * reach) for side in (-1, 1))
    return (total[last] - total[first]) / np.maximum(last - first, 1)


def worse(model: Model, residual: Array, edges: Edges, s: Array) -> Array:
    """How many times more than typical the outer edges near ``s`` miss the outline, at least 1."""
    reach = model.pitch / 4
    typical = float(np.median(miss(residual, edges, edges.s, reach)))
    return np.maximum(miss(residual, edges, s, reach) / max(typical, LEAST_NOISE), 1.0)


def widened(fitted: Fit, edges: Edges) -> Fit:
    """Return a fit whose covariance holds that the places of abrupt changes are not known."""
    residual, design = _linearised(fitted.model, edges)
    precision = _noise(fitted.model, residual, edges)[2]
    information = (design.T @ diags(precision) @ design).toarray()
    held = _held(fitted.model, information, fitted.prior)
    wide = _stiffened(fitted.model, held, fitted.prior.blunted())
    return replace(fitted, covariance=inverse(wide))


def evidence(fitted: Fit, edges: Edges, precision: Array) -> float:
    """Log probability of the edges under the prior (a lower bound), but for a constant.

    The bound holds for any mean and covariance of the unknowns, so fits may be compared at one
    precision.
    """
    model, covariance = fitted.model, fitted.covariance
    residual, design = _linearised(model, edges)
    information = (design.T @ diags(precision) @ design).toarray()
    bound = -0.5 * float(precision @ residual**2) - 0.5 * float(np.sum(covariance * information))
    bound += 0.5 * float(np.linalg.slogdet(covariance)[1])
    return bound + fitted.prior.expected(*_penalised_parts(model, model.beta, covariance))


def _linearised(model: Model, edges: Edges) -> tuple[Array, csr_matrix]:
    """How far edges lie outside the model's outline, and the derivative of the outline (n, p)."""
    table, strand, layout = model.table, edges.strand, model.layout
    s = feet(model, strand, edges.s, edges.points)
    out = edges.points - positions(model, strand, s)
    distance = np.linalg.norm(out, axis=1)
    out /= np.maximum(distance, 1e-9)[:, None]
    v = model.at(s)
    tangent = np.column_stack([np.interp(s, table.s, table.tangents[:, i]) for i in (0, 1)])
    along = (out * tangent).sum(axis=1)
    across = out[:, 0] * tangent[:, 1] - out[:, 1] * tangent[:, 0]
    e = 1.0 - 2.0 * strand
    c, d = np.cos(v.phi), np.sin(v.phi)
    turn = e * v.R * (across * v.lean * d - along * c)
    leaning = e * v.R * along * d
    design = hstack(
        [
            diags(e * v.R * (along * v.lean * c - across * d)) @ basis(layout.phi, s),
            diags(across) @ basis(layout.mid, s) + diags(turn) @ basis(layout.mid, s, 1),
            diags(e * (across * c + along * v.lean * d)) @ basis(layout.R, s),
            diags(leaning) @ basis(layout.lean, s),
            csr_matrix(leaning[:, None] * model.sight(s)),
            csr_matrix(np.eye(8)[edges.kind]),
        ],
        format="csr",
    )
    return distance - model.part("radii")[edges.kind], design


def _noise(model: Model, residual: Array, edges: Edges) -> tuple[float, float, Array]:
    """Robust sd of a residual, mean correlation length, weight of each edge point.

    Edges against the background and edges in contact are weighted by their own scatter: shading
    moves the latter more. Where outer edges miss the outline by more than typical, within a
    quarter of a pitch, all edges are taken to be that much worse.
    """
    precision = np.zeros(len(residual))
    off = worse(model, residual, edges, edges.s)
    lengths = []
    for border in np.unique(edges.border):
        own = edges.border == border
        typical = max(1.4826 * float(np.median(np.abs(residual[own]))), LEAST_NOISE)
        scatter = np.maximum(typical, edges.doubt) * off
        robust = (1 - np.clip(np.abs(residual) / (TUKEY * scatter), 0, 1) ** 2) ** 2
        tracks = [own & (edges.track == k) for k in range(4)]
        length = float(np.mean([_correlation(residual[k], robust[k] > 0.05) for k in tracks]))
        # What shading leaves is alike along an edge.
        length = max(length, RUN if edges.doubt[own].max() > typical else 1.0)
        precision[own] = (robust / (scatter**2 * length))[own]
        lengths.append(length)
    noise = 1.4826 * float(np.median(np.abs(residual)))
    return noise, float(np.mean(lengths)), precision


def _correlation(residual: Array, good: Mask) -> float:
    """1 + 2 sum of the autocorrelations of a series until they vanish; 1 for white noise."""
    x = residual[good]
    n = len(x)
    if n < 50:
        return 1.0
    x = x - x.mean()
    spectrum = np.abs(np.fft.rfft(x, 2 * n)) ** 2
    rho = np.fft.irfft(spectrum)[: n // 4]
    rho = rho / rho[0]
    end = int(np.argmax(rho < 2 / np.sqrt(n))) or len(rho)
    return float(1 + 2 * rho[1:end].sum())


def _penalised(
    model: Model, information: Array, target: Array, prior: Prior
) -> tuple[Array, Prior]:
    """Solve the penalised normal equations, re-estimating the prior: unknowns, prior."""
    layout, diagonal = model.layout, np.diag(information)
    held = _held(model, information, prior)
    target = target + _ridge(information) * model.beta
    stiffest = {name: EVEN * float(diagonal[layout.blocks[name]].max()) for name in PENALISED}
    stiffest["lean"] = STRAIGHTER
    for _ in range(UPDATES):
        matrix = _stiffened(model, held, prior)
        beta, near = solve(matrix, target, layout.cells, layout.shared)
        prior = prior.updated(*_penalised_parts(model, beta, near), stiffest)
    return beta, prior


def _penalised_parts(
    model: Model, beta: Array, covariance: Array
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Unknowns and covariance of each penalised block."""
    where = {name: model.layout.blocks[name] for name in PENALISED}
    return {k: beta[w] for k, w in where.items()}, {k: covariance[w, w] for k, w in where.items()}


def _ridge(information: Array) -> Array:
    """Hold where they are unseen stretches, which have neither data nor penalty."""
    diagonal = np.diag(information)
    return 1e-9 * diagonal + 1e-9 * diagonal.mean()


def _held(model: Model, information: Array, prior: Prior) -> Array:
    """Add to the information in the data what is known beforehand but for smoothness."""
    blocks = model.layout.blocks
    matrix = information + np.diag(_ridge(information))
    if prior.seen is not None:
        matrix[blocks["mid"], blocks["mid"]] += np.diag(prior.seen[0])
    facing = blocks["lean"]
    matrix[facing, facing] += np.eye(facing.stop - facing.start) / FACING**2
    matrix[blocks["radii"], blocks["radii"]] += np.kron(np.eye(2), _shading(*prior.shading))
    return matrix


def _shading(alike: float, apart: float) -> Array:
    """Return what is known of the effective radii a-, a+, b-, b+ against one kind of border.

    Light from one side moves the edges of both strands alike. Moved apart, as if strand a lay more
    to the right wherever it is seen, they would look like a pair that leans.
    """
    both, one = np.array([-1.0, 1, -1, 1]) / 2, np.array([-1.0, 1, 1, -1]) / 2
    return np.outer(both, both) / alike**2 + np.outer(one, one) / apart**2


def _stiffened(model: Model, held: Array, prior: Prior) -> Array:
    """Add smoothness."""
    matrix = held.copy()
    for name, penalty in prior.penalties().items():
        where = model.layout.blocks[name]
        matrix[where, where] += penalty
    return matrix


def _freedom(model: Model, information: Array, covariance: Array) -> dict[str, float]:
    share = np.einsum("ij,ji->i", covariance, information)
    return {name: float(share[where].sum()) for name, where in model.layout.blocks.items()}
