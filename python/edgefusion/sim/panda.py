# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Panda3D's software renderer: no display, no GPU. One pipe to it, and what turns our meshes into its nodes."""

from __future__ import annotations

from typing import Any, Hashable, Sequence

import cv2
import numpy as np
import numpy.typing as npt

from edgefusion.errors import RefusedError
from edgefusion.sim.mesh import Part, Texture

# Panda3D builds its types at run time, so that there is nothing to check calls against.
Node = Any
Pipe = Any

TEXTURE_MAX_PX = 512
"""A side of a texture; the software renderer takes powers of two only."""

# Silent about the display that it looks for and does not need.
PRC = """
textures-power-2 down
load-display p3tinydisplay
aux-display
notify-level error
notify-level-x11display fatal
sync-video false
audio-library-name null
"""

NO_X11 = (
    "the camera's renderer needs libX11.so.6, which is not on this machine: apt-get install libx11-6 "
    "(the simulated laser and the base run without it)"
)
NO_PANDA3D = "the camera's renderer needs Panda3D: pip install 'edgefusion[sim]'"


def open_pipe() -> Pipe:
    """The pipe to the software renderer. Raises RefusedError, one line that says what is missing."""
    try:
        from panda3d import core
    except ImportError as error:
        raise RefusedError(NO_PANDA3D) from error
    core.load_prc_file_data("", PRC)
    selection = core.GraphicsPipeSelection.get_global_ptr()
    selection.make_module_pipe("p3tinydisplay")
    for kind in selection.get_pipe_types():
        if kind.get_name() == "TinyOffscreenGraphicsPipe":
            return selection.make_pipe(kind)
    raise RefusedError(NO_X11)


def collect_garbage() -> None:
    """Lets go of what no scene needs any more: Panda3D keeps states, and with them textures, until it is asked."""
    from panda3d import core

    core.RenderState.garbage_collect()
    core.TransformState.garbage_collect()


def part_node(part: Part) -> Node:
    """A node with the surface's triangles and its texture."""
    from panda3d import core

    data = core.GeomVertexData("part", core.GeomVertexFormat.get_v3n3t2(), core.Geom.UH_static)
    data.unclean_set_num_rows(len(part.vertices))
    uv = part.uv * (1, -1) + (0, 1)  # Panda3D's v runs upwards
    rows = np.ascontiguousarray(np.hstack([part.vertices, part.normals, uv]), np.float32)
    memoryview(data.modify_array(0)).cast("B")[:] = rows.tobytes()
    triangles = core.GeomTriangles(core.Geom.UH_static)
    triangles.set_index_type(core.Geom.NT_uint32)
    indices = triangles.modify_vertices()
    indices.unclean_set_num_rows(part.triangles.size)
    memoryview(indices).cast("B")[:] = part.triangles.astype(np.uint32).tobytes()
    geom = core.Geom(data)
    geom.add_primitive(triangles)
    node = core.GeomNode("part")
    node.add_geom(geom)
    return node


def texture_of(image: Texture, alpha: npt.NDArray[np.uint8] | None = None) -> Any:
    """A texture of a BGR image [height, width, 3], and of its opacity [height, width] where one is given."""
    from panda3d import core

    size = tuple(min(TEXTURE_MAX_PX, _power_of_two(side)) for side in (image.shape[1], image.shape[0]))
    resized = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA))
    form = core.Texture.F_rgb
    if alpha is not None:
        opacity = np.asarray(cv2.resize(alpha, size, interpolation=cv2.INTER_AREA))
        resized, form = np.dstack([resized, opacity]), core.Texture.F_rgba
    texture = core.Texture()
    texture.setup_2d_texture(size[0], size[1], core.Texture.T_unsigned_byte, form)
    texture.set_ram_image(np.ascontiguousarray(resized[::-1]).tobytes())
    texture.set_minfilter(core.SamplerState.FT_linear_mipmap_linear)
    texture.set_magfilter(core.SamplerState.FT_linear)
    return texture


def _power_of_two(side: int) -> int:
    """The nearest power of two, by ratio."""
    return 1 << max(0, round(float(np.log2(side))))


def model_of(parts: Sequence[Part], name: str) -> Node:
    """A node path with all parts; those that share a texture share it in memory, too."""
    from panda3d import core

    root = core.NodePath(name)
    textures: dict[Hashable, Any] = {}
    for order, part in enumerate(parts):
        path = root.attach_new_node(part_node(part))
        # Else surfaces are drawn in the order of their addresses, and where two are as far away the last one wins.
        path.set_bin("background", order)
        key = _memory_of(part.texture)
        if key not in textures:
            textures[key] = texture_of(part.texture)
        path.set_texture(textures[key])
    return root


def _memory_of(texture: Texture) -> Hashable:
    """Where its pixels are: two views of the same pixels have the same, two slices of one sheet do not."""
    return texture.__array_interface__["data"], texture.shape, texture.strides
