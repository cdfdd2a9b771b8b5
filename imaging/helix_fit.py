"""Fit the phase, axis and radius of two twisted strands to their visible edges.

Strategy: every edge point must lie at the effective tube radius from the nearest point of its
strand's centreline. Least squares with Tukey weights; second differences of the phase and the axis
and first differences of the radius are penalised. The three weights of the penalties follow from
the data (restricted maximum likelihood, by the update of Fellner and Schall). Neighbouring edge
points err together, so the noise variance that enters is the one of independent points: the
residuals' variance times their correlation length along the edge.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.linalg import cholesky
from scipy.linalg.lapack import dpotri
from scipy.ndimage import minimum_filter1d
from scipy.sparse import csr_matrix, diags, hstack
from scipy.special import digamma, gammaln

from imaging.helix_edges import OUTER, Edges
from imaging.helix_model import Model, basis, feet, positions

Array = np.ndarray
TUKEY = 4.685
ABRUPT, SMOOTH = 1.0, np.inf  # degrees of freedom of those changes: few and large, or many
BLIND = 2  # knots by which the place of an abrupt change may be missed
SHADED = 0.2  # px; by which light from one side may move the two edges of a strand apart
LEAST_NOISE = 1e-3  # px
UPDATES = 4  # of the prior, each step
PENALISED = {"phi": 2, "mid": 2, "R": 1}  # block -> order of the difference
EVEN = 1e6  # largest ratio of a penalty to the information in the data


@dataclass(frozen=True)
class Prior:
    """How stiff each block of unknowns is: sum of weight * local * difference^2.

    There is one weight for each block and each ``group`` of differences, the stretches between
    gaps: what a tine has combed need not be as even as what it has not.

    Differences may be few and large, as where the link density steps: they are taken to follow
    Student's distribution with ABRUPT degrees of freedom, so that the local weight falls where a
    step is seen and the rest stays smooth. Those of the phase have ``tail`` degrees of freedom:
    where the link density varies smoothly, a Gaussian's (SMOOTH) describe them.
    """

    differences: dict[str, Array]
    groups: dict[str, np.ndarray]
    tail: float = ABRUPT
    weights: dict[str, Array] = field(default_factory=dict)
    local: dict[str, Array] = field(default_factory=dict)

    def penalties(self) -> dict[str, Array]:
        """Return D' diag(weight * local) D of each block."""
        return {
            name: (d.T * (self.weights.get(name, 1.0) * self.local.get(name, 1.0))) @ d
            for name, d in self.differences.items()
        }

    def updated(
        self,
        beta: dict[str, Array],
        covariance: dict[str, Array],
        stiffest: dict[str, float],
    ) -> "Prior":
        """Re-estimate the weights from the unknowns (Fellner-Schall; expectation of Student's).

        w <- (m - w tr(V S)) / (beta' S beta), Wood & Fasiolo, Biometrics 73 (2017).
        """
        weights, local = {}, dict(self.local)
        for name, d in self.differences.items():
            here = self.local.get(name, np.ones(len(d)))
            spread = np.einsum("ij,jk,ik->i", d, covariance[name], d, optimize=True)
            size = (d @ beta[name]) ** 2
            group = self.groups[name]
            count, held, seen = (
                np.bincount(group, value)
                for value in (
                    np.ones(len(d)),
                    self.weights.get(name, 1.0) * here * spread,
                    here * size,
                )
            )
            free = np.maximum(count - held, 1e-6 * count)
            weight = np.minimum(free / np.maximum(seen, 1e-300), stiffest[name])
            weights[name] = weight[group]
            tail = self.tails[name]
            if np.isfinite(tail):
                local[name] = (tail + 1) / (tail + weights[name] * (size + spread))
        return replace(self, weights=weights, local=local)

    @property
    def tails(self) -> dict[str, float]:
        """Degrees of freedom of each block's differences."""
        return dict.fromkeys(PENALISED, ABRUPT) | {"phi": self.tail}

    def blunted(self) -> "Prior":
        """Return the prior with abrupt changes possible wherever one is within BLIND knots.

        The local weights say where a change is as if its place were known.
        """
        size = 2 * BLIND + 1
        local = {name: minimum_filter1d(here, size) for name, here in self.local.items()}
        return replace(self, local=local)


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
    blur : float
        Width (standard deviation) of the edges found [px].
    residual : (n,) array
        Distance of every edge point from the fitted outline [px].
    """

    model: Model
    covariance: Array
    prior: Prior
    freedom: dict[str, float]
    noise: float
    correlation: float
    blur: float
    residual: Array


def fit_best(smooth: Fit, edges: Edges, rounds: int = 6) -> Fit:
    """Fit again, with smooth and with abrupt changes of phase; return the more probable fit."""
    smooth = fit(smooth.model, edges, smooth.prior, rounds)
    # From a slack prior, or the smooth fit would hold the local weights alike.
    abrupt = fit(
        smooth.model,
        edges,
        Prior(smooth.prior.differences, smooth.prior.groups, ABRUPT),
        2 * rounds,
    )
    _, _, precision = _noise(smooth.residual, edges)
    gain = evidence(abrupt, edges, precision) - evidence(smooth, edges, precision)
    return abrupt if gain > 0 else smooth


def first_prior(model: Model, held: dict[str, np.ndarray]) -> Prior:
    """Return the prior to start from.

    Parameters
    ----------
    model : Model
    held : dict
        For each penalised block, the differences (bool) to penalise; False in gaps, so that what
        lies before and behind a tine is fitted apart.
    """
    stiff = {name: _differences(model, name, held[name]) for name in PENALISED}
    groups = {name: _groups(held[name]) for name in PENALISED}
    return Prior(stiff, groups, SMOOTH)


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
        noise, correlation, precision = _noise(residual, edges)
        information = (design.T @ diags(precision) @ design).toarray()
        target = design.T @ (precision * residual) + information @ model.beta
        beta, covariance, prior = _penalised(model, information, target, prior)
        model = model.moved(beta)
    freedom = _freedom(model, information, covariance)
    blur = 0.4 / float(np.median(edges.steepness))
    residual, _ = _linearised(model, edges)
    return Fit(model, covariance, prior, freedom, noise, correlation, blur, residual)


def misfit(fitted: Fit, edges: Edges, s: Array, reach: float) -> Array:
    """How much further than typical the outer edges within ``reach`` of ``s`` miss the outline.

    Mean distance over the one that Gaussian noise would give, at least 1: where the strands are
    not as the model has them, as where they leave the picture's plane, its errors grow alike.
    """
    outer = edges.border == OUTER
    place, size = edges.s[outer], np.abs(fitted.residual[outer])
    total = np.concatenate([[0.0], np.cumsum(size)])
    first, last = (np.searchsorted(place, s + side * reach) for side in (-1, 1))
    mean = (total[last] - total[first]) / np.maximum(last - first, 1)
    return np.maximum(mean / (np.sqrt(2 / np.pi) * 1.4826 * np.median(size)), 1.0)


def widened(fitted: Fit, edges: Edges) -> Fit:
    """Return a fit whose covariance holds that the places of abrupt changes are not known."""
    residual, design = _linearised(fitted.model, edges)
    _, _, precision = _noise(residual, edges)
    information = (design.T @ diags(precision) @ design).toarray()
    wide = _inverse(_stiffened(fitted.model, information, fitted.prior.blunted()))
    return replace(fitted, covariance=wide)


def _linearised(model: Model, edges: Edges) -> tuple[Array, csr_matrix]:
    """How far edges lie outside the model's outline, and the derivative of the outline (n, p)."""
    table, strand = model.table, edges.strand
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
    design = hstack(
        [
            diags(e * v.R * (along * v.lean * c - across * d)) @ basis(model.layout.phi, s),
            diags(across) @ basis(model.layout.mid, s)
            + diags(turn) @ basis(model.layout.mid, s, 1),
            diags(e * (across * c + along * v.lean * d)) @ basis(model.layout.R, s),
            csr_matrix((e * v.R * along * d)[:, None] * model.leaning(s)),
            csr_matrix(np.eye(8)[edges.kind]),
        ],
        format="csr",
    )
    return distance - model.part("radii")[edges.kind], design


def _noise(residual: Array, edges: Edges) -> tuple[float, float, Array]:
    """Robust sd of a residual, mean correlation length, weight of each edge point.

    Edges against the background and edges in contact are weighted by their own scatter: shading
    moves the latter more.
    """
    precision = np.zeros(len(residual))
    lengths = []
    for border in np.unique(edges.border):
        own = edges.border == border
        noise = max(1.4826 * float(np.median(np.abs(residual[own]))), LEAST_NOISE)
        robust = (1 - np.clip(np.abs(residual) / (TUKEY * noise), 0, 1) ** 2) ** 2
        tracks = [own & (edges.track == k) for k in range(4)]
        length = float(np.mean([_correlation(residual[k], robust[k] > 0.05) for k in tracks]))
        precision[own] = robust[own] / (noise**2 * length)
        lengths.append(length)
    noise = 1.4826 * float(np.median(np.abs(residual)))
    return noise, float(np.mean(lengths)), precision


def _correlation(residual: Array, good: np.ndarray) -> float:
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


def _differences(model: Model, name: str, held: np.ndarray) -> Array:
    """Differences D (m, size) of one block of unknowns, those not ``held`` left out."""
    size = model.layout.blocks[name].stop - model.layout.blocks[name].start
    return np.diff(np.eye(size), n=PENALISED[name], axis=0)[held]


def _groups(held: np.ndarray) -> np.ndarray:
    """Return the number of the run that each held difference belongs to."""
    return np.unique(np.cumsum(~held)[held], return_inverse=True)[1]


def _penalised(
    model: Model, information: Array, target: Array, prior: Prior
) -> tuple[Array, Array, Prior]:
    """Solve the penalised normal equations, re-estimating the prior: beta, covariance, prior."""
    blocks = model.layout.blocks
    diagonal = np.diag(information)
    ridge = _ridge(information)
    for _ in range(UPDATES):
        covariance = _inverse(_stiffened(model, information, prior))
        beta = covariance @ (target + ridge * model.beta)
        stiffest = {name: EVEN * diagonal[blocks[name]].max() for name in PENALISED}
        prior = prior.updated(
            {name: beta[blocks[name]] for name in PENALISED},
            {name: covariance[blocks[name], blocks[name]] for name in PENALISED},
            stiffest,
        )
    return beta, covariance, prior


def _ridge(information: Array) -> Array:
    """Hold where they are unseen stretches, which have neither data nor penalty."""
    diagonal = np.diag(information)
    return 1e-9 * diagonal + 1e-9 * diagonal.mean()


def _stiffened(model: Model, information: Array, prior: Prior) -> Array:
    """Add the prior to the information in the data."""
    blocks = model.layout.blocks
    matrix = information + np.diag(_ridge(information))
    for name, penalty in prior.penalties().items():
        matrix[blocks[name], blocks[name]] += penalty
    sides = np.kron(np.eye(4), [[1.0, -1.0], [-1.0, 1.0]])
    matrix[blocks["radii"], blocks["radii"]] += sides / (2 * SHADED**2)
    return matrix


def _inverse(matrix: Array) -> Array:
    """Inverse of a symmetric positive definite matrix."""
    lower = np.tril(dpotri(cholesky(matrix, lower=True), lower=1)[0])
    return lower + np.tril(lower, -1).T


def evidence(fitted: Fit, edges: Edges, precision: Array) -> float:
    """Log probability of the edges under the prior (a lower bound), but for a constant.

    Unknowns are Gaussian; local weights follow Gamma(n/2, n/2), which makes the differences
    Student's with n degrees of freedom (Tipping & Lawrence, Neurocomputing 69 (2005)). The bound
    holds for any mean and covariance of the unknowns, so fits may be compared at one precision.
    """
    model, covariance, prior = fitted.model, fitted.covariance, fitted.prior
    residual, design = _linearised(model, edges)
    information = (design.T @ diags(precision) @ design).toarray()
    bound = -0.5 * float(precision @ residual**2) - 0.5 * float(np.sum(covariance * information))
    bound += 0.5 * float(np.linalg.slogdet(covariance)[1])
    for name, d in prior.differences.items():
        where = model.layout.blocks[name]
        spread = np.einsum("ij,jk,ik->i", d, covariance[where, where], d, optimize=True)
        weight, tail = prior.weights[name], prior.tails[name]
        size = weight * ((d @ model.beta[where]) ** 2 + spread)
        bound += float(np.sum(0.5 * np.log(weight) + _gain(size, tail)))
        # Where the prior alone decides, the bound is loose by as much as at size 1.
        undecided = float(np.sum(weight * prior.local.get(name, 1.0) * spread))
        bound -= undecided * float(_gain(np.array(1.0), tail) - _gain(np.array(1.0), SMOOTH))
    return bound


def _gain(size: Array, tail: float) -> Array:
    """E[log(u)/2 - u size/2] - KL(u) of local weights u with their best distribution."""
    if np.isinf(tail):
        return -0.5 * size
    a, b, a0 = (tail + 1) / 2, (tail + size) / 2, tail / 2
    log_u = digamma(a) - np.log(b)
    apart = (
        (a - a0) * digamma(a) - gammaln(a) + gammaln(a0) + a0 * np.log(b / a0) + a * (a0 / b - 1)
    )
    return 0.5 * log_u - 0.5 * a / b * size - apart


def _freedom(model: Model, information: Array, covariance: Array) -> dict[str, float]:
    share = np.einsum("ij,ji->i", covariance, information)
    return {name: float(share[where].sum()) for name, where in model.layout.blocks.items()}
