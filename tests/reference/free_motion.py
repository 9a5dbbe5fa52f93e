"""Equal steps of free rods in space under forces and contact in NumPy and SciPy (docs/model.md §2.4, §2.6)."""

import numpy as np
from scipy.linalg import expm, logm

from reference import free as twin
from reference.contact_drag import ContactFormula
from reference.lie import frame_matrix, integrate_frames, twist_matrix


def screw(S):
    """(θ, µ) of a frame matrix."""
    A = np.real(logm(S))
    return np.array([A[2, 1], A[0, 2], A[1, 0]]), A[:3, 3]


def exponential(theta, mu):
    return expm(twist_matrix(theta, mu))


class Moving:
    """Rods with their middle frames, from the levels of a shape; all steps but the first are of second order."""

    def __init__(self, shape, R, r, p, h):
        self.p, self.h = p, h
        self.shapes, self.times = [shape], [0.0]
        self.frames = [[frame_matrix(R[rod], r[rod]) for rod in range(len(R))]]
        self.drift = np.zeros(middle_of(shape)), np.zeros(shape.bending.shape, complex)
        self.lag = self.drift

    def foretold(self, t):
        """Directors and places of all nodes at the extrapolated state."""
        values, _ = twin.lagrange(self.times[:2], t)
        shape = twin.combined(values, self.shapes[:2])
        frames = self.frames[0]
        if len(self.frames) > 1:
            frames = []
            for before, now in zip(self.frames[1], self.frames[0], strict=True):
                theta, mu = screw(np.linalg.inv(before) @ now)
                frames.append(now @ exponential(-values[1] * theta, -values[1] * mu))
        return self.laid_out(shape, np.array(frames))

    def laid_out(self, shape, frames):
        """Directors and places [rod, node, …] from the middle frames."""
        rods, nodes = shape.bending.shape
        strain = np.stack([0 * shape.twist, shape.bending.real, shape.bending.imag], axis=-1)
        R, r = np.zeros((rods, nodes, 3, 3)), np.zeros((rods, nodes, 3))
        R[:, nodes // 2], r[:, nodes // 2] = frames[:, :3, :3], frames[:, :3, 3]
        return integrate_frames(strain, np.full(rods, self.h), nodes // 2, R, r)

    def load(self, R, force, stiffness, t):
        """The external force and contact as drag, with blocks that are not less than K, in the Bishop frame."""
        load, formula = twin.load_of(np.einsum("rnij,rni->rnj", R, force)), ContactFormula(self.times, t)
        K = np.swapaxes(R, 2, 3) @ stiffness @ R
        coupling = K[..., 0, 1:]
        size = np.linalg.norm(coupling, axis=-1)
        K_along = K[..., 0, 0] + size
        K_across = (
            K[..., 1:, 1:] + coupling[..., :, None] * coupling[..., None, :] / np.maximum(size, 1e-300)[..., None, None]
        )
        ratio = self.p.drag_ratio
        share = formula.share(np.maximum(2 * K_along, 2 * np.linalg.eigvalsh(K_across)[..., -1] / ratio), 1.0)
        load.transverse_drag = formula.drag_of_matrix(K_across, ratio, share)
        load.axial_drag = twin.middle(formula.drag(2 * K_along, 1.0, share))
        beyond = formula.rate * formula.ratio
        along = self.drift[0] + beyond * twin.middle(share) * self.lag[0]
        across = self.drift[1] + beyond * share * self.lag[1]
        pair = np.einsum("rnij,rnj->rni", load.transverse_drag, np.stack([across.real, across.imag], axis=-1))
        load.axial = load.axial + load.axial_drag * along
        load.transverse = load.transverse + pair[..., 0] + 1j * pair[..., 1]
        return load

    def step(self, t, force, stiffness):
        """A step to t; ``force`` and ``stiffness`` are functions of the places [rod, node, 3]."""
        levels = self.times[:2]
        _, slopes = twin.lagrange([t, *levels], t)
        rate = slopes[0]
        R, r = self.foretold(t)
        load = self.load(R, force(r), stiffness(r), t)
        shape, axial, transverse = twin.step(self.shapes[:2], levels, t, self.p, self.h, load)
        self.lag = (axial - self.drift[0]) / rate, (transverse - self.drift[1]) / rate
        self.drift = tuple(v + lag / (t - self.times[0]) for v, lag in zip(self.drift, self.lag, strict=True))
        frames = [self.moved(rod, rate, slopes, axial, transverse, shape) for rod in range(len(axial))]
        self.frames.insert(0, frames)
        self.shapes.insert(0, shape)
        self.times.insert(0, t)

    def moved(self, rod, rate, slopes, axial, transverse, shape):
        """The middle frame after the backward formula for the screw from its present place; one step ago it was −ξ."""
        n = shape.bending.shape[1] // 2
        spin = twin.middle(twin.spin_of(transverse, axial, shape.bending, self.h))[rod, n - 1]
        omega = np.array([0.0, spin.real, spin.imag])
        u = np.array([twin.middle(axial)[rod, n - 1], transverse[rod, n].real, transverse[rod, n].imag])
        theta, mu = omega / rate, u / rate
        if len(self.times) > 1:
            last_theta, last_mu = screw(np.linalg.inv(self.frames[1][rod]) @ self.frames[0][rod])
            weight = slopes[2] / rate
            theta, mu = theta + weight * last_theta, mu + weight * last_mu
        return self.frames[0][rod] @ exponential(theta, mu)


def middle_of(shape):
    """The shape of an array at half nodes."""
    rods, nodes = shape.bending.shape
    return rods, nodes - 1
