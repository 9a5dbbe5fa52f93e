"""Pictures of rods and membranes in parallel projection: what each pixel sees, and how it is lit.

Places are in pixels: x to the right, y downwards, z towards the viewer. A rod is a chain of capsules, which the ray of
a pixel meets exactly. Of a translucent surface the nearest layer that faces the viewer and the nearest that faces away
are kept. Kernels of shapes run on the CPU, over one shape after the other, so that no two write at once.
"""

import warp as wp

wp.set_module_options({"enable_backward": False})

FAR = wp.constant(wp.float32(-1.0e30))
"""Depth where there is nothing."""
LIGHT = wp.constant(wp.vec3(-0.39, -0.55, 0.74))
"""Direction of the light: from the upper left, behind the viewer."""


@wp.struct
class Layer:
    """The nearest surface at each pixel [row, column]: depth, unit normal, colour (sRGB)."""

    depth: wp.array2d(dtype=wp.float32)
    normal: wp.array2d(dtype=wp.vec3)
    colour: wp.array2d(dtype=wp.vec3)


@wp.struct
class Capsules:
    """Segments of rods: ends, their colours, and radius."""

    start: wp.array(dtype=wp.vec3)
    end: wp.array(dtype=wp.vec3)
    start_colour: wp.array(dtype=wp.vec3)
    end_colour: wp.array(dtype=wp.vec3)
    radius: wp.array(dtype=wp.float32)


@wp.struct
class Sheet:
    """A triangulated surface: points with outward normals and colours."""

    points: wp.array(dtype=wp.vec3)
    normals: wp.array(dtype=wp.vec3)
    colours: wp.array(dtype=wp.vec3)
    triangles: wp.array2d(dtype=wp.int32)


@wp.func
def capsule_met(x: float, y: float, start: wp.vec3, axis: wp.vec3, radius: float):
    """Height of the capsule above its start on the ray at (x, y) from it, and the place along the axis; FAR for none.

    The ray meets the cylinder where |p − s axis| = radius with s = p·axis/|axis|²; beyond its ends, a sphere.
    """
    length2 = wp.dot(axis, axis)
    flat2 = axis[0] * axis[0] + axis[1] * axis[1]
    along = x * axis[0] + y * axis[1]
    s = 0.0
    if flat2 > 1.0e-6 * length2:
        half = along * axis[2]
        rest = length2 * (x * x + y * y - radius * radius) - along * along
        root = half * half - flat2 * rest
        if root < 0.0:
            return FAR, s
        height = (half + wp.sqrt(root)) / flat2
        s = (along + height * axis[2]) / length2
        if s >= 0.0 and s <= 1.0:
            return height, s
    elif axis[2] > 0.0:
        s = 1.0
    s = wp.clamp(wp.ceil(s), 0.0, 1.0)  # the sphere of the nearer end
    u, v = x - s * axis[0], y - s * axis[1]
    inside = radius * radius - u * u - v * v
    if inside < 0.0:
        return FAR, s
    return s * axis[2] + wp.sqrt(inside), s


@wp.func
def first_pixel(least: float):
    return wp.max(int(wp.ceil(least - 0.5)), 0)


@wp.func
def last_pixel(largest: float, count: int):
    return wp.min(int(wp.floor(largest - 0.5)), count - 1)


@wp.kernel
def draw_capsules(rods: Capsules, seen: Layer):
    one = wp.tid()
    a, b, r = rods.start[one], rods.end[one], rods.radius[one]
    for row in range(first_pixel(wp.min(a[1], b[1]) - r), last_pixel(wp.max(a[1], b[1]) + r, seen.depth.shape[0]) + 1):
        left, right = wp.min(a[0], b[0]) - r, wp.max(a[0], b[0]) + r
        for column in range(first_pixel(left), last_pixel(right, seen.depth.shape[1]) + 1):
            x, y = float(column) + 0.5 - a[0], float(row) + 0.5 - a[1]
            height, s = capsule_met(x, y, a, b - a, r)
            if height > FAR and a[2] + height > seen.depth[row, column]:
                seen.depth[row, column] = a[2] + height
                seen.normal[row, column] = (wp.vec3(x, y, height) - s * (b - a)) / r
                seen.colour[row, column] = (1.0 - s) * rods.start_colour[one] + s * rods.end_colour[one]


@wp.func
def across(a: wp.vec3, b: wp.vec3, x: float, y: float):
    """Twice the signed area of the triangle a, b, (x, y)."""
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])


@wp.func
def keep_nearest(layer: Layer, row: int, column: int, depth: float, normal: wp.vec3, colour: wp.vec3):
    if depth > layer.depth[row, column]:
        layer.depth[row, column] = depth
        layer.normal[row, column] = normal
        layer.colour[row, column] = colour


@wp.kernel
def draw_sheet(sheet: Sheet, front: Layer, back: Layer):
    one = wp.tid()
    i, j, k = sheet.triangles[one, 0], sheet.triangles[one, 1], sheet.triangles[one, 2]
    a, b, c = sheet.points[i], sheet.points[j], sheet.points[k]
    area = across(a, b, c[0], c[1])
    if area == 0.0:
        return
    low, high = wp.min(wp.min(a, b), c), wp.max(wp.max(a, b), c)
    for row in range(first_pixel(low[1]), last_pixel(high[1], front.depth.shape[0]) + 1):
        for column in range(first_pixel(low[0]), last_pixel(high[0], front.depth.shape[1]) + 1):
            x, y = float(column) + 0.5, float(row) + 0.5
            u, v = across(b, c, x, y) / area, across(c, a, x, y) / area
            w = 1.0 - u - v
            if u >= -1.0e-4 and v >= -1.0e-4 and w >= -1.0e-4:
                normal = wp.normalize(u * sheet.normals[i] + v * sheet.normals[j] + w * sheet.normals[k])
                colour = u * sheet.colours[i] + v * sheet.colours[j] + w * sheet.colours[k]
                depth = u * a[2] + v * b[2] + w * c[2]
                if normal[2] > 0.0:
                    keep_nearest(front, row, column, depth, normal, colour)
                else:
                    keep_nearest(back, row, column, depth, -normal, colour)


@wp.func
def lit(colour: wp.vec3, normal: wp.vec3, gloss: float):
    """Colour of a surface with ambient, diffuse and specular light."""
    middle = wp.normalize(LIGHT + wp.vec3(0.0, 0.0, 1.0))
    diffuse = 0.5 + 0.5 * wp.max(wp.dot(normal, LIGHT), 0.0)
    rim = 0.72 + 0.28 * wp.max(normal[2], 0.0)
    shine = gloss * wp.pow(wp.max(wp.dot(normal, middle), 0.0), 40.0)
    return diffuse * rim * 1.12 * colour + wp.vec3(shine, shine, shine)


@wp.func
def is_below_an_edge(seen: Layer, row: int, column: int, reach: int, step: float):
    """Whether a rod passes in front of another here: a pixel near by is nearer to the viewer by more than ``step``."""
    found = False
    for side in range(4):
        r, c = row, column
        if side == 0:
            r = wp.max(row - reach, 0)
        if side == 1:
            r = wp.min(row + reach, seen.depth.shape[0] - 1)
        if side == 2:
            c = wp.max(column - reach, 0)
        if side == 3:
            c = wp.min(column + reach, seen.depth.shape[1] - 1)
        found = found or seen.depth[r, c] > seen.depth[row, column] + step
    return found


@wp.func
def covered(under: wp.vec3, layer: Layer, row: int, column: int, behind: float, opacity: float):
    """A colour seen through a translucent layer, where this is in front of ``behind``; denser where it is oblique."""
    if layer.depth[row, column] <= behind:
        return under
    normal = layer.normal[row, column]
    oblique = 1.0 - normal[2]
    share = opacity + (1.0 - opacity) * 0.6 * oblique * oblique * oblique
    return (1.0 - share) * under + share * lit(layer.colour[row, column], normal, 0.25)


@wp.kernel
def compose(
    rods: Layer, front: Layer, back: Layer, opacity: float, reach: int, step: float, picture: wp.array2d(dtype=wp.vec3)
):
    row, column = wp.tid()
    colour, depth = wp.vec3(1.0, 1.0, 1.0), rods.depth[row, column]
    if depth > FAR:
        colour = lit(rods.colour[row, column], rods.normal[row, column], 0.3)
        if is_below_an_edge(rods, row, column, reach, step):
            colour = 0.55 * colour
    colour = covered(colour, back, row, column, depth, opacity)
    picture[row, column] = covered(colour, front, row, column, depth, opacity)
