"""Fit the phase, axis and radius of two twisted strands to their visible edges.

Strategy: every edge point must lie at the effective tube radius from the nearest point of its
strand's centreline. Least squares with Tukey weights; second differences of the phase and the axis
and first differences of the radius are penalised. The three weights of the penalties follow from
the data (restricted maximum likelihood, by the update of Fellner and Schall). Neighbouring edge
points err together, so the noise variance that enters is the one of independent points: the
residuals' variance times their correlation length along the edge.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_matrix, diags, hstack

from imaging.helix_edges import Edges
from imaging.helix_model import Model, basis, feet, positions

Array = np.ndarray
TUKEY = 4.685
STEPPED = ("phi", "mid", "R")  # may change abruptly: at a step, a kink, a tine
TAIL = 1.0  # degrees of freedom of those changes
LEAST_NOISE = 1e-3  # px
PENALISED = {"phi": 2, "mid": 2, "R": 1}  # block -> order of the difference
EVEN = 1e6  # largest ratio of a penalty to the information in the data


@dataclass(frozen=True)
class Prior:
    """How stiff each block of unknowns is: sum of weight * local * difference^2.

    Differences of the phase may be few and large, as where the link density steps: they are taken
    to follow Student's distribution with TAIL degrees of freedom, so that the local weight falls
    where a step is seen and the rest stays smooth.
    """

    differences: dict[str, Array]
    weights: dict[str, float] = field(default_factory=lambda: dict.fromkeys(PENALISED, 1.0))
    local: dict[str, Array] = field(default_factory=dict)

    def penalties(self) -> dict[str, Array]:
        """Return D' diag(weight * local) D of each block."""
        return {
            name: self.weights[name] * (d.T * self.local.get(name, 1.0)) @ d
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
            old = self.weights[name]
            free = max(len(d) - old * float(here @ spread), 1e-6 * len(d))
            weights[name] = min(free / max(float(here @ size), 1e-300), stiffest[name])
            if name in STEPPED:
                local[name] = (TAIL + 1) / (TAIL + weights[name] * (size + spread))
        return Prior(self.differences, weights, local)


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


def fit(
    model: Model,
    edges: Edges,
    held: dict[str, np.ndarray],
    prior: "Prior | None" = None,
    rounds: int = 6,
) -> Fit:
    """Fit a model to edges.

    Parameters
    ----------
    model : Model
        Where to start; must be within about a quarter turn.
    edges : Edges
    held : dict
        For each penalised block, the differences (bool) to penalise; False in gaps, so that what
        lies before and behind a tine is fitted apart.
    prior : Prior, optional
        Penalty weights to start from.
    rounds : int
        Gauss-Newton steps.
    """
    prior = prior or Prior({name: _differences(model, name, held[name]) for name in PENALISED})
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
            csr_matrix(np.eye(4)[edges.kind]),
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


def _penalised(
    model: Model, information: Array, target: Array, prior: Prior
) -> tuple[Array, Array, Prior]:
    """Solve the penalised normal equations, re-estimating the prior: beta, covariance, prior."""
    blocks = model.layout.blocks
    diagonal = np.diag(information)
    # Unseen stretches have neither data nor penalty: hold them where they are.
    ridge = 1e-9 * diagonal + 1e-9 * diagonal.mean()
    for _ in range(2):
        matrix = information + np.diag(ridge)
        for name, penalty in prior.penalties().items():
            matrix[blocks[name], blocks[name]] += penalty
        factor = cho_factor(matrix)
        covariance = cho_solve(factor, np.eye(len(matrix)))
        beta = cho_solve(factor, target + ridge * model.beta)
        stiffest = {name: EVEN * diagonal[blocks[name]].max() for name in PENALISED}
        prior = prior.updated(
            {name: beta[blocks[name]] for name in PENALISED},
            {name: covariance[blocks[name], blocks[name]] for name in PENALISED},
            stiffest,
        )
    return beta, covariance, prior


def _freedom(model: Model, information: Array, covariance: Array) -> dict[str, float]:
    share = np.einsum("ij,ji->i", covariance, information)
    return {name: float(share[where].sum()) for name, where in model.layout.blocks.items()}
