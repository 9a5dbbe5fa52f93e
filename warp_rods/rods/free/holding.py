"""Where ends of free rods are held in space, as functions of time."""

from __future__ import annotations

import numpy as np

from warp_rods.frames.rotations import left_jacobian
from warp_rods.kernels.layout import to_host
from warp_rods.rods.free.arrays import Arrays
from warp_rods.rods.free.ends import End


class Holding:
    """Writes places and velocities of held ends, and dead loads, to the arrays ``Hold`` of an ensemble.

    position [rod, end, 3], rotation [rod, end, 3, 3]: the ends at t = 0, with their material frames.
    """

    def __init__(self, ends: tuple[End, End], arrays: Arrays, position: np.ndarray, rotation: np.ndarray):
        self._ends, self._hold = ends, arrays.hold
        self._position, self._rotation = position, rotation
        none = np.zeros_like(ends[0].thrust)
        along = [np.stack([end.thrust, end.torque, none], axis=1) for end in ends]
        self._hold.along.assign(np.stack(along, axis=1))
        self._hold.force.assign(np.stack([end.force for end in ends], axis=1))
        self._hold.couple.assign(np.stack([end.couple for end in ends], axis=1))

    def set_places(self, time: float) -> None:
        """Where the ends are held at a time."""
        places, frames = zip(*(self._at(i, time) for i in range(2)), strict=True)
        self._hold.position.assign(np.stack(places, axis=1))
        self._hold.rotation.assign(np.stack(frames, axis=1))

    def set_velocities(self, time: float) -> None:
        """The velocities of these places at a time."""
        velocities, turns = zip(*(self._rates(i, time) for i in range(2)), strict=True)
        self._hold.velocity.assign(np.stack(velocities, axis=1))
        self._hold.angular_velocity.assign(np.stack(turns, axis=1))

    def forget_drift(self) -> None:
        """Let the ends be where they are held."""
        self._hold.drift.zero_()
        self._hold.drift_angle.zero_()

    def apart(self, time: float) -> np.ndarray:
        """The distance between the places of the two ends at a time [rod]."""
        (first, _), (last, _) = (self._at(i, time) for i in range(2))
        return np.linalg.norm(last - first, axis=-1)

    def _at(self, index: int, time: float) -> tuple[np.ndarray, np.ndarray]:
        end = self._ends[index]
        place = self._position[:, index] + (0.0 if end.motion is None else end.motion(time))
        turned = _turns(np.stack([end.turning * time, 0 * end.turning, 0 * end.turning], axis=1))
        frame = self._rotation[:, index] @ turned
        if end.rotation is None:
            return place, frame
        at_start = np.swapaxes(_turns(end.rotation(0.0)), -1, -2)
        return place, _turns(end.rotation(time)) @ at_start @ frame

    def _rates(self, index: int, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Velocities and angular velocities in space [rod, 3]."""
        end = self._ends[index]
        _place, frame = self._at(index, time)
        velocity = np.zeros_like(self._position[:, index])
        if end.motion is not None:
            velocity += end.motion.rate(time)
        turn = end.turning[:, None] * frame[..., 0]
        if end.rotation is not None:
            turned = left_jacobian(end.rotation(time)) @ end.rotation.rate(time)[..., None]
            turn = turn + turned[..., 0]
        return velocity, turn


def _turns(vectors: np.ndarray) -> np.ndarray:
    """Rotation matrices of rotation vectors."""
    if not np.any(vectors):
        return np.broadcast_to(np.eye(3), (*np.shape(vectors)[:-1], 3, 3))
    from scipy.spatial.transform import Rotation  # slow to import

    return Rotation.from_rotvec(vectors).as_matrix()


def places_of_ends(arrays: Arrays, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions [rod, end, 3] and material frames [rod, end, 3, 3] of the ends, from frames that are laid out.

    angles [rod, end]: ϑ of the material in the Bishop frame.
    """
    position, bishop = to_host(arrays.position)[:, [0, -1]], to_host(arrays.rotation)[:, [0, -1]]
    turn = np.stack([angles, np.zeros_like(angles), np.zeros_like(angles)], axis=-1)
    return position, bishop @ _turns(turn)
