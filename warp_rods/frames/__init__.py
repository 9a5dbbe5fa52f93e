"""Frames, strains and curves in NumPy: the geometry of chapters 2 and 3 and appendices A and B of the dissertation.

Curves         arc_length, tangent, curvature, torsion, frenet_frame, bishop_frame, material_frame, parallel_transport
Strains        frenet_strain, bishop_strain, material_strain, turned_strain, turned, angle_between, frenet_of_frame,
               FrenetStrain
Closed curves  writhe, twist, twist_of_strain, link
Products       path_product (frames from strains or velocities), strain_of_frames
SO(3)          hat, vee, rotation_exp, rotation_log, left_jacobian, left_jacobian_inverse, quaternion, from_quaternion
Euler angles   euler_rotation, euler_angles, euler_jacobian
SE(3)          se3_exp, se3_log, se3_compose, se3_inverse, Ad, ad, Ad_star, ad_star, metric

All of them take arrays over any leading axes and return float64. Frames are (R, r) with the directors as the columns of
R, the tangent first; strains are measured in the frame, twist first; screws are (angular, linear). A wrong argument is
a ``SceneError`` that names it; what is undefined at a point (torsion of a straight piece, Euler angles at gimbal lock)
is NaN or a convention there, with a RuntimeWarning. ``help(wr.frames.torsion)`` explains a name.
"""

from warp_rods.frames.curves import arc_length as arc_length
from warp_rods.frames.curves import bishop_frame as bishop_frame
from warp_rods.frames.curves import curvature as curvature
from warp_rods.frames.curves import frenet_frame as frenet_frame
from warp_rods.frames.curves import material_frame as material_frame
from warp_rods.frames.curves import parallel_transport as parallel_transport
from warp_rods.frames.curves import tangent as tangent
from warp_rods.frames.curves import torsion as torsion
from warp_rods.frames.euler import euler_angles as euler_angles
from warp_rods.frames.euler import euler_jacobian as euler_jacobian
from warp_rods.frames.euler import euler_rotation as euler_rotation
from warp_rods.frames.gauss import link as link
from warp_rods.frames.gauss import twist as twist
from warp_rods.frames.gauss import twist_of_strain as twist_of_strain
from warp_rods.frames.gauss import writhe as writhe
from warp_rods.frames.motions import Ad as Ad
from warp_rods.frames.motions import Ad_star as Ad_star
from warp_rods.frames.motions import ad as ad
from warp_rods.frames.motions import ad_star as ad_star
from warp_rods.frames.motions import metric as metric
from warp_rods.frames.motions import se3_compose as se3_compose
from warp_rods.frames.motions import se3_exp as se3_exp
from warp_rods.frames.motions import se3_inverse as se3_inverse
from warp_rods.frames.motions import se3_log as se3_log
from warp_rods.frames.products import path_product as path_product
from warp_rods.frames.products import strain_of_frames as strain_of_frames
from warp_rods.frames.rotations import from_quaternion as from_quaternion
from warp_rods.frames.rotations import hat as hat
from warp_rods.frames.rotations import left_jacobian as left_jacobian
from warp_rods.frames.rotations import left_jacobian_inverse as left_jacobian_inverse
from warp_rods.frames.rotations import quaternion as quaternion
from warp_rods.frames.rotations import rotation_exp as rotation_exp
from warp_rods.frames.rotations import rotation_log as rotation_log
from warp_rods.frames.rotations import vee as vee
from warp_rods.frames.strains import FrenetStrain as FrenetStrain
from warp_rods.frames.strains import angle_between as angle_between
from warp_rods.frames.strains import bishop_strain as bishop_strain
from warp_rods.frames.strains import frenet_of_frame as frenet_of_frame
from warp_rods.frames.strains import frenet_strain as frenet_strain
from warp_rods.frames.strains import material_strain as material_strain
from warp_rods.frames.strains import turned as turned
from warp_rods.frames.strains import turned_strain as turned_strain
