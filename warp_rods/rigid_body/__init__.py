"""The rigid body, a Cosserat medium of dimension zero (dissertation, §3.2), with a variational step on SE(3)."""

from warp_rods.rigid_body.body import RigidBody as RigidBody
