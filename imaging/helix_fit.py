"""Fit the phase, axis and radius of two twisted strands to their visible edges.

Strategy: every edge point must lie at the effective tube radius from the nearest point of its
strand's centreline. Least squares with Tukey weights; second differences of the phase and the axis
and first differences of the radius are penalised. The three weights of the penalties follow from
the data (restricted maximum likelihood, by the update of Fellner and Schall). Neighbouring edge
points err together, so the noise variance that enters is the one of independent points: the
residuals' variance times their correlation length along the edge.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_matrix, diags, hstack

from imaging.helix_edges import Edges
from imaging.helix_model import Model, basis, feet, positions

Array = NDArray[np.float64]
TUKEY = 4.685
PENALISED = {"phi": 2, "mid": 2, "R": 1}  # block -> order of the difference
EVEN = 1e6  # largest ratio of a penalty to the information in the data


@dataclass(frozen=True)
class Fit:
    """A fitted model with what is needed for its uncertainty.

    Attributes
    ----------
    model : Model
    covariance : (p, p) array
        Posterior covariance of the unknowns.
    weights : dict
        Penalty weight of each block.
    freedom : dict
        Effective number of free parameters of each block.
    noise : float
        Robust standard deviation of one edge point [px].
    correlation : float
        Number of neighbouring edge points that err as one.
    blur : float
        Width (standard deviation) of the edges found [px].
    """

    model: Model
    covariance: Array
    weights: dict[str, float]
    freedom: dict[str, float]
    noise: float
    correlation: float
    blur: float


def fit(
    model: Model,
    edges: Edges,
    held: dict[str, NDArray[np.bool_]],
    weights: dict[str, float] | None = None,
    rounds: int = 8,
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
    weights : dict, optional
        Penalty weights to start from.
    rounds : int
        Gauss-Newton steps.
    """
    differences = {name: _penalty(model, name, held[name]) for name in PENALISED}
    weights = dict(weights or dict.fromkeys(PENALISED, 1.0))
    for _ in range(rounds):
        residual, design = _linearised(model, edges)
        noise, correlation, robust = _noise(residual, edges)
        information = (design.T @ diags(robust / (noise**2 * correlation)) @ design).toarray()
        pull = design.T @ (robust * residual) / (noise**2 * correlation)
        target = pull + information @ model.beta
        beta, covariance, weights = _penalised(model, information, target, differences, weights)
        model = model.moved(beta)
    freedom = _freedom(model, information, covariance)
    blur = 0.4 / float(np.median(edges.steepness))
    return Fit(model, covariance, weights, freedom, noise, correlation, blur)


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
    """Robust sd of a residual, its correlation length in points, Tukey weights."""
    noise = max(1.4826 * float(np.median(np.abs(residual))), 1e-3)
    z = np.clip(np.abs(residual) / (TUKEY * noise), 0, 1)
    robust = (1 - z**2) ** 2
    lengths = [
        _correlation(residual[edges.track == k], robust[edges.track == k] > 0.05)
        for k in range(4)
    ]
    return noise, float(np.mean(lengths)), robust


def _correlation(residual: Array, good: NDArray[np.bool_]) -> float:
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


def _penalty(model: Model, name: str, held: NDArray[np.bool_]) -> Array:
    """Differences D (m, size) of one block of unknowns, those not ``held`` left out."""
    size = model.layout.blocks[name].stop - model.layout.blocks[name].start
    return np.diff(np.eye(size), n=PENALISED[name], axis=0)[held]


def _penalised(
    model: Model,
    information: Array,
    target: Array,
    differences: dict[str, Array],
    weights: dict[str, float],
) -> tuple[Array, Array, dict[str, float]]:
    """Solve the penalised normal equations, re-estimating the weights: beta, covariance, weights.

    Fellner-Schall: w <- (rank - w tr(V S)) / (beta' S beta), Wood & Fasiolo, Biometrics 73 (2017).
    """
    blocks = model.layout.blocks
    diagonal = np.diag(information)
    # Unseen stretches have neither data nor penalty: hold them where they are.
    ridge = 1e-9 * diagonal + 1e-9 * np.median(diagonal)
    for _ in range(2):
        matrix = information + np.diag(ridge)
        for name, d in differences.items():
            matrix[blocks[name], blocks[name]] += weights[name] * d.T @ d
        factor = cho_factor(matrix)
        covariance = cho_solve(factor, np.eye(len(matrix)))
        beta = cho_solve(factor, target + ridge * model.beta)
        weights = {
            name: _weight(weights[name], d, beta[blocks[name]],
                          covariance[blocks[name], blocks[name]], diagonal[blocks[name]].max())
            for name, d in differences.items()
        }  # fmt: skip
    return beta, covariance, weights


def _weight(weight: float, d: Array, beta: Array, covariance: Array, data: float) -> float:
    """One Fellner-Schall update, kept below the stiffness that hides the data by EVEN."""
    if not len(d):
        return weight
    used = weight * float(np.einsum("ij,jk,ik->", d, covariance, d, optimize=True))
    free = max(len(d) - used, 1e-6 * len(d))
    rough = float(np.sum((d @ beta) ** 2))
    return min(free / max(rough, 1e-300), EVEN * data)


def _freedom(model: Model, information: Array, covariance: Array) -> dict[str, float]:
    share = np.einsum("ij,ji->i", covariance, information)
    return {name: float(share[where].sum()) for name, where in model.layout.blocks.items()}
