"""A script that opens the animation of a run in Blender: with colours, camera, world, and a film to render."""

from __future__ import annotations

from pathlib import Path

from warp_rods.draw.content import Content
from warp_rods.draw.usd.materials import MEMBRANE_OPACITY

__all__ = ["write_script"]

_SCRIPT = '''"""Opens {animation} in Blender (5.0 was tried):

    blender --python {name}

With a picture or a film to render, and no window: blender --background --python {name} -- --frame 10 --out still.png
                                                   blender --background --python {name} -- --out film.mp4
"""

import argparse
import sys
from pathlib import Path

import bpy

try:
    from pxr import Usd  # comes with Blender, not with its module for Python
except ImportError:
    Usd = None

HERE, ANIMATION = Path(__file__).resolve().parent, "{animation}"
MEMBRANE = {opacity:g}


def timing(scene):
    """First and last frame, and frames a second, as the animation has them now; else those of the import, and 24."""
    if Usd is None:
        return
    stage = Usd.Stage.Open(str(HERE / ANIMATION), Usd.Stage.LoadNone)
    scene.frame_start, scene.frame_end = round(stage.GetStartTimeCode()), round(stage.GetEndTimeCode())
    scene.render.fps = max(round(stage.GetTimeCodesPerSecond()), 1)


def material(name, opacity=1.0):
    """Shows the colours that the file gives to each node, or each point of a membrane."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    surface = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    colour = nodes.new("ShaderNodeAttribute")
    colour.attribute_name = "displayColor"
    links.new(colour.outputs["Color"], surface.inputs["Base Color"])
    surface.inputs["Alpha"].default_value = opacity
    surface.inputs["Roughness"].default_value = 0.6
    surface.inputs["Specular IOR Level"].default_value = 0.2  # a white world would wash out the colours
    return made


def opened():
    """The objects of the animation, with their materials."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    options = {{"import_guide": False, "apply_unit_conversion_scale": False}}
    known = bpy.ops.wm.usd_import.get_rna_type().properties.keys()  # Blender 4.2 leaves units alone
    bpy.ops.wm.usd_import(filepath=str(HERE / ANIMATION), **{{key: options[key] for key in options if key in known}})
    colours, translucent = material("Colours of the rods"), material("Colours of the membrane", MEMBRANE)
    for thing in bpy.data.objects:
        if thing.type in ("CURVES", "MESH") and "displayColor" in thing.data.attributes:
            thing.data.materials.clear()
            thing.data.materials.append(translucent if thing.name.startswith("Membrane") else colours)
        if thing.type == "CAMERA":
            bpy.context.scene.camera = thing
        if thing.type == "LIGHT":
            thing.data.energy *= 0.5  # the world gives the rest


def world(scene):
    """Even light all round, and nothing behind: pictures are transparent, films white."""
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    light = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    light.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    light.inputs["Strength"].default_value = 0.4


def film(scene):
    """Size, frames and colours."""
    timing(scene)
    scene.render.resolution_x, scene.render.resolution_y = 1280, 720
    scene.render.film_transparent = True
    scene.view_settings.view_transform = "Standard"
    scene.render.engine = "CYCLES"  # needs no display
    scene.cycles.samples, scene.cycles.use_denoising = 16, False


def render(scene, out, frame):
    scene.render.filepath = str(Path(out).resolve())
    if frame is not None:
        scene.frame_set(frame)
        bpy.ops.render.render(write_still=True)
        return
    scene.render.film_transparent = False
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):  # Blender 5
        settings.media_type = "VIDEO"
    settings.file_format = "FFMPEG"
    scene.render.ffmpeg.format, scene.render.ffmpeg.codec = "MPEG4", "H264"
    bpy.ops.render.render(animation=True)


def main():
    given = argparse.ArgumentParser(prog="{name}")
    given.add_argument("--out", help="a picture of one frame (.png), or a film of all (.mp4)")
    given.add_argument("--frame", type=int, help="the frame of the picture, counted from 0")
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    given = given.parse_args(words)
    opened()
    scene = bpy.context.scene
    world(scene)
    film(scene)
    scene.frame_set(0 if given.frame is None else given.frame)
    if given.out:
        render(scene, given.out, given.frame)


main()
'''


def write_script(shown: Content, path: Path) -> None:
    """Write the script; the animation itself, ``animation.usdc``, is to be beside it, whatever it shows of the run."""
    text = _SCRIPT.format(animation="animation.usdc", name="blender.py", opacity=MEMBRANE_OPACITY)
    path.write_text(text, encoding="utf-8")
